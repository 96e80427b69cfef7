#pragma once

#include <string_view>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/physics/scene/dynamic_scene.hpp"

namespace touchstone::physics {

/// The joint that name_of() calls so: `mechanism.joint`, or a joint between bodies by its own name.
/// @throws InputError: there is none.
inline JointAddress joint_named(const DynamicScene& scene, std::string_view name) {
  for (std::size_t m = 0; m < scene.mechanisms.size(); ++m)
    for (std::size_t j = 0; j < scene.mechanisms[m].joints.size(); ++j)
      if (name_of(scene, {m, j}) == name) return {m, j};
  for (std::size_t j = 0; j < scene.joints.size(); ++j)
    if (scene.joints[j].name == name) return {JointAddress::kBodyJoint, j};
  reject(name, "is no joint of the scene");
}

}  // namespace touchstone::physics
