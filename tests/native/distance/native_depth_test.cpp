#include <gmock/gmock.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <span>
#include <string>
#include <vector>

#include "touchstone/contact_core/native/distance/facet_axes.hpp"
#include "touchstone/contact_core/native/distance/pair_depth.hpp"
#include "touchstone/contact_core/native/distance/witness.hpp"
#include "touchstone/contact_core/native/overlap/overlap.hpp"
#include "touchstone/tests/native/distance/all_features_reference.hpp"
#include "touchstone/tests/native/native_fixture.hpp"

#define TOUCHSTONE_ISA baseline
#include "touchstone/contact_core/native/simd/box_pair_depth.hpp"
#undef TOUCHSTONE_ISA

// Depth, normal and witness points of pairs that overlap: against the reference in long double, against the
// scalar code (best_facet_axis), over instruction sets, and in batches.

namespace touchstone {
namespace {

struct PosedSolids {
  std::vector<Hexahedron> solids;
  std::vector<Pose> poses;
  std::vector<SolidPair> pairs;

  void add(const Hexahedron& a, const Pose& X_WA, const Hexahedron& b, const Pose& X_WB) {
    const auto first = static_cast<SolidIndex>(solids.size());
    solids.push_back(a), solids.push_back(b);
    poses.push_back(X_WA), poses.push_back(X_WB);
    pairs.push_back({first, first + 1});
  }
};

/// B turned against A about a random axis by about `tilt`, or by that and a quarter turn.
Pose nearly_aligned(const Pose& X_WA, double tilt, Random& random) {
  Pose turn;
  const Vector3 axis = tilt * random.vector(1.0);
  turn.R = rotation_from_quaternion(1.0, axis.x(), axis.y(), axis.z());
  if (random.below(2) == 0) {
    Pose quarter;
    quarter.R.col(0) = Vector3(0, 1, 0), quarter.R.col(1) = Vector3(-1, 0, 0);
    turn = compose(quarter, turn);
  }
  Pose out = compose(X_WA, turn);
  out.p = X_WA.p + random.vector(0.6);
  return out;
}

/// All that makes axes tie, nearly tie, or lose their direction.
PosedSolids hard_pairs(std::uint64_t seed, int count) {
  Random random(seed);
  PosedSolids out;
  for (int i = 0; i < count; ++i) {
    // Poses that are aligned but for a tilt of any size, for kinds that overlap.
    const Pose X_WA = random.below(4) == 0 ? at(0.25, -0.5, 0.125) : random.pose(0.3);
    const double tilt = random.below(4) == 0 ? 0.0 : std::ldexp(1.0, -2 - random.below(54));
    switch (random.below(8)) {
      case 0:
        out.add(random.box(), X_WA, random.box(), random.pose(0.6));
        break;
      case 1:
        out.add(random.any(), X_WA, random.any(), random.pose(0.6));
        break;
      case 2: {  // ties of all axes: cubes, or one solid twice
        const Hexahedron solid = random.below(2) ? Hexahedron::from_size({1, 1, 1}) : random.any();
        out.add(solid, X_WA, solid, nearly_aligned(X_WA, tilt, random));
        break;
      }
      case 3:
        out.add(random.box(), X_WA, random.box(), nearly_aligned(X_WA, tilt, random));
        break;
      case 4: {
        const Hexahedron sheared = random.sheared();
        out.add(sheared, X_WA, random.below(2) ? sheared : random.box(), nearly_aligned(X_WA, tilt, random));
        break;
      }
      case 5: {  // contained deep inside, also about the same centre
        Pose X_WB = nearly_aligned(X_WA, tilt, random);
        X_WB.p = X_WA.p + random.vector(random.below(2) ? 0.0 : 0.2);
        out.add(Hexahedron::from_size({4, 4, 4}), X_WA, Hexahedron::from_size({0.5, 0.5, 0.5}), X_WB);
        break;
      }
      case 6:
        out.add(random.slab_or_needle(), X_WA, random.slab_or_needle(), nearly_aligned(X_WA, tilt, random));
        break;
      default:  // poses off orthonormal by single precision
        out.add(random.box(), X_WA, random.sheared(), random.pose(0.5));
        out.poses.back().R = out.poses.back().R.cast<float>().cast<double>();
    }
  }
  return out;
}

/// Of two boxes, as DepthRecord::axis names it, unit; zero where its edges are nearly parallel.
Vector3 unit_axis(const Pose& X_WA, const Pose& X_WB, int axis) {
  Vector3 L = axis < 3 ? X_WA.R.col(axis) : X_WB.R.col(axis % 3);
  if (axis >= 6) L = cross(X_WA.R.col((axis - 6) / 3), X_WB.R.col(axis % 3));
  return norm(L) < 0x1p-9 ? Vector3::Zero() : Vector3(L / norm(L));
}

/// Along that axis; -infinity where there is none.
double gap_along(const Hexahedron& a, const Pose& X_WA, const Hexahedron& b, const Pose& X_WB, int axis) {
  const Vector3 L = unit_axis(X_WA, X_WB, axis);
  if (L == Vector3::Zero()) return -kInfinity;
  double gap = std::abs(dot(L, X_WB.p - X_WA.p));
  for (int k = 0; k < 3; ++k) {
    gap -= a.half_extents()[k] * std::abs(dot(L, X_WA.R.col(k)));
    gap -= b.half_extents()[k] * std::abs(dot(L, X_WB.R.col(k)));
  }
  return gap;
}

/// The two axes of all 15 along which boxes overlap least, that one first.
struct LeastAxes {
  int axis[2] = {-1, -1};
  double gap[2] = {-kInfinity, -kInfinity};

  LeastAxes(const Hexahedron& a, const Pose& X_WA, const Hexahedron& b, const Pose& X_WB) {
    for (int i = 0; i < 15; ++i) {
      const double of = gap_along(a, X_WA, b, X_WB, i);
      if (of > gap[0])
        axis[1] = axis[0], gap[1] = gap[0], axis[0] = i, gap[0] = of;
      else if (of > gap[1])
        axis[1] = i, gap[1] = of;
    }
  }
};

/// Of a pair that a lone search of axes has: DepthScale's size.
double size_of(const Hexahedron& a, const Pose& X_WA, const Hexahedron& b, const Pose& X_WB) {
  return a.half_extents().sum() + b.half_extents().sum() + (X_WB.p - X_WA.p).cwiseAbs().sum();
}

/// Boxes face on face, turned and leaning by any angle, at any depth, edges that may lie over each other;
/// poses of which some are as far off orthonormal as they may be.
PosedSolids resting_boxes(std::uint64_t seed, int count) {
  Random random(seed);
  PosedSolids out;
  const auto small = [&random] {
    return random.below(4) == 0 ? 0.0 : std::ldexp(1.0, -4 - random.below(50));
  };
  const auto quarter_about = [](int k, Pose X) {
    const Matrix3 R = X.R;
    X.R.col((k + 1) % 3) = R.col((k + 2) % 3), X.R.col((k + 2) % 3) = -R.col((k + 1) % 3);
    return X;
  };
  for (int i = 0; i < count; ++i) {
    const Hexahedron a = random.below(8) == 0 ? random.slab_or_needle() : random.box();
    const Hexahedron b = random.below(4) == 0 ? a : random.box();
    const Pose X_WA =
        random.below(4) == 0 ? at(0.25, -0.5, 0.125) : random.pose(random.below(8) == 0 ? 1e3 : 0.3);
    // A quarter turn or any about z, then one that lays another face down, then it leans.
    const Vector3 lean = small() * random.vector(1.0);
    const double about_z = random.below(2) == 0 ? small() : 1.5 * random.vector(1.0).x();
    Pose X_AB;
    X_AB.R = rotation_from_quaternion(1.0, lean.x(), lean.y(), about_z);
    for (int k = 0; k < 3; ++k)
      for (int turns = random.below(4); turns > 0; --turns) X_AB = quarter_about(k, X_AB);
    int down = 0;
    X_AB.R.row(2).cwiseAbs().maxCoeff(&down);
    const double depth = small(), height = a.half_extents().z() + b.half_extents()[down] - depth;
    Vector3 aside = random.below(2) == 0 ? Vector3(small(), -small(), 0.0) : random.vector(0.5);
    // Some overlap by as much beside these faces, or by little more.
    const double beside = a.half_extents().x() + X_AB.R.row(0).cwiseAbs().dot(b.half_extents());
    if (random.below(4) == 0) aside.x() = beside - depth * (1.0 + small());
    X_AB.p = {aside.x(), aside.y(), random.below(2) ? height : -height};
    out.add(a, X_WA, b, compose(X_WA, X_AB));
    if (random.below(8) == 0) out.poses.back().R *= 1.0 + 0.45e-6;
  }
  return out;
}

/// Boxes that overlap along two axes by the same to 2^-24 to 2^-9 of their size, or to rounding, more
/// along all others; rotations are off orthonormal by all but what poses may be.
PosedSolids tied_boxes(std::uint64_t seed, int count) {
  Random random(seed);
  PosedSolids out;
  const auto stretched = [&random](const Pose& X) {
    Matrix3 by = Matrix3::Identity();
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j <= i; ++j) by(i, j) = by(j, i) = by(i, j) + (random.below(2) ? 0.45e-6 : -0.45e-6);
    return Pose{X.R * by, X.p};
  };
  while (static_cast<int>(out.pairs.size()) < count) {
    const Hexahedron a = random.box(), b = random.box();
    const Pose X_WA = stretched(random.pose(0.3));
    Pose X_WB = stretched(random.pose(0.6));
    const LeastAxes least(a, X_WA, b, X_WB);
    // B goes against the first axis, until that overlaps by as much as the second one.
    const auto outwards = [&](int k) {
      const Vector3 n = unit_axis(X_WA, X_WB, least.axis[k]);
      return Vector3(dot(n, X_WB.p - X_WA.p) < 0.0 ? -n : n);
    };
    const Vector3 by = -outwards(0);
    const double size = size_of(a, X_WA, b, X_WB), slope = 1.0 + dot(by, outwards(1));
    const double wanted = random.below(4) == 0 ? 0.0 : size * std::ldexp(1.0, -9 - random.below(16));
    if (slope < 0.1) continue;
    X_WB.p += (least.gap[0] - least.gap[1] - (random.below(2) ? wanted : -wanted)) / slope * by;
    const LeastAxes tied(a, X_WA, b, X_WB);
    if (tied.gap[0] < 0.0 && tied.gap[0] - tied.gap[1] < 0x1p-8 * size) out.add(a, X_WA, b, X_WB);
  }
  return out;
}

/// Frusta all but flat, each twice at one pose: all pairs of their edges are parallel, or cross, to rounding.
void add_flat_frusta(PosedSolids& out) {
  for (const double size : {1.0, 10.0, 100.0})
    for (const double height : {2e-14, 1e-13}) {
      std::vector<Vector3> corners;
      for (int k = 0; k < 2; ++k)
        for (const double y : {-0.5, 0.5})
          for (const double x : {-0.5, 0.5}) {
            const double side = k == 0 ? size : 0.2 * size;
            corners.emplace_back(x * side, y * side, k * height);
          }
      const Hexahedron frustum = Hexahedron::from_vertices(corners, WarpPolicy::accept);
      out.add(frustum, Pose{}, frustum, Pose{});
      out.add(frustum, at(0.25, -0.5, 0.125), frustum, at(0.25, -0.5, 0.125));
    }
}

/// Hexahedra of 12 to 18 edges that overlap, from a touch to deep inside.
PosedSolids overlapping_hulls(std::uint64_t seed, int count) {
  Random random(seed);
  const auto solid = [&] { return random.below(2) == 0 ? random.tapered() : random.warped(); };
  PosedSolids out;
  for (int i = 0; i < count; ++i) {
    const Hexahedron a = solid(), b = solid();
    const Pose X_WA = random.pose(1.0);
    Pose X_WB = random.pose(1.0);
    X_WB.p = X_WA.p + random.vector(random.below(3) == 0 ? 0.2 : 0.9);
    out.add(a, X_WA, b, X_WB);
  }
  return out;
}

struct Answers {
  std::vector<PairStatus> status;
  std::vector<PairGeometry> geometry;
};

Answers measure_distances(const PosedSolids& set, std::size_t step) {
  const auto native = make_native();
  native->build(set.solids);
  const auto workspace = native->make_workspace();
  Answers out;
  out.status.resize(set.pairs.size()), out.geometry.resize(set.pairs.size());
  for (std::size_t i = 0; i < set.pairs.size(); i += step) {
    const std::size_t here = std::min(step, set.pairs.size() - i);
    native->evaluate({std::span(set.pairs).subspan(i, here), set.poses, Query{QueryKind::distance}},
                     {std::span(out.status).subspan(i, here), std::span(out.geometry).subspan(i, here), {}},
                     *workspace);
  }
  return out;
}

/// Bounds as in native_test.cpp.
void expect_right(const PosedSolids& set, std::size_t i, const PairGeometry& g) {
  const SolidPair pair = set.pairs[i];
  WorldVertices a, b;
  world_vertices(set.solids[pair.a], set.poses[pair.a], a);
  world_vertices(set.solids[pair.b], set.poses[pair.b], b);
  const double S = scale_of(set.solids[pair.a], set.poses[pair.a], set.solids[pair.b], set.poses[pair.b]);
  const double exact = static_cast<double>(reference_signed_distance(a, b));
  EXPECT_NEAR(g.separation, exact, 4e-15 * S);
  EXPECT_NEAR(norm(g.n_AB_W), 1.0, 1e-15);
  EXPECT_NEAR(static_cast<double>(reference_separation_along(a, b, g.n_AB_W)), exact, 4e-15 * S);
  EXPECT_LE(norm(g.p_B_W - (g.p_A_W + g.separation * g.n_AB_W)), 1e-15 * S);
  EXPECT_NEAR(static_cast<double>(reference_height(a, g.p_A_W)), 0.0, 1e-14 * S);
  EXPECT_NEAR(static_cast<double>(reference_height(b, g.p_B_W)), 0.0, 1e-14 * S);
}

TEST(NativeDepth, IsRightOnTiesNearTiesParallelEdgesContainmentSlabsAndNeedles) {
  const PosedSolids set = hard_pairs(1, 1200);
  const Answers answers = measure_distances(set, set.pairs.size());
  int overlapping = 0;
  for (std::size_t i = 0; i < set.pairs.size(); ++i) {
    if (answers.status[i] != PairStatus::overlapping) continue;
    SCOPED_TRACE(i);
    ++overlapping;
    expect_right(set, i, answers.geometry[i]);
    if (testing::Test::HasFailure()) return;
  }
  EXPECT_GT(overlapping, 800);
}

TEST(NativeDepth, BatchesOfAnySizeGiveTheBitsOfSinglePairs) {
  const PosedSolids set = hard_pairs(2, 1500);
  const Answers alone = measure_distances(set, 1);
  for (const std::size_t step : {2u, 3u, 7u, 256u, 1500u}) {
    const Answers batch = measure_distances(set, step);
    for (std::size_t i = 0; i < set.pairs.size(); ++i) {
      ASSERT_EQ(alone.status[i], batch.status[i]) << i;
      ASSERT_EQ(std::bit_cast<std::uint64_t>(alone.geometry[i].separation),
                std::bit_cast<std::uint64_t>(batch.geometry[i].separation));
      ASSERT_EQ(alone.geometry[i].n_AB_W, batch.geometry[i].n_AB_W);
      ASSERT_EQ(alone.geometry[i].p_A_W, batch.geometry[i].p_A_W);
      ASSERT_EQ(alone.geometry[i].p_B_W, batch.geometry[i].p_B_W);
    }
  }
}

TEST(NativeDepth, ExchangingTheSolidsKeepsEveryBit) {
  const PosedSolids set = hard_pairs(3, 1500);
  PosedSolids exchanged = set;
  for (const SolidPair& pair : set.pairs) {
    std::swap(exchanged.solids[pair.a], exchanged.solids[pair.b]);
    std::swap(exchanged.poses[pair.a], exchanged.poses[pair.b]);
  }
  const Answers ab = measure_distances(set, 1500), ba = measure_distances(exchanged, 1500);
  for (std::size_t i = 0; i < set.pairs.size(); ++i) {
    ASSERT_EQ(ab.status[i], ba.status[i]);
    ASSERT_EQ(std::bit_cast<std::uint64_t>(ab.geometry[i].separation),
              std::bit_cast<std::uint64_t>(ba.geometry[i].separation));
    ASSERT_EQ(ab.geometry[i].n_AB_W, Vector3(-ba.geometry[i].n_AB_W));
    ASSERT_EQ(ab.geometry[i].p_A_W, ba.geometry[i].p_B_W);
  }
}

// ---- The kernels themselves

/// The pairs of `set` that two kinds allow, in the order the kernels want.
std::vector<native::PairIndices> pairs_of_kind(const native::SolidSet& data, const PosedSolids& set,
                                               native::SolidKind kind) {
  std::vector<native::PairIndices> out;
  for (const SolidPair& pair : set.pairs) {
    if (native::kind_of(data, pair) > kind) continue;
    const bool swapped = !native::comes_first(data, pair, set.poses[pair.a], set.poses[pair.b]);
    out.push_back(swapped ? native::PairIndices{pair.b, pair.a} : native::PairIndices{pair.a, pair.b});
  }
  return out;
}

using native::DepthRecord;

void expect_same_bits(const DepthRecord& p, const DepthRecord& q) {
  ASSERT_EQ(p.certified, q.certified);
  ASSERT_EQ(p.known, q.known);
  if (p.certified == native::Certified::separated) {
    ASSERT_EQ(p.axis, q.axis);
  }
  if (p.known == native::DepthKnown::nothing) return;
  ASSERT_EQ(std::bit_cast<std::uint64_t>(p.separation), std::bit_cast<std::uint64_t>(q.separation));
  for (int k = 0; k < 3; ++k) {
    ASSERT_EQ(std::bit_cast<std::uint64_t>(p.n[k]), std::bit_cast<std::uint64_t>(q.n[k]));
    ASSERT_EQ(std::bit_cast<std::uint64_t>(p.p_A[k]), std::bit_cast<std::uint64_t>(q.p_A[k]));
  }
}

struct DepthOf {
  const PosedSolids& set;
  const native::SolidSet data = native::make_solid_set(set.solids);

  const native::PoseRecord* poses() const {
    return reinterpret_cast<const native::PoseRecord*>(set.poses.data());
  }
  std::vector<DepthRecord> boxes(const native::Kernels& kernels,
                                 std::span<const native::PairIndices> pairs) const {
    std::vector<DepthRecord> out(pairs.size());
    kernels.compute_box_depths(poses(), data.boxes.data(), pairs.data(), pairs.size(), out.data());
    return out;
  }
  std::vector<DepthRecord> parallelepipeds(const native::Kernels& kernels,
                                           std::span<const native::PairIndices> pairs) const {
    std::vector<DepthRecord> out(pairs.size());
    kernels.compute_parallelepiped_depths(poses(), data.parallelepiped_edges.data(), pairs.data(),
                                          pairs.size(), out.data());
    return out;
  }
  native::PlacedPair placed(const native::PairIndices& pair) const {
    native::PlacedPair out;
    native::place(data, {pair.a, pair.b}, set.poses[pair.a], set.poses[pair.b], true, out);
    return out;
  }
  DepthRecord hulls(const native::Kernels& kernels, const native::PairIndices& pair) const {
    DepthRecord out;
    native::find_hull_depth(data, kernels, {pair.a, pair.b}, placed(pair),
                            std::max(norm_inf(set.poses[pair.a].p), norm_inf(set.poses[pair.b].p)), out);
    return out;
  }
};

/// Pairs in lanes have the bits of one pair, and place the hulls as place() does.
void expect_lanes_as_one_pair(const DepthOf& depth, const native::Kernels& kernels,
                              std::span<const native::PairIndices> pairs, std::size_t at_least) {
  // Pairs of hulls that lanes take.
  std::vector<native::HullTask> tasks;
  for (const native::PairIndices& pair : pairs) {
    const native::PlainHull &a = depth.data.solids[pair.a].hull->plain,
                            &b = depth.data.solids[pair.b].hull->plain;
    if (a.is_regular && b.is_regular) tasks.push_back({pair, &a, &b, nullptr, nullptr});
  }
  ASSERT_GT(tasks.size(), at_least);
  std::vector<DepthRecord> records(tasks.size());
  std::vector<native::PlacedHulls> placed(tasks.size());
  for (std::size_t i = 0; i < tasks.size(); ++i) tasks[i].depth = &records[i], tasks[i].placed = &placed[i];
  kernels.compute_hull_depths(depth.poses(), native::vertex_records(depth.data), tasks.data(), tasks.size(),
                              tasks.size());
  // Depths and placed hulls against those of each pair alone.
  int known = 0;
  for (std::size_t i = 0; i < tasks.size(); ++i) {
    expect_same_bits(depth.hulls(kernels, tasks[i].pair), records[i]);
    if (records[i].known == native::DepthKnown::nothing) continue;
    ++known;
    const native::PlacedPair alone = depth.placed(tasks[i].pair);
    ASSERT_EQ(std::memcmp(&alone.pair.hulls.a, placed[i].a, sizeof placed[i].a), 0);
    ASSERT_EQ(std::memcmp(&alone.pair.hulls.b, placed[i].b, sizeof placed[i].b), 0);
    const double(&origin)[3] = placed[i].origin;
    ASSERT_EQ(alone.origin_W, Vector3(origin[0], origin[1], origin[2]));
  }
  EXPECT_GT(known, 50);
}

/// The same pairs far from the world's origin, and of solids far from their own.
PosedSolids moved_away(const PosedSolids& set, const Vector3& in_world, const Vector3& in_solid) {
  PosedSolids out;
  for (const SolidPair& pair : set.pairs) {
    const auto moved = [&](SolidIndex solid) {
      std::vector<Vector3> corners(set.solids[solid].vertices().begin(), set.solids[solid].vertices().end());
      for (Vector3& corner : corners) corner += in_solid;
      return Hexahedron::from_vertices(corners, WarpPolicy::accept);
    };
    const auto pose = [&](SolidIndex solid) {
      Pose X_WS = set.poses[solid];
      X_WS.p += in_world - rotate(X_WS.R, in_solid);
      return X_WS;
    };
    out.add(moved(pair.a), pose(pair.a), moved(pair.b), pose(pair.b));
  }
  return out;
}

TEST(NativeDepthKernels, PairsInLanesHaveTheBitsOfOnePair) {
  const PosedSolids near = hard_pairs(5, 600);
  PosedSolids with_flat = near;
  add_flat_frusta(with_flat);
  for (const PosedSolids& set : {with_flat, moved_away(with_flat, {1e6, -3e5, 7e5}, Vector3::Zero()),
                                 moved_away(near, Vector3::Zero(), {512.0, -256.0, 64.0})}) {
    const DepthOf depth{set};
    const auto pairs = pairs_of_kind(depth.data, set, native::SolidKind::general);
    for (int k = 0; k < native::available_kernels().count; ++k) {
      const native::Kernels& kernels = *native::available_kernels().of[k];
      SCOPED_TRACE(kernels.isa);
      expect_lanes_as_one_pair(depth, kernels, pairs, 200);
      if (testing::Test::HasFailure()) return;
    }
  }
}

TEST(NativeDepthKernels, EveryInstructionSetGivesTheGenericBits) {
  // Pairs of each kind.
  PosedSolids set = hard_pairs(4, 2500);
  const PosedSolids tied = tied_boxes(9, 1000);
  for (const SolidPair& pair : tied.pairs)
    set.add(tied.solids[pair.a], tied.poses[pair.a], tied.solids[pair.b], tied.poses[pair.b]);
  const DepthOf depth{set};
  const auto boxes = pairs_of_kind(depth.data, set, native::SolidKind::box);
  const auto parallelepipeds = pairs_of_kind(depth.data, set, native::SolidKind::parallelepiped);
  const auto all = pairs_of_kind(depth.data, set, native::SolidKind::general);
  const PosedSolids hulls = overlapping_hulls(7, 3000);
  const DepthOf depth_of_bent{hulls};
  const auto bent = pairs_of_kind(depth_of_bent.data, hulls, native::SolidKind::general);
  ASSERT_GT(boxes.size(), 1600u);
  const native::Kernels& generic = *native::available_kernels().of[0];
  const auto box_records = depth.boxes(generic, boxes),
             parallelepiped_records = depth.parallelepipeds(generic, parallelepipeds);
  // Each instruction set against the first one.
  for (int k = 0; k < native::available_kernels().count; ++k) {
    const native::Kernels& kernels = *native::available_kernels().of[k];
    SCOPED_TRACE(kernels.isa);
    const auto other_boxes = depth.boxes(kernels, boxes),
               other_parallelepipeds = depth.parallelepipeds(kernels, parallelepipeds);
    // Boxes: in lanes, one alone, and from a contact.
    for (std::size_t i = 0; i < boxes.size(); ++i) {
      expect_same_bits(box_records[i], other_boxes[i]);
      expect_same_bits(box_records[i], depth.boxes(kernels, {&boxes[i], 1})[0]);
      DepthRecord of_contact;
      kernels.compute_box_pair_depth(depth.poses(), depth.data.boxes.data(), boxes[i],
                                     native::PairNeed::contacts, &of_contact);
      ASSERT_EQ(of_contact.certified, box_records[i].certified);
      if (of_contact.certified != native::Certified::separated) expect_same_bits(box_records[i], of_contact);
    }
    // The same of parallelepipeds, and of general solids one by one.
    for (std::size_t i = 0; i < parallelepipeds.size(); ++i) {
      expect_same_bits(parallelepiped_records[i], other_parallelepipeds[i]);
      expect_same_bits(parallelepiped_records[i],
                       depth.parallelepipeds(kernels, {&parallelepipeds[i], 1})[0]);
    }
    for (const native::PairIndices& pair : all)
      expect_same_bits(depth.hulls(generic, pair), depth.hulls(kernels, pair));
    for (const native::PairIndices& pair : bent)
      expect_same_bits(depth_of_bent.hulls(generic, pair), depth_of_bent.hulls(kernels, pair));
  }
}

/// Of boxes that rest six axes of fifteen tell: one by one and in lanes they have the same bits.
TEST(NativeDepthKernels, BoxesThatRestHaveTheBitsOfTheSearch) {
  namespace simd = native::baseline;
  int told = 0, of_edges = 0, met = 0;
  for (const std::uint64_t seed : {11, 12, 13}) {
    const PosedSolids set = resting_boxes(seed, 8000);
    const DepthOf depth{set};
    const auto boxes = pairs_of_kind(depth.data, set, native::SolidKind::box);
    const auto in_lanes = depth.boxes(native::kernels(), boxes);
    for (std::size_t i = 0; i < boxes.size(); ++i) {
      for (const auto need : {native::PairNeed::manifold, native::PairNeed::contacts}) {
        DepthRecord alone;
        native::kernels().compute_box_pair_depth(depth.poses(), depth.data.boxes.data(), boxes[i], need,
                                                 &alone);
        ASSERT_EQ(alone.certified, in_lanes[i].certified);
        if (alone.certified != native::Certified::separated) expect_same_bits(in_lanes[i], alone);
        if (testing::Test::HasFailure()) FAIL() << "seed " << seed << ", pair " << i;
      }
      // How many six axes tell.
      if (in_lanes[i].certified != native::Certified::overlapping) continue;
      DepthRecord of_six;
      const bool tells =
          simd::compute_resting_depth(depth.poses()[boxes[i].a], depth.data.boxes[boxes[i].a],
                                      depth.poses()[boxes[i].b], depth.data.boxes[boxes[i].b], &of_six);
      ++met, told += tells ? 1 : 0, of_edges += tells && of_six.axis >= 6 ? 1 : 0;
      if (tells) expect_same_bits(in_lanes[i], of_six);
    }
  }
  EXPECT_GT(told, met / 3);
  EXPECT_GT(of_edges, told / 20);
  RecordProperty("met", met), RecordProperty("told", told), RecordProperty("of_edges", of_edges);
}

/// What a lone contact takes from its first pass, in place of the search.
TEST(NativeDepthKernels, TheFirstPassTellsTheAxisOfMostLoneContacts) {
  namespace simd = native::baseline;
  Random random(10);
  PosedSolids set;
  for (int i = 0; i < 5000; ++i) set.add(random.box(), random.pose(0.5), random.box(), random.pose(1.0));
  const DepthOf depth{set};
  int met = 0, sure_of_axis = 0, apart = 0, sure_of_gap = 0;
  for (const native::PairIndices& pair : pairs_of_kind(depth.data, set, native::SolidKind::box)) {
    DepthRecord found;
    native::kernels().compute_box_pair_depth(depth.poses(), depth.data.boxes.data(), pair,
                                             native::PairNeed::distance, &found);
    const native::BoxRecord &a = depth.data.boxes[pair.a], &b = depth.data.boxes[pair.b];
    const simd::CoarsePair coarse(depth.poses()[pair.a], a, depth.poses()[pair.b], b);
    const simd::SureAxis sure(coarse, b);
    // Where it tells, the search does not contradict.
    if (sure.is_apart) {
      ASSERT_EQ(found.certified, native::Certified::separated);
    } else if (sure.code >= 0) {
      ASSERT_EQ(found.certified, native::Certified::overlapping);
      ASSERT_EQ(found.axis, sure.code);
    }
    // Pairs that a face separates do not get to it.
    if (coarse.separates()) continue;
    const bool is_apart = found.certified == native::Certified::separated;
    ++(is_apart ? apart : met);
    if (is_apart ? sure.is_apart : sure.code >= 0) ++(is_apart ? sure_of_gap : sure_of_axis);
  }
  EXPECT_GT(met, 1000);
  EXPECT_GT(sure_of_axis, met / 2);
  EXPECT_GT(apart, 30);
  EXPECT_GT(sure_of_gap, apart / 2);
  RecordProperty("met", met), RecordProperty("sure_of_axis", sure_of_axis);
  RecordProperty("apart", apart), RecordProperty("sure_of_gap", sure_of_gap);
}

/// Three closed forms and the scalar code: within 16 u of the extent of one another, and certificates right.
TEST(NativeDepthKernels, AgreeWithTheScalarCodeWhereTheyAnswer) {
  const PosedSolids set = hard_pairs(5, 4000);
  const DepthOf depth{set};
  const native::Kernels& kernels = native::kernels();
  int answered[3] = {0, 0, 0}, asked[3] = {0, 0, 0};
  // The class in integers, and the depth by scalar code.
  for (const native::PairIndices& pair : pairs_of_kind(depth.data, set, native::SolidKind::general)) {
    const native::PlacedPair placed = depth.placed(pair);
    const bool meet = native::hulls_meet(kernels, placed);
    const native::SeparationAxis axis = native::best_facet_axis(
        placed.pair.hulls, *placed.pair.a, placed.pair.R_WA, *placed.pair.b, placed.pair.R_WB);
    const native::SolidKind kind = native::kind_of(depth.data, {pair.a, pair.b});
    // Each kernel that takes the pair's kind.
    std::vector<std::pair<int, DepthRecord>> records{{2, depth.hulls(kernels, pair)}};
    if (kind <= native::SolidKind::parallelepiped)
      records.push_back({1, depth.parallelepipeds(kernels, {&pair, 1})[0]});
    if (kind == native::SolidKind::box) records.push_back({0, depth.boxes(kernels, {&pair, 1})[0]});
    for (const auto& [method, record] : records) {
      SCOPED_TRACE(method);
      if (record.certified != native::Certified::unknown) {
        ASSERT_EQ(record.certified == native::Certified::overlapping, meet);
      }
      if (!meet) continue;
      ++asked[method];
      if (record.known == native::DepthKnown::nothing) continue;
      ++answered[method];
      const double S = placed.pair.hulls.extent + norm(placed.origin_W);
      ASSERT_NEAR(record.separation, std::min(axis.separation, 0.0), 16 * native::kRoundoff * S);
    }
  }
  // Each answers more than half of what it is asked for.
  for (int method = 0; method < 3; ++method) {
    EXPECT_GT(answered[method], asked[method] / 2) << method;
    RecordProperty("asked" + std::to_string(method), asked[method]);
    RecordProperty("answered" + std::to_string(method), answered[method]);
  }
}

TEST(NativeDepthKernels, NameTheAxisAlongWhichBoxesAreFurthestApart) {
  Random random(8);
  PosedSolids set;
  for (int i = 0; i < 2000; ++i) set.add(random.box(), random.pose(1.0), random.box(), random.pose(1.0));
  const DepthOf depth{set};
  const auto boxes = pairs_of_kind(depth.data, set, native::SolidKind::box);
  const auto records = depth.boxes(native::kernels(), boxes);
  int by_edges = 0, by_faces = 0;
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    if (records[i].certified != native::Certified::separated) continue;
    ++(records[i].axis >= 6 ? by_edges : by_faces);
    const Hexahedron &a = set.solids[boxes[i].a], &b = set.solids[boxes[i].b];
    const Pose &X_WA = set.poses[boxes[i].a], &X_WB = set.poses[boxes[i].b];
    const double furthest = LeastAxes(a, X_WA, b, X_WB).gap[0];
    ASSERT_GT(furthest, 0.0);
    ASSERT_NEAR(gap_along(a, X_WA, b, X_WB, records[i].axis), furthest, 1e-13) << i;
  }
  EXPECT_GT(by_edges, 50);
  EXPECT_GT(by_faces, 300);
}

/// Whether n is no face's normal: then it is across an edge of each.
bool is_across_edges(const native::PlacedPair& placed, const double (&n)[3]) {
  const auto is_along = [&](const native::SolidFeatures& solid, const Matrix3& R) {
    for (int f = 0; f < solid.normal_count; ++f)
      if (std::abs(dot(rotate(R, solid.normals[f]), Vector3(n[0], n[1], n[2]))) > 1 - 1e-12) return true;
    return false;
  };
  return !is_along(*placed.pair.a, placed.pair.R_WA) && !is_along(*placed.pair.b, placed.pair.R_WB);
}

TEST(NativeDepthKernels, PassOverNoEdgeThatHasTheDepth) {
  const PosedSolids set = overlapping_hulls(6, 6000);
  const DepthOf depth{set};
  int across = 0, bent = 0;
  for (const native::PairIndices& pair : pairs_of_kind(depth.data, set, native::SolidKind::general)) {
    const native::PlacedPair placed = depth.placed(pair);
    const DepthRecord record = depth.hulls(native::kernels(), pair);
    if (record.certified != native::Certified::overlapping || record.known == native::DepthKnown::nothing)
      continue;
    // All faces and all pairs of edges, none left out.
    const native::SeparationAxis axis = native::best_facet_axis(
        placed.pair.hulls, *placed.pair.a, placed.pair.R_WA, *placed.pair.b, placed.pair.R_WB);
    const double S = placed.pair.hulls.extent + norm(placed.origin_W);
    ASSERT_NEAR(record.separation, axis.separation, 16 * native::kRoundoff * S);
    if (!is_across_edges(placed, record.n)) continue;
    ++across;
    if (depth.data.solids[pair.a].hull->record.topology.edge_count > 16) ++bent;
  }
  EXPECT_GT(across, 1000);
  EXPECT_GT(bent, 300);
}

TEST(NativeDepthKernels, LeaveDoubtfulParallelEdgesToTheScalarCode) {
  // Edges that cross at `angle`, B's below A's by `depth` where they cross: the sliver facet is the nearest.
  for (const int exponent : {-5, -12, -20, -30, -40}) {
    const double angle = std::ldexp(1.0, exponent);
    Pose X_WA, X_WB;
    X_WA.R = rotation_from_quaternion(std::cos(M_PI / 8), std::sin(M_PI / 8), 0, 0);
    Pose turn;
    turn.R = rotation_from_quaternion(1.0, 0, 0, angle / 2);
    X_WB.R = compose(turn, X_WA).R;
    X_WB.p = {0, 0, std::sqrt(2.0) - angle * 1e-3};
    PosedSolids set;
    set.add(Hexahedron::from_size({1, 1, 1}), X_WA, Hexahedron::from_size({1, 1, 1}), X_WB);
    const Answers answers = measure_distances(set, 1);
    ASSERT_EQ(answers.status[0], PairStatus::overlapping);
    SCOPED_TRACE(exponent);
    expect_right(set, 0, answers.geometry[0]);
  }
}

}  // namespace
}  // namespace touchstone
