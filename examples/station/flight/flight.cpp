#include "touchstone/examples/station/flight/flight.hpp"

#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>

#include "touchstone/contact_core/broadphase/register_broadphases.hpp"
#include "touchstone/contact_core/geometry/quaternion.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/contact_core/native/native.hpp"

namespace touchstone::station {
namespace {

using training::Action;
using training::Arm;
using training::kNone;

/// FNV's 64-bit prime and offset, over words.
constexpr std::uint64_t kHashPrime = 0x100000001b3, kHashStart = 0xcbf29ce484222325;

double clock_us() noexcept {
  const std::chrono::duration<double, std::micro> now = std::chrono::steady_clock::now().time_since_epoch();
  return now.count();
}

Vector3 clamped(const Vector3& axes) {
  return {std::clamp(axes.x(), -1.0, 1.0), std::clamp(axes.y(), -1.0, 1.0), std::clamp(axes.z(), -1.0, 1.0)};
}

std::unique_ptr<training::Method> make_method(MethodKind kind, const training::Setting& setting,
                                              double report_delay) {
  switch (kind) {
    case MethodKind::unchecked:
      return training::make_unchecked_method(setting);
    case MethodKind::late_report:
      return training::make_late_report_method(setting, report_delay);
    case MethodKind::first_build:
      return training::make_first_build_method(setting);
    case MethodKind::ours:
      break;
  }
  return std::make_unique<training::ContactWorldMethod>(setting, make_native(), make_native_broadphase());
}

/// By tip; of an arm that walks of the one that is free.
std::vector<training::ArmHand> make_hands(const Stance& stance, const StationScene& scene) {
  std::vector<training::ArmHand> hands;
  if (stance.walks()) {
    hands.emplace_back(*stance.arm(), scene.tips[stance.flown(0)].link);
    return hands;
  }
  for (const Tip& tip : scene.tips) hands.emplace_back(*stance.arm(), tip.link);
  return hands;
}

}  // namespace

Method::Method(MethodKind given, std::unique_ptr<training::Method> given_method, const StationScene& scene)
    : kind(given), flown(std::move(given_method)), stance(scene), log(scene.setting) {
  log.slide_steps.assign(1, 0);
  if (scene.arm() != nullptr) {
    hands = make_hands(stance, scene);
    goals.assign(scene.arm()->joints.begin(), scene.arm()->joints.end());
  }
}

Flight::Flight(const StationScene& scene, std::uint32_t methods, bool dynamics)
    : scene_(&scene), ghost_poses_(scene.setting.object_count()), near_(scene.setting), hash_(kHashStart) {
  state_.methods = methods | 1U << static_cast<unsigned>(MethodKind::ours);
  state_.policy = scene.setting.scene().policy;
  state_.dynamics = dynamics && scene.dynamics != nullptr;
  if (scene.dynamics) state_.guard = scene.dynamics->settings.policy;
  if (const Arm* arm = scene.arm()) {
    ghost_joints_ = ghost_next_ = arm->joints;
    ghost_links_.resize(arm->mechanism->links().size());
  }
  ghost_next_poses_ = ghost_poses_;
  commands_.reserve(1);
  arm_commands_.reserve(1);
  make_methods();
}

const Method* Flight::method(MethodKind kind) const {
  for (const Method& method : methods_)
    if (method.kind == kind) return &method;
  return nullptr;
}

void Flight::make_methods() {
  std::vector<Method> methods;
  for (std::size_t i = 0; i < kMethods; ++i) {
    if (!(state_.methods >> i & 1U)) continue;
    const auto kind = static_cast<MethodKind>(i);
    std::unique_ptr<training::Method> flown;
    if (state_.dynamics && kind == MethodKind::ours)
      flown = std::make_unique<GuardedMethod>(scene_->setting, *scene_->dynamics);
    else
      flown = make_method(kind, scene_->setting, state_.report_delay);
    methods.emplace_back(kind, std::move(flown), *scene_);
    for (const Action& action : scene_->initial) act(methods.back(), action);
  }
  methods_ = std::move(methods);
  ours_ = methods_.back().flown.get();
  guarded_ = state_.dynamics ? static_cast<GuardedMethod*>(ours_) : nullptr;
  world_ = state_.dynamics ? nullptr : static_cast<training::ContactWorldMethod*>(ours_);
  tell_policy();
  for (Method& method : methods_)
    method.formation = std::make_shared<const training::Formation>(method.flown->formation());
  state_.tip = stance().flown(state_.tip);
  figures_ = {};
  start_ghost();
  near_.find(tip().object, ours_->poses(), ours_->formation());
}

/// Where `ours` stands.
void Flight::start_ghost() {
  ghost_hands_.clear();
  if (scene_->arm() != nullptr) ghost_hands_ = make_hands(stance(), *scene_);
  const std::span<const double> joints = methods_.back().joints();
  std::copy(joints.begin(), joints.end(), ghost_joints_.begin());
  for (training::ArmHand& hand : ghost_hands_) hand.start_from(ghost_joints_);
  place_ghost();
}

void Flight::act(Method& method, const Action& action) {
  method.flown->act(action);
  method.formation = std::make_shared<const training::Formation>(method.flown->formation());
}

// ---- between frames

ControlAnswer Flight::set(const Control& control) {
  using Kind = Control::Kind;
  const auto joints = static_cast<std::uint32_t>(ghost_joints_.size());
  switch (control.kind) {
    // How commands are meant.
    case Kind::frame_of_command:
      state_.frame = static_cast<CommandFrame>(control.index);
      state_.camera = control.attitude;
      return {};
    case Kind::vernier:
      state_.vernier = control.on;
      return {};
    case Kind::brakes:
      state_.brakes = control.on;
      return {};
    case Kind::joint_mode:
      if (control.on && control.index >= joints) return {false, "no joint " + std::to_string(control.index)};
      state_.joint_mode = control.on;
      start_hands();
      if (control.on) state_.joint = control.index;
      return {};
    // Latches and selections.
    case Kind::latch:
      return latch(control.index);
    case Kind::release:
      return release();
    case Kind::reset:
      return reset("reset");
    case Kind::select:
      return select(control.index, control.on);
    // Methods, policies and faults; some begin the flight anew.
    case Kind::methods:
      state_.methods = (control.index & kAllMethods) | 1U << static_cast<unsigned>(MethodKind::ours);
      return reset("methods chosen; reset");
    case Kind::policy:
      return set_policy(control.index);
    case Kind::joint_brake:
    case Kind::torque_loss:
      return break_joint(control);
    case Kind::dynamics:
      return set_dynamics(control.on);
    case Kind::tip:
      return set_tip(control.index);
    case Kind::late_report:
      if (!(control.value >= 0.0 && control.value <= training::kLongestDelay))
        return {false, "no such delay"};
      state_.report_delay = control.value;
      return reset("report delay set; reset");
    case Kind::scene:
      break;
  }
  return {false, "not a control of a flight"};
}

ControlAnswer Flight::reset(std::string text) {
  make_methods();
  ++resets_;
  return {true, std::move(text)};
}

void Flight::tell_policy() {
  if (guarded_) return guarded_->set_policy(state_.guard);
  world_->world().set_default_rule(
      {state_.policy, {}, scene_->setting.script().translation_only, scene_->setting.scene().passive});
  world_->world().prepare();
}

/// The first four are the same with dynamics and without; `push` needs forces.
ControlAnswer Flight::set_policy(std::uint32_t policy) {
  if (policy == kPush && !state_.dynamics) return {false, "push needs dynamics"};
  if (policy != kPush && policy > static_cast<std::uint32_t>(ContactPolicy::slide))
    return {false, "no such policy"};
  if (state_.dynamics)
    state_.guard = policy == kPush ? physics::GuardPolicy::push : static_cast<physics::GuardPolicy>(policy);
  else
    state_.policy = static_cast<ContactPolicy>(policy);
  tell_policy();
  return {true,
          "policy " + std::string(state_.dynamics ? to_string(state_.guard) : to_string(state_.policy))};
}

ControlAnswer Flight::set_dynamics(bool on) {
  if (on && !scene_->dynamics) return {false, "this scene has no dynamics"};
  state_.dynamics = on;
  return reset(on ? "dynamics on; reset" : "dynamics off; reset");
}

ControlAnswer Flight::set_tip(std::uint32_t tip) {
  if (tip >= scene_->tips.size()) return {false, "no tip " + std::to_string(tip)};
  if (stance().flown(tip) != tip) return {false, "the arm stands on " + scene_->tips[tip].name};
  state_.tip = tip;
  state_.joint_mode = false;
  start_hands();
  near_.find(this->tip().object, ours_->poses(), ours_->formation());
  const std::string& name = scene_->tips[tip].name;
  return {true, stance().is_locked() ? name + " is the end to be let go" : "the hand flies " + name};
}

/// Hands go on from where joint mode or another tip's hand has left the arm.
void Flight::start_hands() {
  for (Method& method : methods_)
    for (training::ArmHand& hand : method.hands) hand.start_from(method.joints());
  for (training::ArmHand& hand : ghost_hands_) hand.start_from(ghost_joints_);
}

ControlAnswer Flight::break_joint(const Control& control) {
  const std::string joint = std::to_string(control.index);
  if (control.index >= std::min(ghost_joints_.size(), JointFaults::kMost))
    return {false, "no joint " + joint};
  if (control.kind == Control::Kind::joint_brake) {
    state_.joints.braked = (state_.joints.braked & ~(1U << control.index)) | static_cast<unsigned>(control.on)
                                                                                 << control.index;
    return {true, (control.on ? "brake stuck on joint " : "brake freed on joint ") + joint};
  }
  if (!state_.dynamics) return {false, "a loss of torque needs dynamics"};
  if (!(control.value >= 0.0 && control.value <= 1.0)) return {false, "no such share of a torque"};
  state_.joints.torque_share[control.index] = control.value;
  return {true, "joint " + joint + " has " + std::to_string(std::lround(100.0 * control.value)) +
                    " % of its torque"};
}

ControlAnswer Flight::select(std::uint32_t object, bool on) {
  if (object >= scene_->setting.object_count()) return {false, "no object " + std::to_string(object)};
  const auto kind = on ? OperatorAction::Kind::switch_on : OperatorAction::Kind::switch_off;
  for (Method& method : methods_) act(method, {kind, 0.0, object, kNone, {}});
  return {true, scene_->setting.object_name(object) + (on ? " switched on" : " switched off")};
}

bool Flight::touches(const Tip& tip, std::uint32_t object, std::span<const Pose> poses) noexcept {
  return std::all_of(tip.jaws.begin(), tip.jaws.end(),
                     [&](const Jaw& jaw) { return near_.between(jaw.object, object, poses) <= kGripReach; });
}

/// Jaws must hold what their tool latches, and only the flown tip latches.
bool Flight::may_latch(const LatchOption& option, const Method& method, std::uint32_t object) {
  if (object != Control::kAny && object != option.carried) return false;
  if (method.flown->formation().carrier[option.carried] != kNone) return false;
  for (const Tip& each : scene_->tips) {
    if (each.object != option.carrier) continue;
    return &each == &tip() && touches(each, option.carried, method.flown->poses());
  }
  return true;
}

const LatchOption* Flight::nearest_option(const Method& method, std::uint32_t object) {
  const LatchOption* best = nullptr;
  double least = kLatchReach;
  for (const LatchOption& option : scene_->latches) {
    if (!may_latch(option, method, object)) continue;
    const double separation = near_.between(option.carrier, option.carried, method.flown->poses());
    if (!(separation <= least)) continue;
    least = separation;
    best = &option;
  }
  return best;
}

bool Flight::carries(const Method& method, std::uint32_t carrier) {
  const std::vector<std::uint32_t>& by = method.flown->formation().carrier;
  return std::find(by.begin(), by.end(), carrier) != by.end();
}

/// By a fixture that the free end of an arm that walks is over. None: there is nothing of that here.
std::optional<ControlAnswer> Flight::hold(std::uint32_t object) {
  std::optional<ControlAnswer> answer;
  for (Method& method : methods_) {
    const std::uint32_t tip = method.stance.flown(state_.tip);
    if (!method.stance.walks() || method.stance.is_locked() || carries(method, scene_->tips[tip].object))
      continue;
    const std::uint32_t fixture = method.stance.within_reach(tip, method.flown->poses());
    if (fixture == kNone || (object != Control::kAny && object != fixture)) continue;
    method.stance.hold(tip, fixture);
    if (method.kind != MethodKind::ours) continue;
    if (guarded_) guarded_->hold_free_end(true);
    answer = {true, scene_->setting.object_name(fixture) + " holds " + scene_->tips[tip].name +
                        ": both ends are held"};
  }
  return answer;
}

/// The chosen end, where both are held. None: there is nothing of that here.
std::optional<ControlAnswer> Flight::let_go() {
  if (!stance().walks()) return std::nullopt;
  const std::string& name = scene_->tips[state_.tip].name;
  const bool is_locked = stance().is_locked();
  for (Method& method : methods_)
    if (method.stance.is_locked()) walk(method);
  if (!is_locked) return std::nullopt;
  start_ghost();
  tell_policy();
  near_.find(tip().object, ours_->poses(), ours_->formation());
  return ControlAnswer{true, name + " is let go: the arm stands on " + scene_->tips[1 - state_.tip].name};
}

/// The same world: where the base is let go, the other end is the base from now on.
void Flight::walk(Method& method) {
  std::unique_ptr<const Arm> walked =
      method.stance.stand_without(state_.tip, method.flown->poses(), method.joints());
  if (walked)
    method.flown->set_base(*walked);
  else if (guarded_ && method.kind == MethodKind::ours)
    guarded_->hold_free_end(false);
  method.stance.let_go(state_.tip, std::move(walked));
  method.hands = make_hands(method.stance, *scene_);
  for (training::ArmHand& hand : method.hands) hand.start_from(method.joints());
}

ControlAnswer Flight::latch(std::uint32_t object) {
  if (const std::optional<ControlAnswer> held = hold(object)) return *held;
  ControlAnswer answer{false, tip().jaws.empty() ? "nothing within reach of the latch"
                                                 : "the jaws hold nothing that may be latched"};
  // All methods are asked before any changes.
  std::array<const LatchOption*, kMethods> options{};
  for (std::size_t i = 0; i < methods_.size(); ++i) {
    const LatchOption* const option = options[i] = nearest_option(methods_[i], object);
    if (option != nullptr && methods_[i].flown->formation().root_of(option->carrier) == option->carried)
      return {false, scene_->setting.object_name(option->carried) + " carries " +
                         scene_->setting.object_name(option->carrier) + ": a latch would close a cycle"};
  }
  for (std::size_t i = 0; i < methods_.size(); ++i) {
    Method& method = methods_[i];
    const LatchOption* const option = options[i];
    if (option == nullptr) continue;
    act(method, {OperatorAction::Kind::latch, 0.0, option->carried, option->carrier, option->allowed});
    if (method.kind == MethodKind::ours)
      answer = {true, scene_->setting.object_name(option->carrier) + " carries " +
                          scene_->setting.object_name(option->carried)};
  }
  return answer;
}

ControlAnswer Flight::release() {
  if (const std::optional<ControlAnswer> let = let_go()) return *let;
  ControlAnswer answer{false, "nothing is carried"};
  for (Method& method : methods_)
    for (const LatchOption& option : scene_->latches) {
      if (method.flown->formation().carrier[option.carried] != option.carrier) continue;
      const auto is_carrier = [&](const Tip& each) { return each.object == option.carrier; };
      const bool is_a_tips = std::any_of(scene_->tips.begin(), scene_->tips.end(), is_carrier);
      if (is_a_tips && !is_carrier(tip())) continue;
      act(method, {OperatorAction::Kind::release, 0.0, option.carried, kNone, {}});
      if (method.kind == MethodKind::ours)
        answer = {true, scene_->setting.object_name(option.carried) + " released"};
    }
  return answer;
}

// ---- frames

HandRates Flight::rates_of(const HandInput& input) const noexcept {
  HandRates rates;
  if (state_.brakes || state_.joint_mode) return rates;
  rates.velocity =
      (state_.vernier ? scene_->scales.vernier : scene_->scales.coarse) * clamped(input.translation);
  rates.turn =
      (state_.vernier ? scene_->scales.vernier_turn : scene_->scales.coarse_turn) * clamped(input.rotation);
  rates.mode = state_.frame == CommandFrame::end_effector ? HandRates::Mode::hand : HandRates::Mode::world;
  Matrix3 R = Matrix3::Identity();
  if (state_.frame == CommandFrame::base && stance().arm() != nullptr) R = stance().arm()->X_WB.R;
  if (state_.frame == CommandFrame::camera)
    R = rotation_matrix(
        normalized({state_.camera[3], {state_.camera[0], state_.camera[1], state_.camera[2]}}));
  if (rates.mode == HandRates::Mode::world) {
    rates.velocity = rotate(R, rates.velocity);
    rates.turn = rotate(R, rates.turn);
  }
  return rates;
}

void Flight::drive_joint(const Arm& arm, std::span<const double> q, double joint,
                         std::span<double> goals) const noexcept {
  for (const Mechanism::Joint& each : arm.mechanism->joints()) {
    if (each.value != state_.joint || joint == 0.0) continue;
    const double most = each.kind == JointKind::prismatic ? scene_->scales.slide : scene_->scales.joint;
    const double step = std::min(most, each.rate) * std::clamp(joint, -1.0, 1.0) * (1.0 / rate());
    goals[each.value] = std::clamp(q[each.value] + step, each.lower, each.upper);
  }
}

void Flight::move_jaws(const Arm& arm, double grip, std::span<double> goals) const noexcept {
  if (grip == 0.0) return;
  for (const Mechanism::Joint& joint : arm.mechanism->joints())
    for (const Jaw& jaw : tip().jaws) {
      if (joint.value != jaw.value) continue;
      const double step = joint.rate * std::clamp(grip, -1.0, 1.0) / rate();
      goals[jaw.value] = std::clamp(goals[jaw.value] + step, joint.lower, joint.upper);
    }
}

/// The tool holds a latched object: its jaws stay until the release.
void Flight::hold_jaws(std::span<const double> q, Method& method) const noexcept {
  const training::Formation& formation = method.flown->formation();
  for (const LatchOption& option : scene_->latches) {
    if (formation.carrier[option.carried] != option.carrier) continue;
    for (const Tip& each : scene_->tips)
      for (const Jaw& jaw : each.jaws)
        if (each.object == option.carrier) method.goals[jaw.value] = q[jaw.value];
  }
}

void Flight::command_arm(Method& method, const HandRates& rates, const HandInput& input) noexcept {
  const Arm& arm = *method.stance.arm();
  const std::span<const double> q = method.flown->joints().subspan(arm.first_value, method.goals.size());
  std::copy(q.begin(), q.end(), method.goals.begin());
  const double duration = 1.0 / rate();
  if (state_.brakes || method.stance.is_locked()) return;
  if (state_.joint_mode)
    drive_joint(arm, q, input.joint, method.goals);
  else if (!rates.at_rest())
    method.hand(state_.tip).command(q, rates, duration, method.goals);
  move_jaws(arm, input.grip, method.goals);
  hold_jaws(q, method);
  for (std::size_t i = 0; i < method.goals.size(); ++i)
    if (i < JointFaults::kMost && (state_.joints.braked >> i & 1U)) method.goals[i] = q[i];
  if (!std::equal(q.begin(), q.end(), method.goals.begin())) arm_commands_.push_back({&arm, method.goals});
}

void Flight::fly(Method& method, const HandRates& rates, const HandInput& input) noexcept {
  const double start = clock_us();
  if (guarded_ && method.kind == MethodKind::ours)
    guarded_->set_joints(state_.joints, state_.brakes || method.stance.is_locked());
  method.log.events.clear();
  method.log.slide_steps.back() = 0;
  commands_.clear();
  arm_commands_.clear();
  if (!method.hands.empty()) {
    command_arm(method, rates, input);
  } else {
    const std::uint32_t object = tip().object;
    if (!rates.at_rest() && method.flown->formation().carrier[object] == kNone)
      commands_.push_back({object, training::flown(method.flown->poses()[object], rates, 1.0 / rate())});
  }
  method.flown->frame(commands_, arm_commands_, method.log);
  take_log(method);
  method.decide_us = clock_us() - start;
}

void Flight::take_log(Method& method) noexcept {
  method.blocked = method.reports_contact = false;
  for (const training::LoggedEvent& event : method.log.events) {
    const bool reports = event.kind == EventKind::began || event.kind == EventKind::persists ||
                         event.kind == EventKind::penetrating_at_start;
    method.reports_contact = method.reports_contact || reports;
    if (event.kind != EventKind::blocked || method.blocked) continue;
    method.blocked = true;
    method.blocked_by = event.solids;
  }
  method.blocked_frames += method.blocked;
  method.slid = method.log.slide_steps.back() > 0;
}

void Flight::step(const HandInput& input) noexcept {
  const HandRates rates = rates_of(input);
  const std::uint32_t hand = tip().object;
  const Pose X_before = ours_->poses()[hand];
  const bool is_arm = !methods_.back().hands.empty();
  const training::HandFigures before =
      is_arm ? methods_.back().hand(state_.tip).figures() : training::HandFigures{};
  for (Method& method : methods_) fly(method, rates, input);
  if (is_arm) {
    const training::HandFigures& after = methods_.back().hand(state_.tip).figures();
    was_limited_ = after.limited_frames > before.limited_frames;
    was_damped_ = after.damped_frames > before.damped_frames;
  }
  is_at_limit_ =
      std::any_of(methods_.back().log.events.begin(), methods_.back().log.events.end(),
                  [](const training::LoggedEvent& event) { return event.kind == EventKind::at_limit; });
  move_ghost(rates, input.joint);
  near_.find(hand, ours_->poses(), ours_->formation());
  ++frame_;
  add_figures(X_before);
  add_to_hash();
}

/// The commanded pose leads on from where contact stopped the arm, up to the leash; else it is where the arm
/// was commanded to go.
void Flight::move_ghost(const HandRates& rates, double joint) noexcept {
  const Method& mine = methods_.back();
  const bool leads = mine.blocked && !mine.hands.empty() && !rates.at_rest() && joint == 0.0;
  if (leads) {
    ghost_hands_[stance().walks() ? 0 : state_.tip].command(ghost_joints_, rates, 1.0 / rate(), ghost_next_);
    const Arm& arm = *stance().arm();
    arm.mechanism->link_poses(arm.X_WB, ghost_next_, ghost_links_);
    const Pose& X_WG = ghost_links_[arm.link_of_object[tip().object - arm.first_object]];
    const Pose& X_WH = ours_->poses()[tip().object];
    const double turn = axis_angle_of(quaternion_of(X_WH.R.transpose() * X_WG.R)).angle;
    if (norm(X_WG.p - X_WH.p) <= kLeash && turn <= kLeash)
      std::copy(ghost_next_.begin(), ghost_next_.end(), ghost_joints_.begin());
  } else {
    std::copy(mine.goals.begin(), mine.goals.end(), ghost_joints_.begin());
  }
  place_ghost();
}

void Flight::place_ghost() noexcept {
  const std::span<const Pose> actual = ours_->poses();
  std::copy(actual.begin(), actual.end(), ghost_poses_.begin());
  if (!commands_.empty()) ghost_poses_[commands_[0].object] = commands_[0].path.to();
  const Arm* const arm = stance().arm();
  if (arm == nullptr) return;
  arm->mechanism->link_poses(arm->X_WB, ghost_joints_, ghost_links_);
  for (std::uint32_t i = 0; i < arm->object_count; ++i)
    ghost_poses_[arm->first_object + i] = ghost_links_[arm->link_of_object[i]];
  const training::Formation& formation = ours_->formation();
  for (std::uint32_t i = 0; i < ghost_poses_.size(); ++i) {
    const std::uint32_t root = formation.root_of(i);
    if (root != i) ghost_poses_[i] = compose(ghost_poses_[root], formation.X_RO[i]);
  }
}

bool Flight::is_done(const StationTask& task) noexcept {
  using Kind = StationTask::Kind;
  const bool is_carried = ours_->formation().carrier[task.object] != kNone;
  const Tip& tip = scene_->tips[task.tip];
  switch (task.kind) {
    case Kind::carry:
      return is_carried;
    case Kind::bring:
      return is_carried && is_at(task, ours_->poses()[task.object]);
    case Kind::place:
      return !is_carried && is_at(task, ours_->poses()[task.object]);
    case Kind::reach:
      return is_at(task, compose(ours_->poses()[tip.object], tip.X_HT));
    case Kind::grip:
      return touches(tip, task.object, ours_->poses());
    case Kind::hold:
      return stance().fixture_of(task.tip) == task.object;
    case Kind::stand:
      return stance().fixture_of(task.tip) == task.object && !stance().is_locked();
    case Kind::joint:
      break;
  }
  return std::abs(ours_->joints()[task.joint] - task.value) <= task.within;
}

void Flight::add_figures(const Pose& X_before) noexcept {
  figures_.time += 1.0 / rate();
  figures_.tip = transform(ours_->poses()[tip().object], tip().X_HT.p);
  figures_.path += norm(ours_->poses()[tip().object].p - X_before.p);
  const Method& mine = methods_.back();
  for (const training::LoggedEvent& event : mine.log.events)
    figures_.contacts += event.kind == EventKind::began;
  if (mine.reports_contact) figures_.cue_seconds += 1.0 / rate();
  if (guarded_) add_forces();
  for (std::size_t i = 0; i < scene_->tasks.size(); ++i) {
    const StationTask& task = scene_->tasks[i];
    if (figures_.done_at[i] != 0.0 || !is_done(task)) continue;
    figures_.done_at[i] = figures_.time;
    figures_.is_within[i] = figures_.time <= task.most_time && figures_.largest_force <= task.most_force &&
                            figures_.contacts <= task.most_contacts;
  }
}

void Flight::add_forces() noexcept {
  figures_.force = guarded_->contact_force();
  figures_.largest_force = std::max(figures_.largest_force, figures_.force);
  figures_.failed_steps = guarded_->failed_steps();
  figures_.torque_share = 0.0;
  for (const Mechanism::Joint& joint : scene_->arm()->mechanism->joints())
    if (joint.value != Mechanism::kNone && joint.effort > 0.0)
      figures_.torque_share =
          std::max(figures_.torque_share, std::abs(guarded_->torques()[joint.value]) / joint.effort);
}

void Flight::add_to_hash() noexcept {
  const auto add = [this](double value) {
    hash_ = (hash_ ^ std::bit_cast<std::uint64_t>(value)) * kHashPrime;
  };
  for (const Method& method : methods_)
    for (const Pose& X : method.flown->poses()) {
      for (int column = 0; column < 3; ++column)
        for (int row = 0; row < 3; ++row) add(X.R(row, column));
      for (int i = 0; i < 3; ++i) add(X.p[i]);
    }
}

}  // namespace touchstone::station
