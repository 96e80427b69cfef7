#pragma once

#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "touchstone/contact_core/fit/triangle_mesh.hpp"
#include "touchstone/tests/fit/meshes.hpp"

// Closed shells as nobody means them: slanted, through themselves, flush, twice, within each other, inside
// out.

namespace touchstone::test {

class RandomShells {
 public:
  explicit RandomShells(std::uint64_t seed) : engine_(seed) {}

  double next() { return static_cast<double>(engine_() >> 11) * 0x1p-53; }
  bool one_in(unsigned count) { return engine_() % count == 0; }
  Vector3 within(const Vector3& low, const Vector3& high) {
    return low + Vector3(next(), next(), next()).cwiseProduct(high - low);
  }

  /// One to six shells, with their corners on a grid; a third of such meshes are turned off the axes.
  TriangleMesh mesh() {
    grid_ = one_in(4) ? 0.1 : 0.25;  // 0.1: no double is
    TriangleMesh all;
    for (std::uint64_t left = 1 + engine_() % 6; left > 0; --left) {
      TriangleMesh one = shell();
      if (one_in(5)) turn_inside_out(one);
      append(all, one);
      if (one_in(5)) append(all, one);
      if (!one_in(6)) continue;
      Vector3 middle = Vector3::Zero();
      for (const Vector3& p : one.vertices) middle += p / static_cast<double>(one.vertices.size());
      for (Vector3& p : one.vertices) p = middle + 0.5 * (p - middle);
      if (one_in(2)) turn_inside_out(one);
      append(all, one);
    }
    if (one_in(3))
      for (Vector3& p : all.vertices)
        p = Vector3(0.8 * p.x() - 0.6 * p.z(), p.y(), 0.6 * p.x() + 0.8 * p.z());
    return all;
  }

 private:
  double step(unsigned count) { return grid_ * static_cast<double>(engine_() % count); }
  Vector3 place() {
    const double x = step(9), y = step(9);
    return {x, y, step(9)};
  }

  static void turn_inside_out(TriangleMesh& mesh) {
    for (auto& t : mesh.triangles) std::swap(t[1], t[2]);
  }

  TriangleMesh shell() {
    const auto places = [this](int count) {
      std::vector<Vector3> all;
      for (int i = 0; i < count; ++i) all.push_back(place());
      return all;
    };
    // One of four kinds of closed shells.
    switch (engine_() % 4) {
      case 0: {  // a sheared block
        const Vector3 foot = place(), x(grid_ + step(5), step(3), 0.0), y(step(3), grid_ + step(5), 0.0),
                      z(step(3) - grid_, step(3) - grid_, grid_ + step(5));
        TriangleMesh block = box_mesh({0, 0, 0}, {1, 1, 1});
        for (Vector3& p : block.vertices) p = foot + p.x() * x + p.y() * y + p.z() * z;
        return block;
      }
      case 1: {
        const Vector3 low = place(), size(grid_ + step(5), grid_ + step(5), grid_ + step(5));
        return box_mesh(low, low + size);
      }
      case 2:  // an octahedron of any six corners: it may pass through itself
        return {places(6),
                {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}}};
      default: {  // a prism on any four corners, as a bow tie
        std::vector<Vector3> corners = places(4);
        const double low = step(5), high = low + grid_ + step(4);
        for (std::size_t i = 0; i < 4; ++i) {
          corners[i].z() = low;
          corners.emplace_back(corners[i].x(), corners[i].y(), high);
        }
        return {corners,
                {{0, 2, 1},
                 {0, 3, 2},
                 {4, 5, 6},
                 {4, 6, 7},
                 {0, 1, 5},
                 {0, 5, 4},
                 {1, 2, 6},
                 {1, 6, 5},
                 {2, 3, 7},
                 {2, 7, 6},
                 {3, 0, 4},
                 {3, 4, 7}}};
      }
    }
  }

  std::mt19937_64 engine_;
  double grid_ = 0.25;
};

/// How often a closed mesh winds about a point, by the solid angles of its triangles: between whole numbers
/// on the surface.
inline double winding_by_angles(const TriangleMesh& mesh, const Vector3& p) {
  double sum = 0.0;
  for (const auto& t : mesh.triangles) {
    const Vector3 a = mesh.vertices[t[0]] - p, b = mesh.vertices[t[1]] - p, c = mesh.vertices[t[2]] - p;
    const double la = norm(a), lb = norm(b), lc = norm(c);
    sum += std::atan2(dot(a, cross(b, c)), la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb);
  }
  return sum / (2.0 * std::numbers::pi);
}

}  // namespace touchstone::test
