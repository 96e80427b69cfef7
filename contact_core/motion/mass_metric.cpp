#include "touchstone/contact_core/motion/mass_metric.hpp"

#include <algorithm>
#include <numbers>

#include "touchstone/contact_core/geometry/matrix3.hpp"
#include "touchstone/contact_core/input_error.hpp"

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

/// Of half a rounded box's extents and its radius: the integral of x^2 for the half extent h along x, p and q
/// along the others. In turn: the box, its slabs on the faces, quarters of cylinders on the edges along x and
/// across it, octants of balls on the corners.
double rounded_box_second(double h, double p, double q, double r) {
  constexpr double kPi = std::numbers::pi;
  const double h2 = h * h, r2 = r * r, line = 2.0 / 3.0 * (h * h2);
  const double out = h + r;
  const double across = 2.0 / 3.0 * (out * out * out - h * h2);
  const double box_and_slabs = line * (4.0 * p * q) + across * (4.0 * p * q) + line * (4.0 * r * (p + q));
  const double edge = kPi * r2 * h2 + (8.0 / 3.0) * (h * r2 * r) + (kPi / 4.0) * (r2 * r2);
  const double corners = kPi * (r2 * r) * ((4.0 / 3.0) * h2 + h * r + (4.0 / 15.0) * r2);
  return box_and_slabs + line * (kPi * r2) + edge * (2.0 * (p + q)) + corners;
}

MassMoments rounded_box_moments(const Vector3& half, double r) {
  constexpr double kPi = std::numbers::pi;
  const double x = half.x(), y = half.y(), z = half.z();
  MassMoments out;
  out.volume = 8.0 * (x * y * z) + 8.0 * r * ((x * y + y * z) + z * x) + 2.0 * kPi * (r * r) * ((x + y) + z) +
               (4.0 / 3.0) * kPi * (r * r * r);
  out.first = Vector3::Zero();
  out.second = Matrix3::Zero();
  out.second(0, 0) = rounded_box_second(x, y, z, r);
  out.second(1, 1) = rounded_box_second(y, z, x, r);
  out.second(2, 2) = rounded_box_second(z, x, y, r);
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
  if (solid.is_rounded()) {
    if (solid.is_box()) return rounded_box_moments(solid.half_extents(), solid.radius());
    throw InputError("the mass of a rounded solid whose core is no box is not known");
  }
  return core_moments(solid);
}

MassMoments core_moments(const Hexahedron& solid) {
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
