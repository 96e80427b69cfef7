#include "touchstone/examples/station/flight/station_scene.hpp"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <span>

#include "touchstone/adapters/plugin/utf8.hpp"
#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/geometry/quaternion.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/examples/program/files/json.hpp"
#include "touchstone/examples/station/flight/bytes.hpp"
#include "touchstone/examples/station/flight/solids_json.hpp"
#include "touchstone/examples/station/flight/stance.hpp"

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
    append_solids(*scene.setting.instance().trees()[i], i, out);
  return out;
}

json joints_json(const Mechanism& mechanism) {
  json out = json::array();
  for (const Mechanism::Joint& joint : mechanism.joints())
    if (joint.value != Mechanism::kNone)
      out.push_back({{"name", joint.name},
                     {"kind", to_string(joint.kind)},
                     {"lower", limit(joint.lower)},
                     {"upper", limit(joint.upper)},
                     {"rate", limit(joint.rate)},
                     {"effort", limit(joint.effort)}});
  return out;
}

json tip_json(const Tip& tip) {
  json jaws = json::array();
  for (const Jaw& jaw : tip.jaws) jaws.push_back(jaw.value);
  return {{"name", tip.name},
          {"object", tip.object},
          {"position", numbers(tip.X_HT.p)},
          {"rotation", attitude(tip.X_HT.R)},
          {"jaws", jaws}};
}

json tips_json(const StationScene& scene) {
  json out = json::array();
  for (const Tip& tip : scene.tips) out.push_back(tip_json(tip));
  return out;
}

json arms_json(const StationScene& scene) {
  json out = json::array();
  for (const training::Arm& arm : scene.setting.arms()) {
    json links = json::array();
    for (std::uint32_t i = 0; i < arm.object_count; ++i) links.push_back(arm.first_object + i);
    out.push_back({{"name", arm.mechanism->name()},
                   {"links", links},
                   {"hand", scene.hand_object()},
                   {"tip", tip_json(scene.tips[0])},
                   {"base", {{"position", numbers(arm.X_WB.p)}, {"rotation", attitude(arm.X_WB.R)}}},
                   {"joints", joints_json(*arm.mechanism)}});
  }
  return out;
}

json camera(const std::string& name, int object, const Vector3& position, const Vector3& look,
            const Vector3& up, double fov) {
  return {{"name", name},          {"object", object},  {"position", numbers(position)},
          {"look", numbers(look)}, {"up", numbers(up)}, {"fov", fov}};
}

/// Cameras on links that carry one, by the link's name.
struct LinkCamera {
  const char *link, *name;
  Vector3 position, look, up;
  double fov;
};
const std::array<LinkCamera, 2> kLinkCameras = {
    LinkCamera{"lower_boom", "elbow", {0.3, 0.0, 0.5}, {1.0, 0.0, -0.05}, {0.0, 0.0, 1.0}, 0.8},
    LinkCamera{"body", "body", {-1.6, 0.0, 0.0}, {-1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, 1.1}};

/// Cameras where the real ones are: beside each end effector, at the elbow looking along the booms, on a body
/// that carries arms; and two in the bay.
json cameras_json(const StationScene& scene) {
  json out = json::array();
  const training::Arm* const arm = scene.arm();
  const Vector3 tip = scene.setting.scene().objects[scene.hand_object()].X_WO.p;
  const double share = scene.view / kFarthestView;
  // On the arm: beside each tip, and on its links.
  if (arm != nullptr) {
    for (const Tip& each : scene.tips) {
      const bool is_first = &each == scene.tips.data();
      const double away = share * (each.jaws.empty() ? 1.0 : 0.6);  // tools with jaws are smaller
      out.push_back(camera(is_first ? "wrist" : "wrist " + each.name, static_cast<int>(each.object),
                           transform(each.X_HT, away * Vector3(-0.6, 0.0, 0.35)),
                           rotate(each.X_HT.R, {1.0, 0.0, -0.25}), rotate(each.X_HT.R, {0.0, 0.0, 1.0}),
                           1.0));
    }
    for (std::uint32_t i = 0; i < arm->object_count; ++i)
      for (const LinkCamera& each : kLinkCameras)
        if (arm->mechanism->links()[arm->link_of_object[i]].name == each.link)
          out.push_back(camera(each.name, static_cast<int>(arm->first_object + i), each.position, each.look,
                               each.up, each.fov));
  }
  // In the bay.
  const Vector3 bay = tip + share * Vector3(2.5, -3.5, 1.2);
  const Vector3 mast = tip + share * Vector3(-3.0, -2.5, 2.5);
  const Vector3 below = tip - share * Vector3(0.0, 0.0, 0.5);
  out.push_back(camera("pan-tilt", -1, mast, below - mast, {0.0, 0.0, 1.0}, 0.7));
  out.push_back(camera("bay", -1, bay, below - bay, {0.0, 0.0, 1.0}, 0.9));
  return out;
}

json holds_json(const StationScene& scene) {
  json out = json::array();
  for (const HoldOption& option : scene.holds)
    out.push_back({{"tip", option.tip}, {"fixture", option.fixture}});
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

/// The files, and the robot, that a recording was flown with.
std::string hash_of(std::span<const std::filesystem::path> files, std::string_view bits) {
  std::string bytes;
  for (const std::filesystem::path& file : files) {
    std::ifstream in(file, std::ios::binary);
    bytes.append(std::istreambuf_iterator<char>(in), {});
  }
  return station::hash_of(bytes.append(bits));
}

void check_hands(const Script& script) {
  if (script.hands.empty()) throw InputError("script '" + script.name + "': no hand to fly with");
  for (std::size_t i = 1; i < script.hands.size(); ++i)
    if (script.hands[i].arm)
      throw InputError("script '" + script.name + "': the station flies one arm, by the first hand");
}

/// Those that the list beside the script names, and of other links those that the robot's file has.
std::vector<ObjectMesh> find_meshes(const std::filesystem::path& script, const training::Setting& setting,
                                    const SceneRobot& robot, const SceneRobots& robots) {
  const std::filesystem::path list = std::filesystem::path(script).replace_extension(".meshes.json");
  std::vector<ObjectMesh> meshes = read_meshes(list, setting, robots.on_account);
  std::vector<ObjectMesh> links = robot.meshes(setting);
  std::erase_if(links, [&](const ObjectMesh& link) {
    return std::any_of(meshes.begin(), meshes.end(),
                       [&](const ObjectMesh& listed) { return listed.object == link.object; });
  });
  meshes.insert(meshes.end(), std::make_move_iterator(links.begin()), std::make_move_iterator(links.end()));
  return meshes;
}

/// The tip that a held link is the end of. An arm that walks has two, and stands on one of them.
HoldOption make_hold(const Action& action, const StationScene& scene) {
  const std::string what = "script '" + scene.setting.script().name +
                           "': " + scene.setting.object_name(action.carrier) + " holds " +
                           scene.setting.object_name(action.object) + ": ";
  if (scene.setting.may_move(action.carrier)) throw InputError(what + "what may move holds no arm");
  if (scene.tips.size() != 2) throw InputError(what + "the arm has not two ends");
  const auto tip = std::find_if(scene.tips.begin(), scene.tips.end(),
                                [&](const Tip& each) { return each.object == action.object; });
  if (tip == scene.tips.end()) throw InputError(what + "that link is no end of the arm");
  return {static_cast<std::uint32_t>(tip - scene.tips.begin()), action.carrier, action.time <= 0.0};
}

/// @throws InputError: it is not held at first by the end that the mechanism has as its base, where that end
/// can be held, and by no other.
void check_start(const StationScene& scene) {
  const std::string what = "script '" + scene.setting.script().name + "': an arm that walks ";
  std::size_t held = 0;
  for (const HoldOption& option : scene.holds) {
    if (!option.at_start) continue;
    ++held;
    const training::Arm& arm = *scene.arm();
    const std::uint32_t link = arm.link_of_object[scene.tips[option.tip].object - arm.first_object];
    if (link != arm.mechanism->base()) throw InputError(what + "stands at first on its base");
  }
  if (held != 1) throw InputError(what + "is held by one fixture at time 0");
  const auto& objects = scene.setting.scene().objects;
  for (const HoldOption& option : scene.holds) {
    const Tip& tip = scene.tips[option.tip];
    if (option.at_start &&
        !Stance::is_over(compose(objects[tip.object].X_WO, tip.X_HT), objects[option.fixture].X_WO))
      throw InputError(what + "is at time 0 within 0.1 m and 10 degrees of the fixture that holds it");
  }
}

/// @throws InputError: a task whose fixture the script does not let hold that end.
void check_hold(const StationTask& task, const StationScene& scene, const std::filesystem::path& file) {
  using Kind = StationTask::Kind;
  if (task.kind != Kind::hold && task.kind != Kind::stand) return;
  const auto is_tasks = [&](const HoldOption& option) {
    return option.tip == task.tip && option.fixture == task.object;
  };
  if (std::none_of(scene.holds.begin(), scene.holds.end(), is_tasks))
    throw InputError(file.string() + ": task '" + task.name + "': the script lets " +
                     scene.setting.object_name(task.object) + " not hold " + scene.tips[task.tip].name);
}

}  // namespace

StationScene::StationScene(std::string given_name, Script script, double rate)
    : name(std::move(given_name)), setting(std::move(script), rate) {
  for (const HexahedronTree* tree : setting.instance().trees()) refuse_rounded(*tree, "the station");
  using Kind = OperatorAction::Kind;
  const std::span<const Action> actions = setting.actions();
  const bool walks = std::any_of(actions.begin(), actions.end(),
                                 [](const Action& action) { return action.kind == Kind::hold; });
  tips = find_tips(setting, walks);
  for (const Action& action : actions) {
    if (action.kind == Kind::hold) holds.push_back(make_hold(action, *this));
    if (action.kind != Kind::latch) continue;
    if (action.time <= 0.0) initial.push_back(action);
    latches.push_back({action.carrier, action.object, action.allowed});
  }
  std::vector<std::uint32_t> ends;
  if (walks)
    for (const Tip& tip : tips) ends.push_back(tip.object);
  dynamics = load_station_dynamics(setting, latches, std::move(ends));
  if (walks) check_start(*this);
}

std::string scene_name(const std::filesystem::path& file) {
  const std::string stem = file.stem().string();
  if (is_utf8(stem)) return stem;
  std::string out;
  for (const char byte : stem) {
    const bool is_ascii = static_cast<unsigned char>(byte) < 0x80;
    out += is_ascii ? std::string(1, byte) : "%" + hex_of({&byte, 1});
  }
  return out;
}

std::unique_ptr<const StationScene> load_station_scene(const std::filesystem::path& file, double rate,
                                                       const SceneRobots& robots) {
  SceneRobot robot;
  Script script = robot.read_script(file, robots);
  check_hands(script);
  // The flight has no end: room is taken for the frame that is flown.
  script.scene.frame_rate = rate;
  script.scene.duration = 2.0 / rate;
  auto scene = std::make_unique<StationScene>(scene_name(file), std::move(script), rate);
  const std::filesystem::path tasks = std::filesystem::path(file).replace_extension(".tasks.json");
  scene->tasks = read_tasks(tasks, scene->setting, scene->tips);
  for (const StationTask& task : scene->tasks) check_hold(task, *scene, tasks);
  scene->file = std::filesystem::absolute(file);
  scene->files = hash_of(std::array{robot.is_flown() && is_robot_file(file) ? std::filesystem::path() : file,
                                    scene->setting.script().scene_file, tasks},
                         robot.is_flown() ? flown_bits(*scene->arm()) : "");
  if (robot.is_flown()) {
    scene->view = std::min(kFarthestView, 2.0 * extent_of(scene->setting, *scene->arm()));
    scene->scales = hand_scales_of(reach_of(*scene->arm()->mechanism));
  }
  if (robots.recorded != nullptr) {
    const auto recorded = robots.recorded->find(scene->name);
    scene->scales = recorded == robots.recorded->end() ? HandScales{} : recorded->second;
  }
  if (robots.shows_meshes) scene->meshes = place_meshes(find_meshes(file, scene->setting, robot, robots));
  return scene;
}

std::string scene_json(const StationScene& scene) {
  const Script& script = scene.setting.script();
  json out = {{"type", "scene"},
              {"name", scene.name},
              {"title", script.name},
              {"description", script.scene.description},
              {"gap", script.scene.contact_gap},
              {"objects", objects_json(scene)},
              {"solids", solids_json(scene)},
              {"arms", arms_json(scene)},
              {"dynamics", scene.dynamics != nullptr},
              {"hand", scene.hand_object()},
              {"rates", rates_json(scene.scales)},
              {"view", scene.view},
              {"tips", tips_json(scene)},
              {"cameras", cameras_json(scene)},
              {"latches", latches_json(scene)},
              {"holds", holds_json(scene)},
              {"tasks", tasks_json(scene)}};
  if (!scene.meshes.bytes.empty())
    out["meshes"] = {{"path", scene.meshes.path}, {"triangles", scene.meshes.triangles}};
  return program::one_line(out);
}

}  // namespace touchstone::station
