#pragma once

#include <span>

#include "touchstone/contact_core/world/model/world_model.hpp"
#include "touchstone/contact_core/world/pairs/frame_pairs.hpp"
#include "touchstone/contact_core/world/slide/slider.hpp"

// Paths of sub-steps that no rows plan: about a contact, on along the command, and beside a leader.

namespace touchstone {

/// A mover that only advances turns about its contact. A pose that is commanded says where a body is to be,
/// not how it comes there: on the path on which its origin goes straight a tool that is turned about an edge
/// it rests on dips below that edge, and would stand. On this one the touching point goes straight, and it
/// keeps to it.
RigidPath pivot_path(const Pose& X_WO, const Pose& goal, const Vector3& touching_W);
struct Pivot {
  const FramePair* pair = nullptr;  ///< null: none
  Vector3 touching_W = Vector3::Zero();
};
/// Where the pair that stopped a root at `stop` of its commanded path touches it; of several the nearest,
/// whatever order they come in.
Pivot find_pivot(const WorldModel& model, std::span<const FramePair> pairs, std::span<const Moment> moments,
                 std::uint32_t root, double stop);
/// Of the points at which that pair touches where it stands the one that the motion to the goal presses most:
/// of a face that rests on another, one of the edge that it is turned about.
Vector3 pressed_point(const WorldModel& model, NarrowphaseQuery& query, const Pivot& pivot,
                      std::uint32_t root, const Pose& goal);

/// The slider goes on along its commanded path, of which `stop` is gone, with what goes along.
void begin_shove(Slider& slider, const RigidPath& path, double stop);
/// After a part that ended at `stop`. @returns whether it shoves on; else it may slide.
bool go_on_shoving(Slider& slider, double stop, bool is_blocked, bool may_slide);
/// The rest of a leader's commanded path: the same motion, evenly continued.
RigidPath shoving_path(const Slider& slider, const Pose& X_WO);

/// The motion of a leader, from where another body stands.
RigidPath path_along(const RigidPath& leader, const Pose& X_WO);

}  // namespace touchstone
