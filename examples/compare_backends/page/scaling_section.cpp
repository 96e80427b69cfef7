#include <fmt/format.h>

#include "touchstone/examples/compare_backends/figures/growth_plot.hpp"
#include "touchstone/examples/compare_backends/page/sections.hpp"
#include "touchstone/examples/program/plots/svg_plot.hpp"
#include "touchstone/examples/program/terminal/text_table.hpp"

namespace touchstone::comparison {
namespace {

std::string broadphase_table(const Page& page) {
  HtmlTable table({"broadphase", "objects", "hexahedra each", "ms a frame", "99%", "with overlap",
                   "candidates", "allocations a frame", "missed"});
  for (const BroadphaseResult& result : page.report.broadphases) {
    std::vector<std::string> row = {xml_text(result.name), format_count(result.size.objects),
                                    format_count(result.size.hexahedra_each)};
    if (!result.gap.empty()) {
      row.push_back(result.gap);
      table.add(row);
      continue;
    }
    row.push_back(fmt::format("{:.3f}", result.frame.median_ns * 1e-6));
    row.push_back(result.frame.blocks < kLeastForP99 ? "-"
                                                     : fmt::format("{:.3f}", result.frame.p99_ns * 1e-6));
    row.push_back(result.with_overlap ? fmt::format("{:.3f}", result.with_overlap->median_ns * 1e-6) : "-");
    row.push_back(format_count(static_cast<std::size_t>(result.candidates)));
    row.push_back(result.allocations ? fmt::format("{:.3g}", *result.allocations) : "-");
    row.push_back(result.missed ? fmt::format("{} of {}", *result.missed, format_count(result.true_pairs))
                                : "not checked");
    table.add(row);
  }
  return table.str();
}

std::string broadphases(const Page& page) {
  const Report& report = page.report;
  if (report.broadphases.empty())
    return "<p class='gap'>Missing: broadphases. Not run (--no-broadphase).</p>\n";
  return "<h3>Broadphases: objects and hexahedra an object</h3>\n<p>update and find_pairs of objects that "
         "all move and turn every frame. Missed: of the pairs whose hexahedra are within the margin in the "
         "last frame, taken from all pairs up to 10 000 hexahedra, beyond that from the candidates of all "
         "broadphases, confirmed by <code>exact</code>. With overlap: and the overlap of all pairs by the "
         "narrowphase of the same name, as one batch. <code>edge_face</code> is the paper's coarse check: "
         "every two objects, a list node allocated for each pair in range, and pairs missed whose spheres "
         "touch exactly. Slopes: least squares of the logarithms, of three points or more.</p>\n<div "
         "class='plots'>\n" +
         growth_plot(report.broadphases, Growth::objects, page.names, false) +
         growth_plot(report.broadphases, Growth::hexahedra_each, page.names, false) + "</div>\n" +
         broadphase_table(page) + source_note("broadphases", "figures/broadphases*.svg");
}

std::string threads(const Page& page) {
  const Report& report = page.report;
  std::string gaps;
  for (const Gap& gap : report.thread_gaps)
    gaps +=
        "<p class='gap'>Missing: threads of " + page.named(gap.what) + ": " + xml_text(gap.why) + ".</p>\n";
  if (report.thread_runs.empty()) return gaps;
  std::string html = fmt::format(
      "<h3>Narrowphases: threads</h3>\n<p>Distances of {} pairs of <code>{}</code> (overlaps, of a backend "
      "without), in batches, wall clock a pair, median of {} passes; the machine has {} hardware threads. A "
      "slope of -1 is perfect; fewer than three points have none. Backends with a wrong or missing answer in "
      "that family have no speed "
      "mark.</p>\n<div class='plots'>\n",
      format_count(report.thread_runs.front().pairs),
      report.sets.empty() ? "" : xml_text(report.sets.front().name),
      report.thread_runs.front().pass.repetitions, report.machine.hardware_threads);
  html += thread_plot(report.thread_runs, page.names, false, kFewLines) + "</div>\n";
  if (thread_line_count(report.thread_runs) > kFewLines) {
    html += fmt::format(
                "<details><summary>All {} backends, not the {} fastest alone</summary><div class='plots'>",
                thread_line_count(report.thread_runs), kFewLines) +
            thread_plot(report.thread_runs, page.names, false) + "</div></details>\n";
  }
  // The table behind the plot.
  html += gaps;
  HtmlTable table({"backend", "threads", "ns a pair", "99%", "wrong"});
  for (const ThreadResult& run : report.thread_runs) {
    if (run.gap.empty())
      table.add({page.named(run.backend), std::to_string(run.threads), format_ns(run.pass.median_ns),
                 format_ns(shown_p99(run.pass)), format_count(run.wrong)});
    else if (run.threads == 1)
      table.add({page.named(run.backend), run.gap});
  }
  return html + "<details><summary>Table</summary>" + table.str() + "</details>\n" +
         source_note("thread_runs", "figures/threads.svg");
}

}  // namespace

std::string scaling_section(const Page& page) {
  if (page.report.broadphases.empty() && page.report.thread_runs.empty() && page.report.thread_gaps.empty())
    return "";
  return "<h2>Scaling</h2>\n" + broadphases(page) + threads(page);
}

}  // namespace touchstone::comparison
