#include <algorithm>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/examples/compare_backends/run/sets/pair_file_run.hpp"

#ifdef TOUCHSTONE_HAS_SCENE_FILES
#include "touchstone/adapters/scene_files/pair_file.hpp"
#endif

namespace touchstone::comparison {

#ifdef TOUCHSTONE_HAS_SCENE_FILES

namespace {

PairGeometry unknown_geometry() {
  const Vector3 unknown = Vector3::Constant(kNaN);
  return {kNaN, unknown, unknown, unknown, 0};
}

/// One case's answer as the backends give theirs: a contact has a depth, a pair that is apart its class only.
void add_answer(const std::optional<CapturedAnswer>& captured, BackendAnswers& out) {
  for (const QueryKind kind : kQueryKinds) {
    QueryAnswers& answers = out.queries[index_of(kind)];
    answers.status.push_back(PairStatus::unsupported);
    answers.geometry.push_back(unknown_geometry());
    if (kind == QueryKind::manifold) answers.points.resize(answers.points.size() + kMaxManifoldPoints);
    if (!captured || (!captured->contact && kind == QueryKind::distance)) continue;
    answers.status.back() = captured->contact ? PairStatus::overlapping : PairStatus::separated;
    if (!captured->contact) continue;
    const ContactPoint& deepest = captured->points.front();
    answers.geometry.back() = {captured->separation, captured->n_AB_W, deepest.p_A_W, deepest.p_B_W, 0};
    if (kind != QueryKind::manifold) continue;
    answers.geometry.back().point_count = static_cast<std::int32_t>(captured->points.size());
    std::copy(captured->points.begin(), captured->points.end(), answers.points.end() - kMaxManifoldPoints);
  }
}

std::string nothing_to_compare(const PairFileCases& file) {
  if (file.cases.empty()) return file.file + ": has no cases: there is nothing to compare";
  const PairFileCases::Case& first = file.cases.front();
  return file.file + ": none of its " + std::to_string(file.cases.size()) +
         " cases is a pair of solids: there is nothing to compare; the first, '" + first.id +
         "': " + first.invalid;
}

}  // namespace

PairFileCases load_pair_file(const std::string& file) {
  PairFileCases result;
  BackendAnswers captured;
  captured.name = "captured";
  captured.capabilities.penetration = captured.capabilities.manifold = true;
  result.file = file;
  result.set.name = "pairs";
  result.set.description = "the cases of " + file;
  for (const PairCase& each : load_pairs(file)) {
    result.cases.push_back({each.id, each.pair ? "" : each.invalid_reason, result.set.pairs.size()});
    if (!each.pair) continue;
    const auto first = static_cast<SolidIndex>(result.set.solids.size());
    for (int i = 0; i < 2; ++i) {
      result.set.solids.push_back(each.pair->solids[i]);
      result.set.poses.push_back(each.pair->X_WS[i]);
    }
    result.set.pairs.push_back({first, first + 1});
    result.set.ids.push_back(each.id);
    add_answer(each.captured, captured);
    if (each.captured) captured.description = "as captured in " + each.captured->by;
  }
  if (result.set.pairs.empty()) throw InputError(nothing_to_compare(result));
  if (!captured.description.empty()) result.captured = std::move(captured);
  return result;
}

#else

PairFileCases load_pair_file(const std::string& file) {
  throw InputError(file + ": this build reads no pair files (adapter scene_files is off)");
}

#endif

}  // namespace touchstone::comparison
