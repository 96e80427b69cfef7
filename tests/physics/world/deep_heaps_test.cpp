// Heaps of bodies that lie deep in each other: they part without gaining energy but what lifts them.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <list>
#include <random>
#include <string>
#include <vector>

#include "touchstone/contact_core/geometry/matrix3.hpp"
#include "touchstone/physics/world/groups/fewest_points.hpp"
#include "touchstone/tests/physics/cubes.hpp"

namespace touchstone::physics {
namespace {

constexpr double kGravity = 9.81, kDeep = 5e-3;  // [m/s2]; from this depth on [m] bodies are parted softly

/// Boxes in a lattice narrower than they are, each turned anyhow.
struct Heap : Cubes {
  std::list<HexahedronTree> trees;
  std::vector<std::uint32_t> bodies;
  std::mt19937 random;

  explicit Heap(std::uint32_t seed) : random(seed) {}
  double draw() { return 2.0 * static_cast<double>(random()) / 4294967296.0 - 1.0; }
  Vector3 draw_vector(double most) { return {most * draw(), most * draw(), most * draw()}; }

  void add(const Vector3& p_W, const Vector3& size, double turn, double speed) {
    Pose X_WB = at(p_W);
    const Vector3 turn_W = draw_vector(turn), v_W = draw_vector(speed), w_W = draw_vector(5.0 * speed);
    const double angle = norm(turn_W);
    if (angle > 0.0) X_WB.R = rotation_about(turn_W / angle, angle);
    const RigidBody box(box_inertia(1.0, size), "box");
    trees.push_back(HexahedronTree({{"box", Hexahedron::from_size(size), {}}}, "box"));
    bodies.push_back(world.add_body(box, box.state(X_WB, v_W, w_W)));
    contacts->add(Mover::of_body(bodies.back()), trees.back(), {0.5, 0.0});
  }
  void add_lattice(int count, double pitch, const Vector3& size, double turn, double speed = 0.0) {
    const int across = static_cast<int>(std::ceil(std::cbrt(count)));
    for (int i = 0; i < count; ++i) {
      const int x = i % across, y = i / across % across, z = i / (across * across);
      add({pitch * x, pitch * y, 0.15 + pitch * z}, size, turn, speed);
    }
    contacts->build();
  }
};

/// The energy that a step gave, and the share of it that parting lifted: bodies then move otherwise than by
/// the mean of their velocities before and after.
struct Account {
  double given = 0.0, lifted = 0.0, depth = 0.0;  // [J], [J], [m]
};

Account take_step(Heap& heap, double h) {
  Account account;
  const auto heights = [&] {
    double sum = 0.0;
    for (const std::uint32_t body : heap.bodies) sum += heap.world.pose(body).p.z();
    return sum;
  };
  const auto rises = [&] {
    double sum = 0.0;
    for (const std::uint32_t body : heap.bodies) sum += heap.world.velocity(body).z();
    return sum;
  };
  const double energy = heap.world.energy(), height = heights(), rise = rises();
  const std::span<const Contact> contacts = heap.contacts->find(heap.world, h);
  for (const Contact& contact : contacts)
    account.depth = std::max(account.depth, -dot(contact.n_AB_W, contact.p_B_W - contact.p_A_W));
  EXPECT_EQ(heap.world.step(h, contacts).failure, StepFailure::none);
  account.lifted = kGravity * ((heights() - height) - 0.5 * h * (rise + rises()));
  account.given = heap.world.energy() - energy - account.lifted;
  return account;
}

TEST(DeepHeaps, GainNoEnergyButWhatPartingLifts) {
  struct Case {
    int count;
    double pitch, turn, h;
  };
  std::uint32_t seed = 3101;
  for (const Case& c :
       {Case{25, 0.12, 1.0, 1e-3}, Case{25, 0.12, 1.0, 1.0 / 240.0}, Case{12, 2e-3, 0.02, 1e-3},
        Case{9, 0.05, 0.3, 1e-3}, Case{18, 0.15, 1.0, 2e-3}, Case{30, 0.1, 0.5, 1.0 / 240.0}}) {
    Heap heap(seed++);
    heap.add_ground();
    heap.add_lattice(c.count, c.pitch, {kCubeSide, kCubeSide, kCubeSide}, c.turn);
    const double scale = heap.world.energy();
    for (int i = 0; i < static_cast<int>(0.6 / c.h); ++i) {
      const Account account = take_step(heap, c.h);
      if (account.depth <= kDeep) break;
      ASSERT_LT(account.given, 1e-12 * scale) << "heap " << seed - 1 << ", step " << i;
    }
  }
}

TEST(DeepHeaps, ComeApartAndRest) {
  for (std::uint32_t seed = 3201; seed < 3204; ++seed) {
    Heap heap(seed);
    heap.add_ground();
    heap.add_lattice(15, 0.12, {kCubeSide, kCubeSide, kCubeSide}, 1.0);
    double depth = 0.0;
    for (int i = 0; i < 1500; ++i) depth = take_step(heap, 1.0 / 240.0).depth;
    EXPECT_LT(depth, 1.1e-4) << seed;
    for (const std::uint32_t body : heap.bodies) EXPECT_LT(norm(heap.world.velocity(body)), 1e-4) << seed;
  }
}

TEST(DeepHeaps, FreeOnesKeepTheirMomenta) {
  // Slabs that turn and fly as they part: parting moves them off their paths.
  for (std::uint32_t seed = 3301; seed < 3305; ++seed) {
    Heap heap(seed);
    DynamicsWorld::Settings settings;  // without gravity
    heap.world = DynamicsWorld(settings);
    heap.add_lattice(12, 0.1, {0.3, 0.2, 0.1}, 1.0, 0.3);
    const double energy = heap.world.energy();
    const Vector3 momentum = heap.world.linear_momentum(), turning = heap.world.angular_momentum();
    for (int i = 0; i < 600; ++i) {
      ASSERT_EQ(heap.step(1e-3).failure, StepFailure::none);
      ASSERT_LT(heap.world.energy(), energy) << seed << ", step " << i;
    }
    EXPECT_LT(norm(heap.world.linear_momentum() - momentum), 1e-12) << seed;
    EXPECT_LT(norm(heap.world.angular_momentum() - turning), 1e-12) << seed;
  }
}

TEST(FewestPoints, LeaveTheDeepestAndTheCornersOfAManifold) {
  using namespace stepping;
  // A rectangle, its edges' middles and its centre, which is deepest; then three points of another pair.
  std::vector<Contact> contacts;
  const auto add = [&](std::uint32_t b, double x, double y, double depth) {
    Contact& contact = contacts.emplace_back();
    contact.a = Mover::ground(), contact.b = Mover::of_body(b);
    contact.n_AB_W = {0, 0, 1};
    contact.p_A_W = {x, y, 0};
    contact.p_B_W = {x, y, -depth};
  };
  for (const double x : {-0.2, 0.0, 0.2})
    for (const double y : {-0.1, 0.0, 0.1}) add(0, x, y, x == 0.0 && y == 0.0 ? 0.02 : 0.01);
  for (const double x : {0.0, 0.1, 0.2}) add(1, x, 0, 0.01);
  GroupState group;
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    GroupPoint& point = group.points.emplace_back();
    point.contact = &contacts[i];
    point.index = static_cast<std::uint32_t>(i);
  }
  keep_fewest(group);
  std::vector<std::uint32_t> kept, spare;
  for (const GroupPoint& point : group.points) kept.push_back(point.index);
  for (const GroupPoint& point : group.spare) spare.push_back(point.index);
  EXPECT_EQ(kept, (std::vector<std::uint32_t>{0, 2, 4, 6, 9, 10, 11}));
  std::sort(spare.begin(), spare.end());
  EXPECT_EQ(spare, (std::vector<std::uint32_t>{1, 3, 5, 7, 8}));
}

}  // namespace
}  // namespace touchstone::physics
