#include "contact_core/native/facet_axes.hpp"

#include <array>
#include <cmath>
#include <limits>

namespace touchstone::native {
namespace {

/// Edges whose sine is below this are parallel to rounding: their cross product carries no direction.
constexpr double kNoDirection = 4 * kRoundoff;

struct Candidates {
  const HullPair& pair;
  SeparationAxis best{-std::numeric_limits<double>::infinity(), Vector3::UnitX()};

  void consider(const Vector3& axis, double length) {
    const Interval on_a = project(pair.a, axis);
    const Interval on_b = project(pair.b, axis);
    const double ahead = on_b.low - on_a.high;
    const double behind = on_a.low - on_b.high;
    const bool forward = ahead >= behind;
    const double separation = (forward ? ahead : behind) / length;
    if (!(separation > best.separation + 2 * kRoundoff * pair.extent)) return;
    best.separation = separation;
    best.n = forward ? Vector3(axis / length) : Vector3(-axis / length);
  }
};

}  // namespace

Matrix3 cofactor(const Matrix3& R) {
  Matrix3 out;
  for (int i = 0; i < 3; ++i) out.col(i) = cross(R.col((i + 1) % 3), R.col((i + 2) % 3));
  return out;
}

SeparationAxis best_facet_axis(const HullPair& pair, const SolidFeatures& a, const Matrix3& R_WA,
                               const SolidFeatures& b, const Matrix3& R_WB) {
  Candidates candidates{pair};
  const Matrix3 N_WA = cofactor(R_WA), N_WB = cofactor(R_WB);
  for (int i = 0; i < a.normal_count; ++i) {
    const Vector3 axis = rotate(N_WA, a.normals[i]);
    candidates.consider(axis, norm(axis));
  }
  for (int j = 0; j < b.normal_count; ++j) {
    const Vector3 axis = rotate(N_WB, b.normals[j]);
    candidates.consider(axis, norm(axis));
  }
  std::array<Vector3, 18> edges_b;
  for (int j = 0; j < b.edge_count; ++j) edges_b[j] = rotate(R_WB, b.edges[j]);
  for (int i = 0; i < a.edge_count; ++i) {
    const Vector3 edge_a = rotate(R_WA, a.edges[i]);
    for (int j = 0; j < b.edge_count; ++j) {
      const Vector3 axis = cross(edge_a, edges_b[j]);
      const double length = norm(axis);
      if (length > kNoDirection) candidates.consider(axis, length);
    }
  }
  return candidates.best;
}

}  // namespace touchstone::native
