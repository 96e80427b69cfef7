#include <fmt/format.h>

#include <cmath>

#include "touchstone/examples/dynamics_run/results.hpp"
#include "touchstone/examples/program/files/csv.hpp"
#include "touchstone/examples/program/files/json.hpp"
#include "touchstone/examples/program/terminal/engine_log.hpp"

namespace touchstone::dynamics {
namespace {

using program::Json;
using program::json;
using program::number;

constexpr int kSchema = 1;

Json json(const physics::DynamicScene& scene, const physics::SceneAnswer& answer,
          const AnswerResult& result) {
  Json out = {{"figure", std::string(to_string(answer.figure))}};
  JointKind kind = JointKind::fixed;
  if (answer.is_vector()) out["of"] = scene.scene.objects[answer.object].tree.name();
  if (answer.is_of_joint()) {
    out["of"] = name_of(scene, answer.joint);
    kind = kind_of(scene, answer.joint);
  }
  out["unit"] = unit_of(answer, kind);
  out["time_s"] = answer.time;
  out["closed_form"] = answer.is_vector() ? json(answer.value) : number(answer.value.x());
  out["found"] = answer.is_vector() ? json(result.found) : number(result.found.x());
  out["error"] = number(result.error);
  out["tolerance"] = answer.tolerance;
  out["holds"] = result.holds;
  if (!result.is_given) out["not_given"] = true;
  return out;
}

Json last_poses(const SceneResult& result, const BackendRun& run) {
  Json poses = Json::object();
  for (std::size_t o = 0; o < run.last.size(); ++o)
    poses[result.scene->scene.objects[o].tree.name()] = json(run.last[o]);
  return poses;
}

Json json(const SceneResult& result, const BackendRun& run) {
  Json out = {{"backend", run.backend}};
  // A run that did not begin has a reason alone.
  if (!run.not_run.empty()) {
    out["not_run"] = run.not_run;
    return out;
  }
  out["stopped"] = run.stopped.empty() ? Json(nullptr) : Json(run.stopped);
  out["steps"] = run.steps;
  // Known answers are of the scene's own parameters, and judged for these alone.
  out["answers"] = Json::array();
  for (std::size_t i = 0; i < run.answers.size() && result.scene->answers_hold; ++i)
    out["answers"].push_back(json(*result.scene, result.scene->answers[i], run.answers[i]));
  // Errors, drifts and energies are in SI units, which their keys name.
  out["deepest_m"] = number(run.deepest);
  out["pose_error_m"] = number(run.pose_error);
  out["angle_error_rad"] = number(run.angle_error);
  out["unexplained_momentum_ns"] = number(run.unexplained_momentum);
  out["momentum_drift_ns"] = number(run.linear_drift);
  out["angular_momentum_drift_nms"] = number(run.angular_drift);
  out["energy_drift_j"] = number(run.energy_drift);
  out["momentum_scale_ns"] = number(run.linear_scale);
  out["angular_momentum_scale_nms"] = number(run.angular_scale);
  out["energy_made_j"] = number(run.energy_made);
  out["energy_lost_j"] = number(run.energy_lost);
  out["energy_scale_j"] = number(run.energy_scale);
  out["rest_speed_m_s"] = number(run.rest_speed);
  // Times and counts say what the run cost.
  out["step_us"] = json(run.total);
  out["detection_us"] = json(run.detection);
  out["allocations"] = run.allocations ? Json(*run.allocations) : Json(nullptr);
  out["contacts"] = run.contact_count;
  out["undecided_pairs"] = run.undecided;
  out["failed_pairs"] = run.failed;
  out["unconverged_solves"] = run.unconverged;
  out["worst_residual_m_s"] = number(run.worst_residual);
  out["misses"] = run.misses;
  out["late"] = run.late;
  out["last"] = last_poses(result, run);
  return out;
}

}  // namespace

std::string results_json(const std::vector<SceneResult>& results,
                         const std::vector<std::string>& not_measured) {
  Json out = {
      {"schema", kSchema}, {"program", "dynamics_run"}, {"machine", json(program::describe_machine())}};
  // An interrupted run says which scenes it lacks.
  out["partial"] = !not_measured.empty();
  out["not_measured"] = not_measured;
  out["engine_messages"] = program::engine_log_lines();
  out["scenes"] = Json::array();
  for (const SceneResult& result : results) {
    const physics::DynamicScene& scene = *result.scene;
    // Each scene stands with its settings, its verdict and all of its runs.
    Json entry = {{"scene", result.file},
                  {"name", scene.scene.name},
                  {"parameters", scene.scene.parameters},
                  {"step_s", scene.step},
                  {"duration_s", scene.scene.duration},
                  {"answers_hold", scene.answers_hold},
                  {"reference", result.reference},
                  {"deadline_us", number(result.deadline_us)},
                  {"touches", result.touches},
                  {"build_on", result.recommended.empty() ? Json(nullptr) : Json(result.recommended)},
                  {"reason", result.reason}};
    entry["objects"] = scene.scene.objects.size();
    entry["runs"] = Json::array();
    for (const BackendRun& run : result.runs) entry["runs"].push_back(json(result, run));
    out["scenes"].push_back(std::move(entry));
  }
  // Only all scenes together choose a backend for all.
  const OverallVerdict verdict = not_measured.empty()
                                     ? choose_over_all(results)
                                     : OverallVerdict{"", "the run ended before all scenes were done"};
  out["build_on"] = verdict.recommended.empty() ? Json(nullptr) : Json(verdict.recommended);
  out["reason"] = verdict.reason;
  return out.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";  // paths and names may be no UTF-8
}

std::string results_csv(const std::vector<SceneResult>& results,
                        const std::vector<std::string>& not_measured) {
  using program::csv_number;
  using program::csv_text;
  std::string text =
      "scene,backend,not_run,stopped,steps,answers,answers_met,deepest_m,pose_error_m,angle_error_rad,"
      "unexplained_momentum_ns,momentum_drift_ns,angular_momentum_drift_nms,energy_drift_j,energy_made_j,"
      "energy_lost_j,energy_scale_j,rest_speed_m_s,median_us,p99_9_us,worst_us,detection_median_us,"
      "allocations,contacts,"
      "undecided_pairs,failed_pairs,unconverged_solves,worst_residual_m_s,build_on,partial\n";
  const int partial = not_measured.empty() ? 0 : 1;
  for (const SceneResult& result : results) {
    for (const BackendRun& run : result.runs) {
      text += fmt::format("{},{},{},", csv_text(result.file), csv_text(run.backend), csv_text(run.not_run));
      // A run that did not begin keeps its columns, empty.
      if (!run.not_run.empty()) {
        text += std::string(25, ',') + fmt::format(",{}\n", partial);
        continue;
      }
      // Answers of other parameters are not judged, and count as none.
      std::size_t met = 0;
      for (const AnswerResult& answer : run.answers) met += answer.holds ? 1 : 0;
      const bool judged = result.scene->answers_hold;
      text += fmt::format("{},{},{},{}", csv_text(run.stopped), run.steps, judged ? run.answers.size() : 0,
                          judged ? met : 0);
      // Figures go in the order of the header.
      for (const double figure : {run.deepest, run.pose_error, run.angle_error, run.unexplained_momentum,
                                  run.linear_drift, run.angular_drift, run.energy_drift, run.energy_made,
                                  run.energy_lost, run.energy_scale, run.rest_speed, run.total.median_us,
                                  run.total.p999_us, run.total.worst_us, run.detection.median_us})
        text += "," + csv_number(figure);
      text +=
          fmt::format(",{},{},{},{},{},{},{},{}\n", run.allocations ? std::to_string(*run.allocations) : "",
                      run.contact_count, run.undecided, run.failed, run.unconverged, run.worst_residual,
                      run.backend == result.recommended ? 1 : 0, partial);
    }
  }
  return text;
}

}  // namespace touchstone::dynamics
