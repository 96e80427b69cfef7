#include <fmt/format.h>

#include <map>

#include "touchstone/examples/compare_backends/page/sections.hpp"
#include "touchstone/examples/compare_backends/results/method_text.hpp"
#include "touchstone/examples/compare_backends/results/schema_text.hpp"
#include "touchstone/examples/program/plots/svg_plot.hpp"
#include "touchstone/examples/program/terminal/text_table.hpp"

namespace touchstone::comparison {
namespace {

std::string machine(const Machine& of) {
  std::string libraries;
  for (const auto& [name, version] : of.libraries)
    libraries += fmt::format("{}{} {}", libraries.empty() ? "" : ", ", xml_text(name), xml_text(version));
  return fmt::format(
      "<h3>Machine and build</h3><dl><dt>machine</dt><dd>{}, instruction set {}, {} hardware "
      "threads</dd><dt>system</dt><dd>{}</dd><dt>compiler</dt><dd>{}, "
      "{}</dd><dt>flags</dt><dd><code>{}</code></dd><dt>versions</dt><dd>Touchstone {}, {}; the engines' "
      "stand with the backends</dd></dl>\n",
      xml_text(of.cpu), xml_text(of.instruction_set), of.hardware_threads, xml_text(of.system),
      xml_text(of.compiler), xml_text(of.build_type), xml_text(of.flags), xml_text(of.version), libraries);
}

/// Other machines that measured shards, each once, and how many.
std::string elsewhere(const Report& report) {
  std::map<std::string, std::size_t> shards;
  for (const ShardMachine& each : report.elsewhere)
    ++shards[fmt::format("{}, instruction set {}, {}", each.cpu, each.instruction_set, each.compiler)];
  std::string html;
  for (const auto& [machine, count] : shards)
    html +=
        fmt::format("<p>{} of the {} shards of the pairs {} measured on another machine: {}.</p>\n", count,
                    report.elsewhere.front().shard.n, count == 1 ? "was" : "were", xml_text(machine));
  return html;
}

std::string errors() {
  std::string html =
      "<h3>Errors</h3><p>S is the larger of the pair's size and its largest world coordinate. Every error is "
      "measured against <code>exact</code>, which decides in integers.</p><dl>";
  for (std::size_t m = 0; m < kMeasures; ++m) {
    const auto measure = static_cast<Measure>(m);
    html += fmt::format("<dt>{}</dt><dd>{}</dd>\n", to_string(measure),
                        xml_text(std::string(definition(measure))));
  }
  html += "</dl>\n<p>A query's error, in the figures, the verdict and --max-error [m]:</p><ul>";
  for (const QueryKind query : kQueryKinds)
    html += fmt::format("<li>{}</li>\n", xml_text(std::string(cost_definition(query))));
  for (const std::string_view rule : cost_rules())
    html += fmt::format("<li>{}</li>\n", xml_text(std::string(rule)));
  return html + "</ul>\n";
}

std::string times(const Options& options) {
  const MeasureOptions measure;
  std::string html = fmt::format(
      "<h3>Times</h3><p>{} pairs a family, seed {}, {} repetitions, blocks of {} pairs, batches of "
      "{}.</p><dl>",
      format_count(options.pair_count()), options.seed, options.repetitions, measure.block,
      format_count(measure.batch));
  for (const auto& [name, text] : kTimingMethod)
    html += fmt::format("<dt>{}</dt><dd>{}</dd>\n", name, xml_text(std::string(text)));
  return html + "</dl>\n";
}

const Capabilities* declared(const Report& report, const std::string& backend) {
  for (const SetResult& set : report.sets) {
    for (const BackendResult& result : set.backends) {
      if (result.name == backend) return &result.capabilities;
    }
  }
  return nullptr;
}

std::string backends(const Page& page) {
  std::string html = "<h3>Backends</h3>\n<dl>";
  HtmlTable table({"declared", "scalar bits", "margin: absolute [m]", "margin: over scale", "distance",
                   "penetration", "manifold", "complete", "thread safe", "deterministic"});
  const auto yes = [](bool value) { return std::string(value ? "yes" : "no"); };
  for (const auto& [name, description] : page.report.backends) {
    html += fmt::format("<dt>{}</dt><dd>{}</dd>\n", page.named(name), xml_text(description));
    const Capabilities* can = declared(page.report, name);
    if (can == nullptr) continue;
    table.add({page.named(name), std::to_string(can->scalar_bits), format_error(can->resolution.absolute),
               format_error(can->resolution.relative), yes(can->distance), yes(can->penetration),
               yes(can->manifold), yes(can->overlap_complete), yes(can->thread_safe),
               yes(can->deterministic)});
  }
  return html + "</dl>\n" + table.str();
}

std::string schema() {
  std::string html =
      "<details><summary>Schema of results.json and results.csv</summary>\n<p>A figure that was not measured "
      "is null, an infinite one the string \"inf\". Every object of the same kind has the same keys.</p>\n"
      "<table class='schema'><thead><tr><th>in</th><th>keys</th><th>meaning</th></tr></thead><tbody>\n";
  for (const SchemaEntry& entry : kJsonSchema) {
    html += fmt::format("<tr><td>{}</td><td><code>{}</code></td><td>{}</td></tr>\n", entry.where, entry.keys,
                        xml_text(std::string(entry.meaning)));
  }
  return html + "</tbody></table>\n<p>CSV: " + xml_text(std::string(kCsvSchema)) + "</p></details>\n";
}

}  // namespace

std::string method_section(const Page& page) {
  std::string html = "<h2>Method</h2>\n" + machine(page.report.machine) + elsewhere(page.report) + errors() +
                     times(page.report.options) + backends(page) + "<h3>Known limits</h3><ul>";
  for (const std::string_view limit : kKnownLimits) html += "<li>" + xml_text(std::string(limit)) + "</li>\n";
  return html + "</ul>\n" + schema() +
         "<p>A case is replayed with <code>compare_backends --case ID --seed SEED</code> (and the pairs or "
         "scene it is of); two runs are compared with <code>compare_backends diff OLD.json NEW.json</code>. "
         "The same figures: results.json, results.csv; each plot: figures/.</p>\n";
}

}  // namespace touchstone::comparison
