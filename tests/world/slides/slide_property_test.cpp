#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iostream>

#include "touchstone/contact_core/motion/mass_metric.hpp"
#include "touchstone/contact_core/native/native.hpp"
#include "touchstone/tests/support/random_solid.hpp"
#include "touchstone/tests/world/near_spheres.hpp"
#include "touchstone/tests/world/world_fixture.hpp"
#ifdef TOUCHSTONE_HAS_EXACT
#include "touchstone/adapters/exact/exact.hpp"
#include "touchstone/contact_core/geometry/constants.hpp"
#endif

namespace touchstone {
namespace {

#ifdef TOUCHSTONE_HAS_EXACT

/// Five solids in a trough of three slabs, commanded to crowd together and turn.
struct Crowd {
  static constexpr int kMovers = 5, kSolids = 8;
  std::unique_ptr<ContactWorld> world = make_world();
  std::vector<Hexahedron> solids;
  std::vector<ObjectHandle> objects;
  std::vector<MassMetric> metrics;
  std::unique_ptr<Narrowphase> exact;
  std::unique_ptr<Narrowphase::Workspace> workspace;

  /// @param reversed registers the last first; handles and solids are counted alike.
  Crowd(Random& random, double thin, bool reversed = false) : objects(kSolids) {
    world->set_default_rule(rule(ContactPolicy::slide));
    std::vector<Pose> X_WO;
    for (int i = 0; i < kMovers; ++i) {
      solids.push_back(random_solid(random, thin));
      X_WO.push_back(at(1.45 * (i - 2), random.uniform(-0.3, 0.3), 0.05));
    }
    solids.push_back(Hexahedron::from_size({30, 30, 1})), X_WO.push_back(at(0, 0, -1.2));
    solids.push_back(Hexahedron::from_size({30, 1, 6})), X_WO.push_back(at(0, 1.6, 0));
    solids.push_back(Hexahedron::from_size({30, 1, 6})), X_WO.push_back(at(0, -1.6, 0));
    for (int k = 0; k < kSolids; ++k) {
      const int i = reversed ? kSolids - 1 - k : k;
      const auto tree = std::make_shared<HexahedronTree>(
          std::vector<PlacedHexahedron>{{"solid", solids[i], Pose{}}}, "solid " + std::to_string(i));
      objects[i] = world->add({tree, X_WO[i], i >= kMovers});
    }
    for (const Hexahedron& solid : solids) metrics.push_back(mass_metric(mass_moments(solid)));
    BackendRegistry registry;
    register_exact(registry);
    exact = registry.make_narrowphase("exact");
    exact->build(solids);
    workspace = exact->make_workspace();
  }
  /// Asks `exact` about all pairs whose spheres meet; the least separation, or nothing where two overlap.
  double least_separation(const std::array<Pose, kSolids>& poses, QueryKind kind) {
    double least = 1.0;
    for (SolidIndex a = 0; a < kMovers; ++a) {
      for (SolidIndex b = a + 1; b < kSolids; ++b) {
        if (!may_be_within(solids[a], poses[a], solids[b], poses[b])) continue;
        const SolidPair pair{a, b};
        PairStatus status{};
        PairGeometry geometry{};
        Query query;
        query.kind = kind;
        exact->evaluate({{&pair, 1}, poses, query}, {{&status, 1}, {&geometry, 1}, {}}, *workspace);
        if (status != PairStatus::separated) return -1.0;
        if (kind != QueryKind::overlap) least = std::min(least, geometry.separation);
      }
    }
    return least;
  }
  double distance(int i, const Pose& X, const Pose& goal) const {
    const Twist left{transform(goal, metrics[i].centre) - transform(X, metrics[i].centre),
                     RigidPath::between(X, goal).at(0, 0).angular_velocity_W};
    return std::sqrt(inner_product(turned(X.R, metrics[i].J), left, left));
  }
};

struct Figures {
  std::vector<std::uint32_t> steps;
  std::uint32_t limits = 0;
  std::uint64_t queries = 0;
  double least = 1.0, growth = 0.0;
};

/// All movers are commanded to go to the middle and down, and any way else, by about `pace` [m, rad].
std::vector<MotionCommand> together(const Crowd& crowd, Random& random, double pace) {
  std::vector<MotionCommand> commands;
  for (int i = 0; i < Crowd::kMovers; ++i) {
    const Vector3 home = -crowd.world->actual_pose(crowd.objects[i]).p;
    const Vector3 by = 0.4 * pace * (home + Vector3(0, 0, -1)) + random.vector(pace);
    commands.push_back(crowd.world->move_by(crowd.objects[i], by, random.vector(1.5 * pace)));
  }
  return commands;
}

void move_and_judge(Crowd& crowd, const std::vector<MotionCommand>& commands, Figures& figures) {
  const FrameReport report = crowd.world->frame(commands);
  if (report.slide_steps > 0) figures.steps.push_back(report.slide_steps);
  figures.limits += report.iteration_limits;
  figures.queries = std::max(figures.queries, report.queries);
  std::array<double, Crowd::kMovers> before;
  before.fill(kInfinity);
  for (std::size_t part = 0; part < crowd.world->executed_parts(); ++part) {
    for (int k = 0; k <= 4; ++k) {
      std::array<Pose, Crowd::kSolids> poses;
      for (int i = 0; i < Crowd::kSolids; ++i)
        poses[i] = crowd.world->executed_pose(crowd.objects[i], part, k / 4.0);
      const bool last = k == 4;
      const double now = crowd.least_separation(poses, last ? QueryKind::distance : QueryKind::overlap);
      ASSERT_GT(now, 0.0) << "part " << part << " sample " << k;
      if (last) figures.least = std::min(figures.least, now);
      // The commanded path, part 0, moves the origin, which is not the centre of mass.
      for (int i = 0; i < Crowd::kMovers && part > 0; ++i) {
        const double distance = crowd.distance(i, poses[i], commands[i].path.to());
        figures.growth = std::max(figures.growth, distance - before[i]);
        before[i] = distance;
      }
    }
  }
}

class SlideProperty : public ::testing::TestWithParam<double> {};

TEST_P(SlideProperty, NothingExecutedOverlapsAndNoDistanceGrows) {
  Random random(11);
  const double pace = GetParam();
  Figures figures;
  for (int run = 0; run < 6; ++run) {
    Crowd crowd(random, run % 3 == 0 ? 0.05 : 1.0);
    for (int frame = 0; frame < 40; ++frame) {
      move_and_judge(crowd, together(crowd, random, pace), figures);
      ASSERT_FALSE(HasFatalFailure()) << "run " << run << " frame " << frame;
    }
  }
  // To the rounding that find_impact leaves: 32 u of the largest coordinate or size, here 45 m.
  EXPECT_GE(figures.least, 0.5 * kGap - 32 * 0x1p-53 * 45);
  EXPECT_LE(figures.growth, 1e-15);
  std::vector<std::uint32_t>& steps = figures.steps;
  std::sort(steps.begin(), steps.end());
  EXPECT_GT(steps.size(), 30u);
  // A stop for want of iterations is allowed, and rare: turns of up to a radian a frame among near-parallel
  // faces.
  EXPECT_LE(figures.limits, pace > 0.1 ? steps.size() / 50 : 0u);
  std::cout << "pace " << pace << ": " << steps.size() << " frames slid, sub-steps: median "
            << steps[steps.size() / 2] << ", 90 % " << steps[steps.size() * 9 / 10] << ", worst "
            << steps.back() << "; queries, worst " << figures.queries << "; " << figures.limits
            << " iteration limits; least separation " << figures.least / kGap << " g; growth "
            << figures.growth << " m\n";
}

TEST_P(SlideProperty, RegistrationOrderDoesNotShow) {
  for (int run = 0; run < 10; ++run) {
    Random first(run), second(run);
    Crowd ahead(first, run % 2 ? 0.05 : 1.0), back(second, run % 2 ? 0.05 : 1.0, true);
    for (int frame = 0; frame < 20; ++frame) {
      ahead.world->frame(together(ahead, first, GetParam()));
      std::vector<MotionCommand> commands = together(back, second, GetParam());
      std::reverse(commands.begin(), commands.end());
      back.world->frame(commands);
      for (int i = 0; i < Crowd::kMovers; ++i) {
        const Pose& X = ahead.world->actual_pose(ahead.objects[i]);
        const Pose& Y = back.world->actual_pose(back.objects[i]);
        ASSERT_TRUE(X.p == Y.p && X.R == Y.R)
            << "run " << run << " frame " << frame << " mover " << i << " by " << norm(X.p - Y.p);
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Paces, SlideProperty, ::testing::Values(0.01, 0.05, 0.5), [](const auto& test) {
  return std::to_string(static_cast<int>(100 * test.param)) + "cm";
});

#endif

}  // namespace
}  // namespace touchstone
