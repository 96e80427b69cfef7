#include "touchstone/contact_core/numerics/triangle_predicate.hpp"

#include <gtest/gtest.h>

#include "pair_generators.hpp"
#include "touchstone/contact_core/numerics/exact_pair.hpp"
#include "touchstone/contact_core/numerics/exact_predicates.hpp"

namespace touchstone::numerics {
namespace {

MinkowskiTriangle random_triangle(Random& random) {
  MinkowskiTriangle out;
  for (int k = 0; k < 3; ++k) {
    out.a[k] = static_cast<std::uint8_t>(random_int(random, 0, 7));
    out.b[k] = static_cast<std::uint8_t>(random_int(random, 0, 7));
  }
  return out;
}

Certified certify_near(const HullPair& pair, const MinkowskiTriangle& guess) {
  ExactPair exact(pair.a, pair.b);
  return certify_near(exact, guess);
}

/// Whatever the guess, a settled question is settled right. @return how many guesses settled it.
int count_settled(const HullPair& pair, int guesses, Random& random) {
  const bool meet = hulls_intersect(pair.a, pair.b);
  int settled = 0;
  ExactPair exact(pair.a, pair.b);
  for (int i = 0; i < guesses; ++i) {
    const MinkowskiTriangle guess = random_triangle(random);
    const Certified found = certify_near(exact, guess);
    if (found == Certified::unknown) continue;
    ++settled;
    EXPECT_EQ(hulls_intersect(exact), meet);  // whatever was asked before
    EXPECT_EQ(found == Certified::overlapping, meet) << "a " << +guess.a[0] << +guess.a[1] << +guess.a[2]
                                                     << " b " << +guess.b[0] << +guess.b[1] << +guess.b[2];
  }
  return settled;
}

TEST(PortalPredicate, IsRightForEveryGuessOnGrids) {
  Random random(1);
  int settled = 0;
  for (int i = 0; i < 3000; ++i) {
    settled += count_settled(grid_pair(random, random_int(random, 1, 4)), 8, random);
    settled += count_settled(mapped_grid_pair(random, 2, random_int(random, 1, 20)), 8, random);
    if (HasFailure()) return;
  }
  EXPECT_GT(settled, 10000);
}

TEST(PortalPredicate, IsRightForTouchingAndNearlyTouchingBoxes) {
  Random random(2);
  int settled = 0;
  for (int i = 0; i < 3000; ++i) {
    settled += count_settled(aligned_box_pair(random, i % 2 == 0 ? 1.0 : 0.1), 8, random);
    settled += count_settled(rotated_box_pair(random), 8, random);
    if (HasFailure()) return;
  }
  EXPECT_GT(settled, 5000);
}

/// Coordinates whose bits span more than the 125 that fixed integers hold, fewer, and about as many.
TEST(PortalPredicate, IsRightOnBothSidesOfTheFixedIntegersSpan) {
  Random random(3);
  int settled = 0;
  for (const int span : {0, 60, 71, 72, 73, 74, 120, 600}) {
    for (int i = 0; i < 300; ++i) {
      HullPair pair = grid_pair(random, 2);
      // One vertex moves by a bit 2^-span below the grid's unit: a touch becomes a gap or an overlap of that.
      pair.a.x[i % 8] += (i % 3 - 1) * std::ldexp(1.0, -52);
      pair.b.y[i % 8] = std::ldexp(pair.b.y[i % 8] + 0.75, -span);
      settled += count_settled(pair, 8, random);
      settled += count_settled(scattered_pair(random, -span, 0), 4, random);
      if (HasFailure()) return;
    }
  }
  EXPECT_GT(settled, 1000);
}

/// Two unit cubes, B moved: the face x = 1/2 of A against x = -1/2 of B.
HullPair cubes(const Vector3& moved) {
  HullPair out;
  for (int i = 0; i < 8; ++i) {
    const Vector3 v(i & 4 ? 0.5 : -0.5, i & 2 ? 0.5 : -0.5, i & 1 ? 0.5 : -0.5);
    out.a.x[i] = v.x(), out.a.y[i] = v.y(), out.a.z[i] = v.z();
    out.b.x[i] = v.x() + moved.x(), out.b.y[i] = v.y() + moved.y(), out.b.z[i] = v.z() + moved.z();
  }
  return out;
}

TEST(PortalPredicate, AFacetsPlaneDecidesFaceContact) {
  const MinkowskiTriangle facet_of_a{{4, 5, 6}, {0, 0, 0}};
  for (const double offset : {0.25, 1.0, -1.0}) {
    const HullPair touching = cubes({1, offset, 0.25});
    EXPECT_EQ(certify_near(touching, facet_of_a), Certified::overlapping) << offset;
  }
  const HullPair apart = cubes({std::nextafter(1.0, 2.0), 0.25, 0.25});
  EXPECT_EQ(certify_near(apart, facet_of_a), Certified::separated);
  // In one plane, but beside each other.
  const HullPair beside = cubes({1, 1.5, 0});
  EXPECT_EQ(certify_near(beside, facet_of_a), Certified::separated);
}

TEST(PortalPredicate, AVertexOnThePlaneOfTwoEdgesAloneDecidesNothing) {
  // Lines along x of A and y of B span z's plane. A has one edge there, B one vertex in line with it.
  HullPair pair = cubes({3, 0, 1});
  pair.a.z[3] -= 1.0, pair.a.z[7] -= 1.0;
  for (int i = 0; i < 8; ++i)
    if (i != 0) pair.b.z[i] += 1.0;
  EXPECT_EQ(certify_near(pair, {{1, 5, 5}, {1, 1, 3}}), Certified::unknown);
  EXPECT_FALSE(hulls_intersect(pair.a, pair.b));
}

}  // namespace
}  // namespace touchstone::numerics
