#include "touchstone/physics/world/groups/warm_start.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "touchstone/physics/bodies/inertia.hpp"

using namespace touchstone;
using namespace touchstone::physics;
using namespace touchstone::physics::stepping;

namespace {

struct Carrying {
  Movers movers;
  WarmStart warm;

  Carrying() {
    const RigidBody cube(box_inertia(1.0, {1, 1, 1}), "cube");
    movers.bodies.push_back({cube, cube.state({}, Vector3::Zero(), Vector3::Zero())});
  }
  static Contact contact(std::uint64_t key, double x) {
    return {Mover::of_body(0), Mover::ground(), {0, 0, 1}, {x, 0, 0}, {x, 0, 0}, 0.5, 0.0, key};
  }
  /// A step with a force of 1, 2, ... N at each contact.
  void step(const std::vector<Contact>& contacts) {
    warm.carry(contacts, movers);
    for (std::size_t i = 0; i < contacts.size(); ++i)
      warm.keep(i, contacts[i], contacts[i].p_A_W, {.force_W = {0, 0, static_cast<double>(i + 1)}});
    warm.accept();
  }
  std::vector<double> forces(const std::vector<Contact>& contacts) {
    warm.carry(contacts, movers);
    std::vector<double> out;
    for (std::size_t i = 0; i < contacts.size(); ++i) out.push_back(warm.of(i).force_W.z());
    warm.undo();
    return out;
  }
};

TEST(WarmStart, WhatPartedAContactIsCarriedWithItsForce) {
  Carrying world;
  const std::vector<Contact> before{Carrying::contact(7, 0), Carrying::contact(8, 1)};
  world.warm.carry(before, world.movers);
  for (std::size_t i = 0; i < 2; ++i)
    world.warm.keep(i, before[i], before[i].p_A_W, {{0, 0, 1}, {0, 0, 3.0 + static_cast<double>(i)}});
  world.warm.accept();
  // One contact keeps its name, the other's goes to the nearest of the pair.
  const std::vector<Contact> after{Carrying::contact(8, 1), Carrying::contact(9, 0.1)};
  world.warm.carry(after, world.movers);
  EXPECT_EQ(world.warm.of(0).parting_W, Vector3(0, 0, 4));
  EXPECT_EQ(world.warm.of(1).parting_W, Vector3(0, 0, 3));
}

TEST(WarmStart, AForceFollowsItsKey) {
  Carrying world;
  world.step({Carrying::contact(7, 0), Carrying::contact(8, 1)});
  EXPECT_EQ(world.forces({Carrying::contact(8, 1), Carrying::contact(7, 0)}), (std::vector<double>{2, 1}));
  // Asked again, the step was not taken: the same.
  EXPECT_EQ(world.forces({Carrying::contact(8, 1), Carrying::contact(7, 0)}), (std::vector<double>{2, 1}));
}

TEST(WarmStart, ForcesWhoseNamesAreGoneGoToTheNearestPoint) {
  Carrying world;
  world.step({Carrying::contact(7, 0), Carrying::contact(8, 1), Carrying::contact(9, 2)});
  // 9 is now called 11 and lies near where it was; 8 is gone, and nearer to 7.
  EXPECT_EQ(world.forces({Carrying::contact(7, 0.4), Carrying::contact(11, 2.2)}),
            (std::vector<double>{3, 3}));
  // Contacts without a name start from nothing.
  EXPECT_EQ(world.forces({Carrying::contact(0, 0)}), (std::vector<double>{0}));
}

}  // namespace
