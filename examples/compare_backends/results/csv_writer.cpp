#include <fmt/format.h>

#include "touchstone/examples/compare_backends/results/json_writer.hpp"
#include "touchstone/examples/program/files/csv.hpp"

namespace touchstone::comparison {
namespace {

std::string cells(const std::optional<Timing>& timing) {
  return timing ? csv_number(timing->median_ns) + "," + csv_number(shown_p99(*timing)) : ",";
}

std::string cells(const Quantiles& quantiles, const SetResult& set) {
  if (quantiles.count == 0) return ",,,";
  return fmt::format("{},{},{},{}", csv_number(quantiles.median), csv_number(quantiles.p99),
                     csv_number(quantiles.worst), csv_text(case_id(set, quantiles.worst_case)));
}

void append_header(std::string& csv) {
  csv += "set,backend,query,cases,missed,phantom,undecided,failed,unsupported,missing_value,";
  csv +=
      "single_median_ns,single_p99_ns,batch_median_ns,batch_p99_ns,raw_median_ns,raw_p99_ns,cached_median_ns,"
      "cached_p99_ns,frame_median_ns,";
  csv += "frame_p99_ns,allocations_per_query,worst_cost_m,worst_cost_case,worst_cost_reason";
  for (std::size_t m = 0; m < kMeasures; ++m) {
    const auto measure = static_cast<Measure>(m);
    for (const char* unit : {"S", "size"}) {
      if (!is_length(measure) && unit == std::string_view("size")) continue;
      const std::string name = is_length(measure) ? fmt::format("{}_over_{}", to_string(measure), unit)
                                                  : std::string(to_string(measure));
      csv += fmt::format(",{0}_median,{0}_p99,{0}_worst,{0}_worst_case", name);
    }
  }
  csv += ",partial\n";
}

bool belongs_to(Measure measure, QueryKind kind) {
  if (kind == QueryKind::overlap) return false;
  return (measure >= Measure::deepest) == (kind == QueryKind::manifold);
}

void append_row(std::string& csv, const SetResult& set, const BackendResult& backend, QueryKind kind,
                bool partial) {
  const std::size_t q = index_of(kind);
  const Judgement& judgement = backend.judgement;
  csv += fmt::format("{},{},{},{}", set.name, backend.name, to_string(kind), set.cases);
  // Columns stay, empty where exact answers are missing.
  if (backend.judged) {
    const Wrongness& wrong = judgement.wrongness[q];
    csv += fmt::format(",{},{},{},{},{},{}", wrong.missed, wrong.phantom, wrong.undecided, wrong.failed,
                       wrong.unsupported, wrong.missing);
  } else {
    csv += ",,,,,,";
  }
  // Times of all modes follow, then those of frames.
  const BackendResult::Rows& rows = backend.rows[q];
  csv += "," + cells(rows.single) + "," + cells(rows.batch) + "," + cells(rows.raw) + "," +
         cells(rows.cached) + "," + cells(backend.frame[q]);
  csv += "," + (rows.allocations ? csv_number(*rows.allocations) : "");
  // The worst case is named, so that it can be replayed.
  if (backend.judged) {
    csv += fmt::format(",{},{},{}", csv_number(judgement.worst[q].cost),
                       csv_text(case_id(set, judgement.worst[q].index)), judgement.worst[q].reason);
  } else {
    csv += ",,,";
  }
  // Measures of other queries keep their columns.
  for (std::size_t m = 0; m < kMeasures; ++m) {
    const auto measure = static_cast<Measure>(m);
    const bool shown = backend.judged && belongs_to(measure, kind);
    csv += "," + cells(shown ? judgement.errors[m].over_scale : Quantiles{}, set);
    if (is_length(measure)) csv += "," + cells(shown ? judgement.errors[m].over_size : Quantiles{}, set);
  }
  csv += partial ? ",1\n" : ",0\n";
}

void append_set(std::string& csv, const SetResult& set, bool partial) {
  for (const BackendResult& backend : set.backends) {
    for (const QueryKind kind : kQueryKinds) append_row(csv, set, backend, kind, partial);
  }
}

}  // namespace

std::string results_csv(const Report& report) {
  std::string csv;
  append_header(csv);
  const bool partial = !report.not_measured.empty();
  for (const SetResult& set : report.sets) append_set(csv, set, partial);
  for (const SceneResult& scene : report.scenes) append_set(csv, scene.set, partial);
  return csv;
}

}  // namespace touchstone::comparison
