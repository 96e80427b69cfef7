#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <sstream>

#include "touchstone/contact_core/geometry/difference_determinant.hpp"
#include "touchstone/contact_core/geometry/orientation.hpp"
#include "touchstone/contact_core/geometry/pose.hpp"
#include "touchstone/contact_core/numerics/exact_predicates.hpp"
#include "touchstone/tests/numerics/hull_oracle.hpp"
#include "touchstone/tests/numerics/pair_generators.hpp"

// hulls_intersect() and orient3d_sign() against integer arithmetic (GMP) on inputs made to be hard.

namespace touchstone::numerics {
namespace {

std::string text(const HullPair& pair) {
  std::ostringstream out;
  out << std::hexfloat;
  for (const WorldVertices* hull : {&pair.a, &pair.b})
    for (int i = 0; i < 8; ++i) out << hull->x[i] << ' ' << hull->y[i] << ' ' << hull->z[i] << '\n';
  return out.str();
}

struct Counts {
  int meeting = 0;
  int apart = 0;
};

void check(const HullPair& pair, Counts& counts) {
  const bool expected = hulls_intersect_by_linear_program(pair.a, pair.b);
  ++(expected ? counts.meeting : counts.apart);
  ASSERT_EQ(hulls_intersect(pair.a, pair.b), expected) << text(pair);
  ASSERT_EQ(hulls_intersect(pair.b, pair.a), expected) << text(pair);
}

/// Both answers must be common, or the family tests little.
void check_family(int count, double least_share, const std::function<HullPair(Random&)>& make) {
  Random random(20240607);
  Counts counts;
  for (int i = 0; i < count; ++i) {
    check(make(random), counts);
    if (testing::Test::HasFatalFailure()) return;
  }
  EXPECT_GE(std::min(counts.meeting, counts.apart), least_share * count)
      << counts.meeting << " meeting, " << counts.apart << " apart";
}

/// Moves B along a random direction to where the answer changes, to the last bit of the parameter, and checks
/// there.
void check_at_touching(const WorldVertices& a, const WorldVertices& b, Random& random, double extent,
                       Counts& counts) {
  const Vector3 direction = extent * random_rotation(random).col(0);
  double meeting = 0.0, apart = 8.0;
  const auto moved = [&](double t) { return HullPair{a, translated(b, t * direction)}; };
  if (!hulls_intersect(a, b)) return;
  for (;;) {
    const double middle = meeting + (apart - meeting) / 2.0;
    if (middle <= meeting || middle >= apart) break;
    const HullPair pair = moved(middle);
    const bool meet = hulls_intersect(pair.a, pair.b);
    // The coarse steps are no test of exactness.
    if (apart - meeting < 0x1p-46) {
      check(pair, counts);
      if (testing::Test::HasFatalFailure()) return;
    }
    (meet ? meeting : apart) = middle;
  }
}

void check_near_touching(int count, const Vector3& offset, double extent) {
  Random random(7);
  Counts counts;
  for (int i = 0; i < count; ++i) {
    const auto placed = [&] {
      WorldVertices hull = random_hexahedron(random);
      for (int k = 0; k < 8; ++k) hull.x[k] *= extent, hull.y[k] *= extent, hull.z[k] *= extent;
      return translated(hull, offset);
    };
    const WorldVertices a = placed(), b = placed();
    check_at_touching(a, b, random, extent, counts);
    if (testing::Test::HasFatalFailure()) return;
  }
  EXPECT_GE(std::min(counts.meeting, counts.apart), count / 2);
}

TEST(HullsIntersectOracle, SmallGridsOfAllRanks) {
  for (int range : {1, 2, 3, 6})
    check_family(1200, 0.05, [&](Random& random) { return grid_pair(random, range); });
}

TEST(HullsIntersectOracle, MappedGrids) {
  for (int bits : {2, 8, 20})
    check_family(600, 0.05, [&](Random& random) { return mapped_grid_pair(random, 3, bits); });
}

TEST(HullsIntersectOracle, PolygonsInOnePlane) {
  // Touching rectangles under a rotation in their plane: ties of full mantissas in the plane's own
  // arithmetic.
  check_family(1500, 0.05, [&](Random& random) {
    HullPair pair = aligned_box_pair(random, 0.1);
    const double w = uniform(random, -1, 1), z = uniform(random, -1, 1);
    const Pose flat{rotation_from_quaternion(w, 0.0, 0.0, z),
                    {uniform(random, -9, 9), uniform(random, -9, 9), 0.0}};
    const int axis = random_int(random, 0, 2);
    for (WorldVertices* hull : {&pair.a, &pair.b}) {
      for (int i = 0; i < 8; ++i) {
        const Vector3 p = transform(flat, Vector3(hull->x[i], hull->y[i], 0.0));
        std::array<double, 3> out;
        out[axis] = 0.1, out[(axis + 1) % 3] = p.x(), out[(axis + 2) % 3] = p.y();
        hull->x[i] = out[0], hull->y[i] = out[1], hull->z[i] = out[2];
      }
    }
    return pair;
  });
}

TEST(HullsIntersectOracle, PolygonsByUlps) {
  // A triangle whose side from about (1/2, 1/2) to (24, 24) passes (12, 12), where a segment ends, by a few
  // ulps: the points for which plain doubles often give the wrong orientation (Kettner et al., Classroom
  // Examples of Robustness Problems in Geometric Computations, 2008).
  check_family(1500, 0.05, [](Random& random) {
    const Vector3 corner{0.5 + random_int(random, 0, 255) * 0x1p-53,
                         0.5 + random_int(random, 0, 255) * 0x1p-53, 0.0};
    const std::array<Vector3, 3> triangle = {corner, Vector3(24, 24, 0), Vector3(24, 0, 0)};
    const std::array<Vector3, 2> segment = {Vector3(12, 12, 0), Vector3(0, 24, 0)};
    HullPair pair;
    for (int i = 0; i < 8; ++i) {
      const Vector3 &p = triangle[i % 3], &q = segment[i % 2];
      pair.a.x[i] = p.x(), pair.a.y[i] = p.y(), pair.a.z[i] = p.z();
      pair.b.x[i] = q.x(), pair.b.y[i] = q.y(), pair.b.z[i] = q.z();
    }
    return pair;
  });
}

TEST(HullsIntersectOracle, AlignedBoxes) {
  for (double unit : {1.0, 0.1, 1e-7})
    check_family(800, 0.05, [&](Random& random) { return aligned_box_pair(random, unit); });
}

TEST(HullsIntersectOracle, RotatedTouchingBoxes) { check_family(3000, 0.05, rotated_box_pair); }

TEST(HullsIntersectOracle, NearTouchingHexahedra) { check_near_touching(400, Vector3::Zero(), 1.0); }

TEST(HullsIntersectOracle, NearTouchingFarFromOrigin) {
  check_near_touching(200, Vector3(1e6, -1e6, 3e6), 1.0);
  check_near_touching(200, Vector3(1e15, 0.0, 2e15), 30.0);  // rounded to eighths: all ranks
}

TEST(HullsIntersectOracle, FarFromOriginRoundedToFewPoints) {
  const Vector3 offset(1e15, -2e15, 4e15);
  check_family(1500, 0.05, [&](Random& random) {
    const Vector3 by = random_vector(random, 1);
    return HullPair{translated(random_hexahedron(random), offset),
                    translated(random_hexahedron(random), offset + 2.0 * by)};
  });
}

TEST(HullsIntersectOracle, DenormalAndHugeGrids) {
  for (int exponent : {-1074, -1030, -400, 400, 1020}) {
    check_family(300, 0.05, [&](Random& random) {
      const HullPair pair = mapped_grid_pair(random, 3, exponent == 1020 ? 0 : 4);
      // The largest coordinates of the huge grids (about 1000) must stay finite.
      const int e = exponent == 1020 ? 1013 : exponent;
      return HullPair{scaled(pair.a, e), scaled(pair.b, e)};
    });
  }
}

TEST(HullsIntersectOracle, DifferencesThatOverflow) {
  check_family(600, 0.05, [&](Random& random) {
    // Clamped to {-2 .. 1} + 1/2, so that 2^1023 times the largest stays finite.
    HullPair pair = grid_pair(random, 3);
    for (WorldVertices* hull : {&pair.a, &pair.b}) {
      for (auto* coordinates : {&hull->x, &hull->y, &hull->z})
        for (double& c : *coordinates) c = std::scalbn(std::clamp(c, 0.0, 3.0) - 1.5, 1023);
    }
    return pair;
  });
}

TEST(HullsIntersectOracle, MixedScalesWithTies) {
  // Every axis with its own power of two keeps the grid's contacts exact.
  check_family(400, 0.05, [&](Random& random) {
    HullPair pair = grid_pair(random, 2);
    for (WorldVertices* hull : {&pair.a, &pair.b}) {
      for (int i = 0; i < 8; ++i) {
        hull->x[i] = std::scalbn(hull->x[i], -1000);
        hull->z[i] = std::scalbn(hull->z[i], 1000);
      }
    }
    return pair;
  });
}

TEST(HullsIntersectOracle, TiesAcrossMoreThan125Bits) {
  // Exact contacts of the grid, with some coordinates 2^-200 or 2^200 times the others on the same axis.
  for (int exponent : {-200, 200}) {
    check_family(400, 0.05, [&](Random& random) {
      HullPair pair = mapped_grid_pair(random, 2, 3);
      for (WorldVertices* hull : {&pair.a, &pair.b}) {
        const int i = random_int(random, 0, 7);
        hull->x[i] = std::scalbn(hull->x[i], exponent);
        if (random_int(random, 0, 1) == 0) hull->y[i] = std::scalbn(hull->y[i], exponent);
      }
      return pair;
    });
  }
}

TEST(HullsIntersectOracle, ScatteredExponents) {
  for (const auto& [low, high] : {std::array{-1074, 1023}, std::array{-60, 60}, std::array{-20, 0}}) {
    check_family(300, 0.0, [low = low, high = high](Random& random) {
      HullPair pair = scattered_pair(random, low, high);
      // One vertex of B is on a segment of A to rounding, or beside a vertex by an ulp or not at all.
      const Vector3 p = pair.a.vertex(random_int(random, 0, 7)), q = pair.a.vertex(random_int(random, 0, 7));
      const Vector3 near = random_int(random, 0, 1) == 0
                               ? Vector3(p / 2.0 + q / 2.0)
                               : Vector3(p * (1.0 - random_int(random, 0, 2) * 0x1p-53));
      pair.b.x[0] = near.x(), pair.b.y[0] = near.y(), pair.b.z[0] = near.z();
      return pair;
    });
  }
}

TEST(HullsIntersectOracle, AFewUlpsAcrossAtAVertex) {
  check_family(800, 0.05, [&](Random& random) {
    const WorldVertices large = random_hexahedron(random);
    const WorldVertices tiny = scaled(random_hexahedron(random), -51);
    const double ulps = random_int(random, -2, 6);
    return HullPair{large, translated(tiny, large.vertex(random_int(random, 0, 7)) * (1.0 + ulps * 0x1p-52))};
  });
}

TEST(Orient3dOracle, NearlyCoplanarPoints) {
  Random random(3);
  int zero = 0;
  for (int i = 0; i < 20000; ++i) {
    const double extent = std::scalbn(1.0, random_int(random, -30, 30));
    const auto point = [&] {
      return Vector3{uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, -extent, extent)};
    };
    const Vector3 a = point(), b = point(), c = point();
    const double s = random_int(random, -8, 8) / 4.0, t = random_int(random, -8, 8) / 4.0;
    const Vector3 d = a + s * (b - a) + t * (c - a);
    const int expected = orient3d_sign_in_integers(a, b, c, d);
    zero += expected == 0;
    ASSERT_EQ(orient3d_sign(a, b, c, d), expected);
    ASSERT_EQ(orient3d_sign(b, a, c, d), -expected);
  }
  EXPECT_GT(zero, 100);
}

TEST(Orient3dOracle, AllScales) {
  Random random(4);
  const std::array<std::array<int, 2>, 6> ranges = {
      {{-1074, 1023}, {-1074, -1000}, {1000, 1023}, {-200, 200}, {-70, 0}, {-3, 3}}};
  for (const auto& [low, high] : ranges) {
    for (int i = 0; i < 3000; ++i) {
      const auto points = scattered_pair(random, low, high).a;
      const Vector3 a = points.vertex(0), b = points.vertex(1), c = points.vertex(2);
      const Vector3 d = i % 2 == 0 ? points.vertex(3) : Vector3(a / 2.0 + b / 2.0);
      ASSERT_EQ(orient3d_sign(a, b, c, d), orient3d_sign_in_integers(a, b, c, d))
          << std::hexfloat << a.transpose() << '\n'
          << b.transpose() << '\n'
          << c.transpose() << '\n'
          << d.transpose();
    }
  }
}

TEST(Orient3dOracle, SmallGrid) {
  Random random(5);
  const double greatest = std::numeric_limits<double>::max();
  for (int i = 0; i < 20000; ++i) {
    const auto point = [&] {
      const int x = random_int(random, -1, 1), y = random_int(random, -1, 1), z = random_int(random, -1, 1);
      return Vector3(x, y, z);
    };
    const Vector3 a = point(), b = point(), c = point(), d = point();
    const int expected = orient3d_sign_in_integers(a, b, c, d);
    ASSERT_EQ(orient3d_sign(a, b, c, d), expected);
    ASSERT_EQ(orient3d_sign(a * greatest, b * greatest, c * greatest, d * greatest), expected);
    const double least = std::numeric_limits<double>::denorm_min();
    ASSERT_EQ(orient3d_sign(a * least, b * least, c * least, d * least), expected);
  }
}

/// One direction asked about many points, in any order and again: heights are kept.
void check_directions(const HullPair& pair, Random& random, int& zeros) {
  std::array<Vector3, 16> points;
  for (int i = 0; i < 8; ++i) points[i] = pair.a.vertex(i), points[8 + i] = pair.b.vertex(i);
  DifferenceDeterminant determinant(points);
  for (int k = 0; k < 4; ++k) {
    const auto any = [&] { return random_int(random, 0, 15); };
    const int a = any(), b = any(), c = any();
    DirectionSigns signs(determinant, {a, b}, {a, c});
    for (int n = 0; n < 12; ++n) {
      const int p = any(), q = any();
      const int from_a = signs.sign({a, q});
      ASSERT_EQ(from_a, orient3d_sign_in_integers(points[a], points[b], points[c], points[q])) << text(pair);
      ASSERT_EQ(signs.sign({p, q}), DifferenceDeterminant(points).sign({a, b}, {a, c}, {p, q})) << text(pair);
      zeros += from_a == 0 && p != q;
    }
  }
}

TEST(DirectionSignsOracle, TouchingBoxesGridsAndScatteredPoints) {
  Random random(6);
  int zeros = 0;
  for (int i = 0; i < 1500; ++i) {
    check_directions(rotated_box_pair(random), random, zeros);
    check_directions(mapped_grid_pair(random, 3, random_int(random, 1, 20)), random, zeros);
    // Spans about where 64-bit, 128-bit and any integers take over.
    const int span = std::array{4, 7, 8, 9, 10, 60, 70, 72, 74, 400}[i % 10];
    check_directions(scattered_pair(random, -span, 0), random, zeros);
    HullPair grid = grid_pair(random, 3);
    for (auto* coordinates : {&grid.a.x, &grid.b.y})
      for (double& c : *coordinates) c = std::ldexp(c, -random_int(random, 0, span));
    check_directions(grid, random, zeros);
    if (HasFatalFailure()) return;
  }
  EXPECT_GT(zeros, 10000);
}

}  // namespace
}  // namespace touchstone::numerics
