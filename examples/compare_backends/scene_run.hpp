#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "touchstone/examples/compare_backends/gallery.hpp"
#include "touchstone/examples/compare_backends/options.hpp"
#include "touchstone/examples/compare_backends/set_result.hpp"

namespace touchstone::comparison {

/// A backend along a scene's frames.
struct SceneBackend {
  std::string name;
  std::optional<double> first_contact;  ///< time of the first frame in contact [s]
  std::size_t missed_frames = 0;        ///< frames in contact reported clear
  std::size_t phantom_frames = 0;       ///< clear frames reported in contact
  std::size_t undecided_frames = 0;  ///< neither: some pair undecided, failed or unsupported, none in contact
  /// What a world that believes this backend would do at each frame of the commanded motion, from one frame
  /// alone: '.' free, 'b' blocked rightly, 'w' wrongly blocked (contact reported, or not decided, where there
  /// is none), 'm' merged (contact not reported). Empty without truth.
  std::string frames_told;
  /// Exact clearance in the last frame before the first that it would block [m]; NaN: none is.
  double clearance_at_stop = 0;
  /// Largest |least separation - exact least separation| of a frame [m]; NaN: none.
  double worst_clearance_error = 0;
};

/// A backend, a facet count and a query kind: what a frame costs, and how far its answers are from the exact
/// clearance of the finest facets: distance and manifold by |least separation - d|; a frame whose contact is
/// reported wrongly by |d|.
struct FacetRow {
  std::string backend;
  int facets = 0;
  QueryKind query = QueryKind::overlap;
  std::size_t pairs = 0;
  double frame_ns = 0;  ///< median
  double error = 0;     ///< worst over the frames [m]; +inf where a figure is missing
  bool wrong = false;   ///< this backend has a wrong or missing answer to the query among the scene's cases
  bool serves = false;  ///< error <= budget and not wrong
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
  int finest_facets = 0;                 ///< 0: the scene has no parameter `facets`
  std::size_t facet_frames = 0;
  /// Of these, one after the other around the first contact, or the least clearance where there is none.
  std::size_t facet_frames_near = 0;
  /// Of facet_frames, those whose exact class differs between the fewest and the most facets.
  std::size_t facet_class_frames = 0;
  double facet_budget = 0;  ///< --max-error or the scene's gap [m]
  std::vector<FacetRow> facet_rows;
};

/// The cheapest row of this query that serves; null when none does.
const FacetRow* cheapest_row(const SceneResult& scene, QueryKind query);

/// Fewer frames than this leave more than 5 % of the frames unknown (95 % bound of none).
inline constexpr std::size_t kLeastFacetFrames = 59;
/// Why the facet frames do not bear a recommendation for this query, one line; empty: they do.
std::string thin_evidence(const SceneResult& scene, QueryKind query);

/// Every chosen backend's answers to a set, in this process or a worker.
using AnswerSet = std::function<std::vector<BackendAnswers>(const PairSet&, const MeasureOptions&)>;

/// A scene file stepped through time, as a pair set. Ids are "stem:frame:pair".
struct SceneFrames {
  PairSet set;
  std::vector<double> times;         ///< of the frames [s]
  std::vector<std::size_t> numbers;  ///< of the frames, among all_frames
  std::string description;
  double rate = 0, duration = 0, gap = 0;
  bool has_facets = false;
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
SceneFrames load_scene_frames(const std::string& file, const std::map<std::string, double>& parameters,
                              std::span<const std::size_t> numbers);

/// `count` of `all` frames, evenly spread from the first to the last.
std::vector<std::size_t> spread_frames(std::size_t all, std::size_t count);

/// The settings that concern this file.
/// @throws InputError when one names this scene and a parameter that it does not have.
std::map<std::string, double> parameters_for(const std::string& file, std::span<const SceneSetting> settings);

/// @throws InputError when a setting concerns none of the files.
void check_settings(std::span<const std::string> files, std::span<const SceneSetting> settings);

struct SceneOptions {
  std::map<std::string, double> parameters;
  MeasureOptions measure;
  std::optional<double> max_error;  ///< [m]
  std::vector<int> facets = {4, 8, 12, 16, 24, 32, 48, 64};
  std::size_t facet_frames = 100;  ///< half of them around the first contact, the others evenly spread
  std::size_t most_frames = 0;     ///< of the scene itself, evenly spread; 0: all
};

SceneResult run_scene(const std::string& file, const SceneOptions& options, const Oracle* oracle,
                      const AnswerSet& answer, const Progress& progress = {});

}  // namespace touchstone::comparison
