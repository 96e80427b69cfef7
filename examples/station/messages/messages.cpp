#include "touchstone/examples/station/messages/messages.hpp"

#include <cmath>
#include <nlohmann/json.hpp>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/examples/program/files/json.hpp"

namespace touchstone::station {
namespace {

using nlohmann::json;
using Kind = Control::Kind;

constexpr std::array<double, 12> kEdges = {1e3,  2e3,  5e3,   10e3,  20e3,  30e3,
                                           50e3, 75e3, 100e3, 150e3, 250e3, 500e3};
constexpr std::array<const char*, 3> kFrameNames = {"end effector", "base", "camera"};
constexpr std::array<const char*, 13> kEventNames = {
    "near",    "began",    "ended", "blocked", "at_limit", "refused", "penetrating_at_start",
    "latched", "released", "reset", "scene",   "fault",    "note"};

/// @throws InputError: not a finite number.
double number(const json& from, const char* name) {
  const auto found = from.find(name);
  if (found == from.end() || !found->is_number())
    throw InputError(std::string("'") + name + "' is no number");
  const double value = *found;
  if (!std::isfinite(value)) throw InputError(std::string("'") + name + "' is not finite");
  return value;
}

double number_or(const json& from, const char* name, double otherwise) {
  return from.contains(name) ? number(from, name) : otherwise;
}

/// @throws InputError: no whole number from 0 to `most`.
std::uint64_t index(const json& from, const char* name, std::uint64_t most) {
  const double value = number(from, name);
  if (!(value >= 0.0 && value <= static_cast<double>(most) && value == std::floor(value)))
    throw InputError(std::string("'") + name + "' is no number from 0 to " + std::to_string(most));
  return static_cast<std::uint64_t>(value);
}

template <std::size_t N>
std::array<double, N> numbers(const json& from, const char* name) {
  const auto found = from.find(name);
  if (found == from.end() || !found->is_array() || found->size() != N)
    throw InputError(std::string("'") + name + "' is no list of " + std::to_string(N) + " numbers");
  std::array<double, N> out;
  for (std::size_t i = 0; i < N; ++i) {
    if (!(*found)[i].is_number()) throw InputError(std::string("'") + name + "' is no list of numbers");
    out[i] = (*found)[i];
    if (!std::isfinite(out[i])) throw InputError(std::string("'") + name + "' is not finite");
  }
  return out;
}

Vector3 vector_or_zero(const json& from, const char* name) {
  if (!from.contains(name)) return Vector3::Zero();
  const auto v = numbers<3>(from, name);
  return {v[0], v[1], v[2]};
}

bool flag(const json& from, const char* name) {
  const auto found = from.find(name);
  if (found == from.end() || !found->is_boolean())
    throw InputError(std::string("'") + name + "' is neither true nor false");
  return *found;
}

std::string text_of(const json& from, const char* name) {
  const auto found = from.find(name);
  if (found == from.end() || !found->is_string()) throw InputError(std::string("'") + name + "' is no text");
  return *found;
}

InputMessage read_input(const json& message) {
  InputMessage out;
  out.hand.translation = vector_or_zero(message, "translation");
  out.hand.rotation = vector_or_zero(message, "rotation");
  out.hand.joint = number_or(message, "joint", 0.0);
  out.hand.grip = number_or(message, "grip", 0.0);
  out.number = static_cast<std::uint32_t>(index(message, "number", 0xffffffff));
  out.stamp = number(message, "stamp");
  return out;
}

Control frame_control(const json& message) {
  Control out{Kind::frame_of_command};
  const std::string name = text_of(message, "frame_of_command");
  for (out.index = 0; out.index < kFrameNames.size() && name != kFrameNames[out.index];) ++out.index;
  if (out.index == kFrameNames.size()) throw InputError("no frame of command '" + name + "'");
  if (static_cast<CommandFrame>(out.index) != CommandFrame::camera) return out;
  out.attitude = numbers<4>(message, "camera");
  double square = 0.0;
  for (const double q : out.attitude) square += q * q;
  if (!(std::abs(square - 1.0) < 1e-3)) throw InputError("'camera' is no attitude");
  return out;
}

Control mode_control(const json& message) {
  const std::string mode = text_of(message, "mode");
  if (mode != "hand" && mode != "joint") throw InputError("no mode '" + mode + "'");
  Control out{Kind::joint_mode, mode == "joint"};
  if (out.on) out.index = static_cast<std::uint32_t>(index(message, "joint", 0xffff));
  return out;
}

Control latch_control(const json& message) {
  Control out{Kind::latch};
  out.index = message.at("latch").is_boolean()
                  ? Control::kAny
                  : static_cast<std::uint32_t>(index(message, "latch", 0xfffffff));
  return out;
}

Control scene_control(const json& message, const StationScenes& scenes) {
  const std::string name = text_of(message, "scene");
  Control out{Kind::scene};
  out.index = static_cast<std::uint32_t>(find_scene(scenes, name));
  if (out.index == scenes.size()) throw InputError("no scene '" + name + "'");
  return out;
}

Control select_control(const json& message) {
  const json& select = message.at("select");
  if (!select.is_object()) throw InputError("'select' is no object");
  return {Kind::select, flag(select, "on"), static_cast<std::uint32_t>(index(select, "object", 0xfffffff))};
}

Control methods_control(const json& message) {
  const json& methods = message.at("methods");
  if (!methods.is_array() || methods.size() > kMethods) throw InputError("'methods' is no list of methods");
  Control out{Kind::methods};
  for (const json& method : methods) {
    if (!method.is_number_unsigned() || method >= kMethods)
      throw InputError("'methods' is no list of methods");
    out.index |= 1U << method.get<unsigned>();
  }
  return out;
}

Control policy_control(const json& message) {
  const std::string name = text_of(message, "policy");
  for (const ContactPolicy policy :
       {ContactPolicy::cue, ContactPolicy::hold, ContactPolicy::advance, ContactPolicy::slide})
    if (name == to_string(policy)) return {Kind::policy, true, static_cast<std::uint32_t>(policy)};
  if (name == to_string(physics::GuardPolicy::push)) return {Kind::policy, true, kPush};
  throw InputError("no policy '" + name + "'");
}

void read_fault(const json& fault, ControlMessage& out) {
  if (!fault.is_object()) throw InputError("'fault' is no object");
  const std::string kind = text_of(fault, "kind");
  if (kind == "joint brake")
    out.controls.push_back(
        {Kind::joint_brake, flag(fault, "on"), static_cast<std::uint32_t>(index(fault, "joint", 31))});
  else if (kind == "late report")
    out.controls.push_back({Kind::late_report, true, 0, number(fault, "delay")});
  else if (kind == "camera")
    out.camera = {static_cast<std::uint32_t>(index(fault, "camera", 31)), flag(fault, "on")};
  else if (kind == "torque loss")
    out.controls.push_back({Kind::torque_loss, true, static_cast<std::uint32_t>(index(fault, "joint", 31)),
                            number(fault, "share")});
  else
    throw InputError("no fault '" + kind + "'");
}

ControlMessage read_control(const json& message, const StationScenes& scenes) {
  ControlMessage out;
  if (message.contains("scene")) out.controls.push_back(scene_control(message, scenes));
  if (message.contains("dynamics")) out.controls.push_back({Kind::dynamics, flag(message, "dynamics")});
  if (message.contains("methods")) out.controls.push_back(methods_control(message));
  if (message.contains("reset") && flag(message, "reset")) out.controls.push_back({Kind::reset});
  if (message.contains("frame_of_command")) out.controls.push_back(frame_control(message));
  if (message.contains("vernier")) out.controls.push_back({Kind::vernier, flag(message, "vernier")});
  if (message.contains("brakes")) out.controls.push_back({Kind::brakes, flag(message, "brakes")});
  if (message.contains("tip"))
    out.controls.push_back({Kind::tip, true, static_cast<std::uint32_t>(index(message, "tip", 31))});
  if (message.contains("mode")) out.controls.push_back(mode_control(message));
  if (message.contains("release") && flag(message, "release")) out.controls.push_back({Kind::release});
  if (message.contains("latch") && message.at("latch") != false)
    out.controls.push_back(latch_control(message));
  if (message.contains("select")) out.controls.push_back(select_control(message));
  if (message.contains("policy")) out.controls.push_back(policy_control(message));
  if (message.contains("fault")) read_fault(message.at("fault"), out);
  out.debrief = message.contains("debrief") && flag(message, "debrief");
  if (out.controls.empty() && !out.debrief && !out.camera)
    throw InputError("a control that sets nothing known");
  return out;
}

json stage_json(const TimeHistogram& times) {
  return {{"median", times.quantile_us(0.5)},
          {"p99", times.quantile_us(0.99)},
          {"p999", times.quantile_us(0.999)},
          {"worst", times.worst_us()}};
}

json counts_json(const TimeHistogram& times) {
  json counts = json::array();
  std::uint64_t above = times.count();
  for (const double edge : kEdges) {
    const std::uint64_t beyond = times.above(edge);
    counts.push_back(above - beyond);
    above = beyond;
  }
  counts.push_back(above);
  return {{"edges", kEdges}, {"counts", counts}};
}

}  // namespace

PageMessage read_message(std::string_view text, const StationScenes& scenes) {
  const json message = json::parse(text, nullptr, false);
  if (!message.is_object()) return GarbageMessage{};
  try {
    const std::string type = text_of(message, "type");
    if (type == "input") return read_input(message);
    if (type == "control") return read_control(message, scenes);
    if (type == "ping") return PingMessage{number(message, "stamp")};
    if (type == "seen") return SeenMessage{index(message, "frame", std::uint64_t{1} << 53U)};
    if (type == "drawn")
      return DrawnMessage{index(message, "frame", std::uint64_t{1} << 53U), number(message, "stamp"),
                          number_or(message, "offset", 0.0), number_or(message, "rtt", 0.0)};
    return RefusedMessage{"no message of type '" + type.substr(0, 40) + "'"};
  } catch (const InputError& error) {
    return RefusedMessage{error.what()};
  }
}

std::string hello_json(const StationScenes& scenes, std::size_t scene, std::uint32_t client, double rate,
                       std::size_t most_clients, std::size_t most_bytes, bool has_record) {
  json names = json::array();
  for (const auto& each : scenes)
    names.push_back({{"name", each->name}, {"title", each->setting.script().name}});
  return program::one_line(
      json{{"type", "hello"},
           {"version", 2},
           {"client", client},
           {"rate_hz", rate},
           {"station_us", station_us()},
           {"scenes", names},
           {"scene", scenes[scene]->name},
           {"record", has_record},
           {"methods",
            {{{"name", "no check"}, {"what", "every command is carried out"}},
             {{"name", "figure 1"}, {"what", "the image generator reports contacts 100 ms late"}},
             {{"name", "figure 2"},
              {"what", "the paper's first build: coarse and fine check of a step's end, and hold"}},
             {{"name", "ours"}, {"what", "contact world, native, slide"}}}},
           {"limits", {{"clients", most_clients}, {"message_bytes", most_bytes}, {"late_us", kLate}}}});
}

std::string scene_json(const StationScene& scene, std::uint32_t serial) {
  // The scene's own text is large and made once: the serial goes in behind its opening brace.
  return "{\"serial\":" + std::to_string(serial) + "," + scene_json(scene).substr(1);
}

std::string event_json(const StationEvent& event) {
  json out = {{"type", "event"},
              {"frame", event.frame},
              {"time", event.time},
              {"kind", kEventNames.at(static_cast<std::size_t>(event.kind))}};
  if (event.has_pair) {
    out["method"] = event.method;
    out["a"] = event.solids.a;
    out["b"] = event.solids.b;
    out["separation"] = std::isfinite(event.separation) ? json(event.separation) : json(nullptr);
  } else {
    out["text"] = event.text.data();
  }
  return program::one_line(out);
}

std::string state_json(const StateMessage& state, const StationScenes& scenes, std::uint32_t pilot,
                       std::uint32_t failed_cameras) {
  const FlightState& flight = state.flight;
  // Bits and faults become lists.
  json methods = json::array(), faults = json::array(), latched = json::array(), held = json::array(),
       off = json::array();
  for (std::uint32_t i = 0; i < kMethods; ++i)
    if (flight.methods >> i & 1U) methods.push_back(i);
  for (std::uint32_t i = 0; i < JointFaults::kMost; ++i) {
    if (flight.joints.braked >> i & 1U)
      faults.push_back({{"kind", "joint brake"}, {"joint", i}, {"on", true}});
    if (flight.joints.torque_share[i] < 1.0)
      faults.push_back({{"kind", "torque loss"}, {"joint", i}, {"share", flight.joints.torque_share[i]}});
  }
  if (flight.report_delay != training::kImageGeneratorDelay)
    faults.push_back({{"kind", "late report"}, {"delay", flight.report_delay}});
  for (std::uint32_t i = 0; i < 32; ++i)
    if (failed_cameras >> i & 1U) faults.push_back({{"kind", "camera"}, {"camera", i}, {"on", true}});
  // Objects that are held, and pairs that are off.
  for (std::size_t i = 0; i < state.latched_count; ++i) latched.push_back(state.latched[i]);
  for (std::size_t i = 0; i < state.held_count; ++i) held.push_back(state.held[i]);
  for (std::size_t i = 0; i < state.off_count; ++i) off.push_back(state.off[i]);
  return program::one_line(
      json{{"type", "state"},
           {"frame", state.frame},
           {"scene", scenes[state.scene]->name},
           {"serial", state.serial},
           {"mode", flight.joint_mode ? "joint" : "hand"},
           {"joint", flight.joint},
           {"tip", flight.tip},
           {"frame_of_command", kFrameNames[static_cast<std::size_t>(flight.frame)]},
           {"vernier", flight.vernier},
           {"brakes", flight.brakes},
           {"dynamics", flight.dynamics},
           {"methods", methods},
           {"policy", flight.dynamics ? to_string(flight.guard) : to_string(flight.policy)},
           {"selected_off", off},
           {"latched", latched},
           {"held", held},
           {"base", state.base},
           {"faults", faults},
           {"pilot", pilot}});
}

namespace {

json score(const StateMessage& state, const StationScenes& scenes) {
  json tasks = json::array();
  const std::vector<StationTask>& all = scenes[state.scene]->tasks;
  const bool has_forces = state.flight.dynamics;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const double done_at = state.figures.done_at[i];
    tasks.push_back({{"name", all[i].name},
                     {"done", done_at > 0.0},
                     {"within_limits", done_at > 0.0 ? json(state.figures.is_within[i]) : json(nullptr)},
                     {"elapsed", done_at > 0.0 ? done_at : state.figures.time}});
  }
  return {{"type", "score"},
          {"frame", state.frame},
          {"tasks", tasks},
          {"elapsed", state.figures.time},
          {"contacts", state.figures.contacts},
          {"cue_seconds", state.figures.cue_seconds},
          // Without dynamics none is known.
          {"largest_force", has_forces ? json(state.figures.largest_force) : json(nullptr)},
          {"force", has_forces ? json(state.figures.force) : json(nullptr)},
          {"torque_share", has_forces ? json(state.figures.torque_share) : json(nullptr)},
          {"failed_steps", state.figures.failed_steps},
          {"path", state.figures.path},
          {"path_length", state.figures.path}};
}

}  // namespace

std::string score_json(const StateMessage& state, const StationScenes& scenes) {
  return program::one_line(score(state, scenes));
}

std::string debrief_json(const StateMessage& state, const StationScenes& scenes,
                         std::span<const std::array<double, 4>> path, const std::deque<std::string>& events) {
  json out = score(state, scenes);
  out["type"] = "debrief";
  out["path"] = json::array();
  for (const auto& point : path) out["path"].push_back(point);
  out["events"] = json::array();
  for (const std::string& event : events) out["events"].push_back(json::parse(event));
  return program::one_line(out);
}

std::string pong_json(double stamp, double received_us, double sent_us) {
  return program::one_line(
      json{{"type", "pong"}, {"stamp", stamp}, {"received_us", received_us}, {"sent_us", sent_us}});
}

std::string error_json(std::string_view text) {
  return program::one_line(json{{"type", "error"}, {"text", text}});
}

std::string latency_json(const LatencyFigures& latency, const LoopFigures& loop, double rate,
                         double offset_us, double rtt_us) {
  return program::one_line(json{{"type", "latency"},
                                {"stages_us",
                                 {{"input_to_received", stage_json(latency.input_to_received)},
                                  {"received_to_started", stage_json(latency.received_to_started)},
                                  {"started_to_decided", stage_json(latency.started_to_decided)},
                                  {"decided_to_sent", stage_json(latency.decided_to_sent)},
                                  {"sent_to_drawn", stage_json(latency.sent_to_drawn)},
                                  {"input_to_drawn", stage_json(latency.input_to_drawn)}}},
                                {"sum_less_input_to_drawn_us", stage_json(latency.difference)},
                                {"count", latency.input_to_drawn.count()},
                                {"histogram_us", counts_json(latency.input_to_drawn)},
                                {"over_150_ms", latency.input_to_drawn.above(kLate)},
                                {"deadline",
                                 {{"steps", loop.step.count()},
                                  {"missed", loop.missed.load()},
                                  {"period_us", 1e6 / rate},
                                  {"worst_step_us", loop.step.worst_us()},
                                  {"median_step_us", loop.step.quantile_us(0.5)},
                                  {"p999_step_us", loop.step.quantile_us(0.999)}}},
                                {"offset_us", offset_us},
                                {"rtt_us", rtt_us}});
}

}  // namespace touchstone::station
