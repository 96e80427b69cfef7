#include "touchstone/contact_core/mechanism/round_parts.hpp"

#include <array>
#include <cmath>
#include <numbers>

#include "touchstone/contact_core/geometry/trigonometry.hpp"
#include "touchstone/contact_core/input_error.hpp"

namespace touchstone {
namespace {

constexpr int kMostFacets = 4096;

void require(bool holds, const std::string& name, const std::string& reason) {
  if (!holds) throw InputError("round part '" + name + "': " + reason);
}

bool is_length(double value) { return std::isfinite(value) && value > 0.0; }

double corner_radius(double radius, int facets, bool inscribed) {
  return inscribed ? radius : radius / cosine(std::numbers::pi / facets);
}

/// Corner k of the polygon, at the angle (2k - 1) pi / n; k is taken modulo n, so that neighbours share bits.
Vector3 corner(double radius, int facets, int k, double z) {
  const double angle = (2 * (k % facets) - 1) * std::numbers::pi / facets;
  const auto [s, c] = sine_cosine(angle);
  return {radius * c, radius * s, z};
}

Hexahedron slice(const std::array<Vector3, 4>& at_0, double length, const std::string& name) {
  std::array<Vector3, 8> v;
  for (int bits = 0; bits < 8; ++bits) {
    v[bits] = at_0[bits >> 1];
    if (bits & 1) v[bits].z() = length;
  }
  return Hexahedron::from_vertices(v, WarpPolicy::refuse, "hexahedron '" + name + "'");
}

}  // namespace

double polygon_error(double radius, int facets, bool inscribed) {
  const double c = cosine(std::numbers::pi / facets);
  return inscribed ? radius * (1.0 - c) : radius * (1.0 / c - 1.0);
}

RoundPart make_cylinder(double radius, double length, int facets, bool inscribed, const Pose& X_OS,
                        const std::string& name) {
  require(facets >= 4 && facets <= kMostFacets && facets % 2 == 0, name,
          std::to_string(facets) + " facets; a cylinder takes an even number from 4 to 4096");
  require(is_length(radius), name, "the radius is " + std::to_string(radius) + " m, not a length > 0");
  require(is_length(length), name, "the length is " + std::to_string(length) + " m, not a length > 0");
  const double r = corner_radius(radius, facets, inscribed);
  RoundPart part;
  // Chords parallel to facet 0's edge join corners 1 + k and -k: slice k lies between chords k and k + 1.
  for (int k = 0; k + 1 < facets / 2; ++k) {
    const std::string slice_name = name + "." + std::to_string(k);
    const std::array<Vector3, 4> at_0 = {corner(r, facets, 1 + k, 0.0), corner(r, facets, facets - k, 0.0),
                                         corner(r, facets, 2 + k, 0.0),
                                         corner(r, facets, facets - k - 1, 0.0)};
    part.solids.push_back({slice_name, slice(at_0, length, slice_name), X_OS});
  }
  part.figures.push_back({"", name, facets, inscribed, radius, polygon_error(radius, facets, inscribed)});
  return part;
}

RoundPart make_tube(double outer_radius, double inner_radius, double length, int facets, bool inscribed,
                    const Pose& X_OS, const std::string& name) {
  require(facets >= 3 && facets <= kMostFacets, name,
          std::to_string(facets) + " facets; a tube takes 3 to 4096");
  require(is_length(inner_radius) && std::isfinite(outer_radius) && outer_radius > inner_radius, name,
          "a tube needs 0 < inner radius < outer radius; they are " + std::to_string(inner_radius) + " and " +
              std::to_string(outer_radius) + " m");
  require(is_length(length), name, "the length is " + std::to_string(length) + " m, not a length > 0");
  const double inner = corner_radius(inner_radius, facets, inscribed);
  const double outer = corner_radius(outer_radius, facets, inscribed);
  RoundPart part;
  for (int k = 0; k < facets; ++k) {
    const std::string facet = name + "." + std::to_string(k);
    const std::array<Vector3, 4> at_0 = {corner(inner, facets, k, 0.0), corner(inner, facets, k + 1, 0.0),
                                         corner(outer, facets, k, 0.0), corner(outer, facets, k + 1, 0.0)};
    part.solids.push_back({facet, slice(at_0, length, facet), X_OS});
  }
  for (const double radius : {outer_radius, inner_radius})
    part.figures.push_back({"", name, facets, inscribed, radius, polygon_error(radius, facets, inscribed)});
  return part;
}

void append(RoundPart part, std::size_t link, MechanismDescription& description) {
  LinkDescription& to = description.links[link];
  for (PlacedHexahedron& placed : part.solids) to.solids.push_back(std::move(placed));
  for (FacetFigure& figure : part.figures) {
    figure.object = to.name;
    description.facet_figures.push_back(std::move(figure));
  }
}

}  // namespace touchstone
