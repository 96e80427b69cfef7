#pragma once

#include <string>

#include "touchstone/examples/station/flight/session.hpp"

namespace touchstone::station {

inline constexpr std::uint32_t kOurs = 1U << static_cast<unsigned>(MethodKind::ours);
using Kind = Control::Kind;

/// Bundled scenes at 50 Hz.
inline StationScenes bundled(const std::vector<std::string>& names, double rate = 50.0) {
  StationScenes scenes;
  for (const std::string& name : names)
    scenes.push_back(load_station_scene(std::string(STATION_SCENES) + "/" + name + ".yaml", rate));
  return scenes;
}

/// The hand's x axis comes out of the end effector's mouth: towards what it shall grapple.
inline HandInput ahead(double rate) {
  HandInput hand;
  hand.translation = {rate, 0.0, 0.0};
  return hand;
}

}  // namespace touchstone::station
