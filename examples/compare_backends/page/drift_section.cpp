#include <fmt/format.h>

#include "touchstone/examples/compare_backends/page/sections.hpp"
#include "touchstone/examples/compare_backends/svg_plot.hpp"
#include "touchstone/examples/program/text_table.hpp"

namespace touchstone::comparison {

std::string drift_section(const Page& page) {
  const Report& report = page.report;
  if (report.drift.empty())
    return "<h2>What it costs in dynamics</h2>\n<p class='gap'>Missing: dynamics drift against contact "
           "error. "
           "<code>dynamics_run --out FOLDER</code> runs the scenes with dynamics over every backend; "
           "<code>--dynamics FOLDER/results.json</code> brings them here.</p>\n";
  std::string html = R"(<h2>What it costs in dynamics</h2>
<p>The same scenes with dynamics over the contacts of each backend (<code>dynamics_run</code>): how far final poses are from
the reference's, the momentum that nothing explains, and the energy that contacts made, over the scene's energy; against the worst
error of a manifold's figures over the families. One mark a scene. The time of a step holds contacts and forces.</p>
)";
  const std::string plot = drift_plot(report.drift, report.rankings, page.names, false);
  html += plot.empty() ? "<p class='gap'>Missing: the figure. No contact error was measured.</p>\n"
                       : "<div>" + plot + "</div>\n";
  for (const DriftRun& run : report.drift) {
    for (const std::string& figure : missing_figures(run))
      html += fmt::format("<p class='gap'>Not in the figure: {}, {}: {} is not measured.</p>\n",
                          xml_text(run.backend), xml_text(run.scene), figure);
  }
  HtmlTable table({"backend", "scene", "final poses [m]", "momentum [N s]", "energy made / scale",
                   "deepest [m]", "closed forms met", "ns a step", "to build on"});
  for (const DriftRun& run : report.drift) {
    std::vector<std::string> row = {page.named(run.backend), run.scene};
    if (!run.gap.empty())
      row.push_back(run.gap);
    else
      for (const std::string& cell :
           {format_error(run.pose_error), format_error(run.momentum), format_error(run.energy_made),
            format_error(run.deepest), fmt::format("{} of {}", run.met, run.answers), format_ns(run.step_ns),
            std::string(run.build_on ? "yes" : "")})
        row.push_back(cell);
    table.add(row);
  }
  return html + "<details><summary>Table</summary>" + table.str() + "</details>\n" +
         source_note("dynamics", plot.empty() ? "" : "figures/dynamics_drift.svg");
}

}  // namespace touchstone::comparison
