#include <gtest/gtest.h>

#include <cmath>

#include "touchstone/adapters/bullet/bullet.hpp"
#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/tests/support/sweep_of_cubes.hpp"

// Bullet's casts on a closed form.

namespace touchstone::test {
namespace {

constexpr double kMeet = 1.0 / 3, kWay = 6.0;  // [m]

TEST(BulletSweep, CubesMeetWhereTheyDo) {
  const Hexahedron box = Hexahedron::from_size({1, 1, 1});
  const Hexahedron hull = Hexahedron::from_vertices(box.vertices());
  // Nearer than [m]: btContinuousConvexCollision stops a millimetre before, btGjkConvexCast within its
  // margins.
  const std::pair<const char*, double> near[] = {
      {"bullet_continuous", 1.1e-3}, {"bullet_subsimplex_cast", 1e-9}, {"bullet_gjk_cast", 0.05}};
  for (const auto& [name, most] : near) {
    const std::optional<double> said = sweep_cubes(sweep_named(bullet_sweeps(), name), box, 0.3);
    ASSERT_TRUE(said) << name;
    EXPECT_NEAR(*said, kMeet, most / kWay) << name;
  }
  for (const char* name : {"bullet_continuous", "bullet_subsimplex_cast"}) {
    const std::optional<double> said = sweep_cubes(sweep_named(bullet_sweeps(), name), hull, 0.3);
    ASSERT_TRUE(said) << name;
    EXPECT_NEAR(*said, kMeet, 1.1e-3 / kWay) << name;
  }
}

TEST(BulletSweep, CubesThatPassDoNotMeet) {
  for (const SweepEntry& entry : bullet_sweeps()) {
    EXPECT_EQ(sweep_cubes(entry, Hexahedron::from_size({1, 1, 1}), 1.2), std::nullopt) << entry.name;
    EXPECT_EQ(entry.backend, "bullet");
    EXPECT_NEAR(entry.make()->most_turn(), entry.name == "bullet_continuous" ? std::atan(1.0) : 0.0, 1e-15);
  }
}

/// A bar of 2 m turns about its middle onto a small cube that stands `angle` further [rad].
std::optional<double> turn_onto(double turn, double angle) {
  const Hexahedron bar = Hexahedron::from_size({2, 0.02, 0.02}),
                   cube = Hexahedron::from_size({0.02, 0.02, 0.02});
  const RigidPath path = RigidPath::by({}, Vector3::Zero(), {0, 0, turn});
  const RigidPath rest{Pose{Matrix3::Identity(), {0.9 * std::cos(angle), 0.9 * std::sin(angle), 0}}};
  const auto sweep = sweep_named(bullet_sweeps(), "bullet_continuous").make();
  sweep->set(bar, path, cube, rest);
  return sweep->impact();
}

TEST(BulletSweep, TurnsAreFollowedUpTo45Degrees) {
  const std::optional<double> within = turn_onto(0.75, 0.6);
  ASSERT_TRUE(within);
  EXPECT_NEAR(*within, 0.77, 0.03);  // where the sides of both meet
  // Of larger turns it sweeps another: this bar would have its middle line beyond the cube's centre, at 0.8.
  const std::optional<double> beyond = turn_onto(1.5, 1.2);
  EXPECT_TRUE(!beyond || *beyond > 0.8);
}

TEST(BulletSweep, RoundedSolidsAreRefused) {
  for (const SweepEntry& entry : bullet_sweeps())
    EXPECT_THROW(sweep_cubes(entry, Hexahedron::sphere(1), 0), InputError) << entry.name;
}

}  // namespace
}  // namespace touchstone::test
