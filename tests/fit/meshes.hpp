#pragma once

#include <cmath>
#include <numbers>

#include "touchstone/contact_core/fit/triangle_mesh.hpp"

// Small parts whose covers are known.

namespace touchstone::test {

inline void append_quad(TriangleMesh& mesh, const Vector3& a, const Vector3& b, const Vector3& c,
                        const Vector3& d) {
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), {a, b, c, d});
  mesh.triangles.push_back({first, first + 1, first + 2});
  mesh.triangles.push_back({first, first + 2, first + 3});
}

inline void append(TriangleMesh& mesh, const TriangleMesh& more) {
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), more.vertices.begin(), more.vertices.end());
  for (const auto& t : more.triangles) mesh.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
}

inline std::array<Vector3, 8> box_vertices(const Vector3& low, const Vector3& high) {
  std::array<Vector3, 8> v;
  for (int i = 0; i < 8; ++i)
    v[i] = {(i & 4) != 0 ? high.x() : low.x(), (i & 2) != 0 ? high.y() : low.y(),
            (i & 1) != 0 ? high.z() : low.z()};
  return v;
}

inline TriangleMesh box_mesh(const Vector3& low, const Vector3& high) {
  const std::array<Vector3, 8> v = box_vertices(low, high);
  TriangleMesh mesh;
  append_quad(mesh, v[0], v[1], v[3], v[2]);
  append_quad(mesh, v[4], v[6], v[7], v[5]);
  append_quad(mesh, v[0], v[4], v[5], v[1]);
  append_quad(mesh, v[2], v[3], v[7], v[6]);
  append_quad(mesh, v[0], v[2], v[6], v[4]);
  append_quad(mesh, v[1], v[5], v[7], v[3]);
  return mesh;
}

/// An L, 2 x 2 x 1 m, legs 0.5 m thick: one closed shell.
inline TriangleMesh angle_mesh() {
  const std::array<Eigen::Vector2d, 6> outline = {
      {{0, 0}, {2, 0}, {2, 0.5}, {0.5, 0.5}, {0.5, 2}, {0, 2}}};  // counter-clockwise
  const auto at = [&](std::size_t i, double z) { return Vector3(outline[i % 6].x(), outline[i % 6].y(), z); };
  TriangleMesh mesh;
  for (std::size_t i = 0; i < 6; ++i) append_quad(mesh, at(i, 0), at(i + 1, 0), at(i + 1, 1), at(i, 1));
  append_quad(mesh, at(0, 1), at(1, 1), at(2, 1), at(3, 1));
  append_quad(mesh, at(0, 1), at(3, 1), at(4, 1), at(5, 1));
  append_quad(mesh, at(3, 0), at(2, 0), at(1, 0), at(0, 0));
  append_quad(mesh, at(5, 0), at(4, 0), at(3, 0), at(0, 0));
  return mesh;
}

/// A tube about z, from z = 0 up, of `facets` facets with their corners on the circles.
inline TriangleMesh tube_mesh(double inner, double outer, double height, int facets) {
  const auto at = [&](double radius, int i, double z) {
    const double angle = 2.0 * std::numbers::pi * (i % facets) / facets;
    return Vector3(radius * std::cos(angle), radius * std::sin(angle), z);
  };
  TriangleMesh mesh;
  for (int i = 0; i < facets; ++i) {
    append_quad(mesh, at(outer, i, 0), at(outer, i + 1, 0), at(outer, i + 1, height), at(outer, i, height));
    append_quad(mesh, at(inner, i + 1, 0), at(inner, i, 0), at(inner, i, height), at(inner, i + 1, height));
    append_quad(mesh, at(inner, i, height), at(outer, i, height), at(outer, i + 1, height),
                at(inner, i + 1, height));
    append_quad(mesh, at(outer, i, 0), at(inner, i, 0), at(inner, i + 1, 0), at(outer, i + 1, 0));
  }
  return mesh;
}

/// A cone about z from z = 0 up, of `facets` facets with their corners on the circles; `top` 0: to a tip.
inline TriangleMesh cone_mesh(double radius, double top, double height, int facets) {
  const auto at = [&](double r, int i, double z) {
    const double angle = 2.0 * std::numbers::pi * (i % facets) / facets;
    return Vector3(r * std::cos(angle), r * std::sin(angle), z);
  };
  TriangleMesh mesh;
  const auto append_triangle = [&](const Vector3& a, const Vector3& b, const Vector3& c) {
    append(mesh, {{a, b, c}, {{0, 1, 2}}});
  };
  for (int i = 0; i < facets; ++i) {
    append_triangle(at(radius, i + 1, 0), at(radius, i, 0), Vector3::Zero());
    append_triangle(at(radius, i, 0), at(radius, i + 1, 0), at(top, i + 1, height));
    if (top == 0.0) continue;
    append_triangle(at(radius, i, 0), at(top, i + 1, height), at(top, i, height));
    append_triangle(at(top, i, height), at(top, i + 1, height), {0, 0, height});
  }
  return mesh;
}

}  // namespace touchstone::test
