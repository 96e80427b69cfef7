#include "touchstone/examples/station/station_scene.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/geometry/quaternion.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/examples/program/json.hpp"

namespace touchstone::station {
namespace {

using nlohmann::json;
using training::Action;
using training::kNone;

json numbers(const Vector3& v) { return {v.x(), v.y(), v.z()}; }

json attitude(const Matrix3& R) {
  const Quaternion q = quaternion_of(R);
  return {q.v.x(), q.v.y(), q.v.z(), q.w};
}

/// JSON has no infinity: null stands for no limit.
json limit(double value) { return std::abs(value) < kInfinity ? json(value) : json(nullptr); }

json objects_json(const StationScene& scene) {
  json out = json::array();
  for (std::uint32_t i = 0; i < scene.setting.object_count(); ++i) {
    json solids = json::array();
    const SolidIndex first = scene.setting.instance().first_solid(i);
    for (SolidIndex k = 0; k < scene.setting.instance().trees()[i]->solids().size(); ++k)
      solids.push_back(first + k);
    const bool is_link = scene.setting.arm_of(i) != nullptr;
    out.push_back({{"name", scene.setting.object_name(i)},
                   {"kind", is_link                     ? "link"
                            : scene.setting.may_move(i) ? "free"
                                                        : "static"},
                   {"selectable", true},
                   {"moves", static_cast<bool>(scene.setting.may_move(i))},
                   {"solids", solids}});
  }
  return out;
}

json solids_json(const StationScene& scene) {
  json out = json::array();
  for (std::uint32_t i = 0; i < scene.setting.object_count(); ++i)
    for (const PlacedHexahedron& placed : scene.setting.instance().trees()[i]->solids()) {
      json vertices = json::array();
      for (const Vector3& vertex : placed.solid.vertices()) {
        const Vector3 p_O = transform(placed.X_OS, vertex);
        for (int k = 0; k < 3; ++k) vertices.push_back(p_O[k]);
      }
      out.push_back({{"object", i}, {"name", placed.name}, {"vertices", vertices}});
    }
  return out;
}

json joints_json(const Mechanism& mechanism) {
  json out = json::array();
  for (const Mechanism::Joint& joint : mechanism.joints())
    if (joint.value != Mechanism::kNone)
      out.push_back({{"name", joint.name},
                     {"lower", limit(joint.lower)},
                     {"upper", limit(joint.upper)},
                     {"rate", limit(joint.rate)},
                     {"effort", limit(joint.effort)}});
  return out;
}

json arms_json(const StationScene& scene) {
  json out = json::array();
  const Pose& X_HT = scene.X_HT;
  for (const training::Arm& arm : scene.setting.arms()) {
    json links = json::array();
    for (std::uint32_t i = 0; i < arm.object_count; ++i) links.push_back(arm.first_object + i);
    out.push_back(
        {{"name", arm.mechanism->name()},
         {"links", links},
         {"hand", scene.hand_object()},
         {"tip",
          {{"object", scene.hand_object()}, {"position", numbers(X_HT.p)}, {"rotation", attitude(X_HT.R)}}},
         {"base", {{"position", numbers(arm.X_WB.p)}, {"rotation", attitude(arm.X_WB.R)}}},
         {"joints", joints_json(*arm.mechanism)}});
  }
  return out;
}

json camera(const char* name, int object, const Vector3& position, const Vector3& look, const Vector3& up,
            double fov) {
  return {{"name", name},          {"object", object},  {"position", numbers(position)},
          {"look", numbers(look)}, {"up", numbers(up)}, {"fov", fov}};
}

/// Cameras where the real ones are: beside the end effector and at the elbow, looking along the booms; and
/// one in the bay.
json cameras_json(const StationScene& scene) {
  json out = json::array();
  const training::Arm* const arm = scene.arm();
  const auto hand = static_cast<int>(scene.hand_object());
  const Vector3 tip = scene.setting.scene().objects[scene.hand_object()].X_WO.p;
  if (arm != nullptr) {
    const Pose& X_HT = scene.X_HT;
    out.push_back(camera("wrist", hand, transform(X_HT, {-0.6, 0.0, 0.35}), rotate(X_HT.R, {1.0, 0.0, -0.25}),
                         rotate(X_HT.R, {0.0, 0.0, 1.0}), 1.0));
    for (std::uint32_t i = 0; i < arm->object_count; ++i)
      if (arm->mechanism->links()[arm->link_of_object[i]].name == "lower_boom")
        out.push_back(camera("elbow", static_cast<int>(arm->first_object + i), {0.3, 0.0, 0.5},
                             {1.0, 0.0, -0.05}, {0.0, 0.0, 1.0}, 0.8));
  }
  const Vector3 bay = tip + Vector3(2.5, -3.5, 1.2);
  const Vector3 mast = tip + Vector3(-3.0, -2.5, 2.5);
  out.push_back(camera("pan-tilt", -1, mast, tip - Vector3(0.0, 0.0, 0.5) - mast, {0.0, 0.0, 1.0}, 0.7));
  out.push_back(camera("bay", -1, bay, tip - Vector3(0.0, 0.0, 0.5) - bay, {0.0, 0.0, 1.0}, 0.9));
  return out;
}

json latches_json(const StationScene& scene) {
  json out = json::array();
  for (const LatchOption& option : scene.latches)
    out.push_back({{"carrier", option.carrier}, {"carried", option.carried}});
  return out;
}

json limits_json(const StationTask& task) {
  const StationTask none;
  json out = json::object();
  if (task.most_force != none.most_force) out["force"] = task.most_force;
  if (task.most_time != none.most_time) out["time"] = task.most_time;
  if (task.most_contacts != none.most_contacts) out["contacts"] = task.most_contacts;
  return out;
}

json tasks_json(const StationScene& scene) {
  json out = json::array();
  for (const StationTask& task : scene.tasks)
    out.push_back({{"name", task.name}, {"title", task.title}, {"limits", limits_json(task)}});
  return out;
}

/// Of the flown frame in the object that stands for the hand.
Pose tip_in_hand(const StationScene& scene) {
  const training::Arm* const arm = scene.arm();
  if (arm == nullptr) return {};
  std::vector<Pose> X_WL(arm->mechanism->links().size());
  arm->mechanism->link_poses(arm->X_WB, arm->joints, X_WL);
  const std::uint32_t link = arm->link_of_object[scene.hand_object() - arm->first_object];
  return compose(inverse(X_WL[link]), X_WL[arm->flown_link]);
}

/// FNV-1a over all bytes: which files a recording was flown with.
std::string hash_of(std::span<const std::filesystem::path> files) {
  std::uint64_t hash = 0xcbf29ce484222325;
  for (const std::filesystem::path& file : files) {
    std::ifstream in(file, std::ios::binary);
    for (char byte = 0; in.get(byte);) hash = (hash ^ static_cast<std::uint8_t>(byte)) * 0x100000001b3;
  }
  return fmt::format("{:016x}", hash);
}

constexpr std::array<const char*, 3> kTaskKinds = {"carry", "place", "reach"};

void read_limits(const json& limits, StationTask& task) {
  for (const auto& [name, value] : limits.items()) {
    const double most = value.get<double>();
    if (!(most >= 0.0)) throw InputError("task '" + task.name + "': the limit '" + name + "' is below 0");
    if (name == "force")
      task.most_force = most;
    else if (name == "time")
      task.most_time = most;
    else if (name == "contacts")
      task.most_contacts = value.get<std::uint32_t>();
    else
      throw InputError("task '" + task.name + "': no limit '" + name + "'");
  }
}

StationTask read_task(const json& from, const StationScene& scene) {
  StationTask task;
  task.name = from.at("name");
  task.title = from.at("title");
  if (from.contains("limits")) read_limits(from.at("limits"), task);
  const std::string kind = from.at("kind");
  const auto found = std::find(kTaskKinds.begin(), kTaskKinds.end(), kind);
  if (found == kTaskKinds.end()) throw InputError("no kind of task '" + kind + "'");
  task.kind = static_cast<StationTask::Kind>(found - kTaskKinds.begin());
  if (task.kind != StationTask::Kind::reach) {
    const std::size_t object = find_object(scene.setting.scene(), from.at("object").get<std::string>());
    if (object == kNoObject) throw InputError("task '" + task.name + "': no such object");
    task.object = static_cast<std::uint32_t>(object);
  }
  if (task.kind == StationTask::Kind::carry) return task;
  const auto p = from.at("position").get<std::array<double, 3>>();
  task.p_W = {p[0], p[1], p[2]};
  task.within = from.at("within");
  return task;
}

std::vector<StationTask> read_tasks(const std::filesystem::path& file, const StationScene& scene) {
  std::vector<StationTask> tasks;
  std::ifstream in(file);
  if (!in) return tasks;
  try {
    for (const json& task : json::parse(in)) tasks.push_back(read_task(task, scene));
  } catch (const json::exception& error) {
    throw InputError(file.string() + ": " + error.what());
  } catch (const InputError& error) {
    throw InputError(file.string() + ": " + error.what());
  }
  if (tasks.size() > kMostTasks) throw InputError(file.string() + ": more than 8 tasks");
  return tasks;
}

void check_hands(const Script& script) {
  if (script.hands.empty()) throw InputError("script '" + script.name + "': no hand to fly with");
  for (std::size_t i = 1; i < script.hands.size(); ++i)
    if (script.hands[i].arm)
      throw InputError("script '" + script.name + "': the station flies one arm, by the first hand");
}

}  // namespace

StationScene::StationScene(std::string given_name, Script script, double rate)
    : name(std::move(given_name)), setting(std::move(script), rate) {
  for (const Action& action : setting.actions()) {
    if (action.kind != OperatorAction::Kind::latch) continue;
    if (action.time <= 0.0) initial.push_back(action);
    latches.push_back({action.carrier, action.object, action.allowed});
  }
  X_HT = tip_in_hand(*this);
  dynamics = load_station_dynamics(setting, latches);
}

std::uint32_t StationScene::hand_object() const {
  const training::Arm* const flown = arm();
  if (flown == nullptr) return setting.object_of_hand(0);
  // Links without hexahedra hang on the last one that has some.
  std::uint32_t object = flown->first_object;
  for (const std::uint32_t joint : flown->mechanism->chain(flown->flown_link)) {
    const std::uint32_t outer = flown->mechanism->joints()[joint].outer;
    if (flown->object_of_link[outer] != Mechanism::kNone) object = flown->object_of_link[outer];
  }
  return object;
}

std::unique_ptr<const StationScene> load_station_scene(const std::filesystem::path& file, double rate) {
  Script script = load_script(file);
  check_hands(script);
  // The flight has no end: room is taken for the frame that is flown.
  script.scene.frame_rate = rate;
  script.scene.duration = 2.0 / rate;
  auto scene = std::make_unique<StationScene>(file.stem().string(), std::move(script), rate);
  const std::filesystem::path tasks = std::filesystem::path(file).replace_extension(".tasks.json");
  scene->tasks = read_tasks(tasks, *scene);
  scene->file = std::filesystem::absolute(file);
  scene->files = hash_of(std::array{file, scene->setting.script().scene_file, tasks});
  return scene;
}

std::string scene_json(const StationScene& scene) {
  const Script& script = scene.setting.script();
  const json out = {{"type", "scene"},
                    {"name", scene.name},
                    {"title", script.name},
                    {"description", script.scene.description},
                    {"gap", script.scene.contact_gap},
                    {"objects", objects_json(scene)},
                    {"solids", solids_json(scene)},
                    {"arms", arms_json(scene)},
                    {"dynamics", scene.dynamics != nullptr},
                    {"hand", scene.hand_object()},
                    {"cameras", cameras_json(scene)},
                    {"latches", latches_json(scene)},
                    {"tasks", tasks_json(scene)}};
  return comparison::one_line(out);
}

}  // namespace touchstone::station
