#include <gtest/gtest.h>

#include "touchstone/contact_core/broadphase/world_spheres.hpp"
#include "touchstone/tests/broadphase/random_scene.hpp"

// Boxes that are huge, tiny, coincident or exactly touching, at any place, against brute force.

namespace touchstone {
namespace {

using namespace broadphase_tests;

// A place per box: mostly about a few others, exactly touching, coincident or nested.
Pose extreme_pose(std::mt19937_64& random, const Scene& scene, const std::vector<double>& sizes,
                  double size) {
  if (scene.poses.empty() || random() % 4 == 0) {
    const double decade = std::uniform_real_distribution<double>(-200, 150)(random);
    Pose X = random_pose(random, std::pow(10.0, random() % 2 == 0 ? decade : 1.0));
    X.R = random() % 2 == 0 ? Matrix3(Matrix3::Identity()) : X.R;
    return X;
  }
  const std::size_t other = random() % scene.poses.size();
  Pose X{Matrix3::Identity(), scene.poses[other].p};
  const std::uint64_t how = random() % 4;
  const double reach = how == 0 ? 0.0 : 0.5 * (size + sizes[other]);
  for (int i = 0; i < 3; ++i)
    if (how == 1 || (how == 2 && i == 0)) X.p(i) += (random() % 2 == 0 ? 1 : -1) * reach;
  if (how == 3) X.p *= 1.0 + 0x1p-52;
  return X;
}

struct ExtremeScene {
  Scene scene;
  std::vector<double> sizes;
};

ExtremeScene extreme_scene(std::uint64_t seed, int objects) {
  std::mt19937_64 random(seed);
  const bool alike = random() % 2 == 0;
  const double common = std::pow(10.0, std::uniform_real_distribution<double>(-150, 100)(random));
  ExtremeScene extreme;
  for (int i = 0; i < objects; ++i) {
    double size = alike ? common : std::pow(10.0, std::uniform_real_distribution<double>(-290, 140)(random));
    if (random() % 2 == 0 && !extreme.sizes.empty()) size = extreme.sizes[random() % extreme.sizes.size()];
    const Pose X = extreme_pose(random, extreme.scene, extreme.sizes, size);
    extreme.scene.add({{"", Hexahedron::from_size(Vector3::Constant(size)), {}}}, X);
    extreme.sizes.push_back(size);
  }
  return extreme;
}

// The hulls' own boxes overlap in every axis, aligned ones: such pairs touch beyond doubt.
Pairs surely_touching(const ExtremeScene& extreme) {
  const Scene& scene = extreme.scene;
  std::vector<Box> boxes;
  std::vector<bool> aligned;
  for (std::size_t s = 0; s < scene.solids.size(); ++s) {
    WorldVertices v;
    world_vertices(scene.solids[s], scene.poses[s], v);
    const auto [x0, x1] = std::minmax_element(v.x.begin(), v.x.end());
    const auto [y0, y1] = std::minmax_element(v.y.begin(), v.y.end());
    const auto [z0, z1] = std::minmax_element(v.z.begin(), v.z.end());
    boxes.push_back({{*x0, *y0, *z0}, {*x1, *y1, *z1}});
    aligned.push_back(scene.poses[s].R == Matrix3(Matrix3::Identity()));
  }
  Pairs pairs;
  for (SolidIndex a = 0; a < boxes.size(); ++a)
    for (SolidIndex b = a + 1; b < boxes.size(); ++b)
      if (aligned[a] && aligned[b] && overlap(boxes[a], boxes[b])) pairs.push_back({a, b});
  return pairs;
}

TEST(ExtremeBoxes, NoPairIsMissedAndNativeFindsWhatBruteForceFinds) {
  std::size_t touching = 0;
  for (std::uint64_t seed = 0; seed < 400; ++seed) {
    // Extreme sizes and places, with static objects and margins of any size.
    ExtremeScene extreme = extreme_scene(seed, 90);
    Scene& scene = extreme.scene;
    std::mt19937_64 random(seed + 1000);
    std::vector<std::uint8_t> is_static(90);
    if (seed % 3 == 0)
      for (std::uint8_t& flag : is_static) flag = random() % 3 == 0;
    const double margin = seed % 2 == 0 ? 0.0 : std::pow(10.0, static_cast<double>(random() % 200) - 100.0);
    // Native finds what brute force finds; in scenes without static objects, all that touches.
    const auto brute_force = make("brute_force", scene, margin, is_static);
    const auto native = make("native", scene, margin, is_static);
    Pairs found = sweep(*native, 256);
    ASSERT_EQ(found, sweep(*brute_force, 256)) << seed;
    if (seed % 3 != 0) {
      const Pairs needed = surely_touching(extreme);
      touching += needed.size();
      ASSERT_TRUE(std::includes(found.begin(), found.end(), needed.begin(), needed.end())) << seed;
    }
    // The same after a few have moved, and on paths.
    const std::vector<Pose> before = scene.poses;
    for (std::uint32_t few : {1u, 4u, 40u}) {
      std::vector<std::uint32_t> moved;
      for (std::uint32_t i = 0; i < few; ++i) {
        const auto object = static_cast<std::uint32_t>(random() % 90);
        scene.place(object, extreme_pose(random, scene, extreme.sizes, extreme.sizes[object]));
        moved.push_back(object);
      }
      native->update(scene.poses, moved), brute_force->update(scene.poses, moved);
      found = sweep(*native, 256);
      ASSERT_EQ(found, sweep(*brute_force, 256)) << seed << ", " << few << " moved";
    }
    native->update_paths({before, scene.poses}, {}), brute_force->update_paths({before, scene.poses}, {});
    const Pairs swept = sweep(*native, 256);
    ASSERT_EQ(swept, sweep(*brute_force, 256)) << seed << ", paths";
    if (seed % 3 != 0) {
      const Pairs needed = surely_touching(extreme);
      ASSERT_TRUE(std::includes(swept.begin(), swept.end(), needed.begin(), needed.end())) << seed;
    }
  }
  EXPECT_GT(touching, 50000u);
}

}  // namespace
}  // namespace touchstone
