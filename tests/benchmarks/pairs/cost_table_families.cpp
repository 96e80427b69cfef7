#include "touchstone/tests/benchmarks/pairs/cost_table_families.hpp"

#include <array>
#include <cmath>

#include "touchstone/examples/measures/common/random.hpp"
#include "touchstone/examples/measures/pairs/pair_families.hpp"

namespace touchstone {
namespace {

using measures::PairSet;
using measures::Random;

constexpr std::array<std::string_view, 15> kFamilies = {
    "wall",     "wall_1e-12",    "aligned_tapered", "wall_turned", "blocks_turned",
    "touching", "resting",       "near_1e-7",       "near_1e-3",   "slabs_needles",
    "far",      "near_parallel", "random",          "tapered",     "sheared"};

/// A block with its top a tenth narrower in x and y.
Hexahedron tapered_block(const Vector3& size) {
  std::array<Vector3, 8> corners;
  for (int i = 0; i < 8; ++i) {
    const double share = (i & 1) != 0 ? 0.45 : 0.5;
    corners[i] = {(i & 4) != 0 ? share * size.x() : -share * size.x(),
                  (i & 2) != 0 ? share * size.y() : -share * size.y(),
                  (i & 1) != 0 ? 0.5 * size.z() : -0.5 * size.z()};
  }
  return Hexahedron::from_vertices(corners, WarpPolicy::accept);
}

/// Blocks of a wall: neighbours in a course, or one block on the seam of two below.
struct Wall {
  double gap = 0.0;  // [m], along the direction of contact; negative: deep
  bool is_tapered = false;
  bool is_turned = false;  // the whole wall, every pair's by its own angles
};

void add_wall_pair(const Wall& wall, Random& random, PairSet& set) {
  const Vector3 size = measures::uniform_vector(random, 0.1, 1.0);
  const std::uint32_t axis = wall.is_tapered ? 2 : random.below(3);
  Vector3 offset = Vector3::Zero();
  offset[axis] = size[axis] + wall.gap * size[axis];
  if (axis == 2) offset.x() = 0.5 * size.x() * static_cast<double>(random.below(3));
  const Matrix3 R = wall.is_turned ? measures::random_rotation(random) : Matrix3(Matrix3::Identity());
  const Vector3 p = measures::uniform_vector(random, -5.0, 5.0);
  const Hexahedron block = wall.is_tapered ? tapered_block(size) : Hexahedron::from_size(size);
  const auto first = static_cast<SolidIndex>(set.solids.size());
  set.solids.insert(set.solids.end(), 2, block);
  set.poses.push_back({R, p});
  set.poses.push_back({R, p + rotate(R, offset)});
  set.pairs.push_back({first, first + 1});
}

PairSet make_wall(std::string_view name, const Wall& wall, std::uint64_t seed, std::size_t count) {
  PairSet set;
  set.name = name;
  for (std::size_t i = 0; i < count; ++i) {
    Random random(measures::mix_seed(seed, 100, i));
    add_wall_pair(wall, random, set);
  }
  return set;
}

}  // namespace

std::span<const std::string_view> cost_table_families() { return kFamilies; }

PairSet make_cost_table_family(std::string_view name, std::uint64_t seed, std::size_t count) {
  if (name == "wall") return make_wall(name, {}, seed, count);
  if (name == "wall_1e-12") return make_wall(name, {.gap = 1e-12}, seed, count);
  if (name == "aligned_tapered") return make_wall(name, {.gap = -0.01, .is_tapered = true}, seed, count);
  if (name == "wall_turned") return make_wall(name, {.is_turned = true}, seed, count);
  if (name == "blocks_turned") return make_wall(name, {.is_tapered = true, .is_turned = true}, seed, count);
  return measures::make_pair_family(name, seed, count);
}

}  // namespace touchstone
