#include "touchstone/examples/training_run/flight/fly.hpp"

#include <chrono>
#include <thread>

#include "touchstone/contact_core/threads/processor_time.hpp"
#include "touchstone/examples/measures/common/allocations.hpp"

namespace touchstone::training {
namespace {

using Clock = std::chrono::steady_clock;

/// By hand; null: it flies a free object.
std::vector<std::unique_ptr<ArmHand>> make_arm_hands(const Setting& setting) {
  std::vector<std::unique_ptr<ArmHand>> hands(setting.script().hands.size());
  for (const Arm& arm : setting.arms()) hands[arm.hand] = std::make_unique<ArmHand>(arm);
  return hands;
}

/// One flight's loop. What is timed and counted is step(): control, check and log.
class Flight {
 public:
  Flight(const Setting& setting, Method& method, bool in_real_time)
      : setting_(setting),
        method_(method),
        in_real_time_(in_real_time),
        log_(setting),
        hands_(make_arm_hands(setting)) {
    commands_.reserve(hands_.size());
    arm_commands_.reserve(setting.arms().size());
    method_.send(0.0);
  }

  FlightLog take(const measures::Progress& progress) {
    const std::size_t count = setting_.frame_count();
    for (std::size_t frame = 0; frame < count; ++frame) {
      take_actions(frame);
      if (in_real_time_) wait_for(frame);
      const auto before = measures::thread_allocations();
      step(frame);
      const auto after = measures::thread_allocations();
      if (before && after && log_.allocations)
        *log_.allocations += *after - *before;
      else
        log_.allocations.reset();
      if (progress) progress(static_cast<double>(frame + 1) / static_cast<double>(count));
    }
    for (const auto& hand : hands_) log_.hand_figures.push_back(hand ? hand->figures() : HandFigures{});
    return std::move(log_);
  }

 private:
  void take_actions(std::size_t frame) {
    const std::span<const Action> actions = setting_.actions();
    for (; next_action_ < actions.size() && actions[next_action_].time <= setting_.time(frame);
         ++next_action_) {
      method_.act(actions[next_action_]);
      log_.formations.push_back(method_.formation());
    }
  }

  void wait_for(std::size_t frame) const {
    const std::chrono::duration<double> due(setting_.time(frame));
    std::this_thread::sleep_until(start_ + std::chrono::duration_cast<Clock::duration>(due));
  }

  void step(std::size_t frame) noexcept {
    const double duration = setting_.time(frame + 1) - setting_.time(frame);
    log_.slide_steps.push_back(0);
    log_.formation.push_back(static_cast<std::uint32_t>(log_.formations.size() - 1));
    const double cpu_start = processor_us();
    const Clock::time_point start = Clock::now();
    command(frame, duration);
    method_.frame(commands_, arm_commands_, log_);
    const std::chrono::duration<double, std::nano> elapsed = Clock::now() - start;
    log_.frame_us.push_back(1e-3 * elapsed.count());
    log_.frame_cpu_us.push_back(processor_us() - cpu_start);
    log_.X_WO.insert(log_.X_WO.end(), method_.poses().begin(), method_.poses().end());
    log_.joints.insert(log_.joints.end(), method_.joints().begin(), method_.joints().end());
    ++log_.frames;
    method_.send(setting_.time(frame + 1));
  }

  void command(std::size_t frame, double duration) noexcept {
    commands_.clear();
    arm_commands_.clear();
    for (std::size_t i = 0; i < hands_.size(); ++i) {
      if (hands_[i]) continue;
      const std::uint32_t object = setting_.object_of_hand(i);
      const Pose& X_WO = method_.poses()[object];
      const HandRates rates = setting_.rates(i, frame);
      const bool is_flying = !rates.at_rest() && method_.formation().carrier[object] == kNone;
      if (is_flying) commands_.push_back({object, flown(X_WO, rates, duration)});
      log_.paths[frame * hands_.size() + i] = is_flying ? commands_.back().path : RigidPath(X_WO);
    }
    log_.joint_goals.insert(log_.joint_goals.end(), method_.joints().begin(), method_.joints().end());
    for (const Arm& arm : setting_.arms()) command(arm, frame, duration);
  }

  void command(const Arm& arm, std::size_t frame, double duration) noexcept {
    const HandRates rates = setting_.rates(arm.hand, frame);
    if (rates.at_rest()) return;
    const std::span<double> goals =
        std::span(log_.joint_goals).subspan(frame * log_.values + arm.first_value, arm.joints.size());
    hands_[arm.hand]->command(method_.joints().subspan(arm.first_value, goals.size()), rates, duration,
                              goals);
    arm_commands_.push_back({&arm, goals});
  }

  const Setting& setting_;
  Method& method_;
  bool in_real_time_;
  Clock::time_point start_ = Clock::now();
  FlightLog log_;
  std::vector<std::unique_ptr<ArmHand>> hands_;
  std::vector<Command> commands_;
  std::vector<ArmCommand> arm_commands_;
  std::size_t next_action_ = 0;
};

}  // namespace

FlightLog fly(const Setting& setting, Method& method, bool in_real_time, const measures::Progress& progress) {
  return Flight(setting, method, in_real_time).take(progress);
}

}  // namespace touchstone::training
