#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "touchstone/examples/compare_backends/page/sections.hpp"
#include "touchstone/examples/compare_backends/results/json_writer.hpp"
#include "touchstone/examples/program/plots/svg_plot.hpp"
#include "touchstone/examples/program/terminal/text_table.hpp"

namespace touchstone::comparison {
namespace {

const std::vector<std::string> kHeader = {"backend", "inside", "ns a pair", "99.9 % [ns]",
                                          "allocs",  "beyond", "worst [m]", "why"};

std::string verdict_block(const Page& page, const Verdict& verdict, bool open) {
  std::string html =
      fmt::format("<section class='one-verdict' data-query='{}'>{}{}{}<p>{}</p>\n",
                  to_string(verdict.choice.query), open ? "<strong>" : "", xml_text(sentence(verdict)),
                  open ? "</strong>" : "", xml_text(headline(verdict)));
  if (verdict.is_empty()) return html + "</section>\n";
  HtmlTable table(kHeader, "ranked");
  for (const Candidate& each : verdict.candidates) {
    table.add({page.named(each.backend), each.inside ? "yes" : "no", speed_text(each),
               format_ns(each.p999_ns), format_allocations(each.allocations), beyond_text(each),
               format_error(each.worst_cost), reason_out(verdict, each)},
              each.inside ? "" : "out");
  }
  return html + (open ? table.str() : "<details><summary>Why</summary>" + table.str() + "</details>") +
         "</section>\n";
}

std::string checkbox(const char* id, const char* label, bool checked) {
  return fmt::format("<label><input type='checkbox' id='{}'{}> {}</label>", id, checked ? " checked" : "",
                     label);
}

std::string limits(const char* id, const char* label, double chosen, std::span<const double> bins) {
  std::string html = fmt::format("<label>{} <select id='{}'><option value=''>any</option>", label, id);
  const double end = upper_end(chosen, bins);
  for (const double bin : bins)
    html += fmt::format("<option value='{0}'{1}>{0} m</option>", bin, bin == end ? " selected" : "");
  return html + "</select></label>";
}

// Presets for the most common questions.
std::string first_controls(const Choice& choice) {
  std::string html = "<label>query <select id='query'>";
  for (const QueryKind query : kQueryKinds)
    html += fmt::format("<option{}>{}</option>", query == choice.query ? " selected" : "", to_string(query));
  return html +
         fmt::format(
             "</select></label><button type='button' id='contacts_only'>contacts only</button><button "
             "type='button' id='one_in_a_thousand'>0.1 mm, one in a thousand beyond</button><label>error "
             "<input id='slider' type='range' min='-18' max='1' step='0.1'> <input id='budget' type='text' "
             "inputmode='decimal' size='8' value='{}'> m</label><label>share beyond it <input "
             "id='share_slider' type='range' min='-6' max='-0.1' step='0.1'> <input id='share' type='text' "
             "inputmode='decimal' size='8' value='{}'></label>\n",
             choice.max_error, choice.share);
}

std::string pairs_controls(const Page& page, const Choice& choice) {
  std::string html = "<fieldset><legend>Pairs</legend>" + checkbox("apart", "apart", choice.apart) +
                     limits("apart_up_to", "up to", choice.apart_up_to, kApartBins) +
                     checkbox("touching", "touching", choice.touching) +
                     checkbox("deep", "deeper than 1 % of size", choice.deep) +
                     limits("within", "coordinates up to", choice.within, kWithinBins) +
                     "</fieldset>\n<fieldset id='sets'><legend>Pair sets</legend>";
  for (const ChoiceSet& set : page.report.choices) {
    html += fmt::format("<label><input type='checkbox' value='{0}'{1}> {0}</label>", xml_text(set.name),
                        choice.has_set(set.name) ? " checked" : "");
  }
  return html + "</fieldset>\n";
}

std::string number_or_nothing(double value) { return std::isfinite(value) ? fmt::format("{}", value) : ""; }

std::string answer_controls(const Choice& choice) {
  const std::size_t coverage = std::min(bin_of(choice.min_coverage, kCoverageBins), kCoverageBins.size() - 1);
  return "<fieldset><legend>Answers</legend><span id='asked_figures'>" +
         checkbox("normals", "normals", choice.normals) +
         checkbox("points", "closest or contact points", choice.points) + "</span>" +
         fmt::format(
             "<label id='coverage_row'>coverage of the patch from <input id='coverage_slider' type='range' "
             "min='0' max='{}' step='1' value='{}'> <input id='coverage' type='text' size='6' readonly "
             "value='{}'></label><label>a call, at 99.9 %, within <input id='deadline' type='text' "
             "inputmode='decimal' size='8' value='{}'> s</label>",
             kCoverageBins.size() - 1, coverage, kCoverageBins[coverage],
             number_or_nothing(choice.deadline)) +
         checkbox("no_allocations", "no allocations", choice.no_allocations) + "</fieldset>\n";
}

std::string controls(const Page& page, const Choice& choice) {
  std::string header;
  for (const std::string& title : kHeader) header += (header.empty() ? "[\"" : ",\"") + title + "\"";
  return "<form class='controls' id='controls' data-header='" + header + "]' hidden>\n" +
         first_controls(choice) +
         "<details id='more'><summary>pairs, sets and answers to judge by</summary>\n" +
         pairs_controls(page, choice) + answer_controls(choice) + "</details></form>\n";
}

std::string explanation(const Report& report) {
  return fmt::format(
      "<p class='soft'>A contact missed or reported where there is none, and an undecided answer, cost the "
      "depth or distance that they are wrong by; a failed answer what it leaves unknown. Unsupported "
      "answers count only where they are asked for. Costs are counted rounded up to two digits. Speed: the "
      "mean of the medians over {} pair {} and {} {} with such pairs, of all their pairs, one pair a "
      "call (scenes: a frame a call); 99.9 %: of single calls, with the clock's own time; -: too few calls "
      "or not counted. In brackets: the time of a backend with a wrong, missing or unsupported answer.</p>\n",
      report.sets.size(), report.sets.size() == 1 ? "set" : "sets", report.scenes.size(),
      report.scenes.size() == 1 ? "scene" : "scenes");
}

}  // namespace

std::string opening_backend(const Report& report) {
  return decide(report.choices, report.options.choice).fastest;
}

std::string choose_section(const Page& page) {
  if (page.report.choices.empty()) return "";
  return "<h2>Query and limits</h2>\n" + controls(page, page.report.options.choice) +
         "<noscript><p class='soft'>The controls need JavaScript.</p></noscript>\n";
}

std::string verdict_section(const Page& page) {
  const Report& report = page.report;
  if (report.choices.empty()) return "";
  Choice choice = report.options.choice;
  const QueryKind asked = choice.query;
  std::string html =
      "<div class='verdict'><h2>Recommended backend</h2>\n<div id='chosen' aria-live='polite'></div><div "
      "id='static-verdicts'>\n" +
      verdict_block(page, decide(report.choices, choice), true);
  for (const QueryKind other : kQueryKinds) {
    if (other == asked) continue;
    choice.query = other;
    choice.min_coverage = 0;
    html += verdict_block(page, decide(report.choices, choice), false);
  }
  return html + "</div>\n<script type='application/json' id='choices'>" + choices_json(report) +
         "</script>\n" + explanation(report) + source_note("choices") + "</div>\n";
}

}  // namespace touchstone::comparison
