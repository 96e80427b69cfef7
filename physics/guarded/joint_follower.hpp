#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "touchstone/contact_core/geometry/no_index.hpp"
#include "touchstone/physics/joints/joint_system.hpp"
#include "touchstone/physics/scene/scene_simulation.hpp"

namespace touchstone::physics {

/// Moves bodies after a cut so that joints between bodies hold again. Bodies and mechanisms that were cut
/// stand; the others of their groups move by the least motion, weighed by mass, that makes the joints hold
/// (JointSystem::pull_together()). Velocities stay; the next step's start makes them agree. Memory is taken
/// once. One thread.
class JointFollower {
 public:
  explicit JointFollower(const SceneSimulation& simulation);

  bool any() const { return joints_ > 0; }
  /// Sets states of `simulation`'s world. @param is_held by body and, behind them, by mechanism, as world()
  /// counts them. @return whether anything moved
  bool follow(SceneSimulation& simulation, std::span<const std::uint8_t> is_held);
  /// The largest error of any joint that holds, as all stand [m] [rad].
  double worst_error(SceneSimulation& simulation);

 private:
  std::uint32_t unit_of(const SceneSimulation& simulation, const Mover& mover) const;
  void find_groups(const SceneSimulation& simulation);
  void fill(SceneSimulation& simulation, std::span<const std::uint8_t> is_held);
  JointSystem::Side side(SceneSimulation& simulation, const Mover& mover,
                         std::span<const std::uint8_t> is_held);
  void give(SceneSimulation& simulation);

  std::size_t joints_, bodies_;
  JointSystem system_;
  std::vector<std::uint32_t> group_;  // by unit: the least of its group
  std::vector<std::uint32_t> place_;  // by unit: in system_
  std::vector<std::uint8_t> is_cut_;  // by group: something of it is held
  std::vector<std::uint32_t> units_;  // of system_'s bodies, then arms
  struct Arm {
    std::vector<double> q, qd, tau;  // tau: none
    MechanismDynamics::Workspace workspace;
  };
  std::vector<Arm> arms_;  // by mechanism
};

}  // namespace touchstone::physics
