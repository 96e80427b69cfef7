#include "touchstone/examples/station/flight/guarded_method.hpp"

#include <algorithm>

#include "touchstone/contact_core/broadphase/register_broadphases.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/contact_core/native/native.hpp"

namespace touchstone::station {
namespace {

using physics::Contact;
using physics::JointDrive;

constexpr std::size_t kMostEvents = 4096;  // of a frame
/// Forces below this do not hold an arm back [N].
constexpr double kLeastForce = 1.0;

/// Said once a pair at a frame's end; the others whenever they happen.
bool is_of_end(EventKind kind) {
  return kind == EventKind::near || kind == EventKind::persists || kind == EventKind::blocked;
}

}  // namespace

GuardedMethod::GuardedMethod(const training::Setting& setting, const StationDynamics& dynamics)
    : setting_(&setting),
      dynamics_(&dynamics),
      settings_(dynamics.settings),
      formation_(setting.object_count()) {
  const training::Arm& arm = setting.arms()[0];
  value_of_.resize(arm.joints.size());
  make_run(dynamics.scene);
  X_WO_.resize(setting.object_count());
  joints_ = before_ = goals_ = arm.joints;
  torques_.assign(joints_.size(), 0.0);
  events_.reserve(kMostEvents);
  pushing_.reserve(kMostPushing);
  take_state();
}

/// The one before ends.
void GuardedMethod::make_run(const physics::DynamicScene& scene) {
  run_ = std::make_unique<physics::GuardedSimulation>(scene, settings_, make_native, make_native_broadphase);
  const Mechanism& inside = run_->simulation().dynamics_of(0).mechanism();
  for (const Mechanism::Joint& joint : setting_->arms()[0].mechanism->joints())
    for (const Mechanism::Joint& same : inside.joints())
      if (joint.value != Mechanism::kNone && same.name == joint.name) value_of_[joint.value] = same.value;
}

void GuardedMethod::set_base(const training::Arm& arm) {
  auto walked = std::make_unique<const physics::DynamicScene>(go_on_from(*run_, *dynamics_, *setting_, arm));
  make_run(*walked);
  walked_ = std::move(walked);
  for (std::uint32_t i = 0; i < setting_->object_count(); ++i)
    if (!formation_.is_on[i]) run_->select(i, false);
  // The last frame's name objects of the run before.
  events_.clear();
  pushing_.clear();
  take_state();
}

void GuardedMethod::set_policy(physics::GuardPolicy policy) {
  settings_.policy = policy;
  run_->set_policy(policy);
}

void GuardedMethod::hold_free_end(bool is_held) {
  if (is_held)
    run_->dynamics().join_as_they_stand(0);
  else
    run_->dynamics().switch_joint(0, false);
}

void GuardedMethod::act(const training::Action& action) {
  using Kind = OperatorAction::Kind;
  bool is_done = true;
  if (action.kind == Kind::latch) {
    const auto& options = dynamics_->scene.latch_options;
    const auto found =
        std::find_if(options.begin(), options.end(), [&](const physics::SceneLatchOption& each) {
          return each.carrier == action.carrier && each.carried == action.object;
        });
    is_done = found != options.end() && run_->latch_now(static_cast<std::size_t>(found - options.begin()));
  }
  if (action.kind == Kind::release) is_done = run_->release_now(action.object);
  if (action.kind == Kind::switch_on || action.kind == Kind::switch_off)
    run_->select(action.object, action.kind == Kind::switch_on);
  if (!is_done)
    throw InputError("dynamics refuses that latch or release of " + setting_->object_name(action.object));
  formation_.apply(action, X_WO_);
}

/// Rates that lead to the goals at the frame's end; brakes hold with what drives may give at most.
void GuardedMethod::drive(std::span<const double> goals) {
  for (const Mechanism::Joint& joint : setting_->arms()[0].mechanism->joints()) {
    const std::uint32_t value = joint.value;
    if (value == Mechanism::kNone) continue;
    JointDrive drive;
    const bool is_braked = holds_ || (value < JointFaults::kMost && (faults_.braked >> value & 1U) != 0);
    drive.mode = is_braked ? JointDrive::Mode::brake : JointDrive::Mode::rate;
    drive.rate = (goals[value] - joints_[value]) * setting_->scene().frame_rate;
    drive.limit = joint.effort;
    if (!is_braked && value < JointFaults::kMost && faults_.torque_share[value] < 1.0)
      drive.limit = faults_.torque_share[value] * joint.effort;
    run_->dynamics().set_drive(0, value_of_[value], drive);
  }
}

void GuardedMethod::take_step(bool is_last) {
  for (const ContactEvent& event : run_->proof().events) {
    if (events_.size() + 1 >= kMostEvents) break;
    if (is_of_end(event.kind) && !is_last) continue;
    const auto is_same = [&](const ContactEvent& other) {
      return other.kind == EventKind::began && event.kind == EventKind::persists && other.a == event.a &&
             other.b == event.b && other.solids == event.solids;
    };
    const auto begun = std::find_if(events_.begin(), events_.end(), is_same);
    if (begun != events_.end())
      begun->geometry_at_end = event.geometry_at_end;
    else
      events_.push_back(event);
  }
}

void GuardedMethod::take_forces() {
  const physics::SceneSimulation& simulation = run_->simulation();
  const double share = 1.0 / static_cast<double>(dynamics_->steps);
  pushing_.clear();
  for (std::size_t i = 0; i < simulation.contacts().size(); ++i) {
    const Contact& contact = simulation.contacts()[i];
    const Vector3& force_W = simulation.forces()[i].force_W;
    const double force = norm(force_W);
    if (is_of_arm(contact.a) != is_of_arm(contact.b)) force_ += share * force;
    if (force == 0.0 || pushing_.size() == kMostPushing) continue;
    const physics::ContactOrigin& origin = simulation.detection().origins()[i];
    pushing_.push_back(
        {origin.solids, contact.p_A_W, contact.n_AB_W, origin.separation + run_->gap(), force_W});
  }
  const std::span<const double> torques = simulation.world().joint_torques(0);
  for (std::size_t i = 0; i < torques_.size(); ++i) torques_[i] += share * torques[value_of_[i]];
}

/// Forces, not the proof, stop an arm here: that it is held back shows in what it did not do.
void GuardedMethod::add_stall(std::span<const double> goals) {
  // An arm stalls where it went less than half of what was asked, and presses on something.
  double asked = 0.0, done = 0.0;
  for (std::size_t i = 0; i < goals.size(); ++i) {
    asked += (goals[i] - before_[i]) * (goals[i] - before_[i]);
    done += (goals[i] - before_[i]) * (joints_[i] - before_[i]);
  }
  if (asked == 0.0 || !(done < 0.5 * asked) || !(force_ > kLeastForce)) return;
  // The contact that presses hardest on it is what blocks.
  const auto is_arms = [&](const PushingContact& contact) {
    return setting_->arm_of(formation_.root_of(setting_->instance().object_of(contact.solids.a))) !=
           setting_->arm_of(formation_.root_of(setting_->instance().object_of(contact.solids.b)));
  };
  const PushingContact* hardest = nullptr;
  for (const PushingContact& contact : pushing_)
    if (is_arms(contact) && (hardest == nullptr || norm(contact.force_W) > norm(hardest->force_W)))
      hardest = &contact;
  if (hardest == nullptr) return;
  // Its event is repeated as a stop.
  for (const ContactEvent& event : events_) {
    if (event.kind != EventKind::began && event.kind != EventKind::persists) continue;
    const SolidIndex a = setting_->instance().first_solid(object_of(event.a)) + event.solids.a,
                     b = setting_->instance().first_solid(object_of(event.b)) + event.solids.b;
    if (std::min(a, b) != std::min(hardest->solids.a, hardest->solids.b) ||
        std::max(a, b) != std::max(hardest->solids.a, hardest->solids.b))
      continue;
    ContactEvent stop = event;
    stop.kind = EventKind::blocked;
    events_.push_back(stop);
    return;
  }
}

void GuardedMethod::take_state() {
  for (std::size_t i = 0; i < X_WO_.size(); ++i) X_WO_[i] = run_->shown_pose(i);
  const std::span<const double> q = run_->simulation().world().joint_values(0);
  for (std::size_t i = 0; i < joints_.size(); ++i) joints_[i] = q[value_of_[i]];
}

void GuardedMethod::log_events(training::FlightLog& log) const {
  for (const ContactEvent& event : events_) {
    training::LoggedEvent logged{frame_, event.kind, {0, 0}, event.s, event.geometry.separation};
    if (event.kind != EventKind::refused && event.kind != EventKind::at_limit) {
      const SceneInstance& instance = setting_->instance();
      logged.solids = {instance.first_solid(object_of(event.a)) + event.solids.a,
                       instance.first_solid(object_of(event.b)) + event.solids.b};
      if (logged.solids.b < logged.solids.a) std::swap(logged.solids.a, logged.solids.b);
    }
    log.add(logged);
  }
}

void GuardedMethod::frame(std::span<const training::Command>,
                          std::span<const training::ArmCommand> arm_commands,
                          training::FlightLog& log) noexcept {
  // Joints without a command hold where they are.
  std::copy(joints_.begin(), joints_.end(), goals_.begin());
  for (const training::ArmCommand& command : arm_commands)
    std::copy(command.values.begin(), command.values.end(), goals_.begin());
  std::copy(joints_.begin(), joints_.end(), before_.begin());
  drive(goals_);
  events_.clear();
  force_ = 0.0;
  std::fill(torques_.begin(), torques_.end(), 0.0);
  // The frame's steps of dynamics; the first that fails ends it.
  for (std::size_t i = 0; i < dynamics_->steps; ++i) {
    const physics::GuardedStep step = run_->step();
    if (step.dynamics.failure != physics::StepFailure::none) {
      ++failed_;
      failure_ = physics::reason_of(step.dynamics.failure);
      break;
    }
    take_step(i + 1 == dynamics_->steps);
    take_forces();
    log.queries += run_->proof().queries;
    log.iteration_limits += run_->proof().iteration_limits;
  }
  take_state();
  add_stall(goals_);
  log_events(log);
  ++frame_;
}

}  // namespace touchstone::station
