#include "touchstone/adapters/c_files/touchstone_files.h"
#include "touchstone/adapters/c_interface/calls.hpp"
#include "touchstone/adapters/c_interface/world.hpp"
#include "touchstone/adapters/robot_formats/robot_formats.hpp"
#include "touchstone/adapters/robots/simplify.hpp"
#include "touchstone/contact_core/native/native.hpp"

// Robots of files in a world.

using namespace touchstone;
using c_interface::guarded;

namespace {

MechanismDescription robot_of(const char* path, const touchstone_robot_options& options) {
  RobotOptions reading;
  reading.sphere_facets = options.sphere_facets;
  if (options.free_mimic_joints != 0) reading.mimic = MimicJoints::free;
  MechanismDescription robot = load_robot(path, reading).mechanism;
  if (options.srdf != nullptr) robot.exempt_pairs = load_exempt_pairs(options.srdf);
  return robot;
}

}  // namespace

touchstone_code touchstone_add_robot(touchstone_world* world, const char* name, const char* path,
                                     const touchstone_robot_options* options, const touchstone_pose* X_WB,
                                     const double* values, size_t count, touchstone_mechanism* out) {
  return guarded({{world, "world"}, {path, "path"}, {X_WB, "X_WB"}, {out, "out"}}, [&] {
    const touchstone_robot_options given = options == nullptr ? touchstone_robot_options{} : *options;
    MechanismDescription robot = robot_of(path, given);
    if (name != nullptr) robot.name = name;
    MechanismPlacement placement;
    placement.initial = c_interface::values_of(values, count, "values");
    if (given.mechanism != nullptr) c_interface::take_options(*given.mechanism, robot, placement);
    // Links that still overlap in the reference pose.
    if (given.exempt_reference_overlaps != 0) exempt_reference_overlaps(robot, *make_native());
    *out = c_interface::add_mechanism(*world, std::move(robot), std::move(placement), *X_WB);
  });
}
