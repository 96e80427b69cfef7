#pragma once

#include <atomic>

#include "touchstone/examples/station/exchange/exchange_parts.hpp"
#include "touchstone/examples/station/exchange/live_outputs.hpp"
#include "touchstone/examples/station/exchange/merge_judge.hpp"
#include "touchstone/examples/station/exchange/recording.hpp"

namespace touchstone::station {

/// A pilot whose hands held something and who has not been heard of for so long has let go [us].
inline constexpr double kLetGoAfter = 500e3;

/// The fixed-step loop: newest input, decision, frame out. It waits for nobody; steps without a control
/// allocate nothing but what Figure 2's method does.
class StationLoop {
 public:
  /// Keeps references; `recorder` and `outputs` may be null.
  StationLoop(Session& session, Exchange& exchange, MergeJudge& judge, Recorder* recorder,
              LiveOutputs* outputs = nullptr);

  /// One frame now.
  void step();
  /// Frames at the scene's rate until `stop`, or for the number asked. A step that ends after the next is due
  /// is a miss, and the frames after it are not hurried: simulated time falls behind.
  void run(const std::atomic<bool>& stop, std::uint64_t frames = 0);

 private:
  void take_controls();
  HandInput take_hand(double now);
  void tell(const Control& control, const ControlAnswer& answer);
  void tell_contacts();
  void push_event(const StationEvent& event);
  void push_state(bool changed);
  void record(const RecordedInput& input);

  Session& session_;
  Exchange& exchange_;
  MergeJudge& judge_;
  Recorder* recorder_;
  LiveOutputs* outputs_;
  HandInput in_force_;
  InputStamp obeyed_;  // the newest
  bool was_blocked_ = false;
  SolidPair blocked_by_{0, 0};
};

}  // namespace touchstone::station
