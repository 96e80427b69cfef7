#include "touchstone/adapters/scene_files/guard_file.hpp"

#include "touchstone/adapters/scene_files/scene_head.hpp"
#include "touchstone/contact_core/input_error.hpp"

namespace touchstone {
namespace {

using physics::GuardPolicy;
using scene_files::YamlReader;
using scene_files::YamlSource;

GuardPolicy read_guard_policy(const YamlReader& reader) {
  for (const GuardPolicy policy :
       {GuardPolicy::cue, GuardPolicy::hold, GuardPolicy::advance, GuardPolicy::slide, GuardPolicy::push})
    if (reader.text() == physics::to_string(policy)) return policy;
  reader.fail("unknown policy '" + reader.text() + "'; known: cue, hold, advance, slide, push");
}

physics::GuardRule read_rule(const YamlReader& item) {
  item.require_keys({"between", "policy"});
  const std::vector<YamlReader> names = item.at("between").list();
  if (names.size() != 2) item.at("between").fail("expected two objects or groups");
  return {names[0].text(), names[1].text(), read_guard_policy(item.at("policy"))};
}

SceneHand read_hand(const YamlReader& item, const Scene& scene) {
  item.require_keys({"link", "point", "rates"});
  SceneHand hand;
  hand.name = item.at("link").text();
  hand.hand.link = find_object(scene, hand.name);
  if (hand.hand.link == kNoObject) item.at("link").fail("the scene has no object '" + hand.name + "'");
  if (item.has("point")) hand.hand.p_O = item.at("point").length3();
  for (const YamlReader& row : item.at("rates").list()) {
    row.require_keys({"time", "velocity", "turn"});
    GuardedRates rates;
    rates.time = row.at("time").number();
    if (row.has("velocity")) rates.wanted_W.v = row.at("velocity").length3();
    if (row.has("turn")) rates.wanted_W.w = row.at("turn").vector3() * row.source().radians_per_angle;
    if (!hand.rates.empty() && !(rates.time > hand.rates.back().time))
      row.at("time").fail("is not after the row before");
    hand.rates.push_back(rates);
  }
  return hand;
}

/// A figure of SlideBudget, if the guard has it.
void read_most(const YamlReader& guard, const char* key, std::uint64_t& most) {
  if (!guard.has(key)) return;
  const int value = guard.at(key).integer();
  if (value < 1) guard.at(key).fail("must be at least 1");
  most = static_cast<std::uint64_t>(value);
}

}  // namespace

bool has_guard(const std::filesystem::path& path) {
  const YAML::Node document = scene_files::parse_yaml(path);
  return document.IsMap() && document["dynamics"] && document["dynamics"].IsMap() &&
         document["dynamics"]["guard"];
}

GuardedScene load_guarded_scene(const std::filesystem::path& path, const SceneParameters& parameters,
                                const ArmModels& arm_models) {
  GuardedScene out{load_dynamic_scene(path, parameters, arm_models), {}, {}};
  YamlSource source;
  source.file = path.string();
  const YAML::Node document = scene_files::parse_yaml(path);
  const YamlReader root(document, source);
  scene_files::read_units(root, source);
  source.parameters = out.scene.scene.parameters;
  const YamlReader dynamics = root.at("dynamics");
  if (!dynamics.has("guard")) dynamics.fail("there is no guard");
  const YamlReader guard = dynamics.at("guard");
  guard.require_keys({"policy", "gap", "slide_pairs", "slide_work", "rules", "hands"});
  if (guard.has("policy")) out.settings.policy = read_guard_policy(guard.at("policy"));
  if (guard.has("gap")) out.settings.gap = guard.at("gap").length();
  read_most(guard, "slide_pairs", out.settings.slides.pairs);
  read_most(guard, "slide_work", out.settings.slides.mover_work);
  if (guard.has("rules"))
    for (const YamlReader& item : guard.at("rules").list()) out.settings.rules.push_back(read_rule(item));
  if (guard.has("hands"))
    for (const YamlReader& item : guard.at("hands").list())
      out.hands.push_back(read_hand(item, out.scene.scene));
  return out;
}

}  // namespace touchstone
