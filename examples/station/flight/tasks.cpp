#include "touchstone/examples/station/flight/tasks.hpp"

#include <algorithm>
#include <array>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>

#include "touchstone/contact_core/geometry/quaternion.hpp"
#include "touchstone/contact_core/input_error.hpp"

namespace touchstone::station {
namespace {

using nlohmann::json;
using Kind = StationTask::Kind;

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr std::array<const char*, 8> kKinds = {"carry", "bring", "place", "reach",
                                               "grip",  "joint", "hold",  "stand"};
constexpr std::array<const char*, 12> kKeys = {"name", "title", "kind",   "object", "tip",   "position",
                                               "rpy",  "turn",  "within", "joint",  "value", "limits"};

void read_limits(const json& limits, StationTask& task) {
  for (const auto& [name, value] : limits.items()) {
    const double most = value.get<double>();
    if (!(most >= 0.0)) throw InputError("the limit '" + name + "' is below 0");
    if (name == "force")
      task.most_force = most;
    else if (name == "time")
      task.most_time = most;
    else if (name == "contacts")
      task.most_contacts = value.get<std::uint32_t>();
    else
      throw InputError("no limit '" + name + "'");
  }
}

void read_place(const json& from, StationTask& task) {
  const auto p = from.at("position").get<std::array<double, 3>>();
  task.p_W = {p[0], p[1], p[2]};
  task.within = from.at("within");
  if (from.contains("rpy") != from.contains("turn")) throw InputError("'rpy' and 'turn' go together");
  if (!from.contains("rpy")) return;
  const auto rpy = from.at("rpy").get<std::array<double, 3>>();
  Vector6 position = Vector6::Zero();
  for (int i = 0; i < 3; ++i) position[3 + i] = rpy[static_cast<std::size_t>(i)] * kDegree;
  task.R_W = pose_from_position_vector(position).R;
  task.most_turn = from.at("turn").get<double>() * kDegree;
  if (!(task.most_turn >= 0.0)) throw InputError("'turn' is below 0");
}

void read_joint(const json& from, const training::Setting& setting, StationTask& task) {
  if (setting.arms().empty()) throw InputError("there is no arm");
  const Mechanism& mechanism = *setting.arms()[0].mechanism;
  const Mechanism::Joint& joint =
      mechanism.joints()[mechanism.find_joint(from.at("joint").get<std::string>())];
  if (joint.value == Mechanism::kNone) throw InputError("joint '" + joint.name + "' does not move");
  const double unit = joint.kind == JointKind::prismatic ? 1.0 : kDegree;
  task.joint = joint.value;
  task.value = from.at("value").get<double>() * unit;
  task.within = from.at("within").get<double>() * unit;
}

void read_object(const json& from, const training::Setting& setting, StationTask& task) {
  const auto name = from.at("object").get<std::string>();
  const std::size_t object = find_object(setting.scene(), name);
  if (object == kNoObject) throw InputError("there is no object '" + name + "'");
  task.object = static_cast<std::uint32_t>(object);
}

void read_tip(const json& from, const std::vector<Tip>& tips, StationTask& task) {
  if (from.contains("tip")) {
    const auto name = from.at("tip").get<std::string>();
    const auto found =
        std::find_if(tips.begin(), tips.end(), [&](const Tip& tip) { return tip.name == name; });
    if (found == tips.end()) throw InputError("there is no tip '" + name + "'");
    task.tip = static_cast<std::uint32_t>(found - tips.begin());
  }
  if (task.kind == Kind::grip && tips[task.tip].jaws.empty()) throw InputError("that tip has no jaws");
}

void read_goal(const json& from, const training::Setting& setting, const std::vector<Tip>& tips,
               StationTask& task) {
  for (const auto& [key, value] : from.items())
    if (std::find(kKeys.begin(), kKeys.end(), key) == kKeys.end())
      throw InputError("unknown field '" + key + "'");
  const auto kind = from.at("kind").get<std::string>();
  const auto found = std::find(kKinds.begin(), kKinds.end(), kind);
  if (found == kKinds.end()) throw InputError("no kind of task '" + kind + "'");
  task.kind = static_cast<Kind>(found - kKinds.begin());
  read_tip(from, tips, task);
  if (task.kind == Kind::joint) return read_joint(from, setting, task);
  if (task.kind != Kind::reach) read_object(from, setting, task);
  const bool has_place = task.kind == Kind::bring || task.kind == Kind::place || task.kind == Kind::reach;
  if (has_place) read_place(from, task);
}

StationTask read_task(const json& from, const training::Setting& setting, const std::vector<Tip>& tips) {
  StationTask task;
  task.name = from.at("name");
  task.title = from.at("title");
  try {
    read_goal(from, setting, tips, task);
    if (from.contains("limits")) read_limits(from.at("limits"), task);
  } catch (const json::exception& error) {
    throw InputError("task '" + task.name + "': " + error.what());
  } catch (const InputError& error) {
    throw InputError("task '" + task.name + "': " + error.what());
  }
  return task;
}

}  // namespace

bool is_at(const StationTask& task, const Pose& X_W) {
  if (!(norm(X_W.p - task.p_W) <= task.within)) return false;
  if (task.most_turn == StationTask{}.most_turn) return true;
  return axis_angle_of(quaternion_of(task.R_W.transpose() * X_W.R)).angle <= task.most_turn;
}

std::vector<StationTask> read_tasks(const std::filesystem::path& file, const training::Setting& setting,
                                    const std::vector<Tip>& tips) {
  std::vector<StationTask> tasks;
  std::ifstream in(file);
  if (!in) return tasks;
  try {
    for (const json& task : json::parse(in)) tasks.push_back(read_task(task, setting, tips));
  } catch (const json::exception& error) {
    throw InputError(file.string() + ": " + error.what());
  } catch (const InputError& error) {
    throw InputError(file.string() + ": " + error.what());
  }
  if (tasks.size() > kMostTasks) throw InputError(file.string() + ": more than 8 tasks");
  return tasks;
}

}  // namespace touchstone::station
