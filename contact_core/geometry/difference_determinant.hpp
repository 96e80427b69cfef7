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

/// det[a b c], where every component is a difference of two coordinates, rounded once.
inline FilteredDeterminant filtered_determinant(const Vector3& a, const Vector3& b, const Vector3& c) {
  const double xp = b.y() * c.z(), xn = b.z() * c.y();
  const double yp = b.z() * c.x(), yn = b.x() * c.z();
  const double zp = b.x() * c.y(), zn = b.y() * c.x();
  const double ax = std::abs(a.x()), ay = std::abs(a.y()), az = std::abs(a.z());
  const double permanent = (ax * (std::abs(xp) + std::abs(xn)) + ay * (std::abs(yp) + std::abs(yn))) +
                           az * (std::abs(zp) + std::abs(zn));
  return {(a.x() * (xp - xn) + a.y() * (yp - yn)) + a.z() * (zp - zn), 0x1p-49 * permanent,
          0x1p-1000 * (((1.0 + ax) + ay) + az)};
}

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
  Vector3 rounded(Difference u) const { return points_[u.q] - points_[u.p]; }
  int unfiltered_sign(Difference u, Difference v, Difference w, const FilteredDeterminant& det) noexcept;
  int exact_sign(Difference u, Difference v, Difference w) noexcept;
  int exact_sign_any_span(Difference u, Difference v, Difference w) const noexcept;
  void prepare_integers() noexcept;
  IntegerVector integer_difference(Difference u) const;

  std::span<const Vector3> points_;
  bool integers_ready_ = false;
  bool integers_fit_ = false;         // all coordinates on their axis's unit are below 2^125
  std::array<int, 3> unit_exponent_;  // per axis: of the least significant bit of any coordinate
  std::array<IntegerVector, kMaxPoints> integers_;  // coordinates in units of 2^unit_exponent_; if they fit
};

}  // namespace touchstone::numerics
