#pragma once

#include <memory>
#include <string>
#include <vector>

#include "touchstone/contact_core/broadphase/broadphase.hpp"
#include "touchstone/physics/engine/engine_scene.hpp"

namespace touchstone::physics {

/// Shared by the adapters of engines: the scene in an engine's terms, its actions in time, what
/// moves with what, what is in the world, sums over the bodies, and the depth as `native` sees it. An adapter
/// sets the engine up in its constructor, all objects in, then calls start(), and keep_start() at the end.
class SceneEngine : public DynamicsEngine {
 public:
  const DynamicScene& scene() const final { return bodies_.scene(); }
  std::uint64_t steps() const final { return steps_; }
  void begin_step() final;
  EngineStep step() final;

  bool has(std::size_t object) const final { return !is_out(bodies_.body_of(object)); }
  std::size_t carrier_of(std::size_t object) const final;
  std::unique_ptr<EngineSnapshot> snapshot() const final;
  void restore(const EngineSnapshot& snapshot) final;
  void reset() final;

  Pose object_pose(std::size_t object) const final;
  std::optional<Vector3> velocity(std::size_t object) const final;
  std::optional<Vector3> angular_velocity(std::size_t object) const final;
  double joint_value(const JointAddress& joint) const final;
  double joint_rate(const JointAddress& joint) const final;
  double joint_torque(const JointAddress& joint) const final;
  Vector3 linear_momentum() const final;
  Vector3 angular_momentum() const final;
  double energy() const final;
  Vector3 body_momentum() const final;
  double body_mass() const final;
  double worst_depth() final;

 protected:
  /// How a body moves: its frame B, B's origin, turning.
  struct State {
    Pose X_WB;
    Vector3 v_W = Vector3::Zero(), w_W = Vector3::Zero();
  };
  /// [rad, rad/s, N m] or [m, m/s, N].
  struct JointState {
    double value = 0.0, rate = 0.0, torque = 0.0;
  };

  explicit SceneEngine(const DynamicScene& scene);
  /// Sets the start: closes latches, sets drives and the state, and takes objects out that come later.
  void start();
  /// Saves the state that reset() restores.
  void keep_start();

  const EngineScene& bodies() const { return bodies_; }
  double step_size() const { return scene().step; }
  /// Whether the pair is checked now: not exempt, nor allowed by a latch that is closed.
  bool is_checked(SolidIndex a, SolidIndex b) const;
  bool has_latches() const { return !held_.empty(); }
  bool is_out(std::size_t body) const { return is_out_[body] != 0; }
  const State& state(std::size_t body) const { return states_[body]; }
  /// A kinematic body's state at the next step's end, and its velocity until then.
  const State& target(std::size_t body) const { return targets_[body]; }
  /// Velocity of a kinematic body's point over the last step; of others 0.
  Vector3 commanded_velocity(std::size_t body, const Vector3& p_W) const;
  /// Fills what does not depend on the engine: sides and their velocities.
  void finish_contact(EngineContact& contact) const;

  /// Applies a force at B's origin and a moment for the next step alone. @param body a free one or a link
  virtual void apply(std::size_t body, const Vector3& force_W, const Vector3& moment_W) = 0;
  /// Moves the engine's world by the scene's step. `step` has its failure empty and its times 0.
  virtual void advance(EngineStep& step) = 0;
  /// The body's state now; of free bodies, kinematic ones and links.
  virtual State read_state(std::size_t body) const = 0;
  /// @param joint of EngineScene::joints(), then of its body_joints(), which have an axis or state 0.
  virtual JointState read_joint(std::size_t joint) const;
  /// For the steps from now on; the torque is that of the middle of the step, the limit within the joint's.
  virtual void set_drive(std::size_t joint, const JointDrive& drive);
  /// From now on a joint of EngineScene::joints() has the value and the rate, and what hangs on it goes
  /// along.
  virtual void set_joint(std::size_t joint, double value, double rate);
  /// What the engine's method does not do of an action. @throws InputError: "unsupported"
  virtual void refuse(const SceneAction& action) const;
  /// Joins two bodies at their current poses into one; and parts them. `carrier` may be of any kind.
  virtual void latch(std::size_t carrier, std::size_t carried);
  virtual void release(std::size_t carried);
  /// Lets a joint between bodies hold them at their current poses, with value 0; or lets go.
  virtual void switch_joint(std::size_t body_joint, bool is_on);
  /// Takes a free body out of the engine's world, or puts it in with that state.
  virtual void take_body(std::size_t body) = 0;
  virtual void put_body(std::size_t body, const State& at) = 0;
  /// The engine's internal state that later steps depend on, beyond what this class keeps.
  virtual std::unique_ptr<EngineSnapshot> save() const = 0;
  /// Back to it. This class restores its part itself, and commands the drives afterwards.
  /// @pre save() of this engine made it
  virtual void load(const EngineSnapshot& saved) = 0;

 private:
  struct Held {
    std::size_t carrier, carried;  // bodies
    std::vector<SolidPair> allowed;
  };

  /// The push on a body in the next step, at its B's origin.
  struct Push {
    bool is_any = false;
    Vector3 force_W = Vector3::Zero(), moment_W = Vector3::Zero();
  };

  /// All of this class that changes from step to step.
  struct Run {
    std::vector<State> states, targets;
    std::vector<std::uint8_t> is_out;
    std::vector<JointState> joint_states;
    std::vector<SceneDrive> drives;
    std::vector<double> drives_since;
    std::vector<Held> held;
    std::vector<std::size_t> root;
    std::size_t next_action;
    std::uint64_t steps;
  };
  struct Snapshot;

  void take_action(const SceneAction& action) final;
  void take_out(std::size_t object) final;
  void put_in(std::size_t object, const Pose& X_WO, const Vector3& v_W, const Vector3& w_W) final;
  void take_push(std::size_t object, const Vector3& force_W, const Vector3& p_W,
                 const Vector3& moment_W) final;
  void apply_pushes();
  bool is_carried(std::size_t body) const;
  std::string why_not(const SceneAction& action) const;
  void carry_out(const SceneAction& action);
  void hold(std::size_t carrier, std::size_t carried, std::span<const ExemptPair> allowed);
  void let_go(std::size_t carried);
  void find_roots();
  void apply_drives(bool all);
  void aim(double time);
  void read();
  std::size_t joint_index(const JointAddress& address) const;
  double effort_of(std::size_t joint) const;

  EngineScene bodies_;
  std::vector<State> states_, targets_;
  std::vector<std::uint8_t> is_out_;  // by body
  std::vector<Push> pushes_;          // by body
  std::vector<JointState> joint_states_;
  std::vector<SceneDrive> drives_;
  std::vector<double> drives_since_;
  std::vector<Held> held_;
  std::vector<std::size_t> root_;  // by body: that carries it, or itself
  std::size_t next_action_ = 0;
  std::uint64_t steps_ = 0;
  std::string refused_;  // why the next step fails
  std::unique_ptr<EngineSnapshot> start_;
  std::shared_ptr<const int> id_ = std::make_shared<const int>(0);  // snapshots know it: addresses come again

  struct Judge;
  struct JudgeDeleter {
    void operator()(Judge* judge) const;
  };
  std::unique_ptr<Judge, JudgeDeleter> judge_;
};

}  // namespace touchstone::physics
