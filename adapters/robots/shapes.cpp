#include "touchstone/adapters/robots/shapes.hpp"

#include <array>
#include <cmath>
#include <numbers>

#include "touchstone/contact_core/geometry/trigonometry.hpp"
#include "touchstone/contact_core/input_error.hpp"

namespace touchstone {
namespace {

constexpr int kMostFacets = 1024;
/// Corners are rounded inwards by a few 2^-53 of the radius each: the shape that is held is this much larger.
constexpr double kOutwards = 1.0 + 0x1p-48;

void require(bool holds, const std::string& name, const std::string& reason) {
  if (!holds) throw InputError("round part '" + name + "': " + reason);
}

void require_shape(const std::string& name, int facets, const std::array<double, 3>& lengths) {
  require(facets >= 4 && facets <= kMostFacets && facets % 4 == 0, name,
          std::to_string(facets) + " facets; a sphere takes a multiple of 4 from 4 to 1024");
  for (const double length : lengths)
    require(std::isfinite(length) && length > 0.0, name,
            "a length is " + figure(length) + " m, not a length > 0");
}

/// A circle of latitude that the bands' corners stand on, about the z axis.
struct Latitude {
  double radius;  ///< of the polygon's corners
  double z;
};

/// Of the regular polygon round the meridian, corner `j` from the top, and round z the polygon that holds its
/// circle.
Latitude latitude(int j, int facets) {
  const auto [s, c] = sine_cosine((0.5 - (2.0 * j + 1.0) / facets) * std::numbers::pi);
  const double inverse = 1.0 / cosine(std::numbers::pi / facets);
  return {c * inverse * inverse, s * inverse};
}

/// Corner k of a polygon round z, as make_cylinder() has them: facet 0 is centred on +x.
Vector3 corner(const Latitude& at, int facets, int k) {
  const auto [s, c] = sine_cosine((2 * (k % facets) - 1) * std::numbers::pi / facets);
  return {at.radius * c, at.radius * s, at.z};
}

/// The unit sphere's hexahedra, stretched, then moved by half_length up or down from the equator.
RoundPart make_round(const Vector3& stretch, double half_length, int facets, const Pose& X_OS,
                     const std::string& name) {
  RoundPart part;
  // Corners are moved outwards, so that the hexahedra enclose the surface.
  const auto place = [&](const Latitude& at, int k) {
    const Vector3 v = corner(at, facets, k).cwiseProduct(stretch * kOutwards);
    return Vector3(v.x(), v.y(), v.z() + (v.z() > 0.0 ? half_length : -half_length));
  };
  // Each band of latitude is cut into hexahedra across the solid.
  for (int band = 0; band + 1 < facets / 2; ++band) {
    const std::array<Latitude, 2> ends = {latitude(band + 1, facets), latitude(band, facets)};
    for (int k = 0; k + 1 < facets / 2; ++k) {
      const std::array<int, 4> corners = {1 + k, facets - k, 2 + k, facets - k - 1};
      std::array<Vector3, 8> v;
      for (int bits = 0; bits < 8; ++bits) v[bits] = place(ends[bits & 1], corners[bits >> 1]);
      const std::string slice = name + "." + std::to_string(part.solids.size());
      part.solids.push_back(
          {slice, Hexahedron::from_vertices(v, WarpPolicy::within_tolerance, "hexahedron '" + slice + "'"),
           X_OS});
    }
  }
  // The farthest corner bounds how far the hexahedra reach beyond the surface.
  double farthest = 0.0;  // of the unit sphere's corners, from its centre
  for (int j = 0; j < facets / 2; ++j) {
    const Latitude at = latitude(j, facets);
    farthest = std::max(farthest, std::sqrt(at.radius * at.radius + at.z * at.z));
  }
  const double radius = stretch.maxCoeff();
  part.figures.push_back(
      {"", name, facets, false, radius, radius * (farthest * kOutwards * kOutwards - 1.0)});
  return part;
}

}  // namespace

RoundPart make_sphere(double radius, int facets, const Pose& X_OS, const std::string& name) {
  require_shape(name, facets, {radius, radius, radius});
  return make_round({radius, radius, radius}, 0.0, facets, X_OS, name);
}

RoundPart make_capsule(double radius, double length, int facets, const Pose& X_OS, const std::string& name) {
  require_shape(name, facets, {radius, length, length});
  return make_round({radius, radius, radius}, 0.5 * length * kOutwards, facets, X_OS, name);
}

RoundPart make_ellipsoid(const Vector3& half_axes, int facets, const Pose& X_OS, const std::string& name) {
  require_shape(name, facets, {half_axes.x(), half_axes.y(), half_axes.z()});
  return make_round(half_axes, 0.0, facets, X_OS, name);
}

}  // namespace touchstone
