#include "touchstone/physics/scene/scene_latches.hpp"

namespace touchstone::physics {

std::size_t first_latch_option(const DynamicScene& scene) {
  return scene.scene.latches.size() + scene.actions.size();
}

std::size_t latch_between(const DynamicScene& scene, std::size_t carrier, std::size_t carried) {
  const auto is_same = [&](std::size_t its_carrier, std::size_t its_carried) {
    return its_carrier == carrier && its_carried == carried;
  };
  for (std::size_t i = 0; i < scene.latch_options.size(); ++i)
    if (is_same(scene.latch_options[i].carrier, scene.latch_options[i].carried))
      return first_latch_option(scene) + i;
  const auto& latches = scene.scene.latches;
  for (std::size_t i = 0; i < latches.size(); ++i)
    if (is_same(find_object(scene.scene, latches[i].carrier), find_object(scene.scene, latches[i].carried)))
      return i;
  for (std::size_t i = 0; i < scene.actions.size(); ++i)
    if (scene.actions[i].kind == SceneAction::Kind::latch &&
        is_same(scene.actions[i].carrier, scene.actions[i].carried))
      return latches.size() + i;
  return kNoLatch;
}

std::span<const ExemptPair> allowed_by(const DynamicScene& scene, std::size_t latch) {
  const std::size_t first = scene.scene.latches.size(), options = first_latch_option(scene);
  if (latch < first) return scene.scene.latches[latch].allowed;
  if (latch >= options) return scene.latch_options[latch - options].allowed;
  return scene.actions[latch - first].allowed;
}

}  // namespace touchstone::physics
