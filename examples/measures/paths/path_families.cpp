#include "touchstone/examples/measures/paths/path_families.hpp"

#include <array>
#include <string>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/examples/measures/common/random.hpp"
#include "touchstone/examples/measures/pairs/drawn_solids.hpp"
#include "touchstone/examples/measures/pairs/placements.hpp"

namespace touchstone::measures {
namespace {

struct Path {
  Hexahedron a, b;
  std::array<Pose, 2> X_WA, X_WB;  ///< at the path's ends
};

/// Before A's bounding sphere and beyond it [sums of the two radii].
constexpr double kOutside = 1.2;

// A moves a little; B comes from outside, to pass A at a distance or to end before, in or behind it.
// @param length how far B comes from and may go [sums of the radii].
Path pass_by(Hexahedron a, Hexahedron b, double length, bool turns, Random& random) {
  // A at both ends.
  const Pose X_WA = random_pose(random);
  const Pose X_WA_to{turns ? random_rotation(random) : X_WA.R, X_WA.p + uniform_vector(random, -0.5, 0.5)};
  // B's way, seen from A.
  const double reach = a.bounding_sphere().radius + b.bounding_sphere().radius;
  const Vector3 way = random_direction(random);
  Vector3 side = random_direction(random);
  side = side - way * dot(side, way);
  const Vector3 offset = side * (0.8 * reach * random.uniform());
  const double end = random.uniform(-0.5, length);
  const Pose X_WB{random_rotation(random), X_WA.p + offset - way * (length * reach)};
  const Pose X_WB_to{turns ? random_rotation(random) : X_WB.R, X_WA_to.p + offset + way * (end * reach)};
  return {std::move(a), std::move(b), {X_WA, X_WA_to}, {X_WB, X_WB_to}};
}

Path straight_path(Random& random) {
  Hexahedron a = random_box(random), b = random_box(random);
  return pass_by(std::move(a), std::move(b), kOutside, false, random);
}

Hexahedron any_hexahedron(Random& random) {
  const std::uint32_t kind = random.below(3);
  return kind == 0 ? random_box(random) : kind == 1 ? sheared_box(random) : tapered_box(random);
}

Path turning_path(Random& random) {
  Hexahedron a = any_hexahedron(random), b = any_hexahedron(random);
  return pass_by(std::move(a), std::move(b), kOutside, true, random);
}

// So long that most contacts are over between two poses of sixteen.
Path thin_path(Random& random) {
  constexpr double kLength = 4;
  Hexahedron a = thin_box(random), b = thin_box(random);
  const bool turns = random.below(2) == 0;
  return pass_by(std::move(a), std::move(b), kLength, turns, random);
}

// B along A's upper face, from 2^-20 to 2^-6 m above it to as much above it or in it, turning about the
// face's normal in half of the draws.
Path grazing_path(Random& random) {
  // Heights above the face.
  const Vector3 half_a = dyadic_half(random), half_b = dyadic_half(random);
  const double from = random.binary_scale(-20, -7), to = random.sign() * random.binary_scale(-20, -7);
  const double level = half_a.z() + half_b.z();
  // Places on it: the middle of B stays over A.
  const double turn = random.uniform(-1, 1), turned = random.below(2) == 0 ? random.uniform(-1, 1) : turn;
  std::array<Vector3, 2> place;
  for (Vector3& p : place) {
    p = uniform_vector(random, -0.9, 0.9);
    p = {p.x() * half_a.x(), p.y() * half_a.y(), level};
  }
  place[0].z() += from;
  place[1].z() += to;
  // In the world A rests.
  const Pose X_WA = random_pose(random);
  const std::array<Pose, 2> X_WB = {compose(X_WA, {turn_about_z(turn), place[0]}),
                                    compose(X_WA, {turn_about_z(turned), place[1]})};
  return {Hexahedron::from_size(half_a * 2), Hexahedron::from_size(half_b * 2), {X_WA, X_WA}, X_WB};
}

using MakePath = Path (*)(Random&);

constexpr std::array<PairFamily, 4> kFamilies = {{
    {"paths_straight", "boxes that pass each other without turning, or meet"},
    {"paths_turning", "boxes, sheared boxes and frusta that pass each other while both turn, or meet"},
    {"paths_thin", "slabs and needles that fly past each other or through, most contacts between two poses"},
    {"paths_grazing", "boxes that slide 2^-20 to 2^-6 m above a face and end above it or as deep in it"},
}};
constexpr std::array<MakePath, kFamilies.size()> kMakers = {straight_path, turning_path, thin_path,
                                                            grazing_path};
/// Streams of draws of their own, beyond those of the families of pairs.
constexpr std::uint64_t kFirstStream = 1000;

std::size_t family_index(std::string_view name) {
  for (std::size_t i = 0; i < kFamilies.size(); ++i)
    if (kFamilies[i].name == name) return i;
  throw InputError("unknown family of paths '" + std::string(name) +
                   "', known are: " + joined(kFamilies, &PairFamily::name));
}

}  // namespace

std::span<const PairFamily> path_families() { return kFamilies; }

PairSet make_path_family(std::string_view name, std::uint64_t seed, std::size_t count, std::size_t poses) {
  const std::size_t family = family_index(name);
  PairSet set;
  set.name = name;
  set.description = kFamilies[family].description;
  for (std::size_t i = 0; i < count; ++i) {
    Random random(mix_seed(seed, kFirstStream + family, i));
    const Path path = kMakers[family](random);
    append_path(
        set, set.name + ":" + std::to_string(i), {path.a, path.b},
        {RigidPath::between(path.X_WA[0], path.X_WA[1]), RigidPath::between(path.X_WB[0], path.X_WB[1])},
        poses);
  }
  return set;
}

}  // namespace touchstone::measures
