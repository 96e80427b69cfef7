#include <fmt/format.h>

#include "touchstone/examples/compare_backends/figures/speed_error_plot.hpp"
#include "touchstone/examples/compare_backends/page/sections.hpp"
#include "touchstone/examples/program/plots/svg_plot.hpp"
#include "touchstone/examples/program/terminal/text_table.hpp"

namespace touchstone::comparison {

namespace {

// Unsupported queries stand beside wrong answers: they are no error.
std::string wrong_and_unsupported(const Wrongness& wrong) {
  const std::size_t unsupported = wrong.unsupported;
  std::string text = wrong_lines(wrong, ", ");
  if (unsupported > 0) {
    text += fmt::format("{}<span class='soft n'>{} not supported</span>", text.empty() ? "" : ", ",
                        format_count(unsupported));
  }
  return text;
}

}  // namespace

std::string ranking_section(const Page& page) {
  const Report& report = page.report;
  if (report.rankings.empty()) return "";
  std::string html = fmt::format(
      "<h2>Summary</h2>\n<p>Over {} pair {}: the mean of the medians, one pair a call through the "
      "interface, and the worst error over S. A backend with any wrong or missing answer has no place; its "
      "row says what it got wrong.</p>\n<div class='ranks'>\n",
      report.sets.size(), report.sets.size() == 1 ? "set" : "sets");
  for (const Ranking& ranking : report.rankings) {
    html += fmt::format(
        "<div><h3>{}</h3><table><thead><tr><th>backend</th><th>ns a pair</th><th>worst "
        "error</th></tr></thead><tbody>\n",
        to_string(ranking.query));
    for (const RankedBackend& standing : ranking.standings) {
      html += "<tr><th>" + page.named(standing.backend) + "</th>";
      html += standing.wrong.is_complete()
                  ? fmt::format("<td>{}</td><td>{}</td></tr>\n", format_ns(standing.nanoseconds),
                                format_error(standing.worst_error))
                  : "<td class='wrong' colspan='2'>" + wrong_and_unsupported(standing.wrong) + "</td></tr>\n";
    }
    html += "</tbody></table></div>\n";
  }
  return html + "</div>\n" + source_note("rankings");
}

std::string speed_section(const Page& page) {
  const Report& report = page.report;
  if (!report.has_truth || report.sets.empty()) return "";
  const PlotAxes axes = axes_for(report.sets);
  std::string html =
      "<h2>Speed against error</h2>\n<p>One mark a backend: its worst error over S, with a whisker to the "
      "median and a tick at the 99th percentile, and its median time, one pair a call through the interface, "
      "with a whisker to the 99th percentile; both of " +
      blocks_text(report) +
      " (fewer than 100 blocks: no whisker). The column on the left is exactly 0. A backend with any wrong "
      "or missing answer gets no speed mark: it stands hollow on the rail; below, who does not support how "
      "many pairs. The dashed line joins the backends that none beats in both: above it and right of it "
      "something is faster and more exact.</p>\n";
  for (const QueryKind query : kQueryKinds) {
    html += fmt::format("<h3>{}</h3><div class='plots'>\n", to_string(query));
    for (const SetResult& set : report.sets) html += speed_error_plot(set, query, axes, page.names, false);
    html += "</div>\n";
  }
  return html +
         source_note("pair_sets[].backends[].queries.*: cost_over_S, single", "figures/<set>_<query>.svg");
}

}  // namespace touchstone::comparison
