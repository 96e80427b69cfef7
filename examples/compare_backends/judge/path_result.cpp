#include "touchstone/examples/compare_backends/judge/path_result.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace touchstone::comparison {
namespace {

double separation_at(const SolidPaths& paths, double s, const Oracle& oracle) {
  const PosedPair posed = posed_at(paths, s);
  return oracle.truth(posed.a, posed.b).separation;
}

/// How deep the solids are in each other where motion goes on beyond the contact: at its end and at the
/// path's own poses before it.
double depth_seen(const SolidPaths& paths, std::span<const PairTruth> poses, double hi, double end,
                  const Oracle& oracle) {
  double least = separation_at(paths, end, oracle);
  for (std::size_t k = 0; k < poses.size(); ++k) {
    const double s = static_cast<double>(k) / static_cast<double>(poses.size() - 1);
    if (s >= hi && s <= end) least = std::min(least, poses[k].separation);
  }
  return std::max(0.0, -least);
}

PathFault judge_path(const SolidPaths& paths, const PathTruth& truth, std::span<const PairTruth> poses,
                     const Impact& impact, const Oracle& oracle) {
  const bool goes_on = impact.status == ImpactStatus::clear;
  PathFault fault{paths.id, "", goes_on ? 1.0 : impact.lo, 0, 0};
  // Contacts that it passes count, however slight; what it cannot answer is open.
  if (truth.path_class == PathClass::meets && fault.s > truth.hi)
    fault.reason = goes_on ? "missed" : "late";
  else if (impact.status == ImpactStatus::failed)
    fault.reason = "failed";
  else if (impact.status == ImpactStatus::iteration_limit)
    fault.reason = "open";
  // A stop costs what is still free there.
  if (fault.reason == "missed" || fault.reason == "late")
    fault.cost = depth_seen(paths, poses, truth.hi, fault.s, oracle);
  else if (!goes_on)
    fault.cost = std::max(0.0, separation_at(paths, fault.s, oracle));
  fault.cost_over_scale = fault.cost / paths.scale;
  return fault;
}

/// The first pose that is a contact, or undecided; as many as there are: none.
template <class IsThere>
std::size_t first_of(std::size_t poses, const IsThere& is_there) {
  std::size_t k = 0;
  while (k < poses && !is_there(k)) ++k;
  return k;
}

void count_pose(std::span<const PairTruth> poses, std::span<const PairStatus> overlap,
                PathBackendResult& into) {
  const std::size_t exact = first_of(poses.size(), [&](std::size_t k) { return poses[k].contact(); });
  const std::size_t said =
      first_of(poses.size(), [&](std::size_t k) { return overlap[k] != PairStatus::separated; });
  if (said < poses.size() && overlap[said] != PairStatus::overlapping)
    ++into.pose_open;
  else
    ++(said == exact ? into.pose_right : said > exact ? into.pose_later : into.pose_earlier);
}

void count(const PathFault& fault, PathBackendResult& into) {
  ++into.answered;
  if (into.answered == 1 || fault.cost_over_scale > into.worst.cost_over_scale) into.worst = fault;
  if (fault.reason.empty()) return;
  into.faults.push_back(fault);
  ++(fault.reason == "missed"    ? into.missed
     : fault.reason == "late"    ? into.late
     : fault.reason == "phantom" ? into.phantom
     : fault.reason == "early"   ? into.early
     : fault.reason == "failed"  ? into.failed
                                 : into.open);
}

}  // namespace

std::string stop_text(double s, const std::string& reason) {
  return (s < 1 ? fmt::format("stops at s = {}", s) : std::string("clear to the end")) +
         (reason.empty() ? "" : " (" + reason + ")");
}

PathSetResult begin_paths(const PairSet& set, std::size_t poses, std::span<const PathTruth> truth,
                          std::span<const PairTruth> poses_truth) {
  PathSetResult result;
  result.name = set.name;
  result.paths = truth.size();
  result.poses = poses;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const auto here = poses_truth.subspan(i * poses, poses);
    const bool meets = truth[i].path_class == PathClass::meets;
    result.meets += meets ? 1 : 0;
    result.open += truth[i].path_class == PathClass::open ? 1 : 0;
    if (meets && std::none_of(here.begin(), here.end(), [](const PairTruth& at) { return at.contact(); }))
      ++result.unseen;
  }
  return result;
}

PathBackendResult judge_paths(const PairSet& set, std::size_t poses, std::span<const PathTruth> truth,
                              std::span<const PairTruth> poses_truth, const PathAnswers& answers,
                              std::span<const PairStatus> overlap, const Oracle& oracle) {
  PathBackendResult result;
  result.name = answers.backend;
  result.sweep = answers.sweep;
  result.why_none = answers.why_none;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const auto here = poses_truth.subspan(i * poses, poses);
    const auto said = overlap.empty() ? overlap : overlap.subspan(i * poses, poses);
    if (!said.empty()) count_pose(here, said, result);
    if (truth[i].path_class == PathClass::open || !answers.why_none.empty()) continue;
    const std::optional<Impact>& impact = answers.impacts[i];
    // Not taken: its solids were refused, or nowhere on it is there an answer of the pair.
    const bool is_unanswered = !said.empty() && std::all_of(said.begin(), said.end(), [](PairStatus status) {
      return status == PairStatus::unsupported;
    });
    if (!impact || is_unanswered) {
      ++result.unsupported;
      continue;
    }
    result.check = answers.sweep.empty() ? to_string(impact->check) : "swept";
    PathFault fault = judge_path(paths_of(set, poses, i), truth[i], here, *impact, oracle);
    // A stop on a clear path is one that nothing asked for, unless the solids come as near as the gap.
    if (fault.reason.empty() && impact->status == ImpactStatus::blocked) {
      if (truth[i].path_class == PathClass::clear && fault.cost > answers.gaps[i])
        fault.reason = "phantom";
      else if (fault.cost_over_scale >= kEarlyFrom)
        fault.reason = "early";
    }
    count(fault, result);
  }
  std::stable_sort(result.faults.begin(), result.faults.end(), [](const PathFault& x, const PathFault& y) {
    return x.cost_over_scale > y.cost_over_scale;
  });
  if (result.faults.size() > kKeptWrongCases) result.faults.resize(kKeptWrongCases);
  return result;
}

}  // namespace touchstone::comparison
