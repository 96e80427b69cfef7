#include <fmt/format.h>

#include <algorithm>

#include "touchstone/examples/compare_backends/figures/error_plots.hpp"
#include "touchstone/examples/compare_backends/page/sections.hpp"
#include "touchstone/examples/program/plots/svg_plot.hpp"
#include "touchstone/examples/program/terminal/text_table.hpp"

namespace touchstone::comparison {
namespace {

const BackendResult* judged(const SetResult& set, const std::string& name) {
  for (const BackendResult& backend : set.backends)
    if (backend.name == name && backend.judged) return &backend;
  return nullptr;
}

/// Sets by backends; empty where no contact of any set is face on face.
std::string coverage(const Page& page) {
  std::vector<std::string> header = {"error: median / 99% / worst"};
  for (const std::string& name : page.names) header.push_back(page.named(name));
  HtmlTable table(header, "errors");
  bool is_any = false;
  // A row is shown only where a backend has contacts face on face.
  for (const SetResult& set : page.report.sets) {
    std::vector<std::string> row = {xml_text(set.name)};
    bool is_in_set = false;
    for (const std::string& name : page.names) {
      const BackendResult* const backend = judged(set, name);
      const auto measure = static_cast<std::size_t>(Measure::patch_coverage);
      const Quantiles each = backend ? backend->judgement.errors[measure].over_scale : Quantiles{};
      is_in_set |= each.count > 0;
      row.push_back(each.count == 0 ? "-"
                                    : fmt::format("{} / {} / {}", format_error(each.median),
                                                  format_error(each.p99), format_error(each.worst)));
    }
    if (is_in_set) table.add(row);
    is_any |= is_in_set;
  }
  // Without such contacts there is no table.
  if (!is_any) return "";
  return "<h3>Patch coverage</h3>\n<p>Manifold query, contacts face on face: how far the area of the points' "
         "hull is from that of the true patch, as a share of it. 0: the points hold the whole face; 1: a "
         "line or a point, on which a block turns over.</p>\n" +
         table.str() + source_note("pair_sets[].backends[].errors.patch_coverage");
}

std::string distributions(const Page& page, const Decades& axis, std::size_t most_lines) {
  std::string html = "<div class='plots three'>\n";
  for (const SetResult& set : page.report.sets)
    html += error_distribution_plot(set, QueryKind::distance, axis, page.names, false, most_lines);
  return html + "</div>\n";
}

// Six lines a plot, and where there are more all of them where asked for.
std::string few_and_all_distributions(const Page& page) {
  const Decades axis = error_axis_for(page.report.sets, QueryKind::distance);
  const std::string few = distributions(page, axis, kFewLines);
  const bool is_all = std::all_of(page.report.sets.begin(), page.report.sets.end(), [](const SetResult& set) {
    return distribution_lines(set, QueryKind::distance).size() <= kFewLines;
  });
  if (is_all) return few;
  return fmt::format(
             "<p class='soft'>Drawn: of each set the {} backends with the fewest wrong or missing "
             "answers.</p>\n",
             kFewLines) +
         few + "<details><summary>All backends' lines</summary>" + distributions(page, axis, kAllLines) +
         "</details>\n";
}

}  // namespace

std::string errors_section(const Page& page) {
  const Report& report = page.report;
  // Errors need exact answers.
  if (!report.has_truth || report.sets.empty()) return "";
  // Sizes of errors come first, as shares of the pairs.
  std::string html =
      "<h2>Error distributions</h2>\n<p>Distance query: the share of a set's pairs whose error over S is at "
      "most so much; exactly 0 stands left of the broken axis. A missed or phantom contact counts as the "
      "depth or distance it is wrong by; a line ends below 100 % where pairs have no answer. Lines go "
      "through the 0, 1, 2, 5, 10, 20 ... 90, 95, 99, 99.9 and 100 % values. A backend "
      "that answers no pair's distance has no line.</p>\n";
  html +=
      few_and_all_distributions(page) +
      source_note("pair_sets[].backends[].queries.distance.cost_curve_over_S", "figures/<set>_errors.svg");
  // Signed errors follow, which tell a margin from a relative error.
  html +=
      "<h3>Error against true separation</h3>\n<p>Signed, both over S, linear within 1e-17 and logarithmic "
      "beyond; left: in contact, right: apart; up: reported further apart or less deep than true. A margin "
      "or tolerance of an engine is a level band, a relative error a slope. Every set's pairs, evenly "
      "spread, and its worst.</p>\n<div class='plots small'>\n";
  for (const std::string& name : page.names) {
    const std::string plot = signed_error_plot(report.sets, name, page.names, false);
    html += plot.empty() ? "<p class='gap'>" + page.named(name) + ": answers no distances.</p>\n" : plot;
  }
  return html + "</div>\n" +
         source_note("pair_sets[].backends[].signed_errors_over_S", "figures/signed_<backend>.svg") +
         coverage(page);
}

}  // namespace touchstone::comparison
