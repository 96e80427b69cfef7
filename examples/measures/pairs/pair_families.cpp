#include "touchstone/examples/measures/pairs/pair_families.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/examples/measures/common/random.hpp"
#include "touchstone/examples/measures/pairs/drawn_solids.hpp"
#include "touchstone/examples/measures/pairs/placements.hpp"
#include "touchstone/examples/measures/pairs/written_block.hpp"

namespace touchstone::measures {
namespace {

struct Pair {
  Hexahedron a, b;
  Pose X_WA, X_WB;
};

// ---- placements

// Centres up to the sum of the bounding spheres' radii apart: some overlap, some are apart.
Pair place_nearby(Hexahedron a, Hexahedron b, Random& random) {
  const Pose X_WA = random_pose(random);
  const double reach = a.bounding_sphere().radius + b.bounding_sphere().radius;
  const Vector3 direction = random_direction(random);
  const Vector3 p_WB = X_WA.p + direction * (reach * random.uniform(0.1, 1.0));
  const Pose X_WB{random_rotation(random), p_WB};
  return {std::move(a), std::move(b), X_WA, X_WB};
}

// Columns: x, the part of y_hint across x, and their product.
Matrix3 frame_from(const Vector3& x, const Vector3& y_hint) {
  const Vector3 y = unit(y_hint - x * dot(x, y_hint));
  Matrix3 frame;
  frame.col(0) = x;
  frame.col(1) = y;
  frame.col(2) = cross(x, y);
  return frame;
}

Matrix3 product(const Matrix3& left, const Matrix3& right) {
  Matrix3 result;
  for (int column = 0; column < 3; ++column) result.col(column) = rotate(left, Vector3(right.col(column)));
  return result;
}

// The feature of a solid that is to make contact: a point of it, a supporting normal (every vertex has n . v
// <= n . p), and a direction along it.
struct Feature {
  Vector3 point, normal, along;
};

Feature face_feature(const Hexahedron& solid, Random& random) {
  const int face = static_cast<int>(random.below(6));
  const auto& loop = Hexahedron::kFaceVertices[face];
  std::array<double, 4> weight;
  double sum = 0.0;
  for (double& w : weight) sum += w = random.uniform(0.1, 1);
  Vector3 point = Vector3::Zero();
  for (int i = 0; i < 4; ++i) point += solid.vertices()[loop[i]] * (weight[i] / sum);
  return {point, solid.face_plane(face).normal, solid.vertices()[loop[1]] - solid.vertices()[loop[0]]};
}

// The two faces of an edge are those whose loops hold both of its ends.
Feature edge_feature(const Hexahedron& solid, Random& random) {
  const int edge = static_cast<int>(random.below(12));
  const auto& ends = Hexahedron::kEdgeVertices[edge];
  Vector3 normal = Vector3::Zero();
  const double share = random.uniform(0.1, 0.9);
  double weight = share;
  for (int face = 0; face < 6; ++face) {
    const auto& loop = Hexahedron::kFaceVertices[face];
    if (std::count(loop.begin(), loop.end(), ends[0]) && std::count(loop.begin(), loop.end(), ends[1])) {
      normal += solid.face_plane(face).normal * weight;
      weight = 1.0 - share;
    }
  }
  const EdgeLine line = solid.edge_line(edge);
  return {line.origin + line.direction * random.uniform(0.2, 0.8), unit(normal), line.direction};
}

Feature vertex_feature(const Hexahedron& solid, Random& random) {
  const int vertex = static_cast<int>(random.below(8));
  Vector3 normal = Vector3::Zero();
  for (int face = 0; face < 6; ++face) {
    const auto& loop = Hexahedron::kFaceVertices[face];
    if (std::count(loop.begin(), loop.end(), vertex)) {
      normal += solid.face_plane(face).normal * random.uniform(0.3, 1);
    }
  }
  return {solid.vertices()[vertex], unit(normal), random_direction(random)};
}

// B's pose such that its feature faces A's at `gap` along the common normal: the signed distance is `gap`
// where the normals support the solids (and |gap| is the least way out, as it is for small gaps).
// spin_half_tangent: tan of half the angle between the two features' directions; NaN for a random angle.
Pose pose_against(const Pose& X_WA, const Feature& a, const Feature& b, double gap, double spin_half_tangent,
                  Random& random) {
  const Vector3 n_W = unit(rotate(X_WA.R, a.normal));
  Vector3 along_W = rotate(X_WA.R, a.along);
  if (std::isnan(spin_half_tangent)) {
    do along_W = random_direction(random);
    while (std::abs(dot(along_W, n_W)) > 0.9);
  } else {
    const Matrix3 F = frame_from(n_W, along_W);
    const double t = spin_half_tangent, d = 1.0 + t * t;
    along_W = Vector3(F.col(1)) * ((1.0 - t * t) / d) + Vector3(F.col(2)) * (2.0 * t / d);
  }
  Vector3 along_B = b.along;
  while (std::abs(dot(unit(along_B), b.normal)) > 0.9) along_B = random_direction(random);
  const Matrix3 R = product(frame_from(-n_W, along_W), frame_from(b.normal, along_B).transpose());
  const Vector3 p_W = transform(X_WA, a.point) + n_W * gap;
  return {R, p_W - rotate(R, b.point)};
}

constexpr double kRandomSpin = kNaN;

// Face against vertex, vertex against face, or edge against edge.
Pair place_against(Hexahedron a, Hexahedron b, double gap, Random& random) {
  const Pose X_WA = random_pose(random);
  const std::uint32_t kind = random.below(3);
  const Feature of_a = kind == 0   ? face_feature(a, random)
                       : kind == 1 ? vertex_feature(a, random)
                                   : edge_feature(a, random);
  const Feature of_b = kind == 0   ? vertex_feature(b, random)
                       : kind == 1 ? face_feature(b, random)
                                   : edge_feature(b, random);
  const Pose X_WB = pose_against(X_WA, of_a, of_b, gap, kRandomSpin, random);
  return {std::move(a), std::move(b), X_WA, X_WB};
}

Pair near_touching(double relative_gap, Random& random) {
  Hexahedron a = random_box(random), b = random_box(random);
  const double gap = std::max(a.size(), b.size()) * relative_gap * random.uniform(-1, 1);
  return place_against(std::move(a), std::move(b), gap, random);
}

// ---- families

// Draws that are arguments of one call stand in statements of their own, last argument first: the order in
// which the cases of older reports were drawn.

Pair random_pair(Random& random) {
  Hexahedron b = random_box(random), a = random_box(random);
  return place_nearby(std::move(a), std::move(b), random);
}

Pair near_1e3_pair(Random& random) { return near_touching(1e-3, random); }
Pair near_1e7_pair(Random& random) { return near_touching(1e-7, random); }

// B on A: a third touches exactly, a third is sunk by 2^-30 to 2^-10 m, a third stands on a tilted A, sunk by
// 1e-6 of size.
Pair resting_pair(Random& random) {
  const Vector3 half_a = dyadic_half(random), half_b = dyadic_half(random);
  Hexahedron a = Hexahedron::from_size(half_a * 2), b = Hexahedron::from_size(half_b * 2);
  const std::uint32_t kind = random.below(3);
  const double sunk = kind == 0 ? 0.0 : std::ldexp(1.0, -10 - static_cast<int>(random.below(21)));
  Pose X_AB{
      turn_about_z(random.uniform(-1, 1)),
      {random.uniform(-1, 1) * half_a.x(), random.uniform(-1, 1) * half_a.y(), half_a.z() + half_b.z()}};
  if (kind < 2) {
    X_AB.p.z() -= sunk;
    return {std::move(a), std::move(b), Pose{}, X_AB};
  }
  X_AB.p.z() -= 1e-6 * std::max(a.size(), b.size());
  const Pose X_WA = random_pose(random);
  const Pose X_WB = compose(X_WA, X_AB);
  return {std::move(a), std::move(b), X_WA, X_WB};
}

Pair sheared_pair(Random& random) {
  Hexahedron b = sheared_box(random), a = sheared_box(random);
  return place_nearby(std::move(a), std::move(b), random);
}

Pair tapered_pair(Random& random) {
  Hexahedron b = tapered_box(random), a = tapered_box(random);
  return place_nearby(std::move(a), std::move(b), random);
}

Pair containment_pair(Random& random) {
  Hexahedron a = random_box(random);
  const Vector3 half = a.half_extents();
  const double room = std::min({half.x(), half.y(), half.z()});
  const Vector3 shape = uniform_vector(random, 0.2, 1);
  Hexahedron b = Hexahedron::from_size(shape * (room * random.uniform(0.1, 0.8) / norm(shape)));
  const double reach = b.bounding_sphere().radius;
  const Pose X_WA = random_pose(random);
  Vector3 p_AB;
  for (int axis = 0; axis < 3; ++axis) p_AB[axis] = (half[axis] - reach) * random.uniform(-0.95, 0.95);
  const Pose X_WB{random_rotation(random), transform(X_WA, p_AB)};
  if (random.below(2) == 0) return {std::move(b), std::move(a), X_WB, X_WA};
  return {std::move(a), std::move(b), X_WA, X_WB};
}

Pair slabs_needles_pair(Random& random) {
  Hexahedron a = thin_box(random);
  Hexahedron b = random.below(2) == 0 ? thin_box(random) : random_box(random);
  if (random.below(2) == 0) return place_nearby(std::move(a), std::move(b), random);
  const double sign = random.sign();
  const double gap = sign * random.binary_scale(-30, -10);
  return place_against(std::move(a), std::move(b), gap, random);
}

Pair far_pair(Random& random) {
  constexpr std::array<double, 4> kDistances = {1e3, 1e4, 1e5, 1e6};
  Pair pair = random.below(2) == 0 ? random_pair(random) : near_touching(1e-3, random);
  const double distance = kDistances[random.below(4)];
  const Vector3 offset = random_direction(random) * distance;
  pair.X_WA.p += offset;
  pair.X_WB.p += offset;
  return pair;
}

// Crossing edges at an angle of 2^-4 to 2^-52.
Pair near_parallel_pair(Random& random) {
  Hexahedron a = random_box(random), b = random_box(random);
  constexpr std::array<double, 5> kGaps = {0.0, 1e-3, -1e-3, 1e-6, -1e-6};
  const int exponent = -5 - static_cast<int>(random.below(49));
  const double half_tangent = std::ldexp(random.sign(), exponent);
  const Pose X_WA = random_pose(random);
  const Feature of_a = edge_feature(a, random), of_b = edge_feature(b, random);
  const Pose X_WB = pose_against(X_WA, of_a, of_b, kGaps[random.below(5)], half_tangent, random);
  return {std::move(a), std::move(b), X_WA, X_WB};
}

// A prism over a square standing on its corner: vertices at (+-r, 0) and (0, +-r), exactly representable at
// any dyadic r.
Hexahedron diamond_prism(double r, double half_z) {
  std::array<Vector3, 8> vertices;
  const std::array<Vector3, 4> ring = {Vector3(-r, 0, 0), Vector3(0, r, 0), Vector3(0, -r, 0),
                                       Vector3(r, 0, 0)};
  for (int i = 0; i < 8; ++i) vertices[i] = ring[i >> 1] + Vector3(0, 0, i & 1 ? half_z : -half_z);
  return Hexahedron::from_vertices(vertices);
}

// Touching on exactly representable coordinates: by face, edge or vertex, and a prism's edge or vertex on a
// face or edge.
Pair touching_pair(Random& random) {
  const Vector3 a = dyadic_half(random), b = dyadic_half(random);
  const double z = random.dyadic(-2, 2, 6), y = random.dyadic(-2, 2, 6), x = random.dyadic(-2, 2, 6);
  const Vector3 origin(x, y, z);
  const std::uint32_t kind = random.below(5);
  Vector3 offset;  // lateral offsets stay inside the faces
  for (int axis = 0; axis < 3; ++axis) offset[axis] = random.dyadic(-1, 1, 4) * a[axis];
  const bool prism = kind >= 3;
  const Vector3 reach = prism ? Vector3(b.x(), b.x(), b.z()) : b;
  const int touching_axes = prism ? static_cast<int>(kind) - 2 : static_cast<int>(kind) + 1;
  const std::uint32_t first = prism ? 0 : random.below(3);
  for (int i = 0; i < touching_axes; ++i) {
    const auto axis = prism ? (i == 0 ? 0u : 2u) : (first + static_cast<std::uint32_t>(i)) % 3;
    offset[axis] = random.sign() * (a[axis] + reach[axis]);
  }
  Hexahedron solid_b = prism ? diamond_prism(b.x(), b.z()) : Hexahedron::from_size(b * 2);
  return {Hexahedron::from_size(a * 2), std::move(solid_b), Pose{Matrix3::Identity(), origin},
          Pose{Matrix3::Identity(), origin + offset}};
}

// A box that lies turned in its file: rounding its corners bends its faces.
Hexahedron bent_box(const Vector3& half, const Matrix3& R, Written how) {
  auto vertices = box_vertices(half);
  for (Vector3& v : vertices) v = as_written(rotate(R, v), how);
  return Hexahedron::from_vertices(vertices, WarpPolicy::accept);
}

// B, turned back flat, on A: a plain slab, a bent one or another bent block, from 1 mm deep to 0.1 mm apart.
Pair bent_pair(Random& random) {
  constexpr std::array kHow = {Written::with_nine_decimals, Written::with_six_decimals,
                               Written::with_four_decimals, Written::with_three_decimals, Written::as_float};
  const Written how = kHow[random.below(kHow.size())];
  const std::uint32_t kind = random.below(3);
  const Vector3 half_b = uniform_vector(random, 0.1, 1);
  const Vector3 half_a = kind < 2 ? uniform_vector(random, 0.8, 2) : uniform_vector(random, 0.1, 1);
  const Matrix3 R_A = random_rotation(random), R_B = random_rotation(random);
  const double turn = random.uniform(-1, 1), gap = random.uniform(-1e-3, 1e-4);
  const double x = random.uniform(-1, 1) * half_a.x(), y = random.uniform(-1, 1) * half_a.y();
  const Pose X_WS = random_pose(random);  // of A as it would lie, not turned
  const Pose X_SB{product(turn_about_z(turn), R_B.transpose()), {x, y, half_a.z() + half_b.z() + gap}};
  Hexahedron b = bent_box(half_b, R_B, how);
  if (kind == 0) return {Hexahedron::from_size(half_a * 2), std::move(b), X_WS, compose(X_WS, X_SB)};
  const Pose X_SA{R_A.transpose(), Vector3::Zero()};
  return {bent_box(half_a, R_A, how), std::move(b), compose(X_WS, X_SA), compose(X_WS, X_SB)};
}

using MakePair = Pair (*)(Random&);

constexpr std::array<PairFamily, 12> kFamilies = {{
    {"random", "boxes of 0.2 to 2 m, centres up to the sum of their radii apart"},
    {"near_1e-3", "boxes within 1e-3 of size of touching, both sides; vertex on face and crossing edges"},
    {"near_1e-7", "boxes within 1e-7 of size of touching, both sides; vertex on face and crossing edges"},
    {"resting", "boxes stacked face on face: exactly touching, sunk by 2^-30 to 2^-10 m, or tilted"},
    {"sheared", "sheared boxes, centres up to the sum of their radii apart"},
    {"tapered", "frusta with a shifted top, centres up to the sum of their radii apart"},
    {"containment", "a small box wholly inside a larger one"},
    {"slabs_needles", "boxes 2^-7 to 2^-20 as thin as long, nearby or within 2e-3 m of touching"},
    {"far", "random and near-touching boxes 1e3 to 1e6 m from the origin"},
    {"near_parallel",
     "boxes whose crossing edges meet at 2^-4 to 2^-52 rad, 0, 1e-6 or 1e-3 m from touching"},
    {"touching", "exactly touching on representable coordinates: face, edge, vertex, prism edge and vertex"},
    {"bent",
     "blocks whose corners a file wrote (9 to 3 decimals, floats), flat on each other, 1 mm deep to 0.1 mm "
     "apart"},
}};

constexpr std::array<MakePair, kFamilies.size()> kMakers = {
    random_pair,      near_1e3_pair,      near_1e7_pair, resting_pair,       sheared_pair,  tapered_pair,
    containment_pair, slabs_needles_pair, far_pair,      near_parallel_pair, touching_pair, bent_pair};

std::size_t family_index(std::string_view name) {
  for (std::size_t i = 0; i < kFamilies.size(); ++i) {
    if (kFamilies[i].name == name) return i;
  }
  throw InputError("unknown pair family '" + std::string(name) +
                   "', known are: " + joined(kFamilies, &PairFamily::name));
}

void append_pair(PairSet& set, std::size_t family, std::uint64_t seed, std::size_t index) {
  Random random(mix_seed(seed, family, index));
  Pair pair = kMakers[family](random);
  const auto first = static_cast<SolidIndex>(set.solids.size());
  set.solids.push_back(std::move(pair.a));
  set.solids.push_back(std::move(pair.b));
  set.poses.push_back(pair.X_WA);
  set.poses.push_back(pair.X_WB);
  set.pairs.push_back({first, first + 1});
}

PairSet empty_set(std::size_t family) {
  PairSet set;
  set.name = kFamilies[family].name;
  set.description = kFamilies[family].description;
  return set;
}

}  // namespace

std::span<const PairFamily> pair_families() { return kFamilies; }

PairSet make_pair_family(std::string_view name, std::uint64_t seed, std::size_t count) {
  const std::size_t family = family_index(name);
  PairSet set = empty_set(family);
  set.solids.reserve(2 * count);
  set.poses.reserve(2 * count);
  set.pairs.reserve(count);
  for (std::size_t i = 0; i < count; ++i) append_pair(set, family, seed, i);
  return set;
}

PairSet make_family_pair(std::string_view name, std::uint64_t seed, std::size_t index) {
  const std::size_t family = family_index(name);
  PairSet set = empty_set(family);
  append_pair(set, family, seed, index);
  set.ids = {std::string(name) + ":" + std::to_string(index)};
  return set;
}

}  // namespace touchstone::measures
