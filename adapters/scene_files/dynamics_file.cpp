#include "touchstone/adapters/scene_files/dynamics_file.hpp"

#include <cmath>

#include "touchstone/adapters/scene_files/arm_reader.hpp"
#include "touchstone/adapters/scene_files/dynamics/parts.hpp"
#include "touchstone/contact_core/input_error.hpp"

namespace touchstone {
namespace scene_files {

std::string where(const YamlReader& reader) { return reader.file_and_line() + ": "; }

YamlReader called(const YamlReader& reader, const std::string& what) {
  return {reader.node(), reader.source(), what + ": "};
}

std::size_t read_object(const YamlReader& reader, const Scene& scene) {
  const std::size_t object = find_object(scene, reader.text());
  if (object == kNoObject) reader.fail("the scene has no object " + in_quotes(reader.text()));
  return object;
}

double read_at_least_0(const YamlReader& reader, double value) {
  if (!(value >= 0.0)) reader.fail("must be >= 0");
  return value;
}

double read_joint_figure(const YamlReader& reader, JointKind kind) {
  return kind == JointKind::revolute ? reader.angle() : reader.length();
}

}  // namespace scene_files

namespace {

using namespace scene_files;
using physics::BodyKind;
using physics::DynamicScene;
using physics::SceneBody;

void read_settings(const YamlReader& dynamics, DynamicScene& out) {
  if (dynamics.has("gravity")) out.gravity_W = dynamics.at("gravity").length3();
  out.step = read_positive(dynamics.at("step"), dynamics.at("step").number());
  const double steps = out.scene.duration / out.step;
  if (!(std::abs(steps - std::round(steps)) <= 0x1p-50 * steps) || steps < 0.5)
    dynamics.at("step").fail("does not divide the duration into whole steps");
  if (dynamics.has("contact_margin")) {
    const YamlReader margin = dynamics.at("contact_margin");
    out.contact_margin = read_positive(margin, margin.length());
    if (!(out.contact_margin > out.scene.contact_gap)) margin.fail("is not above the contact gap");
  }
  const auto read = [&](const char* key, double unit, double& value) {
    if (dynamics.has(key)) value = unit * read_at_least_0(dynamics.at(key), dynamics.at(key).number());
  };
  const double length = 1.0 / dynamics.source().lengths_per_metre;
  read("bounce_speed", length, out.bounce_speed);
  read("push_out", 1.0, out.push_out);
  read("part_speed", length, out.part_speed);
  read("sleep_speed", length, out.sleep_speed);
  read("sleep_time", 1.0, out.sleep_time);
}

DynamicScene read_dynamics(const YamlReader& dynamics, Scene scene) {
  dynamics.require_keys({"gravity",     "step",       "contact_margin", "friction",   "restitution",
                         "combine",     "pairs",      "bounce_speed",   "push_out",   "part_speed",
                         "sleep_speed", "sleep_time", "bodies",         "mechanisms", "joints",
                         "arms",        "exempt",     "latches",        "actions",    "answers",
                         "conserved",   "accept",     "guard"});
  DynamicScene out;
  out.scene = std::move(scene);
  read_settings(dynamics, out);
  // Objects with a motion are kinematic unless `bodies` says otherwise.
  SceneBody usual;
  usual.where = where(dynamics);
  read_surface(dynamics, usual.surface);
  out.bodies.assign(out.scene.objects.size(), usual);
  for (std::size_t i = 0; i < out.bodies.size(); ++i) {
    if (!out.scene.objects[i].motion.at_rest()) out.bodies[i].kind = BodyKind::kinematic;
  }
  // Mechanisms first: bodies, joints and actions name their links.
  if (dynamics.has("mechanisms")) read_mechanisms(dynamics, out);
  read_bodies(dynamics, out);
  if (dynamics.has("arms")) read_arms(dynamics.at("arms"), out);
  if (dynamics.has("joints"))
    for (const YamlReader& item : dynamics.at("joints").list()) read_body_joint(item, out);
  read_pairs(dynamics, out);
  // Those that name links of arms, which the scene itself does not know.
  if (dynamics.has("exempt"))
    for (ExemptPair& pair : read_exempt_pairs(dynamics.at("exempt"), out.scene))
      out.scene.exempt_pairs.push_back(std::move(pair));
  if (dynamics.has("latches")) read_latches(dynamics.at("latches"), out.scene);
  if (dynamics.has("actions"))
    for (const YamlReader& item : dynamics.at("actions").list())
      out.actions.push_back(read_action(item, out));
  if (dynamics.has("answers"))
    for (const YamlReader& item : dynamics.at("answers").list())
      out.answers.push_back(read_answer(item, out));
  if (dynamics.has("conserved")) read_conserved(dynamics.at("conserved"), out);
  if (dynamics.has("accept")) read_accept(dynamics.at("accept"), out);
  return out;
}

}  // namespace

DynamicScene load_dynamic_scene(const std::filesystem::path& path, const SceneParameters& parameters,
                                const ArmModels& arm_models) {
  Scene scene = load_scene(path, parameters);
  YamlSource source;
  source.arm_models = arm_models;
  source.file = path.string();
  const YAML::Node document = parse_yaml(path);
  const YamlReader root(document, source);
  read_units(root, source);
  read_parameters(root, {}, source);
  const bool answers_hold = source.parameters == scene.parameters;
  source.parameters = scene.parameters;
  if (!root.has("dynamics")) throw InputError(source.file + ": the scene asks for no dynamics");
  DynamicScene out = read_dynamics(root.at("dynamics"), std::move(scene));
  out.answers_hold = answers_hold;
  try {
    physics::validate(out);
  } catch (const InputError& error) {
    const std::string_view message = error.what();
    if (message.starts_with(source.file + ":")) throw;
    throw InputError(source.file + ": " + std::string(message));
  }
  return out;
}

}  // namespace touchstone
