#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "touchstone/contact_core/native/overlap/flush_hulls.hpp"
#include "touchstone/contact_core/numerics/exact_pair.hpp"
#include "touchstone/contact_core/numerics/exact_predicates.hpp"
#include "touchstone/tests/native/native_fixture.hpp"

// certify_flush() against exact arithmetic: unknown or right, never wrong, and seldom unknown where it is
// meant for.

namespace touchstone {
namespace {

using numerics::Certified;

struct FlushPair {
  WorldVertices a, b;
  Vector3 n_W, p_W;
};

enum class Shape { boxes, equal_boxes, frusta };

/// Turned solids that lie flush but for rounding, and `ulps` beyond of the pair's reach.
FlushPair flush_pair(Random& random, Shape shape, double reach, double ulps) {
  // Sizes, and an offset along an axis with which faces touch but for some units in the last place.
  const Vector3 size_a = random.vector(0.2, 2);
  const Vector3 size_b = shape == Shape::equal_boxes ? size_a : random.vector(0.2, 2);
  const int axis = random.below(3);
  Vector3 offset = shape == Shape::equal_boxes ? Vector3(0, 0, 0) : random.vector(0.5);
  offset(axis) = 0.5 * size_a(axis) + 0.5 * size_b(axis) + ulps * 0x1p-52 * (2 + reach);
  // A box, or one that narrows aside of the axis.
  const auto solid = [&](const Vector3& size) {
    if (shape != Shape::frusta) return Hexahedron::from_size(size);
    std::array<Vector3, 8> v;
    for (int i = 0; i < 8; ++i) {
      v[i] = {i & 4 ? 0.5 : -0.5, i & 2 ? 0.5 : -0.5, i & 1 ? 0.5 : -0.5};
      if (v[i]((axis + 2) % 3) > 0.0) v[i]((axis + 1) % 3) *= 0.8;
      v[i] = v[i].cwiseProduct(size);
    }
    return Hexahedron::from_vertices(v);
  };
  // The pair in the world, and a plane between the two.
  const Pose X_WA = random.pose(reach);
  Pose X_WB = X_WA;
  X_WB.p += X_WA.R * offset;
  FlushPair out;
  world_vertices(solid(size_a), X_WA, out.a);
  world_vertices(solid(size_b), X_WB, out.b);
  out.n_W = X_WA.R.col(axis);
  out.p_W = out.a.vertex(axis == 0 ? 4 : axis == 1 ? 2 : 1);
  return out;
}

/// Returns how many of `count` pairs are left unknown.
int count_unknown(std::uint64_t seed, Shape shape, double reach, int most_ulps, int count) {
  Random random(seed);
  int unknown = 0;
  for (int i = 0; i < count; ++i) {
    const double ulps = most_ulps == 0 ? 0.0 : random.below(2 * most_ulps + 1) - most_ulps;
    const FlushPair pair = flush_pair(random, shape, reach, ulps);
    const Certified found =
        native::certify_flush(native::kernels(), pair.a, pair.b, pair.n_W, pair.p_W).certified;
    if (found == Certified::unknown)
      ++unknown;
    else
      EXPECT_EQ(found == Certified::overlapping, numerics::hulls_intersect(pair.a, pair.b))
          << seed << " " << i;
  }
  return unknown;
}

TEST(CertifyFlush, DecidesFlushPairsAsExactArithmeticDoes) {
  for (const double reach : {0.0, 5.0, 1000.0}) {
    for (const int ulps : {0, 1, 3, 30}) {
      EXPECT_LE(count_unknown(1, Shape::boxes, reach, ulps, 500), 25) << reach << " " << ulps;
      EXPECT_LE(count_unknown(2, Shape::frusta, reach, ulps, 500), 25) << reach << " " << ulps;
      // Equal faces may touch in whole edges, exactly: no margin decides that.
      EXPECT_LE(count_unknown(3, Shape::equal_boxes, reach, ulps, 500), 100) << reach << " " << ulps;
    }
  }
}

TEST(CertifyFlush, GuessesOfPairsLeftOpenAreDecidedExactly) {
  Random random(7);
  int open = 0, decided = 0;
  for (int i = 0; i < 20000; ++i) {
    const Shape shape = i % 2 == 0 ? Shape::equal_boxes : Shape::frusta;
    const FlushPair pair = flush_pair(random, shape, 5.0, random.below(3) - 1);
    const native::FlushVerdict verdict =
        native::certify_flush(native::kernels(), pair.a, pair.b, pair.n_W, pair.p_W);
    EXPECT_FALSE(verdict.guess && verdict.certified != Certified::unknown);
    if (!verdict.guess) continue;
    ++open;
    numerics::ExactPair exact(pair.a, pair.b);
    const Certified found = numerics::certify_near(exact, *verdict.guess);
    if (found == Certified::unknown) continue;
    ++decided;
    EXPECT_EQ(found == Certified::overlapping, numerics::hulls_intersect(pair.a, pair.b)) << i;
  }
  std::printf("%d of %d decided\n", decided, open);
  EXPECT_GT(open, 100);
  EXPECT_GT(decided, 0.7 * open);
}

TEST(CertifyFlush, GuessesThatAreOffAreUnknownOrRight) {
  Random random(4);
  for (int i = 0; i < 3000; ++i) {
    FlushPair pair = flush_pair(random, Shape::boxes, 3.0, random.below(5) - 2);
    const double off = std::ldexp(1.0, -random.below(60));
    pair.n_W += off * random.vector(1.0);
    pair.p_W += (i % 2 == 0 ? 0.0 : off) * random.vector(1.0);
    const Certified found =
        native::certify_flush(native::kernels(), pair.a, pair.b, pair.n_W, pair.p_W).certified;
    if (found == Certified::unknown) continue;
    EXPECT_EQ(found == Certified::overlapping, numerics::hulls_intersect(pair.a, pair.b)) << i;
  }
}

TEST(CertifyFlush, EdgesAndCornersThatTouchAreUnknownOrRight) {
  Random random(5);
  int known = 0;
  for (int i = 0; i < 3000; ++i) {
    // Turned so that an edge or a corner points at the other's face, and lowered onto it.
    FlushPair pair = flush_pair(random, Shape::boxes, 2.0, 0.0);
    const Hexahedron cube = Hexahedron::from_size(random.vector(0.2, 2));
    world_vertices(cube, random.pose(1.0), pair.b);
    double lowest = 1e300;
    for (int k = 0; k < 8; ++k) lowest = std::min(lowest, dot(pair.n_W, pair.b.vertex(k) - pair.p_W));
    for (int k = 0; k < 8; ++k) {
      pair.b.x[k] -= lowest * pair.n_W.x();
      pair.b.y[k] -= lowest * pair.n_W.y();
      pair.b.z[k] -= lowest * pair.n_W.z();
    }
    const Certified found =
        native::certify_flush(native::kernels(), pair.a, pair.b, pair.n_W, pair.p_W).certified;
    if (found == Certified::unknown) continue;
    ++known;
    EXPECT_EQ(found == Certified::overlapping, numerics::hulls_intersect(pair.a, pair.b)) << i;
  }
  EXPECT_GT(known, 300);
}

TEST(CertifyFlush, OrdinaryAndExtremePairsAreUnknownOrRight) {
  Random random(6);
  for (int i = 0; i < 2000; ++i) {
    FlushPair pair = flush_pair(random, Shape::boxes, 1.0, random.below(3) - 1);
    const int exponent = 25 * (random.below(81) - 40);
    for (WorldVertices* v : {&pair.a, &pair.b})
      for (auto* column : {&v->x, &v->y, &v->z})
        for (double& c : *column) c = std::ldexp(c, exponent);
    for (int k = 0; k < 3; ++k) pair.p_W(k) = std::ldexp(pair.p_W(k), exponent);
    const Certified found =
        native::certify_flush(native::kernels(), pair.a, pair.b, pair.n_W, pair.p_W).certified;
    if (found == Certified::unknown) continue;
    EXPECT_LE(std::abs(exponent), 400);
    EXPECT_EQ(found == Certified::overlapping, numerics::hulls_intersect(pair.a, pair.b))
        << i << " " << exponent;
  }
}

/// Two unit cubes along the world's axes, B `gap` above A and a quarter aside.
FlushPair stacked_cubes(double gap) {
  const Hexahedron cube = Hexahedron::from_size({1, 1, 1});
  Pose X_WB;
  X_WB.p = {0.25, 0.25, 1.0 + gap};
  FlushPair out;
  world_vertices(cube, Pose{}, out.a);
  world_vertices(cube, X_WB, out.b);
  out.n_W = {0, 0, 1}, out.p_W = {0, 0, 0.5};
  return out;
}

TEST(CertifyFlush, SaysWhetherAnotherPlaneMayTellMore) {
  const auto ask = [](const FlushPair& pair) {
    return native::certify_flush(native::kernels(), pair.a, pair.b, pair.n_W, pair.p_W);
  };
  FlushPair pair = stacked_cubes(0x1p-52);
  EXPECT_EQ(ask(pair).certified, Certified::separated);
  EXPECT_EQ(ask(pair).miss, native::FlushMiss::none);
  pair = stacked_cubes(0.0);  // exactly in the plane
  EXPECT_EQ(ask(pair).certified, Certified::unknown);
  EXPECT_EQ(ask(pair).miss, native::FlushMiss::pair);
  pair = stacked_cubes(0x1p-52);
  pair.n_W = {0.6, 0, 0.8};
  EXPECT_EQ(ask(pair).certified, Certified::unknown);
  EXPECT_EQ(ask(pair).miss, native::FlushMiss::plane);
  pair.n_W = {0, 0, 0};
  EXPECT_EQ(ask(pair).miss, native::FlushMiss::plane);
}

}  // namespace
}  // namespace touchstone
