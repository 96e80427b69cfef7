#pragma once

#include "touchstone/physics/scene/dynamic_scene.hpp"

namespace touchstone::dynamics {

/// A robot that comes without a scene falls: half a second in steps of 1 ms under 9.81 m/s2, its base held,
/// all joints free between their limits, from the middle of these (the reference where there are none), over
/// a floor a hundredth of its reach below its lowest point. Links that fixed joints join are one; those
/// without a mass get that of their hexahedra at 1000 kg/m3. A moving link without hexahedra, as of a
/// steering hinge, has a cube of 10 mm about its centre of mass, which meets nothing. @throws InputError: no
/// joint that moves.
physics::DynamicScene robot_scene(const MechanismDescription& robot);

}  // namespace touchstone::dynamics
