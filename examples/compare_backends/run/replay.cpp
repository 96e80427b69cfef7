#include "touchstone/examples/compare_backends/run/replay.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/examples/compare_backends/judge/path_result.hpp"
#include "touchstone/examples/measures/pairs/pair_families.hpp"
#include "touchstone/examples/program/terminal/text_table.hpp"

namespace touchstone::comparison {
namespace {

PairSet single_case(const PairSet& set, std::size_t index) {
  const SolidPair pair = set.pairs[index % set.pairs.size()];
  const auto poses = set.frame_poses(index / set.pairs.size());
  PairSet one;
  one.name = set.name;
  one.description = set.description;
  one.solids = {set.solids[pair.a], set.solids[pair.b]};
  one.poses = {poses[pair.a], poses[pair.b]};
  one.pairs = {{0, 1}};
  one.ids = {case_id(set, index)};
  return one;
}

std::optional<std::size_t> whole_number(const std::string& text) {
  std::size_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

bool is_family(const std::string& name) {
  return std::any_of(pair_families().begin(), pair_families().end(),
                     [&](const PairFamily& family) { return family.name == name; });
}

std::string text(const Vector3& v) { return fmt::format("({}, {}, {})", v.x(), v.y(), v.z()); }

std::string describe_solid(const char* name, const Hexahedron& solid, const Pose& X_WS) {
  std::string out = fmt::format("{}: ", name);
  if (solid.is_box()) {
    out += "box, half sides " + text(solid.half_extents()) + "\n";
  } else {
    out += solid.is_warped() ? fmt::format("warped hexahedron, vertices up to {:.3g} m out of plane\n",
                                           solid.out_of_plane())
                             : "hexahedron\n";
    for (const Vector3& vertex : solid.vertices()) out += "     " + text(vertex) + "\n";
  }
  out += "   position " + text(X_WS.p) + "\n";
  for (int row = 0; row < 3; ++row) {
    out += fmt::format("   {} [{}, {}, {}]\n", row == 0 ? "rotation" : "        ", X_WS.R(row, 0),
                       X_WS.R(row, 1), X_WS.R(row, 2));
  }
  return out;
}

std::string describe_errors(const PosedPair& posed, const PairTruth& truth, const Oracle& oracle,
                            const BackendAnswers& answers) {
  const CaseErrors errors = case_errors(posed, truth, oracle, answers, 0);
  std::string out;
  for (const QueryKind kind : kQueryKinds) {
    const CaseCost& cost = errors.cost(kind);
    if (errors.unsupported[index_of(kind)])
      out += fmt::format("    {} is unsupported\n", to_string(kind));
    else
      out += fmt::format("    {} costs {} m{}{}\n", to_string(kind), format_error(cost.cost),
                         *cost.reason ? ": " : "", cost.reason);
  }
  for (std::size_t m = 0; m < kMeasures; ++m) {
    if (errors.values[m] == errors.values[m]) {
      out += fmt::format("    error of {}: {}{}\n", to_string(static_cast<Measure>(m)), errors.values[m],
                         is_length(static_cast<Measure>(m)) ? " m" : "");
    }
  }
  return out;
}

std::string describe_answer(const BackendAnswers& answers) {
  std::string out = answers.name + "\n";
  if (!answers.failure.empty()) out += "    " + answers.failure + "\n";
  for (const QueryKind kind : kQueryKinds) {
    const QueryAnswers& of_kind = answers.queries[index_of(kind)];
    out += fmt::format("    {}: {}", to_string(kind), to_string(of_kind.status[0]));
    if (!of_kind.geometry.empty()) {
      const PairGeometry& geometry = of_kind.geometry[0];
      out += fmt::format(", separation {}, normal {}, p_A {}, p_B {}", geometry.separation,
                         text(geometry.n_AB_W), text(geometry.p_A_W), text(geometry.p_B_W));
      if (!of_kind.points.empty()) {
        for (int i = 0; i < std::clamp(geometry.point_count, 0, kMaxManifoldPoints); ++i) {
          out += fmt::format("\n      point {} separation {}", text(of_kind.points[i].p_A_W),
                             of_kind.points[i].separation);
        }
      }
    }
    out += "\n";
  }
  return out;
}

/// The ends of the path that `id` names in the file of pairs, as a path of two poses.
std::optional<PairSet> find_path(const Options& options, const std::string& id) {
  if (options.pairs_file.empty()) return std::nullopt;
  const PairFileCases file = load_pair_file(options.pairs_file);
  const auto end_named = [&](const std::string& name) {
    return std::find_if(file.cases.begin(), file.cases.end(), [&](const PairFileCases::Case& each) {
      return each.id == id + name && each.invalid.empty();
    });
  };
  const auto start = end_named("@start"), end = end_named("@end");
  if (start == file.cases.end() || end == file.cases.end()) return std::nullopt;
  PairSet path = single_case(file.set, start->index);
  const PairSet last = single_case(file.set, end->index);
  path.solids.insert(path.solids.end(), last.solids.begin(), last.solids.end());
  path.poses.insert(path.poses.end(), last.poses.begin(), last.poses.end());
  path.pairs.push_back({2, 3});
  path.ids.push_back(end->id);
  return path;
}

std::string describe_stop(const PathBackendResult& result) {
  const PathFault& answer = result.worst;
  if (result.answered == 0) return result.name + "\n    not taken\n";
  return fmt::format("{}\n    {}: {}, costs {} m\n", result.name, result.check,
                     stop_text(answer.s, answer.reason), format_error(answer.cost));
}

std::string replay_path(const PairSet& path, const Options& options, const Backends& backends,
                        const Oracle* oracle) {
  if (oracle == nullptr)
    throw InputError("--case " + options.case_id +
                     ": a path is judged by 'exact', which is not in this build");
  constexpr std::size_t kEnds = 2;
  std::string out = options.case_id + "\n";
  for (std::size_t i = 0; i < path.solids.size(); ++i)
    out += describe_solid(i % 2 == 0 ? "A" : "B", path.solids[i], path.poses[i]);
  // The truth, as the corpus has it.
  const std::vector<PairTruth> ends = compute_truth(path, *oracle, 1);
  const std::vector<PathTruth> truth = compute_path_truth(path, kEnds, *oracle, 1);
  out += fmt::format("exact: {}, s in [{}, {}]\n", to_string(truth[0].path_class), truth[0].lo, truth[0].hi);
  const auto stop = [&](const PathAnswers& answers) {
    return describe_stop(judge_paths(path, kEnds, truth, ends, answers, {}, *oracle));
  };
  // Backends of this process, then the sweeps of their engines.
  std::string sweeps;
  for (const auto& [name, description] : chosen_backends(options, backends)) {
    if (std::any_of(backends.workers.begin(), backends.workers.end(),
                    [&](const Worker& worker) { return worker.offers(name); })) {
      out += name + "\n    runs in a process of its own, which is asked about poses alone\n";
      continue;
    }
    out += stop(run_paths(backends.registry.narrowphase(name), path, kEnds));
    for (const SweepEntry& sweep : backends.sweeps)
      if (sweep.backend == name) sweeps += stop(run_sweep(sweep, path, kEnds));
  }
  return out + sweeps;
}

}  // namespace

PairSet find_case(const Options& options, const std::string& id) {
  // Files come before families, since an id of theirs may look like a family's.
  if (!options.pairs_file.empty()) {
    const PairFileCases file = load_pair_file(options.pairs_file);
    for (const PairFileCases::Case& each : file.cases) {
      if (each.id != id) continue;
      if (!each.invalid.empty())
        throw InputError(options.pairs_file + ": case '" + id + "' is invalid: " + each.invalid);
      return single_case(file.set, each.index);
    }
  }
  if (!options.corpus.empty()) {
    const Corpus corpus = load_corpus(options.corpus);
    for (const CorpusSet& each : corpus.sets) {
      const PairSet set = corpus_pairs(corpus, each);
      const auto found = std::find(set.ids.begin(), set.ids.end(), id);
      if (found != set.ids.end()) return single_case(set, static_cast<std::size_t>(found - set.ids.begin()));
    }
  }
  for (const std::string& scene : options.scenes) {
    const PairSet set = load_scene_frames(scene, parameters_for(scene, options.scene_settings)).set;
    const auto found = std::find(set.ids.begin(), set.ids.end(), id);
    if (found != set.ids.end()) return single_case(set, static_cast<std::size_t>(found - set.ids.begin()));
  }
  // An id of a family is enough to make the pair anew.
  const std::size_t colon = id.find(':');
  if (colon != std::string::npos && is_family(id.substr(0, colon))) {
    if (const auto index = whole_number(id.substr(colon + 1))) {
      return make_family_pair(id.substr(0, colon), options.seed, *index);
    }
  }
  throw InputError(
      "--case " + id +
      ": no such case; give family:index, or --pairs, --corpus or --scene with an id of that file");
}

std::string replay_case(const Options& options, const Backends& backends, const Oracle* oracle) {
  if (const auto path = find_path(options, options.case_id))
    return replay_path(*path, options, backends, oracle);
  const PairSet set = find_case(options, options.case_id);
  const PosedPair posed = posed_pair(set, 0);
  std::string out = fmt::format("{} (seed {})\n", case_id(set, 0), options.seed);
  out += describe_solid("A", set.solids[0], set.poses[0]) + describe_solid("B", set.solids[1], set.poses[1]);
  out += fmt::format("size {} m, S {} m\n", posed.size, posed.scale);
  PairTruth truth;
  if (oracle != nullptr) {
    truth = oracle->truth(posed.a, posed.b);
    out +=
        fmt::format("exact: {}, separation {}, normal {}{}\n", to_string(truth.pair_class), truth.separation,
                    text(truth.n_AB_W), truth.normal_unique ? "" : " (not the only one)");
  } else {
    out += "exact: not in this build\n";
  }
  MeasureOptions measure;
  measure.seed = options.seed;
  measure.time_pairs = false;
  for (const BackendAnswers& answers : answer_set(options, backends, set, measure)) {
    out += describe_answer(answers);
    if (oracle != nullptr) out += describe_errors(posed, truth, *oracle, answers);
  }
  return out;
}

}  // namespace touchstone::comparison
