#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "touchstone/contact_core/geometry/no_index.hpp"
#include "touchstone/contact_core/geometry/norms.hpp"
#include "touchstone/contact_core/memory/growing_list.hpp"
#include "touchstone/contact_core/motion/narrowphase_query.hpp"
#include "touchstone/contact_core/world/contact_world.hpp"
#include "touchstone/contact_core/world/model/open_solids.hpp"
#include "touchstone/contact_core/world/model/rides.hpp"
#include "touchstone/contact_core/world/model/travels.hpp"
#include "touchstone/contact_core/world/objects/mechanism_mover.hpp"
#include "touchstone/contact_core/world/objects/object_table.hpp"
#include "touchstone/contact_core/world/pairs/frame_pairs.hpp"
#include "touchstone/contact_core/world/pairs/pair_rules.hpp"
#include "touchstone/contact_core/world/pairs/selection_state.hpp"

namespace touchstone {

class FrameLanes;

/// The input of a world's parts: the objects, their rules, their poses, and the paths that are laid.
/// Its functions are read-only. Indices are slots of objects and solids of the layout; what moves as one is
/// known by its root's slot.
struct WorldModel {
  std::unique_ptr<Narrowphase> narrowphase;
  // Native: plans slides, and motion where the narrowphase only judges. Null: the narrowphase is native
  // itself.
  std::unique_ptr<Narrowphase> planner;
  double gap;
  double margin = 0.0;  // the broadphase's [m]

  ObjectTable objects;
  MechanismTable mechanisms;
  PairRules rules;
  Selection selection;
  Layout layout;

  double furthest = 0.0;  // no object's origin has been further out since all was laid out [m]
  double largest_extent =
      0.0;  // no solid's sphere reached further from its object's origin, and a radius [m]
  GrowingList<CarriedPath> paths;            // by slot; a root's
  GrowingList<double> stops;                 // by slot; a root's
  GrowingList<std::uint8_t> in_motion;       // by slot; a root's
  GrowingList<Pose> from;                    // by solid; where one is closed (see open) as it stood then
  GrowingList<Pose> X_BS;                    // by solid, in its body; of mechanisms' solids
  GrowingList<Sphere> sphere_B;              // by solid, its bounding sphere in its body
  GrowingList<std::uint32_t> root_of_solid;  // objects' own, which lie further apart in memory
  GrowingList<std::pair<std::uint32_t, std::uint32_t>> members;  // (root, object by slot), sorted
  GrowingList<std::uint32_t> member_root;                        // by slot: its root in members, or none
  Rides rides;                                                   // by root
  OpenSolids open;                                               // of objects with levels
  Travels travels;

  bool is_sampled() const { return !gives_signed_distance(*narrowphase); }
  /// The narrowphase whose separations guide motion.
  const Narrowphase& separations() const { return is_sampled() ? *planner : *narrowphase; }

  std::uint32_t root_of(SolidIndex solid) const { return root_of_solid[solid]; }
  std::uint32_t body_of(SolidIndex solid) const { return objects[layout.slot_of[solid]].body; }
  /// The mechanism that the object is a link of or is carried by, or null.
  MechanismMover* mechanism_of(std::uint32_t slot) const {
    const ObjectRecord& body = objects[objects[slot].body];
    return body.is_link() ? mechanisms.at(body.mechanism) : nullptr;
  }
  /// The mechanism on whose path the object goes: mechanism_of(), or the one of which a link takes it along;
  /// or null.
  MechanismMover* arm_of(std::uint32_t slot) const {
    const Rides::Ride* ride = rides.find(objects[slot].root);
    return mechanism_of(ride == nullptr ? slot : ride->lead);
  }
  /// The link of that mechanism with which it goes. @pre there is one.
  std::uint32_t link_of(std::uint32_t slot) const {
    const Rides::Ride* ride = rides.find(objects[slot].root);
    return ride == nullptr ? objects[objects[slot].body].link : ride->link;
  }
  /// The pose of such an object while its link is at X_WL.
  Pose pose_on_link(std::uint32_t slot, const Pose& X_WL) const;
  /// Whether the two go with one link, or with two that no joint moves against each other, and one of them
  /// only for a frame: they stand to each other as they did.
  bool go_as_one(const SolidPair& pair) const;
  /// Whether its mover's path moves the object. @pre the mover has a path.
  bool moves(std::uint32_t slot) const;
  /// Calls visit(slot) for each object that moves with the root.
  template <class Visit>
  void for_each_member(std::uint32_t root, Visit visit) const {
    const std::pair<std::uint32_t, std::uint32_t> first{root, 0};
    for (auto member = std::lower_bound(members.begin(), members.end(), first);
         member != members.end() && member->first == root; ++member)
      visit(member->second);
  }
  /// Calls visit(solid) for each of the slot's solids that has to be looked at, ascending: of an object with
  /// levels the open ones. `from`, and Travels by solid, are of these only.
  template <class Visit>
  void for_each_solid_of(std::uint32_t slot, Visit visit) const {
    const SolidIndex first = layout.first_solid[slot];
    if (layout.levels[slot] == nullptr) {
      for (SolidIndex i = first; i < layout.first_solid[slot + 1]; ++i) visit(i);
    } else {
      for (const SolidIndex i : open.of(slot, first)) visit(i);
    }
  }
  /// The same of all that moves with the root.
  template <class Visit>
  void for_each_solid(std::uint32_t root, Visit visit) const {
    for_each_member(root, [&](std::uint32_t slot) { for_each_solid_of(slot, visit); });
  }
  /// A mover's solid, then the other one's; of two links of one arm the one on the later link counts as the
  /// mover's: which of the two is a depends on the order of registration.
  std::pair<SolidIndex, SolidIndex> mover_first(const SolidPair& pair, std::uint32_t root) const {
    const bool is_own = root_of(pair.a) == root_of(pair.b);
    const bool is_b = is_own ? is_a_on_earlier_link(pair) : root_of(pair.b) == root;
    return is_b ? std::pair{pair.b, pair.a} : std::pair{pair.a, pair.b};
  }
  /// Whether solid a is on the earlier link. @pre both are on links of one arm.
  bool is_a_on_earlier_link(const SolidPair& pair) const {
    return objects[body_of(pair.a)].link < objects[body_of(pair.b)].link;
  }

  /// On its path.
  BodyState state_at(std::uint32_t slot, double s) const;
  MovingSolid moving_solid(SolidIndex solid) const;
  /// Solids a and b of two links of one arm in the earlier link's frame, in which that link rests.
  /// @param travel how far the other one goes at most [m].
  std::pair<MovingSolid, MovingSolid> seen_from_earlier_link(const SolidPair& pair, double travel) const;

  /// At least what any pair keeps that is no further from the origin [m].
  double gap_at(double distance) const;
  double gap_of(const SolidPair& pair) const;
  /// Updates `furthest` after an object was moved.
  void note_place(std::uint32_t slot) { furthest = std::max(furthest, norm_inf(objects[slot].X_WO.p)); }
  /// No pair has more.
  PairDistances most_distances() const;
  /// By so much more than the broadphase's margin the solid is in contact with others: far out, or with a
  /// coarse backend, twice the gap is more. @param travel it goes no further from where it is. [m]
  double contact_reach(SolidIndex solid, double travel) const;
  /// The same of all solids of an object with levels.
  double contact_reach_of_object(std::uint32_t slot, double travel) const;
  /// Whether the pair is switched on, not exempt, and not of one body.
  bool is_checked(const SolidPair& pair) const;
  /// Makes a pair with its rule and distances, of which nothing else is known yet.
  FramePair frame_pair(const SolidPair& pair) const;
  /// Index of two links of one mechanism into Travels::of_link_pair, or kNoLinkPair.
  std::uint32_t link_pair_index(const SolidPair& pair) const;

  /// Travels' plan is of the mechanism's path.
  bool has_planned(const MechanismMover& mover) const {
    return mover.planned_path == mover.paths && mover.planned_after == travels.clearings;
  }
  /// No point of the solid goes further than this on the mechanism's path [m].
  double travel_on(const MechanismMover& mover, SolidIndex solid) const;
  /// The same of all of the slot's solids that have to be looked at: `out` by solid.
  void measure_travels(const MechanismMover& mover, std::uint32_t slot, GrowingList<double>& out) const;
  /// The same of all that is within a sphere in the slot's body.
  double travel_on(const MechanismMover& mover, std::uint32_t slot, const Sphere& within_B) const;
  /// The same of each two links relative to each other: `out` by Travels::of_link_pair.
  void measure_link_travels(const MechanismMover& mover, std::vector<double>& out) const;
  double travelled(const SolidPair& pair, std::uint32_t link_pair) const {
    return link_pair != kNoLinkPair ? travels.of_link_pair[link_pair]
                                    : travels.of_solid[pair.a] + travels.of_solid[pair.b];
  }
  double last_travel(const SolidPair& pair, std::uint32_t link_pair) const {
    return link_pair != kNoLinkPair ? travels.last_link_pair[link_pair]
                                    : travels.last_solid[pair.a] + travels.last_solid[pair.b];
  }
  bool is_clear(const WatchedPair& watch) const {
    return travelled({watch.a, watch.b}, watch.link_pair) <= watch.clear_until;
  }
};

/// When the two meet on the paths that are laid; notes how long the pair stays clear.
/// @param until what comes after this s is of no use.
Impact impact_of(const WorldModel& model, NarrowphaseQuery& query, FramePair& pair, double until = 1.0);

/// In place of a root: of a pair that depends on no other; of one that two mechanisms in motion share, which
/// are seen from one another.
inline constexpr std::uint32_t kAlone = kNoIndex;
inline constexpr std::uint32_t kInTurn = 0xfffffffe;
/// The root whose pairs have to be taken in turn with this one: of a mechanism, as it is seen from its links,
/// also of what these take along; else of the only one of the two in motion, which may be stopped by what
/// comes first. Or kAlone, kInTurn.
std::uint32_t mover_of(const WorldModel& model, const SolidPair& pair);
/// The same as impact_of() of a watched pair, whose knowledge it takes up and renews.
/// @param start of the two as they stand; null: not known.
void find_impact_of(const WorldModel& model, NarrowphaseQuery& query, WatchedPair& watch, FramePair& pair,
                    const SeparationMemo::Answer* start, double until = 1.0);

/// Computes vertices of these watched pairs' solids, so that lanes only read vertices_of().
void place_vertices(WorldModel& model, FrameLanes& lanes, const PairWatch& watched,
                    std::span<const std::uint32_t> watches);
/// A solid's vertices at its current pose; they are kept until it moves.
const WorldVertices& vertices_of(WorldModel& model, SolidIndex solid);
/// A lower bound of the separation of two solids at their current poses [m]: how far apart they are along the
/// axis that separated them last, or the line of their centres. It costs a tenth of a narrowphase call.
double apart_at_least(WorldModel& model, const WatchedPair& watch);
/// Whether that bound shows a pair to be further apart than `travel` and the distance of interest; then this
/// is noted.
/// @param standing travels of the two where they stand. @pre the narrowphase gives separations.
bool is_apart_by_axis(WorldModel& model, WatchedPair& watch, const PairDistances& pair, double standing,
                      double travel);

}  // namespace touchstone
