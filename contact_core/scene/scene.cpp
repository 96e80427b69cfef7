#include "touchstone/contact_core/scene/scene.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/contact_core/scene/scene_instance.hpp"

namespace touchstone {
namespace {

void require_positive(const Scene& scene, double value, const char* what) {
  if (!std::isfinite(value) || !(value > 0.0))
    throw InputError("scene '" + scene.name + "': " + what + " must be finite and > 0");
}

// Objects and groups share one name space, so that an exemption can only mean one thing; '/' separates object
// and hexahedron in it.
void validate_names(const Scene& scene) {
  std::set<std::string> names;
  for (const SceneObject& object : scene.objects) {
    const std::string& name = object.tree.name();
    if (name.empty()) throw InputError("scene '" + scene.name + "': an object has no name");
    if (name.find('/') != std::string::npos)
      throw InputError("object '" + name + "': a name may not contain '/'");
    if (!names.insert(name).second) throw InputError("object '" + name + "': the name occurs twice");
  }
  for (const SceneObject& object : scene.objects)
    for (const std::string& group : object.groups)
      if (group.empty() || names.count(group) != 0)
        throw InputError("object '" + object.tree.name() + "': group '" + group +
                         "' is empty or has the name of an object");
}

/// Of the first `count` latches.
std::size_t carrier_among(const Scene& scene, std::size_t count, std::size_t object) {
  for (std::size_t i = 0; i < count; ++i)
    if (scene.latches[i].carried == scene.objects[object].tree.name())
      return find_object(scene, scene.latches[i].carrier);
  return kNoObject;
}

bool is_named(const SceneObject& object, std::string_view name) {
  return object.tree.name() == name ||
         std::find(object.groups.begin(), object.groups.end(), name) != object.groups.end();
}

}  // namespace

std::size_t find_object(const Scene& scene, std::string_view name) {
  for (std::size_t i = 0; i < scene.objects.size(); ++i)
    if (scene.objects[i].tree.name() == name) return i;
  return kNoObject;
}

std::size_t carrier_of(const Scene& scene, std::size_t object) {
  return carrier_among(scene, scene.latches.size(), object);
}

std::vector<std::size_t> find_objects(const Scene& scene, std::string_view name) {
  std::vector<std::size_t> found;
  for (std::size_t i = 0; i < scene.objects.size(); ++i)
    if (is_named(scene.objects[i], name)) found.push_back(i);
  return found;
}

bool may_be_taken_along(const Scene& scene, std::size_t object) {
  const SceneObject& it = scene.objects[object];
  if (it.is_static || !it.motion.at_rest() || carrier_of(scene, object) != kNoObject) return false;
  if (scene.passive != Passive::stays) return true;
  return std::any_of(scene.rules.begin(), scene.rules.end(), [&](const SceneRule& rule) {
    return rule.passive.value_or(Passive::stays) != Passive::stays &&
           (is_named(it, rule.first) || is_named(it, rule.second));
  });
}

void validate_rule(const Scene& scene, const SceneRule& rule) {
  const auto fail = [&](const std::string& reason) {
    throw InputError("rule between '" + rule.first + "' and '" + rule.second + "': " + reason);
  };
  for (const std::string* name : {&rule.first, &rule.second})
    if (find_objects(scene, *name).empty()) fail("'" + *name + "' names no object or group of the scene");
  if (rule.first == rule.second && find_object(scene, rule.first) != kNoObject)
    fail("names one object twice");
  if (rule.warn_distance && !(*rule.warn_distance >= 0.0 && std::isfinite(*rule.warn_distance)))
    fail("the warn distance must be finite and >= 0");
  if (!rule.policy && !rule.warn_distance && !rule.translation_only && !rule.passive) fail("sets nothing");
}

void validate_latch(const Scene& scene, std::size_t index) {
  const SceneLatch& latch = scene.latches[index];
  const auto fail = [&](const std::string& reason) {
    throw InputError("latch of '" + latch.carried + "' to '" + latch.carrier + "': " + reason);
  };
  for (const std::string* name : {&latch.carrier, &latch.carried})
    if (find_object(scene, *name) == kNoObject) fail("'" + *name + "' names no object of the scene");
  const std::size_t carried = find_object(scene, latch.carried);
  const std::size_t other = carrier_among(scene, index, carried);
  if (other != kNoObject)
    fail("'" + latch.carried + "' is already carried by '" + scene.objects[other].tree.name() + "'");
  if (!scene.objects[carried].motion.at_rest()) fail("'" + latch.carried + "' has a motion of its own");
  if (scene.objects[carried].is_static) fail("'" + latch.carried + "' is static");
  for (std::size_t i = find_object(scene, latch.carrier); i != kNoObject; i = carrier_among(scene, index, i))
    if (i == carried) fail("closes a cycle");
  for (const ExemptPair& pair : latch.allowed) {
    find_solids(scene, pair.first);
    find_solids(scene, pair.second);
  }
}

std::string_view to_string(ContactPolicy policy) {
  switch (policy) {
    case ContactPolicy::cue:
      return "cue";
    case ContactPolicy::hold:
      return "hold";
    case ContactPolicy::advance:
      return "advance";
    case ContactPolicy::slide:
      return "slide";
  }
  return "invalid ContactPolicy";
}

std::string_view to_string(Passive passive) {
  constexpr std::array<std::string_view, 3> kNames{"stays", "shoved", "carried"};
  return kNames[static_cast<std::size_t>(passive)];
}

std::uint64_t Scene::frame_count() const {
  // Two figures from a file, each rounded to half an ulp, and their product: together below 2 eps. A whole
  // number of frames that came out just below it still counts.
  const double frames = duration * frame_rate;
  const double nearest = std::round(frames);
  const bool whole = std::abs(frames - nearest) <= 2 * std::numeric_limits<double>::epsilon() * nearest;
  return static_cast<std::uint64_t>(whole ? nearest : std::floor(frames)) + 1;
}

void validate(const Scene& scene) {
  if (scene.name.empty()) throw InputError("scene: no name");
  require_positive(scene, scene.frame_rate, "the frame rate");
  require_positive(scene, scene.contact_gap, "the contact gap");
  require_positive(scene, scene.duration, "the duration");
  // Frame numbers stay exact as doubles.
  if (scene.duration * scene.frame_rate > 0x1p52)
    throw InputError("scene '" + scene.name + "': more than 2^52 frames");
  if (scene.objects.empty()) throw InputError("scene '" + scene.name + "': no object");
  validate_names(scene);
  for (const SceneObject& object : scene.objects) {
    const std::string name = "object '" + object.tree.name() + "'";
    validate_pose(object.X_WO, name + ": pose");
    validate_motion(object.motion, name);
    if (object.is_static && !object.motion.at_rest()) throw InputError(name + ": is static and has a motion");
  }
  for (const ExemptPair& pair : scene.exempt_pairs) {
    find_solids(scene, pair.first);
    find_solids(scene, pair.second);
  }
  for (std::size_t i = 0; i < scene.latches.size(); ++i) validate_latch(scene, i);
  for (const SceneRule& rule : scene.rules) validate_rule(scene, rule);
}

}  // namespace touchstone
