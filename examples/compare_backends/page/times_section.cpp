#include <fmt/format.h>

#include "touchstone/examples/compare_backends/figures/time_plot.hpp"
#include "touchstone/examples/compare_backends/page/sections.hpp"

namespace touchstone::comparison {

std::string times_section(const Page& page) {
  const Report& report = page.report;
  if (report.sets.empty()) return "";
  const Decades axis = time_axis_for(report.sets);
  std::string html =
      "<h2>Time distributions</h2>\n<p>Circle: one pair a call, cold (each pair's data come from memory). "
      "Diamond: the same, cached (the block was just run through). Square: in batches, cold. Triangle: the "
      "engine's own cheapest call. Mark: median; box: quartiles; line: least to 99th percentile, all of " +
      blocks_text(report) +
      ". Fewer than 100 blocks: no 99 %, the line ends at the upper quartile. An "
      "arrow at the figure's edge: further out than its axis. Right: allocations a query. A backend with a "
      "wrong or missing answer in the set has no speed "
      "mark (open: undecided, failed, without a value); its times stand in the tables below.</p>\n";
  for (const QueryKind query : kQueryKinds) {
    const bool open = query == report.options.choice.query;
    html += fmt::format("<details{}><summary><h3>{}</h3></summary><div class='plots'>\n", open ? " open" : "",
                        to_string(query));
    for (const SetResult& set : report.sets) html += time_plot(set, query, axis, page.names, false);
    html += "</div></details>\n";
  }
  return html + source_note("pair_sets[].backends[].queries.*: single, cached, batch, raw",
                            "figures/<set>_<query>_times.svg");
}

}  // namespace touchstone::comparison
