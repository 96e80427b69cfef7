#include <gtest/gtest.h>

#include "touchstone/adapters/fcl/fcl.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/tests/support/sweep_of_cubes.hpp"

// FCL's continuous collision on a closed form.

namespace touchstone::test {
namespace {

constexpr double kMeet = 1.0 / 3;

TEST(FclSweep, CubesMeetWhereTheyDo) {
  const Hexahedron box = Hexahedron::from_size({1, 1, 1});
  for (const Hexahedron& cube : {box, Hexahedron::from_vertices(box.vertices())}) {
    for (const char* name : {"fcl_ca", "fcl_indep_ca"}) {
      const std::optional<double> said = sweep_cubes(sweep_named(fcl_sweeps(), name), cube, 0.3);
      ASSERT_TRUE(said) << name;
      EXPECT_NEAR(*said, kMeet, 1e-4) << name;  // it ends where a step is below that
    }
    // The first of ten poses in contact.
    const std::optional<double> seen = sweep_cubes(sweep_named(fcl_sweeps(), "fcl_naive"), cube, 0.3);
    ASSERT_TRUE(seen);
    EXPECT_GE(*seen, kMeet - 1e-9);
    EXPECT_LE(*seen, kMeet + 0.12);
  }
}

TEST(FclSweep, CubesThatPassDoNotMeet) {
  for (const SweepEntry& entry : fcl_sweeps()) {
    EXPECT_EQ(sweep_cubes(entry, Hexahedron::from_size({1, 1, 1}), 1.2), std::nullopt) << entry.name;
    EXPECT_EQ(entry.backend, "fcl_indep");
    EXPECT_EQ(entry.make()->most_turn(), kInfinity);
  }
}

TEST(FclSweep, RoundedSolidsAreRefused) {
  for (const SweepEntry& entry : fcl_sweeps())
    EXPECT_THROW(sweep_cubes(entry, Hexahedron::sphere(1), 0), InputError) << entry.name;
}

}  // namespace
}  // namespace touchstone::test
