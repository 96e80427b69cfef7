#include "touchstone/examples/compare_backends/error_plots.hpp"
#include "touchstone/examples/compare_backends/page/sections.hpp"

namespace touchstone::comparison {

std::string errors_section(const Page& page) {
  const Report& report = page.report;
  if (!report.has_truth || report.sets.empty()) return "";
  const Decades axis = error_axis_for(report.sets, QueryKind::distance);
  std::string html =
      "<h2>Error distributions</h2>\n<p>Distance query: the share of a set's pairs whose error over S is at "
      "most so much; exactly 0 stands left of the broken axis. A missed or phantom contact counts as the "
      "depth or distance it is wrong by; a line ends below 100 % where pairs have no answer. Lines go "
      "through the 0, 1, 2, 5, 10, 20 ... 90, 95, 99, 99.9 and 100 % values. A backend "
      "that answers no pair's distance has no line.</p>\n<div class='plots three'>\n";
  for (const SetResult& set : report.sets)
    html += error_distribution_plot(set, QueryKind::distance, axis, page.names, false);
  html += "</div>\n" + source_note(page, "pair_sets[].backends[].queries.distance.cost_curve_over_S",
                                   "figures/<set>_errors.svg");
  html +=
      "<h3>Error against true separation</h3>\n<p>Signed, both over S, linear within 1e-17 and logarithmic "
      "beyond; left: in contact, right: apart; up: reported further apart or less deep than true. A margin "
      "or "
      "tolerance of an engine is a level band, a relative error a slope. Every set's pairs, evenly spread, "
      "and its worst.</p>\n<div class='plots small'>\n";
  for (const std::string& name : page.names) {
    const std::string plot = signed_error_plot(report.sets, name, page.names, false);
    html += plot.empty() ? "<p class='gap'>" + page.named(name) + ": answers no distances.</p>\n" : plot;
  }
  return html + "</div>\n" +
         source_note(page, "pair_sets[].backends[].signed_errors_over_S", "figures/signed_<backend>.svg");
}

}  // namespace touchstone::comparison
