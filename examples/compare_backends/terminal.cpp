#include "examples/compare_backends/terminal.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "examples/compare_backends/text_table.hpp"

namespace touchstone::comparison {
namespace {

double median(const std::optional<Timing>& timing) {
  return timing ? timing->median_ns : std::numeric_limits<double>::quiet_NaN();
}

// What the ratio columns divide by: native's one-pair-a-call median, else the fastest one's.
double reference(const SetResult& set, QueryKind kind) {
  double fastest = std::numeric_limits<double>::quiet_NaN();
  for (const BackendResult& backend : set.backends) {
    const double ns = median(backend.rows[index_of(kind)].single);
    if (backend.name == "native" && !std::isnan(ns)) return ns;
    fastest = std::fmin(fastest, ns);
  }
  return fastest;
}

std::string timing_table(const SetResult& set) {
  TextTable table({"ns a pair", "overlap", "ratio", "batch", "raw", "distance", "ratio", "batch", "raw",
                   "manifold", "ratio", "batch", "raw", "allocs"});
  for (const BackendResult& backend : set.backends) {
    std::vector<std::string> row = {backend.name};
    std::optional<double> allocations;
    for (const QueryKind kind : kQueryKinds) {
      const BackendResult::Rows& rows = backend.rows[index_of(kind)];
      row.push_back(format_ns(median(rows.single)));
      row.push_back(format_ratio(median(rows.single) / reference(set, kind)));
      row.push_back(format_ns(median(rows.batch)));
      row.push_back(format_ns(median(rows.raw)));
      if (rows.allocations) allocations = std::max(allocations.value_or(0), *rows.allocations);
    }
    row.push_back(allocations ? fmt::format("{:.3g}", *allocations) : "-");
    table.add(std::move(row));
  }
  return table.str();
}

std::string wrong_of(const BackendResult& backend, QueryKind kind) {
  return format_count(backend.judgement.wrongness[index_of(kind)].total());
}

const Quantiles& error_of(const BackendResult& backend, Measure measure) {
  return backend.judgement.errors[static_cast<std::size_t>(measure)].over_scale;
}

std::string error_table(const SetResult& set) {
  TextTable table({"wrong, errors/S", "missed", "phantom", "undec", "fail", "wr.over", "wr.dist", "wr.mani",
                   "dist 99%", "worst", "depth 99%", "worst", "normal", "witness", "points", "area"});
  for (const BackendResult& backend : set.backends) {
    if (!backend.judged) continue;
    const Wrongness& wrong = backend.judgement.wrongness[index_of(QueryKind::overlap)];
    table.add({backend.name, format_count(wrong.missed), format_count(wrong.phantom),
               format_count(wrong.undecided), format_count(wrong.failed),
               wrong_of(backend, QueryKind::overlap), wrong_of(backend, QueryKind::distance),
               wrong_of(backend, QueryKind::manifold), format_error(error_of(backend, Measure::distance).p99),
               format_error(error_of(backend, Measure::distance).worst),
               format_error(error_of(backend, Measure::depth).p99),
               format_error(error_of(backend, Measure::depth).worst),
               format_error(error_of(backend, Measure::normal).worst),
               format_error(error_of(backend, Measure::witness).worst),
               format_error(error_of(backend, Measure::point_witness).worst),
               format_error(error_of(backend, Measure::patch_area).p99)});
  }
  return table.str();
}

std::string set_section(const SetResult& set, bool has_truth) {
  std::string text = fmt::format("\n{}: {}\n", set.name, set.description);
  text += has_truth
              ? fmt::format("  {} pairs, {} in contact ({} exactly touching)\n", format_count(set.cases),
                            format_count(set.contacts), format_count(set.touching))
              : fmt::format("  {} pairs\n", format_count(set.cases));
  text += timing_table(set);
  if (has_truth) text += error_table(set);
  for (const BackendResult& backend : set.backends) {
    if (!backend.failure.empty()) text += fmt::format("  {}: {}\n", backend.name, backend.failure);
  }
  return text;
}

std::string broadphase_section(const Report& report) {
  TextTable table({"broadphase", "boxes", "ms a frame", "99%", "candidates", "allocs", "missed"});
  for (const BroadphaseResult& result : report.broadphases) {
    if (!result.gap.empty()) {
      table.add({result.name, format_count(result.boxes), result.gap});
      continue;
    }
    table.add({result.name, format_count(result.boxes), fmt::format("{:.3f}", result.frame.median_ns * 1e-6),
               fmt::format("{:.3f}", result.frame.p99_ns * 1e-6),
               format_count(static_cast<std::size_t>(result.candidates)),
               result.allocations ? fmt::format("{:.3g}", *result.allocations) : "-",
               result.missed ? fmt::format("{} of {}", *result.missed, format_count(result.true_pairs))
                             : "not checked"});
  }
  return "\nbroadphases: update and find_pairs of boxes that all move\n" + table.str();
}

std::string verdict_section(const Verdict& verdict) {
  std::string text = "\n" + sentence(verdict) + "\n";
  TextTable table({"backend", "inside", "ns a pair", "worst [m]", "why", "case"});
  for (const Candidate& candidate : verdict.candidates) {
    table.add({candidate.backend, candidate.inside ? "yes" : "no", format_ns(candidate.nanoseconds),
               format_error(candidate.worst_cost), candidate.worst_reason, candidate.worst_id});
  }
  return text + table.str();
}

}  // namespace

std::string terminal_report(const Report& report) {
  std::string text = fmt::format("{}, {}\n{}, {}{}\n", report.machine.cpu, report.machine.system,
                                 report.machine.compiler, report.machine.build_type, report.machine.flags);
  for (const auto& [name, description] : report.backends)
    text += fmt::format("  {:18}  {}\n", name, description);
  for (const Gap& gap : report.gaps) text += fmt::format("  {:18}  {}\n", gap.what, gap.why);
  if (!report.has_truth) text += "  without `exact` no error is measured: times only\n";
  for (const SetResult& set : report.sets) text += set_section(set, report.has_truth);
  if (!report.broadphases.empty()) text += broadphase_section(report);
  for (const Verdict& verdict : report.verdicts) {
    if (verdict.query == report.options.query) text += verdict_section(verdict);
  }
  return text;
}

}  // namespace touchstone::comparison
