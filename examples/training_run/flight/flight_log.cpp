#include "touchstone/examples/training_run/flight/flight_log.hpp"

#include <algorithm>

namespace touchstone::training {
namespace {

/// A pair in contact writes up to four a frame; room for all pairs, but no more than this many [160 MB].
constexpr std::size_t kMostEvents = 4'000'000;

}  // namespace

FlightLog::FlightLog(const Setting& setting)
    : objects(setting.object_count()), hands(setting.script().hands.size()), values(setting.value_count()) {
  const std::size_t count = setting.frame_count();
  X_WO.reserve((count + 1) * objects);
  for (const SceneObject& object : setting.scene().objects) X_WO.push_back(object.X_WO);
  paths.assign(count * hands, RigidPath());
  joints.reserve((count + 1) * values);
  for (const Arm& arm : setting.arms()) joints.insert(joints.end(), arm.joints.begin(), arm.joints.end());
  joint_goals.reserve(count * values);
  formations.reserve(1 + setting.actions().size());
  formations.emplace_back(objects);
  formation.reserve(count);
  slide_steps.reserve(count);
  frame_us.reserve(count);
  frame_cpu_us.reserve(count);
  events.reserve(std::min(kMostEvents, 64 + 2 * count * setting.pairs().size()));
  hand_figures.reserve(hands);
}

void FlightLog::add(const LoggedEvent& event) noexcept {
  if (events.size() < events.capacity())
    events.push_back(event);
  else
    ++lost_events;
}

}  // namespace touchstone::training
