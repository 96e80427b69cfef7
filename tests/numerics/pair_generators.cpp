#include "touchstone/tests/numerics/pair_generators.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "touchstone/contact_core/geometry/pose.hpp"

namespace touchstone::numerics {
namespace {

void set(WorldVertices& hull, int i, const Vector3& p) {
  hull.x[i] = p.x(), hull.y[i] = p.y(), hull.z[i] = p.z();
}

template <typename Map>
WorldVertices mapped(const WorldVertices& hull, Map map) {
  WorldVertices out;
  for (int i = 0; i < 8; ++i) set(out, i, map(hull.vertex(i)));
  return out;
}

template <typename Map>
HullPair mapped(const HullPair& pair, Map map) {
  return {mapped(pair.a, map), mapped(pair.b, map)};
}

/// A lattice direction that stays within {0 .. range} when added to a coordinate a few times.
Vector3 lattice_direction(Random& random) {
  return {double(random_int(random, -1, 1)), double(random_int(random, -1, 1)),
          double(random_int(random, -1, 1))};
}

WorldVertices grid_hull(Random& random, int range) {
  const auto coordinate = [&] { return double(random_int(random, 0, range)); };
  const Vector3 origin{coordinate(), coordinate(), coordinate()};
  const int rank = random_int(random, 0, 7);
  const Vector3 u = lattice_direction(random), v = lattice_direction(random);
  WorldVertices hull;
  for (int i = 0; i < 8; ++i) {
    const double s = random_int(random, -range, range), t = random_int(random, -range, range);
    if (rank <= 2)
      set(hull, i, origin + (rank > 0 ? s : 0.0) * u + (rank > 1 ? t : 0.0) * v);
    else
      set(hull, i, {coordinate(), coordinate(), coordinate()});
  }
  return hull;
}

WorldVertices box(const Vector3& low, const Vector3& high) {
  WorldVertices hull;
  for (int i = 0; i < 8; ++i)
    set(hull, i,
        {i >> 2 & 1 ? high.x() : low.x(), i >> 1 & 1 ? high.y() : low.y(), i & 1 ? high.z() : low.z()});
  return hull;
}

WorldVertices grid_box(Random& random) {
  Vector3 low, high;
  for (int axis = 0; axis < 3; ++axis) {
    low(axis) = random_int(random, 0, 4);
    high(axis) = low(axis) + random_int(random, 1, 3);
  }
  return box(low, high);
}

}  // namespace

int random_int(Random& random, int low, int high) {
  return low + static_cast<int>(random() % static_cast<unsigned>(high - low + 1));
}

HullPair grid_pair(Random& random, int range) {
  HullPair pair{grid_hull(random, range), grid_hull(random, range)};
  if (random_int(random, 0, 3) == 0) return pair;
  // Half of the rest is pushed apart, so that touching is as common as overlap.
  const int steps = random_int(random, 1, range);
  const Vector3 by = steps * lattice_direction(random);
  pair.b = translated(pair.b, by);
  return pair;
}

HullPair mapped_grid_pair(Random& random, int range, int bits) {
  const HullPair pair = grid_pair(random, range);
  Matrix3 m;
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column) m(row, column) = random_int(random, -(1 << bits), 1 << bits);
  const Pose map{m, {double(random_int(random, -1000, 1000)), double(random_int(random, -1000, 1000)), 7}};
  return mapped(pair, [&](const Vector3& p) { return transform(map, p); });
}

HullPair aligned_box_pair(Random& random, double unit) {
  const HullPair pair{grid_box(random), grid_box(random)};
  return mapped(pair, [&](const Vector3& p) { return Vector3(p * unit); });
}

HullPair rotated_box_pair(Random& random) {
  const HullPair pair = aligned_box_pair(random, 0.1);
  const Pose pose{random_rotation(random), {uniform(random, -9, 9), uniform(random, -9, 9), 0}};
  return mapped(pair, [&](const Vector3& p) { return transform(pose, p); });
}

WorldVertices random_hexahedron(Random& random) {
  const Vector3 half = random_vector(random, 0.1, 1);
  WorldVertices hull = box(-half, half);
  const int kind = random_int(random, 0, 3);
  Matrix3 m = random_rotation(random);
  if (kind == 1) {
    Matrix3 shear = Matrix3::Identity();
    shear(0, 1) = uniform(random, -1, 1), shear(0, 2) = uniform(random, -1, 1);
    m = m * shear;
  }
  const double taper = kind == 2 ? uniform(random, 0.0, 0.9) : 0.0;
  const double warp = kind == 3 ? 0.05 : 0.0;
  const Pose pose{m, Vector3::Zero()};
  return mapped(hull, [&](const Vector3& p) {
    const double s = p.z() > 0.0 ? 1.0 - taper : 1.0;
    const Vector3 bend{warp * uniform(random, -1, 1), warp * uniform(random, -1, 1), 0.0};
    return transform(pose, Vector3(p.x() * s, p.y() * s, p.z()) + bend);
  });
}

WorldVertices translated(const WorldVertices& hull, const Vector3& by) {
  return mapped(hull, [&](const Vector3& p) { return Vector3(p + by); });
}

WorldVertices scaled(const WorldVertices& hull, int exponent) {
  return mapped(hull, [&](const Vector3& p) {
    return Vector3(std::scalbn(p.x(), exponent), std::scalbn(p.y(), exponent), std::scalbn(p.z(), exponent));
  });
}

WorldVertices permuted(const WorldVertices& hull, Random& random) {
  std::array<int, 8> order;
  std::iota(order.begin(), order.end(), 0);
  for (int i = 7; i > 0; --i) std::swap(order[i], order[random_int(random, 0, i)]);
  WorldVertices out;
  for (int i = 0; i < 8; ++i) set(out, i, hull.vertex(order[i]));
  return out;
}

HullPair scattered_pair(Random& random, int low, int high) {
  const auto coordinate = [&] {
    if (random_int(random, 0, 7) == 0) return 0.0;
    const double fraction = uniform(random, -1, 1);
    return std::scalbn(fraction, random_int(random, low, high));
  };
  HullPair pair;
  for (WorldVertices* hull : {&pair.a, &pair.b})
    for (int i = 0; i < 8; ++i) set(*hull, i, {coordinate(), coordinate(), coordinate()});
  return pair;
}

}  // namespace touchstone::numerics
