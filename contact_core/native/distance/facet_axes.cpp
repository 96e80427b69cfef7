#include "touchstone/contact_core/native/distance/facet_axes.hpp"

#include <array>
#include <cmath>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/native/common/double_double.hpp"

namespace touchstone::native {
namespace {

/// Edges whose sine is below this are parallel to rounding: their cross product carries no direction.
constexpr double kNoDirection = 4 * kRoundoff;
/// Below this sine the cross product is formed from exact products: rounded ones would leave the axis off the
/// edges' common direction by u / sine, and the separation off by that times the edges' length.
constexpr double kNearlyParallel = 0x1p-4;
/// Separations closer than this many u * extent are equal.
constexpr double kTie = 2;

/// Of +axis and -axis the one with the greater separation.
SeparationAxis along(const HullPair& pair, const Vector3& axis, double length) {
  const Interval on_a = project(pair.a, axis);
  const Interval on_b = project(pair.b, axis);
  const double ahead = on_b.low - on_a.high;
  const double behind = on_a.low - on_b.high;
  const bool forward = ahead >= behind;
  return {(forward ? ahead : behind) / length, (forward ? 1.0 / length : -1.0 / length) * axis};
}

template <class Visit>
void visit_axes(const HullPair& pair, const SolidFeatures& a, const Matrix3& R_WA, const SolidFeatures& b,
                const Matrix3& R_WB, const Visit& visit) {
  const Matrix3 N_WA = cofactor(R_WA), N_WB = cofactor(R_WB);
  // Facets of B - A that are facets of A, and of B.
  for (int i = 0; i < a.normal_count; ++i) {
    const Vector3 axis = rotate(N_WA, a.normals[i]);
    visit(along(pair, axis, norm(axis)));
  }
  for (int j = 0; j < b.normal_count; ++j) {
    const Vector3 axis = rotate(N_WB, b.normals[j]);
    visit(along(pair, axis, norm(axis)));
  }
  // Facets across an edge of each; those of nearly parallel edges need a cross product without cancellation.
  std::array<Vector3, 18> edges_b;
  for (int j = 0; j < b.edge_count; ++j) edges_b[j] = rotate(R_WB, b.edges[j]);
  for (int i = 0; i < a.edge_count; ++i) {
    const Vector3 edge_a = rotate(R_WA, a.edges[i]);
    for (int j = 0; j < b.edge_count; ++j) {
      Vector3 axis = cross(edge_a, edges_b[j]);
      double length = norm(axis);
      if (length < kNearlyParallel) {
        axis = accurate_cross(edge_a, edges_b[j]);
        length = norm(axis);
      }
      if (length > kNoDirection) visit(along(pair, axis, length));
    }
  }
}

}  // namespace

Matrix3 cofactor(const Matrix3& R) {
  Matrix3 out;
  for (int i = 0; i < 3; ++i) out.col(i) = cross(R.col((i + 1) % 3), R.col((i + 2) % 3));
  return out;
}

SeparationAxis best_facet_axis(const HullPair& pair, const SolidFeatures& a, const Matrix3& R_WA,
                               const SolidFeatures& b, const Matrix3& R_WB) {
  SeparationAxis best{-kInfinity, Vector3::UnitX()};
  const double tie = kTie * kRoundoff * pair.extent;
  visit_axes(pair, a, R_WA, b, R_WB, [&](const SeparationAxis& axis) {
    if (axis.separation > best.separation + tie) best = axis;
  });
  return best;
}

void find_near_ties(const HullPair& pair, const SolidFeatures& a, const Matrix3& R_WA, const SolidFeatures& b,
                    const Matrix3& R_WB, double best_separation, NearTies& ties) {
  ties.count = 0;
  const double least = best_separation - 8 * kTie * kRoundoff * pair.extent;
  visit_axes(pair, a, R_WA, b, R_WB, [&](const SeparationAxis& axis) {
    if (axis.separation >= least && ties.count < static_cast<int>(ties.axes.size()))
      ties.axes[ties.count++] = axis;
  });
}

}  // namespace touchstone::native
