#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cstdint>
#include <thread>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/tests/ode/ode_scenes.hpp"

namespace touchstone::ode_test {
namespace {

constexpr std::array<SolidPair, 1> kPair = {{{0, 1}}};

struct PairKind {
  const char* name;
  bool a_is_box;
  bool b_is_box;
};

class OdeConventions : public testing::TestWithParam<PairKind> {
 protected:
  OdeConventions() : narrowphase_(registry().make_narrowphase("ode")) {
    const Hexahedron box = Hexahedron::from_size({1, 1, 1});
    const std::array<Hexahedron, 2> solids = {GetParam().a_is_box ? box : convex_cube(),
                                              GetParam().b_is_box ? box : convex_cube()};
    narrowphase_->build(solids);
  }

  Answers ask_at(const Vector3& p_B, QueryKind kind) const {
    const std::array<Pose, 2> poses = {Pose{}, Pose{Matrix3::Identity(), p_B}};
    return ask(*narrowphase_, kPair, poses, Query{.kind = kind});
  }

  std::unique_ptr<Narrowphase> narrowphase_;
};

// Unit cubes 0.9 apart along x: depth 0.1, the normal from A to B, A's surface at x = 0.5 and B's at 0.4.
TEST_P(OdeConventions, NormalPointsFromAToBAndWitnessesAreOnTheSurfaces) {
  for (const double sign : {1.0, -1.0}) {
    const Answers answers = ask_at({sign * 0.9, 0.2, 0.1}, QueryKind::manifold);
    ASSERT_EQ(answers.status[0], PairStatus::overlapping);
    const PairGeometry& geometry = answers.geometry[0];
    EXPECT_NEAR(geometry.separation, -0.1, 1e-12);
    EXPECT_NEAR(geometry.n_AB_W.x(), sign, 1e-12);
    EXPECT_NEAR(geometry.p_A_W.x(), sign * 0.5, 1e-12);
    EXPECT_NEAR(geometry.p_B_W.x(), sign * 0.4, 1e-12);
    EXPECT_EQ(geometry.p_B_W, geometry.p_A_W + geometry.separation * geometry.n_AB_W);
    EXPECT_EQ(geometry.point_count, GetParam().a_is_box && GetParam().b_is_box ? 4 : 1);
    for (int i = 0; i < geometry.point_count; ++i) {
      EXPECT_NEAR(answers.points[i].p_A_W.x(), sign * 0.5, 1e-12);
      EXPECT_NEAR(answers.points[i].p_B_W.x(), sign * 0.4, 1e-12);
    }
  }
}

TEST_P(OdeConventions, ApartIsSeparatedForOverlapAndUnsupportedForDistance) {
  for (const double x : {1.1, 1e6}) {
    EXPECT_EQ(ask_at({x, 0, 0}, QueryKind::overlap).status[0], PairStatus::separated);
    for (const QueryKind kind : {QueryKind::distance, QueryKind::manifold}) {
      const Answers answers = ask_at({x, 0, 0}, kind);
      EXPECT_EQ(answers.status[0], PairStatus::unsupported);
      EXPECT_TRUE(std::isnan(answers.geometry[0].separation));
      EXPECT_TRUE(std::isnan(answers.geometry[0].n_AB_W.x()));
      EXPECT_EQ(answers.geometry[0].point_count, 0);
    }
  }
}

TEST_P(OdeConventions, ApartIsSeparatedWhereNoPositiveSeparationIsAsked) {
  const std::array<Pose, 2> poses = {Pose{}, Pose{Matrix3::Identity(), {1.1, 0, 0}}};
  const Answers answers =
      ask(*narrowphase_, kPair, poses, Query{.kind = QueryKind::manifold, .max_separation = 0.0});
  EXPECT_EQ(answers.status[0], PairStatus::separated);
  EXPECT_EQ(answers.geometry[0].separation, kInfinity);
}

TEST_P(OdeConventions, NonFinitePoseIsFailedNotSeparated) {
  EXPECT_EQ(ask_at({std::nan(""), 0, 0}, QueryKind::overlap).status[0], PairStatus::failed);
}

TEST_P(OdeConventions, OverlapIsSeen) {
  EXPECT_EQ(ask_at({0.9, 0.2, 0.1}, QueryKind::overlap).status[0], PairStatus::overlapping);
}

INSTANTIATE_TEST_SUITE_P(Kinds, OdeConventions,
                         testing::Values(PairKind{"BoxBox", true, true}, PairKind{"BoxConvex", true, false},
                                         PairKind{"ConvexBox", false, true},
                                         PairKind{"ConvexConvex", false, false}),
                         [](const auto& kind) { return kind.param.name; });

// A cube of side 0.2 inside one of side 1, 0.1 off centre along x: the way out is 0.4 + 0.1 = 0.5 along +x.
TEST(OdeNarrowphase, ContainedBoxIsSeenWithItsDepth) {
  const auto narrowphase = registry().make_narrowphase("ode");
  const std::array<Hexahedron, 2> solids = {Hexahedron::from_size({1, 1, 1}),
                                            Hexahedron::from_size({0.2, 0.2, 0.2})};
  narrowphase->build(solids);
  const std::array<Pose, 2> poses = {Pose{}, Pose{Matrix3::Identity(), {0.1, 0, 0}}};
  const Answers answers = ask(*narrowphase, kPair, poses, Query{.kind = QueryKind::distance});
  ASSERT_EQ(answers.status[0], PairStatus::overlapping);
  EXPECT_NEAR(answers.geometry[0].separation, -0.5, 1e-12);
  EXPECT_NEAR(answers.geometry[0].n_AB_W.x(), 1.0, 1e-12);
}

bool same_bits(const Answers& u, const Answers& v) {
  if (u.status != v.status) return false;
  for (std::size_t i = 0; i < u.status.size(); ++i) {
    if (u.status[i] == PairStatus::overlapping &&
        (std::bit_cast<std::uint64_t>(u.geometry[i].separation) !=
             std::bit_cast<std::uint64_t>(v.geometry[i].separation) ||
         u.geometry[i].n_AB_W != v.geometry[i].n_AB_W || u.geometry[i].p_A_W != v.geometry[i].p_A_W ||
         u.geometry[i].point_count != v.geometry[i].point_count)) {
      return false;
    }
  }
  return true;
}

TEST(OdeNarrowphase, EightThreadsGiveTheBitsOfOne) {
  const PairScene scene = mixed_scene(300);
  const auto narrowphase = registry().make_narrowphase("ode");
  narrowphase->build(scene.solids);
  const Query query{.kind = QueryKind::manifold};
  const Answers expected = ask(*narrowphase, scene.pairs, scene.poses, query);
  std::array<Answers, 8> answers;
  std::vector<std::unique_ptr<Narrowphase::Workspace>> workspaces;  // made here, used elsewhere
  for (std::size_t t = 0; t < answers.size(); ++t) workspaces.push_back(narrowphase->make_workspace());
  std::vector<std::thread> threads;
  for (std::size_t t = 0; t < answers.size(); ++t) {
    threads.emplace_back(
        [&, t] { evaluate(*narrowphase, scene.pairs, scene.poses, query, *workspaces[t], answers[t]); });
  }
  for (std::thread& thread : threads) thread.join();
  for (const Answers& answer : answers) EXPECT_TRUE(same_bits(expected, answer));
}

TEST(OdeNarrowphase, TwoInstancesLiveSideBySide) {
  const std::array<Hexahedron, 2> solids = {Hexahedron::from_size({1, 1, 1}), convex_cube()};
  const std::array<Pose, 2> poses = {Pose{}, Pose{Matrix3::Identity(), {0.9, 0, 0}}};
  const auto first = registry().make_narrowphase("ode");
  first->build(solids);
  {
    const auto second = registry().make_narrowphase("ode");
    second->build(solids);
  }
  EXPECT_EQ(ask(*first, kPair, poses, {}).status[0], PairStatus::overlapping);
}

}  // namespace
}  // namespace touchstone::ode_test
