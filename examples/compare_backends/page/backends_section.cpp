#include <fmt/format.h>

#include "touchstone/examples/compare_backends/page/sections.hpp"
#include "touchstone/examples/program/plots/svg_plot.hpp"

namespace touchstone::comparison {

std::string backends_section(const Page& page) {
  const Report& report = page.report;
  const Machine& machine = report.machine;
  std::string html = "<h2>Backends compared</h2>\n<p class='legend'>";
  for (const auto& [name, description] : report.backends) {
    html += fmt::format("<span data-backend='{}' title='{}'>{}</span>", xml_text(name), xml_text(description),
                        page.named(name));
  }
  return html +
         fmt::format(
             "</p>\n<p class='soft'>On {} ({}), {}; {}, {}{}. Seed {}. Made by:</p>\n<pre id='command'>{}"
             "</pre>\n",
             xml_text(machine.cpu), xml_text(machine.instruction_set), xml_text(machine.system),
             xml_text(machine.compiler), xml_text(machine.build_type),
             report.elsewhere.empty()
                 ? ""
                 : fmt::format("; {} of {} shards on other machines (see Method)", report.elsewhere.size(),
                               report.elsewhere.front().shard.n),
             report.options.seed, xml_text(report.options.command_line));
}

}  // namespace touchstone::comparison
