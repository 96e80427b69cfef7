#include "touchstone/adapters/scene_files/dynamics/parts.hpp"

#include <algorithm>
#include <array>

namespace touchstone::scene_files {
namespace {

using physics::DynamicScene;
using physics::SceneAction;
using physics::SceneJoint;

/// A joint that moves is driven from then on.
void read_drive_action(const YamlReader& drive, const DynamicScene& scene, SceneAction& action) {
  drive.require_keys(
      {"joint", "torque", "ramp", "rate", "brake", "limit", "position", "stiffness", "damping"});
  action.joint = read_joint_name(drive.at("joint"), scene);
  if (kind_of(scene, action.joint) == JointKind::fixed) drive.at("joint").fail("is fixed");
  action.drive = read_drive(drive, kind_of(scene, action.joint));
}

/// An arm's joint is put at a value.
void read_set_action(const YamlReader& set, const DynamicScene& scene, SceneAction& action) {
  set.require_keys({"joint", "value", "rate"});
  action.kind = SceneAction::Kind::set_joint;
  // The joint is one of a mechanism that moves.
  action.joint = read_joint_name(set.at("joint"), scene);
  if (action.joint.is_of_bodies()) set.at("joint").fail("is no joint of a mechanism");
  const SceneJoint& joint = scene.mechanisms[action.joint.mechanism].joints[action.joint.joint];
  if (joint.kind == JointKind::fixed) set.at("joint").fail("is fixed");
  // Its value stays within the limits.
  action.value = read_joint_figure(set.at("value"), joint.kind);
  if (!(action.value >= joint.lower && action.value <= joint.upper))
    set.at("value").fail("is out of the joint's limits");
  if (set.has("rate")) action.rate = read_joint_figure(set.at("rate"), joint.kind);
}

/// An object is latched to a carrier.
void read_latch_action(const YamlReader& latch, const DynamicScene& scene, SceneAction& action) {
  latch.require_keys({"carrier", "carried", "allowed"});
  action.kind = SceneAction::Kind::latch;
  action.carrier = read_object(latch.at("carrier"), scene.scene);
  action.carried = read_object(latch.at("carried"), scene.scene);
  if (latch.has("allowed")) action.allowed = read_exempt_pairs(latch.at("allowed"), scene.scene);
}

}  // namespace

SceneAction read_action(const YamlReader& item, const DynamicScene& scene) {
  // One action an item, so that its kind is never in doubt.
  const std::array<const char*, 8> kinds{"drive", "latch", "release", "set", "join", "part", "add", "remove"};
  item.require_keys({"time", "drive", "latch", "release", "set", "join", "part", "add", "remove"});
  if (std::count_if(kinds.begin(), kinds.end(), [&](const char* kind) { return item.has(kind); }) != 1)
    item.fail("expected one of drive, latch, release, set, join, part, add, remove");
  SceneAction action;
  action.where = where(item);
  action.time = read_at_least_0(item.at("time"), item.at("time").number());
  // Drives, values and latches have keys of their own.
  if (item.has("drive")) read_drive_action(item.at("drive"), scene, action);
  if (item.has("set")) read_set_action(item.at("set"), scene, action);
  if (item.has("latch")) read_latch_action(item.at("latch"), scene, action);
  // Joints between bodies are joined and parted by name.
  for (const auto& [key, kind] :
       {std::pair("join", SceneAction::Kind::join), std::pair("part", SceneAction::Kind::part)}) {
    if (!item.has(key)) continue;
    action.kind = kind;
    action.joint = read_joint_name(item.at(key), scene);
    if (!action.joint.is_of_bodies()) item.at(key).fail("is no joint between bodies");
  }
  // So are objects that are released, come in or go out.
  for (const auto& [key, kind] :
       {std::pair("release", SceneAction::Kind::release), std::pair("add", SceneAction::Kind::add),
        std::pair("remove", SceneAction::Kind::remove)}) {
    if (!item.has(key)) continue;
    action.kind = kind;
    action.carried = read_object(item.at(key), scene.scene);
  }
  return action;
}

}  // namespace touchstone::scene_files
