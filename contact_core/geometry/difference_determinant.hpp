#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <span>

#include "touchstone/contact_core/geometry/fixed_integer.hpp"
#include "touchstone/contact_core/geometry/vector.hpp"

namespace touchstone::numerics {

/// A determinant in doubles and what its magnitude must exceed for its sign to be certain; see the .cpp.
/// Overflow leaves an infinite or NaN error, which nothing exceeds.
struct FilteredDeterminant {
  double value;
  double relative_error;  ///< of the roundings, relative to the sum of all terms' magnitudes
  double absolute_error;  ///< of underflow

  bool is_certain() const { return std::abs(value) > relative_error + absolute_error; }
  int sign() const { return value > 0.0 ? 1 : -1; }
};

/// b x c, and the sums of the magnitudes of each component's terms.
struct FilteredCross {
  Vector3 n;
  Vector3 magnitude;
};

inline FilteredCross filtered_cross(const Vector3& b, const Vector3& c) {
  const double xp = b.y() * c.z(), xn = b.z() * c.y();
  const double yp = b.z() * c.x(), yn = b.x() * c.z();
  const double zp = b.x() * c.y(), zn = b.y() * c.x();
  return {{xp - xn, yp - yn, zp - zn},
          {std::abs(xp) + std::abs(xn), std::abs(yp) + std::abs(yn), std::abs(zp) + std::abs(zn)}};
}

/// det[a b c] of a and b x c, where every component is a difference of two coordinates, rounded once.
inline FilteredDeterminant filtered_determinant(const Vector3& a, const FilteredCross& bc) {
  const double ax = std::abs(a.x()), ay = std::abs(a.y()), az = std::abs(a.z());
  const double permanent = (ax * bc.magnitude.x() + ay * bc.magnitude.y()) + az * bc.magnitude.z();
  return {(a.x() * bc.n.x() + a.y() * bc.n.y()) + a.z() * bc.n.z(), 0x1p-49 * permanent,
          0x1p-1000 * (((1.0 + ax) + ay) + az)};
}

inline FilteredDeterminant filtered_determinant(const Vector3& a, const Vector3& b, const Vector3& c) {
  return filtered_determinant(a, filtered_cross(b, c));
}

class DirectionSigns;

/// Signs of determinants of differences of given points, exact for every finite double. A floating-point
/// filter decides almost all; what it leaves goes to integers, made when first needed. No heap. An object is
/// for one thread.
class DifferenceDeterminant {
 public:
  static constexpr int kMaxPoints = 16;
  /// q - p, as indices of points.
  struct Difference {
    int p, q;
  };

  /// @pre at most kMaxPoints, all finite; they must outlive this object.
  explicit DifferenceDeterminant(std::span<const Vector3> points) noexcept : points_(points) {}

  const Vector3& point(int i) const { return points_[i]; }

  /// Sign of det[u v w].
  int sign(Difference u, Difference v, Difference w) noexcept {
    const FilteredDeterminant det = filtered_determinant(rounded(u), rounded(v), rounded(w));
    return det.is_certain() ? det.sign() : unfiltered_sign(u, v, w, det);
  }
  /// Sign of component `axis` of u x v.
  int cross_sign(Difference u, Difference v, int axis) noexcept;
  /// Sign of component `axis` of u.
  int component_sign(Difference u, int axis) const noexcept {
    const double p = points_[u.p](axis), q = points_[u.q](axis);
    return q > p ? 1 : q < p ? -1 : 0;
  }
  bool is_zero(Difference u) const noexcept { return points_[u.p] == points_[u.q]; }

 private:
  friend DirectionSigns;

  Vector3 rounded(Difference u) const { return points_[u.q] - points_[u.p]; }
  /// Where the filter was not certain: what needs no integers, or kUncertain.
  int wide_filter(Difference u, Difference v, Difference w, const FilteredDeterminant& det) const noexcept;
  int unfiltered_sign(Difference u, Difference v, Difference w, const FilteredDeterminant& det) noexcept;
  int exact_sign(Difference u, Difference v, Difference w) noexcept;
  int exact_sign_any_span(Difference u, Difference v, Difference w) const noexcept;
  void prepare_integers() noexcept;
  void take_differences() noexcept;
  IntegerVector integer_difference(Difference u) const;

  std::span<const Vector3> points_;
  bool integers_ready_ = false;
  bool integers_fit_ = false;         // all coordinates on their axis's unit are below 2^125
  bool are_narrow_ = false;           // all differences are below 2^61
  std::array<int, 3> unit_exponent_;  // per axis: of the least significant bit of any coordinate
  /// If they fit: differences from point 0 in the largest power of two, an axis, that leaves integers.
  std::array<IntegerVector, kMaxPoints> integers_;
};

/// Signs of det[u v w] for one u and v and many w, exact: u x v is made once, and where doubles do not
/// decide, the exact height of each point along it is, too.
class DirectionSigns {
 public:
  using Difference = DifferenceDeterminant::Difference;

  /// @pre `determinant` outlives this object.
  DirectionSigns(DifferenceDeterminant& determinant, Difference u, Difference v) noexcept
      : determinant_(determinant),
        u_(u),
        v_(v),
        cross_(filtered_cross(determinant.rounded(u), determinant.rounded(v))) {}

  /// Sign of det[u v w].
  int sign(Difference w) noexcept {
    if ((known_ >> w.p & known_ >> w.q & 1u) != 0) return compare<6>(heights_[w.q], heights_[w.p]);
    const FilteredDeterminant det = filtered_determinant(determinant_.rounded(w), cross_);
    return det.is_certain() ? det.sign() : unfiltered_sign(w, det);
  }

 private:
  using Height = Limbs<6>;

  int unfiltered_sign(Difference w, const FilteredDeterminant& det) noexcept;
  void prepare_direction() noexcept;
  const Height& height(int point) noexcept;

  DifferenceDeterminant& determinant_;
  Difference u_, v_;
  FilteredCross cross_;
  unsigned known_ = 0;  // a bit for each point whose height is there
  bool is_ready_ = false;
  IntegerVector narrow_;  // u x v, where all differences are narrow
  WideVector wide_;       // else
  std::array<Height, DifferenceDeterminant::kMaxPoints> heights_;
};

}  // namespace touchstone::numerics
