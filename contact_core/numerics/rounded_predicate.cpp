#include "touchstone/contact_core/numerics/rounded_predicate.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "touchstone/contact_core/geometry/big_integer.hpp"
#include "touchstone/contact_core/numerics/closest_point.hpp"

namespace touchstone::numerics {
namespace {

// A finite double is an integer below 2^2098 times 2^-1074: 33 limbs, one more for differences. The closest
// point's formulas are products of four differences at most, the comparison below is between their squares:
// 8 * 34 limbs, and a few that sums and product() may touch.
constexpr int kLimbs = 8 * 34 + 8;

/// BigInteger with the operators that closest_point.hpp asks for.
struct Integer {
  BigInteger<kLimbs> value;

  Integer() = default;
  Integer(int small) { assign_shifted(value, small < 0 ? -1 : 1, static_cast<unsigned>(std::abs(small)), 0); }
  Integer(const BigInteger<kLimbs>& v) : value(v) {}
};

Integer operator+(const Integer& a, const Integer& b) { return sum(a.value, b.value); }
Integer operator-(const Integer& a, const Integer& b) { return difference(a.value, b.value); }
Integer operator*(const Integer& a, const Integer& b) { return product<kLimbs>(a.value, b.value); }
Integer operator-(const Integer& a) {
  Integer out = a;
  out.value.sign = -out.value.sign;
  return out;
}
int compare(const Integer& a, const Integer& b) {
  if (a.value.sign != b.value.sign) return a.value.sign < b.value.sign ? -1 : 1;
  return a.value.sign * compare_magnitude(a.value, b.value);
}
bool operator==(const Integer& a, const Integer& b) { return compare(a, b) == 0; }
bool operator<(const Integer& a, const Integer& b) { return compare(a, b) < 0; }
bool operator>(const Integer& a, const Integer& b) { return compare(a, b) > 0; }
bool operator>=(const Integer& a, const Integer& b) { return compare(a, b) >= 0; }

/// Of the lowest bit that a double's mantissa can have.
int lowest_exponent(double value) {
  return value == 0.0 ? std::numeric_limits<int>::max() : std::ilogb(value) - 52;
}

Integer on_grid(double value, int grid) {
  Integer out = 0;
  if (value == 0.0) return out;
  const int exponent = lowest_exponent(value);
  const auto mantissa = static_cast<std::uint64_t>(std::scalbn(std::abs(value), -exponent));
  assign_shifted(out.value, value < 0.0 ? -1 : 1, mantissa, exponent - grid);
  return out;
}

using Hull = std::array<Vector<Integer>, 8>;

/// About A's vertex 0.
struct IntegerHulls {
  Hull a, b;
  Integer radius;  ///< the sum of both
};

int lowest_exponent(const WorldVertices& v) {
  int lowest = std::numeric_limits<int>::max();
  for (const auto* axis : {&v.x, &v.y, &v.z})
    for (const double value : *axis) lowest = std::min(lowest, lowest_exponent(value));
  return lowest;
}

void place_on_grid(const WorldVertices& v, const Vector3& origin, int grid, Hull& out) {
  const Vector<Integer> o{on_grid(origin.x(), grid), on_grid(origin.y(), grid), on_grid(origin.z(), grid)};
  for (int i = 0; i < 8; ++i)
    out[static_cast<std::size_t>(i)] =
        Vector<Integer>{on_grid(v.x[i], grid), on_grid(v.y[i], grid), on_grid(v.z[i], grid)} - o;
}

/// In doubles, about A's vertex 0: for a guess only.
std::array<Vector<double>, 8> relative(const WorldVertices& v, const Vector3& origin) {
  std::array<Vector<double>, 8> out;
  for (int i = 0; i < 8; ++i)
    out[static_cast<std::size_t>(i)] = {v.x[i] - origin.x(), v.y[i] - origin.y(), v.z[i] - origin.z()};
  return out;
}

}  // namespace

bool rounded_hulls_intersect(const WorldVertices& a, double radius_a, const WorldVertices& b,
                             double radius_b) noexcept {
  const Vector3 origin = a.vertex(0);
  const int grid = std::min(std::min(lowest_exponent(a), lowest_exponent(b)),
                            std::min(lowest_exponent(radius_a), lowest_exponent(radius_b)));
  IntegerHulls hulls;
  place_on_grid(a, origin, grid, hulls.a), place_on_grid(b, origin, grid, hulls.b);
  hulls.radius = on_grid(radius_a, grid) + on_grid(radius_b, grid);

  ClosestSimplex<double> guess;
  guess.size = 1;
  guess.vertices[0] = {0, 0};
  find_closest_point<double>(relative(a, origin), relative(b, origin), guess);
  ClosestSimplex<Integer> simplex;
  simplex.size = guess.size;
  simplex.vertices = guess.vertices;
  find_closest_point<Integer>(hulls.a, hulls.b, simplex);
  if (simplex.contains_origin) return true;
  // The distance is height / |direction|.
  const Integer radius_square = hulls.radius * hulls.radius;
  return radius_square * dot(simplex.direction, simplex.direction) >= simplex.height * simplex.height;
}

}  // namespace touchstone::numerics
