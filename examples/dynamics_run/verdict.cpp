#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "touchstone/examples/dynamics_run/results.hpp"
#include "touchstone/physics/contact_laws.hpp"

namespace touchstone::dynamics {
namespace {

/// Times closer than this are one: other work on the machine shifts them by as much.
constexpr double kAsFast = 1.1;

/// Of the rotation between two attitudes: |R1 - R2| (Frobenius) is 2 sqrt(2) sin(angle / 2).
double angle_between(const Matrix3& R1, const Matrix3& R2) {
  double squares = 0.0;
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) squares += (R1(i, k) - R2(i, k)) * (R1(i, k) - R2(i, k));
  return 2.0 * std::asin(std::min(1.0, std::sqrt(squares / 8.0)));
}

/// Whether it went to the end: only then are its final poses those of another's.
bool is_whole(const BackendRun& run) { return run.not_run.empty() && run.stopped.empty(); }

void compare_poses(const BackendRun& reference, BackendRun& run) {
  run.pose_error = run.angle_error = 0.0;
  for (std::size_t o = 0; o < run.last.size(); ++o) {
    run.pose_error = physics::worse_of(run.pose_error, norm(run.last[o].p - reference.last[o].p));
    run.angle_error = physics::worse_of(run.angle_error, angle_between(run.last[o].R, reference.last[o].R));
  }
}

void find_misses(const SceneResult& result, BackendRun& run) {
  const physics::SceneAccept& accept = result.scene->accept;
  const auto miss = [&](bool is_off, const std::string& what) {
    if (is_off) run.misses.push_back(what);
  };
  miss(!run.not_run.empty(), "not run");
  miss(!run.stopped.empty(), "stopped " + run.stopped);
  if (!run.misses.empty()) return;
  std::size_t wrong = 0;
  if (result.scene->answers_hold)
    for (const AnswerResult& answer : run.answers) wrong += answer.holds ? 0 : 1;
  miss(wrong > 0, fmt::format("{} of {} answers off", wrong, run.answers.size()));
  // What is no number is no match.
  miss(!(run.deepest <= accept.depth), fmt::format("{:.2g} mm deep", 1e3 * run.deepest));
  const bool has_reference = std::isfinite(run.pose_error) && std::isfinite(run.angle_error);
  miss(!has_reference, "no reference");
  miss(has_reference && run.pose_error > accept.position,
       fmt::format("ends {:.2g} mm off", 1e3 * run.pose_error));
  miss(has_reference && run.angle_error > accept.angle, fmt::format("ends {:.2g} rad off", run.angle_error));
  miss(!(run.energy_made <= accept.energy_made * run.energy_scale),
       fmt::format("makes {:.2g} J", run.energy_made));
}

/// Fewer misses; of those without any the most accurate of the fastest; else the one that ends least off.
const BackendRun* best_of(const std::vector<BackendRun>& runs) {
  std::vector<const BackendRun*> left;
  for (const BackendRun& run : runs)
    if (is_whole(run)) left.push_back(&run);
  const auto keep_least = [&](const auto& figure, double factor) {
    double least = std::numeric_limits<double>::infinity();
    for (const BackendRun* run : left) least = std::min(least, figure(*run));
    std::erase_if(left, [&](const BackendRun* run) { return figure(*run) > factor * least; });
  };
  keep_least([](const BackendRun& run) { return static_cast<double>(run.misses.size()); }, 1.0);
  if (!left.empty() && left[0]->misses.empty())
    keep_least([](const BackendRun& run) { return run.total.median_us; }, kAsFast);
  keep_least([](const BackendRun& run) { return run.pose_error; }, 1.0);
  return left.empty() ? nullptr : left[0];
}

std::string joined(const std::vector<std::string>& texts) {
  std::string all;
  for (const std::string& text : texts) all += (all.empty() ? "" : ", ") + text;
  return all;
}

std::string reason_for(const SceneResult& result, const BackendRun& best) {
  if (!best.misses.empty())
    return "none is within the scene's limits; it is the least off: " + joined(best.misses);
  std::vector<std::string> as_fast, slower, off;
  for (const BackendRun& run : result.runs) {
    if (&run == &best || !run.not_run.empty()) continue;
    const std::string time = fmt::format("{} {:.1f} us", run.backend, run.total.median_us);
    if (!run.misses.empty())
      off.push_back(run.backend + " (" + joined(run.misses) + ")");
    else if (run.total.median_us > kAsFast * best.total.median_us)
      slower.push_back(time);
    else
      as_fast.push_back(time);
  }
  std::string reason = fmt::format("within the scene's limits at {:.1f} us a step", best.total.median_us);
  if (!as_fast.empty()) reason += "; as fast to 10 %, not closer to the reference: " + joined(as_fast);
  if (!slower.empty()) reason += "; slower: " + joined(slower);
  if (!off.empty()) reason += "; off: " + joined(off);
  return reason;
}

}  // namespace

void judge(SceneResult& result) {
  const auto reference = std::find_if(result.runs.begin(), result.runs.end(),
                                      [&](const BackendRun& run) { return run.backend == result.reference; });
  for (BackendRun& run : result.runs) {
    run.total = comparison::step_times(std::exchange(run.total_us, {}));
    run.detection = comparison::step_times(std::exchange(run.detection_us, {}));
    if (reference != result.runs.end() && is_whole(*reference) && is_whole(run))
      compare_poses(*reference, run);
    find_misses(result, run);
  }
  const BackendRun* const best = best_of(result.runs);
  if (best == nullptr) {
    result.reason = "none went through";
    return;
  }
  result.recommended = best->backend;
  result.reason = reason_for(result, *best);
}

}  // namespace touchstone::dynamics
