#pragma once

#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "touchstone/examples/compare_backends/run/scenes/round_reference.hpp"
#include "touchstone/examples/compare_backends/run/sets/options.hpp"
#include "touchstone/examples/measures/pairs/pair_set.hpp"

namespace touchstone::comparison {

/// A scene file stepped through time, as a pair set. Ids are "stem:frame:pair".
struct SceneFrames {
  PairSet set;
  std::vector<double> times;         ///< of the frames [s]
  std::vector<std::size_t> numbers;  ///< of the frames, among all_frames
  std::string description;
  double rate = 0, duration = 0, gap = 0;
  bool has_facets = false;                   ///< a parameter of that name
  std::vector<Tube> tubes;                   ///< the round parts behind the facets
  int cover_levels = 0;                      ///< see with_covers()
  std::size_t all_frames = 0;                ///< that the scene has
  std::map<std::string, double> parameters;  ///< in the file's units
};
/// The frames of a scene file at its rate; at most `most_frames`, evenly spread, when that is not 0.
/// @throws InputError naming file, line and object; also in a build without the scene_files adapter.
SceneFrames load_scene_frames(const std::string& file, const std::map<std::string, double>& parameters = {},
                              std::size_t most_frames = 0);

/// The scene's cases: pairs of all frames. @throws InputError naming the file, as load_scene_frames, and for
/// more than there is room for.
double check_scene_length(const std::string& file, const std::map<std::string, double>& parameters,
                          std::size_t most_frames);

/// The given frames of a scene file, by their numbers among all_frames.
/// @param cover_level as with_covers(); empty: the hexahedra as written.
SceneFrames load_scene_frames(const std::string& file, const std::map<std::string, double>& parameters,
                              std::span<const std::size_t> numbers, std::optional<int> cover_level = {});

/// `count` of `all` frames, evenly spread from the first to the last.
std::vector<std::size_t> spread_frames(std::size_t all, std::size_t count);

/// The settings that concern this file.
/// @throws InputError when one names this scene and a parameter that it does not have.
std::map<std::string, double> parameters_for(const std::string& file, std::span<const SceneSetting> settings);

/// @throws InputError when a setting concerns none of the files.
void check_settings(std::span<const std::string> files, std::span<const SceneSetting> settings);

}  // namespace touchstone::comparison
