#include "touchstone/physics/engine/engine_registry.hpp"

#include <algorithm>

#include "touchstone/contact_core/input_error.hpp"

namespace touchstone::physics {

EngineChoice parse_engine_choice(std::string_view text) {
  const std::size_t colon = text.find(':');
  if (colon == std::string_view::npos) return {std::string(text), std::string(kOwnCheck)};
  return {std::string(text.substr(0, colon)), std::string(text.substr(colon + 1))};
}

void EngineRegistry::add(Entry entry) {
  for (const Entry& other : engines_)
    if (other.name == entry.name) throw InputError("engine '" + entry.name + "' is registered twice");
  engines_.push_back(std::move(entry));
}

const EngineRegistry::Entry& EngineRegistry::engine(std::string_view name) const {
  for (const Entry& entry : engines_)
    if (entry.name == name) return entry;
  for (const Missing& missing : missing_)
    if (missing.name == name) throw InputError("engine '" + missing.name + "' is missing: " + missing.reason);
  std::vector<std::string> known;
  for (const Entry& entry : engines_) known.push_back(entry.name);
  throw InputError("no engine '" + std::string(name) + "'; known are " + joined(known));
}

const EngineRegistry::Entry& EngineRegistry::engine(const EngineChoice& choice) const {
  const Entry& entry = engine(choice.engine);
  for (const Missing& refused : entry.refused_checks)
    if (refused.name == choice.check)
      throw InputError("engine '" + entry.name + "': unsupported: check '" + refused.name +
                       "': " + refused.reason);
  if (std::find(entry.checks.begin(), entry.checks.end(), choice.check) == entry.checks.end())
    throw InputError("engine '" + entry.name + "' has no check '" + choice.check + "'; it has " +
                     joined(entry.checks));
  return entry;
}

std::unique_ptr<DynamicsEngine> EngineRegistry::make(const EngineChoice& choice,
                                                     const DynamicScene& scene) const {
  const Entry& entry = engine(choice);
  validate(scene);
  const std::vector<std::string> lacking = unsupported(entry.features(choice.check), scene);
  if (!lacking.empty()) throw InputError("engine '" + choice.text() + "': unsupported: " + joined(lacking));
  std::unique_ptr<DynamicsEngine> made = entry.make(scene, choice.check);
  made->features_ = entry.features(choice.check);
  return made;
}

void set_checks(EngineRegistry::Entry& entry, const BackendRegistry& backends) {
  entry.checks.emplace_back(kOwnCheck);
  for (const BackendRegistry::NarrowphaseEntry& each : backends.narrowphases())
    if (each.make()->capabilities().manifold)
      entry.checks.push_back(each.name);
    else
      entry.refused_checks.push_back({each.name, "it has no manifolds"});
}

std::shared_ptr<CheckInside> make_check(const BackendRegistry& backends, const std::string& check,
                                        const DynamicScene& scene) {
  if (check == kOwnCheck || check == "native") return nullptr;
  std::vector<Hexahedron> solids;
  for (const SceneObject& object : scene.scene.objects)
    for (const PlacedHexahedron& placed : object.tree.solids()) solids.push_back(placed.solid);
  std::unique_ptr<Narrowphase> narrowphase = backends.make_narrowphase(check);
  try {
    narrowphase->build(solids);
  } catch (const InputError& error) {
    throw InputError("check '" + check + "': " + error.what());
  }
  return make_check_inside(std::move(narrowphase));
}

}  // namespace touchstone::physics
