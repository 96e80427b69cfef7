#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "touchstone/examples/station/flight/guarded_method.hpp"
#include "touchstone/examples/station/flight/inputs.hpp"
#include "touchstone/examples/station/flight/near_distances.hpp"
#include "touchstone/examples/station/flight/stance.hpp"
#include "touchstone/examples/station/flight/station_scene.hpp"
#include "touchstone/examples/training_run/flight/contact_world_method.hpp"
#include "touchstone/examples/training_run/setting/hand.hpp"

namespace touchstone::station {

/// The methods of the experiment, in the order of protocol.md.
enum class MethodKind : std::uint8_t { unchecked, late_report, first_build, ours };
inline constexpr std::size_t kMethods = 4;
inline constexpr std::uint32_t kAllMethods = 0xf;  ///< a bit a method

/// One method's flight: the same hand, its own arm.
struct Method {
  MethodKind kind;
  std::unique_ptr<training::Method> flown;
  Stance stance;
  std::vector<training::ArmHand> hands;  ///< by tip, or the free one's of an arm that walks; none: a free
                                         ///< object is flown
  training::FlightLog log;               ///< of the last frame
  std::vector<double> goals;             ///< joint values that the last frame commanded
  std::shared_ptr<const training::Formation>
      formation;  ///< a copy for those who judge; renewed between frames
  double decide_us = 0.0;
  bool blocked = false, reports_contact = false, slid = false;
  SolidPair blocked_by{0, 0};
  std::uint32_t blocked_frames = 0;

  Method(MethodKind given, std::unique_ptr<training::Method> given_method, const StationScene& scene);
  /// @param chosen FlightState::tip. @pre an arm is flown.
  training::ArmHand& hand(std::uint32_t chosen) { return hands[stance.walks() ? 0 : chosen]; }
  std::span<const double> joints() const { return flown->joints().first(goals.size()); }
};

/// The state of the controls, as `state` of protocol.md.
struct FlightState {
  CommandFrame frame = CommandFrame::end_effector;
  std::array<double, 4> camera = {0.0, 0.0, 0.0, 1.0};
  bool vernier = false, brakes = false, joint_mode = false;
  std::uint32_t joint = 0;
  std::uint32_t tip = 0;  ///< of StationScene::tips, that is flown, or of a locked arm chosen to be let go
  std::uint32_t methods = kAllMethods;
  ContactPolicy policy = ContactPolicy::slide;
  bool dynamics = false;
  physics::GuardPolicy guard = physics::GuardPolicy::push;  ///< with dynamics, instead of `policy`
  JointFaults joints;                                       ///< torques count with dynamics alone
  double report_delay = training::kImageGeneratorDelay;
};

/// The answer to a control.
struct ControlAnswer {
  bool done = true;
  std::string text;  ///< for the log: what was done, or why not
};

/// How a flight goes, for the score.
struct FlightFigures {
  double time = 0.0;                         ///< since the last reset [s]
  double path = 0.0;                         ///< of the hand's object's origin, in `ours` [m]
  std::uint32_t contacts = 0;                ///< that began, in `ours`
  double cue_seconds = 0.0;                  ///< with a contact, in `ours`
  double force = 0.0, largest_force = 0.0;   ///< GuardedMethod::contact_force(); 0 without dynamics [N]
  double torque_share = 0.0;                 ///< the largest of any joint's torque over its limit, this frame
  std::uint64_t failed_steps = 0;            ///< that dynamics did not take
  std::array<double, kMostTasks> done_at{};  ///< by task of the scene, when it was done first [s]; 0: not yet
  std::array<bool, kMostTasks> is_within{};  ///< by task: done within its limits
  Vector3 tip = Vector3::Zero();             ///< of the flown frame [m]
};

/// All that is decided in a session, frame by frame, from inputs alone: the same inputs at the same frames
/// give the same bits of all poses. set() is between frames and may allocate; step() allocates nothing but
/// what Figure 2's method does (training_run/flight/method.hpp). One thread.
class Flight {
 public:
  /// Keeps a reference. @throws InputError as training_run's methods.
  /// @param dynamics where the scene has them.
  explicit Flight(const StationScene& scene, std::uint32_t methods = kAllMethods, bool dynamics = false);

  /// Of all kinds but `scene`, which needs another flight.
  ControlAnswer set(const Control& control);
  void step(const HandInput& input) noexcept;

  const StationScene& scene() const { return *scene_; }
  const FlightState& state() const { return state_; }
  const FlightFigures& figures() const { return figures_; }
  std::uint64_t frame() const { return frame_; }  ///< flown, resets included
  std::uint64_t hash() const { return hash_; }    ///< of every pose of every method of every frame
  std::uint32_t resets() const { return resets_; }
  double rate() const { return scene_->setting.scene().frame_rate; }

  std::span<const Method> methods() const { return methods_; }
  const Method* method(MethodKind kind) const;
  const training::Method& ours() const { return *ours_; }
  /// The one that is flown.
  const Tip& tip() const { return scene_->tips[state_.tip]; }
  /// Of `ours`.
  const Stance& stance() const { return methods_.back().stance; }
  /// Null without dynamics.
  const GuardedMethod* guarded() const { return guarded_; }
  // Of `ours`, the last frame's: events, and what their handles and solids are in the scene.
  std::span<const ContactEvent> events() const {
    return guarded_ ? guarded_->events() : world_->report().events;
  }
  std::uint32_t object_of(ObjectHandle object) const {
    return guarded_ ? guarded_->object_of(object) : world_->object_of(object);
  }
  SolidIndex solid_in_scene(ObjectHandle object, SolidIndex within) const {
    return scene_->setting.instance().first_solid(object_of(object)) + within;
  }
  /// Commanded poses of `ours`: where the hand leads on from a stop, no further from there than kLeash; else
  /// where the last frame commanded it to go.
  std::span<const Pose> commanded() const { return ghost_poses_; }
  std::span<const double> commanded_joints() const { return ghost_joints_; }
  /// Of `ours`: from the flown object, or what it carries, to others.
  std::span<const NearDistance> distances() const { return near_.found(); }
  bool was_limited() const { return was_limited_; }
  bool was_damped() const { return was_damped_; }
  bool is_at_limit() const { return is_at_limit_; }

  static constexpr double kLeash = 0.5;  ///< [m], and turns as lengths at 1 m
  /// A latch closes where the carrier is this near to what it shall carry [m]; assumed.
  static constexpr double kLatchReach = 0.1;

 private:
  void make_methods();
  HandRates rates_of(const HandInput& input) const noexcept;
  void fly(Method& method, const HandRates& rates, const HandInput& input) noexcept;
  void command_arm(Method& method, const HandRates& rates, const HandInput& input) noexcept;
  void drive_joint(const training::Arm& arm, std::span<const double> q, double joint,
                   std::span<double> goals) const noexcept;
  void move_jaws(const training::Arm& arm, double grip, std::span<double> goals) const noexcept;
  void hold_jaws(std::span<const double> q, Method& method) const noexcept;
  void take_log(Method& method) noexcept;
  void move_ghost(const HandRates& rates, double joint) noexcept;
  void place_ghost() noexcept;
  void add_to_hash() noexcept;
  void add_figures(const Pose& X_before) noexcept;
  bool is_done(const StationTask& task) noexcept;
  bool touches(const Tip& tip, std::uint32_t object, std::span<const Pose> poses) noexcept;
  bool may_latch(const LatchOption& option, const Method& method, std::uint32_t object);
  static bool carries(const Method& method, std::uint32_t carrier);
  std::optional<ControlAnswer> hold(std::uint32_t object);
  std::optional<ControlAnswer> let_go();
  void walk(Method& method);
  void start_ghost();
  ControlAnswer latch(std::uint32_t object);
  ControlAnswer release();
  ControlAnswer select(std::uint32_t object, bool on);
  ControlAnswer set_policy(std::uint32_t policy);
  ControlAnswer set_dynamics(bool on);
  ControlAnswer set_tip(std::uint32_t tip);
  void start_hands();
  ControlAnswer break_joint(const Control& control);
  void tell_policy();
  void add_forces() noexcept;
  ControlAnswer reset(std::string text);
  void act(Method& method, const training::Action& action);
  const LatchOption* nearest_option(const Method& method, std::uint32_t object);

  const StationScene* scene_;
  FlightState state_;
  FlightFigures figures_;
  std::vector<Method> methods_;
  training::Method* ours_ = nullptr;
  training::ContactWorldMethod* world_ = nullptr;  // ours_, without dynamics
  GuardedMethod* guarded_ = nullptr;               // ours_, with them
  std::vector<training::ArmHand> ghost_hands_;     // by tip
  std::vector<double> ghost_joints_, ghost_next_;
  std::vector<Pose> ghost_links_, ghost_poses_, ghost_next_poses_;
  std::vector<training::Command> commands_;
  std::vector<training::ArmCommand> arm_commands_;
  NearDistances near_;
  bool was_limited_ = false, was_damped_ = false, is_at_limit_ = false;
  std::uint64_t frame_ = 0, hash_ = 0;
  std::uint32_t resets_ = 0;
};

}  // namespace touchstone::station
