#include "touchstone/contact_core/numerics/exact_predicates.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>

#include "touchstone/adapters/exact/signed_distance.hpp"
#include "touchstone/tests/support/random_poses.hpp"

// hulls_intersect against the exact backend, an independent algorithm in arbitrary-precision integers: on
// grids of small integers, where every degeneracy occurs, and on boxes brought to touch, at all magnitudes a
// double can hold.

namespace touchstone {
namespace {

using numerics::hulls_intersect;
using Generator = std::mt19937_64;

WorldVertices scaled(const WorldVertices& v, int exponent) {
  WorldVertices out;
  for (int i = 0; i < 8; ++i) {
    out.x[i] = std::scalbn(v.x[i], exponent);
    out.y[i] = std::scalbn(v.y[i], exponent);
    out.z[i] = std::scalbn(v.z[i], exponent);
  }
  return out;
}

WorldVertices shifted(const WorldVertices& v, const Vector3& by) {
  WorldVertices out;
  for (int i = 0; i < 8; ++i)
    out.x[i] = v.x[i] + by.x(), out.y[i] = v.y[i] + by.y(), out.z[i] = v.z[i] + by.z();
  return out;
}

WorldVertices box(const Vector3& half, const Pose& X) {
  WorldVertices out;
  world_vertices(Hexahedron::from_size(2.0 * half), X, out);
  return out;
}

// Eight points of {-reach .. reach}^3 in a random affine subspace of dimension `rank`.
WorldVertices grid_points(Generator& random, int rank, int reach) {
  const auto small = [&] {
    return static_cast<double>(static_cast<int>(random() % (2 * reach + 1)) - reach);
  };
  const Vector3 origin{small(), small(), small()};
  std::array<Vector3, 3> axes;
  for (Vector3& axis : axes) axis = {small(), small(), small()};
  WorldVertices out;
  for (int i = 0; i < 8; ++i) {
    Vector3 p = origin;
    for (int k = 0; k < rank; ++k) p += small() * axes[k];
    out.x[i] = p.x(), out.y[i] = p.y(), out.z[i] = p.z();
  }
  return out;
}

struct Tally {
  int contacts = 0;
  int total = 0;
};

void expect_agreement(const WorldVertices& a, const WorldVertices& b, Tally& tally) {
  const bool expected = exact_overlap(a, b);
  ASSERT_EQ(hulls_intersect(a, b), expected) << "pair " << tally.total;
  ASSERT_EQ(hulls_intersect(b, a), expected) << "swapped pair " << tally.total;
  tally.contacts += expected;
  ++tally.total;
}

TEST(HullsIntersectAgreesWithExact, OnGridsOfAllRanks) {
  Generator random(1);
  Tally tally;
  for (int reach : {1, 2, 3})
    for (int rank_a = 0; rank_a <= 3; ++rank_a)
      for (int rank_b = 0; rank_b <= 3; ++rank_b)
        for (int repeat = 0; repeat < 60; ++repeat) {
          const WorldVertices a = grid_points(random, rank_a, reach), b = grid_points(random, rank_b, reach);
          expect_agreement(a, b, tally);
        }
  EXPECT_GT(tally.contacts, tally.total / 10);
  EXPECT_LT(tally.contacts, tally.total * 9 / 10);
}

TEST(HullsIntersectAgreesWithExact, OnFlatHullsInOnePlane) {
  Generator random(2);
  Tally tally;
  for (int repeat = 0; repeat < 600; ++repeat) {
    WorldVertices a = grid_points(random, 3, 3), b = grid_points(random, 3, 3);
    for (int i = 0; i < 8; ++i) {  // project both into the plane z = x - 2 y, or onto a line in it
      if (repeat % 3 == 0) a.y[i] = b.y[i] = 1.0;
      a.z[i] = a.x[i] - 2.0 * a.y[i];
      b.x[i] += 4.0 * (repeat % 10);
      b.z[i] = b.x[i] - 2.0 * b.y[i];
    }
    expect_agreement(a, b, tally);
  }
  EXPECT_GT(tally.contacts, 100);
  EXPECT_LT(tally.contacts, 500);
}

TEST(HullsIntersectAgreesWithExact, OnBoxesBroughtToTouchAtEveryMagnitude) {
  Generator random(3);
  Tally tally;
  for (int repeat = 0; repeat < 400; ++repeat) {
    Pose X_A, X_B;
    if (repeat % 2 == 0) {
      const Vector3 q = random_vector(random, 1);
      X_A.R = rotation_from_quaternion(q.x(), q.y(), q.z(), 1.0);
      const double x = uniform(random, -1, 1), y = uniform(random, -1, 1);
      X_B.R = repeat % 4 == 0 ? X_A.R : rotation_from_quaternion(1.0, x, y, 0.3);
    }
    const Vector3 half_a = random_vector(random, 0.1, 1);
    const Vector3 half_b = random_vector(random, 0.1, 1);
    const WorldVertices a = box(half_a, X_A), b = box(half_b, X_B);
    // Touch by the exact distance along x, then step by ulps around it.
    const Vector3 far{5.0, uniform(random, -0.3, 0.3), uniform(random, -0.3, 0.3)};
    double high_a = -1e9, low_b = 1e9;
    for (int i = 0; i < 8; ++i) high_a = std::max(high_a, a.x[i]), low_b = std::min(low_b, b.x[i] + far.x());
    const double touch = high_a - low_b + 5.0;
    for (double ulps : {-3.0, 0.0, 1.0, 3.0}) {
      const WorldVertices placed = shifted(b, {touch + ulps * 0x1p-52, far.y(), far.z()});
      for (int exponent : {0, -1060, -980, 900})
        expect_agreement(scaled(a, exponent), scaled(placed, exponent), tally);
    }
  }
  EXPECT_GT(tally.contacts, tally.total / 20);
  EXPECT_LT(tally.contacts, tally.total * 19 / 20);
}

// One tiny and one huge solid: the exponents of one determinant spread over the whole range of a double.
TEST(HullsIntersectAgreesWithExact, OnMixedMagnitudes) {
  Generator random(4);
  Tally tally;
  for (int repeat = 0; repeat < 100; ++repeat) {
    const WorldVertices huge = scaled(grid_points(random, 3, 2), 900);
    const WorldVertices tiny = scaled(grid_points(random, 3, 2), -900);
    expect_agreement(huge, tiny, tally);
    expect_agreement(huge, shifted(tiny, {0, 0, std::scalbn(1.0, 900)}), tally);
  }
}

}  // namespace
}  // namespace touchstone
