#pragma once

#include <array>

#include "touchstone/contact_core/geometry/difference_determinant.hpp"
#include "touchstone/contact_core/geometry/hexahedron.hpp"

namespace touchstone::numerics {

/// A pair of hulls for exact predicates, which may be asked one after another: the integers of its vertices
/// are made once, by the first that needs them. For one thread.
struct ExactPair {
  static constexpr int kFirstOfB = 8;

  const WorldVertices& a;
  const WorldVertices& b;
  std::array<Vector3, 16> points;  ///< 0-7 are A's, 8-15 B's
  DifferenceDeterminant determinant{points};

  /// @pre finite vertices, which outlive this object.
  ExactPair(const WorldVertices& a_W, const WorldVertices& b_W) noexcept : a(a_W), b(b_W) {
    for (int i = 0; i < 8; ++i) points[i] = a.vertex(i), points[kFirstOfB + i] = b.vertex(i);
  }
  ExactPair(const ExactPair&) = delete;
  ExactPair& operator=(const ExactPair&) = delete;
};

}  // namespace touchstone::numerics
