#pragma once

#include <span>

#include "touchstone/contact_core/world/frame_pairs.hpp"
#include "touchstone/contact_core/world/slide/slider.hpp"
#include "touchstone/contact_core/world/world_model.hpp"

// Paths of sub-steps that no rows plan: about a contact, on along the command, and beside a leader.

namespace touchstone {

/// A mover that only advances turns about its contact. A pose that is commanded says where a body is to be,
/// not how it comes there: on the path on which its origin goes straight a tool that is turned about an edge
/// it rests on dips below that edge, and would stand. On this one the touching point goes straight, and it
/// keeps to it.
RigidPath pivot_path(const Pose& X_WO, const Pose& goal, const Vector3& touching_W);
/// Where the pair that stopped a root at `stop` of its commanded path touches it; of several the nearest,
/// whatever order they come in. @returns false: none did.
bool find_pivot(const WorldModel& model, std::span<const FramePair> pairs, std::span<const Moment> moments,
                std::uint32_t root, double stop, Vector3& touching_W);

/// The slider goes on along its commanded path, of which `stop` is gone, with what goes along.
void begin_shove(Slider& slider, const RigidPath& path, double stop);
/// After a part that ended at `stop`. @returns whether it shoves on; else it may slide.
bool go_on_shoving(Slider& slider, double stop, bool is_blocked, bool may_slide);
/// The rest of a leader's commanded path: the same motion, evenly continued.
RigidPath shoving_path(const Slider& slider, const Pose& X_WO);

/// The motion of a leader, from where another body stands.
RigidPath path_along(const RigidPath& leader, const Pose& X_WO);

}  // namespace touchstone
