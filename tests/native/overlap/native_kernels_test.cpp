#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/native/engine/pair_geometry.hpp"
#include "touchstone/contact_core/native/overlap/overlap.hpp"
#include "touchstone/contact_core/native/simd/kernels.hpp"
#include "touchstone/contact_core/numerics/exact_predicates.hpp"
#include "touchstone/tests/native/native_fixture.hpp"

// The kernels of every instruction set that this machine has, against the exact answer and one another.

namespace touchstone {
namespace {

using native::Certified;

struct Crowd {
  std::vector<Hexahedron> solids;
  std::vector<Pose> poses;
  std::vector<SolidPair> pairs;
  std::vector<bool> meet;

  void add(const Hexahedron& a, const Pose& X_WA, const Hexahedron& b, const Pose& X_WB) {
    const auto first = static_cast<SolidIndex>(solids.size());
    solids.push_back(a), solids.push_back(b);
    poses.push_back(X_WA), poses.push_back(X_WB);
    pairs.push_back({first, first + 1});
    WorldVertices a_W, b_W;
    world_vertices(a, X_WA, a_W);
    world_vertices(b, X_WB, b_W);
    meet.push_back(numerics::hulls_intersect(a_W, b_W));
  }

  /// The same boxes 2^scale as large.
  void add_scaled(int scale, const Hexahedron& a, Pose X_WA, const Hexahedron& b, Pose X_WB) {
    const double k = std::ldexp(1.0, scale);
    X_WA.p *= k, X_WB.p *= k;
    add(Hexahedron::from_size(2.0 * k * a.half_extents()), X_WA,
        Hexahedron::from_size(2.0 * k * b.half_extents()), X_WB);
  }
};

/// Apart, overlapping, within an ulp of touching, far away; ordinary magnitudes and others; all kinds.
Crowd make_crowd(int count) {
  Random random(41);
  Crowd out;
  for (int i = 0; i < count; ++i) {
    const Hexahedron a = random.any(), b = random.any();
    Pose X_WA = random.pose(0.3), X_WB = random.pose(1.2);
    if (i % 3 == 1) {
      const PairGeometry g = ask(a, X_WA, b, X_WB, QueryKind::distance).geometry;
      X_WB.p -= g.separation * g.n_AB_W;
    } else if (i % 3 == 2) {
      const Vector3 far = random.vector(std::ldexp(1.0, random.below(40)));
      X_WA.p += far, X_WB.p += far;
    }
    out.add(a, X_WA, b, X_WB);
    if (i % 20 == 0) {
      for (const double k : {0x1p-400, 0x1p-125, 0x1p-110, 0x1p110, 0x1p125, 0x1p400}) {
        const Hexahedron cube = Hexahedron::from_size(Vector3::Constant(k));
        Pose X_k = random.pose(0.9);
        X_k.p *= k;
        out.add(cube, at(0, 0, 0), cube, X_k);
      }
    }
  }
  return out;
}

const native::PoseRecord* records(const Crowd& crowd) {
  return reinterpret_cast<const native::PoseRecord*>(crowd.poses.data());
}

TEST(NativeKernels, WhatThePortalCertifiesIsSoOnEveryInstructionSet) {
  const Crowd crowd = make_crowd(600);
  const native::SolidSet set = native::make_solid_set(crowd.solids);
  std::vector<native::PairIndices> pairs;
  for (const SolidPair& pair : crowd.pairs) pairs.push_back({pair.a, pair.b});
  const auto certify = [&](const native::Kernels& kernels, int steps) {
    std::vector<Certified> out(pairs.size());
    kernels.certify_by_mpr(records(crowd), native::vertex_records(set), pairs.data(), pairs.size(), steps,
                           out.data(), nullptr);
    return out;
  };
  const native::KernelList& list = native::available_kernels();
  for (const int steps : {0, 1, 8}) {
    const std::vector<Certified> plain = certify(*list.of[0], steps);
    int known = 0;
    for (std::size_t i = 0; i < plain.size(); ++i) {
      if (plain[i] == Certified::unknown) continue;
      ++known;
      EXPECT_EQ(plain[i] == Certified::overlapping, crowd.meet[i]) << i;
    }
    EXPECT_GT(known, steps == 8 ? 300 : 50);
    for (int k = 1; k < list.count; ++k) EXPECT_EQ(certify(*list.of[k], steps), plain) << list.of[k]->isa;
  }
}

/// Boxes within 2^-16 to 2^-50 of touching, half of them with edges at small angles.
Crowd make_near_touching_boxes(int count) {
  Random random(43);
  Crowd out;
  for (int i = 0; i < count; ++i) {
    const Hexahedron a = random.box(), b = random.box();
    const Pose X_WA = random.pose(0.3);
    Pose X_WB = random.pose(1.2);
    if (i % 2 == 0) {
      const Vector3 turn = random.vector(std::ldexp(1.0, -5 - random.below(49)));
      X_WB.R = X_WA.R * rotation_from_quaternion(1.0, turn.x(), turn.y(), turn.z());
    }
    const PairGeometry g = ask(a, X_WA, b, X_WB, QueryKind::distance).geometry;
    const double gap = (i % 3 == 0 ? -1.0 : 1.0) * std::ldexp(1.0, -16 - random.below(35));
    X_WB.p -= (g.separation - gap) * g.n_AB_W;
    out.add(a, X_WA, b, X_WB);
  }
  return out;
}

TEST(NativeKernels, TheSecondPassOverBoxesIsRightOnEveryInstructionSet) {
  const Crowd crowd = make_near_touching_boxes(3000);
  const native::SolidSet set = native::make_solid_set(crowd.solids);
  std::vector<native::PairIndices> pairs;
  for (const SolidPair& pair : crowd.pairs) pairs.push_back({pair.a, pair.b});
  std::vector<Certified> first(pairs.size()), close(pairs.size());
  const native::KernelList& list = native::available_kernels();
  for (int k = 0; k < list.count; ++k) {
    SCOPED_TRACE(list.of[k]->isa);
    list.of[k]->certify_boxes(records(crowd), set.boxes.data(), pairs.data(), pairs.size(), close.data());
    int left_by_coarse = 0, left = 0;
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      const auto [a, b] = pairs[i];
      const Certified coarse =
          list.of[k]->certify_box_pair(records(crowd)[a], set.boxes[a], records(crowd)[b], set.boxes[b]);
      left_by_coarse += coarse == Certified::unknown ? 1 : 0;
      left += close[i] == Certified::unknown ? 1 : 0;
      if (close[i] == Certified::unknown) continue;
      ASSERT_EQ(close[i] == Certified::overlapping, crowd.meet[i]) << i;
      // The scalar filter, which is the same, agrees.
      ASSERT_EQ(close[i], native::certify_kinds(set, crowd.pairs[i], crowd.poses)) << i;
    }
    EXPECT_TRUE(list.of[k]->lanes == 2 || left_by_coarse > 2000) << left_by_coarse;
    EXPECT_LT(left, 1000);
    if (k == 0) first = close;
    EXPECT_EQ(close, first);
  }
}

/// A box's axes in the world such that axis j is `along` and `outwards`, across it, lies between the two
/// others, at `angle` to the first of them.
Matrix3 frame_about_edge(int j, const Vector3& along, const Vector3& outwards, double angle) {
  const Vector3 beside = cross(outwards, along);
  Matrix3 R;
  R.col(j) = along;
  R.col((j + 1) % 3) = std::cos(angle) * outwards + std::sin(angle) * beside;
  R.col((j + 2) % 3) = std::sin(angle) * outwards - std::cos(angle) * beside;
  return R;
}

/// On the edge along axis j that lies outermost along the two other axes.
Vector3 on_outer_edge(const Hexahedron& box, int j, double along) {
  Vector3 p = box.half_extents();
  p(j) *= along;
  return p;
}

Vector3 unit(const Vector3& v) { return v / norm(v); }

/// Boxes of which an edge meets one of the other within roundings, at a sine of 1 to 2^-52 or 0: anywhere
/// along both edges and a little beyond their ends, seen along any direction between the edges' faces and a
/// little beyond. Matrices are rotations but for `defect`; the boxes are 2^scale as large.
Crowd make_crossing_edges(int count, double defect, int scale) {
  Random random(45);
  Crowd out;
  for (int i = 0; i < count; ++i) {
    const auto box = [&] { return random.below(4) == 0 ? random.slab_or_needle() : random.box(); };
    const auto place = [&] { return random.uniform(-1.05, 1.05); };
    const auto angle = [&] { return random.uniform(-0.02, 1.59); };
    const auto disturb = [&](Pose& X) {
      for (int k = 0; k < 3; ++k) X.R.col(k) += random.vector(defect);
    };
    const Hexahedron a = box(), b = box();
    const int edge_a = random.below(3), edge_b = random.below(3);
    // A's edge, and a direction outwards there.
    const Vector3 along = unit(random.vector(1.0));
    const Vector3 outwards = unit(cross(along, random.vector(1.0)));
    Pose X_WA;
    X_WA.R = frame_about_edge(edge_a, along, outwards, angle());
    disturb(X_WA);
    X_WA.p = random.vector(random.below(3) == 0 ? 1000.0 : 0.5);
    // B's edge, turned about that direction.
    const int exponent = random.below(60);
    const double sine = exponent > 52 ? 0.0 : std::ldexp(random.below(2) == 0 ? 1.0 : -1.0, -exponent);
    const Vector3 turned = std::sqrt(1.0 - sine * sine) * along + sine * cross(outwards, along);
    Pose X_WB;
    X_WB.R = frame_about_edge(edge_b, unit(turned), -outwards, angle());
    disturb(X_WB);
    const double gap =
        0x1p-53 * (random.below(5) - 2) * std::ldexp(1.0, random.below(3) == 0 ? random.below(20) : 0);
    X_WB.p = (transform(X_WA, on_outer_edge(a, edge_a, place())) + gap * outwards) -
             rotate(X_WB.R, on_outer_edge(b, edge_b, place()));
    out.add_scaled(scale, a, X_WA, b, X_WB);
  }
  return out;
}

/// Vertex of a box turned by R about its centre, as its world vertex is computed.
Vector3 turned_vertex(const Matrix3& R, const Vector3& half, const std::array<double, 3>& signs) {
  Vector3 out;
  for (int i = 0; i < 3; ++i)
    out(i) = (signs[0] * half(0) * R(i, 0) + signs[1] * half(1) * R(i, 1)) + signs[2] * half(2) * R(i, 2);
  return out;
}

/// Boxes of 2^105 to 2^114 that meet in a vertex of each, of edges at a sine of 2^-20 to 2^-55; but A lies
/// aside by so little that its products with the edges' directions are denormal numbers.
Crowd make_edges_next_to_denormals(int count) {
  Random random(47);
  Crowd out;
  while (static_cast<int>(out.pairs.size()) < count) {
    const double length = std::ldexp(1.0, 105 + random.below(10));
    const auto extent = [&] { return 2.0 * random.uniform(0.3, 1.0) * length; };
    const double square = extent();
    const Hexahedron a = Hexahedron::from_size({square, square, extent()});
    const Hexahedron b = Hexahedron::from_size({extent(), extent(), extent()});
    // A vertex of A whose first coordinate is that of A's centre, exactly.
    const double angle = random.uniform(-3.2, 3.2), c = std::sqrt(0.5);
    Pose X_WA, X_WB;
    X_WA.R.col(0) = Vector3(c, c * std::cos(angle), c * std::sin(angle));
    X_WA.R.col(1) = Vector3(-c, c * std::cos(angle), c * std::sin(angle));
    X_WA.R.col(2) = Vector3(0.0, -std::sin(angle), std::cos(angle));
    // B's edge is A's, turned by the sine about a direction outwards.
    const int exponent = 20 + random.below(36), edge_b = random.below(3);
    const double lean = std::ldexp(1.0, std::min(0, exponent - 53 + random.below(4)));
    const Vector3 outwards =
        unit(Vector3(random.uniform(-0.5, 0.5) * lean, std::cos(angle), std::sin(angle)));
    const double sine = std::ldexp(random.uniform(-1.0, 1.0), -exponent);
    const Vector3 along = X_WA.R.col(2);
    const Vector3 turned = std::sqrt(1.0 - sine * sine) * along + sine * cross(outwards, along);
    X_WB.R = frame_about_edge(edge_b, unit(turned), -outwards, random.uniform(0.1, 1.45));
    std::array<double, 3> at_b = {1.0, 1.0, 1.0};
    at_b[edge_b] = -1.0;
    X_WA.p = -turned_vertex(X_WA.R, a.half_extents(), {1.0, 1.0, -1.0});
    X_WB.p = -turned_vertex(X_WB.R, b.half_extents(), at_b);
    if (X_WA.p(0) != 0.0) continue;
    X_WA.p(0) = std::ldexp(random.uniform(-1.0, 1.0), -956 - exponent - random.below(8));
    if (is_valid_pose(X_WA) && is_valid_pose(X_WB)) out.add(a, X_WA, b, X_WB);
  }
  return out;
}

/// Turned about axis k by twice the angle of this tangent: what is no cosine or sine is exactly 0 or 1.
Matrix3 turn_about(int k, double tangent) {
  const double d = 1.0 + tangent * tangent, c = (1.0 - tangent * tangent) / d, s = 2.0 * tangent / d;
  Matrix3 R = Matrix3::Identity();
  const int x = (k + 1) % 3, y = (k + 2) % 3;
  R(x, x) = R(y, y) = c, R(y, x) = s, R(x, y) = -s;
  return R;
}

/// Boxes one on the other along an axis of the world, within an ulp, and beside each other by 2^-20 to 2^-52
/// at most, where not well within reach; 2^scale as large.
Crowd make_flush_along_the_world(int count, int scale) {
  Random random(46);
  Crowd out;
  for (int i = 0; i < count; ++i) {
    const Hexahedron a = random.box(), b = random.box();
    const int k = random.below(3), x = (k + 1) % 3;
    const auto turn = [&] { return turn_about(k, random.below(3) == 0 ? 0.0 : random.uniform(-1.0, 1.0)); };
    const Pose X_WA{turn(), random.vector(std::ldexp(1.0, random.below(12)))};
    Pose X_WB{turn(), X_WA.p};
    // Beside one of A's faces.
    Vector3 offset = random.uniform(-0.9, 0.9) * a.half_extents()((x + 1) % 3) * X_WA.R.col((x + 1) % 3);
    const Vector3 n = X_WA.R.col(x);
    const Vector3 reach = b.half_extents();
    double beside = a.half_extents()(x);
    for (int m = 0; m < 3; ++m) beside += reach(m) * std::abs(dot(n, X_WB.R.col(m)));
    const double gap = std::ldexp(random.uniform(-1.0, 1.0), -20 - random.below(33));
    offset += (random.below(2) == 0 ? beside + gap : random.uniform(-1.0, 1.0) * beside) * n;
    X_WB.p += offset;
    const double up = random.below(2) == 0 ? 1.0 : -1.0;
    X_WB.p(k) = X_WA.p(k) + up * (a.half_extents()(k) + b.half_extents()(k));
    if (random.below(3) == 0) X_WB.p(k) = std::nextafter(X_WB.p(k), X_WB.p(k) + up * (random.below(2) - 0.5));
    out.add_scaled(scale, a, X_WA, b, X_WB);
  }
  return out;
}

/// Returns how many pairs are left unknown.
int count_left_by_touching_kernels(const Crowd& crowd) {
  const native::SolidSet set = native::make_solid_set(crowd.solids);
  std::vector<native::PairIndices> pairs;
  for (const SolidPair& pair : crowd.pairs) pairs.push_back({pair.a, pair.b});
  std::vector<Certified> first, found(pairs.size());
  const native::KernelList& list = native::available_kernels();
  for (int k = 0; k < list.count; ++k) {
    SCOPED_TRACE(list.of[k]->isa);
    list.of[k]->certify_touching_boxes(records(crowd), set.boxes.data(), pairs.data(), pairs.size(),
                                       found.data());
    if (k == 0) first = found;
    EXPECT_EQ(found, first);
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      Certified alone{};
      list.of[k]->certify_touching_boxes(records(crowd), set.boxes.data(), &pairs[i], 1, &alone);
      EXPECT_EQ(alone, found[i]) << i;
      if (found[i] == Certified::unknown) continue;
      EXPECT_EQ(found[i] == Certified::overlapping, crowd.meet[i]) << i;
    }
  }
  return static_cast<int>(std::count(first.begin(), first.end(), Certified::unknown));
}

TEST(NativeKernels, CrossingEdgesAreDecidedRightOnEveryInstructionSet) {
  EXPECT_LT(count_left_by_touching_kernels(make_crossing_edges(20000, 0.0, 0)), 3500);
  // Margins grow with the defect, but not with the scale.
  for (const int scale : {-100, 0, 100})
    EXPECT_LT(count_left_by_touching_kernels(make_crossing_edges(5000, 3e-7, scale)), 2700) << scale;
}

/// Products' underflow is in the error bound, too.
TEST(NativeKernels, CrossingEdgesNextToDenormalsAreNeverWrong) {
  count_left_by_touching_kernels(make_edges_next_to_denormals(20000));
}

TEST(NativeKernels, BoxesFlushAlongTheWorldAreDecidedRightOnEveryInstructionSet) {
  EXPECT_LT(count_left_by_touching_kernels(make_flush_along_the_world(20000, 0)), 1700);
  for (const int scale : {-100, 100})
    EXPECT_LT(count_left_by_touching_kernels(make_flush_along_the_world(5000, scale)), 425) << scale;
}

TEST(NativeKernels, BatchesAndSinglePairsAreRightOnEveryInstructionSet) {
  const Crowd crowd = make_crowd(600);
  const native::SolidSet set = native::make_solid_set(crowd.solids);
  std::vector<PairStatus> batch(crowd.pairs.size());
  const native::KernelList& list = native::available_kernels();
  for (int k = 0; k < list.count; ++k) {
    SCOPED_TRACE(list.of[k]->isa);
    // Sizes that leave lanes empty and blocks part full.
    for (const std::size_t size : {std::size_t{1}, std::size_t{3}, std::size_t{7}, batch.size()}) {
      for (std::size_t i = 0; i < batch.size(); i += size) {
        const std::size_t here = std::min(size, batch.size() - i);
        native::overlap(set, *list.of[k], std::span(crowd.pairs).subspan(i, here), crowd.poses,
                        std::span(batch).subspan(i, here));
      }
      for (std::size_t i = 0; i < batch.size(); ++i)
        ASSERT_EQ(batch[i], crowd.meet[i] ? PairStatus::overlapping : PairStatus::separated) << i;
    }
  }
}

/// Whichever pass a pair gets to: near-touching boxes go through all of them, tapered solids apart through
/// their distances and points in lanes.
TEST(NativeKernels, PosesThatAreNotFiniteFailInBatches) {
  // Boxes, sheared and tapered pairs, some of which are apart.
  Crowd crowd = make_near_touching_boxes(20);
  Random random(44);
  for (int i = 0; i < 20; ++i)
    crowd.add(random.sheared(), random.pose(0.3), random.sheared(), random.pose(0.6));
  for (int i = 0; i < 20; ++i)
    crowd.add(random.tapered(), random.pose(0.3), random.tapered(), random.pose(i % 2 ? 0.6 : 3.0));
  const native::SolidSet set = native::make_solid_set(crowd.solids);
  std::vector<PairStatus> status(crowd.pairs.size()), of_manifold(crowd.pairs.size());
  std::vector<PairGeometry> geometry(crowd.pairs.size());
  const Query manifold = whole_clip();
  std::vector<ContactPoint> points(crowd.pairs.size() * kMaxManifoldPoints);
  const native::KernelList& list = native::available_kernels();
  // Each number of a pose in turn, in some poses.
  for (const double bad : {kNaN, HUGE_VAL, -HUGE_VAL}) {
    for (int number = 0; number < 12; ++number) {
      std::vector<Pose> poses = crowd.poses;
      for (std::size_t i = 0; i < poses.size(); i += 2 + i % 4)
        (number < 9 ? poses[i].R(number % 3, number / 3) : poses[i].p(number - 9)) = bad;
      for (int k = 0; k < list.count; ++k) {
        native::overlap(set, *list.of[k], crowd.pairs, poses, status);
        native::compute_geometry(set, *list.of[k], {crowd.pairs, poses, manifold}, of_manifold, geometry,
                                 points);
        for (std::size_t i = 0; i < status.size(); ++i) {
          const bool finite = is_finite(poses[2 * i]) && is_finite(poses[2 * i + 1]);
          ASSERT_EQ(status[i] == PairStatus::failed, !finite) << i << " " << number;
          ASSERT_EQ(of_manifold[i] == PairStatus::failed, !finite) << i << " " << number;
          ASSERT_EQ(geometry[i].point_count > 0, finite) << i << " " << number;
        }
      }
    }
  }
}

/// A crowd on the move, asked pair by pair and as a batch, with a cache kept from frame to frame, with one of
/// random bits, and with none.
TEST(NativeCache, ChangesNoAnswerWhateverItHolds) {
  Random random(42);
  // A crowd in which everything moves a little.
  Crowd crowd = make_crowd(200);
  const auto native = make_native();
  native->build(crowd.solids);
  const auto workspace = native->make_workspace();
  const std::size_t count = crowd.pairs.size();
  std::vector<PairStatus> plain(count), answer(count);
  std::vector<PairCacheEntry> kept(count), alone(count), garbage(count);
  std::size_t kept_axes = 0;
  for (int frame = 0; frame < 40; ++frame) {
    SCOPED_TRACE(frame);
    for (Pose& X : crowd.poses) X.p += random.vector(0.02);
    // All pairs without a cache, with one, and one by one with one.
    const Query query{QueryKind::overlap};
    native->evaluate({crowd.pairs, crowd.poses, query}, {plain}, *workspace);
    native->evaluate({crowd.pairs, crowd.poses, query, kept}, {answer}, *workspace);
    ASSERT_EQ(answer, plain);
    for (std::size_t i = 0; i < count; ++i) {
      native->evaluate(
          {std::span(crowd.pairs).subspan(i, 1), crowd.poses, query, std::span(alone).subspan(i, 1)},
          {std::span(answer).subspan(i, 1)}, *workspace);
      // Entries that hold anything change nothing.
      for (std::uint32_t& word : garbage[i].data)
        word = static_cast<std::uint32_t>(random.below(1 << 30)) * 7u;
      if (i % 2 == 0) garbage[i].data[3] = kept[i].data[3];  // random bits that pass for an axis
    }
    ASSERT_EQ(answer, plain);
    native->evaluate({crowd.pairs, crowd.poses, query, garbage}, {answer}, *workspace);
    ASSERT_EQ(answer, plain);
  }
  for (const PairCacheEntry& entry : kept) kept_axes += entry.data[3] != 0;
  EXPECT_GT(kept_axes, count / 20);  // it is used
}

}  // namespace
}  // namespace touchstone
