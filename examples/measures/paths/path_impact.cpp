#include "touchstone/examples/measures/paths/path_impact.hpp"

#include <algorithm>
#include <cmath>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/contact_core/motion/kept_gap.hpp"
#include "touchstone/contact_core/native/native.hpp"

namespace touchstone::measures {
namespace {

std::vector<Hexahedron> solids_of(std::span<const SolidPaths> paths) {
  std::vector<Hexahedron> solids;
  for (const SolidPaths& each : paths) solids.insert(solids.end(), each.solids.begin(), each.solids.end());
  return solids;
}

/// @throws InputError where the backend refuses a solid of these paths.
void ask(Narrowphase& narrowphase, std::span<const SolidPaths> paths, std::span<std::optional<Impact>> out,
         std::span<double> gaps) {
  // Both are built over the same solids: native plans for a backend that judges poses.
  const std::vector<Hexahedron> solids = solids_of(paths);
  narrowphase.build(solids);
  const auto planner = make_native();
  planner->build(solids);
  NarrowphaseQuery query(narrowphase, *planner, solids.size());
  for (std::size_t i = 0; i < paths.size(); ++i) {
    const GapRule rule = gap_rule(narrowphase, paths[i].scale);
    gaps[i] = rule.gap;
    out[i] = impact_of(paths[i], rule, query, static_cast<SolidIndex>(2 * i));
  }
}

std::vector<SolidPaths> all_paths(const PairSet& set, std::size_t poses) {
  std::vector<SolidPaths> paths;
  for (std::size_t i = 0; i * poses < set.pairs.size(); ++i) paths.push_back(paths_of(set, poses, i));
  return paths;
}

bool follows(const Sweep& sweep, const SolidPaths& paths) {
  return std::all_of(paths.ways.begin(), paths.ways.end(),
                     [&](const RigidPath& way) { return turn_of(way) <= sweep.most_turn(); });
}

/// Result of a sweep in the form of find_impact().
Impact ask_sweep(Sweep& sweep) {
  Impact impact;
  impact.status = ImpactStatus::failed;
  impact.lo = 0.0;
  try {
    const std::optional<double> s = sweep.impact();
    if (s && !std::isfinite(*s)) return impact;
    impact.status = s ? ImpactStatus::blocked : ImpactStatus::clear;
    impact.lo = impact.hi = s ? std::clamp(*s, 0.0, 1.0) : 1.0;
  } catch (const std::exception&) {  // the engine gave up
  }
  return impact;
}

}  // namespace

PosedPair posed_at(const SolidPaths& paths, double s) {
  PairSet one;
  one.solids = {paths.solids.begin(), paths.solids.end()};
  one.poses = {paths.ways[0].pose_at(s), paths.ways[1].pose_at(s)};
  one.pairs = {{0, 1}};
  return posed_pair(one, 0);
}

Impact impact_of(const SolidPaths& paths, const GapRule& rule, NarrowphaseQuery& query, SolidIndex first) {
  std::array<MovingSolid, 2> moving;
  for (std::size_t i = 0; i < 2; ++i)
    moving[i] = {.solid = &paths.solids[i], .X_OS = {}, .path = &paths.ways[i]};
  query.set_pair({first, first + 1});
  return find_impact(moving[0], moving[1], rule, query);
}

GapRule gap_rule(const Narrowphase& narrowphase, double scale) {
  if (!gives_signed_distance(narrowphase)) return {kPathGap};
  return {kept_gap(kPathGap, narrowphase.capabilities().resolution, scale)};
}

PathAnswers run_paths(const BackendRegistry::NarrowphaseEntry& backend, const PairSet& set,
                      std::size_t poses) {
  const std::vector<SolidPaths> paths = all_paths(set, poses);
  PathAnswers answers;
  answers.backend = backend.name;
  answers.impacts.resize(paths.size());
  answers.gaps.resize(paths.size());
  const std::span impacts(answers.impacts);
  const std::span gaps(answers.gaps);
  const auto narrowphase = backend.make();
  try {
    ask(*narrowphase, paths, impacts, gaps);
  } catch (const InputError&) {
    // A solid is refused: every path on its own, so that the others get their answers.
    for (std::size_t i = 0; i < paths.size(); ++i) {
      try {
        ask(*narrowphase, std::span(paths).subspan(i, 1), impacts.subspan(i, 1), gaps.subspan(i, 1));
      } catch (const InputError&) {
        continue;
      }
    }
  }
  return answers;
}

PathAnswers run_sweep(const SweepEntry& entry, const PairSet& set, std::size_t poses) {
  PathAnswers answers;
  answers.backend = entry.name;
  answers.sweep = entry.description;
  const std::unique_ptr<Sweep> sweep = entry.make();
  for (const SolidPaths& each : all_paths(set, poses)) {
    answers.gaps.push_back(kPathGap);
    std::optional<Impact>& impact = answers.impacts.emplace_back();
    if (!follows(*sweep, each)) continue;
    try {
      sweep->set(each.solids[0], each.ways[0], each.solids[1], each.ways[1]);
      impact = ask_sweep(*sweep);
    } catch (const InputError&) {
      continue;
    }
  }
  return answers;
}

}  // namespace touchstone::measures
