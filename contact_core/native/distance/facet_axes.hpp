#pragma once

#include <array>

#include "touchstone/contact_core/native/common/hull_pair.hpp"
#include "touchstone/contact_core/native/solids/solid_features.hpp"

namespace touchstone::native {

/// A unit direction from A to B and the hulls' separation along it.
struct SeparationAxis {
  double separation;  ///< negative: they overlap by that much
  Vector3 n;
};

/// The axis of the greatest separation among all facet normals of the Minkowski difference: faces of A, faces
/// of B, one edge of each. For pairs that overlap this is the minimal translation. Faces are not preferred:
/// an edge pair wins when it is better by more than rounding (2 u * extent), which is all that ties are
/// decided by.
///
/// Error. Any direction gives a lower bound of the separation, so only missing the best one hurts. Normals
/// are cofactor(R) * local normal, exact facet normals of p + R x also where R is off orthonormal; they and
/// the rotated edges are off by a few u. The cross product of edges at a small angle theta is formed from
/// exact products, so it is square to the rotated edges; their rounding turns it by u / theta, but only about
/// the common edge direction; the facet it belongs to is only theta * |edge| wide that way, so the separation
/// along it changes by u * |edge|, or a neighbouring facet's normal, which is among the candidates, lies as
/// near. Together with the vertices' rounding: a few u * max(|world coordinate|, size).
SeparationAxis best_facet_axis(const HullPair& pair, const SolidFeatures& a, const Matrix3& R_WA,
                               const SolidFeatures& b, const Matrix3& R_WB);

/// The candidates within rounding of the best, for a choice by more than their separation.
struct NearTies {
  int count = 0;
  std::array<SeparationAxis, 8> axes;
};
void find_near_ties(const HullPair& pair, const SolidFeatures& a, const Matrix3& R_WA, const SolidFeatures& b,
                    const Matrix3& R_WB, double best_separation, NearTies& ties);

/// The matrix that carries plane normals along with R: its columns are R1 x R2, R2 x R0, R0 x R1.
Matrix3 cofactor(const Matrix3& R);

}  // namespace touchstone::native
