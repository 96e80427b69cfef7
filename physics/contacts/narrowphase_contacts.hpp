#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "touchstone/contact_core/broadphase/broadphase.hpp"
#include "touchstone/contact_core/geometry/hexahedron_tree.hpp"
#include "touchstone/contact_core/narrowphase/narrowphase.hpp"
#include "touchstone/physics/contacts/surface.hpp"
#include "touchstone/physics/world/dynamics_world.hpp"

namespace touchstone::physics {

/// The source of one contact of find().
struct ContactOrigin {
  SolidPair solids;   ///< indices as counted through add()
  PairStatus status;  ///< of the pair
  double separation;  ///< of the point [m]
};

/// The contact points of a dynamics world's movers, from any broadphase and any narrowphase that has
/// manifolds. Set-up throws InputError; find() neither throws nor, as long as no more contacts and pairs come
/// up than reserved for, allocates. One thread at a time.
class NarrowphaseContacts {
 public:
  /// @param margin points up to this far apart are found, so that they can be met within a step [m], > 0.
  NarrowphaseContacts(std::unique_ptr<Broadphase> broadphase, std::unique_ptr<Narrowphase> narrowphase,
                      double margin);

  /// The solids of an object O that moves with a mover M (a body or link, or the ground); keeps a reference
  /// to the tree. Returns the part's number. @param is_static false for parts on the ground that will leave
  /// it.
  /// @throws InputError: a bad surface.
  std::uint32_t add(const Mover& mover, const HexahedronTree& tree, const Surface& surface,
                    const Pose& X_MO = {}, bool is_static = true);
  /// Sets the rules by which surfaces' figures become a contact's, for later calls of find(); numbers are
  /// those of parts.
  void set_surfaces(const SurfacePairs& pairs);
  /// Exempts all solids of two movers from each other, for example links that a joint joins.
  void exempt(const Mover& a, const Mover& b);
  /// The same for two parts, where a mover has several.
  void exempt_parts(std::uint32_t a, std::uint32_t b);
  /// The same for two solids, as counted through add().
  void exempt_solids(SolidIndex a, SolidIndex b);
  /// Memory for this many pairs of exempt_solids().
  void reserve_exempt_solids(std::size_t pairs) { exempt_solids_.reserve(pairs); }
  /// find() omits no contacts along edges and at corners, for later calls: where they are judged, or where
  /// something other than these contacts keeps solids apart.
  void keep_edges();
  /// Takes up what was added. @throws InputError: nothing added, no manifolds, what the backends refuse.
  void build();
  /// Reserves memory for this many contacts at a time and pairs of solids; build() reserves some.
  void reserve(std::size_t contacts, std::size_t pairs);

  /// After build(): gives a part another mover, as when it is latched or released. Does not allocate.
  void move_to(std::uint32_t part, const Mover& mover, const Pose& X_MO);
  /// After build(): a part that is held out touches nothing until it is taken back, as a body that
  /// DynamicsWorld::hold_out() took out. Does not allocate. Parts that come later are added, and build() is
  /// called again: solids keep their numbers, and contacts their keys.
  void hold_out(std::uint32_t part, bool is_out = true);
  /// After build(): `exempt` calls exempt_parts() and exempt_solids() on these contacts, for what is exempt
  /// from now on in place of all that they were given before. Allocates only when more come than ever before.
  template <class Exempt>
  void exempt_anew(const Exempt& exempt) {
    exempt_parts_.clear();
    exempt_solids_.clear();
    exempt(*this);
    sort_exempt();
  }

  /// After build(): what the narrowphase answers has changed otherwise than by poses; the next find() keeps
  /// nothing that was found.
  void look_anew() { was_found_ = false; }

  /// Points within the margin where `world` stands now, pair by pair. Friction is the geometric mean of the
  /// two surfaces', restitution the larger, unless set_surfaces() gave others. Pairs closer than their
  /// narrowphase's resolution (`undecided`) count as those that overlap. Pairs of which neither solid's pose
  /// changed a bit since the last find() keep what was found, where the narrowphase is deterministic; but
  /// pairs that pass or close at an edge, which is for velocities to say.
  ///
  /// @param h the step that is to follow [s]. Pairs of which a solid moves by more than half the margin in it
  /// (its velocity now, and what gravity adds) are followed along their paths, as if nothing acted on them:
  /// where they first come within the margin, their points there are taken back to where the movers are now,
  /// so that the step meets them in time. Such points lie further apart than the margin, and not along the
  /// normal. 0: where the world stands, no more. Omits contacts between sleeping bodies unless an awake body
  /// touches their group; then lists all of the group's. While the whole world is asleep, no pair is
  /// evaluated. Omits contacts along an edge or at a corner of both solids alone, where they are free along a
  /// face at right angles to the normal, or along two at right angles to each other, overlap there by no more
  /// than a millionth of the smaller one's size, and do not close across it in the step by their velocities
  /// as it begins; keep_edges().
  std::span<const Contact> find(const DynamicsWorld& world, double h = 0.0);
  /// The sources of the last find()'s contacts, one each.
  std::span<const ContactOrigin> origins() const { return shown_origins_; }
  /// Pairs of the last find() whose status was `undecided`; `failed` or `unsupported`: their contacts are
  /// missing.
  std::uint32_t undecided() const { return undecided_; }
  std::uint32_t failed() const { return failed_; }
  /// Parts of the last find() that move by more than half the margin, where the broadphase takes no paths:
  /// what they meet in the step may be met late, or not at all.
  std::uint32_t unfollowed() const { return unfollowed_; }

 private:
  struct Part {
    Mover mover;
    const HexahedronTree* tree;
    Surface surface;
    std::size_t first_solid;
    Pose X_MO;
    bool is_static;
    Pose X_WM = {};  // of the mover, at the last find()
    bool has_moved = true, is_fast = false, is_out = false;
    double travel = 0.0;  // no point of it moves further in the step [m]
    // The mover's motion in it: of a point, and about that.
    Vector3 p_W = Vector3::Zero(), v_W = Vector3::Zero(), w_W = Vector3::Zero();
  };
  /// A pair that came up, and its contacts: a run of those of its find().
  struct Found {
    SolidPair pair;
    PairStatus status;
    std::size_t first, count;
  };
  /// A pair of a block, to be evaluated or with the contacts that the last find() left.
  struct Candidate {
    SolidPair pair;
    const Found* kept;
  };

  /// Of both solids of a pair: those that are free where they stand, and of these the ones that stay free.
  struct FreeFaces {
    /// Its outward normal, and whether it stays free in the step.
    struct Face {
      Vector3 normal_W;
      bool stays;
    };
    std::array<Face, 12> faces;
    std::size_t count = 0;
  };
  /// How a pair touches: otherwise than along an edge or at a corner alone, or there, where it passes or
  /// closes.
  enum class CornerTouch : std::uint8_t { none, passes, closes };

  /// Where solids are: the poses that they reach after t [s] of the step.
  struct Placed {
    std::span<const Pose> poses;
    double t;
  };

  bool is_exempt(const SolidPair& pair) const;
  bool is_covered(SolidIndex solid, SolidIndex other, const Vector3& p_W, const Vector3& n_W) const;
  const Part& part_of(SolidIndex solid) const { return parts_[part_of_[solid]]; }
  const Hexahedron& solid_of(SolidIndex solid) const {
    const Part& part = part_of(solid);
    return part.tree->solids()[solid - part.first_solid].solid;
  }
  double radius_of(SolidIndex solid) const { return solid_of(solid).radius(); }
  bool move_parts(const DynamicsWorld& world);
  bool find_path_lengths(const DynamicsWorld& world, double h);
  double find_motion(const DynamicsWorld& world, double h, Part& part);
  void place_in_broadphase(bool any_fast);
  void meet_on_path(const SolidPair& pair, const PairGeometry& now);
  void place_on_path(const SolidPair& pair, double t);
  double clear_time(const SolidPair& pair, const PairGeometry& geometry, double t) const;
  void take_met(const SolidPair& pair, PairStatus status, PairGeometry& geometry,
                std::span<ContactPoint> points, double t);
  double closing_speed(const SolidPair& pair, const Vector3& n_AB_W, const Vector3& a_W,
                       const Vector3& b_W) const;
  void sort_exempt();
  void sort_out(std::size_t count, std::size_t& last);
  void take_block();
  bool take(const SolidPair& pair, PairStatus status, const PairGeometry& geometry,
            std::span<const ContactPoint> points, const Placed& placed);
  CornerTouch corner_touch(const SolidPair& pair, const Vector3& n_AB_W, std::span<const ContactPoint> points,
                           const Placed& placed) const;
  void find_free(SolidIndex solid, SolidIndex other, const Placed& placed, FreeFaces& free) const;
  Vector3 velocity_at(SolidIndex solid, const Vector3& p_W, double t) const;
  void count(PairStatus status);
  std::span<const Contact> show(const DynamicsWorld& world);
  void take_awake(const DynamicsWorld& world);

  std::unique_ptr<Broadphase> broadphase_;
  std::unique_ptr<Narrowphase> narrowphase_;
  std::unique_ptr<Narrowphase::Workspace> workspace_;
  double margin_;
  SurfacePairs surfaces_;
  std::vector<Part> parts_;
  std::vector<std::uint32_t> part_of_;  // by solid
  std::vector<std::pair<Mover, Mover>> exempt_;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> exempt_parts_;  // a < b; ascending once built
  std::vector<SolidPair> exempt_solids_;                               // the same
  std::vector<Pose> poses_;
  bool keeps_edges_ = false;
  bool was_found_ = false;            // since build()
  bool is_warm_ = false;              // the broadphase has seen poses and paths
  double step_ = 0.0, fall_ = 0.0;    // of this find(); the travel that gravity may add in it
  double reach_ = 0.0;                // of its queries, pairs and points
  std::vector<double> path_lengths_;  // by solid, of its bounding sphere's centre
  std::vector<Pose> trial_poses_;     // of a pair in motion
  std::uint32_t unfollowed_ = 0;
  std::vector<std::uint32_t> moved_;  // parts
  std::vector<SolidPair> block_;
  std::vector<Candidate> candidates_;
  std::vector<SolidPair> evaluated_;
  std::vector<PairStatus> status_;
  std::vector<PairGeometry> geometry_;
  std::vector<ContactPoint> points_;
  std::vector<Contact> contacts_, last_contacts_;
  std::vector<ContactOrigin> origins_, last_origins_;
  // Without those of sleepers.
  std::vector<Contact> awake_contacts_;
  std::vector<ContactOrigin> awake_origins_;
  std::vector<std::uint8_t> is_touched_;  // by the first of those that sleep together
  std::span<const ContactOrigin> shown_origins_;
  std::vector<Found> found_, last_found_;
  std::size_t by_velocities_ = 0;  // pairs of the last find() that are looked at anew though nothing moved
  std::uint32_t undecided_ = 0, failed_ = 0;
};

}  // namespace touchstone::physics
