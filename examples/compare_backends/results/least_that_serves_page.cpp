#include "touchstone/examples/compare_backends/results/least_that_serves_page.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "touchstone/examples/compare_backends/results/markdown.hpp"
#include "touchstone/examples/program/terminal/date.hpp"
#include "touchstone/examples/program/terminal/text_table.hpp"

namespace touchstone::comparison {
namespace {

constexpr const char* kIntroduction = R"(# Smallest sufficient model

A scene costs what it is modelled with. Each scene here is modelled with more and fewer hexahedra (facets of what is
round; covers: one box around all that hangs below a node of an object's tree), asked about all pairs and about those alone
that its motion needs (every pair that comes within the contact gap, and for each frame the closest), by every backend, for
each query. A row's error is the geometry's plus the backend's, the worst over the frames judged:

- geometry: the exact answer for the row's hexahedra and pairs against the true one. The true clearance of a round part is
  that of the part itself, bracketed by sectors of it, one hexahedron within and one around each, halved until the two are
  within 1e-12 m; a row of facets is never what facets are judged by. In contact a round part's depth depends on how it is
  cut: there a row counts by how far its facets are from the round surface at most, r (1/cos(pi/n) - 1) circumscribed.
- backend: its answer against the exact one for the same hexahedra and pairs. A wrong class costs the true separation.

Overlap costs only where the class is wrong; a manifold is asked in contact only. Read times as ratios within a table.
)";

std::string machine_lines(const Report& report) {
  return fmt::format("\nTouchstone {}; {} ({}), {} hardware threads, {}; {}, {}; {}.\nWritten by `{}`.\n",
                     report.machine.version, report.machine.cpu, report.machine.instruction_set,
                     report.machine.hardware_threads, report.machine.system, report.machine.compiler,
                     report.machine.build_type, today(), report.options.command_line);
}

// The backend whose rows are shown in full: native where it is there.
std::string shown_backend(const SceneTrade& trade) {
  const bool has_native = std::any_of(trade.rows.begin(), trade.rows.end(),
                                      [](const TradeRow& row) { return row.backend == "native"; });
  return has_native ? "native" : trade.rows.front().backend;
}

std::string steps_table(const SceneTrade& trade) {
  std::string text = "\n" + markdown_head({"query", "the least that serves", "from an allowed error of [m]",
                                           "ns a frame", "geometry [m]", "backend [m]"},
                                          2);
  for (const QueryKind query : kQueryKinds) {
    const std::vector<TradeStep> steps = trade_steps(trade, query);
    if (steps.empty()) text += markdown_row({std::string(to_string(query)), "nothing", "", "", "", ""});
    for (const TradeStep& step : steps)
      text += markdown_row({std::string(to_string(query)), words(*step.row), format_error(step.allowed),
                            format_ns(step.row->frame_ns), format_error(step.row->geometry_error),
                            format_error(step.row->backend_error)});
  }
  return text;
}

// One line a model and choice of pairs: its rows stand one query after the other.
std::string models_table(const SceneTrade& trade) {
  const std::string backend = shown_backend(trade);
  std::string text = fmt::format("\n{}, every model:\n\n", backend);
  text += markdown_head({"model", "hexahedra", "pairs", "overlap, ns a frame", "distance", "manifold",
                         "geometry's error: overlap [m]", "distance", "manifold", "backend's, worst"},
                        1);
  std::vector<std::string> models;
  // One line holds a model's three queries, and the worst error of the backend in them.
  const auto line = [&](const TradeRow& first) {
    std::array<std::string, 3> times = {"-", "-", "-"}, errors = {"-", "-", "-"};
    double worst = 0.0;
    for (const TradeRow& row : trade.rows) {
      if (row.backend != backend || row.model != first.model || row.selected != first.selected) continue;
      times[index_of(row.query)] = format_ns(row.frame_ns);
      errors[index_of(row.query)] = format_error(row.geometry_error);
      worst = std::max(worst, row.backend_error);
    }
    const std::string pairs =
        first.selected ? fmt::format("{} of {}", first.pairs, first.all_pairs) : std::to_string(first.pairs);
    return markdown_row({first.model, std::to_string(first.hexahedra), pairs, times[0], times[1], times[2],
                         errors[0], errors[1], errors[2], format_error(worst)});
  };
  // A model whose pairs were selected has a line of its own.
  for (const TradeRow& row : trade.rows) {
    const std::string key = row.model + (row.selected ? "/" : "");
    if (row.backend != backend || std::find(models.begin(), models.end(), key) != models.end()) continue;
    models.push_back(key);
    text += line(row);
  }
  return text;
}

std::string scene_text(const SceneResult& scene) {
  const SceneTrade& trade = scene.trade;
  std::string parameters;
  for (const auto& [name, value] : scene.parameters) parameters += fmt::format(", {} {}", name, value);
  std::string text = fmt::format("\n## {}\n\n{}\n{} of {} frames judged{}; reference: {}.\n", scene.name,
                                 scene.description, trade.frames, scene.all_frames, parameters,
                                 trade.round ? fmt::format("the true round part, known to {} m",
                                                           format_error(0.5 * trade.reference_width))
                                             : "the hexahedra as written, exactly");
  for (const QueryKind query : {QueryKind::overlap, QueryKind::distance}) {
    const std::string thin = thin_evidence(trade, query);
    if (!thin.empty()) text += fmt::format("No recommendation for {}: {}.\n", to_string(query), thin);
  }
  return text + steps_table(trade) + models_table(trade);
}

std::string selection_text(const std::vector<SelectionRow>& rows) {
  if (rows.empty()) return "";
  std::string text = fmt::format(
      "\n## Selection\n\nA contact world of {} boxes that all move and turn, contacts reported, with "
      "native's checks. On a shared machine read the least.\n\n",
      format_count(rows.front().objects));
  text +=
      markdown_head({"objects switched off", "candidate pairs a frame", "us a frame, median", "least"}, 0);
  for (const SelectionRow& row : rows)
    text += markdown_row({std::to_string(row.switched_off), format_ns(row.candidate_pairs),
                          format_ns(row.frame.median_ns * 1e-3), format_ns(row.frame.minimum_ns * 1e-3)});
  return text;
}

}  // namespace

std::string least_that_serves_page(const Report& report) {
  std::string scenes;
  for (const SceneResult& scene : report.scenes)
    if (!scene.trade.rows.empty()) scenes += scene_text(scene);
  if (scenes.empty()) return "";
  return kIntroduction + machine_lines(report) + scenes + selection_text(report.selection);
}

}  // namespace touchstone::comparison
