#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <tuple>

#include "touchstone/tests/mechanism/random_chain.hpp"
#include "touchstone/tests/support/counting_allocator.hpp"
#include "touchstone/tests/world/arms/arm_fixture.hpp"
#include "touchstone/tests/world/near_spheres.hpp"
#ifdef TOUCHSTONE_HAS_EXACT
#include "touchstone/adapters/exact/exact.hpp"
#endif

// Random motions of arms among boxes. TOUCHSTONE_ARM_MOTIONS sets how many (the full run: 100000).

namespace touchstone {
namespace {

constexpr int kUsualMotions = 400;

int motions_wanted(int usual) {
  const char* given = std::getenv("TOUCHSTONE_ARM_MOTIONS");
  return given == nullptr ? usual : std::atoi(given);
}

/// A box, or a ball, a rod or a rounded box about as large.
Hexahedron draw_obstacle(test::Draw& draw, bool rounded, int number) {
  const Vector3 size(draw.real(0.1, 2), draw.real(0.1, 2), draw.real(0.1, 2));
  if (!rounded) return Hexahedron::from_size(size);
  if (number % 3 == 0) return Hexahedron::sphere(0.5 * size.x());
  return number % 3 == 1 ? Hexahedron::capsule(0.3 * size.x(), size.y())
                         : Hexahedron::rounded_box(0.7 * size, 0.1 * size.x());
}

/// An arm of three bars, or the SSRMS-type arm, among boxes or rounded solids that it does not touch at
/// first; the one latched to it as well.
struct ArmScene {
  std::unique_ptr<ContactWorld> world = make_world();
  std::shared_ptr<const Mechanism> mechanism;
  MechanismHandle arm;
  ObjectHandle carrier, carried;
  std::vector<ObjectHandle> objects;
  std::vector<Hexahedron> solids;
  std::vector<Pose> X_OS;
  std::vector<std::size_t> object_of;

  ArmScene(test::Draw& draw, bool large, bool rounded) {
    mechanism = large ? make_ssrms_arm() : make_arm("arm", 3, draw.chance(0.5) ? "base" : "tip");
    arm = world->add_mechanism({mechanism, draw.pose(2)});
    for (const Mechanism::Link& link : mechanism->links())
      if (link.tree) take(world->link(arm, link.name), *link.tree);
    const std::size_t links = objects.size();
    const double reach = large ? 9 : 3.5;
    for (int i = 0; i < 30; ++i) {
      const auto tree = std::make_shared<HexahedronTree>(
          std::vector<PlacedHexahedron>{{"box", draw_obstacle(draw, rounded, i), Pose{}}},
          "box " + std::to_string(i));
      Pose X = draw.pose(reach);
      X.p += world->link_poses(arm)[mechanism->base()].p;
      const ObjectHandle box = world->add({tree, X, i > 0});
      take(box, *tree);
      if (overlapping(false)) {  // in the way from the start
        world->remove(box);
        drop();
      } else if (i == 0) {
        carrier = objects[draw.integer(1, static_cast<int>(links) - 1)], carried = box;
        world->latch(carrier, carried);
      }
    }
  }

  void take(ObjectHandle object, const HexahedronTree& tree) {
    for (const PlacedHexahedron& placed : tree.solids()) {
      solids.push_back(placed.solid), X_OS.push_back(placed.X_OS), object_of.push_back(objects.size());
    }
    objects.push_back(object);
  }
  void drop() {
    objects.pop_back();
    while (!object_of.empty() && object_of.back() == objects.size())
      object_of.pop_back(), solids.pop_back(), X_OS.pop_back();
    built_ = 0;  // the next box may be another one of the same number
  }

  /// Solids that are never checked: of one object, or exempt.
  bool is_free(std::size_t a, std::size_t b) const {
    if (object_of[a] == object_of[b]) return true;
    const std::size_t own = mechanism->solids().size();
    return a < own && b < own &&
           mechanism->is_exempt(static_cast<std::uint32_t>(a), static_cast<std::uint32_t>(b));
  }

  bool overlapping(bool executed, std::size_t part = 0, double s = 1.0) {
#ifdef TOUCHSTONE_HAS_EXACT
    BackendRegistry registry;
    register_exact(registry);
    // Solids added since the last call are built, too.
    if (built_ != solids.size()) {
      exact_ = registry.make_narrowphase("exact");
      exact_->build(solids);
      workspace_ = exact_->make_workspace();
      built_ = solids.size();
    }
    // Solids where they are, or are on the way.
    std::vector<Pose> poses;
    for (std::size_t i = 0; i < solids.size(); ++i)
      poses.push_back(compose(executed ? world->executed_pose(objects[object_of[i]], part, s)
                                       : world->actual_pose(objects[object_of[i]]),
                              X_OS[i]));
    // Any checked pair in contact.
    for (SolidIndex a = 0; a < solids.size(); ++a)
      for (SolidIndex b = a + 1; b < solids.size(); ++b) {
        if (!may_be_within(solids[a], poses[a], solids[b], poses[b])) continue;
        if (is_free(a, b) || (is_static(a) && is_static(b)) || carried_by(a, b)) continue;
        const SolidPair pair{a, b};
        PairStatus status{};
        exact_->evaluate({{&pair, 1}, poses, Query{}}, {{&status, 1}, {}, {}}, *workspace_);
        if (status != PairStatus::separated) return true;
      }
#else
    static_cast<void>(executed), static_cast<void>(part), static_cast<void>(s);
#endif
    return false;
  }

  bool is_static(std::size_t solid) const {
    if (solid >= mechanism->solids().size()) return !(objects[object_of[solid]] == carried);
    return mechanism->chain(mechanism->link_of(static_cast<std::uint32_t>(solid))).empty();
  }
  /// An object latched to a link is not checked against it.
  bool carried_by(std::size_t a, std::size_t b) const {
    return objects[object_of[a]] == carrier && objects[object_of[b]] == carried;
  }

 private:
#ifdef TOUCHSTONE_HAS_EXACT
  std::unique_ptr<Narrowphase> exact_;
  std::unique_ptr<Narrowphase::Workspace> workspace_;
#endif
  std::size_t built_ = 0;
};

class ArmMotions : public ::testing::TestWithParam<std::tuple<ContactPolicy, bool>> {};

// No actual pose and no sampled pose of what is executed overlaps, as `exact` judges.
TEST_P(ArmMotions, NothingExecutedOverlaps) {
#ifndef TOUCHSTONE_HAS_EXACT
  GTEST_SKIP() << "needs the exact backend";
#endif
  const int wanted = motions_wanted(kUsualMotions);
  const auto [policy, rounded] = GetParam();
  test::Draw draw(31 + static_cast<std::uint64_t>(policy));
  int motions = 0, blocked = 0, slid = 0, latched = 0;
  std::uint32_t limits = 0;
  while (motions < wanted) {
    const bool large = draw.chance(0.15);
    ArmScene scene(draw, large, rounded);
    scene.world->set_default_rule(rule(policy));
    if (scene.overlapping(false)) continue;  // in the reference pose
    const double step = draw.chance(0.5) ? 0.05 : 0.6;
    std::vector<double> way(scene.mechanism->value_count());
    for (int frame = 0; frame < 20 && motions < wanted; ++frame, ++motions) {
      std::vector<double> goal = joints_of(*scene.world, scene.arm);
      for (std::size_t k = 0; k < goal.size(); ++k) {
        if (frame % 8 == 0) way[k] = draw.real(-step, step);
        goal[k] += way[k];
      }
      const FrameReport report = move_joints(*scene.world, scene.arm, goal);
      blocked += static_cast<int>(report.blocked_movers);
      slid += report.slide_steps > 0;
      limits += report.iteration_limits;
      ASSERT_FALSE(scene.overlapping(false)) << "motion " << motions;
      for (std::size_t part = 0; part < scene.world->executed_parts(); ++part)
        for (int k = 1; k <= 4; ++k)
          ASSERT_FALSE(scene.overlapping(true, part, k / 4.0 - 0.1))
              << "motion " << motions << " part " << part;
    }
    ++latched;
  }
  std::printf("%d motions in %d scenes: %d blocked, %d slid, %u iteration limits\n", motions, latched,
              blocked, slid, limits);
  EXPECT_GT(blocked, wanted / 20);
  // A link's path may bend away from every plane that is fixed in the world: it then stops early, which is
  // safe, and printed. Without slides the usual slice has none (the full run 319 of 66 800).
  if (policy != ContactPolicy::slide && wanted <= kUsualMotions) {
    EXPECT_EQ(limits, 0u);
  }
}

INSTANTIATE_TEST_SUITE_P(Policies, ArmMotions,
                         ::testing::Combine(::testing::Values(ContactPolicy::hold, ContactPolicy::advance,
                                                              ContactPolicy::slide),
                                            ::testing::Bool()),
                         [](const auto& test) {
                           return std::string(to_string(std::get<0>(test.param))) +
                                  (std::get<1>(test.param) ? "_rounded" : "");
                         });

// The arm over a floor of tiles: free, pressed, sliding, carrying.
TEST(ArmAllocations, NoneOnceWarm) {
  const auto world = make_world();
  world->set_default_rule(rule(ContactPolicy::slide, 0.01));
  const MechanismHandle arm = world->add_mechanism({make_arm("arm", 3), {}, {0.05, 0, -0.1}});
  for (int i = 0; i < 40; ++i)
    world->add({box_tree("tile " + std::to_string(i), {0.5, 1, 4}), at(-10 + 0.5 * i, 1.0, 0), true});
  const ObjectHandle box = world->add({box_tree("box", {0.2, 0.2, 0.2}), at(6.2, -0.4, 0)});
  world->latch(world->link(arm, "3"), box);
  std::vector<double> goal(3);
  std::size_t before = 0, slid = 0;
  for (int frame = 0; frame < 300; ++frame) {
    if (frame == 20) before = allocation_count();
    goal = {0.05 + 0.1 * std::sin(0.05 * frame), 0.2 * std::sin(0.02 * frame), -0.1};
    const JointCommand command{arm, goal};
    slid += world->frame({}, {&command, 1}).slide_steps > 0;
  }
  EXPECT_EQ(allocation_count(), before);
  EXPECT_GT(slid, 50u);
}

}  // namespace
}  // namespace touchstone
