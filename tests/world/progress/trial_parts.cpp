#include "touchstone/tests/world/progress/trial_parts.hpp"

#include <utility>

namespace touchstone {

std::unique_ptr<ContactWorld> world_with(const Obstacles& obstacles, double gap, ContactPolicy policy) {
  BackendRegistry registry;
  register_core(registry);
  auto world = std::make_unique<ContactWorld>(registry.make_narrowphase("native"),
                                              registry.make_broadphase("native"), gap);
  world->set_default_rule(rule(policy));
  for (std::size_t i = 0; i < obstacles.solids.size(); ++i) {
    const auto tree = std::make_shared<HexahedronTree>(
        std::vector<PlacedHexahedron>{{"solid", obstacles.solids[i], Pose{}}},
        "obstacle " + std::to_string(i));
    world->add({tree, obstacles.X_WO[i], true});
  }
  return world;
}

ProgressTrial arm_trial(std::shared_ptr<const Mechanism> arm, const Pose& X_WB, const std::vector<double>& q,
                        const Obstacles& obstacles, double gap) {
  ProgressTrial out;
  out.world = world_with(obstacles, gap, ContactPolicy::slide);
  out.arm = out.world->add_mechanism({arm, X_WB, q, {}, {}});
  out.model = std::make_unique<MoverModel>(arm, X_WB, obstacles.solids, obstacles.X_WO);
  out.is_arm = true;
  return out;
}

ProgressTrial body_trial(const Hexahedron& solid, const Pose& X_WO, const Obstacles& obstacles, double gap,
                         ContactPolicy policy) {
  ProgressTrial out;
  out.world = world_with(obstacles, gap, policy);
  const auto tree =
      std::make_shared<HexahedronTree>(std::vector<PlacedHexahedron>{{"solid", solid, Pose{}}}, "mover");
  out.body = out.world->add({tree, X_WO});
  out.model = std::make_unique<MoverModel>(std::vector<Hexahedron>{solid}, std::vector<Pose>{Pose{}},
                                           obstacles.solids, obstacles.X_WO);
  return out;
}

void command_rates(ProgressTrial& trial, std::vector<double> rates, double rate) {
  trial.command = [rates, rate](const Configuration& at, int) {
    Configuration goal = at;
    for (std::size_t k = 0; k < rates.size(); ++k) goal.q[k] += rates[k] / rate;
    return goal;
  };
}

void command_path_to(ProgressTrial& trial, const Pose& X_end, double rate) {
  const RigidPath whole = RigidPath::between(trial.at().X_WO, X_end);
  trial.command = [whole, rate](const Configuration&, int frame) {
    return Configuration{{}, whole.pose_at((frame + 1) / (2.0 * rate))};
  };
  trial.frames = static_cast<int>(3 * rate);
  trial.has_end = true;
}

Obstacles shell(const Vector3& size, double play) {
  constexpr double kWall = 0.02;
  const Vector3 half = 0.5 * size;
  const double depth = size.x() + kWall + play;
  Obstacles out;
  for (const double side : {1.0, -1.0}) {
    out.add(Vector3(depth, kWall, size.z() + 1.0),
            at(-0.5 * (kWall + play), side * (half.y() + play + 0.5 * kWall), 0));
    out.add(Vector3(depth, size.y() + 1.0, kWall),
            at(-0.5 * (kWall + play), 0, side * (half.z() + play + 0.5 * kWall)));
  }
  out.add(Vector3(kWall, size.y() + 1.0, size.z() + 1.0), at(-half.x() - play - 0.5 * kWall, 0, 0));
  return out;
}

Configuration ProgressTrial::at() const {
  if (!is_arm) return {{}, world->actual_pose(body)};
  const auto q = world->joint_values(arm);
  return {{q.begin(), q.end()}, {}};
}

Configuration ProgressTrial::executed(std::size_t part, double s) const {
  if (!is_arm) return {{}, world->executed_pose(body, part, s)};
  Configuration out = at();
  world->executed_joints(arm, part, s, out.q);
  return out;
}

}  // namespace touchstone
