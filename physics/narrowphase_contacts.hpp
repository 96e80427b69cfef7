#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "contact_core/broadphase/broadphase.hpp"
#include "contact_core/geometry/hexahedron_tree.hpp"
#include "contact_core/narrowphase/narrowphase.hpp"
#include "physics/dynamics_world.hpp"

namespace touchstone::physics {

/// How much two movers' surfaces rub and bounce.
struct Surface {
  double friction = 0.5;
  double restitution = 0.0;
};

/// Where one contact of find() comes from.
struct ContactOrigin {
  SolidPair solids;   ///< indices as counted through add()
  PairStatus status;  ///< of the pair
  double separation;  ///< of the point [m]
};

/// The contact points of a dynamics world's movers, from any broadphase and any narrowphase that has
/// manifolds. Set-up throws InputError; find() neither throws nor, once warm, allocates. One thread at a
/// time.
class NarrowphaseContacts {
 public:
  /// @param margin points up to this far apart are found, so that they can be met within a step [m], > 0.
  NarrowphaseContacts(std::unique_ptr<Broadphase> broadphase, std::unique_ptr<Narrowphase> narrowphase,
                      double margin);

  /// The solids of a mover, in its frame (a body's or link's); keeps a reference. Returns the part's number.
  /// @throws InputError: a bad surface.
  std::uint32_t add(const Mover& mover, const HexahedronTree& tree, const Surface& surface);
  /// Two movers whose solids are not checked (links that a joint joins, say).
  void exempt(const Mover& a, const Mover& b);
  /// The same for two parts, where a mover has several.
  void exempt_parts(std::uint32_t a, std::uint32_t b);
  /// Takes up what was added. @throws InputError: nothing added, no manifolds, what the backends refuse.
  void build();

  /// Points within the margin where `world` stands now, pair by pair. Friction is the geometric mean of the
  /// two surfaces', restitution the larger. Pairs closer than their narrowphase's resolution (`undecided`)
  /// count as those that overlap. Pairs of which neither solid's pose changed a bit since the last find()
  /// keep what was found, where the narrowphase is deterministic.
  std::span<const Contact> find(const DynamicsWorld& world);
  /// One for each contact of the last find().
  std::span<const ContactOrigin> origins() const { return origins_; }
  /// Pairs of the last find() whose status was `undecided`; `failed` or `unsupported`: their contacts are
  /// missing.
  std::uint32_t undecided() const { return undecided_; }
  std::uint32_t failed() const { return failed_; }

 private:
  struct Part {
    Mover mover;
    const HexahedronTree* tree;
    Surface surface;
    std::size_t first_solid;
    Pose X_WM = {};  // of the mover, at the last find()
    bool has_moved = true;
  };
  /// A pair that came up, and its contacts: a run of those of its find().
  struct Found {
    SolidPair pair;
    PairStatus status;
    std::size_t first, count;
  };
  /// A pair of the block on its way: evaluated, or as the last find() left it.
  struct Candidate {
    SolidPair pair;
    const Found* kept;
  };

  bool is_exempt(std::uint32_t part_a, std::uint32_t part_b) const;
  bool is_covered(SolidIndex solid, const Vector3& p_W, const Vector3& n_W) const;
  const Part& part_of(SolidIndex solid) const { return parts_[part_of_[solid]]; }
  bool move_parts(const DynamicsWorld& world);
  void sort_out(std::size_t count, std::size_t& last);
  void take_block();
  void take(const SolidPair& pair, PairStatus status, const PairGeometry& geometry,
            std::span<const ContactPoint> points);
  void count(PairStatus status);

  std::unique_ptr<Broadphase> broadphase_;
  std::unique_ptr<Narrowphase> narrowphase_;
  std::unique_ptr<Narrowphase::Workspace> workspace_;
  double margin_;
  std::vector<Part> parts_;
  std::vector<std::uint32_t> part_of_;  // by solid
  std::vector<std::pair<Mover, Mover>> exempt_;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> exempt_parts_;  // a < b; ascending once built
  std::vector<Pose> poses_;
  bool was_found_ = false;            // since build()
  std::vector<std::uint32_t> moved_;  // parts
  std::vector<SolidPair> block_;
  std::vector<Candidate> candidates_;
  std::vector<SolidPair> evaluated_;
  std::vector<PairStatus> status_;
  std::vector<PairGeometry> geometry_;
  std::vector<ContactPoint> points_;
  std::vector<Contact> contacts_, last_contacts_;
  std::vector<ContactOrigin> origins_, last_origins_;
  std::vector<Found> found_, last_found_;
  std::uint32_t undecided_ = 0, failed_ = 0;
};

}  // namespace touchstone::physics
