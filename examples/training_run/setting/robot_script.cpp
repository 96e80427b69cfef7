#include "touchstone/examples/training_run/setting/robot_script.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/contact_core/mechanism/configuration_check.hpp"
#include "touchstone/contact_core/native/native.hpp"
#include "touchstone/examples/training_run/setting/robot_start.hpp"

namespace touchstone::training {
namespace {

constexpr double kGap = 0.05, kBlock = 0.2, kSpeed = 0.1;  // by the reach; the last a second
constexpr double kOutward = 1.5, kSideways = 1.0;          // [s]
constexpr double kOfRate = 0.5;          // of what the joint may: the others that move along have theirs
constexpr std::size_t kMostStarts = 32;  // looked at: each is checked with a narrowphase of its own
constexpr double kSlowest = 100.0;       // times: a joint whose rate is about 0 does not take for ever

std::size_t joints_that_move(const Mechanism& robot, std::uint32_t link) {
  const auto chain = robot.chain(link);
  return static_cast<std::size_t>(std::count_if(chain.begin(), chain.end(), [&](std::uint32_t joint) {
    return robot.joints()[joint].value != Mechanism::kNone;
  }));
}

/// A link that holds several moving links is a hand: it is flown, not its fingers.
std::uint32_t without_fingers(const Mechanism& robot, std::uint32_t end) {
  for (const std::uint32_t index : robot.chain(end)) {
    const std::uint32_t inner = robot.joints()[index].inner;
    const auto hangs = [&](const Mechanism::Joint& joint) {
      return joint.inner == inner && joint.value != Mechanism::kNone;
    };
    const auto count = std::count_if(robot.joints().begin(), robot.joints().end(), hangs);
    if (count > 1 && robot.links()[inner].tree && joints_that_move(robot, inner) > 0) return inner;
  }
  return end;
}

/// The last of those that most joints move, or the hand that holds it.
std::uint32_t end_of(const Mechanism& robot) {
  std::uint32_t end = Mechanism::kNone;
  std::size_t most = 1;
  for (std::uint32_t link = 0; link < robot.links().size(); ++link)
    if (robot.links()[link].tree && joints_that_move(robot, link) >= most)
      end = link, most = joints_that_move(robot, link);
  if (end == Mechanism::kNone)
    throw InputError("robot '" + robot.name() + "': no joint moves a link with hexahedra");
  return without_fingers(robot, end);
}

Sphere around(const Mechanism& robot, std::uint32_t link, std::span<const Pose> X_WL) {
  const Sphere& sphere = robot.links()[link].tree->nodes()[0].sphere_O;
  return {transform(X_WL[link], sphere.centre), sphere.radius};
}

/// How far a ball is from the other links' hexahedra, by their balls [m].
double clearance(const Mechanism& robot, std::uint32_t end, std::span<const Pose> X_WL, const Sphere& ball) {
  double least = kInfinity;
  for (std::uint32_t i = 0; i < robot.solids().size(); ++i) {
    if (robot.link_of(i) == end) continue;
    const Sphere& solid = robot.solids()[i].bounding_sphere();
    const Vector3 centre = transform(X_WL[robot.link_of(i)], transform(robot.placed(i).X_OS, solid.centre));
    least = std::min(least, norm(centre - ball.centre) - solid.radius - ball.radius);
  }
  return least;
}

/// Where the link's middle goes, and how fast its joint takes it there at most [m/s].
struct Approach {
  Vector3 direction = Vector3::UnitZ();
  double speed = kInfinity;
};

/// Of the directions in which one of its joints takes the link's middle, the one in which a block
/// stands freest of the other links.
Approach freest_approach(const Mechanism& robot, std::uint32_t end, std::span<const Pose> X_WL,
                         const Sphere& at_end, double away, double block_radius) {
  Approach best;
  double freest = -kInfinity;
  for (const std::uint32_t index : robot.chain(end)) {
    const Mechanism::Joint& joint = robot.joints()[index];
    if (joint.value == Mechanism::kNone) continue;
    const Pose X_WJ = compose(X_WL[joint.inner], joint.X_PJ);
    const Vector3 axis = rotate(X_WJ.R, joint.axis_J);
    const Vector3 v = joint.kind == JointKind::prismatic ? axis : cross(axis, at_end.centre - X_WJ.p);
    if (!(norm(v) > at_end.radius)) continue;  // turns it about itself
    for (const double sign : {1.0, -1.0}) {
      const Vector3 direction = sign / norm(v) * v;
      const double free = clearance(robot, end, X_WL, {at_end.centre + away * direction, block_radius});
      if (free > freest) freest = free, best = {direction, joint.rate * norm(v)};
    }
  }
  return best;
}

/// With a face towards what comes along `direction`.
SceneObject block(double side, const Vector3& p_W, const Vector3& direction, const Vector3& aside) {
  HexahedronTree tree({{"block", Hexahedron::from_size({side, side, side}, "block"), {}}}, "block");
  Matrix3 R;
  R.col(0) = direction, R.col(1) = aside, R.col(2) = cross(direction, aside);
  return {std::move(tree), rigid_frame({R, p_W}), {}, {}};
}

/// The robot at joint values, and the block before its hand.
struct Start {
  std::vector<double> q;
  std::vector<Pose> X_WL;
  double reach = 0.0;  ///< sets the scale of the scene [m]
  Approach approach;
  Vector3 aside;  ///< across the approach, a unit
  SceneObject block;
};

Start start_at(const Mechanism& robot, std::uint32_t end, std::vector<double> q) {
  std::vector<Pose> X_WL(robot.links().size());
  robot.link_poses({}, q, X_WL);
  double reach = 0.0;
  for (std::uint32_t link = 0; link < X_WL.size(); ++link)
    if (robot.links()[link].tree)
      reach = std::max(reach, norm(around(robot, link, X_WL).centre) + around(robot, link, X_WL).radius);
  // The block stands where the end of the robot can approach it most freely.
  const Sphere at_end = around(robot, end, X_WL);
  const double block_radius = 0.87 * kBlock * reach;  // half a cube's diagonal
  const double away = at_end.radius + (kGap + 0.5 * kBlock) * reach;
  const Approach freest = freest_approach(robot, end, X_WL, at_end, away, block_radius);
  const Vector3& direction = freest.direction;
  const Vector3 across =
      cross(direction, std::abs(direction.z()) < 0.9 ? Vector3::UnitZ() : Vector3::UnitX());
  const Vector3 aside = across / norm(across);
  SceneObject before = block(kBlock * reach, at_end.centre + away * direction, direction, aside);
  return {std::move(q), std::move(X_WL), reach, freest, aside, std::move(before)};
}

/// Whether no links touch each other or the block.
bool is_free(const std::shared_ptr<const Mechanism>& robot, const Start& start) {
  // A check tells links and obstacles apart by their names alone, so that a link may have the block's.
  const HexahedronTree& tree = start.block.tree;
  const auto has_link = [&](const std::string& name) {
    return std::any_of(robot->links().begin(), robot->links().end(),
                       [&](const Mechanism::Link& link) { return link.name == name; });
  };
  std::string name = tree.name();
  while (has_link(name)) name += '\'';
  const Obstacle block = {
      std::make_shared<const HexahedronTree>(std::vector(tree.solids().begin(), tree.solids().end()), name),
      start.block.X_WO};
  const ConfigurationCheck check({.mechanism = robot, .obstacles = {block}}, make_native());
  ConfigurationCheck::Scratch scratch = check.make_scratch();
  return check.is_free(start.q, scratch);
}

/// The first that is free, of some and the last; where none is, the first.
Start find_start(const std::shared_ptr<const Mechanism>& robot, std::uint32_t end) {
  std::vector<std::vector<double>> starts = starts_of(*robot, end);
  if (starts.size() > kMostStarts) starts.erase(starts.begin() + kMostStarts - 1, starts.end() - 1);
  if (starts.size() > 1) {
    for (const std::vector<double>& q : starts) {
      Start start = start_at(*robot, end, q);
      if (is_free(robot, start)) return start;
    }
  }
  return start_at(*robot, end, std::move(starts.front()));
}

}  // namespace

Script robot_script(const MechanismDescription& description) {
  const auto robot = std::make_shared<const Mechanism>(description);
  const std::uint32_t end = end_of(*robot);
  Start start = find_start(robot, end);
  // A slow robot gets more time instead of rates beyond its joints.
  const double slower = std::clamp(kSpeed * start.reach / (kOfRate * start.approach.speed), 1.0, kSlowest);
  const double speed = kSpeed * start.reach / slower;

  // The scene lasts as long as the hand's four moves.
  Script script;
  script.name = "Robot " + description.name;
  script.scene.name = script.name;
  script.scene.units = "length m, angle rad";
  script.scene.frame_rate = 50.0;
  script.scene.contact_gap = 1e-9;
  script.scene.policy = ContactPolicy::advance;
  script.scene.duration = slower * 2.0 * (kOutward + kSideways);
  script.scene.objects.push_back(std::move(start.block));
  // The hand goes out, back, sideways and home.
  HandScript hand;
  hand.arm =
      ArmScript{description.name, robot, robot->links()[end].name, std::move(start.q), start.X_WL[end]};
  const Vector3 fast = speed * start.approach.direction, to_side = speed * start.aside;
  const double back = slower * kOutward, sideways = 2.0 * back, home = sideways + slower * kSideways;
  hand.rates = {{0.0, fast}, {back, -fast}, {sideways, to_side}, {home, -to_side}};
  script.hands.push_back(std::move(hand));
  return script;
}

}  // namespace touchstone::training
