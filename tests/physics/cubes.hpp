#pragma once

#include <memory>

#include "touchstone/contact_core/registry.hpp"
#include "touchstone/physics/contacts/narrowphase_contacts.hpp"
#include "touchstone/tests/support/at.hpp"

// Cubes in a dynamics world with its contacts.

namespace touchstone::physics {

inline constexpr double kCubeSide = 0.2;
/// Cubes of 1 kg, and boxes that are driven, under gravity.
struct Cubes {
  BackendRegistry registry;
  RigidBody cube{box_inertia(1.0, {kCubeSide, kCubeSide, kCubeSide}), "cube"};
  HexahedronTree cube_tree{{{"box", Hexahedron::from_size({kCubeSide, kCubeSide, kCubeSide}), {}}}, "cube"};
  HexahedronTree ground_tree{{{"box", Hexahedron::from_size({20, 20, 1}), {}}}, "ground"};
  std::unique_ptr<NarrowphaseContacts> contacts;
  DynamicsWorld world{[] {
    DynamicsWorld::Settings settings;
    settings.gravity_W = {0, 0, -9.81};
    return settings;
  }()};

  Cubes() {
    register_core(registry);
    contacts = std::make_unique<NarrowphaseContacts>(registry.make_broadphase("native"),
                                                     registry.make_narrowphase("native"), 1e-3);
  }
  void add_ground() {
    contacts->add(Mover::of_body(world.add_kinematic(at({0, 0, -0.5}), Vector3::Zero(), Vector3::Zero())),
                  ground_tree, {0.5, 0.0});
  }
  std::uint32_t add_driven(const Vector3& p, const Vector3& v) {
    const auto body = world.add_kinematic(at(p), v, Vector3::Zero());
    contacts->add(Mover::of_body(body), cube_tree, {0.5, 0.0});
    return body;
  }
  std::uint32_t add_cube(const Vector3& p) {
    const auto body = world.add_body(cube, cube.state(at(p), Vector3::Zero(), Vector3::Zero()));
    contacts->add(Mover::of_body(body), cube_tree, {0.5, 0.0});
    return body;
  }
  StepReport step(double h) { return world.step(h, contacts->find(world, h)); }
};

}  // namespace touchstone::physics
