#include <fmt/format.h>

#include "touchstone/examples/compare_backends/judge/upper_bound.hpp"
#include "touchstone/examples/compare_backends/page/sections.hpp"
#include "touchstone/examples/compare_backends/run/replay_command.hpp"
#include "touchstone/examples/program/plots/svg_plot.hpp"
#include "touchstone/examples/program/terminal/text_table.hpp"

namespace touchstone::comparison {
namespace {

std::string bound_text(std::size_t found, std::size_t cases, const char* between = " ") {
  return fmt::format("below{}{}", between, format_error(upper_bound_95(found, cases)));
}

std::string kinds(const Wrongness& wrong) {
  std::string text;
  const auto add = [&](std::size_t count, const char* what) {
    text += fmt::format("{}{} {}: {}", text.empty() ? "" : "; ", format_count(count), what,
                        bound_text(count, wrong.supported()));
  };
  add(wrong.missed, "missed");
  add(wrong.phantom, "phantom");
  add(wrong.undecided, "undecided");
  add(wrong.failed, "failed");
  return text;
}

std::string worst_list(const Page& page, const SetResult& set, const std::vector<WorstCase>& cases) {
  std::string html = "<ul>";
  for (const WorstCase& each : cases) {
    const std::string id = case_id(set, each.index);
    html += fmt::format("<li><code>{}</code> {}, {} m<br><code>{}</code></li>", xml_text(id), each.reason,
                        format_error(each.cost), xml_text(replay_command(page.report, set.name, id)));
  }
  return html + "</ul>";
}

std::string matrix_cell(const Page& page, const SetResult& set, const std::string& name, QueryKind query) {
  for (const BackendResult& backend : set.backends) {
    if (backend.name != name || !backend.judged) continue;
    const std::size_t q = index_of(query);
    const Wrongness& wrong = backend.judgement.wrongness[q];
    const std::string bound = bound_text(wrong.total(), wrong.supported(), "<br>");
    if (wrong.supported() == 0) return "<td class='right'>unsupported</td>";
    const std::string unsupported =
        wrong.unsupported == 0
            ? ""
            : fmt::format("<br><small>{}<br>unsupported</small>", format_count(wrong.unsupported));
    if (wrong.total() == 0)
      return fmt::format("<td class='right'>0<br><small>{}</small>{}</td>", bound, unsupported);
    const double share = static_cast<double>(wrong.total()) / static_cast<double>(wrong.supported());
    return fmt::format(
        "<td class='wrong "
        "w{}'><details><summary>{}<br><small>{}</small>{}</summary><p>{}</p>{}</details></td>",
        share < 0.01  ? 1
        : share < 0.2 ? 2
                      : 3,
        wrong_lines(wrong, "<br>"), bound, unsupported, kinds(wrong),
        worst_list(page, set, backend.judgement.wrong_cases[q]));
  }
  return "<td>-</td>";
}

// A long name may go on below after an underscore.
std::string breakable(const std::string& name) {
  std::string html;
  for (const char each : xml_text(name)) html += each == '_' ? std::string("_<wbr>") : std::string(1, each);
  return html;
}

std::string matrix(const Page& page, QueryKind query) {
  std::string html = fmt::format(
      "<div class='scroll'><table class='matrix'><thead><tr><th>{}</th><th>pairs</th>", to_string(query));
  for (const std::string& name : page.names)
    html += "<th>" + mark_svg(page.names, name) + breakable(name) + "</th>";
  html += "</tr></thead><tbody>\n";
  for (const SetResult& set : page.report.sets) {
    html += fmt::format("<tr><th>{}</th><td>{}</td>", xml_text(set.name), format_count(set.cases));
    for (const std::string& name : page.names) html += matrix_cell(page, set, name, query);
    html += "</tr>\n";
  }
  return html + "</tbody></table></div>\n";
}

}  // namespace

std::string wrongness_section(const Page& page) {
  if (!page.report.has_truth || page.report.sets.empty()) return "";
  std::string html =
      "<h2>Wrong answers</h2>\n<p>Of the pairs in each set. <em>Missed</em>: reported apart, yet in contact. "
      "<em>Phantom</em>: reported in contact, yet apart. <em>No value</em>: the class is right, a figure "
      "that was asked for is missing. <em>Below</em>: the 95 % upper bound of the share of wrong or missing "
      "answers among pairs drawn like these (Clopper and Pearson; none of n: near 3 / n). A cell opens its "
      "kinds, each with its bound, and its worst cases with the commands that replay them.</p>\n";
  for (const QueryKind query : kQueryKinds) html += matrix(page, query);
  return html + source_note("pair_sets[].backends[].queries.*: wrong, wrong_cases");
}

}  // namespace touchstone::comparison
