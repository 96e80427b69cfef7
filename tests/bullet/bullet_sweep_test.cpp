#include <gtest/gtest.h>

#include "touchstone/adapters/bullet/bullet.hpp"
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
    EXPECT_EQ(entry.make()->turns(), entry.name == "bullet_continuous");
  }
}

TEST(BulletSweep, RoundedSolidsAreRefused) {
  for (const SweepEntry& entry : bullet_sweeps())
    EXPECT_THROW(sweep_cubes(entry, Hexahedron::sphere(1), 0), InputError) << entry.name;
}

}  // namespace
}  // namespace touchstone::test
