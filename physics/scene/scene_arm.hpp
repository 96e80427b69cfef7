#pragma once

#include <span>
#include <string>

#include "touchstone/contact_core/mechanism/mechanism.hpp"
#include "touchstone/physics/scene/dynamic_scene.hpp"

namespace touchstone::physics {

/// Adds an arm to a scene: its links with hexahedra as objects `name.link`, the base fixed, their joints as
/// the mechanism `name`, limits and efforts as the arm's; brakes on. Pairs that the arm exempts are exempt.
/// Links' inertias are taken as about their centres of mass. A link without hexahedra is left out where a
/// fixed joint holds it and nothing hangs on it (a frame in a gripper's mouth); the base may be one.
/// @param arm without prismatic offsets in what is left out. @param X_WB of its base. @param q one a joint
/// value.
/// @throws InputError: another number of values, values out of limits; a link without hexahedra that is no
/// such frame; names that the scene has.
void add_arm(DynamicScene& scene, const Mechanism& arm, const std::string& name, const Pose& X_WB,
             std::span<const double> q, const Surface& surface);

}  // namespace touchstone::physics
