#include "touchstone/contact_core/scene/scene_instance.hpp"

#include <algorithm>

#include "touchstone/contact_core/input_error.hpp"

namespace touchstone {
namespace {

bool is_in_group(const SceneObject& object, std::string_view group) {
  return std::find(object.groups.begin(), object.groups.end(), group) != object.groups.end();
}

SolidPair ordered(SolidIndex a, SolidIndex b) { return a < b ? SolidPair{a, b} : SolidPair{b, a}; }

void sort_once(std::vector<SolidPair>& pairs) {
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
}

}  // namespace

std::vector<SolidIndex> find_solids(const Scene& scene, std::string_view name) {
  const std::size_t slash = name.find('/');
  const std::string_view object_name = name.substr(0, slash);
  const bool whole = slash == std::string_view::npos;
  std::vector<SolidIndex> found;
  SolidIndex index = 0;
  for (const SceneObject& object : scene.objects) {
    const bool meant = object.tree.name() == object_name || (whole && is_in_group(object, name));
    for (const PlacedHexahedron& placed : object.tree.solids()) {
      if (meant && (whole || placed.name == name.substr(slash + 1))) found.push_back(index);
      ++index;
    }
  }
  if (found.empty())
    throw InputError("exempt: '" + std::string(name) +
                     "' names no object, object/hexahedron or group of the scene");
  return found;
}

SceneInstance::SceneInstance(const Scene& scene) : scene_(&scene) {
  validate(scene);
  // Solids of all objects are numbered in one row.
  for (std::uint32_t o = 0; o < scene.objects.size(); ++o) {
    const HexahedronTree& tree = scene.objects[o].tree;
    trees_.push_back(&tree);
    first_solid_.push_back(static_cast<SolidIndex>(solids_.size()));
    for (const PlacedHexahedron& placed : tree.solids()) {
      solids_.push_back(placed.solid);
      object_of_.push_back(o);
    }
  }
  // Objects that are carried move with the root of what carries them.
  for (std::uint32_t o = 0; o < scene.objects.size(); ++o) {
    std::size_t root = o;
    while (carrier_of(scene, root) != kNoObject) root = carrier_of(scene, root);
    root_of_.push_back(static_cast<std::uint32_t>(root));
    X_RO_.push_back(root == o ? Pose{} : compose(inverse(scene.objects[root].X_WO), scene.objects[o].X_WO));
  }
  // A search needs the exempt pairs sorted, each of them once.
  const auto exempt = [&](const ExemptPair& pair) {
    const std::vector<SolidPair> named = solids_of(pair);
    exempt_pairs_.insert(exempt_pairs_.end(), named.begin(), named.end());
  };
  for (const ExemptPair& pair : scene.exempt_pairs) exempt(pair);
  for (const SceneLatch& latch : scene.latches)
    for (const ExemptPair& pair : latch.allowed) exempt(pair);
  sort_once(exempt_pairs_);
}

std::vector<SolidPair> SceneInstance::solids_of(const ExemptPair& pair) const {
  std::vector<SolidPair> pairs;
  for (const SolidIndex a : find_solids(*scene_, pair.first))
    for (const SolidIndex b : find_solids(*scene_, pair.second))
      if (object_of_[a] != object_of_[b]) pairs.push_back(ordered(a, b));
  sort_once(pairs);
  return pairs;
}

std::string SceneInstance::solid_name(SolidIndex solid) const {
  const std::uint32_t object = object_of_[solid];
  return trees_[object]->name() + "/" + trees_[object]->solids()[solid - first_solid_[object]].name;
}

void SceneInstance::poses_at(double time, std::span<Pose> out) const {
  for (std::uint32_t o = 0; o < trees_.size(); ++o) {
    const SceneObject& root = scene_->objects[root_of_[o]];
    Pose X_WO = pose_at(root.motion, root.X_WO, time);
    if (root_of_[o] != o) X_WO = compose(X_WO, X_RO_[o]);
    find_global_positions(*trees_[o], X_WO, out.subspan(first_solid_[o], trees_[o]->solids().size()));
  }
}

bool SceneInstance::is_exempt(SolidIndex a, SolidIndex b) const {
  if (root_of_[object_of_[a]] == root_of_[object_of_[b]]) return true;
  return std::binary_search(exempt_pairs_.begin(), exempt_pairs_.end(), ordered(a, b));
}

std::vector<SolidPair> SceneInstance::checked_pairs() const {
  std::vector<SolidPair> pairs;
  const auto count = static_cast<SolidIndex>(solids_.size());
  for (SolidIndex a = 0; a < count; ++a)
    for (SolidIndex b = a + 1; b < count; ++b)
      if (!is_exempt(a, b)) pairs.push_back({a, b});
  return pairs;
}

}  // namespace touchstone
