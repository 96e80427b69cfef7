#include <fmt/format.h>

#include "touchstone/examples/compare_backends/page/sections.hpp"
#include "touchstone/examples/program/plots/svg_plot.hpp"

namespace touchstone::comparison {

std::string pair_file_section(const Page& page) {
  if (!page.report.pair_file) return "";
  const PairFileCases& cases = page.report.pair_file->cases;
  std::string html = fmt::format(
      "<h2>Your pairs</h2>\n<p>{} cases of <code>{}</code>; every answer is in answers.json and "
      "answers.csv.</p>\n",
      cases.cases.size(), xml_text(cases.file));
  for (const PairFileCases::Case& each : cases.cases) {
    if (!each.invalid.empty())
      html += fmt::format("<p class='gap'>{}: invalid. {}</p>\n", xml_text(each.id), xml_text(each.invalid));
  }
  return html;
}

}  // namespace touchstone::comparison
