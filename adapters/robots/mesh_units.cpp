#include "touchstone/adapters/robots/mesh_units.hpp"

#include <algorithm>
#include <map>

#include "touchstone/contact_core/geometry/norms.hpp"
#include "touchstone/contact_core/input_error.hpp"

namespace touchstone {
namespace {

/// Millimetres for metres make 1000, of a hand on an arm ten times its size still 100. A mesh of a real robot
/// is within a few times its joints' reach, and its largest one no less than a thirtieth of it.
constexpr double kTooLarge = 30.0, kLarge = 10.0, kTooSmall = 300.0, kSmall = 30.0;

}  // namespace

double joint_reach(const MechanismDescription& mechanism) {
  std::map<std::string, const JointDescription*> to_parent;
  for (const JointDescription& joint : mechanism.joints) to_parent[joint.child] = &joint;
  double longest = 0.0;
  for (const JointDescription& tip : mechanism.joints) {
    double length = 0.0;
    std::size_t steps = 0;  // a loop is refused later, by Mechanism
    for (const JointDescription* at = &tip; at != nullptr && steps <= mechanism.joints.size(); ++steps) {
      length += norm(at->X_PJ.p);
      const auto next = to_parent.find(at->parent);
      at = next == to_parent.end() ? nullptr : next->second;
    }
    longest = std::max(longest, length);
  }
  return longest;
}

void check_mesh_units(const std::string& source, const RobotOptions& options, Robot& robot) {
  const auto largest =
      std::max_element(robot.replaced.begin(), robot.replaced.end(),
                       [](const ShapeReplacement& a, const ShapeReplacement& b) { return a.size < b.size; });
  const double reach = joint_reach(robot.mechanism);
  if (largest == robot.replaced.end() || !(largest->size > 0.0) || !(reach > 0.0)) return;
  const double larger = largest->size / reach, smaller = reach / largest->size;
  if (!(larger >= kLarge) && !(smaller >= kSmall)) return;
  const std::string text = source + ": link '" + largest->link + "': mesh '" + largest->file + "' is " +
                           figure(largest->size) +
                           " m across, the largest of the robot, while its joints reach " + figure(reach) +
                           " m: a factor of " + figure(std::max(larger, smaller));
  if ((larger >= kTooLarge || smaller >= kTooSmall) && !options.any_mesh_size)
    throw InputError(text + "; are its units those of the robot (a scale of 0.001 or 1000)?");
  robot.notes.push_back(text);
}

}  // namespace touchstone
