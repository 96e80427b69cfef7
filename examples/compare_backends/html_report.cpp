#include "touchstone/examples/compare_backends/html_report.hpp"

#include <fmt/format.h>

#include <map>
#include <string_view>

#include "touchstone/examples/compare_backends/page/embedded_text.hpp"
#include "touchstone/examples/compare_backends/page/sections.hpp"
#include "touchstone/examples/compare_backends/svg_plot.hpp"

namespace touchstone::comparison {
namespace {

std::string head(const Page& page) {
  const Report& report = page.report;
  const Machine& machine = report.machine;
  std::string html = "<h1>Contact detection backends: speed against error</h1>\n";
  html += fmt::format("<p class='soft'>{} ({}), {}; {}, {}. Seed {}. <code>{}</code></p>\n",
                      xml_text(machine.cpu), xml_text(machine.instruction_set), xml_text(machine.system),
                      xml_text(machine.compiler), xml_text(machine.build_type), report.options.seed,
                      xml_text(report.options.command_line));
  if (!report.not_measured.empty()) {
    std::string missing;
    for (const std::string& name : report.not_measured)
      missing += (missing.empty() ? "" : ", ") + xml_text(name);
    html += "<p class='gap'><strong>This report is partial: the run ended early.</strong> Not measured: " +
            missing + ".</p>\n";
  }
  html += "<p class='legend'>";
  for (const auto& [name, description] : report.backends) {
    html += fmt::format("<span data-backend='{}' title='{}'>{}</span>", xml_text(name), xml_text(description),
                        page.named(name));
  }
  html += "</p>\n";
  for (const Gap& gap : report.gaps)
    html += fmt::format("<p class='gap'>Missing: {}. {}.</p>\n", xml_text(gap.what), xml_text(gap.why));
  if (!report.has_truth) {
    html +=
        "<p class='gap'>Without <code>exact</code> no error is measured: this report holds times only.</p>\n";
  }
  return html;
}

// The template with each {{name}} replaced; what is put in is not looked through again.
std::string filled(std::string_view text, const std::map<std::string_view, std::string>& values) {
  std::string page;
  for (std::size_t open; (open = text.find("{{")) != std::string_view::npos;) {
    const std::size_t close = text.find("}}", open);
    page += text.substr(0, open);
    page += values.at(text.substr(open + 2, close - open - 2));
    text.remove_prefix(close + 2);
  }
  return page.append(text);
}

}  // namespace

std::string html_report(const Report& report) {
  const Page page(report);
  std::string sections;
  for (const auto section : {verdict_section, speed_section, wrongness_section, errors_section, times_section,
                             scaling_section, gallery_section, scenes_section, drift_section,
                             consistency_section, families_section, pair_file_section, method_section})
    sections += section(page);
  const auto file = [](std::string_view name) { return std::string(embedded_text(name)); };
  return filled(file("page.html"), {{"report.css", file("report.css")},
                                    {"plot.css", plot_style()},
                                    {"head", head(page)},
                                    {"sections", sections},
                                    {"choice.js", file("choice.js")}});
}

}  // namespace touchstone::comparison
