#include <gmock/gmock.h>

#include <array>
#include <cmath>
#include <cstring>
#include <memory>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "touchstone/adapters/c_interface/corners.hpp"
#include "touchstone/adapters/c_interface/layout.hpp"
#include "touchstone/adapters/c_interface/touchstone.h"
#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/narrowphase/answer_check.hpp"
#include "touchstone/contact_core/narrowphase/no_geometry.hpp"
#include "touchstone/contact_core/native/native.hpp"
#include "touchstone/examples/measures/pairs/pair_families.hpp"
#include "touchstone/tests/support/ask.hpp"
#include "touchstone/tests/support/random_poses.hpp"

namespace touchstone {
namespace {

using testing::HasSubstr;

struct Destroy {
  void operator()(touchstone_narrowphase* one) const { touchstone_destroy(one); }
  void operator()(touchstone_workspace* one) const { touchstone_destroy_workspace(one); }
};

/// Built over `solids`, with a workspace.
struct Native {
  std::unique_ptr<touchstone_narrowphase, Destroy> narrowphase;
  std::unique_ptr<touchstone_workspace, Destroy> workspace;

  explicit Native(std::span<const Hexahedron> solids) {
    touchstone_narrowphase* made = nullptr;
    EXPECT_EQ(touchstone_create("native", &made), TOUCHSTONE_OK);
    narrowphase.reset(made);
    const std::vector<double> corners = c_interface::corners_of(solids);
    EXPECT_EQ(touchstone_build(made, corners.data(), solids.size()), TOUCHSTONE_OK) << touchstone_error();
    touchstone_workspace* scratch = nullptr;
    EXPECT_EQ(touchstone_create_workspace(made, &scratch), TOUCHSTONE_OK);
    workspace.reset(scratch);
  }
  touchstone_code evaluate(const touchstone_input& input, const touchstone_output& output) const {
    return touchstone_evaluate(narrowphase.get(), workspace.get(), &input, &output);
  }
};

Answers ask_c(const Native& native, std::span<const SolidPair> pairs, std::span<const Pose> poses,
              const Query& query) {
  Answers out;
  out.status.resize(pairs.size(), PairStatus::failed);
  out.geometry.resize(pairs.size());
  out.points.resize(pairs.size() * static_cast<std::size_t>(query.max_points));
  const touchstone_input input = c_interface::c_input({pairs, poses, query, {}});
  const touchstone_output output = c_interface::c_output({out.status, out.geometry, out.points});
  EXPECT_EQ(native.evaluate(input, output), TOUCHSTONE_OK) << touchstone_error();
  return out;
}

bool same(double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); }

TEST(CInterface, SameBitsAsThroughCpp) {
  for (const char* family : {"random", "resting", "tapered", "bent", "touching"}) {
    const auto set = measures::make_pair_family(family, 3, 300);
    const auto native = make_native();
    native->build(set.solids);
    const Native c(set.solids);
    for (const QueryKind kind : {QueryKind::overlap, QueryKind::distance, QueryKind::manifold}) {
      const Query query{.kind = kind};
      const Answers expected = ask(*native, set.pairs, set.poses, query);
      const Answers got = ask_c(c, set.pairs, set.poses, query);
      ASSERT_EQ(got.status, expected.status);
      for (std::size_t i = 0; kind != QueryKind::overlap && i < set.pairs.size(); ++i) {
        ASSERT_TRUE(same(got.geometry[i].separation, expected.geometry[i].separation)) << family << i;
        ASSERT_EQ(got.geometry[i].point_count, expected.geometry[i].point_count);
        for (int k = 0; k < 3; ++k)
          ASSERT_TRUE(same(got.geometry[i].p_B_W(k), expected.geometry[i].p_B_W(k))) << family << i;
        for (int p = 0; p < got.geometry[i].point_count; ++p) {
          const std::size_t slot = i * kMaxManifoldPoints + static_cast<std::size_t>(p);
          ASSERT_EQ(got.points[slot].p_A_W, expected.points[slot].p_A_W);
          ASSERT_EQ(got.points[slot].feature_id, expected.points[slot].feature_id);
        }
      }
    }
  }
}

TEST(CInterface, CornersOfABoxAreABox) {
  const std::vector<Hexahedron> solids = {
      Hexahedron::from_size({0.1, 0.7, 3.0}),
      Hexahedron::from_vertices(Hexahedron::from_size({1, 1, 1}).vertices())};
  const auto back = c_interface::solids_from_corners(c_interface::corners_of(solids));
  ASSERT_EQ(back.size(), 2u);
  EXPECT_TRUE(back[0].is_box());
  EXPECT_EQ(back[0].vertices(), solids[0].vertices());
  EXPECT_TRUE(back[1].is_box());  // a centred one, whoever made it
  std::vector<double> moved = c_interface::corners_of(solids);
  for (double& x : moved) x += 0.25;
  EXPECT_FALSE(c_interface::solids_from_corners(moved)[0].is_box());
}

/// Spheres, capsules, plates, rounded boxes and a padded frustum, and one box that is not rounded.
std::vector<Hexahedron> rounded_and_plain() {
  std::array<Vector3, 8> frustum = Hexahedron::from_size({1, 1, 1}).vertices();
  for (Vector3& v : frustum)
    if (v.z() > 0.0) v.x() *= 0.5;
  return {Hexahedron::sphere(0.4),
          Hexahedron::capsule(0.2, 1.5),
          Hexahedron::rounded_box({1.0, 0.0, 0.7}, 0.1),
          Hexahedron::rounded_box({0.6, 0.8, 1.0}, 0.05),
          Hexahedron::from_vertices(frustum).padded(0.1),
          Hexahedron::from_size({0.5, 1.0, 0.3})};
}

TEST(CInterface, RoundedSolidsGiveTheBitsOfCpp) {
  // The same solids over C and in C++.
  const std::vector<Hexahedron> solids = rounded_and_plain();
  const auto native = make_native();
  native->build(solids);
  const Native c(std::vector<Hexahedron>{Hexahedron::from_size({1, 1, 1})});
  const std::vector<double> corners = c_interface::corners_of(solids);
  std::vector<double> radii;
  for (const Hexahedron& solid : solids) radii.push_back(solid.radius());
  ASSERT_EQ(touchstone_build_rounded(c.narrowphase.get(), corners.data(), radii.data(), solids.size()),
            TOUCHSTONE_OK)
      << touchstone_error();
  // All pairs in random poses: the same classes and bits.
  std::vector<SolidPair> pairs;
  for (SolidIndex a = 0; a < solids.size(); ++a)
    for (SolidIndex b = a + 1; b < solids.size(); ++b) pairs.push_back({a, b});
  std::mt19937_64 random(2121);
  std::size_t overlapping = 0;
  for (int round = 0; round < 40; ++round) {
    std::vector<Pose> poses;
    for (std::size_t i = 0; i < solids.size(); ++i) poses.push_back(random_pose(random, 0.8));
    const Query query{.kind = QueryKind::distance};
    const Answers expected = ask(*native, pairs, poses, query), got = ask_c(c, pairs, poses, query);
    ASSERT_EQ(got.status, expected.status);
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      ASSERT_TRUE(same(got.geometry[i].separation, expected.geometry[i].separation)) << i;
      overlapping += got.status[i] == PairStatus::overlapping ? 1 : 0;
    }
  }
  EXPECT_GT(overlapping, 100u);
  EXPECT_LT(overlapping, 40 * pairs.size() - 100);
}

TEST(CInterface, RadiiThatAreNoneAreNamedAndTheLastBuildStays) {
  const std::vector<Hexahedron> solids(2, Hexahedron::from_size({1, 1, 1}));
  const Native c(solids);
  std::vector<double> corners = c_interface::corners_of(solids);
  for (const double bad : {-0.1, kNaN, kInfinity}) {
    const std::array radii = {0.0, bad};
    EXPECT_EQ(touchstone_build_rounded(c.narrowphase.get(), corners.data(), radii.data(), 2),
              TOUCHSTONE_BAD_INPUT);
    EXPECT_THAT(touchstone_error(), testing::AllOf(HasSubstr("solid 1"), HasSubstr("radius")));
  }
  // A flat hexahedron is a solid only with a radius.
  for (std::size_t i = 0; i < 8; ++i) corners[24 + 3 * i] = 0.0;
  EXPECT_EQ(touchstone_build_rounded(c.narrowphase.get(), corners.data(), nullptr, 2), TOUCHSTONE_BAD_INPUT);
  EXPECT_THAT(touchstone_error(), HasSubstr("solid 1"));
  // A backend without rounded solids refuses them by name.
  touchstone_narrowphase* made = nullptr;
  ASSERT_EQ(touchstone_create("edge_face", &made), TOUCHSTONE_OK);
  const std::unique_ptr<touchstone_narrowphase, Destroy> edge_face(made);
  const std::array radii = {0.0, 0.1};
  EXPECT_EQ(touchstone_build_rounded(made, corners.data(), radii.data(), 2), TOUCHSTONE_BAD_INPUT);
  EXPECT_THAT(touchstone_error(), HasSubstr("solid 1 is rounded"));
  // The two cubes of the first build are still asked.
  const Answers got =
      ask_c(c, std::vector<SolidPair>{{0, 1}}, std::vector<Pose>{Pose{}, {Matrix3::Identity(), {3, 0, 0}}},
            {.kind = QueryKind::distance});
  EXPECT_EQ(got.geometry[0].separation, 2.0);
}

class BadCalls : public testing::Test {
 protected:
  std::vector<Hexahedron> solids{Hexahedron::from_size({1, 1, 1}), Hexahedron::from_size({1, 1, 1})};
  Native native{solids};
  touchstone_pair pair{0, 1};
  touchstone_pose poses[2] = {{{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 0, 0}},
                              {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {3, 0, 0}}};
  touchstone_status status = 77;
  touchstone_geometry geometry{};
  touchstone_input input{&pair, 1, poses, 2, {TOUCHSTONE_DISTANCE, 0, kInfinity, 0.0}};
  touchstone_output output{&status, &geometry, nullptr};

  void refused(const char* text) {
    EXPECT_EQ(native.evaluate(input, output), TOUCHSTONE_BAD_INPUT);
    EXPECT_THAT(touchstone_error(), HasSubstr(text));
    EXPECT_EQ(status, 77);
  }
};

TEST_F(BadCalls, PairOutOfRange) {
  pair.b = 2;
  refused("pair 0: (0, 2) is not two of the 2 solids");
}
TEST_F(BadCalls, PairOfOneSolid) {
  pair.a = 1;
  refused("pair 0: (1, 1)");
}
TEST_F(BadCalls, TooFewPoses) {
  input.pose_count = 1;
  refused("poses: has 1 entries, needs 2");
}
TEST_F(BadCalls, NoSuchKind) {
  input.query.kind = 3;
  refused("kind 3 is none");
}
TEST_F(BadCalls, ManifoldWithoutPoints) {
  input.query.kind = TOUCHSTONE_MANIFOLD;
  refused("max_points is 0");
  input.query.max_points = 8;
  refused("points: is NULL");
}
TEST_F(BadCalls, NegativeMaxSeparation) {
  input.query.max_separation = -1.0;
  refused("max_separation is -1");
}
TEST_F(BadCalls, SlotsMissing) {
  output.geometry = nullptr;
  refused("geometry: is NULL");
}
TEST_F(BadCalls, WorkspaceOfAnother) {
  const Native other(solids);
  EXPECT_EQ(touchstone_evaluate(other.narrowphase.get(), native.workspace.get(), &input, &output),
            TOUCHSTONE_BAD_INPUT);
  EXPECT_THAT(touchstone_error(), HasSubstr("another narrowphase"));
}
TEST_F(BadCalls, PosesThatAreNotFiniteFailAlone) {
  poses[1].p[0] = kNaN;
  EXPECT_EQ(native.evaluate(input, output), TOUCHSTONE_OK);
  EXPECT_EQ(status, TOUCHSTONE_FAILED);
}
TEST_F(BadCalls, ARefusedSolidIsNamedAndTheLastBuildStays) {
  std::vector<double> corners = c_interface::corners_of(solids);
  corners[24 + 5] = kNaN;
  EXPECT_EQ(touchstone_build(native.narrowphase.get(), corners.data(), 2), TOUCHSTONE_BAD_INPUT);
  EXPECT_THAT(touchstone_error(), HasSubstr("solid 1"));
  EXPECT_EQ(native.evaluate(input, output), TOUCHSTONE_OK);
  EXPECT_EQ(geometry.separation, 2.0);
}

TEST(CInterface, ErrorsBelongToTheirThread) {
  touchstone_narrowphase* none = nullptr;
  EXPECT_EQ(touchstone_create("no_such", &none), TOUCHSTONE_BAD_INPUT);
  std::thread([] { EXPECT_STREQ(touchstone_error(), ""); }).join();
  EXPECT_THAT(touchstone_error(), HasSubstr("no_such"));
}

TEST(CInterface, PosesAreThoseOfCpp) {
  touchstone_pose pose{};
  const double p[3] = {1, 2, 3}, q[4] = {0.8, 0.3, -0.4, 0.2}, zero[4] = {0, 0, 0, 0};
  ASSERT_EQ(touchstone_pose_from_quaternion(p, q, &pose), TOUCHSTONE_OK);
  const Matrix3 R = rotation_from_quaternion(0.8, 0.3, -0.4, 0.2);
  for (int i = 0; i < 9; ++i) EXPECT_EQ(pose.R[i], R(i % 3, i / 3));
  EXPECT_EQ(touchstone_pose_from_quaternion(p, zero, &pose), TOUCHSTONE_BAD_INPUT);
  const double sheared[16] = {1, 0.1, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  EXPECT_EQ(touchstone_pose_from_matrix(sheared, &pose), TOUCHSTONE_BAD_INPUT);
  const double turned[16] = {0, -1, 0, 4, 1, 0, 0, 5, 0, 0, 1, 6, 0, 0, 0, 1};
  ASSERT_EQ(touchstone_pose_from_matrix(turned, &pose), TOUCHSTONE_OK);
  EXPECT_EQ(pose.R[1], 1.0);
  EXPECT_EQ(pose.R[3], -1.0);
  EXPECT_EQ(pose.p[2], 6.0);
}

// The allowed answers of each backend, and invalid ones.
TEST(AnswerCheck, BrokenAnswersAreNamed) {
  // Answers that are whole.
  const Query distance{.kind = QueryKind::distance}, overlap{}, manifold{.kind = QueryKind::manifold},
      near{.kind = QueryKind::distance, .max_separation = 1.0};
  const PairGeometry good{0.5, {1, 0, 0}, {0, 0, 0}, {0.5, 0, 0}, 0};
  const auto check = [](const Query& query, PairStatus status, PairGeometry geometry) {
    const ContactPoint point{{0, 0, 0}, {0, 0, 0}, kNaN, 0};
    const char* const what = broken_answer(query, status, &geometry, &point);
    return std::string(what == nullptr ? "" : what);
  };
  EXPECT_EQ(check(distance, PairStatus::separated, good), "");
  EXPECT_EQ(check(overlap, PairStatus::separated, no_geometry()), "");
  EXPECT_EQ(check(distance, PairStatus::failed, no_geometry()), "");
  EXPECT_EQ(check(near, PairStatus::separated, no_geometry(kInfinity)), "");
  // An infinite separation is one only beyond the distance asked for.
  EXPECT_THAT(check(distance, PairStatus::separated, no_geometry(kInfinity)), HasSubstr("separation"));
  EXPECT_THAT(check(near, PairStatus::overlapping, no_geometry(kInfinity)), HasSubstr("separation"));
  EXPECT_THAT(check(near, PairStatus::separated, no_geometry(-kInfinity)), HasSubstr("separation"));
  // One field after another is broken.
  EXPECT_THAT(check(overlap, static_cast<PairStatus>(5), good), HasSubstr("status"));
  PairGeometry bad = good;
  bad.n_AB_W = {0, 0, 0};
  EXPECT_THAT(check(distance, PairStatus::separated, bad), HasSubstr("normal"));
  bad = good;
  bad.p_B_W.z() = -kInfinity;
  EXPECT_THAT(check(distance, PairStatus::overlapping, bad), HasSubstr("witness"));
  bad = good;
  bad.point_count = 9;
  EXPECT_EQ(check(distance, PairStatus::separated, bad), "");
  EXPECT_THAT(check(manifold, PairStatus::overlapping, bad), HasSubstr("number of contact points"));
  bad.point_count = 1;
  EXPECT_THAT(check(manifold, PairStatus::overlapping, bad), HasSubstr("contact point is not finite"));
}

}  // namespace
}  // namespace touchstone
