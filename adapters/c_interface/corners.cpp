#include "touchstone/adapters/c_interface/corners.hpp"

#include <array>
#include <string>

namespace touchstone::c_interface {
namespace {

/// Also one with sides of 0, which only a radius makes a solid.
bool is_centred_box(const std::array<Vector3, 8>& v) {
  const Vector3& h = v[7];
  if (!(h.x() >= 0.0 && h.y() >= 0.0 && h.z() >= 0.0)) return false;
  for (int i = 0; i < 8; ++i) {
    const Vector3 corner((i & 4) != 0 ? h.x() : -h.x(), (i & 2) != 0 ? h.y() : -h.y(),
                         (i & 1) != 0 ? h.z() : -h.z());
    if (v[i] != corner) return false;
  }
  return is_finite(2.0 * h);
}

Hexahedron solid_of(const std::array<Vector3, 8>& vertices, double radius, const std::string& name) {
  const bool is_box = is_centred_box(vertices);
  if (radius != 0.0 && is_box) return Hexahedron::rounded_box(2.0 * vertices[7], radius, name);
  Hexahedron core = is_box && vertices[7].minCoeff() > 0.0
                        ? Hexahedron::from_size(2.0 * vertices[7], name)
                        : Hexahedron::from_vertices(vertices, WarpPolicy::within_tolerance, name);
  return radius != 0.0 ? core.padded(radius, name) : core;
}

}  // namespace

std::vector<Hexahedron> solids_from_corners(std::span<const double> corners, std::span<const double> radii) {
  std::vector<Hexahedron> solids;
  solids.reserve(corners.size() / kCornerDoubles);
  for (std::size_t first = 0; first + kCornerDoubles <= corners.size(); first += kCornerDoubles) {
    const std::string name = "solid " + std::to_string(solids.size());
    std::array<Vector3, 8> vertices;
    for (std::size_t i = 0; i < 8; ++i)
      vertices[i] = {corners[first + 3 * i], corners[first + 3 * i + 1], corners[first + 3 * i + 2]};
    solids.push_back(solid_of(vertices, radii.empty() ? 0.0 : radii[solids.size()], name));
  }
  return solids;
}

std::vector<double> corners_of(std::span<const Hexahedron> solids) {
  std::vector<double> corners;
  corners.reserve(solids.size() * kCornerDoubles);
  for (const Hexahedron& solid : solids)
    for (const Vector3& v : solid.vertices()) corners.insert(corners.end(), {v.x(), v.y(), v.z()});
  return corners;
}

}  // namespace touchstone::c_interface
