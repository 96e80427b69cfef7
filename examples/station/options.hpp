#pragma once

#include <optional>

#include "touchstone/examples/robot_files/robot_files.hpp"
#include "touchstone/examples/station/server/server.hpp"
#include "touchstone/examples/training_run/results/outputs.hpp"

namespace touchstone::station {

struct StationOptions {
  ServerSettings server;
  std::string scene;  ///< name, a script's or robot's path; empty: the first bundled one
  std::vector<std::filesystem::path> scripts;  ///< of one's own, or robots, beside the bundled ones
  robot_files::RobotChoices robots;
  double rate = 50.0;  ///< [Hz]
  std::filesystem::path record, replay;
  std::filesystem::path open, open_scene;  ///< a record that the page opens, and what was run; empty: none
  training::OutputOptions outputs;         ///< live, or of a replay
  std::uint32_t methods = kAllMethods;
  double seconds = 0.0;  ///< 0: until a signal
  bool dynamics = false, soak = false;
  std::filesystem::path space_mouse;  ///< spacenav's socket; empty: where it usually is
  bool list = false;
};

/// Nothing: help or the version was asked for. @throws InputError
std::optional<StationOptions> parse_station_options(int argc, const char* const* argv,
                                                    const std::filesystem::path& page);

}  // namespace touchstone::station
