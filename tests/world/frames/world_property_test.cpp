#include <gtest/gtest.h>

#include "touchstone/tests/support/random.hpp"
#include "touchstone/tests/world/world_fixture.hpp"
#ifdef TOUCHSTONE_HAS_EXACT
#include "touchstone/adapters/exact/exact.hpp"
#endif

namespace touchstone {
namespace {

#ifdef TOUCHSTONE_HAS_EXACT

// A few boxes in a small room, commanded to go anywhere: whatever is executed, `exact` finds no overlap at
// the ends nor at sampled poses on the way.
TEST(ContactWorld, NothingExecutedOverlaps) {
  BackendRegistry registry;
  register_exact(registry);
  Random random(5);
  int blocked = 0;
  for (int run = 0; run < 40; ++run) {
    const auto world = make_world();
    world->set_default_rule(rule(run % 2 ? ContactPolicy::advance : ContactPolicy::hold));
    // Five boxes or plates in a row.
    std::vector<Hexahedron> solids;
    std::vector<ObjectHandle> objects;
    for (int i = 0; i < 5; ++i) {
      const double thin = run % 3 == 0 ? 0.02 : 1.0;
      const Vector3 size(random.uniform(0.5, 1.5), random.uniform(0.5, 1.5) * thin, random.uniform(0.5, 1.5));
      objects.push_back(world->add({box_tree("box " + std::to_string(i), size), at(2.7 * i, 0, 0)}));
      solids.push_back(Hexahedron::from_size(size));
    }
    // The judge of their poses.
    const auto exact = registry.make_narrowphase("exact");
    exact->build(solids);
    const auto workspace = exact->make_workspace();
    const auto overlapping = [&](const std::vector<Pose>& poses) {
      for (SolidIndex a = 0; a < 5; ++a) {
        for (SolidIndex b = a + 1; b < 5; ++b) {
          const SolidPair pair{a, b};
          PairStatus status{};
          exact->evaluate({{&pair, 1}, poses, Query{}}, {{&status, 1}, {}, {}}, *workspace);
          if (status != PairStatus::separated) return true;
        }
      }
      return false;
    };
    // They are drawn to the middle, with random turns; no executed pose overlaps.
    for (int frame = 0; frame < 25; ++frame) {
      std::vector<MotionCommand> commands;
      std::vector<Pose> before(5), after(5);
      for (int i = 0; i < 5; ++i) {
        before[i] = world->actual_pose(objects[i]);
        const Vector3 home(5.4, 0, 0);
        commands.push_back(
            world->move_by(objects[i], 0.2 * (home - before[i].p) + random.vector(0.5), random.vector(2.0)));
      }
      blocked += static_cast<int>(world->frame(commands).blocked_movers);
      for (int i = 0; i < 5; ++i) after[i] = world->actual_pose(objects[i]);
      ASSERT_FALSE(overlapping(after)) << "run " << run << " frame " << frame;
      for (std::size_t part = 0; part < world->executed_parts(); ++part)
        for (int k = 1; k < 8; ++k) {
          std::vector<Pose> poses(5);
          for (int i = 0; i < 5; ++i) poses[i] = world->executed_pose(objects[i], part, k / 8.0);
          ASSERT_FALSE(overlapping(poses))
              << "run " << run << " frame " << frame << " part " << part << " sample " << k;
        }
    }
  }
  EXPECT_GT(blocked, 500);
}

#endif

}  // namespace
}  // namespace touchstone
