#include <fmt/format.h>

#include <cmath>

#include "touchstone/examples/compare_backends/figures/drift_plot.hpp"
#include "touchstone/examples/compare_backends/page/sections.hpp"
#include "touchstone/examples/program/plots/svg_plot.hpp"
#include "touchstone/examples/program/terminal/text_table.hpp"

namespace touchstone::comparison {
namespace {

constexpr const char* kHeading = "<h2>Drift in dynamics</h2>\n";

std::string count_or_none(double value) {
  return std::isnan(value) ? "-" : format_count(static_cast<std::size_t>(value));
}

std::string verdict(const Page& page) {
  const Drift& drift = page.report.drift;
  std::string html = "<div class='verdict' id='build-on'>";
  if (drift.build_on.empty())
    html += fmt::format("<strong>Build on: no verdict over all scenes</strong>{}\n",
                        drift.reason.empty() ? "" : "<p>" + xml_text(drift.reason) + ".</p>");
  else
    html += fmt::format("<strong>Build on {}</strong><p>Over all scenes: {}.</p>\n",
                        page.named(drift.build_on), xml_text(drift.reason));
  const std::string agreement = drift_agreement(drift, opening_backend(page.report));
  return html + (agreement.empty() ? "" : "<p>" + xml_text(agreement) + "</p>\n") + "</div>\n";
}

std::string standings(const Page& page) {
  HtmlTable table({"backend", "scenes within", "final poses [m]", "momentum [N s]", "energy made / scale",
                   "deepest [m]", "ns a step", "99.9%, most", "allocations, most", "first miss"},
                  "text");
  for (const DriftStanding& each : drift_standings(page.report.drift)) {
    table.add({page.named(each.backend), fmt::format("{} of {}", each.within, each.scenes),
               format_error(each.pose_error), format_error(each.momentum), format_error(each.energy_made),
               format_error(each.deepest), format_ns(each.step_ns), format_ns(each.p999_ns),
               count_or_none(each.allocations), each.failure},
              each.within < each.scenes ? "out" : "");
  }
  return table.str();
}

std::string scenes(const Page& page) {
  HtmlTable table({"scene", "build on", "why"}, "text");
  for (const DriftScene& scene : page.report.drift.scenes) {
    table.add({xml_text(scene.name), scene.touches && !scene.build_on.empty() ? scene.build_on : "-",
               scene.touches ? scene.reason : "nothing touches: no choice to make"});
  }
  return table.str();
}

std::string every_run(const Page& page) {
  HtmlTable table({"backend", "scene", "final poses [m]", "momentum [N s]", "energy made / scale",
                   "deepest [m]", "closed forms met", "ns a step", "99.9%", "allocations", "build on"});
  for (const DriftRun& run : page.report.drift.runs) {
    std::vector<std::string> row = {page.named(run.backend), run.scene};
    if (!run.gap.empty())
      row.push_back(run.gap);
    else
      for (const std::string& cell :
           {format_error(run.pose_error), format_error(run.momentum), format_error(run.energy_made),
            format_error(run.deepest), fmt::format("{} of {}", run.met, run.answers), format_ns(run.step_ns),
            format_ns(run.p999_ns), count_or_none(run.allocations), std::string(run.build_on ? "yes" : "")})
        row.push_back(cell);
    table.add(row, run.is_within() ? "" : "out");
  }
  return "<details><summary>Every run</summary>" + table.str() + "</details>\n";
}

std::string left_out(const Drift& drift) {
  std::string text;
  for (const DriftRun& run : drift.runs) {
    for (const std::string& figure : missing_figures(run))
      text += fmt::format("{}{}, {}: {}", text.empty() ? "" : "; ", xml_text(run.backend),
                          xml_text(run.scene), figure);
  }
  return text.empty()
             ? ""
             : "<details><summary class='gap'>Not measured</summary><p class='gap'>Not in the figure: " +
                   text + ".</p></details>\n";
}

}  // namespace

std::string drift_section(const Page& page) {
  const Report& report = page.report;
  // A page without dynamics says how to get them.
  if (report.drift.runs.empty())
    return std::string(kHeading) +
           "<p class='gap'>Missing: dynamics drift against contact error. <code>dynamics_run --out "
           "FOLDER</code> runs the scenes with dynamics over every backend; <code>--dynamics "
           "FOLDER/results.json</code> brings them here.</p>\n";
  // The verdict comes first, then its grounds: standings, scenes and errors.
  const std::string plot = drift_plot(report.drift, report.rankings, page.names, false);
  std::string html = kHeading + verdict(page);
  html +=
      R"(<p>The same scenes with dynamics over the contacts of each backend (<code>dynamics_run</code>): how far final poses are from
the reference's, the momentum that nothing explains, and the energy that contacts made, over the scene's energy; the worst over the
scenes that touch. The time of a step holds contacts and forces: the geometric mean of the medians.</p>
)";
  html += standings(page) + "<h3>Scene by scene</h3>\n" + scenes(page);
  html +=
      "<h3>Against the error of a contact</h3>\n<p>The worst error of a manifold's figures over the "
      "families. One mark a scene, hollow where the run is not within the scene's limits; the row above: not "
      "run, or stopped.</p>\n";
  html += plot.empty() ? "<p class='gap'>Missing: the figure. No contact error was measured.</p>\n"
                       : "<div class='wide'>" + plot + "</div>\n";
  return html + left_out(report.drift) + every_run(page) +
         source_note("dynamics", plot.empty() ? "" : "figures/dynamics_drift.svg");
}

}  // namespace touchstone::comparison
