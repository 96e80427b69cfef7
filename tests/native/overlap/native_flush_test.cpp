#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "touchstone/contact_core/native/common/hull_pair.hpp"
#include "touchstone/contact_core/native/distance/facet_axes.hpp"
#include "touchstone/contact_core/native/distance/pair_depth.hpp"
#include "touchstone/contact_core/native/manifold/clip_batch.hpp"
#include "touchstone/contact_core/native/overlap/aligned_hulls.hpp"
#include "touchstone/contact_core/numerics/exact_predicates.hpp"
#include "touchstone/tests/native/native_fixture.hpp"

// Boxes laid flush on each other, as engines leave them: deep by anything from roundings to millimetres, or
// apart by as little, and turned by noise.

namespace touchstone {
namespace {

struct Flush {
  std::vector<Hexahedron> solids;  // pair i: 2i and 2i + 1
  std::vector<Pose> poses;
  std::vector<SolidPair> pairs;
};

/// Along the world's axes when `is_aligned`, but for the noise.
Flush flush_pairs(std::uint64_t seed, int count, bool is_aligned) {
  Random random(seed);
  Flush out;
  for (int i = 0; i < count; ++i) {
    const auto first = static_cast<SolidIndex>(out.solids.size());
    // Sizes on a grid: edges come to lie on edges, corners on corners.
    const auto size = [&] {
      return Vector3(0.25 * (1 + random.below(6)), 0.25 * (1 + random.below(6)),
                     0.25 * (1 + random.below(6)));
    };
    const Hexahedron a = Hexahedron::from_size(size()), b = Hexahedron::from_size(size());
    const double depth = random.below(4) == 0
                             ? 0.0
                             : (random.below(3) == 0 ? -1.0 : 1.0) * std::ldexp(1.0, -8 - random.below(48));
    const double noise = random.below(4) == 0 ? 0.0 : std::ldexp(1.0, -10 - random.below(46));
    Pose X_AB, turn, frame;
    const Vector3 axis = noise * random.vector(1.0);
    turn.R = rotation_from_quaternion(1.0, axis.x(), axis.y(), axis.z());
    X_AB = turn;
    X_AB.p = {0.125 * (random.below(9) - 4), 0.125 * (random.below(9) - 4),
              a.half_extents().z() + b.half_extents().z() - depth};
    if (is_aligned)
      frame.p = 0.5 * Vector3(random.below(9), random.below(9), random.below(9));
    else
      frame = random.pose(3.0);
    out.solids.push_back(a), out.solids.push_back(b);
    out.poses.push_back(frame), out.poses.push_back(compose(frame, X_AB));
    out.pairs.push_back(random.below(2) == 0 ? SolidPair{first, first + 1} : SolidPair{first + 1, first});
  }
  return out;
}

struct Worlds {
  WorldVertices a, b;
};

Worlds vertices_of(const Flush& set, const SolidPair& pair) {
  Worlds out;
  world_vertices(set.solids[pair.a], set.poses[pair.a], out.a);
  world_vertices(set.solids[pair.b], set.poses[pair.b], out.b);
  return out;
}

TEST(NativeFlush, ClassesAreExactAndDepthsThoseOfScalarCode) {
  for (const bool is_aligned : {true, false}) {
    const Flush set = flush_pairs(is_aligned ? 1 : 2, 3000, is_aligned);
    const native::SolidSet data = native::make_solid_set(set.solids);
    const std::unique_ptr<Narrowphase> native = make_native();
    native->build(set.solids);
    int met = 0;
    // Classes are those in integers.
    for (const SolidPair& pair : set.pairs) {
      const Worlds worlds = vertices_of(set, pair);
      const bool meet = numerics::hulls_intersect(worlds.a, worlds.b);
      const Answer answer =
          touchstone::ask(*native, set.poses, Query{QueryKind::manifold, 1.0, 8, 1.0}, pair);
      ASSERT_EQ(answer.status == PairStatus::overlapping, meet);
      ASSERT_EQ(answer.geometry.separation <= 0.0, meet);
      ASSERT_GE(answer.geometry.point_count, 1);
      if (!meet) continue;
      ++met;
      // Depths are those of scalar code.
      native::PlacedPair placed;
      native::place(data, pair, set.poses[pair.a], set.poses[pair.b], true, placed);
      const native::SeparationAxis axis = native::best_facet_axis(
          placed.pair.hulls, *placed.pair.a, placed.pair.R_WA, *placed.pair.b, placed.pair.R_WB);
      const double S = placed.pair.hulls.extent + norm(placed.origin_W);
      ASSERT_NEAR(answer.geometry.separation, std::min(axis.separation, 0.0), 16 * native::kRoundoff * S);
    }
    EXPECT_GT(met, 1500);
  }
}

TEST(NativeFlush, ComparedCoordinatesNeverContradictTheExactClass) {
  int decided = 0, aligned_and_touching = 0;
  for (const bool is_aligned : {true, false}) {
    const Flush set = flush_pairs(3, 4000, is_aligned);
    for (const SolidPair& pair : set.pairs) {
      const Worlds worlds = vertices_of(set, pair);
      const native::Certified certified = native::certify_aligned(worlds.a, worlds.b);
      aligned_and_touching += is_aligned ? 1 : 0;
      if (certified == native::Certified::unknown) continue;
      decided += is_aligned ? 1 : 0;
      ASSERT_EQ(certified == native::Certified::overlapping, numerics::hulls_intersect(worlds.a, worlds.b));
    }
  }
  EXPECT_GT(decided, aligned_and_touching / 2);  // the rest is turned too far
}

/// The rotations that take the world's axes to themselves.
std::vector<Matrix3> axis_rotations() {
  std::vector<Matrix3> out;
  for (int x = 0; x < 6; ++x) {
    for (int y = 0; y < 6; ++y) {
      if (x % 3 == y % 3) continue;
      Matrix3 R = Matrix3::Zero();
      R(x % 3, 0) = x < 3 ? 1.0 : -1.0;
      R(y % 3, 1) = y < 3 ? 1.0 : -1.0;
      R.col(2) = cross(R.col(0), R.col(1));
      out.push_back(R);
    }
  }
  return out;
}

TEST(NativeFlush, ABoxTurnedByACosineThatIsNotZeroIsNotAligned) {
  // cos(pi/2) is 6e-17: over a lever of a metre that parts what the boxes' intervals let meet.
  Pose X_WA, X_WB;
  const double c = std::cos(1.5707963267948966), s = 1.0;
  X_WA.R << c, -s, 0, s, c, 0, 0, 0, 1;
  X_WB.p = {0.9, 0.02, 0};
  const Hexahedron a = Hexahedron::from_size({0.02, 2, 1}), b = Hexahedron::from_size({0.02, 0.02, 0.02});
  WorldVertices a_W, b_W;
  world_vertices(a, X_WA, a_W);
  world_vertices(b, X_WB, b_W);
  ASSERT_FALSE(numerics::hulls_intersect(a_W, b_W));
  EXPECT_EQ(native::certify_aligned_boxes(a.half_extents(), X_WA, b.half_extents(), X_WB),
            native::Certified::unknown);
  for (const QueryKind kind : {QueryKind::overlap, QueryKind::distance, QueryKind::manifold})
    EXPECT_EQ(ask(a, X_WA, b, X_WB, kind).status, PairStatus::separated);
}

TEST(NativeFlush, AlignedBoxesHaveTheExactClassAndAreAlwaysDecided) {
  Random random(5);
  const std::vector<Matrix3> rotations = axis_rotations();
  ASSERT_EQ(rotations.size(), 24u);
  int touching = 0, met = 0;
  constexpr int kCount = 20000;
  for (int i = 0; i < kCount; ++i) {
    const auto size = [&] { return Vector3(random.vector(1.0).cwiseAbs() + Vector3::Constant(0.01)); };
    const Hexahedron a = Hexahedron::from_size(size()), b = Hexahedron::from_size(size());
    Pose X_WA{rotations[random.below(24)], random.vector(std::ldexp(1.0, random.below(20)))};
    Pose X_WB{rotations[random.below(24)], X_WA.p + 0.5 * random.vector(1.0)};
    WorldVertices a_W, b_W;
    world_vertices(a, X_WA, a_W);
    // Face on face, to an ulp of the position.
    const int k = random.below(3);
    const Vector3 reach_b = X_WB.R.cwiseAbs() * b.half_extents();
    X_WB.p(k) = *std::max_element(&(k == 0   ? a_W.x
                                    : k == 1 ? a_W.y
                                             : a_W.z)[0],
                                  &(k == 0   ? a_W.x
                                    : k == 1 ? a_W.y
                                             : a_W.z)[0] +
                                      8) +
                reach_b(k);
    if (random.below(3) == 0) X_WB.p(k) = std::nextafter(X_WB.p(k), random.below(2) == 0 ? -1e9 : 1e9);
    world_vertices(b, X_WB, b_W);
    const native::Certified certified =
        native::certify_aligned_boxes(a.half_extents(), X_WA, b.half_extents(), X_WB);
    const bool meet = numerics::hulls_intersect(a_W, b_W);
    ASSERT_EQ(certified, meet ? native::Certified::overlapping : native::Certified::separated) << i;
    met += meet ? 1 : 0;
    touching += certified == native::certify_aligned(a_W, b_W) ? 1 : 0;
    X_WB.R = rotation_from_quaternion(1.0, 1e-9, 0.0, 0.0);
    ASSERT_EQ(native::certify_aligned_boxes(a.half_extents(), X_WA, b.half_extents(), X_WB),
              native::Certified::unknown);
  }
  EXPECT_EQ(touching, kCount);  // the vertices say so, too
  EXPECT_GT(met, kCount / 4);
  EXPECT_LT(met, kCount * 9 / 10);
}

/// Hulls with vertices on a grid: tapered, flattened and askew, with coordinates that tie. Every other second
/// one of a pair is long, and ends on both sides of the first.
struct GridHulls {
  std::vector<WorldVertices> vertices_S;
  std::vector<Pose> poses;
  std::vector<native::PairIndices> pairs;

  explicit GridHulls(int count) {
    Random random(4);
    const std::vector<Matrix3> rotations = axis_rotations();
    for (int i = 0; i < count; ++i) {
      for (int s = 0; s < 2; ++s) {
        WorldVertices& v = vertices_S.emplace_back();
        const double length = s == 1 && i % 2 == 1 ? 16.0 : 4.0;
        for (int k = 0; k < 8; ++k) {
          const auto place = [&](int bit) { return ((k & bit) != 0 ? 4.0 : 0.0) + random.below(3); };
          v.x[k] = place(4) + 3.0 * s, v.y[k] = place(2);
          v.z[k] = ((k & 1) != 0 ? length - 2.0 : 2.0 - length) + random.below(3);
        }
      }
      poses.insert(poses.end(), 2, {rotations[random.below(24)], random.vector(100.0)});
      pairs.push_back({static_cast<std::uint32_t>(2 * i), static_cast<std::uint32_t>(2 * i + 1)});
    }
  }

  Worlds worlds(std::size_t i) const {
    Worlds out;
    native::world_vertices(vertices_S[2 * i], poses[2 * i], out.a);
    native::world_vertices(vertices_S[2 * i + 1], poses[2 * i + 1], out.b);
    return out;
  }
};

TEST(NativeFlush, AlignedHullsOfAnyShapeHaveTheExactClassAloneAndInLanes) {
  GridHulls hulls(20000);
  hulls.vertices_S[4].y.fill(kNaN);  // leaves a pair unknown
  std::vector<native::Certified> alone;
  int decided = 0;
  for (std::size_t i = 0; i < hulls.pairs.size(); ++i) {
    const Worlds worlds = hulls.worlds(i);
    alone.push_back(i == 2 ? native::Certified::unknown : native::certify_aligned(worlds.a, worlds.b));
    if (alone.back() == native::Certified::unknown) continue;
    ++decided;
    ASSERT_EQ(alone.back() == native::Certified::overlapping, numerics::hulls_intersect(worlds.a, worlds.b));
  }
  EXPECT_GT(decided, 1000);
  // In lanes, with a count that no number of them divides.
  const auto* const poses = reinterpret_cast<const native::PoseRecord*>(hulls.poses.data());
  const auto* const vertices = reinterpret_cast<const native::VertexRecord*>(hulls.vertices_S.data());
  alone.pop_back();
  for (int k = 0; k < native::available_kernels().count; ++k) {
    std::vector<native::Certified> together(alone.size());
    native::available_kernels().of[k]->certify_aligned(poses, vertices, hulls.pairs.data(), together.size(),
                                                       together.data());
    ASSERT_EQ(together, alone) << native::available_kernels().of[k]->isa;
  }
}

TEST(NativeFlush, CoordinatesTellWhereTheEdgeOfALongPrismLiesOnABox) {
  // No vertex of either is on the other.
  WorldVertices box, prism;
  world_vertices(Hexahedron::from_size({1, 1, 1}), at(0, 0, 0), box);
  const auto ring = [](int i) { return std::array{Vector3(-1, 0, 0), Vector3(0, 1, 0)}[i & 1]; };
  for (int i = 0; i < 8; ++i) {
    const Vector3 p = (i & 4) != 0 ? -ring(i >> 1) : ring(i >> 1);
    prism.x[i] = 1.5 + p.x(), prism.y[i] = 0.2 + p.y(), prism.z[i] = (i & 1) != 0 ? 0.6 : -0.7;
  }
  EXPECT_EQ(native::certify_aligned(box, prism), native::Certified::overlapping);
  EXPECT_EQ(native::certify_aligned(prism, box), native::Certified::overlapping);
  for (double& x : prism.x) x += 0x1p-52;
  EXPECT_EQ(native::certify_aligned(box, prism), native::Certified::separated);
}

TEST(NativeFlush, AloneAndTogetherGiveTheSameBitsOnEveryInstructionSet) {
  const Flush set = flush_pairs(5, 1000, false);
  const native::SolidSet data = native::make_solid_set(set.solids);
  const auto* const poses = reinterpret_cast<const native::PoseRecord*>(set.poses.data());
  std::vector<native::ClipTask> tasks;
  std::vector<native::PointRecord> points(8 * set.pairs.size()), alone(8);
  const native::Kernels& generic = *native::available_kernels().of[0];
  // A task for each pair whose depth is found in lanes.
  for (const SolidPair& given : set.pairs) {
    const bool swapped = !native::comes_first(data, given, set.poses[given.a], set.poses[given.b]);
    const native::PairIndices pair{swapped ? given.b : given.a, swapped ? given.a : given.b};
    native::DepthRecord depth;
    generic.compute_box_depths(poses, data.boxes.data(), &pair, 1, &depth);
    if (depth.known == native::DepthKnown::nothing) continue;
    native::ClipTask& task = tasks.emplace_back();
    for (int k = 0; k < 3; ++k) task.n_separation[k] = depth.n[k];
    task.n_separation[3] = depth.separation;
    task.pair = pair, task.swapped = swapped;
    task.points = &points[8 * (tasks.size() - 1)];
  }
  // All in one call.
  ASSERT_GT(tasks.size(), 500u);
  std::vector<native::ClipRecord> together(tasks.size());
  generic.clip_boxes(poses, data.boxes.data(), tasks.data(), tasks.size(), 0.5, together.data());
  // One a call, on every instruction set.
  for (int k = 0; k < native::available_kernels().count; ++k) {
    const native::Kernels& kernels = *native::available_kernels().of[k];
    for (std::size_t i = 0; i < tasks.size(); ++i) {
      native::ClipTask task = tasks[i];
      task.points = alone.data();
      native::ClipRecord record;
      kernels.clip_boxes(poses, data.boxes.data(), &task, 1, 0.5, &record);
      ASSERT_EQ(record.fits, together[i].fits) << kernels.isa;
      ASSERT_EQ(record.count, together[i].count) << kernels.isa;
      ASSERT_EQ(record.deepest, together[i].deepest);
      for (int p = 0; p < record.count; ++p) {
        const native::PointRecord &one = alone[p], &other = points[8 * i + static_cast<std::size_t>(p)];
        ASSERT_EQ(one.feature_id, other.feature_id);
        ASSERT_TRUE(same_bits(one.separation, other.separation));
        for (int c = 0; c < 3; ++c)
          ASSERT_TRUE(same_bits(one.p_A[c], other.p_A[c]) && same_bits(one.p_B[c], other.p_B[c]));
      }
    }
  }
}

}  // namespace
}  // namespace touchstone
