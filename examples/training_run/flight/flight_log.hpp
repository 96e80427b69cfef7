#pragma once

#include <optional>
#include <span>
#include <vector>

#include "touchstone/contact_core/world/contact_world.hpp"
#include "touchstone/examples/training_run/setting/hand.hpp"
#include "touchstone/examples/training_run/setting/setting.hpp"

namespace touchstone::training {

struct LoggedEvent {
  std::uint32_t frame;
  EventKind kind;
  SolidPair solids;   ///< indices in the scene, a < b; {0, 0} for `refused` and `at_limit`
  double s;           ///< within the frame
  double separation;  ///< as the reporting method knows it; NaN where it does not [m]
};

/// All that happened in a flight, for judging and printing after it. Memory is taken before the first frame.
struct FlightLog {
  explicit FlightLog(const Setting& setting);

  std::size_t objects, hands;
  std::size_t values;                    ///< joint values of all arms
  std::size_t frames = 0;                ///< flown
  std::vector<Pose> X_WO;                ///< by frame and object, the start first: what was shown
  std::vector<RigidPath> paths;          ///< by frame and hand: what was commanded; at rest where nothing was
  std::vector<double> joints;            ///< by frame and value, the start first: as shown
  std::vector<double> joint_goals;       ///< by frame and value: as commanded
  std::vector<Formation> formations;     ///< one after each change
  std::vector<std::uint32_t> formation;  ///< by frame: its index
  std::vector<std::uint8_t> slide_steps;  ///< by frame
  std::vector<double> frame_us;           ///< control and check, by the clock on the wall
  std::vector<double> frame_cpu_us;       ///< and by the thread's own, which a busy machine does not lengthen
  std::vector<LoggedEvent> events;
  std::size_t lost_events = 0;  ///< for which there was no room
  std::optional<std::uint64_t> allocations = 0;
  std::uint64_t queries = 0, iteration_limits = 0;
  std::vector<HandFigures> hand_figures;

  std::span<const Pose> shown(std::size_t frame) const {
    return std::span(X_WO).subspan(frame * objects, objects);
  }
  const RigidPath& path(std::size_t frame, std::size_t hand) const { return paths[frame * hands + hand]; }
  std::span<const double> shown_joints(std::size_t frame) const {
    return std::span(joints).subspan(frame * values, values);
  }
  std::span<const double> goals(std::size_t frame) const {
    return std::span(joint_goals).subspan(frame * values, values);
  }
  void add(const LoggedEvent& event) noexcept;
};

}  // namespace touchstone::training
