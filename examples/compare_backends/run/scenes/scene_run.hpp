#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "touchstone/examples/compare_backends/judge/gallery.hpp"
#include "touchstone/examples/compare_backends/judge/set_result.hpp"
#include "touchstone/examples/compare_backends/run/scenes/scene_trade.hpp"
#include "touchstone/examples/compare_backends/run/sets/options.hpp"

namespace touchstone::comparison {

/// A backend along a scene's frames.
struct SceneBackend {
  std::string name;
  std::optional<double> first_contact;  ///< time of the first frame in contact [s]
  std::size_t missed_frames = 0;        ///< frames in contact reported clear
  std::size_t phantom_frames = 0;       ///< clear frames reported in contact
  std::size_t undecided_frames = 0;  ///< neither: some pair undecided, failed or unsupported, none in contact
  /// The action of a world that believes this backend at each frame of the commanded motion, from one frame
  /// alone: '.' free, 'b' blocked rightly, 'w' wrongly blocked (contact reported, or not decided, where there
  /// is none), 'm' merged (contact not reported). Empty without truth.
  std::string frame_outcomes;
  /// Exact clearance in the last frame before the first that it would block [m]; NaN: none is.
  double clearance_at_stop = 0;
  /// Largest |least separation - exact least separation| of a frame [m]; NaN: none.
  double worst_clearance_error = 0;
};

struct SceneResult {
  std::string name;
  std::string description;
  std::string file;
  double rate = 0, duration = 0, gap = 0;
  std::map<std::string, double> parameters;  ///< in the file's units
  std::size_t frames = 0, pairs = 0;
  std::size_t all_frames = 0;  ///< more than `frames` when only some were stepped
  std::optional<double> exact_first_contact;
  SetResult set;  ///< every pair of every frame
  std::vector<SceneBackend> backends;
  std::vector<GalleryCase> worst_cases;  ///< each backend's, see collect_cases()
  SceneTrade trade;                      ///< the least that serves; no rows without truth or pairs
};

struct SceneOptions {
  std::map<std::string, double> parameters;
  MeasureOptions measure;
  std::optional<double> max_error;                           ///< [m]
  std::vector<int> facets = {4, 8, 12, 16, 24, 32, 48, 64};  ///< tried beside the scene's own count
  std::size_t trade_frames = 100;  ///< half of them around the first contact, the others evenly spread
  std::size_t most_frames = 0;     ///< of the scene itself, evenly spread; 0: all
};

SceneResult run_scene(const std::string& file, const SceneOptions& options, const Oracle* oracle,
                      const AnswerSet& answer, const Progress& progress = {});

}  // namespace touchstone::comparison
