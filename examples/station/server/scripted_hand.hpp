#pragma once

#include <atomic>
#include <thread>

#include "touchstone/examples/station/server/server.hpp"

namespace touchstone::station {

/// The scripted hand's input at a time [s] after its start: sweeps of all six axes, none of which repeats
/// with another, full deflection at most.
HandInput scripted_hand(double seconds);

/// Flies a station by itself, on a thread of its own, until its end: for figures of long flights.
class ScriptedHand {
 public:
  /// Keeps a reference. @param rate hands a second [Hz].
  ScriptedHand(Server& server, double rate);
  ~ScriptedHand();
  ScriptedHand(const ScriptedHand&) = delete;
  ScriptedHand& operator=(const ScriptedHand&) = delete;

 private:
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace touchstone::station
