#pragma once

#include <array>
#include <span>

#include "touchstone/contact_core/geometry/difference_determinant.hpp"

namespace touchstone::numerics {

/// Projections of two sets of eight points (0-7 and 8-15) on directions u x v, in doubles with error bounds:
/// decides which directions separate the sets, which do not, and which need exact arithmetic.
class ProjectionFilter {
 public:
  using Difference = DifferenceDeterminant::Difference;

  /// u x v of scaled points, and the sums of the magnitudes of each component's terms.
  struct Direction {
    Vector3 n;
    Vector3 magnitude;
  };
  struct Projections {
    std::array<double, 16> along;
    double low_a, high_a, low_b, high_b;
    /// A difference along[i] - along[j] beyond this has the sign of the exact one.
    double error;
  };

  /// @pre 16 finite points.
  explicit ProjectionFilter(std::span<const Vector3> points) noexcept;

  Direction direction(Difference u, Difference v) const noexcept;
  Projections project(const Direction& direction) const noexcept;
  /// Sign of u x v . w if certain, else 0.
  int certain_sign(const Direction& direction, Difference w) const noexcept;

 private:
  Vector3 difference(Difference u) const { return {x_[u.q] - x_[u.p], y_[u.q] - y_[u.p], z_[u.q] - z_[u.p]}; }

  alignas(64) std::array<double, 16> x_, y_, z_;                       // scaled
  alignas(64) std::array<double, 16> offset_x_, offset_y_, offset_z_;  // from point 0
  Vector3 extent_;                                                     // largest magnitude of the offsets
};

}  // namespace touchstone::numerics
