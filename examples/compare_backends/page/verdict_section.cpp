#include <fmt/format.h>

#include "touchstone/examples/compare_backends/json_writer.hpp"
#include "touchstone/examples/compare_backends/page/sections.hpp"
#include "touchstone/examples/compare_backends/svg_plot.hpp"
#include "touchstone/examples/program/text_table.hpp"

namespace touchstone::comparison {
namespace {

std::string verdict_block(const Page& page, const Verdict& verdict, bool open) {
  std::string html =
      fmt::format("<section class='one-verdict' data-query='{}'>{}{}{}<p>{}</p>\n", to_string(verdict.query),
                  open ? "<strong>" : "", xml_text(sentence(verdict)), open ? "</strong>" : "",
                  xml_text(headline(verdict)));
  HtmlTable table({"backend", "inside", "ns a pair", "worst [m]", "why", "case", "wrong"}, "ranked");
  for (const Candidate& each : verdict.candidates) {
    table.add({page.named(each.backend), each.inside ? "yes" : "no", speed_text(each),
               format_error(each.worst_cost), reason_out(verdict, each), each.worst_id,
               format_count(each.wrong.total())},
              each.inside ? "" : "out");
  }
  return html + (open ? table.str() : "<details><summary>Why</summary>" + table.str() + "</details>") +
         "</section>\n";
}

std::string controls(const Page& page, double budget) {
  std::string html = "<form class='controls' id='controls' hidden><label>query <select id='query'>";
  for (const QueryKind query : kQueryKinds) {
    html += fmt::format("<option{}>{}</option>", query == page.report.options.query ? " selected" : "",
                        to_string(query));
  }
  return html + fmt::format(
                    "</select></label><label>allowed error <input id='slider' type='range' min='-18' max='1' "
                    "step='0.1'></label><label><input id='budget' type='text' inputmode='decimal' size='9' "
                    "value='{}'> m</label></form>\n",
                    budget);
}

}  // namespace

std::string opening_backend(const Report& report) {
  for (const Candidates& of : report.candidates) {
    if (of.query == report.options.query)
      return decide(of.candidates, of.query, report.options.max_error.value_or(kDefaultBudget)).fastest;
  }
  return "";
}

std::string choose_section(const Page& page) {
  if (page.report.candidates.empty()) return "";
  return "<h2>What do you ask?</h2>\n" +
         controls(page, page.report.options.max_error.value_or(kDefaultBudget)) +
         "<noscript><p class='soft'>The controls need JavaScript.</p></noscript>\n";
}

std::string verdict_section(const Page& page) {
  const Report& report = page.report;
  if (report.candidates.empty()) return "";
  const double budget = report.options.max_error.value_or(kDefaultBudget);
  std::string html =
      "<div class='verdict'><h2>Which backend</h2>\n<div id='chosen' aria-live='polite'></div><div "
      "id='static-verdicts'>\n";
  for (const QueryKind asked :
       {report.options.query, QueryKind::overlap, QueryKind::distance, QueryKind::manifold}) {
    const bool open = html.find("data-query") == std::string::npos;
    if (!open && asked == report.options.query) continue;
    for (const Candidates& of : report.candidates) {
      if (of.query == asked) html += verdict_block(page, decide(of.candidates, asked, budget), open);
    }
  }
  html +=
      "</div>\n<script type='application/json' id='candidates'>" + candidates_json(report) + "</script>\n";
  return html +
         fmt::format(
             "<p class='soft'>The page opens with an allowed error of {} m{}. A contact missed or reported "
             "where "
             "there is none costs the depth or distance it is wrong by, and is named; an undecided, failed "
             "or "
             "unsupported answer and a missing figure are never inside. Speed: the mean of the medians over "
             "{} "
             "pair sets and {} scenes, one pair a call (scenes: a frame a call). In brackets: the time of a "
             "backend with a wrong or missing answer.</p>\n",
             budget, report.options.max_error ? "" : " (<code>--max-error</code> chooses another)",
             report.sets.size(), report.scenes.size()) +
         source_note("candidates") + "</div>\n";
}

}  // namespace touchstone::comparison
