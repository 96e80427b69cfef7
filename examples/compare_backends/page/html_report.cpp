#include "touchstone/examples/compare_backends/page/html_report.hpp"

#include <fmt/format.h>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/examples/compare_backends/page/embedded_text.hpp"
#include "touchstone/examples/compare_backends/page/sections.hpp"
#include "touchstone/examples/program/plots/svg_plot.hpp"

namespace touchstone::comparison {
namespace {

// A part of the page, with its entry among the contents.
struct Part {
  const char* id;
  const char* entry;
  std::string (*markup)(const Page&);
};

// In the order in which a reader needs them: the choice, what it rests on, what an error costs, the figures.
constexpr Part kParts[] = {
    {"choose", "Choose", choose_section},          {"verdict", "Verdict", verdict_section},
    {"pairs", "Your pairs", pair_file_section},    {"backends", "Backends", backends_section},
    {"short", "Summary", ranking_section},         {"speed", "Speed against error", speed_section},
    {"wrong", "Wrong answers", wrongness_section}, {"task", "Cost to the task", scenes_section},
    {"dynamics", "In dynamics", drift_section},    {"worst", "Worst cases", gallery_section},
    {"errors", "Errors", errors_section},          {"times", "Times", times_section},
    {"scaling", "Scaling", scaling_section},       {"consistency", "Consistency", consistency_section},
    {"figures", "Every figure", families_section}, {"method", "Method", method_section}};

std::string notices(const Report& report) {
  std::string html;
  if (!report.not_measured.empty()) {
    html += "<p class='gap'><strong>This report is partial: the run ended early.</strong> Not measured: " +
            joined(report.not_measured, xml_text) + ".</p>\n";
  }
  for (const Gap& gap : report.gaps)
    html += fmt::format("<p class='gap'>Missing: {}. {}.</p>\n", xml_text(gap.what), xml_text(gap.why));
  if (!report.has_truth) {
    html +=
        "<p class='gap'>Without <code>exact</code> no error is measured: this report holds times only.</p>\n";
  }
  return html;
}

}  // namespace

std::string html_report(const Report& report) {
  const Page page(report);
  std::string contents, sections;
  for (const Part& part : kParts) {
    const std::string markup = part.markup(page);
    if (markup.empty()) continue;
    contents += fmt::format("<li><a href='#{}'>{}</a></li>\n", part.id, part.entry);
    sections += fmt::format("<section id='{}'>\n{}</section>\n", part.id, markup);
  }
  const auto file = [](std::string_view name) { return std::string(embedded_text(name)); };
  return filled(file("page.html"), {{"report.css", file("report.css")},
                                    {"plot.css", plot_style()},
                                    {"contents", contents},
                                    {"notices", notices(report)},
                                    {"sections", sections},
                                    {"decide.js", file("decide.js")},
                                    {"choice.js", file("choice.js")}});
}

}  // namespace touchstone::comparison
