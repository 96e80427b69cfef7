#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "touchstone/contact_core/motion/path.hpp"
#include "touchstone/contact_core/world/slide/slider.hpp"

namespace touchstone {

/// A rigid body's motion in one sub-step of a slide.
struct RigidPlan {
  RigidPath path;                                                 ///< at rest: nothing is to be gained
  ActiveRows active = {};                                         ///< hold it back: among its rows
  Vector3 force_W = Vector3::Zero(), moment_W = Vector3::Zero();  ///< HandFeel's [N], [N m]
  bool is_near_end = false;                                       ///< see Slider
  std::uint64_t work = 0;                                         ///< adds to Slider::work
};

/// Plans from where the body stands and what is near, and from nothing else. Faces in contact are taken
/// first; then, along the motion that they leave, the planes of all that is near: those are chosen in `near`.
/// @param rows room; then the plan's.
RigidPlan plan_rigid_slide(const Slider& slider, const Pose& X_WR, bool translation_only,
                           std::span<NearPair> near, std::vector<SlideRow>& rows);

}  // namespace touchstone
