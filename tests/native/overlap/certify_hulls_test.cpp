#include <gtest/gtest.h>

#include <cmath>

#include "touchstone/contact_core/native/overlap/gjk.hpp"
#include "touchstone/contact_core/numerics/exact_predicates.hpp"
#include "touchstone/examples/measures/common/random.hpp"

// certify_hulls() on pairs whose products underflow: unknown or right, never wrong. The narrowphase scales
// such pairs first; the bound must hold without that.

namespace touchstone::native {
namespace {

using measures::Random;

WorldVertices turned_box(Random& random) {
  const Matrix3 R = measures::random_rotation(random);
  const Vector3 half = measures::uniform_vector(random, 0.2, 0.5);
  WorldVertices out;
  for (int i = 0; i < 8; ++i) {
    const Vector3 p =
        R * Vector3(i & 4 ? half.x() : -half.x(), i & 2 ? half.y() : -half.y(), i & 1 ? half.z() : -half.z());
    out.x[i] = p.x(), out.y[i] = p.y(), out.z[i] = p.z();
  }
  return out;
}

WorldVertices placed(const WorldVertices& v, const Vector3& p, double size) {
  WorldVertices out;
  for (int i = 0; i < 8; ++i) {
    out.x[i] = (v.x[i] + p.x()) * size, out.y[i] = (v.y[i] + p.y()) * size;
    out.z[i] = (v.z[i] + p.z()) * size;
  }
  return out;
}

/// Where along `way` b is within 2^-halvings of touching a.
double touching_place(const WorldVertices& a, const WorldVertices& b, const Vector3& way,
                      std::uint32_t halvings) {
  double meets = 0.0, apart = 2.0;
  for (std::uint32_t i = 0; i < halvings; ++i) {
    const double middle = 0.5 * (meets + apart);
    (numerics::hulls_intersect(a, placed(b, middle * way, 1.0)) ? meets : apart) = middle;
  }
  return 0.5 * (meets + apart);
}

TEST(CertifyHulls, IsNeverWrongWhereProductsUnderflow) {
  for (const double size : {1e-104, 1e-107, 1e-108, 1e-160, 1e-161, 1e-162, 1e-310}) {
    int meeting = 0;
    for (std::uint64_t seed = 0; seed < 1000; ++seed) {
      Random random(measures::mix_seed(seed, 1, 0));
      const WorldVertices a_1 = turned_box(random), b_1 = turned_box(random);
      const Vector3 way = measures::random_direction(random);
      const double place = touching_place(a_1, b_1, way, 1 + random.below(20));
      const WorldVertices a = placed(a_1, Vector3::Zero(), size), b = placed(b_1, place * way, size);
      const bool meet = numerics::hulls_intersect(a, b);
      meeting += meet;
      HullPair pair;
      shift_to_common_origin(a, b, pair);
      for (const double length : {1.0, size}) {
        const Certified found = certify_hulls(pair, length * way);
        EXPECT_NE(found, meet ? Certified::separated : Certified::overlapping) << size << " seed " << seed;
      }
    }
    EXPECT_GT(meeting, 200) << size;
    EXPECT_LT(meeting, 950) << size;
  }
}

}  // namespace
}  // namespace touchstone::native
