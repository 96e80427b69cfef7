// A program whose own tree has files by the names of ours, found first, and uses both.
#include <array>
#include <cstdio>
#include <exception>

#include "adapters/exact/exact.hpp"
#include "contact_core/geometry/pose.hpp"
#include "examples/measures/common/random.hpp"
#include "physics/bodies/rigid_body.hpp"
#include "tests/backend_suite/suite.hpp"
#include "touchstone/contact_core/geometry/pose.hpp"
#include "touchstone/contact_core/registry.hpp"
#include "touchstone/physics/bodies/rigid_body.hpp"
#include "touchstone/physics/world/dynamics_world.hpp"

#ifndef TOUCHSTONE_STRANGERS_POSE
#error "ours was found for theirs"
#endif

int main() try {
  touchstone::BackendRegistry registry;
  touchstone::register_core(registry);
  const auto narrowphase = registry.make_narrowphase("native");
  const std::array solids = {touchstone::Hexahedron::from_size({2, 2, 2}),
                             touchstone::Hexahedron::from_size({1, 1, 1})};
  narrowphase->build(solids);
  std::array<touchstone::Pose, 2> poses;
  poses[1].p = {1.25, 0, 0};
  const std::array pairs = {touchstone::SolidPair{0, 1}};
  std::array<touchstone::PairStatus, 1> status;
  std::array<touchstone::PairGeometry, 1> geometry;
  narrowphase->evaluate({.pairs = pairs, .poses = poses, .query = {}},
                        {.status = status, .geometry = geometry}, *narrowphase->make_workspace());
  touchstone::physics::DynamicsWorld world(touchstone::physics::DynamicsWorld::Settings{});
  world.step(0.01, {});

  const bool theirs = Pose::sitting != Pose::standing && RigidBody().wheels == 4 && register_exact(1) == 2 &&
                      suite::size() == 3 && random_number() == 4;
  std::printf("%s, their own files: %s\n", to_string(status[0]).data(), theirs ? "yes" : "no");
  return theirs && status[0] == touchstone::PairStatus::overlapping ? 0 : 1;
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
