#include "touchstone/adapters/c_files/scene_parameters.hpp"
#include "touchstone/adapters/c_files/touchstone_files.h"
#include "touchstone/adapters/c_interface/calls.hpp"
#include "touchstone/adapters/c_interface/world.hpp"
#include "touchstone/adapters/scene_files/scene_file.hpp"
#include "touchstone/contact_core/world/scene_world.hpp"

// Worlds of scene files.

using namespace touchstone;
using c_interface::guarded;
using c_interface::number_of;
using c_interface::registry;

namespace {

/// A scene and the world that it is flown in.
class FlownScene final : public c_interface::WorldHolder {
 public:
  FlownScene(Scene scene, const char* backend)
      : scene_(std::move(scene)),
        flown_(scene_, registry().make_narrowphase(backend), registry().make_broadphase("native")) {}
  ContactWorld& world() override { return flown_.world(); }

  const Scene& scene() const { return scene_; }
  SceneWorld& flown() { return flown_; }

 private:
  Scene scene_;
  SceneWorld flown_;
};

/// @throws InputError: a world that is no scene's.
FlownScene& scene_of(const touchstone_world& world) {
  auto* const scene = dynamic_cast<FlownScene*>(world.holder.get());
  if (scene == nullptr) reject("world", "is of no scene file");
  return *scene;
}

}  // namespace

touchstone_code touchstone_load_scene(const char* backend, const char* path,
                                      const touchstone_parameter* parameters, size_t count,
                                      touchstone_world** out) {
  return guarded({{backend, "backend"}, {path, "path"}, {static_cast<const void*>(out), "out"}}, [&] {
    Scene scene = load_scene(path, c_interface::scene_parameters(parameters, count));
    auto made = std::make_unique<touchstone_world>(std::make_unique<FlownScene>(std::move(scene), backend));
    *out = made.release();
  });
}

touchstone_code touchstone_get_scene_facts(const touchstone_world* world, touchstone_scene_facts* out) {
  return guarded({{world, "world"}, {out, "out"}}, [&] {
    const Scene& scene = scene_of(*world).scene();
    *out = {scene.frame_rate, scene.duration, scene.contact_gap, scene.frame_count()};
  });
}

touchstone_code touchstone_get_scene_object_count(const touchstone_world* world, size_t* out) {
  return guarded({{world, "world"}, {out, "out"}}, [&] { *out = scene_of(*world).scene().objects.size(); });
}

touchstone_code touchstone_get_scene_object(const touchstone_world* world, size_t index,
                                            touchstone_object* out) {
  return guarded({{world, "world"}, {out, "out"}}, [&] {
    FlownScene& scene = scene_of(*world);
    const std::size_t count = scene.scene().objects.size();
    if (index >= count)
      reject("index", std::to_string(index) + " is none of the scene's " + std::to_string(count));
    *out = number_of(scene.flown().object(index));
  });
}

touchstone_code touchstone_step_scene(touchstone_world* world, touchstone_report* out) {
  return guarded({{world, "world"}, {out, "out"}},
                 [&] { *out = c_interface::kept_report(*world, scene_of(*world).flown().step()); });
}
