#include "examples/compare_backends/diff.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>

#include "contact_core/input_error.hpp"
#include "examples/compare_backends/mann_whitney.hpp"
#include "examples/compare_backends/results_file.hpp"
#include "examples/program/program.hpp"
#include "examples/program/text_table.hpp"

namespace touchstone::comparison {
namespace {

constexpr const char* kKinds[] = {"missed", "phantom", "undecided", "failed", "unsupported", "missing_value"};
constexpr const char* kModes[] = {"single", "cached", "batch", "raw", "frame"};

// Set, backend and query: what one row of the comparison is about.
struct Subject {
  std::string set, backend, query;
  auto operator<=>(const Subject&) const = default;
};
using Rows = std::map<Subject, Json>;

void add_rows(const Json& set, Rows& rows) {
  for (const Json& backend : set.at("backends")) {
    for (const auto& [query, row] : backend.at("queries").items())
      rows[{set.at("name"), backend.at("backend"), query}] = row;
  }
}

Rows rows_of(const Json& report) {
  Rows rows;
  for (const Json& set : report.at("pair_sets")) add_rows(set, rows);
  for (const Json& scene : report.at("scenes")) add_rows(scene.at("cases"), rows);
  return rows;
}

std::string value_text(const Json& value) {
  if (value.is_number_float()) return format_error(value.get<double>());
  return value.is_string() ? value.get<std::string>() : value.dump();
}

void both(const Rows& before, const Rows& after,
          const std::function<void(const Subject&, const Json&, const Json&)>& visit) {
  for (const auto& [subject, row] : before) {
    const auto found = after.find(subject);
    if (found != after.end()) visit(subject, row, found->second);
  }
}

// ---- what the answers changed in

std::string setting_changes(const Json& before, const Json& after) {
  std::string text;
  const auto compare = [&](const char* what, const Json& x, const Json& y) {
    if (x != y) text += fmt::format("  {} differs: {} -> {}\n", what, value_text(x), value_text(y));
  };
  compare("version", before.at("version"), after.at("version"));
  compare("machine", before.at("machine").at("cpu"), after.at("machine").at("cpu"));
  compare("compiler", before.at("machine").at("compiler"), after.at("machine").at("compiler"));
  compare("flags", before.at("machine").at("flags"), after.at("machine").at("flags"));
  compare("seed", before.at("seed"), after.at("seed"));
  compare("pairs a family", before.at("timing").at("pairs_a_family"),
          after.at("timing").at("pairs_a_family"));
  return text.empty() ? "" : "settings\n" + text;
}

std::string wrongness_changes(const Rows& before, const Rows& after) {
  TextTable table({"wrong answers", "query", "backend", "kind", "old", "new"});
  both(before, after, [&](const Subject& subject, const Json& x, const Json& y) {
    if (!x.contains("wrong") || !y.contains("wrong")) return;
    for (const char* kind : kKinds) {
      const std::size_t old_count = x["wrong"].at(kind), new_count = y["wrong"].at(kind);
      const std::size_t old_cases = x["wrong"].at("cases"), new_cases = y["wrong"].at("cases");
      if (old_count == new_count && (old_cases == new_cases || new_count == 0)) continue;
      table.add({subject.set, subject.query, subject.backend, kind,
                 format_count(old_count) + " of " + format_count(old_cases),
                 format_count(new_count) + " of " + format_count(new_cases)});
    }
  });
  return table.rows().size() == 1 ? "wrong answers: no change\n" : table.str();
}

std::string error_changes(const Rows& before, const Rows& after) {
  TextTable table({"worst error / S", "query", "backend", "old", "new", "case"});
  both(before, after, [&](const Subject& subject, const Json& x, const Json& y) {
    if (!x.contains("cost_over_S") || !y.contains("cost_over_S") || x["cost_over_S"].is_null() ||
        y["cost_over_S"].is_null() || x["cost_over_S"]["worst"] == y["cost_over_S"]["worst"])
      return;
    table.add({subject.set, subject.query, subject.backend, value_text(x["cost_over_S"]["worst"]),
               value_text(y["cost_over_S"]["worst"]), y["cost_over_S"]["worst_case"].get<std::string>()});
  });
  return table.rows().size() == 1 ? "worst errors: no change\n" : table.str();
}

std::string only_in_one(const Rows& before, const Rows& after) {
  const auto list = [](const Rows& here, const Rows& there, const char* which) {
    std::map<std::string, std::size_t> missing;
    for (const auto& [subject, row] : here) {
      if (!there.contains(subject)) ++missing[subject.set + ", " + subject.backend];
    }
    std::string text;
    for (const auto& [what, count] : missing) text += fmt::format("  only in the {}: {}\n", which, what);
    return text;
  };
  return list(before, after, "old") + list(after, before, "new");
}

// ---- times

struct TimeChange {
  Subject subject;
  std::string mode;
  double ratio = 1;  // new over old
  std::size_t repetitions = 0;
  double p = 1;
  bool tested = false, resolved = false;
};

double median_of(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t half = values.size() / 2;
  return values.size() % 2 ? values[half] : (values[half - 1] + values[half]) / 2;
}

std::vector<TimeChange> time_changes(const Rows& before, const Rows& after) {
  std::vector<TimeChange> changes;
  both(before, after, [&](const Subject& subject, const Json& x, const Json& y) {
    for (const char* mode : kModes) {
      if (!x.contains(mode) || !y.contains(mode) || x[mode].is_null() || y[mode].is_null()) continue;
      const auto old_sample = x[mode].value("repetition_medians_ns", std::vector<double>{});
      const auto new_sample = y[mode].value("repetition_medians_ns", std::vector<double>{});
      TimeChange change{subject, mode};
      change.repetitions = std::min(old_sample.size(), new_sample.size());
      if (change.repetitions == 0) continue;
      change.ratio = median_of(new_sample) / median_of(old_sample);
      change.tested = change.repetitions >= kLeastRepetitions;
      if (change.tested) change.p = mann_whitney_p(old_sample, new_sample);
      changes.push_back(std::move(change));
    }
  });
  std::vector<double> p_values;
  for (const TimeChange& change : changes) {
    if (change.tested) p_values.push_back(change.p);
  }
  const std::vector<bool> holds = resolved(p_values, kFalseDiscoveryRate);
  std::size_t next = 0;
  for (TimeChange& change : changes) {
    if (change.tested) change.resolved = holds[next++];
  }
  std::stable_sort(changes.begin(), changes.end(), [](const TimeChange& x, const TimeChange& y) {
    if (x.resolved != y.resolved) return x.resolved;
    return std::abs(std::log(x.ratio)) > std::abs(std::log(y.ratio));
  });
  return changes;
}

std::string time_text(const std::vector<TimeChange>& changes, bool all) {
  TextTable table({"times: new / old", "query", "backend", "row", "ratio", "p", "repetitions", ""});
  std::size_t unresolved = 0, untested = 0;
  for (const TimeChange& change : changes) {
    unresolved += !change.resolved;
    untested += !change.tested;
    if (!change.resolved && !all) continue;
    table.add({change.subject.set, change.subject.query, change.subject.backend, change.mode,
               fmt::format("{:.3f}", change.ratio), change.tested ? fmt::format("{:.2g}", change.p) : "-",
               std::to_string(change.repetitions),
               !change.resolved   ? "unresolved"
               : change.ratio > 1 ? "slower"
                                  : "faster"});
  }
  std::string text = table.rows().size() == 1 ? "" : table.str();
  text += fmt::format(
      "times: {} rows resolved, {} unresolved ({} of these with fewer than {} repetitions in one of the "
      "runs).\n",
      changes.size() - unresolved, unresolved, untested, kLeastRepetitions);
  return text +
         fmt::format(
             "  Mann and Whitney, exact, on the medians of the repetitions; of the resolved at most {:.0f} % "
             "expected by chance (Benjamini and Hochberg).\n  The test knows the noise within the runs; a "
             "machine that was slower throughout one of them shows as a change of every row.\n",
             100 * kFalseDiscoveryRate);
}

}  // namespace

std::string diff_reports(const std::string& old_json, const std::string& new_json, bool all) {
  const Json before = parse_results(old_json, "diff", "the old file"),
             after = parse_results(new_json, "diff", "the new file");
  try {
    const Rows old_rows = rows_of(before), new_rows = rows_of(after);
    return wrongness_changes(old_rows, new_rows) + error_changes(old_rows, new_rows) +
           only_in_one(old_rows, new_rows) + setting_changes(before, after) +
           time_text(time_changes(old_rows, new_rows), all);
  } catch (const nlohmann::json::exception& error) {
    throw InputError(std::string("diff: ") + error.what());
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
