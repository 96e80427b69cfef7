#pragma once

#include <cmath>
#include <span>
#include <vector>

#include "touchstone/adapters/ode/ode.hpp"
#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/geometry/hexahedron.hpp"
#include "touchstone/tests/support/ask.hpp"
#include "touchstone/tests/support/random_poses.hpp"

namespace touchstone::ode_test {

inline BackendRegistry registry() {
  BackendRegistry backends;
  register_ode(backends);
  return backends;
}

inline Hexahedron sheared(const Vector3& size, double xy, double xz, double yz) {
  std::vector<Vector3> vertices;
  const Hexahedron box = Hexahedron::from_size(size);
  for (const Vector3& v : box.vertices()) {
    vertices.push_back({v.x() + xy * v.y() + xz * v.z(), v.y() + yz * v.z(), v.z()});
  }
  return Hexahedron::from_vertices(vertices, WarpPolicy::accept);
}

/// A cube of side 1 that is no box to the adapter: made from vertices.
inline Hexahedron convex_cube() {
  const Hexahedron box = Hexahedron::from_size({1, 1, 1});
  return Hexahedron::from_vertices(box.vertices());
}

/// Solids 2i and 2i + 1 are pair i.
struct PairScene {
  std::vector<Hexahedron> solids;
  std::vector<Pose> poses;
  std::vector<SolidPair> pairs;
};

enum class Family { boxes, sheared, thin_boxes, thin_convexes };

/// As random_pose, with quaternions from a cube: the cases whose figures ode_accuracy_test holds.
inline Pose measured_pose(std::mt19937_64& random, const Vector3& centre, double spread) {
  const double w = uniform(random, -1, 1), x = uniform(random, -1, 1), y = uniform(random, -1, 1);
  const Matrix3 R = rotation_from_quaternion(w, x, y, uniform(random, 0.01, 1));
  return {R, centre + random_vector(random, spread)};
}

/// 1e-6 to 1, each power of ten as likely.
inline double thin_side(std::mt19937_64& random) { return std::pow(10.0, uniform(random, -6, 0)); }

inline PairScene random_pairs(std::size_t count, Family family, const Vector3& centre, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  PairScene scene;
  for (std::uint32_t i = 0; i < count; ++i) {
    for (int k = 0; k < 2; ++k) {
      const bool thin = family == Family::thin_boxes || family == Family::thin_convexes;
      const bool box = family == Family::boxes || family == Family::thin_boxes;
      Vector3 size = random_vector(random, 0.5, 1.5);
      if (thin) {
        const double y = thin_side(random);
        size = {1.0, y, thin_side(random)};
      }
      const double a = uniform(random, -0.5, 0.5), b = uniform(random, -0.5, 0.5),
                   c = uniform(random, -0.5, 0.5);
      const double lean = thin ? 0.0 : 1.0;
      scene.solids.push_back(box ? Hexahedron::from_size(size) : sheared(size, lean * a, lean * b, lean * c));
      scene.poses.push_back(measured_pose(random, centre, thin ? 0.05 : 0.6));
    }
    scene.pairs.push_back({2 * i, 2 * i + 1});
  }
  return scene;
}

/// Least overlap of the vertices' shadows over face normals and edge cross products: the depth of
/// parallelepipeds, negative when an axis separates them. Plain doubles, parallelepipeds only: three edge
/// directions a solid.
inline double reference_depth(const Hexahedron& a, const Pose& X_WA, const Hexahedron& b, const Pose& X_WB) {
  // Corners relative to A, and unit edges.
  const auto corner = [](const Hexahedron& s, const Pose& X, const Pose& X0, int i) {
    return Vector3(rotate(X.R, s.vertices()[i]) + (X.p - X0.p));
  };
  const auto edge = [&](const Hexahedron& s, const Pose& X, int k) {
    const Vector3 e = rotate(X.R, s.vertices()[4 >> k] - s.vertices()[0]);
    return Vector3(e / norm(e));
  };
  // The overlap along an axis.
  double least = kInfinity;
  const auto test = [&](const Vector3& axis) {
    const double length = norm(axis);
    if (length < 1e-9) return;
    double a_low = 1e300, a_high = -1e300, b_low = 1e300, b_high = -1e300;
    for (int i = 0; i < 8; ++i) {
      const double at_a = dot(axis, corner(a, X_WA, X_WA, i)) / length;
      const double at_b = dot(axis, corner(b, X_WB, X_WA, i)) / length;
      a_low = std::min(a_low, at_a), a_high = std::max(a_high, at_a);
      b_low = std::min(b_low, at_b), b_high = std::max(b_high, at_b);
    }
    least = std::min(least, std::min(a_high - b_low, b_high - a_low));
  };
  // Faces of both, and edge against edge.
  for (int i = 0; i < 3; ++i) {
    test(cross(edge(a, X_WA, i), edge(a, X_WA, (i + 1) % 3)));
    test(cross(edge(b, X_WB, i), edge(b, X_WB, (i + 1) % 3)));
    for (int j = 0; j < 3; ++j) test(cross(edge(a, X_WA, i), edge(b, X_WB, j)));
  }
  return least;
}

// Sheared hexahedra with a third of them boxes.
inline PairScene mixed_scene(std::size_t count) {
  PairScene scene = random_pairs(count, Family::sheared, Vector3::Zero(), 5);
  const PairScene boxes = random_pairs(count, Family::boxes, Vector3::Zero(), 6);
  for (std::uint32_t i = 0; i + 1 < scene.solids.size(); i += 3) scene.solids[i] = boxes.solids[i];
  return scene;
}

}  // namespace touchstone::ode_test
