#include "touchstone/examples/compare_backends/diff/diff.hpp"

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <cmath>
#include <set>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/examples/compare_backends/diff/diff_facts.hpp"
#include "touchstone/examples/compare_backends/diff/mann_whitney.hpp"
#include "touchstone/examples/compare_backends/results/results_file.hpp"
#include "touchstone/examples/measures/common/quantiles.hpp"
#include "touchstone/examples/program/files/json_error.hpp"
#include "touchstone/examples/program/terminal/program.hpp"
#include "touchstone/examples/program/terminal/text_table.hpp"

namespace touchstone::comparison {
namespace {

// ---- figures that are the same or not

struct PartText {
  const char* title;
  const char* compared;  // the subject of "no change"
  bool needs_exact;
};
constexpr PartText kParts[kFactParts] = {
    {"wrong answers", "pair sets, scenes' frames, broadphases", true},
    {"worst errors", "every measure over S, clearances of scenes", true},
    {"consistency", "classes, bits, separations over S", false},
    {"allocations", "a query, a frame of a broadphase", false},
};

// Which of the two was not measured against exact; empty: both were.
std::string without_exact(const ReportFacts& before, const ReportFacts& after) {
  if (before.exact && after.exact) return "";
  return before.exact ? "NEW has no exact" : after.exact ? "OLD has no exact" : "neither has exact";
}

std::string part_changes(const ReportFacts& before, const ReportFacts& after, std::size_t part) {
  const PartText& about = kParts[part];
  const std::string lacking = without_exact(before, after);
  if (about.needs_exact && !lacking.empty())
    return fmt::format("{}: not comparable: {}\n", about.title, lacking);
  TextTable table({about.title, "query", "backend", "what", "old", "new", "case"});
  std::size_t compared = 0;
  for (const auto& [key, fact] : before.parts[part]) {
    const auto found = after.parts[part].find(key);
    if (found == after.parts[part].end()) continue;
    ++compared;
    if (fact.value == found->second.value) continue;
    table.add(
        {key.where, key.query, key.backend, key.what, fact.text, found->second.text, found->second.note});
  }
  if (compared == 0) return fmt::format("{}: nothing to compare: no figure is in both\n", about.title);
  if (table.rows().size() > 1) return table.str();
  return fmt::format("{}: no change in {} figures ({})\n", about.title, format_count(compared),
                     about.compared);
}

// ---- what only one of the two has

std::set<FactKey> keys_of(const ReportFacts& facts, bool with_exact) {
  std::set<FactKey> keys;
  for (std::size_t part = 0; part < kFactParts; ++part) {
    if (kParts[part].needs_exact && !with_exact) continue;
    for (const auto& [key, fact] : facts.parts[part]) keys.insert(key);
  }
  for (const auto* times : {&facts.times, &facts.thread_times})
    for (const auto& [key, sample] : *times)
      keys.insert({key.where, key.query, key.backend, key.what + " time"});
  return keys;
}

std::string only_in(const std::set<FactKey>& here, const std::set<FactKey>& there, const char* what) {
  std::set<std::pair<std::string, std::string>> known;
  for (const FactKey& key : there) known.emplace(key.where, key.backend);
  std::set<std::string> lines;
  for (const FactKey& key : here) {
    if (there.contains(key)) continue;
    std::string line = fmt::format("row {}: {}, {}", what, key.where, key.backend);
    if (known.contains({key.where, key.backend}))
      line += fmt::format(", {}{}{}", key.query, key.query.empty() ? "" : ", ", key.what);
    else
      line += ": all of it";
    lines.insert(line);
  }
  std::string text;
  for (const std::string& line : lines) text += line + "\n";
  return text;
}

std::string gone_and_new(const ReportFacts& before, const ReportFacts& after) {
  const bool exact = before.exact && after.exact;
  const std::set<FactKey> old_keys = keys_of(before, exact), new_keys = keys_of(after, exact);
  return only_in(old_keys, new_keys, "gone") + only_in(new_keys, old_keys, "new");
}

// ---- settings

std::string value_text(const Json& value) {
  if (value.is_number_float()) return format_error(value.get<double>());
  return value.is_string() ? value.get<std::string>() : value.dump();
}

std::string setting_changes(const Json& before, const Json& after) {
  std::string text;
  const auto compare = [&](const char* what, const Json& x, const Json& y) {
    if (x != y) text += fmt::format("  {} differs: {} -> {}\n", what, value_text(x), value_text(y));
  };
  compare("version", before.at("version"), after.at("version"));
  compare("machine", before.at("machine").at("cpu"), after.at("machine").at("cpu"));
  compare("compiler", before.at("machine").at("compiler"), after.at("machine").at("compiler"));
  compare("flags", before.at("machine").at("flags"), after.at("machine").at("flags"));
  compare("measured against exact", before.at("measured_against_exact"), after.at("measured_against_exact"));
  compare("seed", before.at("seed"), after.at("seed"));
  compare("pairs a family", before.at("timing").at("pairs_a_family"),
          after.at("timing").at("pairs_a_family"));
  return text.empty() ? "" : "settings\n" + text;
}

// ---- times

struct TimeChange {
  FactKey key;
  double ratio = 1;  // new over old
  std::size_t repetitions = 0;
  double p = 1;
  bool tested = false, resolved = false;
};

double median_of(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return middle(values);
}

using Times = std::map<FactKey, std::vector<double>>;
std::vector<TimeChange> time_changes(const Times& before, const Times& after) {
  std::vector<TimeChange> changes;
  // Only rows of both runs are compared, and tested where repetitions suffice.
  for (const auto& [key, old_sample] : before) {
    const auto found = after.find(key);
    if (found == after.end()) continue;
    const std::vector<double>& new_sample = found->second;
    TimeChange change{key};
    change.repetitions = std::min(old_sample.size(), new_sample.size());
    if (change.repetitions > 0) change.ratio = median_of(new_sample) / median_of(old_sample);
    change.tested = change.repetitions >= kLeastRepetitions;
    if (change.tested) change.p = mann_whitney_p(old_sample, new_sample);
    changes.push_back(std::move(change));
  }
  // All tests are corrected together for false discoveries.
  std::vector<double> p_values;
  for (const TimeChange& change : changes) {
    if (change.tested) p_values.push_back(change.p);
  }
  const std::vector<bool> holds = resolved(p_values, kFalseDiscoveryRate);
  std::size_t next = 0;
  for (TimeChange& change : changes) {
    if (change.tested) change.resolved = holds[next++];
  }
  // Changes that hold come first, by their size.
  std::stable_sort(changes.begin(), changes.end(), [](const TimeChange& x, const TimeChange& y) {
    if (x.resolved != y.resolved) return x.resolved;
    return std::abs(std::log(x.ratio)) > std::abs(std::log(y.ratio));
  });
  return changes;
}

std::string time_text(const char* title, const std::vector<TimeChange>& changes, bool all) {
  TextTable table(
      {std::string(title) + ": new / old", "query", "backend", "row", "ratio", "p", "repetitions", ""});
  std::size_t unresolved = 0, untested = 0;
  for (const TimeChange& change : changes) {
    unresolved += !change.resolved;
    untested += !change.tested;
    if (!change.resolved && !all) continue;
    table.add({change.key.where, change.key.query, change.key.backend, change.key.what,
               fmt::format("{:.3f}", change.ratio), change.tested ? fmt::format("{:.2g}", change.p) : "-",
               std::to_string(change.repetitions),
               !change.resolved   ? "unresolved"
               : change.ratio > 1 ? "slower"
                                  : "faster"});
  }
  std::string text = table.rows().size() == 1 ? "" : table.str();
  text += fmt::format(
      "{}: {} rows resolved, {} unresolved ({} of these with fewer than {} repetitions in one of the "
      "runs).\n",
      title, changes.size() - unresolved, unresolved, untested, kLeastRepetitions);
  return text;
}

std::string test_note() {
  return fmt::format(
      "  Mann and Whitney, exact, on the medians of the repetitions; of the resolved at most {:.0f} % "
      "expected by chance (Benjamini and Hochberg).\n  The test knows the noise within the runs; a "
      "machine that was slower throughout one of them shows as a change of every row.\n",
      100 * kFalseDiscoveryRate);
}

std::string uncompared(const Json& before, const Json& after) {
  if (before.at("broadphases").empty() || after.at("broadphases").empty()) return "";
  return "times of broadphases: not compared: no repetitions of them are kept\n";
}

}  // namespace

std::string diff_reports(const std::string& old_json, const std::string& new_json, bool all) {
  const Json before = parse_results(old_json, "diff", "the old file"),
             after = parse_results(new_json, "diff", "the new file");
  try {
    const ReportFacts old_facts = facts_of(before), new_facts = facts_of(after);
    std::string text = partial_note(before, "OLD") + partial_note(after, "NEW");
    for (std::size_t part = 0; part < kFactParts; ++part) text += part_changes(old_facts, new_facts, part);
    return text + gone_and_new(old_facts, new_facts) + setting_changes(before, after) +
           time_text("times", time_changes(old_facts.times, new_facts.times), all) +
           time_text("times on threads", time_changes(old_facts.thread_times, new_facts.thread_times), all) +
           test_note() + uncompared(before, after);
  } catch (const nlohmann::json::exception& error) {
    throw InputError("diff: a file " + reason_of(error));
  }
}

int run_diff(int argc, const char* const* argv) {
  CLI::App app{"What changed between two runs: wrongness first, then times with Mann and Whitney's p."};
  app.name("compare_backends diff");
  std::string before, after;
  bool all = false;
  app.add_option("OLD.json", before, "results.json of the earlier run")->required();
  app.add_option("NEW.json", after, "results.json of the later run")->required();
  app.add_flag("--all", all, "Also the times that noise leaves unresolved");
  if (!parse_command_line(app, argc - 1, argv + 1)) return 0;
  fmt::print("{}", diff_reports(read_file(before, "diff"), read_file(after, "diff"), all));
  return 0;
}

}  // namespace touchstone::comparison
