#pragma once

#include <string>

#include "touchstone/physics/scene/dynamic_scene.hpp"

// Scenes of boxes for every engine, made by hand.

namespace touchstone::engine_tests {

inline constexpr double kGravity = 9.81;

/// @param duration [s] at `step` [s]; gravity along -z
inline physics::DynamicScene empty_scene(double duration, double step = 1e-3) {
  physics::DynamicScene scene;
  scene.scene.name = "made by hand";
  scene.scene.frame_rate = 50;
  scene.scene.contact_gap = 1e-9;
  scene.scene.duration = duration;
  scene.step = step;
  scene.gravity_W = {0, 0, -kGravity};
  return scene;
}

/// A box of `size` whose centre is at `p_W`. @return its index
inline std::size_t add_box(physics::DynamicScene& scene, const std::string& name, const Vector3& size,
                           const Vector3& p_W, double mass = 0.0, double friction = 0.5) {
  Pose X;
  X.p = p_W;
  scene.scene.objects.push_back(
      {HexahedronTree({{"box", Hexahedron::from_size(size), {}}}, name), X, {}, {}});
  physics::SceneBody body;
  body.surface.friction = friction;
  if (mass > 0.0) {
    body.kind = physics::BodyKind::dynamic;
    body.inertia = physics::box_inertia(mass, size);
  }
  scene.bodies.push_back(body);
  return scene.bodies.size() - 1;
}

/// Its upper face is z = 0.
inline std::size_t add_ground(physics::DynamicScene& scene, double friction = 0.5) {
  return add_box(scene, "ground", {20, 20, 1}, {0, 0, -0.5}, 0.0, friction);
}

}  // namespace touchstone::engine_tests
