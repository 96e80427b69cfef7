#include <fmt/format.h>

#include "touchstone/examples/compare_backends/page/sections.hpp"
#include "touchstone/examples/program/plots/svg_plot.hpp"
#include "touchstone/examples/program/terminal/text_table.hpp"

namespace touchstone::comparison {
namespace {

bool is_wrong(const BackendResult& backend) {
  return backend.is_wrong(0) || backend.is_wrong(1) || backend.is_wrong(2);
}

std::string times(const Page& page, const SetResult& set) {
  HtmlTable table({"median ns a pair", "overlap", "99%", "batch", "raw", "distance", "99%", "batch", "raw",
                   "manifold", "99%", "batch", "raw", "allocations"});
  for (const BackendResult& backend : set.backends) {
    std::vector<std::string> row = {page.named(backend.name)};
    std::optional<double> allocations;
    for (const BackendResult::Rows& rows : backend.rows) {
      row.push_back(format_ns(median(rows.single)));
      row.push_back(rows.single ? format_ns(shown_p99(*rows.single)) : "-");
      row.push_back(format_ns(median(rows.batch)));
      row.push_back(format_ns(median(rows.raw)));
      if (rows.allocations) allocations = std::max(allocations.value_or(0.0), *rows.allocations);
    }
    row.push_back(allocations ? fmt::format("{:.3g}", *allocations) : "-");
    table.add(row, is_wrong(backend) ? "out" : "");
  }
  return table.str();
}

std::string wrongness(const Page& page, const SetResult& set) {
  HtmlTable table({"wrong answers", "query", "missed", "phantom", "undecided", "failed", "unsupported",
                   "no value", "worst cost [m]", "why", "case"});
  for (const BackendResult& backend : set.backends) {
    if (!backend.judged) continue;
    for (const QueryKind kind : kQueryKinds) {
      const Wrongness& wrong = backend.judgement.wrongness[index_of(kind)];
      if (wrong.is_complete()) continue;
      const WorstCase& worst = backend.judgement.worst[index_of(kind)];
      table.add({page.named(backend.name), std::string(to_string(kind)), format_count(wrong.missed),
                 format_count(wrong.phantom), format_count(wrong.undecided), format_count(wrong.failed),
                 format_count(wrong.unsupported), format_count(wrong.missing), format_error(worst.cost),
                 worst.reason, case_id(set, worst.index)});
    }
  }
  return table.str();
}

std::string errors(const Page& page, const SetResult& set) {
  std::vector<std::string> header = {"errors over S: median / 99% / worst"};
  for (std::size_t m = 0; m < kMeasures; ++m) header.emplace_back(to_string(static_cast<Measure>(m)));
  HtmlTable table(header, "errors");
  for (const BackendResult& backend : set.backends) {
    if (!backend.judged) continue;
    std::vector<std::string> row = {page.named(backend.name)};
    for (const ErrorStats& stats : backend.judgement.errors) {
      const Quantiles& each = stats.over_scale;
      row.push_back(each.count == 0 ? "-"
                                    : fmt::format("{} / {} / {}", format_error(each.median),
                                                  format_error(each.p99), format_error(each.worst)));
    }
    table.add(row);
  }
  return table.str();
}

std::string one_set(const Page& page, const SetResult& set) {
  std::string html = fmt::format("<h3>{}</h3><p class='soft'>{}. {} pairs", xml_text(set.name),
                                 xml_text(set.description), format_count(set.cases));
  if (page.report.has_truth) {
    html += fmt::format(", {} in contact, {} of them exactly touching", format_count(set.contacts),
                        format_count(set.touching));
  }
  html += ".</p>\n" + times(page, set);
  return page.report.has_truth ? html + wrongness(page, set) + errors(page, set) : html;
}

}  // namespace

std::string families_section(const Page& page) {
  if (page.report.sets.empty()) return "";
  std::string html =
      "<h2>Pair sets: every figure</h2>\n<p class='print'>Not printed: see results.csv, or the page on a "
      "screen.</p>\n<div class='screen'><p>Faint rows: backends with a wrong or missing answer in the "
      "set.</p>\n";
  for (const SetResult& set : page.report.sets) html += one_set(page, set);
  return html + source_note("pair_sets") + "</div>\n";
}

}  // namespace touchstone::comparison
