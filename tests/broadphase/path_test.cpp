#include <gtest/gtest.h>

#include "touchstone/contact_core/broadphase/swept_sphere.hpp"
#include "touchstone/contact_core/scene/motion.hpp"
#include "touchstone/tests/broadphase/random_scene.hpp"
#include "touchstone/tests/support/counting_allocator.hpp"

namespace touchstone {
namespace {

using namespace broadphase_tests;

constexpr double kPi = 3.14159265358979323846;

// Objects that go from one pose to another by interpolate().
struct MovingScene {
  Scene scene;
  std::vector<Pose> X_WO_from, X_WO_to;
  std::vector<Pose> from, to;
  std::vector<double> bulge;

  SolidPaths paths() const { return {from, to, bulge}; }

  void set_path(std::uint32_t object, const Pose& X_WO_start, const Pose& X_WO_end) {
    X_WO_from.resize(scene.trees.size()), X_WO_to.resize(scene.trees.size());
    from.resize(scene.solids.size()), to.resize(scene.solids.size()), bulge.resize(scene.solids.size());
    X_WO_from[object] = X_WO_start, X_WO_to[object] = X_WO_end;
    const std::size_t first = scene.first_solid(object);
    const std::vector<PlacedHexahedron>& placed = scene.trees[object].solids();
    find_global_positions(scene.trees[object], X_WO_start, std::span(from).subspan(first, placed.size()));
    find_global_positions(scene.trees[object], X_WO_end, std::span(to).subspan(first, placed.size()));
    for (std::size_t i = 0; i < placed.size(); ++i) {
      const double arm = norm(transform(placed[i].X_OS, placed[i].solid.bounding_sphere().centre));
      bulge[first + i] = bulge_of_interpolation(arm * (1 + 1e-15), X_WO_start, X_WO_end);
    }
  }

  std::vector<Pose> poses_at(double s) const {
    std::vector<Pose> poses(scene.solids.size());
    for (std::uint32_t object = 0; object < scene.trees.size(); ++object) {
      const std::size_t count = scene.trees[object].solids().size();
      find_global_positions(scene.trees[object], interpolate(X_WO_from[object], X_WO_to[object], s),
                            std::span(poses).subspan(scene.first_solid(object), count));
    }
    return poses;
  }
};

// Every other object at rest; a third of the others turns by half a turn.
MovingScene moving_scene(int objects, double extent, double offset, std::uint64_t seed) {
  MovingScene moving;
  moving.scene = random_scene(objects, extent, offset, seed);
  std::mt19937_64 random(seed + 1);
  for (std::uint32_t object = 0; object < moving.scene.trees.size(); ++object) {
    Pose start = random_pose(random, extent), end = random_pose(random, extent);
    if (object % 3 == 0) end.R = compose(start, {rotation_about(Vector3::UnitY(), kPi), {0, 0, 0}}).R;
    start.p += Vector3(offset, -2 * offset, 0.5 * offset),
        end.p += Vector3(offset, -2 * offset, 0.5 * offset);
    moving.set_path(object, start, object % 2 == 0 ? end : start);
  }
  return moving;
}

std::vector<Vector3> vertices_at(const Hexahedron& solid, const Pose& X_WS) {
  WorldVertices v;
  world_vertices(solid, X_WS, v);
  std::vector<Vector3> points;
  for (int i = 0; i < 8; ++i) points.push_back(v.vertex(i));
  return points;
}

// Pairs with vertices within `margin` of each other, a at its pose among `poses_a` and b among `poses_b`.
Pairs surely_close(const Scene& scene, const std::vector<Pose>& poses_a, const std::vector<Pose>& poses_b,
                   double margin) {
  Pairs pairs;
  std::vector<std::vector<Vector3>> of_a, of_b;
  for (std::size_t s = 0; s < scene.solids.size(); ++s) {
    of_a.push_back(vertices_at(scene.solids[s], poses_a[s]));
    of_b.push_back(vertices_at(scene.solids[s], poses_b[s]));
  }
  const auto close = [&](std::size_t a, std::size_t b) {
    for (const Vector3& p : of_a[a])
      for (const Vector3& q : of_b[b])
        if (norm(p - q) <= margin) return true;
    return false;
  };
  for (SolidIndex a = 0; a < scene.solids.size(); ++a)
    for (SolidIndex b = a + 1; b < scene.solids.size(); ++b)
      if (scene.object_of[a] != scene.object_of[b] && close(a, b)) pairs.push_back({a, b});
  return pairs;
}

class PathTest : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Core, PathTest, testing::Values("brute_force", "native"),
                         [](const auto& test) { return std::string(test.param); });

TEST_P(PathTest, NeverMissesAPairThatComesWithinMarginAnywhereOnItsPaths) {
  for (double offset : {0.0, 1e6}) {
    const MovingScene moving = moving_scene(40, 12, offset, 21);
    const auto broadphase = build(GetParam(), moving.scene, 0.5);
    ASSERT_TRUE(broadphase->update_paths(moving.paths(), {}));
    const Pairs found = sweep(*broadphase, 64);
    Pairs at_rest = surely_close(moving.scene, moving.from, moving.from, 0.5);
    std::size_t needed = 0;
    for (int i = 0; i <= 12; ++i)
      for (int j : {i, 12 - i, 0}) {  // together, and one ahead of the other
        const Pairs close =
            surely_close(moving.scene, moving.poses_at(i / 12.0), moving.poses_at(j / 12.0), 0.5);
        EXPECT_TRUE(std::includes(found.begin(), found.end(), close.begin(), close.end())) << i << ' ' << j;
        needed += close.size();
      }
    EXPECT_GT(needed, 39 * at_rest.size() / 2);
    EXPECT_LT(found.size(), moving.scene.solids.size() * (moving.scene.solids.size() - 1) / 2);
  }
}

TEST_P(PathTest, PathsOfNoLengthAreHardlyMoreThanPoses) {
  const Scene scene = random_scene(150, 25, 0, 22);
  const auto broadphase = make(GetParam(), scene, 0.1);
  const Pairs posed = sweep(*broadphase, 64);
  broadphase->update_paths({scene.poses, scene.poses}, {});
  const Pairs swept = sweep(*broadphase, 64);
  EXPECT_TRUE(std::includes(posed.begin(), posed.end(), swept.begin(), swept.end()) ||
              std::includes(swept.begin(), swept.end(), posed.begin(), posed.end()));
  EXPECT_NEAR(static_cast<double>(swept.size()), static_cast<double>(posed.size()), 2.0);
  broadphase->update(scene.poses, {});  // and back
  EXPECT_EQ(sweep(*broadphase, 64), posed);
}

Scene two_boxes(const Vector3& size_a, const Vector3& p_a, const Vector3& size_b, const Vector3& p_b) {
  Scene scene;
  scene.add({{"", Hexahedron::from_size(size_a), {}}}, {Matrix3::Identity(), p_a});
  scene.add({{"", Hexahedron::from_size(size_b), {}}}, {Matrix3::Identity(), p_b});
  return scene;
}

TEST_P(PathTest, ABoxThatWouldTunnelThroughAPlateComesUp) {
  for (double speed : {2.0, 1e3, 1e6, 1e12}) {
    const Scene scene = two_boxes({0.1, 0.1, 0.1}, {-0.4 * speed, 0.3, 0.2}, {0.001, 0.5, 0.5}, {0, 0, 0});
    std::vector<Pose> to = scene.poses;
    to[0].p.x() += speed;
    const auto broadphase = make(GetParam(), scene, 1e-9);
    EXPECT_EQ(sweep(*broadphase, 4), Pairs()) << speed;
    broadphase->update(to, std::vector<std::uint32_t>{0});
    EXPECT_EQ(sweep(*broadphase, 4), Pairs()) << speed;
    broadphase->update_paths({scene.poses, to}, {});
    EXPECT_EQ(sweep(*broadphase, 4), Pairs({{0, 1}})) << speed;
    std::vector<Pose> aside = scene.poses;  // a path that leads past it
    aside[0].p.y() += 2 * speed, aside[0].p.x() += 0.1 * speed;
    broadphase->update_paths({scene.poses, aside}, std::vector<std::uint32_t>{0});
    EXPECT_EQ(sweep(*broadphase, 4), Pairs()) << speed;
  }
}

// A full turn brings the box back to where it was; only the bulge tells of it.
TEST_P(PathTest, AFullTurnOnAnArmComesUpWithWhatStandsOnTheCircle) {
  const Scene scene = two_boxes({0.1, 0.1, 0.1}, {3, 0, 0}, {0.1, 0.1, 0.1}, {-3, 0, 0});
  const auto broadphase = build(GetParam(), scene, 1e-9);
  std::vector<double> bulge = {bulge_of_turn(3.0, -1.0), 0.0};
  broadphase->update_paths({scene.poses, scene.poses, bulge}, {});
  EXPECT_EQ(sweep(*broadphase, 4), Pairs({{0, 1}}));
  bulge[0] = bulge_of_path_length(2 * kPi * 3.0, scene.poses[0].p, scene.poses[0].p);
  broadphase->update_paths({scene.poses, scene.poses, bulge}, std::vector<std::uint32_t>{0});
  EXPECT_EQ(sweep(*broadphase, 4), Pairs({{0, 1}}));
  bulge[0] = bulge_of_turn(3.0, 0.5);  // 120 degrees do not get there
  broadphase->update_paths({scene.poses, scene.poses, bulge}, std::vector<std::uint32_t>{0});
  EXPECT_EQ(sweep(*broadphase, 4), Pairs());
}

// A needle's sphere covers every turn about its own centre.
TEST_P(PathTest, ASpinAboutTheCentreNeedsNoBulge) {
  const Scene scene = two_boxes({2, 0.01, 0.01}, {0, 0, 0}, {0.1, 0.1, 0.1}, {0, 0.9, 0});
  const auto broadphase = build(GetParam(), scene, 0.0);
  broadphase->update_paths({scene.poses, scene.poses}, {});
  EXPECT_EQ(sweep(*broadphase, 4), Pairs({{0, 1}}));
}

TEST_P(PathTest, FramesDoNotAllocateAfterTheFirst) {
  MovingScene moving = moving_scene(120, 20, 0, 23);
  const auto broadphase = build(GetParam(), moving.scene, 0.1);
  Pairs block(64);
  const auto frame = [&](std::span<const std::uint32_t> moved) {
    broadphase->update_paths(moving.paths(), moved);
    for (PairCursor cursor; !cursor.done;) broadphase->find_pairs(cursor, block);
  };
  frame({});
  for (std::uint32_t object = 0; object < 40; ++object) {
    moving.set_path(object, moving.X_WO_from[object], moving.X_WO_from[119 - object]);
    const std::size_t before = allocation_count();
    frame(std::span(&object, 1));
    EXPECT_EQ(allocation_count(), before);
  }
}

TEST(NativePaths, FindsWhatBruteForceFindsWithSomeChangedAndSomeStatic) {
  MovingScene moving = moving_scene(200, 40, 0, 24);
  std::vector<std::uint8_t> is_static(200);
  for (std::size_t i = 1; i < 200; i += 4) is_static[i] = 1;
  const auto native = build("native", moving.scene, 0.05, is_static);
  const auto brute_force = build("brute_force", moving.scene, 0.05, is_static);
  native->update_paths(moving.paths(), {}), brute_force->update_paths(moving.paths(), {});
  EXPECT_GT(sweep(*native, 64).size(), 1000u);
  std::mt19937_64 random(25);
  for (int frame = 0; frame < 30; ++frame) {
    std::vector<std::uint32_t> moved;
    for (std::uint32_t object = 0; object < 200; ++object)
      if (random() % (frame % 3 == 0 ? 2 : 60) == 0) {
        moving.set_path(object, random_pose(random, 40), random_pose(random, 40));
        moved.push_back(object);
      }
    native->update_paths(moving.paths(), moved), brute_force->update_paths(moving.paths(), moved);
    ASSERT_EQ(sweep(*native, 64), sweep(*brute_force, 64)) << frame;
  }
}

// --- the bounds themselves

long double distance_to_segment(const Vector3& p, const Vector3& a, const Vector3& b) {
  using P = Eigen::Matrix<long double, 3, 1>;
  const P u = b.cast<long double>() - a.cast<long double>(),
          v = p.cast<long double>() - a.cast<long double>();
  const long double uu = u.squaredNorm();
  const long double t = uu > 0 ? std::clamp(u.dot(v) / uu, 0.0L, 1.0L) : 0.0L;
  return (v - t * u).norm();
}

TEST(Bulge, CoversInterpolatedMotionAndIsTightForAnArc) {
  std::mt19937_64 random(26);
  double worst_share = 0.0;
  for (int trial = 0; trial < 3000; ++trial) {
    const double scale = std::pow(10.0, static_cast<double>(trial % 13) - 6.0);
    Pose from = random_pose(random, scale * static_cast<double>(trial % 3)), to = random_pose(random, scale);
    if (trial % 5 == 0)  // as a reader of single precision would leave it
      for (int i = 0; i < 9; ++i) from.R(i / 3, i % 3) = static_cast<float>(from.R(i / 3, i % 3));
    if (trial % 7 == 0) to.p = from.p;
    if (trial % 11 == 0) to.R = from.R * rotation_about(Vector3::UnitZ(), kPi);
    if (trial % 11 == 1) to.R = from.R * rotation_about(Vector3::UnitX(), 1e-9);
    const Vector3 c_O = random_vector(random, 3 * scale);
    const Vector3 start = transform(from, c_O), end = transform(to, c_O);
    const double bulge = bulge_of_interpolation(norm(c_O) * (1 + 1e-15), from, to);
    for (int i = 0; i <= 40; ++i) {
      const auto stray = static_cast<double>(
          distance_to_segment(transform(interpolate(from, to, i / 40.0), c_O), start, end));
      ASSERT_LE(stray, bulge) << trial << " at " << i;
      worst_share = std::max(worst_share, stray / bulge);
    }
  }
  EXPECT_GT(worst_share, 0.9);
}

TEST(Bulge, OfATurnCoversEveryTurnUpToAFullOne) {
  for (int degrees = 1; degrees <= 360; ++degrees) {
    const double turn = degrees * kPi / 180;
    const double bulge = bulge_of_turn(2.0, std::cos(0.5 * turn));
    const Vector3 arm(2, 0, 0), travel(0.7, -0.4, 0.2);
    const Vector3 end = rotation_about(Vector3::UnitZ(), turn) * arm + travel;
    long double most = 0;
    for (int i = 0; i <= 100; ++i) {
      const double s = i / 100.0;
      const Vector3 p = rotation_about(Vector3::UnitZ(), s * turn) * arm + s * travel;
      most = std::max(most, distance_to_segment(p, arm, end));
    }
    EXPECT_LE(static_cast<double>(most), bulge + 1e-14) << degrees;  // cos and sin of a rounded angle
  }
}

TEST(Bulge, OfAPathLengthCoversTheDetourOverTheEllipsoidsPole) {
  for (double length : {1.0, 1.0 + 1e-12, 1.5, 10.0, 1e9}) {
    const Vector3 a(0, 0, 0), b(1, 0, 0);
    const double bulge = bulge_of_path_length(length, a, b);
    EXPECT_GE(bulge, std::sqrt(0.25 * length * length - 0.25));
    EXPECT_GE(bulge, 0.5 * (length - 1.0));
    EXPECT_LE(bulge, 0.5 * length * (1 + 1e-14));
  }
  EXPECT_LT(bulge_of_path_length(1.0, {0, 0, 0}, {1, 0, 0}), 1e-6);
}

SweptSphere random_swept(std::mt19937_64& random, double scale) {
  const Vector3 from = random_vector(random, scale);
  const std::uint64_t kind = random() % 4;
  Vector3 to = kind == 0 ? from : random_vector(random, scale);
  if (kind == 1) to = from + Vector3(scale, 0, 0);  // parallel to many others
  return {from, to, 0.2 * scale * static_cast<double>(random() % 5)};
}

long double sampled_distance(const SweptSphere& a, const SweptSphere& b) {
  long double least = INFINITY;
  for (int i = 0; i <= 200; ++i)
    least =
        std::min(least, distance_to_segment(a.from_W + (i / 200.0) * (a.to_W - a.from_W), b.from_W, b.to_W));
  return least;
}

TEST(SweptSphere, ToldApartOnlyWhenApartAndMostlyThen) {
  std::mt19937_64 random(27);
  int apart = 0, distinguished = 0;
  for (int trial = 0; trial < 20000; ++trial) {
    const double scale = std::scalbn(1.0, static_cast<int>(random() % 801) - 400);
    const SweptSphere a = random_swept(random, scale), b = random_swept(random, scale);
    const double margin = 0.1 * scale * static_cast<double>(random() % 2);
    const long double gap = sampled_distance(a, b) - (static_cast<long double>(a.radius) + b.radius + margin);
    const bool touches = may_touch(a, b, margin);
    if (gap <= 0) {
      ASSERT_TRUE(touches) << trial;
    }
    if (gap > 0.03 * scale) ++apart, distinguished += touches ? 0 : 1;
    if (gap <= 0 || gap > 0.03 * scale) {
      ASSERT_EQ(may_touch(b, a, margin), touches) << trial;
    }
  }
  EXPECT_GT(apart, 1000);
  EXPECT_EQ(distinguished, apart);
}

TEST(SweptSphere, ThatIsNotFiniteMayTouchEverything) {
  const SweptSphere one{{0, 0, 0}, {1, 0, 0}, 0.1};
  for (double bad : {double(NAN), double(INFINITY)}) {
    EXPECT_TRUE(may_touch(one, {{0, 1e9, 0}, {bad, bad, -bad}, 0.1}, 0.0)) << bad;
    EXPECT_TRUE(may_touch(one, {{0, 1e9, 0}, {0, 1e9, 0}, bad}, 0.0)) << bad;
  }
}

}  // namespace
}  // namespace touchstone
