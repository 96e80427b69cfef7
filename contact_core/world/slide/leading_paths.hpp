#pragma once

#include <span>

#include "touchstone/contact_core/world/model/world_model.hpp"
#include "touchstone/contact_core/world/pairs/frame_pairs.hpp"
#include "touchstone/contact_core/world/slide/slider.hpp"

// Paths of sub-steps that no rows plan: about a contact, on along the command, and beside a leader.

namespace touchstone {

/// A mover that only advances turns about its contact. A commanded pose does not say on which path the body
/// gets there. Where its origin goes straight, a tool that turns about an edge under it dips below that edge,
/// and would be stopped at once. On this path the touching point goes straight, and the contact holds.
RigidPath pivot_path(const Pose& X_WO, const Pose& goal, const Vector3& touching_W);
struct Pivot {
  const FramePair* pair = nullptr;  ///< null: none
  Vector3 touching_W = Vector3::Zero();
};
/// Where the pair that stopped a root at `stop` of its commanded path touches it; of several the nearest,
/// whatever order they come in.
Pivot find_pivot(const WorldModel& model, std::span<const FramePair> pairs, std::span<const Moment> moments,
                 std::uint32_t root, double stop);
/// The point of that pair's contact that the motion to the goal presses most: where faces rest on each other,
/// a point of the edge that the body turns about.
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
