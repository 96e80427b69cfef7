#include "touchstone/examples/compare_backends/diff/diff_facts.hpp"

#include <fmt/format.h>

#include "touchstone/examples/compare_backends/results/results_file.hpp"
#include "touchstone/examples/measures/accuracy/accuracy.hpp"
#include "touchstone/examples/program/terminal/text_table.hpp"

namespace touchstone::comparison {
namespace {

constexpr const char* kKinds[] = {"missed", "phantom", "undecided", "failed", "unsupported", "missing_value"};
constexpr const char* kFrameKinds[] = {"missed_frames", "phantom_frames", "undecided_frames"};
constexpr const char* kModes[] = {"single", "cached", "batch", "raw", "frame"};
constexpr const char* kChecks[] = {"swapped", "moved", "repeated", "threads"};

bool is_of_manifold(const std::string& measure) {
  for (auto m = static_cast<std::size_t>(Measure::deepest); m < kMeasures; ++m)
    if (to_string(static_cast<Measure>(m)) == measure) return true;
  return false;
}

class Collector {
 public:
  explicit Collector(const Json& results) {
    facts_.exact = results.at("measured_against_exact").get<bool>();
    for (const Json& set : results.at("pair_sets")) add_set(set);
    for (const Json& scene : results.at("scenes")) {
      add_set(scene.at("cases"));
      for (const Json& backend : scene.at("backends")) add_frames(scene, backend);
    }
    for (const Json& broadphase : results.at("broadphases")) add_broadphase(broadphase);
    for (const Json& run : results.at("thread_runs")) add_threads(run);
  }

  ReportFacts take() { return std::move(facts_); }

 private:
  std::map<FactKey, Fact>& part(FactPart which) { return facts_.parts[static_cast<std::size_t>(which)]; }

  // None of 100 and none of 1000 are the same: the settings say how many were asked.
  void add_count(FactPart which, const FactKey& key, const Json& count, const Json& of) {
    const std::size_t n = count.get<std::size_t>(), cases = of.get<std::size_t>();
    const std::string text = format_count(n) + " of " + format_count(cases);
    part(which)[key] = {n == 0 ? Json(0) : Json(text), text, ""};
  }

  void add_number(FactPart which, const FactKey& key, const Json& value, std::string note = "") {
    if (!value.is_null()) part(which)[key] = {value, format_error(number_of(value)), std::move(note)};
  }

  void add_worst(const FactKey& key, const Json& quantiles) {
    if (quantiles.is_null()) return;
    add_number(FactPart::error, key, quantiles.at("worst"), quantiles.at("worst_case").get<std::string>());
  }

  static void add_time(std::map<FactKey, std::vector<double>>& times, const FactKey& key,
                       const Json& timing) {
    if (!timing.is_null()) times[key] = timing.at("repetition_medians_ns").get<std::vector<double>>();
  }

  void add_set(const Json& set) {
    const std::string where = set.at("name");
    for (const Json& backend : set.at("backends")) {
      const std::string name = backend.at("backend");
      for (const auto& [query, row] : backend.at("queries").items()) add_row(where, query, name, row);
      add_consistency(where, name, backend.at("consistency"));
      if (facts_.exact) add_errors(where, name, backend.at("errors"));
    }
  }

  void add_row(const std::string& where, const std::string& query, const std::string& backend,
               const Json& row) {
    for (const char* mode : kModes) add_time(facts_.times, {where, query, backend, mode}, row.at(mode));
    add_number(FactPart::allocations, {where, query, backend, "a query"}, row.at("allocations_per_query"));
    if (!facts_.exact) return;
    const Json& wrong = row.at("wrong");
    for (const char* kind : kKinds)
      add_count(FactPart::wrong, {where, query, backend, kind}, wrong.at(kind), wrong.at("cases"));
    add_worst({where, query, backend, "cost over S"}, row.at("cost_over_S"));
  }

  void add_errors(const std::string& where, const std::string& backend, const Json& errors) {
    for (const auto& [measure, of] : errors.items()) {
      const bool length = of.contains("over_S");
      add_worst({where, is_of_manifold(measure) ? "manifold" : "distance", backend,
                 measure + (length ? " over S" : "")},
                of.at(length ? "over_S" : "ratio"));
    }
  }

  void add_consistency(const std::string& where, const std::string& backend, const Json& consistency) {
    if (consistency.is_null()) return;
    for (const char* check : kChecks) {
      const Json& change = consistency.at(check);
      const Json& cases = change.at("cases");
      if (cases == 0) continue;
      const std::string name = check;
      add_count(FactPart::consistency, {where, "", backend, name + ": classes"}, change.at("classes_changed"),
                cases);
      add_count(FactPart::consistency, {where, "", backend, name + ": bits"}, change.at("bits_changed"),
                cases);
      add_number(FactPart::consistency, {where, "", backend, name + ": separation over S"},
                 change.at("worst_over_S"));
    }
  }

  void add_frames(const Json& scene, const Json& backend) {
    if (!facts_.exact) return;
    const std::string where = scene.at("name"), name = backend.at("backend");
    for (const char* kind : kFrameKinds)
      add_count(FactPart::wrong, {where, "frames", name, kind}, backend.at(kind), scene.at("frames"));
    add_number(FactPart::error, {where, "frames", name, "clearance [m]"},
               backend.at("worst_clearance_error_m"));
  }

  void add_broadphase(const Json& broadphase) {
    if (broadphase.contains("gap")) return;
    const std::string where = fmt::format("swarm of {} x {}", broadphase.at("objects").get<std::size_t>(),
                                          broadphase.at("hexahedra_each").get<std::size_t>());
    const std::string name = broadphase.at("broadphase");
    if (facts_.exact && !broadphase.at("missed").is_null())
      add_count(FactPart::wrong, {where, "", name, "missed"}, broadphase.at("missed"),
                broadphase.at("true_pairs"));
    add_number(FactPart::allocations, {where, "", name, "a frame"}, broadphase.at("allocations_per_frame"));
  }

  void add_threads(const Json& run) {
    if (run.contains("gap")) return;
    add_time(
        facts_.thread_times,
        {"threads", run.at("query"), run.at("backend"), fmt::format("on {}", run.at("threads").get<int>())},
        run.at("pass"));
  }

  ReportFacts facts_;
};

}  // namespace

ReportFacts facts_of(const Json& results) { return Collector(results).take(); }

}  // namespace touchstone::comparison
