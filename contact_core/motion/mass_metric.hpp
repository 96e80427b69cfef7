#pragma once

#include "touchstone/contact_core/geometry/hexahedron.hpp"

/// @file
/// The distance of a rigid body from its goal in its mass metric at uniform density, divided by its mass. For
/// a displacement dc of its centre of mass and a turn w (axis times angle) its square is |dc|^2 + w . J w
/// [m^2].

namespace touchstone {

/// Integrals over a solid, or several. Sums of moments in one frame are the moments of the whole.
struct MassMoments {
  using MovesByBits = MassMoments;  ///< see kMovesByBits

  double volume = 0.0;               ///< [m3]
  Vector3 first = Vector3::Zero();   ///< of x [m4]
  Matrix3 second = Matrix3::Zero();  ///< of x x^T [m5]

  MassMoments& operator+=(const MassMoments& other);
};

/// The moments of the solid's hull, in the solid's frame; a warped face is cut along the hull's diagonal.
/// Spheres, capsules, rounded boxes and plates have closed forms. @throws InputError for other rounded
/// solids.
MassMoments mass_moments(const Hexahedron& solid);
/// The moments of the hull of its vertices alone, a rounded solid's core; zero where that is flat.
MassMoments core_moments(const Hexahedron& solid);
/// Moments in frame A from those in frame B.
MassMoments transform(const Pose& X_AB, const MassMoments& moments_B);

/// The metric |dc|^2 + w . J w.
struct MassMetric {
  Vector3 centre = Vector3::Zero();  ///< of mass, in the frame of the moments
  Matrix3 J = Matrix3::Identity();   ///< inertia about the centre over mass, positive definite [m2]
};

/// @pre moments.volume > 0.
MassMetric mass_metric(const MassMoments& moments);

/// Velocity of a body's centre of mass and its angular velocity, or a displacement and a turn [m, rad].
struct Twist {
  Vector3 v = Vector3::Zero();
  Vector3 w = Vector3::Zero();
};

/// Both parts scaled.
inline Twist operator*(double factor, const Twist& twist) { return {factor * twist.v, factor * twist.w}; }

/// @param J_W in the frame that the twists are in.
double inner_product(const Matrix3& J_W, const Twist& a, const Twist& b);

/// A lower bound of J's eigenvalues [m2]; 4/9 of them where all three are equal. A turn whose distance in the
/// metric is d is no longer than d / sqrt of it [rad].
double least_inertia(const Matrix3& J);

}  // namespace touchstone
