#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "contact_core/geometry/vector.hpp"
#include "contact_core/numerics/fixed_integer.hpp"

namespace touchstone::numerics {

/// Signs of determinants of differences of up to 16 given points, exact for every finite double. A
/// floating-point filter decides almost all; what it leaves goes to integers on a common exponent, made when
/// first needed. No heap. Objects are for one thread.
class DifferenceDeterminant {
 public:
  static constexpr int kMaxPoints = 16;
  /// q - p, as indices of points.
  struct Difference {
    int p, q;
  };

  /// @pre at most kMaxPoints, all finite; they are copied.
  explicit DifferenceDeterminant(std::span<const Vector3> points);

  const Vector3& point(int i) const { return points_[i]; }
  /// Points scaled by a power of two to at most 1 in magnitude. Coordinates below 2^-1022 of the largest are
  /// rounded by up to 2^-1074 here; exact answers do not use them.
  const Vector3& scaled(int i) const { return scaled_[i]; }

  /// Sign of det [u v w].
  int sign(Difference u, Difference v, Difference w);

  /// Bit i: det [u v (point first + i) - (point base)] is certainly or exactly > 0 (< 0).
  struct Sides {
    unsigned above = 0;
    unsigned below = 0;
  };
  /// Of those of the eight points from `first` on that `wanted` names.
  Sides sides(Difference u, Difference v, int base, int first, unsigned wanted);
  /// Sign of component `axis` of u x v.
  int cross_sign(Difference u, Difference v, int axis);
  /// Sign of component `axis` of u.
  int component_sign(Difference u, int axis) const;
  bool is_zero(Difference u) const;

 private:
  struct Integers;
  int exact_sign(Difference u, Difference v, Difference w);
  int short_sign(Difference u, Difference v, Difference w) const;
  void prepare_exponent();
  void prepare_short();

  std::array<Vector3, kMaxPoints> points_;
  std::array<Vector3, kMaxPoints> scaled_;
  int count_;
  int lowest_exponent_ = 0;  // of the least significant bit of any coordinate
  bool exponent_known_ = false;
  bool is_short_ = false;  // all coordinates are integers below 2^125 times 2^lowest_exponent_
  std::array<std::array<Int128, 3>, kMaxPoints> short_;
};

/// What |det| of computed differences of scaled points must exceed for its sign to be certain; `permanent` is
/// the same sum of products with every term and difference taken in magnitude, see the .cpp.
double determinant_error(double permanent);

}  // namespace touchstone::numerics
