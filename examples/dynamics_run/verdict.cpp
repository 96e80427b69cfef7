#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "touchstone/examples/dynamics_run/results.hpp"
#include "touchstone/physics/solver/contact_laws.hpp"

namespace touchstone::dynamics {
namespace {

/// Of the rotation between two attitudes: |R1 - R2| (Frobenius) is 2 sqrt(2) sin(angle / 2).
double angle_between(const Matrix3& R1, const Matrix3& R2) {
  double squares = 0.0;
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) squares += (R1(i, k) - R2(i, k)) * (R1(i, k) - R2(i, k));
  return 2.0 * std::asin(std::min(1.0, std::sqrt(squares / 8.0)));
}

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
  std::size_t wrong = 0, given = 0;
  for (const AnswerResult& answer : run.answers) given += answer.is_given ? 1 : 0;
  if (result.scene->answers_hold)
    for (const AnswerResult& answer : run.answers) wrong += answer.holds || !answer.is_given ? 0 : 1;
  miss(wrong > 0, fmt::format("{} of {} answers off", wrong, given));
  // NaN is no match.
  miss(!(run.deepest <= accept.depth), fmt::format("{:.2g} mm deep", 1e3 * run.deepest));
  const bool has_reference = std::isfinite(run.pose_error) && std::isfinite(run.angle_error);
  miss(!has_reference && compares_poses(*result.scene), "no reference");
  miss(has_reference && run.pose_error > accept.position,
       fmt::format("ends {:.2g} mm off", 1e3 * run.pose_error));
  miss(has_reference && run.angle_error > accept.angle, fmt::format("ends {:.2g} rad off", run.angle_error));
  miss(!(run.energy_made <= accept.energy_made * run.energy_scale),
       fmt::format("makes {:.2g} J", run.energy_made));
  // Drifts are NaN where the scene says nothing.
  miss(run.linear_drift > accept.drift * run.linear_scale,
       fmt::format("momentum off by {:.2g} N s", run.linear_drift));
  miss(run.angular_drift > accept.drift * run.angular_scale,
       fmt::format("angular momentum off by {:.2g} N m s", run.angular_drift));
  miss(run.energy_drift > accept.drift * run.energy_scale,
       fmt::format("energy off by {:.2g} J", run.energy_drift));
  miss(run.rest_speed > accept.rest, fmt::format("still at {:.2g} m/s", run.rest_speed));
}

}  // namespace

bool compares_poses(const physics::DynamicScene& scene) {
  return std::isfinite(scene.accept.position) || std::isfinite(scene.accept.angle);
}

void judge(SceneResult& result) {
  const auto reference = std::find_if(result.runs.begin(), result.runs.end(),
                                      [&](const BackendRun& run) { return run.backend == result.reference; });
  for (BackendRun& run : result.runs) {
    run.total = measures::step_times(std::exchange(run.total_us, {}));
    run.detection = measures::step_times(std::exchange(run.detection_us, {}));
    if (reference != result.runs.end() && reference->is_whole() && run.is_whole())
      compare_poses(*reference, run);
    find_misses(result, run);
    run.late = run.total.p999_us > result.deadline_us;  // without a deadline it is never late
  }
  choose(result);
}

}  // namespace touchstone::dynamics
