#include "touchstone/contact_core/numerics/projection_filter.hpp"

#include <algorithm>
#include <cmath>

// Scaling. Multiplying an axis by a power of two changes no sign of a determinant of differences. Axes whose
// largest magnitude is in (2^-64, 2^64] stay as they are; others are scaled to at most 1. So products of
// three differences are below 2^200, and what scaling rounds (coordinates 2^-1022 below the largest) or a
// product underflows, at most 2^-1074 each, adds less than 2^-1000 to a determinant.
//
// Error bound of a difference of two projections, u = 2^-53, P = magnitude . extent: a component of n has 4
// roundings (two differences, product, subtraction), an offset 1, the product 1, the sums 2: each projection
// is within 8.01 u P; their subtraction adds at most 2.01 u P; P as computed is low by at most 9 u P. 18.1 u
// P in all; 32 u P = 2^-48 P is used.

namespace touchstone::numerics {
namespace {

void scale_axis(std::array<double, 16>& coordinates) {
  double largest = 0.0;
  for (const double c : coordinates) largest = std::max(largest, std::abs(c));
  if (largest == 0.0 || (largest > 0x1p-64 && largest <= 0x1p64)) return;
  const int exponent = -(std::ilogb(largest) + 1);
  // In two steps: 2^1074 is no double.
  const double half = std::scalbn(1.0, exponent / 2), rest = std::scalbn(1.0, exponent - exponent / 2);
  for (double& c : coordinates) c = c * half * rest;
}

double offsets(const std::array<double, 16>& coordinates, std::array<double, 16>& out) {
  double largest = 0.0;
  for (int i = 0; i < 16; ++i) {
    out[i] = coordinates[i] - coordinates[0];
    largest = std::max(largest, std::abs(out[i]));
  }
  return largest;
}

double least(const double* v) {
  const double a = std::min(v[0], v[4]), b = std::min(v[1], v[5]), c = std::min(v[2], v[6]),
               d = std::min(v[3], v[7]);
  return std::min(std::min(a, c), std::min(b, d));
}

double greatest(const double* v) {
  const double a = std::max(v[0], v[4]), b = std::max(v[1], v[5]), c = std::max(v[2], v[6]),
               d = std::max(v[3], v[7]);
  return std::max(std::max(a, c), std::max(b, d));
}

}  // namespace

ProjectionFilter::ProjectionFilter(std::span<const Vector3> points) noexcept {
  for (int i = 0; i < 16; ++i) x_[i] = points[i].x(), y_[i] = points[i].y(), z_[i] = points[i].z();
  scale_axis(x_), scale_axis(y_), scale_axis(z_);
  extent_ = {offsets(x_, offset_x_), offsets(y_, offset_y_), offsets(z_, offset_z_)};
}

ProjectionFilter::Direction ProjectionFilter::direction(Difference u, Difference v) const noexcept {
  const Vector3 a = difference(u), b = difference(v);
  const double xp = a.y() * b.z(), xn = a.z() * b.y();
  const double yp = a.z() * b.x(), yn = a.x() * b.z();
  const double zp = a.x() * b.y(), zn = a.y() * b.x();
  return {{xp - xn, yp - yn, zp - zn},
          {std::abs(xp) + std::abs(xn), std::abs(yp) + std::abs(yn), std::abs(zp) + std::abs(zn)}};
}

ProjectionFilter::Projections ProjectionFilter::project(const Direction& direction) const noexcept {
  const double nx = direction.n.x(), ny = direction.n.y(), nz = direction.n.z();
  Projections out;
  for (int i = 0; i < 16; ++i) out.along[i] = (nx * offset_x_[i] + ny * offset_y_[i]) + nz * offset_z_[i];
  out.low_a = least(out.along.data()), out.high_a = greatest(out.along.data());
  out.low_b = least(out.along.data() + 8), out.high_b = greatest(out.along.data() + 8);
  out.error = 0x1p-48 * dot(direction.magnitude, extent_) + 0x1p-998;
  return out;
}

int ProjectionFilter::certain_sign(const Direction& direction, Difference w) const noexcept {
  const Vector3 c = difference(w);
  const double value = dot(direction.n, c);
  const double permanent =
      (direction.magnitude.x() * std::abs(c.x()) + direction.magnitude.y() * std::abs(c.y())) +
      direction.magnitude.z() * std::abs(c.z());
  // As for DifferenceDeterminant's filter.
  if (std::abs(value) <= 0x1p-49 * permanent + 0x1p-1000) return 0;
  return value > 0.0 ? 1 : -1;
}

}  // namespace touchstone::numerics
