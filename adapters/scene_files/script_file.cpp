#include "touchstone/adapters/scene_files/script_file.hpp"

#include <algorithm>

#include "touchstone/adapters/scene_files/scene_head.hpp"
#include "touchstone/adapters/scene_files/yaml_reader.hpp"
#include "touchstone/contact_core/input_error.hpp"

namespace touchstone {
namespace {

using scene_files::YamlReader;
using scene_files::YamlSource;

double read_time(const YamlReader& item) {
  const YamlReader reader = item.at("time");
  const double time = reader.number();
  if (time < 0.0) reader.fail("is before the start");
  return time;
}

std::string read_object(const YamlReader& reader, const Scene& scene) {
  const std::string name = reader.text();
  for (const SceneObject& object : scene.objects)
    if (object.tree.name() == name) return name;
  reader.fail("the scene has no object '" + name + "'");
}

void leave_out(const YamlReader& list, Scene& scene) {
  for (const YamlReader& item : list.list()) {
    const std::string name = read_object(item, scene);
    std::erase_if(scene.objects, [&](const SceneObject& object) { return object.tree.name() == name; });
  }
  validate(scene);  // something else may have named it
}

Scene read_scene(const YamlReader& reader, const std::filesystem::path& script) {
  reader.require_keys({"file", "parameters", "without"});
  SceneParameters parameters;
  if (reader.has("parameters")) {
    const YamlReader list = reader.at("parameters");
    list.require_keys({});
    for (const auto& entry : list.node())
      parameters[entry.first.Scalar()] = list.at(entry.first.Scalar()).number();
  }
  const YamlReader file = reader.at("file");
  return file.located([&] {
    Scene scene = load_scene(script.parent_path() / file.text(), parameters);
    if (reader.has("without")) leave_out(reader.at("without"), scene);
    return scene;
  });
}

void read_frames(const YamlReader& root, Scene& scene) {
  if (root.has("frame_rate")) scene.frame_rate = root.at("frame_rate").number();
  if (scene.frame_rate < kLowestFrameRate || scene.frame_rate > kHighestFrameRate) {
    const YamlReader& where = root.has("frame_rate") ? root.at("frame_rate") : root;
    where.fail("the frame rate is not within 10 and 1000 Hz");
  }
  if (!root.has("duration")) return;
  const YamlReader reader = root.at("duration");
  scene.duration = reader.number();
  if (!(scene.duration > 0.0)) reader.fail("is not above 0");
}

HandRates read_rates(const YamlReader& item) {
  item.require_keys({"time", "velocity", "turn", "mode"});
  HandRates rates;
  rates.time = read_time(item);
  if (item.has("velocity")) rates.velocity = item.at("velocity").length3();
  if (item.has("turn")) rates.turn = item.at("turn").vector3() * item.source().radians_per_angle;
  if (item.has("mode")) {
    const YamlReader mode = item.at("mode");
    if (mode.text() != "world" && mode.text() != "hand")
      mode.fail("unknown mode '" + mode.text() + "'; known: world, hand");
    if (mode.text() == "hand") rates.mode = HandRates::Mode::hand;
  }
  return rates;
}

std::string read_held_joint(const YamlReader& reader, const Mechanism& mechanism) {
  const std::uint32_t index = reader.located([&] { return mechanism.find_joint(reader.text()); });
  const Mechanism::Joint& joint = mechanism.joints()[index];
  if (joint.value != Mechanism::kNone) return joint.name;
  reader.fail("joint '" + reader.text() + "' does not move");
}

ArmScript read_arm(const YamlReader& reader) {
  reader.require_keys({"model", "link", "joints", "held_joints", "pose", "hold"});
  ArmScript arm;
  arm.model = reader.at("model").text();
  arm.mechanism = std::make_shared<const Mechanism>(scene_files::read_arm_model(reader.at("model")));
  arm.link = reader.at("link").text();
  arm.joints = scene_files::read_joint_values(reader.at("joints"), *arm.mechanism);
  if (reader.has("held_joints"))
    for (const YamlReader& joint : reader.at("held_joints").list())
      arm.held_joints.push_back(read_held_joint(joint, *arm.mechanism));
  const YamlReader pose = reader.at("pose");
  pose.require_keys({"position", "rpy"});
  Vector6 position = Vector6::Zero();
  if (pose.has("position")) position.head<3>() = pose.at("position").length3();
  if (pose.has("rpy")) position.tail<3>() = pose.at("rpy").vector3() * reader.source().radians_per_angle;
  arm.X_WL = pose_from_position_vector(position);
  if (reader.has("hold")) arm.holds = scene_files::read_choice(reader.at("hold"));
  return arm;
}

HandScript read_hand(const YamlReader& item, const Script& script) {
  item.require_keys({"object", "rates", "arm"});
  HandScript hand;
  if (item.has("object") == item.has("arm")) item.fail("expected one of object, arm");
  if (item.has("object"))
    hand.object = read_object(item.at("object"), script.scene);
  else
    hand.arm = read_arm(item.at("arm"));
  for (const HandScript& other : script.hands)
    if (hand.arm ? other.arm && other.arm->model == hand.arm->model : other.object == hand.object)
      item.fail("two hands fly '" + (hand.arm ? hand.arm->model : hand.object) + "'");
  const YamlReader here = item.within("hand on '" + (hand.arm ? hand.arm->model : hand.object) + "'");
  const YamlReader list = here.at("rates");
  for (const YamlReader& row : list.list()) {
    hand.rates.push_back(read_rates(row));
    const std::size_t count = hand.rates.size();
    if (count > 1 && !(hand.rates[count - 1].time > hand.rates[count - 2].time))
      row.at("time").fail("is not after the row before");
  }
  if (hand.rates.empty()) list.fail("expected at least one row");
  return hand;
}

/// The scene with the links of all arms that are flown, as the actions see it: by name alone.
Scene with_links(const Script& script) {
  Scene scene = script.scene;
  for (const HandScript& hand : script.hands) {
    if (!hand.arm) continue;
    for (const Mechanism::Link& link : hand.arm->mechanism->links())
      if (link.tree) scene.objects.push_back({*link.tree, {}, {}, {}});
  }
  return scene;
}

OperatorAction read_hold(const YamlReader& hold, double time, const Scene& scene, std::size_t first_link) {
  hold.require_keys({"fixture", "link"});
  OperatorAction action;
  action.kind = OperatorAction::Kind::hold;
  action.time = time;
  action.carrier = read_object(hold.at("fixture"), scene);
  action.object = read_object(hold.at("link"), scene);
  if (find_object(scene, action.carrier) >= first_link) hold.at("fixture").fail("is a link of an arm");
  if (find_object(scene, action.object) < first_link) hold.at("link").fail("is no link of an arm");
  return action;
}

OperatorAction read_action(const YamlReader& item, const Scene& scene, std::size_t first_link) {
  item.require_keys({"time", "latch", "release", "switch_on", "switch_off", "hold"});
  using Kind = OperatorAction::Kind;
  OperatorAction action;
  action.time = read_time(item);
  // An action is one of five.
  const int named = int{item.has("latch")} + int{item.has("release")} + int{item.has("switch_on")} +
                    int{item.has("switch_off")} + int{item.has("hold")};
  if (named != 1) item.fail("expected one of latch, release, switch_on, switch_off, hold");
  if (item.has("hold")) return read_hold(item.at("hold"), action.time, scene, first_link);
  if (item.has("latch")) {
    const YamlReader latch = item.at("latch");
    latch.require_keys({"carrier", "carried", "allowed"});
    action.carrier = read_object(latch.at("carrier"), scene);
    action.object = read_object(latch.at("carried"), scene);
    if (find_object(scene, action.object) >= first_link)
      latch.at("carried").fail("a link of an arm is carried by nothing");
    if (latch.has("allowed")) action.allowed = scene_files::read_exempt_pairs(latch.at("allowed"), scene);
    return action;
  }
  // The rest name one object.
  const char* key = item.has("release") ? "release" : item.has("switch_on") ? "switch_on" : "switch_off";
  action.kind = item.has("release")     ? Kind::release
                : item.has("switch_on") ? Kind::switch_on
                                        : Kind::switch_off;
  action.object = read_object(item.at(key), scene);
  return action;
}

void read_actions(const YamlReader& reader, const Scene& with_links, Script& script) {
  for (const YamlReader& item : reader.list()) {
    script.actions.push_back(read_action(item, with_links, script.scene.objects.size()));
    const std::size_t count = script.actions.size();
    if (count > 1 && script.actions[count - 1].time < script.actions[count - 2].time)
      item.at("time").fail("is before the action above");
  }
}

Script read_script(const YamlReader& root, YamlSource& source, const std::filesystem::path& path) {
  root.require_keys({"name", "description", "scene", "units", "frame_rate", "policy", "translation_only",
                     "duration", "hands", "actions"});
  scene_files::read_units(root, source);
  Script script;
  script.name = root.at("name").text();
  if (root.has("description")) script.description = root.at("description").text();
  script.scene = read_scene(root.at("scene"), path);
  script.scene_file = path.parent_path() / root.at("scene").at("file").text();
  for (SceneObject& object : script.scene.objects) object.motion = {};
  read_frames(root, script.scene);
  if (root.has("policy")) script.scene.policy = scene_files::read_policy(root.at("policy"));
  if (root.has("translation_only"))
    script.translation_only = scene_files::read_choice(root.at("translation_only"));
  for (const YamlReader& item : root.at("hands").list()) script.hands.push_back(read_hand(item, script));
  if (script.hands.empty()) root.at("hands").fail("expected at least one hand");
  if (root.has("actions")) {
    const Scene scene = with_links(script);
    read_actions(root.at("actions"), scene, script);
  }
  return script;
}

}  // namespace

Script load_script(const std::filesystem::path& path, const ArmModels& arm_models) {
  YamlSource source;
  source.arm_models = arm_models;
  source.file = path.string();
  const YAML::Node document = scene_files::parse_yaml(path);
  const YamlReader root(document, source);
  return read_script(root, source, path);
}

}  // namespace touchstone
