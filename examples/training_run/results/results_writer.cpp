#include <fmt/format.h>

#include <cmath>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/examples/program/files/csv.hpp"
#include "touchstone/examples/program/files/json.hpp"
#include "touchstone/examples/program/terminal/engine_log.hpp"
#include "touchstone/examples/training_run/results/results.hpp"

namespace touchstone::training {
namespace {

using program::Json;
using program::json;
using program::number;

constexpr int kSchema = 1;

Json json(const Setting& setting, const SolidPair& pair) {
  return Json::array({setting.instance().solid_name(pair.a), setting.instance().solid_name(pair.b)});
}

Json last_poses(const Setting& setting, const Verdict& verdict) {
  Json poses = Json::object();
  for (std::uint32_t i = 0; i < verdict.last.size(); ++i) {
    if (!setting.may_move(i)) continue;
    poses[setting.object_name(i)] = json(verdict.last[i]);
  }
  return poses;
}

Json json(const HandFigures& hand) {
  return {{"arm", hand.is_arm},
          {"limited_frames", hand.limited_frames},
          {"damped_frames", hand.damped_frames},
          {"largest_residual_m", number(hand.largest_residual)}};
}

Json json(const OutputFigures& output) {
  return {{"receiver", output.receiver},
          {"offered_frames", output.status.offered},
          {"delivered_frames", output.status.delivered},
          {"dropped_frames", output.status.dropped},
          {"errors", output.status.errors},
          {"error", output.error}};
}

Json json(const Setting& setting, const MethodResult& method) {
  Json out = {{"method", method.method}, {"backend", method.backend}};
  // A method that was not flown has a reason alone.
  if (!method.not_flown.empty()) {
    out["not_flown"] = method.not_flown;
    return out;
  }
  const Verdict& v = method.verdict;
  out["check"] = std::string(to_string(method.check));
  out["frames"] = v.frames;
  // Stops and cues name the pairs that caused them.
  out["stops"] = Json::array();
  for (const Stop& stop : v.stops)
    out["stops"].push_back({{"time_s", number(stop.time)},
                            {"pair", json(setting, stop.solids)},
                            {"clearance_m", number(stop.clearance)}});
  out["cues"] = Json::array();
  for (const Cue& cue : v.cues)
    out["cues"].push_back({{"kind", std::string(to_string(cue.kind))},
                           {"time_s", number(cue.time)},
                           {"pair", json(setting, cue.solids)}});
  // Exact answers judge the frames that were shown.
  out["deepest_shown_m"] = number(v.deepest_shown);
  out["deepest_between_m"] = number(v.deepest_between);
  out["merged_frames"] = v.merged;
  out["passed_through_frames"] = v.passed_through;
  out["missed_frames"] = v.missed;
  out["phantom_frames"] = v.phantom;
  out["blocked_frames"] = v.blocked;
  out["false_stop_frames"] = v.false_stops;
  // Times and counts are the costs of a frame.
  out["frame_us"] = json(method.times);
  out["frame_cpu_us"] = json(method.cpu_times);
  out["allocations"] = method.allocations ? Json(*method.allocations) : Json(nullptr);
  out["queries"] = method.queries;
  out["iteration_limits"] = method.iteration_limits;
  // Hands and outputs are judged one by one.
  out["hands"] = Json::array();
  for (const HandFigures& hand : method.hands) out["hands"].push_back(json(hand));
  out["outputs"] = Json::array();
  for (const OutputFigures& output : method.outputs) out["outputs"].push_back(json(output));
  out["last"] = last_poses(setting, v);
  return out;
}

}  // namespace

std::string pair_name(const Setting& setting, const SolidPair& pair) {
  return setting.instance().solid_name(pair.a) + " - " + setting.instance().solid_name(pair.b);
}

std::string results_json(const std::vector<ScriptResult>& results,
                         const std::vector<std::string>& not_measured) {
  Json out = {
      {"schema", kSchema}, {"program", "training_run"}, {"machine", json(program::describe_machine())}};
  out["partial"] = !not_measured.empty();
  out["not_measured"] = not_measured;
  out["engine_messages"] = program::engine_log_lines();
  out["scripts"] = Json::array();
  for (const ScriptResult& result : results) {
    const Setting& setting = *result.setting;
    Json script = {{"script", result.file},
                   {"name", setting.script().name},
                   {"policy", std::string(to_string(setting.scene().policy))},
                   {"frame_rate_hz", setting.scene().frame_rate},
                   {"gap_m", setting.scene().contact_gap},
                   {"duration_s", setting.scene().duration}};
    script["methods"] = Json::array();
    for (const MethodResult& method : result.methods) script["methods"].push_back(json(setting, method));
    out["scripts"].push_back(std::move(script));
  }
  return out.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";  // paths and names may be no UTF-8
}

std::string results_csv(const std::vector<ScriptResult>& results,
                        const std::vector<std::string>& not_measured) {
  using program::csv_number;
  using program::csv_text;
  std::string text =
      "script,method,backend,check,not_flown,policy,frame_rate_hz,gap_m,frames,stops,first_stop_s,first_"
      "clearance_m,deepest_shown_m,deepest_between_m,merged_frames,passed_through_frames,missed_frames,"
      "phantom_frames,blocked_frames,false_stop_frames,median_us,p99_9_us,worst_us,median_cpu_us,p99_9_cpu_"
      "us,worst_cpu_us,allocations,queries,iteration_limits,partial\n";
  const int partial = not_measured.empty() ? 0 : 1;
  for (const ScriptResult& result : results) {
    const Scene& scene = result.setting->scene();
    for (const MethodResult& method : result.methods) {
      text += fmt::format("{},{},{},{},{},{},{},{},", csv_text(result.file), csv_text(method.method),
                          csv_text(method.backend), method.not_flown.empty() ? to_string(method.check) : "",
                          csv_text(method.not_flown), to_string(scene.policy), scene.frame_rate,
                          scene.contact_gap);
      // A method that was not flown keeps its columns, empty.
      if (!method.not_flown.empty()) {
        text += std::string(20, ',') + fmt::format(",{}\n", partial);
        continue;
      }
      // Without a stop its cells stay empty.
      const Verdict& v = method.verdict;
      text += fmt::format("{},{},{},{},", v.frames, v.stops.size(),
                          csv_number(v.stops.empty() ? kNaN : v.stops[0].time),
                          csv_number(v.stops.empty() ? kNaN : v.stops[0].clearance));
      text += fmt::format("{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{}\n", v.deepest_shown,
                          v.deepest_between, v.merged, v.passed_through, v.missed, v.phantom, v.blocked,
                          v.false_stops, method.times.median_us, method.times.p999_us, method.times.worst_us,
                          method.cpu_times.median_us, method.cpu_times.p999_us, method.cpu_times.worst_us,
                          method.allocations ? std::to_string(*method.allocations) : "", method.queries,
                          method.iteration_limits, partial);
    }
  }
  return text;
}

}  // namespace touchstone::training
