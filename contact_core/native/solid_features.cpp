#include "contact_core/native/solid_features.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <vector>

#include "contact_core/numerics/exact_predicates.hpp"

namespace touchstone::native {
namespace {

constexpr double kEps = std::numeric_limits<double>::epsilon();
constexpr double kFlat = 4 * kEps;  // per metre of size: a vertex this far off a face's plane belongs to it
constexpr double kFlatPerThickness = 1e-3;  // keeps top and bottom of a slab thinner than that apart
constexpr double kParallel = 2 * kEps;      // sine between unit directions that count as one

using Vertices = std::array<Vector3, 8>;

struct Facet {
  unsigned mask = 0;  // bit i: vertex i lies on it
  Vector3 normal = Vector3::Zero();
  double area = 0.0;
};

Vertices scaled_to_unit(const Vertices& vertices) {
  double largest = 0.0;
  for (const Vector3& v : vertices)
    largest = std::max({largest, std::abs(v.x()), std::abs(v.y()), std::abs(v.z())});
  const int exponent = -std::ilogb(largest);
  Vertices out;
  for (int i = 0; i < 8; ++i)
    out[i] = {std::scalbn(vertices[i].x(), exponent), std::scalbn(vertices[i].y(), exponent),
              std::scalbn(vertices[i].z(), exponent)};
  return out;
}

Vector3 unit(const Vector3& v) {
  const double largest = std::max({std::abs(v.x()), std::abs(v.y()), std::abs(v.z())});
  if (largest == 0.0) return Vector3::Zero();
  const int exponent = -std::ilogb(largest);
  const Vector3 s(std::scalbn(v.x(), exponent), std::scalbn(v.y(), exponent), std::scalbn(v.z(), exponent));
  return s / norm(s);
}

// Repeated vertices (collapsed edges) stand for the first of them.
unsigned distinct_vertices(const Vertices& v) {
  unsigned mask = 0;
  for (int i = 0; i < 8; ++i) {
    bool repeated = false;
    for (int j = 0; j < i; ++j) repeated = repeated || v[i] == v[j];
    if (!repeated) mask |= 1u << i;
  }
  return mask;
}

// The facet through i, j, k if that plane supports the hull.
bool supporting_facet(const Vertices& v, unsigned distinct, int i, int j, int k, Facet& facet) {
  bool above = false;
  bool below = false;
  unsigned mask = 0;
  for (int l = 0; l < 8; ++l) {
    if (!(distinct >> l & 1u)) continue;
    const int side = l == i || l == j || l == k ? 0 : numerics::orient3d_sign(v[i], v[j], v[k], v[l]);
    above = above || side > 0;
    below = below || side < 0;
    if (side == 0) mask |= 1u << l;
  }
  if (above == below) return false;  // both: no support; neither: collinear, as the solid has volume
  const Vector3 across = cross(v[j] - v[i], v[k] - v[i]);
  const double area = norm(across);
  facet = {mask, above ? Vector3(-unit(across)) : unit(across), area};
  return true;
}

std::vector<Facet> exact_facets(const Vertices& v, unsigned distinct) {
  std::vector<Facet> facets;
  for (int i = 0; i < 8; ++i)
    for (int j = i + 1; j < 8; ++j)
      for (int k = j + 1; k < 8; ++k) {
        if (!(distinct >> i & distinct >> j & distinct >> k & 1u)) continue;
        Facet facet;
        if (!supporting_facet(v, distinct, i, j, k, facet)) continue;
        const auto known =
            std::find_if(facets.begin(), facets.end(), [&](const Facet& f) { return f.mask == facet.mask; });
        if (known == facets.end())
          facets.push_back(facet);
        else if (facet.area > known->area)
          *known = facet;  // the widest triangle gives the best normal
      }
  std::stable_sort(facets.begin(), facets.end(),
                   [](const Facet& f, const Facet& g) { return f.area > g.area; });
  return facets;
}

void take_in_flat_neighbours(const Vertices& v, unsigned distinct, double size, Facet& facet) {
  const Vector3 origin = v[std::countr_zero(facet.mask)];
  double thickness = 0.0;
  for (int i = 0; i < 8; ++i) thickness = std::max(thickness, std::abs(dot(facet.normal, v[i] - origin)));
  const double tolerance = std::min(kFlat * size, kFlatPerThickness * thickness);
  for (int i = 0; i < 8; ++i)
    if (distinct >> i & 1u && std::abs(dot(facet.normal, v[i] - origin)) <= tolerance) facet.mask |= 1u << i;
}

// Convex, counter-clockwise about the normal: next comes the vertex that leaves all others to the left.
HullFace ordered_face(const Vertices& v, const Facet& facet) {
  HullFace face;
  face.normal = facet.normal;
  for (const auto& quad : Hexahedron::kFaceVertices) {
    unsigned mask = 0;
    for (std::uint8_t i : quad) mask |= 1u << i;
    if (mask != facet.mask) continue;
    face.count = 4;
    std::copy(quad.begin(), quad.end(), face.vertices.begin());
    return face;
  }
  const int first = std::countr_zero(facet.mask);
  int current = first;
  do {
    face.vertices[face.count++] = static_cast<std::uint8_t>(current);
    int next = -1;
    for (int i = 0; i < 8; ++i) {
      if (i == current || !(facet.mask >> i & 1u)) continue;
      if (next < 0) {
        next = i;
        continue;
      }
      const Vector3 to_next = v[next] - v[current];
      const Vector3 to_i = v[i] - v[current];
      const double turn = dot(facet.normal, cross(to_next, to_i));
      if (turn < 0.0 || (turn == 0.0 && dot(to_i, to_i) > dot(to_next, to_next))) next = i;
    }
    current = next;
  } while (current != first && face.count < 8);
  return face;
}

template <std::size_t N>
void add_direction(const Vector3& direction, std::array<Vector3, N>& directions, int& count) {
  if (count == static_cast<int>(N) || direction == Vector3::Zero()) return;
  for (int i = 0; i < count; ++i) {
    const Vector3 off = cross(directions[i], direction);
    if (dot(off, off) <= kParallel * kParallel) return;
  }
  directions[count++] = direction;
}

SolidFeatures box_features() {
  SolidFeatures out;
  out.face_count = 6;
  for (int f = 0; f < 6; ++f) {
    HullFace& face = out.faces[f];
    face.count = 4;
    std::copy(Hexahedron::kFaceVertices[f].begin(), Hexahedron::kFaceVertices[f].end(),
              face.vertices.begin());
    face.normal = (f % 2 ? 1.0 : -1.0) * Vector3::Unit(f / 2);
  }
  out.normal_count = out.edge_count = 3;
  for (int i = 0; i < 3; ++i) out.normals[i] = out.edges[i] = Vector3::Unit(i);
  return out;
}

}  // namespace

SolidFeatures find_features(const Hexahedron& solid) {
  if (solid.is_box()) return box_features();
  const Vertices v = scaled_to_unit(solid.vertices());
  const unsigned distinct = distinct_vertices(v);
  double size = 0.0;
  for (int i = 0; i < 8; ++i)
    for (int j = i + 1; j < 8; ++j) size = std::max(size, norm(v[i] - v[j]));

  SolidFeatures out;
  std::vector<unsigned> taken;
  for (Facet facet : exact_facets(v, distinct)) {
    const bool part_of_another =
        std::any_of(taken.begin(), taken.end(), [&](unsigned mask) { return (facet.mask & ~mask) == 0; });
    if (part_of_another || out.face_count == 12) continue;
    take_in_flat_neighbours(v, distinct, size, facet);
    taken.push_back(facet.mask);
    HullFace& face = out.faces[out.face_count++] = ordered_face(v, facet);
    add_direction(face.normal, out.normals, out.normal_count);
  }
  for (int f = 0; f < out.face_count; ++f) {
    const HullFace& face = out.faces[f];
    for (int i = 0; i < face.count; ++i)
      add_direction(unit(v[face.vertices[(i + 1) % face.count]] - v[face.vertices[i]]), out.edges,
                    out.edge_count);
  }
  return out;
}

HullRecord hull_record(const Hexahedron& solid, const SolidFeatures& features) {
  HullRecord out{};
  const Vertices v = scaled_to_unit(solid.vertices());
  out.face_count = static_cast<std::uint8_t>(features.face_count);
  out.regular = features.face_count >= 4;
  std::array<int, 18> sides{};
  for (int f = 0; f < features.face_count; ++f) {
    const HullFace& face = features.faces[f];
    out.normal_x[f] = face.normal.x(), out.normal_y[f] = face.normal.y(), out.normal_z[f] = face.normal.z();
    out.face_vertex[f] = face.vertices[0];
    out.regular = out.regular && face.count >= 3;
    for (int i = 0; i < face.count; ++i) {
      const std::uint8_t from = face.vertices[i], to = face.vertices[(i + 1) % face.count];
      int e = 0;
      while (e < out.edge_count && !(out.edge_vertices[e][0] == to && out.edge_vertices[e][1] == from)) ++e;
      if (e == out.edge_count) {
        const Vector3 direction = unit(v[to] - v[from]);
        if (e == 18 || direction == Vector3::Zero()) {
          out.regular = false;
          continue;
        }
        ++out.edge_count;
        out.edge_vertices[e][0] = from, out.edge_vertices[e][1] = to;
        out.edge_x[e] = direction.x(), out.edge_y[e] = direction.y(), out.edge_z[e] = direction.z();
      }
      out.edge_faces[e][sides[e] == 0 ? 0 : 1] = static_cast<std::uint8_t>(f);
      ++sides[e];
      out.face_edges[f] |= 1u << e;
    }
  }
  for (int e = 0; e < out.edge_count; ++e) out.regular = out.regular && sides[e] == 2;
  return out;
}

}  // namespace touchstone::native
