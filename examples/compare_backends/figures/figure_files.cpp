#include "touchstone/examples/compare_backends/figures/figure_files.hpp"

#include <fmt/format.h>

#include "touchstone/examples/compare_backends/figures/drift_plot.hpp"
#include "touchstone/examples/compare_backends/figures/error_plots.hpp"
#include "touchstone/examples/compare_backends/figures/growth_plot.hpp"
#include "touchstone/examples/compare_backends/figures/speed_error_plot.hpp"
#include "touchstone/examples/compare_backends/figures/time_plot.hpp"
#include "touchstone/examples/compare_backends/figures/timeline_plot.hpp"
#include "touchstone/examples/compare_backends/figures/wireframe_plot.hpp"

namespace touchstone::comparison {
namespace {

std::string file_name(const std::string& figure) { return "figures/" + figure + ".svg"; }

}  // namespace

std::vector<std::string> figure_names(const std::vector<std::string>& sets,
                                      const std::vector<std::string>& backends,
                                      const std::vector<std::string>& scenes) {
  std::vector<std::string> names;
  for (const char* name : {"broadphases", "broadphases_hexahedra", "threads", "dynamics_drift"})
    names.push_back(file_name(name));
  for (const std::string& set : sets) {
    for (const QueryKind query : kQueryKinds)
      for (const char* kind : {"", "_times"})
        names.push_back(file_name(fmt::format("{}_{}{}", set, to_string(query), kind)));
    names.push_back(file_name(set + "_errors"));
  }
  for (const std::string& backend : backends) names.push_back(file_name("signed_" + backend));
  for (std::size_t i = 0; i < kGallerySize; ++i) names.push_back(file_name(fmt::format("worst_{}", i + 1)));
  for (const std::string& scene : scenes) names.push_back(file_name("scene_" + scene));
  return names;
}

std::vector<ReportFile> figure_files(const Report& report) {
  std::vector<ReportFile> files;
  std::vector<std::string> names;
  for (const auto& backend : report.backends) names.push_back(backend.first);
  const auto add = [&](const std::string& name, std::string svg) {
    if (!svg.empty()) files.emplace_back(file_name(name), std::move(svg));
  };
  // Of each set, on axes that all share.
  const PlotAxes axes = axes_for(report.sets);
  const Decades error_axis = error_axis_for(report.sets, QueryKind::distance);
  const Decades time_axis = time_axis_for(report.sets);
  for (const SetResult& set : report.sets) {
    for (const QueryKind query : kQueryKinds) {
      const std::string name = fmt::format("{}_{}", set.name, to_string(query));
      if (report.has_truth) add(name, speed_error_plot(set, query, axes, names, true));
      add(name + "_times", time_plot(set, query, time_axis, names, true));
    }
    if (report.has_truth)
      add(set.name + "_errors", error_distribution_plot(set, QueryKind::distance, error_axis, names, true));
  }
  if (report.has_truth) {
    for (const std::string& name : names)
      add("signed_" + name, signed_error_plot(report.sets, name, names, true));
  }
  // Of the whole run.
  add("broadphases", growth_plot(report.broadphases, Growth::objects, names, true));
  add("broadphases_hexahedra", growth_plot(report.broadphases, Growth::hexahedra_each, names, true));
  add("threads", thread_plot(report.thread_runs, names, true));
  add("dynamics_drift", drift_plot(report.drift, report.rankings, names, true));
  for (std::size_t i = 0; i < report.gallery.size(); ++i)
    add(fmt::format("worst_{}", i + 1), wireframe_plot(report.gallery[i], names, true));
  for (const SceneResult& scene : report.scenes)
    add("scene_" + scene.name, timeline_plot(scene, names, true));
  return files;
}

}  // namespace touchstone::comparison
