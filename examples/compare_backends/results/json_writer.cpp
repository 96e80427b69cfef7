#include "touchstone/examples/compare_backends/results/json_writer.hpp"

#include <fmt/format.h>

#include "touchstone/examples/compare_backends/figures/growth_plot.hpp"
#include "touchstone/examples/compare_backends/results/json_parts.hpp"
#include "touchstone/examples/compare_backends/results/method_text.hpp"
#include "touchstone/examples/program/terminal/date.hpp"

namespace touchstone::comparison {
namespace {

template <typename Range>
Json json_list(const Range& items) {
  Json list = Json::array();
  for (const auto& item : items) list.push_back(json(item));
  return list;
}

void add_run(const Report& report, Json& root) {
  // The schema and the options say how the run is repeated.
  root["schema"] = fmt::format("touchstone.compare_backends/{}", kResultsSchema);
  root["command"] = report.options.command_line;
  root["seed"] = report.options.seed;
  root["version"] = report.machine.version;
  root["date"] = today();
  root["partial"] = !report.not_measured.empty();
  root["not_measured"] = report.not_measured;
  root["engine_messages"] = report.engine_messages;
  // The corpus and the machine say on which data and processor the figures hold.
  if (report.corpus)
    root["corpus"] = {{"name", report.corpus->name},
                      {"version", report.corpus->version},
                      {"sha256", report.corpus->sha256}};
  root["machine"] = {{"cpu", report.machine.cpu},
                     {"instruction_set", report.machine.instruction_set},
                     {"hardware_threads", report.machine.hardware_threads},
                     {"system", report.machine.system},
                     {"compiler", report.machine.compiler},
                     {"build_type", report.machine.build_type},
                     {"flags", report.machine.flags}};
  // Of a merge, whose pairs other machines measured.
  for (const ShardMachine& each : report.elsewhere)
    root["shards_elsewhere"].push_back({{"k", each.shard.k},
                                        {"n", each.shard.n},
                                        {"cpu", each.cpu},
                                        {"instruction_set", each.instruction_set},
                                        {"compiler", each.compiler}});
  for (const auto& [name, version] : report.machine.libraries) root["libraries"][name] = version;
}

void add_timing(const Report& report, Json& root) {
  const MeasureOptions measure;
  root["timing"] = {{"pairs_a_family", report.options.pair_count()},
                    {"pairs_a_block", measure.block},
                    {"pairs_a_batch", measure.batch},
                    {"repetitions", report.options.repetitions},
                    {"seconds_a_row_and_repetition_at_most", measure.slow_seconds}};
  for (const auto& [name, text] : kTimingMethod) root["timing"]["definitions"][std::string(name)] = text;
}

void add_backends(const Report& report, Json& root) {
  root["backends"] = Json::array();
  for (const auto& [name, description] : report.backends) {
    root["backends"].push_back({{"name", name}, {"description", description}});
  }
  // Gaps say what was not measured, and why.
  root["gaps"] = Json::array();
  for (const Gap& gap : report.gaps) root["gaps"].push_back({{"what", gap.what}, {"why", gap.why}});
  // Readers find each measure of accuracy defined in the file itself.
  root["measured_against_exact"] = report.has_truth;
  for (std::size_t m = 0; m < kMeasures; ++m) {
    root["definitions"][to_string(static_cast<Measure>(m))] = definition(static_cast<Measure>(m));
  }
  root["curve_shares"] = kCurveShares;
}

void add_measured(const Report& report, Json& root) {
  // Pairs come first, with the consistency of their answers.
  root["pair_sets"] = json_list(report.sets);
  root["path_sets"] = json_list(report.path_sets);
  for (const auto& [name, description] : report.backends) {
    const Consistency total = total_consistency(report.sets, name);
    if (total.swapped.cases > 0) root["consistency"][name] = json(std::optional(total));
  }
  // Broadphases, scenes and dynamics stand beside the pairs.
  root["broadphases"] = json_list(report.broadphases);
  root["scenes"] = json_list(report.scenes);
  root["selection"] = json_list(report.selection);
  root["dynamics"] = json_list(report.drift.runs);
  // Slopes tell how times grow with objects and threads.
  root["fitted_slopes"] = Json::array();
  for (const FittedSlope& each : fitted_slopes(report.broadphases, report.thread_runs))
    root["fitted_slopes"].push_back(
        {{"along", each.along}, {"backend", each.name}, {"slope", number(each.slope)}});
  root["thread_runs"] = json_list(report.thread_runs);
  root["thread_gaps"] = Json::array();
  for (const Gap& gap : report.thread_gaps)
    root["thread_gaps"].push_back({{"what", gap.what}, {"why", gap.why}});
}

void add_conclusions(const Report& report, Json& root) {
  root["gallery"] = json_list(report.gallery);
  root["rankings"] = json_list(report.rankings);
  root["choices"] = json(report.choices);
  root["verdicts"] = json_list(report.verdicts);
}

}  // namespace

std::string choices_json(const Report& report) {
  std::string text = one_line(json(report.choices));
  for (std::size_t at = 0; (at = text.find('<', at)) != std::string::npos;) text.replace(at, 1, "\\u003c");
  return text;
}

std::string results_json(const Report& report) {
  Json root;
  add_run(report, root);
  add_timing(report, root);
  add_backends(report, root);
  add_measured(report, root);
  add_conclusions(report, root);
  return root.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";  // paths and names may be no UTF-8
}

}  // namespace touchstone::comparison
