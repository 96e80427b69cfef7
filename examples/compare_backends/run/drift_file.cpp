#include "touchstone/examples/compare_backends/run/drift_file.hpp"

#include <fmt/format.h>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/examples/compare_backends/names.hpp"
#include "touchstone/examples/program/files/json.hpp"
#include "touchstone/examples/program/files/json_error.hpp"

namespace touchstone::comparison {
namespace {

// NaN: not measured. @throws InputError for what is below what such a figure can be.
double checked(const Json& run, const char* key, const DriftRun& of) {
  const double value = number_of(run.at(key));
  if (value < 0)
    throw InputError(
        fmt::format("--dynamics: scene {}, backend {}: {} is negative", of.scene, of.backend, key));
  return value;
}

DriftRun run_of(const Json& scene, const Json& run) {
  DriftRun drift;
  drift.scene = scene.at("scene");
  drift.backend = run.at("backend");
  drift.build_on = scene.at("build_on") == drift.backend;
  if (run.contains("not_run")) {
    drift.gap = run.at("not_run");
    return drift;
  }
  if (!run.at("stopped").is_null()) drift.gap = "stopped: " + run.at("stopped").get<std::string>();
  drift.pose_error = checked(run, "pose_error_m", drift);
  drift.momentum = checked(run, "unexplained_momentum_ns", drift);
  // Where nothing has energy there is no share of it: 0 over 0 is no figure, and neither is more over 0.
  const double made = checked(run, "energy_made_j", drift), scale = checked(run, "energy_scale_j", drift);
  drift.energy_made = scale > 0 ? made / scale : kNaN;
  drift.deepest = checked(run, "deepest_m", drift);
  drift.step_ns = 1e3 * checked(run.at("step_us"), "median", drift);
  drift.p999_ns = 1e3 * checked(run.at("step_us"), "p99_9", drift);
  drift.allocations = checked(run, "allocations", drift);
  drift.misses = run.at("misses").get<std::vector<std::string>>();
  for (const Json& answer : run.at("answers")) {
    ++drift.answers;
    drift.met += answer.at("holds").get<bool>() ? 1 : 0;
  }
  return drift;
}

// Text, or empty for null and for a key that an older file lacks.
std::string text_at(const Json& object, const char* key) {
  return object.contains(key) && !object.at(key).is_null() ? object.at(key).get<std::string>() : "";
}

DriftScene scene_of(const Json& scene) {
  DriftScene found{scene.at("scene"), text_at(scene, "build_on"), text_at(scene, "reason"), false};
  if (scene.contains("touches")) {
    found.touches = scene.at("touches");
    return found;
  }
  for (const Json& run : scene.at("runs")) found.touches |= run.value("contacts", 0) > 0;
  return found;
}

}  // namespace

Drift load_drift(const std::string& path) {
  const std::string who = "--dynamics";
  try {
    const Json results = Json::parse(read_file(path, who));
    if (results.at("program") != "dynamics_run")
      throw InputError(who + ": " + path + " is none of dynamics_run");
    Drift drift;
    for (const Json& scene : results.at("scenes")) {
      drift.scenes.push_back(scene_of(scene));
      for (const Json& run : scene.at("runs")) drift.runs.push_back(run_of(scene, run));
    }
    drift.build_on = text_at(results, "build_on");
    drift.reason = text_at(results, "reason");
    return drift;
  } catch (const nlohmann::json::exception& error) {
    throw InputError(who + ": " + path + ": " + reason_of(error));
  }
}

}  // namespace touchstone::comparison
