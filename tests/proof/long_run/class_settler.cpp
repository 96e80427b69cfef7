#include "touchstone/tests/proof/long_run/class_settler.hpp"

#include <gmpxx.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace touchstone::proof {
namespace {

/// Sixteen points: A's eight world vertices, then B's.
constexpr int kPoints = 16;
using Coordinates = std::array<std::array<double, kPoints>, 3>;  // [axis][point]

/// A candidate normal (p1 - p0) x (q1 - q0).
struct Direction {
  std::uint8_t p0, p1, q0, q1;
};

/// 2 * 56 triples of one set, 28 * 28 pairs of pairs.
std::vector<Direction> make_directions() {
  std::vector<Direction> all;
  const auto index = [](int i) { return static_cast<std::uint8_t>(i); };
  for (int set = 0; set < kPoints; set += 8)
    for (int i = set; i < set + 8; ++i)
      for (int j = i + 1; j < set + 8; ++j)
        for (int k = j + 1; k < set + 8; ++k) all.push_back({index(i), index(j), index(i), index(k)});
  for (int i = 0; i < 8; ++i)
    for (int j = i + 1; j < 8; ++j)
      for (int k = 8; k < 16; ++k)
        for (int l = k + 1; l < 16; ++l) all.push_back({index(i), index(j), index(k), index(l)});
  return all;
}

const std::vector<Direction>& directions() {
  static const std::vector<Direction> all = make_directions();
  return all;
}

/// ((R0 x + R1 y) + R2 z) + t, the project's definition of a world vertex, written out once more.
void place(const Hexahedron& solid, const Pose& X, int first, Coordinates& out) {
  for (int i = 0; i < 8; ++i) {
    const Vector3& v = solid.vertices()[i];
    for (int axis = 0; axis < 3; ++axis)
      out[axis][first + i] =
          ((X.R(axis, 0) * v.x() + X.R(axis, 1) * v.y()) + X.R(axis, 2) * v.z()) + X.p(axis);
  }
}

Coordinates place(const PosedSolids& solids) {
  Coordinates points;
  place(solids.a, solids.X_WA, 0, points);
  place(solids.b, solids.X_WB, 8, points);
  return points;
}

// ---- the filter

enum class Gap { apart, overlapping, unknown, no_direction };

/// Signs of gaps in doubles, each with a bound on its error.
///
/// Let u = 2^-53 and all quantities be those below, * marking exact values of the points as given. A
/// difference of two points has a relative error of u. A component of n = e x f is the difference of two
/// products of two such: each product has (1+u)^3, the difference another (1+u), so |n_k - n_k*| <= g4 P_k
/// with P_k the sum of the two products' magnitudes and g4 = 4u / (1 - 4u). A projection (n0 d0 + n1 d1) + n2
/// d2 of a difference d = p - origin has (1+u)^4 on each term besides that of n, so with |d_k| <= D_k it is
/// off by at most g8 sum P_k D_k (both exact magnitudes, which the computed ones reach but for (1+u)^6). g8
/// (1+u)^12 < 9 u; `bound` uses 16 u, which also covers its own rounding. The gap is a difference of two
/// projections: 2 bounds, and u times the two, each at most sum P_k D_k (1 + 9 u): 3 bounds cover it.
/// Underflow: coordinates are first scaled to at most 1 and refused if one that is not 0 falls below 2^-900,
/// so scaling and differences are exact but for u. Each of the at most 30 roundings in a projection may then
/// be off by 2^-1075 more, times at most 8 by later factors: kUnderflow covers them.
class Filter {
 public:
  explicit Filter(const Coordinates& points) {
    double largest = 0.0, least = 1.0;
    for (const auto& axis : points)
      for (const double c : axis) largest = std::max(largest, std::abs(c));
    usable_ = largest > 0.0;
    if (!usable_) return;
    const int exponent = -std::ilogb(largest) - 1;
    for (int axis = 0; axis < 3; ++axis) {
      for (int i = 0; i < kPoints; ++i) {
        const double c = std::scalbn(points[axis][i], exponent);
        if (points[axis][i] != 0.0) least = std::min(least, std::abs(c));
        points_[axis][i] = c;
      }
      reach_[axis] = 0.0;
      for (int i = 0; i < kPoints; ++i) {
        from_origin_[axis][i] = points_[axis][i] - points_[axis][0];
        reach_[axis] = std::max(reach_[axis], std::abs(from_origin_[axis][i]));
      }
    }
    usable_ = least >= kLeast;
  }

  bool usable() const { return usable_; }

  Gap gap(const Direction& direction) const {
    double e[3], f[3], n[3], bound = kUnderflow;
    for (int k = 0; k < 3; ++k) {
      e[k] = points_[k][direction.p1] - points_[k][direction.p0];
      f[k] = points_[k][direction.q1] - points_[k][direction.q0];
    }
    for (int k = 0; k < 3; ++k) {
      const double left = e[(k + 1) % 3] * f[(k + 2) % 3], right = e[(k + 2) % 3] * f[(k + 1) % 3];
      n[k] = left - right;
      bound += 16 * kRoundoff * ((std::abs(left) + std::abs(right)) * reach_[k]);
    }
    std::array<double, kPoints> at;
    for (int i = 0; i < kPoints; ++i)
      at[i] = (n[0] * from_origin_[0][i] + n[1] * from_origin_[1][i]) + n[2] * from_origin_[2][i];
    const auto [low_a, high_a] = range(at.data());
    const auto [low_b, high_b] = range(at.data() + 8);
    const double larger_gap = std::max(low_b - high_a, low_a - high_b);
    if (larger_gap > 3 * bound) return Gap::apart;
    if (larger_gap < -3 * bound) return Gap::overlapping;
    return vanishes(e, f) ? Gap::no_direction : Gap::unknown;
  }

 private:
  /// e x f is exactly zero because every product in it has a factor 0, and a difference is 0 only where it is
  /// exactly.
  static bool vanishes(const double* e, const double* f) {
    for (int k = 0; k < 3; ++k) {
      const int l = (k + 1) % 3, m = (k + 2) % 3;
      if ((e[l] != 0.0 && f[m] != 0.0) || (e[m] != 0.0 && f[l] != 0.0)) return false;
    }
    return true;
  }

  static constexpr double kRoundoff = 0x1p-53;
  static constexpr double kLeast = 0x1p-900;
  static constexpr double kUnderflow = 0x1p-1000;

  static std::array<double, 2> range(const double* v) {
    double low[4], high[4];
    for (int i = 0; i < 4; ++i) {
      low[i] = v[i] < v[i + 4] ? v[i] : v[i + 4];
      high[i] = v[i] < v[i + 4] ? v[i + 4] : v[i];
    }
    return {std::min(std::min(low[0], low[1]), std::min(low[2], low[3])),
            std::max(std::max(high[0], high[1]), std::max(high[2], high[3]))};
  }

  bool usable_ = false;
  Coordinates points_{}, from_origin_{};
  std::array<double, 3> reach_{};
};

// ---- integers

/// The points as whole multiples of one power of two, relative to the first.
class Integers {
 public:
  explicit Integers(const Coordinates& points) {
    int least = 2000;
    for (const auto& axis : points) {
      for (const double c : axis) {
        int exponent = 0;
        if (c != 0.0) std::frexp(c, &exponent), least = std::min(least, exponent);
      }
    }
    for (int axis = 0; axis < 3; ++axis) {
      for (int i = 0; i < kPoints; ++i) points_[axis][i] = whole(points[axis][i], least);
      for (int i = kPoints - 1; i >= 0; --i) points_[axis][i] -= points_[axis][0];
    }
  }

  struct Answer {
    int gap_sign;  ///< of the larger of the gaps along +n and -n
    bool is_zero;  ///< n is; gap_sign means nothing
    bool extends;  ///< A or B has points at different heights along n
  };

  Answer gap(const Direction& direction) {
    for (int k = 0; k < 3; ++k) {
      e_[k] = points_[k][direction.p1] - points_[k][direction.p0];
      f_[k] = points_[k][direction.q1] - points_[k][direction.q0];
    }
    bool zero = true;
    for (int k = 0; k < 3; ++k) {
      n_[k] = e_[(k + 1) % 3] * f_[(k + 2) % 3];
      n_[k] -= e_[(k + 2) % 3] * f_[(k + 1) % 3];
      zero = zero && sgn(n_[k]) == 0;
    }
    if (zero) return {0, true, false};
    for (int i = 0; i < kPoints; ++i) {
      at_[i] = n_[0] * points_[0][i];
      at_[i] += n_[1] * points_[1][i];
      at_[i] += n_[2] * points_[2][i];
    }
    const auto [low_a, high_a] = std::minmax_element(at_.begin(), at_.begin() + 8);
    const auto [low_b, high_b] = std::minmax_element(at_.begin() + 8, at_.end());
    const int sign = std::max(cmp(*low_b, *high_a), cmp(*low_a, *high_b));
    return {sign > 0 ? 1 : sign < 0 ? -1 : 0, false, *low_a != *high_a || *low_b != *high_b};
  }

 private:
  /// c * 2^(53 - exponent), a whole number for every double whose own exponent is at least `exponent`.
  static mpz_class whole(double c, int exponent) {
    if (c == 0.0) return 0;
    int own = 0;
    const double mantissa = std::frexp(c, &own);
    mpz_class value(std::ldexp(mantissa, 53));  // a whole double: exact
    value <<= static_cast<unsigned long>(own - exponent);
    return value;
  }

  std::array<std::array<mpz_class, kPoints>, 3> points_;
  std::array<mpz_class, 3> e_, f_, n_;
  std::array<mpz_class, kPoints> at_;
};

/// Apart along any direction settles the pair. Else it is in contact, and its interiors meet unless the gap
/// along some direction is 0: but only if the directions include all facet normals, which takes a difference
/// of full rank, proved by a direction n = e x f along which one of the sets extends (it is not in the span
/// of e and f).
SettledClass settle_in_integers(const Coordinates& points, const std::vector<Direction>& open,
                                bool full_rank) {
  SettledClass settled;
  settled.directions_in_integers = static_cast<int>(open.size());
  Integers integers(points);
  bool touches = false;
  for (const Direction& direction : open) {
    const Integers::Answer gap = integers.gap(direction);
    if (gap.is_zero) continue;
    if (gap.gap_sign > 0) {
      settled.pair_class = PairClass::separated;
      return settled;
    }
    touches = touches || gap.gap_sign == 0;
    full_rank = full_rank || gap.extends;
  }
  if (full_rank) settled.pair_class = touches ? PairClass::touching : PairClass::penetrating;
  return settled;
}

}  // namespace

SettledClass settle_class(const PosedSolids& solids) {
  const Coordinates points = place(solids);
  const Filter filter(points);
  if (!filter.usable()) return settle_in_integers(points, directions(), false);
  std::vector<Direction> open;
  bool full_rank = false;
  for (const Direction& direction : directions()) {
    switch (filter.gap(direction)) {
      case Gap::apart:
        return {PairClass::separated, 0};
      case Gap::overlapping:
        full_rank = true;
        break;
      case Gap::no_direction:
        break;
      case Gap::unknown:
        open.push_back(direction);
    }
  }
  if (open.empty() && full_rank) return {PairClass::penetrating, 0};
  return settle_in_integers(points, open, full_rank);
}

SettledClass settle_class_in_integers(const PosedSolids& solids) {
  return settle_in_integers(place(solids), directions(), false);
}

}  // namespace touchstone::proof
