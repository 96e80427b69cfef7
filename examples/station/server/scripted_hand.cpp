#include "touchstone/examples/station/server/scripted_hand.hpp"

#include <chrono>
#include <cmath>
#include <numbers>

namespace touchstone::station {
namespace {

/// A sine whose period is given [s].
double sweep(double seconds, double period) { return std::sin(2.0 * std::numbers::pi * seconds / period); }

}  // namespace

HandInput scripted_hand(double seconds) {
  HandInput hand;
  hand.translation = {sweep(seconds, 11.0), sweep(seconds, 17.0), sweep(seconds, 23.0)};
  hand.rotation = {0.5 * sweep(seconds, 13.0), 0.5 * sweep(seconds, 19.0), 0.5 * sweep(seconds, 29.0)};
  return hand;
}

ScriptedHand::ScriptedHand(Server& server, double rate)
    : thread_([this, &server, rate] {
        using Clock = std::chrono::steady_clock;
        const Clock::time_point start = Clock::now();
        for (std::uint32_t number = 1; !stop_; ++number) {
          const std::chrono::duration<double> due(number / rate);
          std::this_thread::sleep_until(start + due);
          server.fly(kScriptClient, number, scripted_hand(due.count()));
        }
      }) {}

ScriptedHand::~ScriptedHand() {
  stop_ = true;
  thread_.join();
}

}  // namespace touchstone::station
