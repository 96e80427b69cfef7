#pragma once

#include <cmath>
#include <memory>
#include <random>
#include <string>
#include <vector>

#ifdef BT_USE_DOUBLE_PRECISION
#include "adapters/bullet/bullet.hpp"
#else
#include "adapters/bullet/bullet_single.hpp"
#endif

namespace touchstone::test {

#ifdef BT_USE_DOUBLE_PRECISION
inline constexpr bool kDouble = true;
inline const std::string kBackend = "bullet";
inline void register_backend(BackendRegistry& registry) { register_bullet(registry); }
#else
inline constexpr bool kDouble = false;
inline const std::string kBackend = "bullet_single";
inline void register_backend(BackendRegistry& registry) { register_bullet_single(registry); }
#endif
inline const std::string kGjk = kBackend + "_gjk";

inline BackendRegistry make_registry() {
  BackendRegistry registry;
  register_backend(registry);
  return registry;
}

struct Answer {
  PairStatus status;
  PairGeometry geometry;
  std::vector<ContactPoint> points;
};

/// Solid 0 against solid 1.
inline Answer ask(const Narrowphase& narrowphase, const std::vector<Pose>& poses, const Query& query) {
  const std::vector<SolidPair> pairs{{0, 1}};
  std::vector<PairStatus> status(1);
  std::vector<PairGeometry> geometry(1);
  std::vector<ContactPoint> points(static_cast<std::size_t>(query.max_points));
  const auto workspace = narrowphase.make_workspace();
  narrowphase.evaluate({pairs, poses, query}, {status, geometry, points}, *workspace);
  points.resize(static_cast<std::size_t>(geometry[0].point_count));
  return {status[0], geometry[0], points};
}

inline Answer ask(const std::string& backend, const std::vector<Hexahedron>& solids,
                  const std::vector<Pose>& poses, const Query& query) {
  const auto narrowphase = make_registry().make_narrowphase(backend);
  narrowphase->build(solids);
  return ask(*narrowphase, poses, query);
}

inline Pose at(double x, double y, double z) {
  Pose X;
  X.p = {x, y, z};
  return X;
}

inline Matrix3 random_rotation(std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  const double w = normal(random), x = normal(random), y = normal(random), z = normal(random);
  return rotation_from_quaternion(w, x, y, z);
}

inline Vector3 random_vector(std::mt19937_64& random, double low, double high) {
  std::uniform_real_distribution<double> uniform(low, high);
  const double x = uniform(random), y = uniform(random), z = uniform(random);
  return {x, y, z};
}

}  // namespace touchstone::test
