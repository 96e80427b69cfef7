#include "touchstone/examples/training_run/setting/robot_start.hpp"

#include <algorithm>
#include <numbers>
#include <utility>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/mechanism/resolved_rate.hpp"
#include "touchstone/examples/measures/common/random.hpp"
#include "touchstone/examples/robot_files/robot_files.hpp"

namespace touchstone::training {
namespace {

constexpr int kDraws = 512;
constexpr std::uint64_t kSeed = 1;
constexpr double kShare = 0.25;  // of a joint's range, to each side of the middle
constexpr double kMostTurn = 0.5 * std::numbers::pi;
constexpr double kWorthwhile = 2.0;  // times as far from a singularity as the middle

/// A value beside the start's, as far as the joint's range is known.
double drawn(const Mechanism::Joint& joint, double start, measures::Random& random) {
  double reach = kShare * (joint.upper - joint.lower);
  if (joint.kind == JointKind::revolute) reach = std::min(reach, kMostTurn);
  if (reach == kInfinity) return start;  // a slider without ends
  return std::clamp(start + random.uniform(-reach, reach), joint.lower, joint.upper);
}

}  // namespace

std::vector<std::vector<double>> starts_of(const Mechanism& robot, std::uint32_t link) {
  // The middle serves where the hand is regular there, by the settings that it flies with.
  const std::vector<double> middle = robot_files::start_values(robot);
  const ResolvedRate control(robot, link);
  std::vector<Pose> X_WL(robot.links().size());
  const auto regularity = [&](const std::vector<double>& q) {
    robot.link_poses({}, q, X_WL);
    return control.regularity(X_WL, X_WL[link].p);
  };
  const double at_middle = regularity(middle);
  if (at_middle >= ResolvedRateSettings{}.damped_below) return {middle};
  // Bent poses.
  std::vector<std::pair<double, std::vector<double>>> bent;
  measures::Random random(kSeed);
  for (int i = 0; i < kDraws; ++i) {
    std::vector<double> q = middle;
    for (const std::uint32_t index : robot.chain(link)) {
      const Mechanism::Joint& joint = robot.joints()[index];
      if (joint.value != Mechanism::kNone) q[joint.value] = drawn(joint, middle[joint.value], random);
    }
    const double here = regularity(q);
    if (here > kWorthwhile * at_middle) bent.emplace_back(here, std::move(q));
  }
  std::stable_sort(bent.begin(), bent.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  // The middle is the last of them.
  std::vector<std::vector<double>> starts;
  for (auto& [here, q] : bent) starts.push_back(std::move(q));
  starts.push_back(middle);
  return starts;
}

}  // namespace touchstone::training
