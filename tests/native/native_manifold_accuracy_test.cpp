#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <set>

#include "examples/compare_backends/surface_measure.hpp"
#include "native_fixture.hpp"

// What manifold.hpp states of every contact point: on A, on B, straight across, over families that make it
// hard.

namespace touchstone {
namespace {

using comparison::SurfaceMeasure;

struct PairOfSolids {
  Hexahedron a, b;
  Pose X_WA, X_WB;
};
using MakePair = std::function<PairOfSolids(Random&)>;

struct Family {
  const char* name;
  MakePair make;
  double bound;  // of the witness error over S
};

Hexahedron thin_box(Random& random, int least, int most) {
  Vector3 size(random.uniform(0.5, 2), random.uniform(0.5, 2), random.uniform(0.5, 2));
  size(random.below(3)) = std::ldexp(random.uniform(1, 2), -least - random.below(most - least + 1));
  if (random.below(2) == 0)
    size(random.below(3)) = std::ldexp(random.uniform(1, 2), -least - random.below(most - least + 1));
  return Hexahedron::from_size(size);
}

/// All corners moved, then pressed flat.
Hexahedron thin_warped(Random& random, int least, int most) {
  for (;;) {
    const double flat = std::ldexp(1.0, -least - random.below(most - least + 1));
    std::vector<Vector3> corners;
    for (int i = 0; i < 8; ++i) {
      const Vector3 p =
          Vector3(i & 4 ? 0.7 : -0.7, i & 2 ? 0.7 : -0.7, i & 1 ? 0.7 : -0.7) + random.vector(0.12);
      corners.push_back({p.x(), p.y(), flat * p.z()});
    }
    try {
      return Hexahedron::from_vertices(corners, WarpPolicy::accept);
    } catch (const InputError&) {
      // Not convex: draw again.
    }
  }
}

/// B's +z face laid on A's, the turn about their common normal free, and B pushed in by up to 1e-3.
PairOfSolids resting(Random& random, const Hexahedron& a, const Hexahedron& b, double reach) {
  Pose X_WA = random.pose(reach), X_WB;
  const double angle = random.uniform(-3, 3);
  Matrix3 turn = rotation_from_quaternion(std::cos(angle / 2), 0, 0, std::sin(angle / 2));
  for (int i = 0; i < 3; ++i) X_WB.R.col(i) = rotate(X_WA.R, turn.col(i));
  const double height = a.half_extents().z() + b.half_extents().z() - random.uniform(0, 1e-3);
  X_WB.p = X_WA.p + rotate(X_WA.R, {random.uniform(-0.3, 0.3), random.uniform(-0.3, 0.3), height});
  return {a, b, X_WA, X_WB};
}

PairOfSolids crossing(Random& random, const Hexahedron& a, const Hexahedron& b, double reach) {
  Pose X_WA = random.pose(reach), X_WB = random.pose(0.0);
  X_WB.p = X_WA.p + random.vector(0.9);
  return {a, b, X_WA, X_WB};
}

/// The largest of p_A's distance to A's surface, p_B's to B's and |p_B - p_A - s n|, over S; NaN where
/// rounding left a solid without volume.
double worst_point(const PairOfSolids& pair, const Answer& answer) {
  WorldVertices va, vb;
  world_vertices(pair.a, pair.X_WA, va), world_vertices(pair.b, pair.X_WB, vb);
  const SurfaceMeasure a(va), b(vb);
  if (a.is_flat() || b.is_flat()) return std::numeric_limits<double>::quiet_NaN();
  double worst = 0.0;
  for (int i = 0; i < answer.geometry.point_count; ++i) {
    const ContactPoint& p = answer.points[i];
    if (p.feature_id == 0x10000) continue;  // the pair's own witness point
    const double across = norm(p.p_B_W - (p.p_A_W + p.separation * answer.geometry.n_AB_W));
    worst = std::max({worst, a.distance(p.p_A_W), b.distance(p.p_B_W), across});
  }
  return worst / scale_of(pair.a, pair.X_WA, pair.b, pair.X_WB);
}

std::vector<Family> families() {
  const double ordinary = 1e-14, thin = 1e-13;
  return {
      {"any", [](Random& r) { return crossing(r, r.any(), r.any(), 0.3); }, ordinary},
      {"boxes", [](Random& r) { return crossing(r, r.box(), r.box(), 5); }, ordinary},
      {"resting boxes", [](Random& r) { return resting(r, r.box(), r.box(), 5); }, ordinary},
      {"thin boxes", [](Random& r) { return crossing(r, thin_box(r, 2, 40), thin_box(r, 2, 40), 1); }, thin},
      {"thin boxes far out",
       [](Random& r) { return crossing(r, thin_box(r, 20, 42), thin_box(r, 20, 42), 500); }, thin},
      {"resting slabs far out",
       [](Random& r) {
         return resting(r, Hexahedron::from_size({1, 2, std::ldexp(1.0, -30 - r.below(12))}),
                        Hexahedron::from_size({2, 1, std::ldexp(1.0, -30 - r.below(12))}), 500);
       },
       thin},
      {"warped", [](Random& r) { return crossing(r, r.warped(), r.warped(), 1); }, ordinary},
      {"thin warped", [](Random& r) { return crossing(r, thin_warped(r, 2, 40), thin_warped(r, 2, 40), 1); },
       thin},
      {"thin warped far out",
       [](Random& r) { return crossing(r, thin_warped(r, 20, 42), thin_warped(r, 20, 42), 500); }, thin},
      {"pyramids", [](Random& r) { return crossing(r, r.pyramid(), r.pyramid(), 1); }, ordinary},
      {"tapered", [](Random& r) { return crossing(r, r.tapered(), r.tapered(), 1); }, ordinary},
  };
}

TEST(NativeManifoldAccuracy, EveryPointLiesOnBothSurfaces) {
  for (const Family& family : families()) {
    Random random(21);
    double worst = 0.0;
    int worst_index = 0, measured = 0, points = 0;
    for (int i = 0; i < 1500; ++i) {
      const PairOfSolids pair = family.make(random);
      const Answer answer = ask(pair.a, pair.X_WA, pair.b, pair.X_WB);
      const double error = worst_point(pair, answer);
      if (std::isnan(error)) continue;
      ++measured, points += answer.geometry.point_count;
      if (error > worst) worst = error, worst_index = i;
    }
    std::printf("%-24s worst %.2g S (pair %d) of %d pairs, %.2f points a pair\n", family.name, worst,
                worst_index, measured, points / std::max(1.0, 1.0 * measured));
    EXPECT_LE(worst, family.bound) << family.name << " " << worst_index;
    EXPECT_GT(measured, 300) << family.name;
  }
}

}  // namespace
}  // namespace touchstone
