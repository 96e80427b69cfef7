#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>

#include "touchstone/adapters/exact/exact.hpp"
#include "touchstone/adapters/exact/signed_distance.hpp"
#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/native/native.hpp"
#include "touchstone/contact_core/numerics/rounded_predicate.hpp"
#include "touchstone/tests/support/ask.hpp"
#include "touchstone/tests/support/counting_allocator.hpp"
#include "touchstone/tests/support/random_solid.hpp"
#include "touchstone/tests/support/scale_of.hpp"

// `native` against `exact` on random pairs of every kind of core, most of them brought near touch.
// TOUCHSTONE_ROUNDED_PAIRS asks for another number of pairs, TOUCHSTONE_ROUNDED_SEED for another seed.

namespace touchstone {
namespace {

std::uint64_t figure_of(const char* name, std::uint64_t otherwise) {
  const char* text = std::getenv(name);
  return text ? std::strtoull(text, nullptr, 10) : otherwise;
}

Hexahedron random_rounded(Random& random) {
  // Spheres, capsules, flat and rounded boxes, padded sheared blocks, and solids without a radius.
  const double radius = random.one_in(8) ? 1e-9 : random.uniform(0.01, 0.6);
  switch (random.below(8)) {
    case 0:
      return Hexahedron::sphere(radius);
    case 1:
      return Hexahedron::capsule(radius, random.uniform(0.1, 2.0));
    case 2: {
      const double x = random.uniform(0.1, 1.5), y = random.uniform(0.1, 1.5);
      return Hexahedron::rounded_box({x, 0, y}, radius);
    }
    case 3: {
      const double x = random.uniform(0.1, 1.5), y = random.uniform(0.1, 1.5), z = random.uniform(0.1, 1.5);
      return Hexahedron::rounded_box({x, y, z}, radius);
    }
    case 4: {
      std::array<Vector3, 8> v = Hexahedron::from_size({1, 1, 1}).vertices();
      const double shear = random.uniform(-0.8, 0.8);
      for (Vector3& p : v) p.x() += shear * p.z();
      return Hexahedron::from_vertices(v).padded(radius);
    }
    case 5:
      return random_solid(random, 1.0);
    default:
      return random_solid(random, 1.0).padded(radius);
  }
}

Hexahedron scaled(const Hexahedron& solid, double scale) {
  if (solid.is_box() && !solid.is_rounded())
    return Hexahedron::from_size((2.0 * scale) * solid.half_extents());
  if (solid.is_box())
    return Hexahedron::rounded_box((2.0 * scale) * solid.half_extents(), scale * solid.radius());
  std::array<Vector3, 8> v = solid.vertices();
  for (Vector3& p : v) p = scale * p;
  const Hexahedron core = Hexahedron::from_vertices(v, WarpPolicy::accept);
  return solid.is_rounded() ? core.padded(scale * solid.radius()) : core;
}

struct RandomPair {
  std::array<Hexahedron, 2> solids;
  std::array<Pose, 2> poses;
};

ExactResult truth_of(const RandomPair& pair) {
  WorldVertices a, b;
  world_vertices(pair.solids[0], pair.poses[0], a), world_vertices(pair.solids[1], pair.poses[1], b);
  return exact_rounded_distance(a, pair.solids[0].radius(), b, pair.solids[1].radius());
}

RandomPair ordinary_pair(std::mt19937_64& engine) {
  Random random(engine());
  RandomPair pair{{random_rounded(random), random_rounded(random)}, {}};
  const bool upright = random.one_in(4);
  const double far = random.one_in(3) ? 0x1p20 : 1.0;
  const Vector3 centre = random.vector(far);
  for (Pose& X : pair.poses) {
    X = random_pose(engine, centre, 1.0);
    if (upright) X.R = Matrix3::Identity();
  }
  if (random.one_in(4)) return pair;
  const ExactResult start = truth_of(pair);  // near touch, or as near as rounding brings them
  pair.poses[1].p -= start.separation * start.n_AB_W;
  if (random.one_in(2)) pair.poses[1].p += random.uniform(-1e-3, 1e-3) * start.n_AB_W;
  return pair;
}

// One in eight at magnitudes that kernels do not take.
RandomPair random_pair(std::mt19937_64& engine) {
  RandomPair pair = ordinary_pair(engine);
  if (engine() % 8 != 0) return pair;
  const double scale = engine() % 2 == 0 ? 0x1p-300 : 0x1p300;
  for (Hexahedron& solid : pair.solids) solid = scaled(solid, scale);
  for (Pose& X : pair.poses) X.p = scale * X.p;
  return pair;
}

double core_separation_along(const RandomPair& pair, const Vector3& n) {
  WorldVertices a, b;
  world_vertices(pair.solids[0], pair.poses[0], a), world_vertices(pair.solids[1], pair.poses[1], b);
  return exact_separation_along(a, b, n);
}

// Distance of a witness from its core, less the radius; of solids without one: from the surface.
double off_surface(const RandomPair& pair, int side, const Vector3& p) {
  WorldVertices v;
  world_vertices(pair.solids[side], pair.poses[side], v);
  return exact_surface_distance(v, p) - pair.solids[side].radius();
}

struct Worst {
  double separation = 0.0, normal = 0.0, witness = 0.0;
};

void compare(const RandomPair& pair, const Answer& answer, Worst& worst) {
  const ExactResult truth = truth_of(pair);
  const PairStatus expected =
      truth.pair_class == PairClass::separated ? PairStatus::separated : PairStatus::overlapping;
  ASSERT_EQ(answer.status, expected) << truth.separation;
  const PairGeometry& g = answer.geometry;
  ASSERT_EQ(g.separation > 0.0, expected == PairStatus::separated);
  const double scale = scale_of(pair.solids[0], pair.poses[0], pair.solids[1], pair.poses[1]);
  worst.separation = std::max(worst.separation, std::abs(g.separation - truth.separation) / scale);
  const double along =
      core_separation_along(pair, g.n_AB_W) - (pair.solids[0].radius() + pair.solids[1].radius());
  worst.normal = std::max(worst.normal, std::abs(along - truth.separation) / scale);
  const double apart = norm(g.p_B_W - g.p_A_W - g.separation * g.n_AB_W);
  for (const double error : {off_surface(pair, 0, g.p_A_W), off_surface(pair, 1, g.p_B_W), apart})
    worst.witness = std::max(worst.witness, std::abs(error) / scale);
}

TEST(RoundedRandomPairs, NativeAgreesWithExact) {
  const std::uint64_t count = figure_of("TOUCHSTONE_ROUNDED_PAIRS", 1000);
  std::mt19937_64 engine(figure_of("TOUCHSTONE_ROUNDED_SEED", 20261));
  const auto native = make_native();
  Worst worst;
  for (std::uint64_t i = 0; i < count; ++i) {
    // A pair with a rounded solid.
    const RandomPair pair = random_pair(engine);
    if (!pair.solids[0].is_rounded() && !pair.solids[1].is_rounded()) continue;
    SCOPED_TRACE(i);
    // Class and geometry against `exact`; overlap and the reverse pair against distance.
    native->build(pair.solids);
    const Answer answer = ask(*native, pair.poses, {.kind = QueryKind::distance});
    compare(pair, answer, worst);
    if (HasFatalFailure()) return;
    ASSERT_EQ(ask(*native, pair.poses, {.kind = QueryKind::overlap}).status, answer.status);
    const Answer reversed = ask(*native, pair.poses, {.kind = QueryKind::distance}, {1, 0});
    ASSERT_EQ(reversed.status, answer.status);
    ASSERT_EQ(reversed.geometry.separation, answer.geometry.separation);
    ASSERT_EQ(reversed.geometry.n_AB_W, Vector3(-answer.geometry.n_AB_W));
  }
  // The worst of all, in units of the resolution that is claimed.
  const double resolution = native->capabilities().resolution.relative;
  RecordProperty("separation", std::to_string(worst.separation / resolution));
  RecordProperty("normal", std::to_string(worst.normal / resolution));
  RecordProperty("witness", std::to_string(worst.witness / resolution));
  EXPECT_LE(worst.separation, resolution);
  EXPECT_LE(worst.normal, resolution);
  EXPECT_LE(worst.witness, 2 * resolution);
}

// Each point is on both surfaces to (1 - cosine) of a tilted face's radius, and none is deeper than the pair.
TEST(RoundedRandomPairs, PointsOfManifoldsAreOnTheSurfaces) {
  std::mt19937_64 engine(20262);
  const auto native = make_native();
  int several = 0;
  for (int i = 0; i < 1000; ++i) {
    const RandomPair pair = random_pair(engine);
    if (!pair.solids[0].is_rounded() && !pair.solids[1].is_rounded()) continue;
    SCOPED_TRACE(i);
    native->build(pair.solids);
    const Answer answer =
        ask(*native, pair.poses, {.kind = QueryKind::manifold, .max_point_separation = 0.01});
    const double scale = scale_of(pair.solids[0], pair.poses[0], pair.solids[1], pair.poses[1]);
    ASSERT_GE(answer.points.size(), 1u);
    several += answer.points.size() > 1 ? 1 : 0;
    double deepest = answer.points[0].separation;
    for (const ContactPoint& point : answer.points) {
      deepest = std::min(deepest, point.separation);
      // Deep pairs: a corner of the clip may be below the other's surface, never beyond its own.
      const double below_a = off_surface(pair, 0, point.p_A_W), below_b = off_surface(pair, 1, point.p_B_W);
      EXPECT_LE(std::abs(below_a), 1e-3 * pair.solids[0].radius() + 1e-13 * scale);
      EXPECT_LE(std::abs(below_b), 1e-3 * pair.solids[1].radius() + 1e-13 * scale);
    }
    EXPECT_EQ(deepest, answer.geometry.separation);
    const Answer reversed =
        ask(*native, pair.poses, {.kind = QueryKind::manifold, .max_point_separation = 0.01}, {1, 0});
    ASSERT_EQ(reversed.points.size(), answer.points.size());
    for (std::size_t k = 0; k < answer.points.size(); ++k) {
      EXPECT_EQ(reversed.points[k].p_A_W, answer.points[k].p_B_W);
      EXPECT_EQ(reversed.points[k].p_B_W, answer.points[k].p_A_W);
      EXPECT_EQ(reversed.points[k].separation, answer.points[k].separation);
    }
  }
  EXPECT_GT(several, 20);
}

TEST(RoundedRandomPairs, OneBatchAnswersAsPairByPairAndAllocatesNothing) {
  // A crowd of both kinds, of which one has no pose.
  Random random(20263);
  std::mt19937_64 engine(20264);
  std::vector<Hexahedron> solids;
  std::vector<Pose> poses;
  std::vector<SolidPair> pairs;
  for (SolidIndex b = 0; b < 40; ++b) {
    solids.push_back(b % 3 == 0 ? random_solid(random, 1.0) : random_rounded(random));
    poses.push_back(random_pose(engine, 1.0));
    for (SolidIndex a = 0; a < b; ++a) pairs.push_back({a, b});
  }
  poses[7].p.x() = kNaN;
  const auto native = make_native();
  native->build(solids);
  const auto workspace = native->make_workspace();
  // Each query: a batch without allocations, then pair by pair.
  for (const QueryKind kind : {QueryKind::overlap, QueryKind::distance, QueryKind::manifold}) {
    Answers all;
    evaluate(*native, pairs, poses, {.kind = kind}, *workspace, all);
    const std::size_t before = allocation_count();
    evaluate(*native, pairs, poses, {.kind = kind}, *workspace, all);
    EXPECT_EQ(allocation_count(), before);
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      const Answers one = ask(*native, {&pairs[i], 1}, poses, {.kind = kind});
      ASSERT_EQ(one.status[0], all.status[i]) << i;
      if (kind == QueryKind::overlap || all.status[i] == PairStatus::failed) continue;
      ASSERT_EQ(one.geometry[0].separation, all.geometry[i].separation) << i;
      ASSERT_EQ(one.geometry[0].point_count, all.geometry[i].point_count) << i;
    }
  }
}

// The predicate alone, on points whose distances are known in integers, at magnitudes of every exponent.
TEST(RoundedPredicate, ComparesSquaresAtAllMagnitudes) {
  const auto point = [](double x, double y, double z) {
    WorldVertices v;
    v.x.fill(x), v.y.fill(y), v.z.fill(z);
    return v;
  };
  for (int k = -1060; k <= 1000; k += 20) {
    const auto s = [k](double value) { return std::scalbn(value, k); };
    const WorldVertices a = point(0, 0, 0), b = point(s(2), s(3), s(6));
    EXPECT_TRUE(numerics::rounded_hulls_intersect(a, s(3), b, s(4))) << k;
    EXPECT_FALSE(numerics::rounded_hulls_intersect(a, std::nextafter(s(3), 0.0), b, s(4))) << k;
    EXPECT_TRUE(numerics::rounded_hulls_intersect(a, std::nextafter(s(3), 1e308), b, s(4))) << k;
  }
  // Mixed: a radius far below the coordinates' last bit decides.
  const WorldVertices a = point(0, 0, 0), b = point(0x1p500, 0, 0);
  EXPECT_TRUE(numerics::rounded_hulls_intersect(a, 0x1p500, b, 0x1p-1074));
  EXPECT_TRUE(numerics::rounded_hulls_intersect(a, 0x1p500, b, 0.0));
  EXPECT_FALSE(numerics::rounded_hulls_intersect(a, std::nextafter(0x1p500, 0), b, 0x1p-1074));
}

}  // namespace
}  // namespace touchstone
