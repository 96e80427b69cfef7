#include <fmt/format.h>

#include <cmath>

#include "touchstone/examples/compare_backends/results/answers_writer.hpp"
#include "touchstone/examples/program/files/csv.hpp"
#include "touchstone/examples/program/files/json.hpp"

namespace touchstone::comparison {
namespace {

Json vector(const Vector3& v) {
  if (!is_finite(v)) return nullptr;
  return {v.x(), v.y(), v.z()};
}

// The figures of one answer, from whichever query carries them.
struct Answer {
  PairStatus status;
  PairGeometry geometry;
  std::span<const ContactPoint> points;
};

Answer answer_of(const BackendAnswers& backend, std::size_t index) {
  const QueryAnswers& distance = backend.queries[index_of(QueryKind::distance)];
  const QueryAnswers& manifold = backend.queries[index_of(QueryKind::manifold)];
  Answer answer{distance.status[index], distance.geometry[index], {}};
  if (answer.status == PairStatus::unsupported) {
    answer.status = backend.queries[index_of(QueryKind::overlap)].status[index];
  }
  const PairStatus status = manifold.status[index];
  if (status != PairStatus::failed && status != PairStatus::unsupported) {
    const int count = std::clamp(manifold.geometry[index].point_count, 0, kMaxManifoldPoints);
    answer.points =
        std::span(manifold.points).subspan(index * kMaxManifoldPoints, static_cast<std::size_t>(count));
  }
  return answer;
}

Json json_answer(const BackendAnswers& backend, std::size_t index) {
  const Answer answer = answer_of(backend, index);
  Json json = {{"backend", backend.name},
               {"status", to_string(answer.status)},
               {"separation", number(answer.geometry.separation)},
               {"normal", vector(answer.geometry.n_AB_W)},
               {"witness_a", vector(answer.geometry.p_A_W)},
               {"witness_b", vector(answer.geometry.p_B_W)},
               {"points", Json::array()}};
  for (const QueryKind kind : kQueryKinds) {
    json["status_by_query"][to_string(kind)] = to_string(backend.queries[index_of(kind)].status[index]);
  }
  for (const ContactPoint& point : answer.points) {
    json["points"].push_back(
        {{"a", vector(point.p_A_W)}, {"b", vector(point.p_B_W)}, {"separation", number(point.separation)}});
  }
  return json;
}

std::string csv_vector(const Vector3& v) {
  if (!is_finite(v)) return ",,";
  return fmt::format("{},{},{}", v.x(), v.y(), v.z());
}

}  // namespace

std::string answers_json(const PairFileResult& result) {
  Json root;
  root["schema"] = "touchstone.compare_backends.answers/1";
  root["file"] = result.cases.file;
  root["cases"] = Json::array();
  for (const PairFileCases::Case& each : result.cases.cases) {
    Json json = {{"id", each.id}};
    // An invalid case keeps its place, with the reason.
    if (!each.invalid.empty()) {
      json["status"] = "invalid";
      json["reason"] = each.invalid;
      root["cases"].push_back(json);
      continue;
    }
    // Backends are read against the exact answer, where there is one.
    if (!result.truth.empty()) {
      const PairTruth& truth = result.truth[each.index];
      json["exact"] = {{"class", to_string(truth.pair_class)},
                       {"separation", number(truth.separation)},
                       {"normal", vector(truth.n_AB_W)},
                       {"normal_unique", truth.normal_unique}};
    }
    json["answers"] = Json::array();
    for (const BackendAnswers& backend : result.answers)
      json["answers"].push_back(json_answer(backend, each.index));
    root["cases"].push_back(json);
  }
  return root.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";  // paths and names may be no UTF-8
}

std::string answers_csv(const PairFileResult& result) {
  std::string csv =
      "id,backend,status,reason,separation,normal_x,normal_y,normal_z,witness_a_x,witness_a_y,witness_a_z,";
  csv += "witness_b_x,witness_b_y,witness_b_z,point_count,points\n";
  for (const PairFileCases::Case& each : result.cases.cases) {
    if (!each.invalid.empty()) {
      csv += csv_text(each.id) + ",,invalid," + csv_text(each.invalid) + ",,,,,,,,,,,,\n";
      continue;
    }
    for (const BackendAnswers& backend : result.answers) {
      const Answer answer = answer_of(backend, each.index);
      const PairGeometry& geometry = answer.geometry;
      std::string points;
      for (const ContactPoint& point : answer.points) {
        points += fmt::format("{}{} {} {} {}", points.empty() ? "" : "; ", point.p_A_W.x(), point.p_A_W.y(),
                              point.p_A_W.z(), point.separation);
      }
      csv +=
          fmt::format("{},{},{},,{},{},{},{},{},{}\n", csv_text(each.id), backend.name,
                      to_string(answer.status), csv_number(geometry.separation), csv_vector(geometry.n_AB_W),
                      csv_vector(geometry.p_A_W), csv_vector(geometry.p_B_W), answer.points.size(), points);
    }
  }
  return csv;
}

}  // namespace touchstone::comparison
