#include "touchstone/examples/station/server/loop.hpp"

#include <algorithm>
#include <chrono>
#include <thread>

#include "touchstone/contact_core/geometry/quaternion.hpp"
#include "touchstone/examples/measures/common/allocations.hpp"
#include "touchstone/examples/station/messages/frame_message.hpp"

namespace touchstone::station {
namespace {

using Kind = StationEvent::Kind;

StationEvent::Kind kind_of(const Control& control, const ControlAnswer& answer) {
  if (!answer.done) return Kind::note;
  switch (control.kind) {
    case Control::Kind::latch:
      return Kind::latched;
    case Control::Kind::release:
      return Kind::released;
    case Control::Kind::reset:
    case Control::Kind::methods:
    case Control::Kind::dynamics:
      return Kind::reset;
    case Control::Kind::scene:
      return Kind::scene;
    case Control::Kind::joint_brake:
    case Control::Kind::late_report:
    case Control::Kind::torque_loss:
      return Kind::fault;
    default:
      return Kind::note;
  }
}

}  // namespace

StationLoop::StationLoop(Session& session, Exchange& exchange, MergeJudge& judge, Recorder* recorder,
                         LiveOutputs* outputs)
    : session_(session), exchange_(exchange), judge_(judge), recorder_(recorder), outputs_(outputs) {
  push_state(true);
}

void StationLoop::record(const RecordedInput& input) {
  if (recorder_ == nullptr) return;
  recorder_->offer(input);
  exchange_.figures.not_recorded.store(recorder_->lost(), std::memory_order_relaxed);
}

void StationLoop::push_event(const StationEvent& event) {
  if (!exchange_.events.push(event)) exchange_.figures.events_lost.fetch_add(1, std::memory_order_relaxed);
}

void StationLoop::tell(const Control& control, const ControlAnswer& answer) {
  if (answer.text.empty()) return;
  StationEvent event;
  event.kind = kind_of(control, answer);
  event.frame = session_.frame();
  event.time = session_.time();
  std::copy_n(answer.text.begin(), std::min(answer.text.size(), event.text.size() - 1), event.text.begin());
  push_event(event);
}

void StationLoop::push_state(bool changed) {
  StateMessage* const slot = exchange_.states.slot();
  if (slot == nullptr) return;  // the server has not taken the last one: figures follow later
  StateMessage& state = *slot;
  const Flight& flight = session_.flight();
  state.frame = session_.frame();
  state.scene = session_.scene();
  state.serial = session_.serial();
  state.flight = flight.state();
  state.figures = flight.figures();
  state.changed = changed;
  state.latched_count = state.off_count = 0;
  const training::Formation& formation = flight.ours().formation();
  for (std::uint32_t i = 0; i < formation.carrier.size(); ++i) {
    if (formation.carrier[i] != training::kNone && state.latched_count < StateMessage::kMost)
      state.latched[state.latched_count++] = {formation.carrier[i], i};
    if (!formation.is_on[i] && state.off_count < StateMessage::kMost) state.off[state.off_count++] = i;
  }
  // Where the arm stands, which an arm that walks changes.
  const Stance& stance = flight.stance();
  state.held_count = 0;
  for (std::uint32_t tip = 0; stance.walks() && tip < state.held.size(); ++tip)
    if (stance.is_held(tip)) state.held[state.held_count++] = {tip, stance.fixture_of(tip)};
  if (stance.arm() != nullptr) {
    const Quaternion q = quaternion_of(stance.arm()->X_WB.R);
    state.base = {q.v.x(), q.v.y(), q.v.z(), q.w};
  }
  exchange_.states.push();
}

void StationLoop::take_controls() {
  bool any = false;
  while (const Control* waiting = exchange_.controls.front()) {
    const Control control = *waiting;
    exchange_.controls.pop();
    record({session_.frame(), control});
    ControlAnswer answer;
    try {
      answer = session_.set(control);
    } catch (const std::exception& error) {  // refused by a world: reported, and a replay does the same
      answer = {false, error.what()};
    }
    tell(control, answer);
    any = true;
  }
  if (any) push_state(true);
}

HandInput StationLoop::take_hand(double now) {
  exchange_.hand.take();
  const HandMessage& message = exchange_.hand.front();
  const bool has_let_go = now - message.stamp.received_us > kLetGoAfter;
  const HandInput hand = has_let_go ? HandInput{} : message.hand;
  if (!(hand == in_force_)) {
    record({session_.frame(), hand});
    in_force_ = hand;
  }
  return hand;
}

void StationLoop::tell_contacts() {
  const Flight& flight = session_.flight();
  const Method& mine = session_.flight().methods().back();
  StationEvent out;
  out.frame = session_.frame();
  out.time = session_.time();
  out.method = static_cast<std::uint32_t>(MethodKind::ours);
  out.has_pair = true;
  for (const ContactEvent& event : flight.events()) {
    // A stop is reported when it begins or passes to another pair, not in each frame that it lasts.
    const bool is_new_stop = event.kind == EventKind::blocked && mine.blocked &&
                             (!was_blocked_ || !(mine.blocked_by == blocked_by_));
    if (event.kind != EventKind::began && event.kind != EventKind::ended &&
        event.kind != EventKind::penetrating_at_start && !is_new_stop)
      continue;
    out.kind = event.kind == EventKind::began   ? Kind::began
               : event.kind == EventKind::ended ? Kind::ended
               : is_new_stop                    ? Kind::blocked
                                                : Kind::penetrating_at_start;
    out.solids = {flight.solid_in_scene(event.a, event.solids.a),
                  flight.solid_in_scene(event.b, event.solids.b)};
    out.separation = event.geometry.separation;
    push_event(out);
    if (is_new_stop) was_blocked_ = true, blocked_by_ = mine.blocked_by;
  }
  was_blocked_ = mine.blocked;
}

void StationLoop::step() {
  FrameFacts facts;
  facts.started_us = station_us();
  const bool sets = exchange_.controls.front() != nullptr;
  if (sets) take_controls();
  const auto before = measures::thread_allocations();
  const HandInput hand = take_hand(facts.started_us);
  facts.input = exchange_.hand.front().stamp;
  facts.has_input = facts.input.client != 0;
  session_.step(hand);
  facts.decided_us = station_us();
  if (facts.has_input && !(facts.input.client == obeyed_.client && facts.input.number == obeyed_.number)) {
    exchange_.figures.answer.add(facts.decided_us - facts.input.received_us);
    obeyed_ = facts.input;
  }
  judge_.offer(session_);
  LoopFigures& figures = exchange_.figures;
  facts.missed = figures.missed.load(std::memory_order_relaxed);
  write_frame(session_, judge_.take(), facts, exchange_.frame.back());
  exchange_.frame.publish();
  if (outputs_ != nullptr) outputs_->send(session_);
  tell_contacts();
  // Five times a second, for the score and the path flown.
  const auto between = static_cast<std::uint64_t>(session_.flight().rate() / 5.0);
  if (session_.frame() % between == 0) push_state(false);
  exchange_.wake();
  figures.frame.store(session_.frame(), std::memory_order_relaxed);
  figures.not_judged.store(judge_.passed_by(), std::memory_order_relaxed);
  figures.step.add(station_us() - facts.started_us);
  const auto after = measures::thread_allocations();
  if (before && after) figures.allocations.fetch_add(*after - *before, std::memory_order_relaxed);
}

void StationLoop::run(const std::atomic<bool>& stop, std::uint64_t frames) {
  using Clock = std::chrono::steady_clock;
  const auto period = std::chrono::duration_cast<Clock::duration>(
      std::chrono::duration<double>(1.0 / session_.flight().rate()));
  Clock::time_point due = Clock::now();
  for (std::uint64_t flown = 0; !stop.load(std::memory_order_relaxed) && (frames == 0 || flown < frames);
       ++flown) {
    step();
    due += period;
    const Clock::time_point now = Clock::now();
    if (now > due) {
      exchange_.figures.missed.fetch_add(1, std::memory_order_relaxed);
      due = now;
    }
    std::this_thread::sleep_until(due);
  }
}

}  // namespace touchstone::station
