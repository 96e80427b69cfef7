#pragma once

#include <array>
#include <memory>
#include <string_view>
#include <vector>

#include "touchstone/examples/station/flight/station_dynamics.hpp"
#include "touchstone/examples/training_run/flight/method.hpp"

namespace touchstone::station {

/// Faults that an instructor sets in an arm, by joint value.
struct JointFaults {
  static constexpr std::size_t kMost = 32;
  std::uint32_t braked = 0;  ///< a bit a joint: it holds with its brake, whatever the hand wants
  std::array<double, kMost> torque_share{};  ///< of its limit that a drive has left, 0 to 1

  JointFaults() { torque_share.fill(1.0); }
};

/// A contact point that pushes, as the last step of a frame had it.
struct PushingContact {
  SolidPair solids;  ///< of the scene
  Vector3 p_A_W = Vector3::Zero(), n_AB_W = Vector3::Zero();
  double separation = 0.0;
  Vector3 force_W = Vector3::Zero();  ///< on b [N]
};

/// Our check with forces (GuardedSimulation): joints follow the rates that lead to the commanded values at
/// the frame's end, with the torque that they have; what is shown is proven. Steps do not allocate, once
/// warm; latches do.
class GuardedMethod final : public training::Method {
 public:
  /// Keeps references. @throws InputError as GuardedSimulation.
  GuardedMethod(const training::Setting& setting, const StationDynamics& dynamics);

  std::string_view name() const noexcept override { return "ours, with dynamics"; }
  std::string_view backend() const noexcept override { return "native"; }
  void act(const training::Action& action) override;
  void set_base(const training::Arm& arm) override;
  void frame(std::span<const training::Command> commands, std::span<const training::ArmCommand> arm_commands,
             training::FlightLog& log) noexcept override;
  void attach(FrameOutput&) override {}  // ShownFlight brings frames to outputs
  void send(double) noexcept override {}
  std::span<const Pose> poses() const noexcept override { return X_WO_; }
  std::span<const double> joints() const noexcept override { return joints_; }
  const training::Formation& formation() const noexcept override { return formation_; }

  void set_policy(physics::GuardPolicy policy);
  /// Of an arm that walks: its free end is held where it is, as if welded, or let go. Between frames.
  void hold_free_end(bool is_held);
  /// From the next frame on. @param holds: brakes on all joints.
  void set_joints(const JointFaults& faults, bool holds) { faults_ = faults, holds_ = holds; }

  // Of the last frame.

  /// Events that began, ended or were refused in any of its steps; pairs near, in contact or blocked at its
  /// end. A contact that forces hold the arm back at counts as blocked: less than half of what was commanded
  /// was done.
  std::span<const ContactEvent> events() const { return events_; }
  std::uint32_t object_of(ObjectHandle object) const {
    return static_cast<std::uint32_t>(run_->object_of(object));
  }
  std::span<const double> torques() const {
    return torques_;
  }  ///< by joint value, means over the frame [N m]
  double contact_force() const {
    return force_;
  }  ///< on arm and load: sum of magnitudes, mean over the frame [N]
  std::span<const PushingContact> pushing() const { return pushing_; }
  /// Steps that dynamics did not take, since the start, and why the last one; nothing moved in them.
  std::uint64_t failed_steps() const { return failed_; }
  std::string_view failure() const { return failure_; }

  static constexpr std::size_t kMostPushing = 64;

 private:
  void make_run(const physics::DynamicScene& scene);
  void drive(std::span<const double> goals);
  void take_step(bool is_last);
  void take_forces();
  void add_stall(std::span<const double> goals);
  void take_state();
  void log_events(training::FlightLog& log) const;
  bool is_of_arm(const physics::Mover& mover) const { return mover.kind == physics::Mover::Kind::link; }

  const training::Setting* setting_;
  const StationDynamics* dynamics_;
  physics::GuardSettings settings_;
  std::unique_ptr<const physics::DynamicScene> walked_;  // that run_ goes on in; null: dynamics_'s
  std::unique_ptr<physics::GuardedSimulation> run_;
  training::Formation formation_;
  std::vector<std::uint32_t> value_of_;  // by the script's joint value: dynamics'
  std::vector<Pose> X_WO_;
  std::vector<double> joints_, before_, torques_, goals_;
  std::vector<ContactEvent> events_;
  std::vector<PushingContact> pushing_;
  JointFaults faults_;
  bool holds_ = false;
  double force_ = 0.0;
  std::uint64_t failed_ = 0;
  std::string_view failure_;
  std::uint32_t frame_ = 0;
};

}  // namespace touchstone::station
