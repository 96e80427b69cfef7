#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "touchstone/contact_core/fit/space/six_planes.hpp"

// Private to contact_core/fit.

namespace touchstone::fit {

/// Hexahedra that keep to what is asked. What is within one of them keeps to it, too: rounds of a search
/// shrink them. It saves looks; whole covers are measured without it.
class AcceptedSolids {
 public:
  /// @param largest_coordinate of the mesh [m]
  explicit AcceptedSolids(double largest_coordinate) : margin_(kMargin * largest_coordinate) {}

  void add(const SixPlanes& solid) { accepted_.push_back(solid); }

  /// Whether one of them holds all of its corners, but for rounding.
  bool holds(const SixPlanes& solid) const {
    const std::array<Vector3, 8> corners = solid.corners();
    return std::any_of(accepted_.begin(), accepted_.end(), [&](const SixPlanes& other) {
      return std::all_of(corners.begin(), corners.end(),
                         [&](const Vector3& p) { return other.above(p) <= margin_; });
    });
  }

 private:
  /// Computed corners of an oblique solid are some roundings, 2^-53, above its own planes. Planes further out
  /// by this move corners by ten times as much (SixPlanes::kLeastDeterminant): less than the 2^-42 that
  /// bounds of an excess add for rounding.
  static constexpr double kMargin = 0x1p-46;

  double margin_;
  std::vector<SixPlanes> accepted_;
};

}  // namespace touchstone::fit
