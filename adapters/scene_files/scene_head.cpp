#include "touchstone/adapters/scene_files/scene_head.hpp"

#include <array>
#include <cmath>
#include <numbers>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/contact_core/mechanism/arms/bundled_arms.hpp"
#include "touchstone/contact_core/scene/scene_instance.hpp"

namespace touchstone::scene_files {
namespace {

std::string unit_name(const YamlReader& units, const char* key, std::array<const char*, 2> known) {
  if (!units.has(key)) return known[0];
  const YamlReader reader = units.at(key);
  const std::string unit = reader.text();
  if (unit != known[0] && unit != known[1])
    reader.fail("unknown unit " + in_quotes(unit) + "; known: " + known[0] + ", " + known[1]);
  return unit;
}

}  // namespace

double read_positive(const YamlReader& reader, double value) {
  if (!(value > 0.0)) reader.fail("must be > 0");
  return value;
}

std::string read_units(const YamlReader& root, YamlSource& source) {
  std::string length = "m";
  std::string angle = "rad";
  if (root.has("units")) {
    const YamlReader units = root.at("units");
    units.require_keys({"length", "angle"});
    length = unit_name(units, "length", {"m", "mm"});
    angle = unit_name(units, "angle", {"rad", "deg"});
  }
  source.lengths_per_metre = length == "mm" ? 1000.0 : 1.0;
  source.radians_per_angle = angle == "deg" ? std::numbers::pi / 180.0 : 1.0;
  return "length " + length + ", angle " + angle;
}

void read_parameters(const YamlReader& root, const SceneParameters& given, YamlSource& source) {
  std::map<std::string, double> parameters;
  if (root.has("parameters")) {
    const YamlReader reader = root.at("parameters");
    reader.require_keys({});
    for (const auto& entry : reader.node())
      parameters[entry.first.Scalar()] = reader.at(entry.first.Scalar()).number();
  }
  for (const auto& [name, value] : given) {
    const auto found = parameters.find(name);
    if (found == parameters.end()) {
      const std::string known = joined(parameters, [](const auto& entry) { return entry.first; });
      throw InputError(source.file + ": the scene has no parameter " + in_quotes(name) +
                       "; known: " + (known.empty() ? "none" : known));
    }
    if (!std::isfinite(value))
      throw InputError(source.file + ": parameter " + in_quotes(name) + " is not finite");
    found->second = value;
  }
  source.parameters = std::move(parameters);
}

Mechanism read_arm_model(const YamlReader& reader) {
  return reader.located([&] {
    const YamlSource& source = reader.source();
    if (!source.arm_models) return Mechanism(make_bundled_arm(reader.text()));
    return Mechanism(source.arm_models(reader.text(), std::filesystem::path(source.file).parent_path()));
  });
}

std::vector<double> read_joint_values(const YamlReader& list, const Mechanism& mechanism) {
  std::vector<JointKind> kinds;
  for (const Mechanism::Joint& joint : mechanism.joints())
    if (joint.value != Mechanism::kNone) kinds.push_back(joint.kind);
  std::vector<double> values;
  for (const YamlReader& value : list.list()) {
    const bool shifts = values.size() < kinds.size() && kinds[values.size()] == JointKind::prismatic;
    values.push_back(shifts ? value.length() : value.angle());
  }
  return values;
}

ContactPolicy read_policy(const YamlReader& reader) {
  for (const ContactPolicy policy :
       {ContactPolicy::cue, ContactPolicy::hold, ContactPolicy::advance, ContactPolicy::slide})
    if (reader.text() == to_string(policy)) return policy;
  reader.fail("unknown policy " + in_quotes(reader.text()) + "; known: cue, hold, advance, slide");
}

Passive read_passive(const YamlReader& reader) {
  for (const Passive passive : {Passive::stays, Passive::shoved, Passive::carried})
    if (reader.text() == to_string(passive)) return passive;
  reader.fail("unknown choice " + in_quotes(reader.text()) + "; known: stays, shoved, carried");
}

bool read_choice(const YamlReader& reader) {
  if (reader.text() != "true" && reader.text() != "false") reader.fail("expected true or false");
  return reader.text() == "true";
}

std::vector<SceneRule> read_rules(const YamlReader& reader, const Scene& scene) {
  std::vector<SceneRule> rules;
  for (const YamlReader& item : reader.list()) {
    item.require_keys({"between", "policy", "warn_distance", "translation_only", "passive"});
    const std::vector<YamlReader> names = item.at("between").list();
    if (names.size() != 2) item.at("between").fail("expected two objects or groups");
    SceneRule rule{names[0].text(), names[1].text()};
    if (item.has("policy")) rule.policy = read_policy(item.at("policy"));
    if (item.has("warn_distance")) rule.warn_distance = item.at("warn_distance").length();
    if (item.has("translation_only")) rule.translation_only = read_choice(item.at("translation_only"));
    if (item.has("passive")) rule.passive = read_passive(item.at("passive"));
    item.bare().located([&] { validate_rule(scene, rule); });
    rules.push_back(std::move(rule));
  }
  return rules;
}

std::vector<ExemptPair> read_exempt_pairs(const YamlReader& reader, const Scene& scene) {
  std::vector<ExemptPair> pairs;
  for (const YamlReader& item : reader.list()) {
    const std::vector<YamlReader> names = item.list();
    if (names.size() != 2) item.fail("expected a pair of names, got " + std::to_string(names.size()));
    for (const YamlReader& name : names) name.bare().located([&] { find_solids(scene, name.text()); });
    pairs.push_back({names[0].text(), names[1].text()});
  }
  return pairs;
}

void read_latches(const YamlReader& reader, Scene& scene) {
  for (const YamlReader& item : reader.list()) {
    item.require_keys({"carrier", "carried", "allowed"});
    SceneLatch latch{item.at("carrier").text(), item.at("carried").text(), {}};
    if (item.has("allowed")) latch.allowed = read_exempt_pairs(item.at("allowed"), scene);
    scene.latches.push_back(std::move(latch));
    item.bare().located([&] { validate_latch(scene, scene.latches.size() - 1); });
  }
}

}  // namespace touchstone::scene_files
