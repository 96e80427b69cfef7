#pragma once

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <memory>
#include <vector>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/contact_core/native/native.hpp"
#include "touchstone/tests/support/all_pairs.hpp"
#include "touchstone/tests/support/ask.hpp"
#include "touchstone/tests/support/random_poses.hpp"
#include "touchstone/tests/support/scale_of.hpp"

namespace touchstone {

/// Asks `native` about one pair.
inline Answer ask(const Hexahedron& a, const Pose& X_WA, const Hexahedron& b, const Pose& X_WB,
                  const Query& query) {
  const std::unique_ptr<Narrowphase> native = make_native();
  native->build(std::array{a, b});
  return ask(*native, std::array{X_WA, X_WB}, query);
}

/// For manifolds of the whole clip, however far apart its corners are.
inline Query whole_clip(QueryKind kind = QueryKind::manifold) {
  return {kind, kInfinity, kMaxManifoldPoints, kInfinity};
}

inline Answer ask(const Hexahedron& a, const Pose& X_WA, const Hexahedron& b, const Pose& X_WB,
                  QueryKind kind = QueryKind::manifold) {
  return ask(a, X_WA, b, X_WB, whole_clip(kind));
}

inline bool same_bits(double x, double y) {
  return std::bit_cast<std::uint64_t>(x) == std::bit_cast<std::uint64_t>(y);
}

inline bool same_bits(const Vector3& p, const Vector3& q) {
  return same_bits(p.x(), q.x()) && same_bits(p.y(), q.y()) && same_bits(p.z(), q.z());
}

inline bool same_bits(const PairGeometry& g, const PairGeometry& h) {
  return same_bits(g.separation, h.separation) && same_bits(g.n_AB_W, h.n_AB_W) &&
         same_bits(g.p_A_W, h.p_A_W) && same_bits(g.p_B_W, h.p_B_W);
}

/// Seeded, and the same on every compiler and standard library (no std::*_distribution).
class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}

  double uniform(double low, double high) { return touchstone::uniform(engine_, low, high); }
  int below(int n) { return static_cast<int>(engine_() % static_cast<std::uint64_t>(n)); }
  Vector3 vector(double low, double high) { return random_vector(engine_, low, high); }
  Vector3 vector(double reach) { return vector(-reach, reach); }
  Pose pose(double reach) {
    Pose X;
    const Vector3 axis = vector(1.0);
    X.R = rotation_from_quaternion(uniform(0.1, 1), axis.x(), axis.y(), axis.z());
    X.p = vector(reach);
    return X;
  }

  Hexahedron box() { return Hexahedron::from_size(vector(0.2, 2)); }
  Hexahedron slab_or_needle() {
    Vector3 size = vector(0.5, 2);
    const double thin = std::ldexp(1.0, -2 - below(25));
    size(below(3)) = thin;
    size(below(3)) = thin;
    return Hexahedron::from_size(size);
  }
  Hexahedron sheared() {
    const Vector3 x{uniform(0.3, 2), uniform(-0.5, 0.5), uniform(-0.5, 0.5)};
    const Vector3 y{uniform(-0.5, 0.5), uniform(0.8, 2), uniform(-0.5, 0.5)};
    const Vector3 z{uniform(-0.2, 0.2), uniform(-0.5, 0.5), uniform(0.8, 2)};
    return from([&](double i, double j, double k) { return Vector3(i * x + j * y + k * z); },
                WarpPolicy::refuse);
  }
  Hexahedron tapered() {
    const Vector3 half = vector(0.2, 1);
    const double top = uniform(0.0, 1.0);
    const double lean = uniform(-0.4, 0.4);
    return from(
        [&](double i, double j, double k) {
          const double m = k > 0 ? top : 1.0;
          return Vector3(2 * i * half.x() * m + 2 * k * lean, 2 * j * half.y() * m, 2 * k * half.z());
        },
        WarpPolicy::refuse);
  }
  Hexahedron pyramid() {
    const Vector3 apex{uniform(-0.3, 0.3), uniform(-0.3, 0.3), uniform(0.3, 1)};
    const Vector3 half = vector(0.3, 1);
    return from(
        [&](double i, double j, double k) {
          return k > 0 ? apex : Vector3(2 * i * half.x(), 2 * j * half.y(), -half.z());
        },
        WarpPolicy::refuse);
  }
  Hexahedron warped() {
    for (;;) {
      try {
        return from([&](double i, double j,
                        double k) { return Vector3(Vector3(1.4 * i, 1.4 * j, 1.4 * k) + vector(0.12)); },
                    WarpPolicy::accept);
      } catch (const InputError&) {
        // Not convex: draw again.
      }
    }
  }
  Hexahedron any() {
    switch (below(6)) {
      case 0:
        return box();
      case 1:
        return slab_or_needle();
      case 2:
        return sheared();
      case 3:
        return tapered();
      case 4:
        return pyramid();
      default:
        return warped();
    }
  }

  /// `count` solids of any kind about the origin.
  AllPairs crowd(SolidIndex count) {
    return all_pairs(
        count, [&](SolidIndex) { return any(); }, [&] { return pose(1.0); });
  }

 private:
  template <class Corner>
  Hexahedron from(const Corner& corner, WarpPolicy warp) {
    std::vector<Vector3> vertices;
    for (int i = 0; i < 8; ++i)
      vertices.push_back(corner(i & 4 ? 0.5 : -0.5, i & 2 ? 0.5 : -0.5, i & 1 ? 0.5 : -0.5));
    return Hexahedron::from_vertices(vertices, warp);
  }

  std::mt19937_64 engine_;
};

}  // namespace touchstone
