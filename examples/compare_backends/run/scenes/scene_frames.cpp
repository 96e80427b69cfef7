#include "touchstone/examples/compare_backends/run/scenes/scene_frames.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "touchstone/contact_core/input_error.hpp"

#ifdef TOUCHSTONE_HAS_SCENE_FILES
#include "touchstone/adapters/scene_files/scene_file.hpp"
#include "touchstone/contact_core/scene/scene_instance.hpp"
#include "touchstone/examples/compare_backends/run/scenes/scene_covers.hpp"
#endif

namespace touchstone::comparison {

#ifdef TOUCHSTONE_HAS_SCENE_FILES

namespace {

// A ring's two circles stand one after the other in the figures; its facets are named after it.
std::vector<Tube> tubes_of(const SceneInstance& instance) {
  const std::vector<FacetFigure>& figures = instance.scene().facet_figures;
  std::vector<Tube> tubes;
  for (std::size_t i = 0; i + 1 < figures.size(); i += 2) {
    const FacetFigure &outer = figures[i], &inner = figures[i + 1];
    Tube tube;
    tube.first = find_solids(instance.scene(), outer.object + "/" + outer.hexahedron + ".0").front();
    tube.facets = static_cast<std::size_t>(outer.facets);
    tube.outer_radius = outer.radius;
    tube.inner_radius = inner.radius;
    const auto& vertices = instance.solids()[tube.first].vertices();
    const auto [low, high] = std::minmax_element(
        vertices.begin(), vertices.end(), [](const Vector3& u, const Vector3& v) { return u.z() < v.z(); });
    tube.low = low->z();
    tube.high = high->z();
    tube.offset = std::max(outer.error, inner.error);
    tubes.push_back(tube);
  }
  return tubes;
}

SceneFrames frames_of(const Scene& scene, const std::string& file, std::span<const std::size_t> numbers) {
  for (const SceneObject& object : scene.objects) refuse_rounded(object.tree, "the comparison of backends");
  const SceneInstance instance(scene);
  SceneFrames frames;
  frames.description = scene.description;
  frames.rate = scene.frame_rate;
  frames.duration = scene.duration;
  frames.gap = scene.contact_gap;
  frames.has_facets = scene.parameters.count("facets") > 0;
  frames.parameters = scene.parameters;
  frames.tubes = tubes_of(instance);
  frames.cover_levels = cover_levels(scene);
  // Solids and pairs of all frames.
  PairSet& set = frames.set;
  set.name = std::filesystem::path(file).stem().string();
  set.description = scene.name;
  set.solids.assign(instance.solids().begin(), instance.solids().end());
  set.pairs = instance.checked_pairs();

  // The poses of each.
  frames.all_frames = scene.frame_count();
  frames.numbers.assign(numbers.begin(), numbers.end());
  std::vector<Pose> poses(set.solids.size());
  for (const std::size_t frame : numbers) {
    frames.times.push_back(scene.frame_time(frame));
    instance.poses_at(frames.times.back(), poses);
    set.poses.insert(set.poses.end(), poses.begin(), poses.end());
    for (std::size_t p = 0; p < set.pairs.size(); ++p) {
      set.ids.push_back(set.name + ":" + std::to_string(frame) + ":" + std::to_string(p));
    }
  }
  return frames;
}

}  // namespace

SceneFrames load_scene_frames(const std::string& file, const std::map<std::string, double>& parameters,
                              std::size_t most_frames) {
  const Scene scene = load_scene(file, parameters);
  const std::size_t all = scene.frame_count();
  return frames_of(scene, file, spread_frames(all, most_frames == 0 ? all : std::min(all, most_frames)));
}

SceneFrames load_scene_frames(const std::string& file, const std::map<std::string, double>& parameters,
                              std::span<const std::size_t> numbers, std::optional<int> cover_level) {
  const Scene scene = load_scene(file, parameters);
  return frames_of(cover_level ? with_covers(scene, *cover_level) : scene, file, numbers);
}

#else

SceneFrames load_scene_frames(const std::string& file, const std::map<std::string, double>& parameters,
                              std::span<const std::size_t>, std::optional<int>) {
  return load_scene_frames(file, parameters, std::size_t{1});
}

SceneFrames load_scene_frames(const std::string& file, const std::map<std::string, double>&, std::size_t) {
  throw InputError(file + ": this build reads no scene files (adapter scene_files is off)");
}

#endif

double check_scene_length(const std::string& file, const std::map<std::string, double>& parameters,
                          std::size_t most_frames) {
  // A case keeps the answers of every backend to every query, some 10 kB.
  constexpr double kMostCases = 1'000'000;
  const SceneFrames scene = load_scene_frames(file, parameters, std::size_t{1});
  const std::size_t frames = most_frames == 0 ? scene.all_frames : std::min(scene.all_frames, most_frames);
  const double cases = static_cast<double>(frames) * static_cast<double>(scene.set.pairs.size());
  if (cases <= kMostCases) return cases;
  throw InputError(
      fmt::format("{}: {} frames (duration {} s at {} Hz) of {} pairs are {:.3g} cases, more than {}; "
                  "shorten the duration or lower the frame rate",
                  file, frames, scene.duration, scene.rate, scene.set.pairs.size(), cases, kMostCases));
}

std::vector<std::size_t> spread_frames(std::size_t all, std::size_t count) {
  std::vector<std::size_t> numbers;
  for (std::size_t i = 0; i < count; ++i) numbers.push_back(count > 1 ? i * (all - 1) / (count - 1) : 0);
  return numbers;
}

std::map<std::string, double> parameters_for(const std::string& file,
                                             std::span<const SceneSetting> settings) {
  std::map<std::string, double> chosen;
  if (settings.empty()) return chosen;
  const SceneFrames scene = load_scene_frames(file, {}, 1);
  for (const SceneSetting& setting : settings) {
    const bool named = setting.scene == scene.set.name;
    const bool known = scene.parameters.count(setting.name) > 0;
    if (named && !known) {
      const std::string list = joined(scene.parameters, [](const auto& entry) { return entry.first; });
      throw InputError(file + ": the scene has no parameter '" + setting.name +
                       "'; known: " + (list.empty() ? "none" : list));
    }
    if (known && (named || setting.scene.empty())) chosen[setting.name] = setting.value;
  }
  return chosen;
}

void check_settings(std::span<const std::string> files, std::span<const SceneSetting> settings) {
  for (const SceneSetting& setting : settings) {
    const bool concerns = std::any_of(files.begin(), files.end(), [&](const std::string& file) {
      return !parameters_for(file, {&setting, 1}).empty();
    });
    if (concerns) continue;
    throw InputError(setting.scene.empty()
                         ? "--set: no scene has the parameter '" + setting.name + "'"
                         : "--set: there is no scene '" + setting.scene + "' among the --scene files");
  }
}

}  // namespace touchstone::comparison
