#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/native/distance/kernel_distances.hpp"
#include "touchstone/tests/native/distance/all_features_reference.hpp"
#include "touchstone/tests/native/native_fixture.hpp"

// Pairs that are apart: the kernels in lanes against each other, against single calls and the reference.

namespace touchstone {
namespace {

using native::DistanceRecord;
using native::Kernels;
using native::PairIndices;
using native::SolidKind;

struct Pair {
  Hexahedron a, b;
  Pose X_WA, X_WB;
};

/// Moves B along the pair's normal to `gap`.
void move_to(double gap, Pair& pair) {
  const PairGeometry g = ask(pair.a, pair.X_WA, pair.b, pair.X_WB, QueryKind::distance).geometry;
  pair.X_WB.p += (gap - g.separation) * g.n_AB_W;
}

/// Two boxes whose long edges cross at a small angle, the corner edges on top of each other, `gap` apart.
Pair crossing_edges(double angle, double gap, Random& random) {
  const Hexahedron a = Hexahedron::from_size({random.uniform(0.2, 2), random.uniform(0.2, 2), 2});
  const Hexahedron b = Hexahedron::from_size({random.uniform(0.2, 2), random.uniform(0.2, 2), 2});
  const Vector3 corner_a(a.half_extents().x(), a.half_extents().y(), random.uniform(-0.8, 0.8));
  const Vector3 corner_b(-b.half_extents().x(), -b.half_extents().y(), random.uniform(-0.8, 0.8));
  const Vector3 n = Vector3(1, random.uniform(0.5, 2), 0).normalized();
  Pose turn;  // about n
  turn.R = rotation_from_quaternion(1.0, n.x() * angle / 2, n.y() * angle / 2, 0.0);
  Pose X_AB = turn;
  X_AB.p = corner_a + gap * n - rotate(turn.R, corner_b);
  const Pose X_WA = random.pose(0.5);
  return {a, b, X_WA, compose(X_WA, X_AB)};
}

Pair any_pair(Random& random) {
  const int kind = random.below(8);
  if (kind == 0)
    return crossing_edges(std::ldexp(1.0, -4 - random.below(49)), 1e-3 * random.below(3), random);
  Pair pair{random.any(), random.any(), random.pose(0.3), random.pose(1.5)};
  if (kind == 1) pair.X_WB.R = pair.X_WA.R;
  if (kind == 2) move_to(std::ldexp(1.0, -random.below(52)), pair);
  if (kind == 3) pair.X_WA.p += Vector3(1e4, -1e5, 1e3), pair.X_WB.p += Vector3(1e4, -1e5, 1e3);
  return pair;
}

struct Scene {
  std::vector<Hexahedron> solids;
  std::vector<Pose> poses;
  std::vector<SolidPair> pairs;

  void add(const Pair& pair) {
    const auto first = static_cast<SolidIndex>(solids.size());
    solids.push_back(pair.a), solids.push_back(pair.b);
    poses.push_back(pair.X_WA), poses.push_back(pair.X_WB);
    pairs.push_back({first, first + 1});
  }
};

/// All pairs, in batches of this size.
void ask_in_batches(const Narrowphase& native, const Scene& scene, const Query& query, std::size_t size,
                    std::vector<PairStatus>& status, std::vector<PairGeometry>& geometry) {
  const auto workspace = native.make_workspace();
  for (std::size_t first = 0; first < scene.pairs.size(); first += size) {
    const std::size_t here = std::min(size, scene.pairs.size() - first);
    native.evaluate({std::span(scene.pairs).subspan(first, here), scene.poses, query},
                    {std::span(status).subspan(first), std::span(geometry).subspan(first), {}}, *workspace);
  }
}

TEST(NativeApart, BatchesOfAnySizeHaveTheBitsOfSingleCalls) {
  constexpr double kReach = 0.1;
  Random random(31);
  Scene scene;
  for (int i = 0; i < 700; ++i) scene.add(any_pair(random));
  // Boxes as far apart as a query reaches, on both sides of that.
  for (int i = 0; i < 600; ++i) {
    const auto box = [&] {
      return Hexahedron::from_size({random.uniform(0.2, 2), random.uniform(0.2, 2), random.uniform(0.2, 2)});
    };
    Pair pair{box(), box(), random.pose(0.3), random.pose(1.5)};
    if (i % 3 != 0) move_to(kReach * (1.0 + (i % 2 - 0.5) * std::ldexp(1.0, -random.below(50))), pair);
    scene.add(pair);
  }
  const auto native = make_native();
  native->build(scene.solids);
  const std::size_t count = scene.pairs.size();
  std::vector<PairStatus> alone(count), status(count);
  std::vector<PairGeometry> geometry_alone(count), geometry(count);
  for (const double reach : {kInfinity, kReach, 0.0}) {
    const Query query{QueryKind::distance, reach};
    ask_in_batches(*native, scene, query, 1, alone, geometry_alone);
    for (const std::size_t size : {std::size_t{2}, std::size_t{3}, std::size_t{7}, std::size_t{64}, count}) {
      ask_in_batches(*native, scene, query, size, status, geometry);
      for (std::size_t i = 0; i < count; ++i) {
        ASSERT_EQ(status[i], alone[i]) << i;
        ASSERT_TRUE(same_bits(geometry[i], geometry_alone[i])) << i << " in batches of " << size;
      }
    }
  }
}

/// DepthRecord::axis of each pair.
std::vector<std::uint8_t> axes_of(const Kernels& kernels, const native::SolidSet& set, SolidKind kind,
                                  const std::vector<Pose>& poses, const std::vector<PairIndices>& pairs) {
  std::vector<native::DepthRecord> depths(pairs.size());
  if (kind == SolidKind::box)
    kernels.compute_box_depths(native::records_of(poses), set.boxes.data(), pairs.data(), pairs.size(),
                               depths.data());
  else
    kernels.compute_parallelepiped_depths(native::records_of(poses), set.parallelepiped_edges.data(),
                                          pairs.data(), pairs.size(), depths.data());
  std::vector<std::uint8_t> out;
  for (const native::DepthRecord& depth : depths) out.push_back(depth.axis);
  return out;
}

/// All passes of one kernel table over the pairs of a kind, the first with axes and without.
std::vector<DistanceRecord> run(const Kernels& kernels, const native::SolidSet& set, SolidKind kind,
                                const std::vector<Pose>& poses, const std::vector<PairIndices>& pairs) {
  std::vector<DistanceRecord> out(4 * pairs.size());
  native::compute_hull_distances(set, kernels, poses, pairs, out.data());
  if (kind == SolidKind::general) return out;
  const std::vector<std::uint8_t> axes = axes_of(kernels, set, kind, poses, pairs);
  native::compute_distances(set, kernels, kind, poses, pairs, axes.data(), &out[pairs.size()]);
  native::compute_distances(set, kernels, kind, poses, pairs, nullptr, &out[3 * pairs.size()]);
  native::compute_distances_accurately(set, kernels, kind, poses, pairs, &out[2 * pairs.size()]);
  return out;
}

TEST(NativeApart, EveryInstructionSetHasTheSameBits) {
  Random random(32);
  for (const SolidKind kind : {SolidKind::box, SolidKind::parallelepiped, SolidKind::general}) {
    // Pairs of one kind; a last batch that is not full.
    Scene scene;
    std::vector<PairIndices> pairs;
    for (int i = 0; i < 501; ++i) {
      Pair pair = any_pair(random);
      if (kind == SolidKind::parallelepiped) pair.a = random.sheared(), pair.b = random.sheared();
      if (!pair.a.is_box() && kind == SolidKind::box) pair.a = random.slab_or_needle();
      if (!pair.b.is_box() && kind == SolidKind::box) pair.b = random.box();
      scene.add(pair);
      pairs.push_back({scene.pairs.back().a, scene.pairs.back().b});
    }
    // Each instruction set against the first one.
    const native::SolidSet set = native::make_solid_set(scene.solids);
    const native::KernelList& list = native::available_kernels();
    const std::vector<DistanceRecord> plain = run(*list.of[0], set, kind, scene.poses, pairs);
    int found = 0;
    for (int k = 1; k < list.count; ++k) {
      const std::vector<DistanceRecord> wide = run(*list.of[k], set, kind, scene.poses, pairs);
      for (std::size_t i = 0; i < plain.size(); ++i) {
        ASSERT_EQ(plain[i].state, wide[i].state) << list.of[k]->isa << " " << i;
        if (plain[i].state < native::DistanceState::if_separated) continue;
        ++found;
        ASSERT_TRUE(same_bits(plain[i].separation, wide[i].separation)) << list.of[k]->isa << " " << i;
        for (int c = 0; c < 3; ++c) {
          ASSERT_TRUE(same_bits(plain[i].n[c], wide[i].n[c])) << list.of[k]->isa << " " << i;
          ASSERT_TRUE(same_bits(plain[i].from_A[c], wide[i].from_A[c])) << list.of[k]->isa << " " << i;
        }
      }
    }
    EXPECT_TRUE(list.count == 1 || found > 100);
  }
}

/// Products of a turn so small are no double's, or have an error that is none: fused or split, what counts is
/// the same.
TEST(NativeApart, TurnsOfAnySmallnessHaveTheSameBitsOnEveryInstructionSet) {
  Random random(36);
  // Boxes over each other, turned by so little that squares of the turn are denormal or zero.
  Scene scene;
  std::vector<PairIndices> pairs;
  for (int exponent = -1070; exponent < -40; exponent += 2) {
    const double turn = std::ldexp(1.0, exponent);
    Pair pair{random.box(), random.box(), Pose{}, Pose{}};
    pair.X_WA.R << 1, -turn, turn, turn, 1, -turn, -turn, turn, 1;
    pair.X_WB.R << 1, turn, -2 * turn, -turn, 1, turn, 2 * turn, -turn, 1;
    pair.X_WB.p = {random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(2.1, 2.5)};
    scene.add(pair);
    pairs.push_back({scene.pairs.back().a, scene.pairs.back().b});
  }
  const native::SolidSet set = native::make_solid_set(scene.solids);
  const native::KernelList& list = native::available_kernels();
  // Each instruction set, one pair a call and all together.
  const auto run_accurately = [&](const Kernels& kernels, std::size_t size) {
    std::vector<DistanceRecord> out(pairs.size());
    for (std::size_t i = 0; i < pairs.size(); i += size)
      native::compute_distances_accurately(
          set, kernels, SolidKind::box, scene.poses,
          std::span<const PairIndices>(pairs).subspan(i, std::min(size, pairs.size() - i)), &out[i]);
    return out;
  };
  const std::vector<DistanceRecord> plain = run_accurately(*list.of[0], pairs.size());
  for (int k = 0; k < list.count; ++k) {
    for (const std::size_t size : {std::size_t{1}, pairs.size()}) {
      const std::vector<DistanceRecord> other = run_accurately(*list.of[k], size);
      for (std::size_t i = 0; i < plain.size(); ++i) {
        ASSERT_EQ(plain[i].state, other[i].state) << list.of[k]->isa << " " << i;
        ASSERT_GE(plain[i].state, native::DistanceState::if_separated);
        ASSERT_TRUE(same_bits(plain[i].separation, other[i].separation)) << list.of[k]->isa << " " << i;
        for (int c = 0; c < 3; ++c) {
          ASSERT_TRUE(same_bits(plain[i].n[c], other[i].n[c])) << list.of[k]->isa << " " << i;
          ASSERT_TRUE(same_bits(plain[i].from_A[c], other[i].from_A[c])) << list.of[k]->isa << " " << i;
        }
      }
    }
  }
}

TEST(NativeApart, ExchangingTheSolidsKeepsEveryBit) {
  Random random(33);
  for (int i = 0; i < 600; ++i) {
    const Pair pair = any_pair(random);
    const PairGeometry ab = ask(pair.a, pair.X_WA, pair.b, pair.X_WB, QueryKind::distance).geometry;
    PairGeometry ba = ask(pair.b, pair.X_WB, pair.a, pair.X_WA, QueryKind::distance).geometry;
    std::swap(ba.p_A_W, ba.p_B_W);
    ba.n_AB_W = -ba.n_AB_W;
    ASSERT_TRUE(same_bits(ab.separation, ba.separation)) << i;
    ASSERT_EQ(ab.n_AB_W, ba.n_AB_W) << i;
    ASSERT_TRUE(same_bits(ab.p_A_W, ba.p_A_W) && same_bits(ab.p_B_W, ba.p_B_W)) << i;
  }
}

TEST(NativeApart, TheSeparationAskedForIsTheLastThatComesBack) {
  Random random(34);
  int apart = 0;
  for (int i = 0; i < 400; ++i) {
    const Pair pair = any_pair(random);
    Query query{QueryKind::distance};
    const Answer plain = ask(pair.a, pair.X_WA, pair.b, pair.X_WB, query);
    if (plain.status != PairStatus::separated) continue;
    ++apart;
    query.max_separation = plain.geometry.separation;
    const Answer at_limit = ask(pair.a, pair.X_WA, pair.b, pair.X_WB, query);
    ASSERT_EQ(at_limit.status, PairStatus::separated);
    ASSERT_TRUE(same_bits(at_limit.geometry, plain.geometry)) << i;
    query.max_separation = std::nextafter(plain.geometry.separation, 0.0);
    const Answer beyond = ask(pair.a, pair.X_WA, pair.b, pair.X_WB, query);
    ASSERT_EQ(beyond.status, PairStatus::separated);
    ASSERT_EQ(beyond.geometry.separation, kInfinity);
    ASSERT_TRUE(std::isnan(beyond.geometry.n_AB_W.x()) && std::isnan(beyond.geometry.p_A_W.x()));
  }
  EXPECT_GT(apart, 100);
}

/// Two bounds that need no reference: the hulls' separation along the normal from below, the witness points
/// on their surfaces from above. The reference, itself a bound from below, must not lie above.
void expect_right(const Pair& pair) {
  WorldVertices va, vb;
  world_vertices(pair.a, pair.X_WA, va);
  world_vertices(pair.b, pair.X_WB, vb);
  const double S = scale_of(pair.a, pair.X_WA, pair.b, pair.X_WB);
  const PairGeometry g = ask(pair.a, pair.X_WA, pair.b, pair.X_WB, QueryKind::distance).geometry;
  EXPECT_GE(g.separation, static_cast<double>(reference_signed_distance(va, vb)) - 4e-15 * S);
  EXPECT_NEAR(static_cast<double>(reference_separation_along(va, vb, g.n_AB_W)), g.separation, 4e-15 * S);
  EXPECT_NEAR(static_cast<double>(reference_height(va, g.p_A_W)), 0.0, 1e-14 * S);
  EXPECT_NEAR(static_cast<double>(reference_height(vb, g.p_B_W)), 0.0, 1e-14 * S);
}

TEST(NativeApart, EdgesAtAnyAngleAreMeasuredRight) {
  Random random(35);
  for (int i = 0; i < 600; ++i) {
    SCOPED_TRACE(i);
    const double gap = random.below(4) == 0 ? 0.0 : std::ldexp(1.0, -random.below(50));
    expect_right(crossing_edges(std::ldexp(random.uniform(0.5, 1), -3 - random.below(50)), gap, random));
    if (HasFailure()) return;
  }
}

/// Two long bars, one turned by a small angle above the other: no axis but the one across their nearest edges
/// separates them.
Pair crossing_bars(double angle, const Pose& X_W) {
  constexpr double kEighth = std::numbers::pi / 8;
  const Hexahedron bar = Hexahedron::from_size({2, 0.2, 0.2});
  const Pose on_edge{rotation_from_quaternion(std::cos(kEighth), std::sin(kEighth), 0, 0), {0, 0, 0}};
  Pose above{rotation_from_quaternion(std::cos(angle / 2), 0, 0, std::sin(angle / 2)),
             {0, 0, 0.2 * std::sqrt(2.0) + angle / 4}};
  return {bar, bar, compose(X_W, on_edge), compose(X_W, compose(above, on_edge))};
}

/// By how much a unit vector is off the normal across the bars' long edges. Their half length is 1, so that
/// these are known to the bit.
double error_of_normal(const Pair& pair, const Vector3& n) {
  using Exact = Eigen::Matrix<long double, 3, 1>;
  const auto along = [](const Pose& X) -> Exact { return X.R.col(0).cast<long double>(); };
  // Of the difference, in which nothing cancels.
  const Exact a = along(pair.X_WA), by = along(pair.X_WB) - a;
  const Exact exact =
      Exact(a.y() * by.z() - a.z() * by.y(), a.z() * by.x() - a.x() * by.z(), a.x() * by.y() - a.y() * by.x())
          .normalized();
  const Exact toward = exact.dot((pair.X_WB.p - pair.X_WA.p).cast<long double>()) < 0 ? -exact : exact;
  return static_cast<double>((n.cast<long double>() - toward).norm());
}

TEST(NativeApart, ThinAxesHaveTheirNormalsFromExactProducts) {
  constexpr double kMost = 1e-15;
  Random random(39);
  Scene scene;
  std::vector<PairIndices> pairs;
  std::vector<Pair> bars;
  for (int i = 0; i < 200; ++i) {
    const double angle = i % 2 == 0 ? 4e-4 : std::ldexp(random.uniform(0.5, 1), -10 - random.below(10));
    bars.push_back(crossing_bars(angle, random.pose(0.0)));
    scene.add(bars.back());
    pairs.push_back({scene.pairs.back().a, scene.pairs.back().b});
    const Pair& pair = bars.back();
    const Answer answer = ask(pair.a, pair.X_WA, pair.b, pair.X_WB, QueryKind::distance);
    ASSERT_EQ(answer.status, PairStatus::separated) << angle;
    ASSERT_LT(error_of_normal(pair, answer.geometry.n_AB_W), kMost) << angle;
  }
  // The quick passes, with axes and without, leave such pairs to the accurate one.
  const native::SolidSet set = native::make_solid_set(scene.solids);
  const native::KernelList& list = native::available_kernels();
  for (int k = 0; k < list.count; ++k) {
    const std::vector<DistanceRecord> records = run(*list.of[k], set, SolidKind::box, scene.poses, pairs);
    for (std::size_t i = pairs.size(); i < records.size(); ++i) {
      const bool is_accurate = i / pairs.size() == 2;
      if (!is_accurate && records[i].state < native::DistanceState::if_separated) continue;
      ASSERT_GE(records[i].state, native::DistanceState::if_separated) << list.of[k]->isa << " " << i;
      const Vector3 n(records[i].n[0], records[i].n[1], records[i].n[2]);
      ASSERT_LT(error_of_normal(bars[i % pairs.size()], n), kMost) << list.of[k]->isa << " " << i;
    }
  }
}

TEST(NativeApart, ShortDistancesKeepTheirDirection) {
  Random random(36);
  for (int i = 0; i < 900; ++i) {
    SCOPED_TRACE(i);
    Pair pair{random.box(), random.box(), random.pose(0.3), random.pose(1.5)};
    if (i % 3 == 1) pair.a = random.sheared(), pair.b = random.sheared();
    if (i % 3 == 2) pair.a = random.tapered(), pair.b = random.warped();
    move_to(std::ldexp(1.0, -random.below(51)), pair);
    expect_right(pair);
    if (HasFailure()) return;
  }
}

TEST(NativeApart, FlatFacesAreFoundByTheKernel) {
  const Hexahedron box = Hexahedron::from_size({2, 2, 1}), small = Hexahedron::from_size({0.5, 0.5, 0.5});
  for (const double x : {0.0, 0.7, 1.2}) {  // inside, and over the rim of the face
    const Answer answer = ask(box, at(0, 0, 0), small, at(x, 0.3, 1.0), QueryKind::distance);
    EXPECT_EQ(answer.geometry.separation, 0.25);
    EXPECT_EQ(answer.geometry.n_AB_W, Vector3(0, 0, 1));
    EXPECT_LE(std::abs(answer.geometry.p_A_W.x()), 1.0);
    EXPECT_GE(answer.geometry.p_B_W.x(), x - 0.25);
  }
}

bool is_separated(const Pair& pair) {
  return ask(pair.a, pair.X_WA, pair.b, pair.X_WB, QueryKind::distance).status == PairStatus::separated;
}

bool is_settled_by_kernels(const Pair& pair) {
  Scene scene;
  scene.add(pair);
  const native::SolidSet set = native::make_solid_set(scene.solids);
  DistanceRecord record{};
  return native::finish_kernel_distance(set, native::kernels(), {0, 1}, scene.poses, true, record);
}

/// The kernels are what makes it fast: they must settle nearly all pairs by themselves.
TEST(NativeApart, TheKernelsSettleNearlyAllPairs) {
  Random random(37);
  int apart = 0, settled = 0;
  for (int i = 0; i < 2000; ++i) {
    Pair pair{random.box(), random.box(), random.pose(0.3), random.pose(1.5)};
    if (i % 4 == 1) pair.a = random.sheared(), pair.b = random.sheared();
    if (i % 4 == 2) pair.a = random.tapered(), pair.b = random.warped();
    if (i % 4 == 3) pair = crossing_edges(std::ldexp(1.0, -4 - random.below(46)), 1e-4, random);
    if (!is_separated(pair)) continue;
    ++apart;
    settled += is_settled_by_kernels(pair);
  }
  EXPECT_GT(apart, 500);
  EXPECT_GE(settled, apart - apart / 100);
}

/// Far from the world's origin the rounded vertices are no box: the kernel that reads them takes over.
TEST(NativeApart, BoxesFarAwayAreMeasuredByTheirVertices) {
  Random random(38);
  int apart = 0, settled = 0;
  for (int i = 0; i < 400; ++i) {
    SCOPED_TRACE(i);
    Pair pair{random.box(), random.box(), random.pose(0.3), random.pose(1.5)};
    const Vector3 far = random.vector(std::ldexp(1.0, 14 + random.below(20)));
    pair.X_WA.p += far, pair.X_WB.p += far;
    if (!is_separated(pair)) continue;
    ++apart;
    settled += is_settled_by_kernels(pair);
    expect_right(pair);
    if (HasFailure()) return;
  }
  EXPECT_GT(apart, 100);
  EXPECT_GE(settled, apart - apart / 20);
}

/// A tapered block about a point 10 km from its own origin, brought to about the world's.
Pair far_from_its_origin(Random& random) {
  std::array<Vector3, 8> vertices =
      Hexahedron::from_size({random.uniform(0.2, 1.5), random.uniform(0.2, 1.5), 1}).vertices();
  const Vector3 middle(random.uniform(-1e4, 1e4), random.uniform(-1e4, 1e4), 1e4);
  for (Vector3& v : vertices) {
    if (v.z() > 0.0) v.x() *= 0.7;
    v += middle;
  }
  const Hexahedron b = Hexahedron::from_size({random.uniform(0.2, 1.5), 1, 1});
  Pose X_WA = random.pose(0.0), X_WB = X_WA;
  X_WA.p = -rotate(X_WA.R, middle);
  X_WB.p = random.pose(1.0).p;
  return {Hexahedron::from_vertices(vertices, WarpPolicy::accept), b, X_WA, X_WB};
}

TEST(NativeDistance, SolidsFarFromTheirOwnOriginMeetWhereOverlapSaysSo) {
  Random random(20261123);
  int meeting = 0;
  for (int i = 0; i < 300; ++i) {
    Pair pair = far_from_its_origin(random);
    move_to(0.0, pair);
    move_to(0.0, pair);  // to the rounding
    const PairStatus overlap = ask(pair.a, pair.X_WA, pair.b, pair.X_WB, Query{QueryKind::overlap}).status;
    EXPECT_EQ(ask(pair.a, pair.X_WA, pair.b, pair.X_WB, QueryKind::distance).status, overlap) << i;
    EXPECT_EQ(ask(pair.a, pair.X_WA, pair.b, pair.X_WB).status, overlap) << i;
    meeting += overlap == PairStatus::overlapping;
  }
  EXPECT_GT(meeting, 50);
  EXPECT_LT(meeting, 250);
}

}  // namespace
}  // namespace touchstone
