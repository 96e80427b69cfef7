#include "touchstone/tests/proof/pairs/families.hpp"

#include <array>
#include <cmath>
#include <vector>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/examples/measures/common/random.hpp"
#include "touchstone/examples/measures/pairs/pair_families.hpp"
#include "touchstone/tests/proof/pairs/byte_decoder.hpp"

namespace touchstone::proof {
namespace {

using measures::Random;

PosedSolids compared_pair(std::size_t family, std::uint64_t seed, std::uint64_t index) {
  const measures::PairSet set =
      measures::make_family_pair(measures::pair_families()[family].name, seed, index);
  const SolidPair pair = set.pairs[0];
  return {set.solids[pair.a], set.solids[pair.b], set.poses[pair.a], set.poses[pair.b]};
}

PosedSolids any_compared_pair(Random& random, std::uint64_t seed, std::uint64_t index) {
  return compared_pair(random.below(static_cast<std::uint32_t>(measures::pair_families().size())), seed,
                       index);
}

Hexahedron scaled(const Hexahedron& solid, double factor) {
  if (solid.is_box()) return Hexahedron::from_size(solid.half_extents() * (2.0 * factor));
  std::array<Vector3, 8> vertices = solid.vertices();
  for (Vector3& v : vertices) v *= factor;
  return Hexahedron::from_vertices(vertices, WarpPolicy::accept);
}

PosedSolids scaled_pair(Random& random, std::uint64_t seed, std::uint64_t index) {
  PosedSolids pair = any_compared_pair(random, seed, index);
  const double factor = std::ldexp(1.0, static_cast<int>(random.below(601)) - 300);
  pair.a = scaled(pair.a, factor), pair.b = scaled(pair.b, factor);
  pair.X_WA.p *= factor, pair.X_WB.p *= factor;
  return pair;
}

Pose rounded_pose(const Pose& X) {
  Pose out;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) out.R(i, j) = in_single_precision(X.R(i, j));
    out.p(i) = in_single_precision(X.p(i));
  }
  return out;
}

PosedSolids single_precision_pair(Random& random, std::uint64_t seed, std::uint64_t index) {
  PosedSolids pair = any_compared_pair(random, seed, index);
  pair.X_WA = rounded_pose(pair.X_WA), pair.X_WB = rounded_pose(pair.X_WB);
  return pair;
}

// Corners of a box moved by up to 2^-3 to 2^-50 of its sides, drawn again until convex.
Hexahedron warped_solid(Random& random) {
  for (;;) {
    const Vector3 half = measures::uniform_vector(random, 0.1, 1);
    const double reach = std::ldexp(1.0, -3 - static_cast<int>(random.below(48)));
    std::array<Vector3, 8> vertices;
    for (int i = 0; i < 8; ++i) {
      const auto coordinate = [&](int axis) {
        return (i >> (2 - axis) & 1 ? 1.0 : -1.0) * half[axis] * (1.0 + reach * random.uniform(-1, 1));
      };
      for (int axis = 0; axis < 3; ++axis) vertices[i][axis] = coordinate(axis);
    }
    try {
      return Hexahedron::from_vertices(vertices, WarpPolicy::accept);
    } catch (const InputError&) {
      continue;
    }
  }
}

// Half of the pairs apart by random amounts, half with a vertex of B within 2^-10 to 2^-60 of the middle of a
// face's diagonal of A.
PosedSolids warped_pair(Random& random) {
  const Hexahedron a = warped_solid(random), b = warped_solid(random);
  const Pose X_WA{random_rotation(random), measures::random_direction(random)};
  Pose X_WB{random_rotation(random), Vector3::Zero()};
  if (random.below(2) == 0) {
    const double reach = a.bounding_sphere().radius + b.bounding_sphere().radius;
    const double share = random.uniform(0.1, 1.0);
    X_WB.p = X_WA.p + measures::random_direction(random) * (reach * share);
    return {a, b, X_WA, X_WB};
  }
  const auto& loop = Hexahedron::kFaceVertices[random.below(6)];
  const Vector3 middle = a.vertices()[loop[0]] * 0.5 + a.vertices()[loop[2]] * 0.5;
  const double gap = std::ldexp(1.0, -10 - static_cast<int>(random.below(51)));
  X_WB.p = transform(X_WA, middle) + measures::random_direction(random) * gap;
  X_WB.p -= rotate(X_WB.R, b.vertices()[random.below(8)]);
  return {a, b, X_WA, X_WB};
}

/// 2^low to twice 2^high, evenly over the powers. One draw after the other: a call's arguments have no order.
double any_between(Random& random, int low, int high) {
  const int exponent = high - static_cast<int>(random.below(static_cast<std::uint32_t>(high - low + 1)));
  return std::ldexp(random.uniform(1, 2), exponent);
}

// A box thin by 2^-5 to 2^-60 in one or two directions (a sheet, a needle, a ribbon), its corners moved by
// shares of their own coordinates: by up to 2^-2 to 2^-54 of them each, or drawn out as pairs opposite in
// either layer, so that hull edges are diagonals of the side faces.
Hexahedron sliver(Random& random) {
  for (;;) {
    Vector3 half = measures::uniform_vector(random, 0.2, 1);
    const auto thin = [&] { return any_between(random, -60, -5); };
    half.x() *= thin();
    if (random.below(2) == 0) half.y() *= thin();
    const double moved = any_between(random, -54, -3);
    const bool draws = random.below(2) == 0, turns = random.below(3) == 0;
    const Matrix3 R = random_rotation(random);
    std::array<Vector3, 8> vertices;
    for (int i = 0; i < 8; ++i) {
      Vector3& v = vertices[i] = {i & 4 ? half.x() : -half.x(), i & 2 ? half.y() : -half.y(),
                                  i & 1 ? half.z() : -half.z()};
      const bool is_drawn = (v.y() * v.z() > 0) == (v.x() < 0);
      for (int axis = draws ? 1 : 0; axis < 3; ++axis)
        v[axis] *= draws ? (is_drawn ? 1.0 + moved : 1.0) : 1.0 + moved * random.uniform(-1, 1);
      if (turns) v = rotate(R, v);
    }
    try {
      return Hexahedron::from_vertices(vertices, WarpPolicy::accept);
    } catch (const InputError&) {
      continue;
    }
  }
}

// Anywhere, or a vertex of B near the middle of two vertices of A, or B almost A where it lies.
PosedSolids sliver_pair(Random& random) {
  const Hexahedron a = sliver(random), other = sliver(random);
  const Pose X_WA{random_rotation(random), measures::random_direction(random)};
  const double gap = any_between(random, -59, -2);
  const Vector3 off = measures::random_direction(random) * gap;
  Pose X_WB{random_rotation(random), X_WA.p + measures::random_direction(random) * 0.1};
  const std::uint32_t placing = random.below(3);
  if (placing == 0) return {a, other, X_WA, X_WB};
  if (placing == 1) {
    const Vector3 middle = a.vertices()[random.below(8)] * 0.5 + a.vertices()[random.below(8)] * 0.5;
    X_WB.p = (transform(X_WA, middle) + off) - rotate(X_WB.R, other.vertices()[random.below(8)]);
    return {a, other, X_WA, X_WB};
  }
  const Matrix3 turn = rotation_from_quaternion(1, off.x(), off.y(), off.z());
  return {a, a, X_WA, {compose(X_WA, Pose{turn, Vector3::Zero()}).R, X_WA.p + off}};
}

PosedSolids decoded_pair(Random& random) {
  for (;;) {
    std::array<std::uint8_t, kDecodedBytes> bytes;
    for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(random.next() >> 56);
    if (const auto pair = decode_pair(bytes)) return *pair;
  }
}

/// A box; a third of them with a top a tenth narrower.
Hexahedron wall_block(Random& random, const Vector3& size) {
  if (random.below(3) != 0) return Hexahedron::from_size(size);
  std::array<Vector3, 8> vertices;
  for (int i = 0; i < 8; ++i) {
    const double share = i & 1 ? 0.45 : 0.5;
    vertices[i] = {i & 4 ? share * size.x() : -share * size.x(), i & 2 ? share * size.y() : -share * size.y(),
                   i & 1 ? 0.5 * size.z() : -0.5 * size.z()};
  }
  return Hexahedron::from_vertices(vertices, WarpPolicy::accept);
}

// The neighbour of a block in a wall, grid, stack or rail of equal ones, across a face, an edge or a corner
// or half a block aside: touching but for a gap of 0, an ulp or so, 1e-12 or 1e-9 m, or as deep.
PosedSolids block_pair(Random& random) {
  Vector3 size = measures::uniform_vector(random, 0.1, 1);
  if (random.below(3) == 0) size[random.below(3)] *= 16.0;  // rails
  const Hexahedron block = wall_block(random, size);
  const std::uint32_t axis = random.below(3);
  Vector3 offset;
  for (int k = 0; k < 3; ++k) offset[k] = 0.5 * (static_cast<int>(random.below(5)) - 2) * size[k];
  const std::array<double, 4> gaps = {0.0, 0x1p-52, 1e-12, 1e-9};
  const double gap = gaps[random.below(4)];
  offset[axis] = size[axis] + random.sign() * gap;
  const bool is_turned = random.below(2) == 0;
  const Matrix3 R = is_turned ? random_rotation(random) : Matrix3(Matrix3::Identity());
  const Vector3 p = measures::uniform_vector(random, -5, 5);
  return {block, block, {R, p}, {R, p + rotate(R, offset)}};
}

constexpr std::array<Family, 6> kOwn = {{
    {"scaled", "any family of the comparison, by 2^-300 to 2^300"},
    {"single_precision", "any family of the comparison, poses rounded to single precision"},
    {"warped", "solids warped by 2^-3 to 2^-50 of their sides, nearby or a vertex next to a face's diagonal"},
    {"slivers", "sheets, needles and ribbons 2^-5 to 2^-60 thick, warped, drawn out, nearly coincident"},
    {"decoded", "random bytes through the fuzzer's decoder"},
    {"blocks", "neighbours in walls, grids, stacks and rails, aligned and turned, 0 to 1e-9 m apart or deep"},
}};

std::vector<Family> all_families() {
  std::vector<Family> all;
  for (const measures::PairFamily& family : measures::pair_families())
    all.push_back({family.name, family.description});
  all.insert(all.end(), kOwn.begin(), kOwn.end());
  return all;
}

}  // namespace

std::span<const Family> families() {
  static const std::vector<Family> all = all_families();
  return all;
}

PosedSolids make_pair(std::size_t family, std::uint64_t seed, std::uint64_t index) {
  const std::size_t compared = measures::pair_families().size();
  if (family < compared) return compared_pair(family, seed, index);
  // Streams of the families' own numbers, from when the comparison had eleven.
  Random random(measures::mix_seed(seed, family - compared + 1011, index));
  switch (family - compared) {
    case 0:
      return scaled_pair(random, seed, index);
    case 1:
      return single_precision_pair(random, seed, index);
    case 2:
      return warped_pair(random);
    case 3:
      return sliver_pair(random);
    case 4:
      return decoded_pair(random);
    default:
      return block_pair(random);
  }
}

}  // namespace touchstone::proof
