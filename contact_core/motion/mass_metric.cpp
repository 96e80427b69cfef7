#include "touchstone/contact_core/motion/mass_metric.hpp"

#include <algorithm>

#include "touchstone/contact_core/geometry/matrix3.hpp"

namespace touchstone {
namespace {

/// The tetrahedron between the origin and a triangle, counter-clockwise from outside: with the sum s of its
/// corners, the integral of x is V s / 4, that of x x^T is V / 20 (sum of c c^T + s s^T).
MassMoments tetrahedron(const Vector3& a, const Vector3& b, const Vector3& c) {
  MassMoments out;
  out.volume = dot(a, cross(b, c)) / 6.0;
  const Vector3 sum = (a + b) + c;
  out.first = (0.25 * out.volume) * sum;
  out.second = (0.05 * out.volume) * (((outer(a, a) + outer(b, b)) + outer(c, c)) + outer(sum, sum));
  return out;
}

}  // namespace

MassMoments& MassMoments::operator+=(const MassMoments& other) {
  volume += other.volume;
  first += other.first;
  second += other.second;
  return *this;
}

MassMoments mass_moments(const Hexahedron& solid) {
  // About a point within, so that a solid far from its own origin loses no digits.
  const Vector3& within = solid.bounding_sphere().centre;
  MassMoments about;
  for (const auto& face : Hexahedron::kFaceVertices) {
    const auto corner = [&](int i) { return Vector3(solid.vertices()[face[i]] - within); };
    const Vector3 a = corner(0), b = corner(1), c = corner(2), d = corner(3);
    // d beyond the plane of a, b, c: the ridge of the hull is b d, not a c.
    const bool ridge_ac = dot(d - a, cross(b - a, c - a)) <= 0.0;
    about += ridge_ac ? tetrahedron(a, b, c) : tetrahedron(a, b, d);
    about += ridge_ac ? tetrahedron(a, c, d) : tetrahedron(b, c, d);
  }
  Pose X;
  X.p = within;
  return transform(X, about);
}

MassMoments transform(const Pose& X_AB, const MassMoments& moments_B) {
  MassMoments out;
  out.volume = moments_B.volume;
  const Vector3 first = rotate(X_AB.R, moments_B.first);
  out.first = first + moments_B.volume * X_AB.p;
  out.second = turned(X_AB.R, moments_B.second) + (outer(first, X_AB.p) + outer(X_AB.p, first)) +
               outer(moments_B.volume * X_AB.p, X_AB.p);
  return out;
}

MassMetric mass_metric(const MassMoments& moments) {
  MassMetric out;
  out.centre = moments.first / moments.volume;
  const Matrix3 spread = moments.second / moments.volume - outer(out.centre, out.centre);
  const double trace = (spread(0, 0) + spread(1, 1)) + spread(2, 2);
  out.J = trace * Matrix3::Identity() - spread;
  return out;
}

double inner_product(const Matrix3& J_W, const Twist& a, const Twist& b) {
  return dot(a.v, b.v) + dot(a.w, rotate(J_W, b.w));
}

double least_inertia(const Matrix3& J) {
  // The product of the other two is at most the square of half their sum.
  const Vector3 x = J.col(0), y = J.col(1), z = J.col(2);
  const double trace = (J(0, 0) + J(1, 1)) + J(2, 2);
  return 4.0 * std::max(dot(x, cross(y, z)), 0.0) / (trace * trace);
}

}  // namespace touchstone
