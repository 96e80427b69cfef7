#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/native/manifold/manifold.hpp"
#include "touchstone/contact_core/native/solids/placed_pair.hpp"
#include "touchstone/examples/measures/accuracy/surface_measure.hpp"
#include "touchstone/tests/native/native_fixture.hpp"

// The statements of manifold.hpp on every contact point: on A, on B, straight across, over families that make
// it hard.

namespace touchstone {
namespace {

struct PairOfSolids {
  Hexahedron a, b;
  Pose X_WA, X_WB;
};
using MakePair = std::function<PairOfSolids(Random&)>;

struct Family {
  const char* name;
  MakePair make;
  double bound;  // of the witness error over S
};

Hexahedron thin_box(Random& random, int least, int most) {
  Vector3 size(random.uniform(0.5, 2), random.uniform(0.5, 2), random.uniform(0.5, 2));
  size(random.below(3)) = std::ldexp(random.uniform(1, 2), -least - random.below(most - least + 1));
  if (random.below(2) == 0)
    size(random.below(3)) = std::ldexp(random.uniform(1, 2), -least - random.below(most - least + 1));
  return Hexahedron::from_size(size);
}

/// All corners moved, then pressed flat.
Hexahedron thin_warped(Random& random, int least, int most) {
  for (;;) {
    const double flat = std::ldexp(1.0, -least - random.below(most - least + 1));
    std::vector<Vector3> corners;
    for (int i = 0; i < 8; ++i) {
      const Vector3 p =
          Vector3(i & 4 ? 0.7 : -0.7, i & 2 ? 0.7 : -0.7, i & 1 ? 0.7 : -0.7) + random.vector(0.12);
      corners.push_back({p.x(), p.y(), flat * p.z()});
    }
    try {
      return Hexahedron::from_vertices(corners, WarpPolicy::accept);
    } catch (const InputError&) {
      // Not convex: draw again.
    }
  }
}

/// B's +z face laid on A's, the turn about their common normal free, and B pushed in by up to 1e-3.
PairOfSolids resting(Random& random, const Hexahedron& a, const Hexahedron& b, double reach) {
  Pose X_WA = random.pose(reach), X_WB;
  const double angle = random.uniform(-3, 3);
  Matrix3 turn = rotation_from_quaternion(std::cos(angle / 2), 0, 0, std::sin(angle / 2));
  for (int i = 0; i < 3; ++i) X_WB.R.col(i) = rotate(X_WA.R, turn.col(i));
  const double height = a.half_extents().z() + b.half_extents().z() - random.uniform(0, 1e-3);
  X_WB.p = X_WA.p + rotate(X_WA.R, {random.uniform(-0.3, 0.3), random.uniform(-0.3, 0.3), height});
  return {a, b, X_WA, X_WB};
}

PairOfSolids crossing(Random& random, const Hexahedron& a, const Hexahedron& b, double reach) {
  Pose X_WA = random.pose(reach), X_WB = random.pose(0.0);
  X_WB.p = X_WA.p + random.vector(0.9);
  return {a, b, X_WA, X_WB};
}

/// The largest of p_A's distance to A's surface, p_B's to B's and |p_B - p_A - s n|, over S; NaN where
/// rounding left a solid without volume.
double worst_point(const PairOfSolids& pair, const Answer& answer) {
  WorldVertices va, vb;
  world_vertices(pair.a, pair.X_WA, va), world_vertices(pair.b, pair.X_WB, vb);
  const measures::SurfaceMeasure a(va), b(vb);
  if (a.is_flat() || b.is_flat()) return kNaN;
  double worst = 0.0;
  for (int i = 0; i < answer.geometry.point_count; ++i) {
    const ContactPoint& p = answer.points[i];
    if (p.feature_id == 0x10000) continue;  // the pair's own witness point
    const double across = norm(p.p_B_W - (p.p_A_W + p.separation * answer.geometry.n_AB_W));
    worst = std::max({worst, a.distance(p.p_A_W), b.distance(p.p_B_W), across});
  }
  return worst / scale_of(pair.a, pair.X_WA, pair.b, pair.X_WB);
}

std::vector<Family> families() {
  const double ordinary = 1e-14, thin = 1e-13;
  return {
      {"any", [](Random& r) { return crossing(r, r.any(), r.any(), 0.3); }, ordinary},
      {"boxes", [](Random& r) { return crossing(r, r.box(), r.box(), 5); }, ordinary},
      {"resting boxes", [](Random& r) { return resting(r, r.box(), r.box(), 5); }, ordinary},
      {"thin boxes", [](Random& r) { return crossing(r, thin_box(r, 2, 40), thin_box(r, 2, 40), 1); }, thin},
      {"thin boxes far out",
       [](Random& r) { return crossing(r, thin_box(r, 20, 42), thin_box(r, 20, 42), 500); }, thin},
      {"resting slabs far out",
       [](Random& r) {
         return resting(r, Hexahedron::from_size({1, 2, std::ldexp(1.0, -30 - r.below(12))}),
                        Hexahedron::from_size({2, 1, std::ldexp(1.0, -30 - r.below(12))}), 500);
       },
       thin},
      {"warped", [](Random& r) { return crossing(r, r.warped(), r.warped(), 1); }, ordinary},
      {"thin warped", [](Random& r) { return crossing(r, thin_warped(r, 2, 40), thin_warped(r, 2, 40), 1); },
       thin},
      {"thin warped far out",
       [](Random& r) { return crossing(r, thin_warped(r, 20, 42), thin_warped(r, 20, 42), 500); }, thin},
      {"pyramids", [](Random& r) { return crossing(r, r.pyramid(), r.pyramid(), 1); }, ordinary},
      {"tapered", [](Random& r) { return crossing(r, r.tapered(), r.tapered(), 1); }, ordinary},
  };
}

TEST(NativeManifoldAccuracy, EveryPointLiesOnBothSurfaces) {
  for (const Family& family : families()) {
    Random random(21);
    double worst = 0.0;
    int worst_index = 0, measured = 0, points = 0;
    for (int i = 0; i < 400; ++i) {
      const PairOfSolids pair = family.make(random);
      const Answer answer = ask(pair.a, pair.X_WA, pair.b, pair.X_WB);
      const double error = worst_point(pair, answer);
      if (std::isnan(error)) continue;
      ++measured, points += answer.geometry.point_count;
      if (error > worst) worst = error, worst_index = i;
    }
    std::printf("%-24s worst %.2g S (pair %d) of %d pairs, %.2f points a pair\n", family.name, worst,
                worst_index, measured, points / std::max(1.0, 1.0 * measured));
    EXPECT_LE(worst, family.bound) << family.name << " " << worst_index;
    EXPECT_GT(measured, 150) << family.name;
  }
}

struct Point2 {
  double x, y;
};

double turn(const Point2& o, const Point2& p, const Point2& q) {
  return (p.x - o.x) * (q.y - o.y) - (p.y - o.y) * (q.x - o.x);
}

double area_in_order(const std::vector<Point2>& polygon) {
  double twice = 0.0;
  for (std::size_t i = 1; i + 1 < polygon.size(); ++i) twice += turn(polygon[0], polygon[i], polygon[i + 1]);
  return 0.5 * std::abs(twice);
}

/// The points in A's own x and y.
std::vector<Point2> seen_from(const Pose& X_WA, const Answer& answer) {
  std::vector<Point2> out;
  for (int i = 0; i < answer.geometry.point_count; ++i) {
    const Vector3 p = answer.points[i].p_A_W - X_WA.p;
    out.push_back({dot(X_WA.R.col(0), p), dot(X_WA.R.col(1), p)});
  }
  return out;
}

/// Area common to A's and B's rectangles, A's axis-aligned (Sutherland, Hodgman 1974).
double common_area(const PairOfSolids& pair) {
  const Vector3 &h = pair.a.half_extents(), &g = pair.b.half_extents();
  std::vector<Point2> polygon;
  for (const auto& [i, j] : {std::pair{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}) {
    const Vector3 p =
        pair.X_WB.p - pair.X_WA.p + i * g.x() * pair.X_WB.R.col(0) + j * g.y() * pair.X_WB.R.col(1);
    polygon.push_back({dot(pair.X_WA.R.col(0), p), dot(pair.X_WA.R.col(1), p)});
  }
  const std::array<Point2, 4> window = {{{-h.x(), -h.y()}, {h.x(), -h.y()}, {h.x(), h.y()}, {-h.x(), h.y()}}};
  for (int k = 0; k < 4; ++k) {
    std::vector<Point2> kept;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
      const Point2 &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
      const double s = turn(window[k], window[(k + 1) % 4], p), t = turn(window[k], window[(k + 1) % 4], q);
      if (s >= 0) kept.push_back(p);
      if ((s > 0 && t < 0) || (s < 0 && t > 0))
        kept.push_back({p.x + s / (s - t) * (q.x - p.x), p.y + s / (s - t) * (q.y - p.y)});
    }
    polygon = kept;
  }
  return area_in_order(polygon);
}

TEST(NativeManifoldAccuracy, RestingFacesKeepTheWholeAreaInOrder) {
  Random random(22);
  double worst = 0.0;
  for (int i = 0; i < 2000; ++i) {
    const PairOfSolids pair = resting(random, random.box(), random.box(), 1);
    const Answer answer = ask(pair.a, pair.X_WA, pair.b, pair.X_WB);
    const double area = common_area(pair);
    if (area < 1e-3 || answer.geometry.separation < -2e-3) continue;
    if (dot(answer.geometry.n_AB_W, pair.X_WA.R.col(2)) < 0.999) continue;
    const double size = pair.a.size() + pair.b.size();
    worst = std::max(worst, std::abs(area_in_order(seen_from(pair.X_WA, answer)) - area) / (size * size));
  }
  EXPECT_LE(worst, 1e-15);
}

// Rounding puts the edges on either side of each other, and the crossings anywhere on them.
TEST(NativeManifoldAccuracy, FlushEdgesInAnyPoseGiveFourPoints) {
  Random random(23);
  for (int i = 0; i < 1000; ++i) {
    const Hexahedron below = random.box();
    const Vector3 h = below.half_extents();
    const Hexahedron above = Hexahedron::from_size({2 * h.x(), (i % 2 ? 1.0 : 2.0) * h.y(), 1});
    const Pose X_WA = random.pose(1);
    Pose X_WB = X_WA;
    X_WB.p += rotate(X_WA.R, Vector3(0, i % 2 ? 0.5 * h.y() : 0, h.z() + 0.5 - 1e-6 * random.below(2)));
    const Answer answer = ask(below, X_WA, above, X_WB);
    ASSERT_EQ(answer.geometry.point_count, 4) << i;
    ASSERT_NEAR(area_in_order(seen_from(X_WA, answer)), (i % 2 ? 2 : 4) * h.x() * h.y(), 2e-14) << i;
  }
}

// Nothing of a tiny motion shows but itself: the area moves by as much as the edges do, and the corners stay
// the same unless one lies within the motion of an edge.
TEST(NativeManifoldAccuracy, TinyMotionKeepsAreaAndFeatureIds) {
  Random random(24);
  int changed = 0, pairs = 0;
  for (int i = 0; i < 2000; ++i) {
    PairOfSolids pair = resting(random, random.box(), random.box(), 1);
    const double S = scale_of(pair.a, pair.X_WA, pair.b, pair.X_WB);
    const int most = i % 2 ? 8 : 4;
    Query query = whole_clip();
    query.max_points = most;
    const Answer before = ask(pair.a, pair.X_WA, pair.b, pair.X_WB, query);
    if (dot(before.geometry.n_AB_W, pair.X_WA.R.col(2)) < 0.999) continue;
    pair.X_WB.p += 1e-9 * S * random.vector(0.5);
    const Answer after = ask(pair.a, pair.X_WA, pair.b, pair.X_WB, query);
    const double area = area_in_order(seen_from(pair.X_WA, before));
    ++pairs;
    ASSERT_NEAR(area_in_order(seen_from(pair.X_WA, after)), area, 1e-8 * S * S) << i;
    std::set<std::uint32_t> ids_before, ids_after;
    for (int k = 0; k < before.geometry.point_count; ++k) ids_before.insert(before.points[k].feature_id);
    for (int k = 0; k < after.geometry.point_count; ++k) ids_after.insert(after.points[k].feature_id);
    ASSERT_EQ(ids_before.size(), static_cast<std::size_t>(before.geometry.point_count)) << "an id twice";
    changed += ids_before != ids_after;
  }
  EXPECT_GT(pairs, 1000);
  EXPECT_LE(changed, pairs / 500);
}

std::set<std::uint32_t> ids_of(const Answer& answer) {
  std::set<std::uint32_t> ids;
  for (int k = 0; k < answer.geometry.point_count; ++k) ids.insert(answer.points[k].feature_id);
  return ids;
}

/// `above` on `below`, flush where they are as wide, then turned and moved by no more than 1e-9.
PairOfSolids nearly_flush(Random& random, const Hexahedron& below, double height, const Hexahedron& above,
                          const Pose& X_WA, double motion) {
  PairOfSolids pair{below, above, X_WA, X_WA};
  const double angle = motion * random.uniform(-1, 1);
  const Matrix3 turn = rotation_from_quaternion(std::cos(angle / 2), 0, 0, std::sin(angle / 2));
  for (int i = 0; i < 3; ++i) pair.X_WB.R.col(i) = rotate(X_WA.R, turn.col(i));
  const Vector3 offset = motion * random.vector(1);
  pair.X_WB.p += rotate(X_WA.R, Vector3(offset.x(), offset.y(), height + offset.z()));
  return pair;
}

// Squares as wide as each other, turned by 1e-9, have a clip of eight corners, four of which come and go with
// the turn's sign; A's and B's edges each take turns to be the inner ones.
TEST(NativeManifoldAccuracy, FlushFacesKeepTheirFourPointsAndIds) {
  Random random(26);
  // Solids that stand on a cube, and the area that they share with its face.
  const Hexahedron cube = Hexahedron::from_size({1, 1, 1});
  std::vector<Vector3> lower, leaning;
  for (int i = 0; i < 8; ++i) {
    const double x = i & 4 ? 0.5 : -0.5, y = i & 2 ? 0.5 : -0.5, z = i & 1 ? 0.5 : -0.5;
    lower.push_back({i & 1 ? 0.5 * x : x, i & 1 ? 0.5 * y : y, z});
    leaning.push_back({x + 0.3 * (z + 0.5), y, z});
  }
  struct Above {
    const char* name;
    Hexahedron solid;
    double area;
  };
  const std::vector<Above> above = {{"box", cube, 1},
                                    {"narrower box", Hexahedron::from_size({0.5, 1, 1}), 0.5},
                                    {"wider box", Hexahedron::from_size({1, 3, 1}), 1},
                                    {"parallelepiped", Hexahedron::from_vertices(leaning), 1},
                                    {"frustum", Hexahedron::from_vertices(lower), 1}};
  // At rest on it the manifold has four ids.
  for (const auto& [name, solid, area] : above) {
    for (int place = 0; place < 20; ++place) {
      const Pose X_WA = place == 0 ? at(0, 0, 0) : random.pose(1);
      const double height = 1.0 - 1e-4;
      const PairOfSolids still = nearly_flush(random, cube, height, solid, X_WA, 0.0);
      const std::set<std::uint32_t> ids = ids_of(ask(still.a, still.X_WA, still.b, still.X_WB));
      ASSERT_EQ(ids.size(), 4u) << name << " " << place;
      // Turned by a rounding or a billionth it has the same ones, over the same area.
      for (int i = 0; i < 20; ++i) {
        const PairOfSolids pair = nearly_flush(random, cube, height, solid, X_WA, i % 2 ? 1e-9 : 1e-15);
        const Answer answer = ask(pair.a, pair.X_WA, pair.b, pair.X_WB);
        ASSERT_EQ(answer.geometry.point_count, 4) << name << " " << place << " " << i;
        ASSERT_EQ(ids_of(answer), ids) << name << " " << place << " " << i;
        ASSERT_NEAR(area_in_order(seen_from(pair.X_WA, answer)), area, 1e-8);
        ASSERT_LE(worst_point(pair, answer), 1e-14);
      }
    }
  }
}

/// The pair's manifold by make_manifold(), given the answer's own separation and normal. @pre in the check's
/// order.
native::Manifold by_scalar_code(const PairOfSolids& pair, const PairGeometry& geometry, Vector3& origin_W) {
  const native::SolidSet set = native::make_solid_set(std::array{pair.a, pair.b});
  native::PlacedPair placed;
  native::place(set, {0, 1}, pair.X_WA, pair.X_WB, true, placed);
  const native::SignedDistance distance{geometry.separation, geometry.n_AB_W,
                                        placed.from_world(geometry.p_A_W)};
  native::Manifold out;
  native::make_manifold(placed.pair, distance, INFINITY, kMaxManifoldPoints, false, out);
  origin_W = placed.origin_W;
  return out;
}

// The lanes' kernel clips parallelograms by their centres and half edges; scalar code clips any polygons.
TEST(NativeManifoldAccuracy, KernelFindsThePointsAndIdsOfTheScalarCode) {
  Random random(27);
  int pairs = 0, points = 0;
  for (int i = 0; i < 3000; ++i) {
    // Boxes and sheared blocks that rest on or cross each other, in the order that scalar code takes.
    const bool boxes = i % 2 == 0;
    const Hexahedron a = boxes ? random.box() : random.sheared(), b = boxes ? random.box() : random.sheared();
    PairOfSolids pair = i % 3 == 0 && boxes ? resting(random, a, b, 1) : crossing(random, a, b, 1);
    if (pair.X_WA.p.x() >= pair.X_WB.p.x()) {
      std::swap(pair.a, pair.b);
      std::swap(pair.X_WA, pair.X_WB);
    }
    // Each of its points is found by its id, in the same place.
    const Answer answer = ask(pair.a, pair.X_WA, pair.b, pair.X_WB);
    Vector3 origin_W;
    const native::Manifold expected = by_scalar_code(pair, answer.geometry, origin_W);
    ASSERT_EQ(answer.geometry.point_count, expected.count) << i;
    for (int k = 0; k < expected.count; ++k) {
      const auto same = [&](const ContactPoint& p) { return p.feature_id == expected.points[k].feature_id; };
      const auto found = std::find_if(answer.points.begin(), answer.points.end(), same);
      ASSERT_NE(found, answer.points.end()) << i << " " << std::hex << expected.points[k].feature_id;
      EXPECT_NEAR(norm(found->p_A_W - (origin_W + expected.points[k].p_A_W)), 0.0, 1e-12) << i;
      EXPECT_NEAR(found->separation, expected.points[k].separation, 1e-14) << i;
    }
    ++pairs, points += expected.count;
  }
  EXPECT_GT(points, 4 * pairs);
}

/// General blocks that cross, and such on each other, flush to up to 1e-7 in any frame.
AllPairs crossing_and_flush_blocks(Random& random, int count) {
  AllPairs scene;
  const auto add = [&scene](const PairOfSolids& pair) {
    const auto first = static_cast<SolidIndex>(scene.solids.size());
    scene.solids.insert(scene.solids.end(), {pair.a, pair.b});
    scene.poses.insert(scene.poses.end(), {pair.X_WA, pair.X_WB});
    scene.pairs.push_back({first, first + 1});
  };
  constexpr std::array<double, 5> kMotions = {0.0, 1e-15, 1e-9, 1e-8, 1e-7};
  for (int i = 0; i < count; ++i) {
    const Hexahedron block = random.tapered();
    add(crossing(random, block, random.tapered(), 1));
    const double height = block.vertices()[7].z() - block.vertices()[0].z();
    add(nearly_flush(random, block, height, block, random.pose(1), kMotions[i % 5]));
    // Base on base, so that their edges coincide.
    PairOfSolids bases = nearly_flush(random, block, -height, block, random.pose(1), kMotions[i % 5]);
    for (int k : {1, 2}) bases.X_WB.R.col(k) = -bases.X_WB.R.col(k);
    add(bases);
  }
  return scene;
}

// Lanes clip the faces of general hexahedra, and leave corners' order and names to scalar code.
TEST(NativeManifoldAccuracy, GeneralPairsOfABatchHaveThePointsOfSinglePairs) {
  Random random(28);
  const AllPairs scene = crossing_and_flush_blocks(random, 1000);
  const auto native = make_native();
  native->build(scene.solids);
  int points = 0;
  for (Query query : {whole_clip(), Query{.kind = QueryKind::manifold},
                      Query{.kind = QueryKind::manifold, .max_separation = 0.1, .max_points = 4}}) {
    const Answers together = ask(*native, scene.pairs, scene.poses, query);
    for (std::size_t i = 0; i < scene.pairs.size(); ++i) {
      const Answer alone = ask(*native, scene.poses, query, scene.pairs[i]);
      ASSERT_EQ(together.status[i], alone.status) << i;
      ASSERT_EQ(together.geometry[i].point_count, alone.geometry.point_count) << i;
      ASSERT_TRUE(same_bits(together.geometry[i], alone.geometry)) << i;
      for (std::size_t k = 0; k < alone.points.size(); ++k, ++points) {
        const ContactPoint& point = together.points[static_cast<std::size_t>(query.max_points) * i + k];
        ASSERT_TRUE(same_bits(point.p_A_W, alone.points[k].p_A_W)) << i;
        ASSERT_TRUE(same_bits(point.p_B_W, alone.points[k].p_B_W)) << i;
        ASSERT_TRUE(same_bits(point.separation, alone.points[k].separation)) << i;
        ASSERT_EQ(point.feature_id, alone.points[k].feature_id) << i;
      }
    }
  }
  EXPECT_GT(points, 10000);
}

/// Clips of the pairs that a batch clips in lanes.
std::vector<native::HullClipTask> hull_clip_tasks(const native::SolidSet& set, const AllPairs& scene,
                                                  const Answers& answers) {
  std::vector<native::HullClipTask> out;
  for (std::size_t i = 0; i < scene.pairs.size(); ++i) {
    const SolidPair& given = scene.pairs[i];
    const bool swapped = !native::comes_first(set, given, scene.poses[given.a], scene.poses[given.b]);
    const SolidPair pair = swapped ? SolidPair{given.b, given.a} : given;
    const native::PlainHull *const a = set.solids[pair.a].plain, *const b = set.solids[pair.b].plain;
    if (a == nullptr || b == nullptr) continue;
    const Vector3 n = (swapped ? -1.0 : 1.0) * answers.geometry[i].n_AB_W;
    out.push_back({{n.x(), n.y(), n.z(), answers.geometry[i].separation}, {pair.a, pair.b}, a, b});
  }
  return out;
}

/// What finish_hull_clip() reads.
void expect_same_clip(const native::HullClipRecord& p, const native::HullClipRecord& q) {
  using Bits = native::HullClipBits;
  ASSERT_EQ(p.bits >> Bits::kFits & 1u, q.bits >> Bits::kFits & 1u);
  if ((p.bits >> Bits::kFits & 1u) == 0) return;
  ASSERT_EQ(p.bits, q.bits);
  ASSERT_EQ(p.flush, q.flush);
  ASSERT_TRUE(same_bits(p.tie, q.tie));
  for (int k = 0; k < 3; ++k) ASSERT_TRUE(same_bits(p.origin[k], q.origin[k]));
  for (int k = 0; k < 8; ++k) {
    if ((p.bits >> (Bits::kLeft + k) & 1u) == 0) continue;
    ASSERT_TRUE(same_bits(p.p_x[k], q.p_x[k]) && same_bits(p.p_y[k], q.p_y[k]));
    ASSERT_TRUE(same_bits(p.p_z[k], q.p_z[k]) && same_bits(p.separation[k], q.separation[k]));
  }
}

TEST(NativeManifoldAccuracy, EveryInstructionSetClipsGeneralPairsToTheSameBits) {
  Random random(29);
  const AllPairs scene = crossing_and_flush_blocks(random, 300);
  const native::SolidSet set = native::make_solid_set(scene.solids);
  const auto native = make_native();
  native->build(scene.solids);
  const std::vector<native::HullClipTask> tasks =
      hull_clip_tasks(set, scene, ask(*native, scene.pairs, scene.poses, whole_clip()));
  ASSERT_GT(tasks.size(), 800u);
  const auto clipped = [&](const native::Kernels& kernels, std::span<const native::HullClipTask> some) {
    std::vector<native::HullClipRecord> out(some.size());
    kernels.clip_hulls(native::records_of(scene.poses), native::vertex_records(set), some.data(), some.size(),
                       0.5, out.data());
    return out;
  };
  // All in one call, and one a call.
  const auto expected = clipped(*native::available_kernels().of[0], tasks);
  for (int k = 0; k < native::available_kernels().count; ++k) {
    const native::Kernels& kernels = *native::available_kernels().of[k];
    const auto together = clipped(kernels, tasks);
    for (std::size_t i = 0; i < tasks.size(); ++i) {
      SCOPED_TRACE(kernels.isa + (" " + std::to_string(i)));
      expect_same_clip(expected[i], together[i]);
      expect_same_clip(expected[i], clipped(kernels, {&tasks[i], 1})[0]);
      if (HasFatalFailure()) return;
    }
  }
  // Most fit, and many have flush edges.
  const auto share = [&](auto counts) {
    return static_cast<double>(std::count_if(expected.begin(), expected.end(), counts)) /
           static_cast<double>(expected.size());
  };
  EXPECT_GT(share([](const auto& clip) { return (clip.bits >> native::HullClipBits::kFits & 1u) != 0; }),
            0.5);
  EXPECT_GT(share([](const auto& clip) { return clip.flush != 0; }), 0.2);
}

/// The same solids with corners as a file of floats has them, in frames in which that bends their faces.
void put_into_floats(Random& random, AllPairs& scene) {
  for (std::size_t i = 0; i < scene.solids.size(); ++i) {
    const Matrix3 R = random.pose(1).R;
    auto vertices = scene.solids[i].vertices();
    for (Vector3& v : vertices) v = Vector3(R * v).cast<float>().cast<double>();
    scene.solids[i] = Hexahedron::from_vertices(vertices);
    scene.poses[i].R = Matrix3(scene.poses[i].R * R.transpose());
  }
}

/// A pair as the check takes it, and its answer.
struct Prepared {
  native::PlacedPair placed;
  native::SignedDistance distance;
};
void prepare(const native::SolidSet& set, const AllPairs& scene, const Answers& answers, std::size_t i,
             Prepared& out) {
  SolidPair pair = scene.pairs[i];
  const PairGeometry& geometry = answers.geometry[i];
  const bool swapped = !native::comes_first(set, pair, scene.poses[pair.a], scene.poses[pair.b]);
  if (swapped) std::swap(pair.a, pair.b);
  native::place(set, pair, scene.poses[pair.a], scene.poses[pair.b], true, out.placed);
  out.distance = {geometry.separation, (swapped ? -1.0 : 1.0) * geometry.n_AB_W,
                  out.placed.from_world(swapped ? geometry.p_B_W : geometry.p_A_W)};
}

/// By the kernel of one pair; false where it does not fit.
bool clip_in_lanes(const native::Kernels& kernels, const Prepared& pair, double limit, bool swapped,
                   native::Manifold& out) {
  const native::PosedPair& posed = pair.placed.pair;
  const Vector3& n = pair.distance.n;
  const double n_separation[4] = {n.x(), n.y(), n.z(), pair.distance.separation};
  native::HullClipRecord clipped;
  kernels.clip_hull_pair({&posed.a->quads, posed.hulls.a.x.data(), posed.R_WA.data()},
                         {&posed.b->quads, posed.hulls.b.x.data(), posed.R_WB.data()}, n_separation,
                         posed.hulls.extent, limit, &clipped);
  if ((clipped.bits >> native::HullClipBits::kFits & 1u) == 0) return false;
  native::finish_hull_clip(clipped, pair.distance, limit, kMaxManifoldPoints, swapped, out);
  return true;
}

void expect_same_points(const native::Manifold& p, const native::Manifold& q) {
  ASSERT_EQ(p.count, q.count);
  for (std::size_t k = 0; k < static_cast<std::size_t>(p.count); ++k) {
    ASSERT_EQ(p.points[k].feature_id, q.points[k].feature_id) << k;
    ASSERT_TRUE(same_bits(p.points[k].separation, q.points[k].separation)) << k;
    ASSERT_TRUE(same_bits(p.points[k].p_A_W, q.points[k].p_A_W)) << k;
    ASSERT_TRUE(same_bits(p.points[k].p_B_W, q.points[k].p_B_W)) << k;
  }
}

TEST(NativeManifoldAccuracy, TheKernelOfOnePairHasTheBitsOfScalarCodeForPlaneAndBentFaces) {
  Random random(31);
  for (const bool bent : {false, true}) {
    AllPairs scene = crossing_and_flush_blocks(random, 200);
    if (bent) put_into_floats(random, scene);
    const native::SolidSet set = native::make_solid_set(scene.solids);
    const auto native = make_native();
    native->build(scene.solids);
    const Answers answers = ask(*native, scene.pairs, scene.poses, whole_clip());
    int asked = 0, fitting = 0;
    for (std::size_t i = 0; i < scene.pairs.size(); ++i) {
      Prepared pair;
      prepare(set, scene, answers, i, pair);
      ASSERT_EQ(pair.placed.pair.a->quads.bent != 0, bent);
      // All points, and those near, of either order.
      const double limit = i % 2 == 0 ? INFINITY : 0.05;
      native::Manifold expected, got;
      native::make_manifold(pair.placed.pair, pair.distance, limit, kMaxManifoldPoints, i % 3 == 0, expected);
      for (int k = 0; k < native::available_kernels().count; ++k, ++asked) {
        const native::Kernels& kernels = *native::available_kernels().of[k];
        if (!clip_in_lanes(kernels, pair, limit, i % 3 == 0, got)) continue;
        SCOPED_TRACE(kernels.isa + (" " + std::to_string(i)));
        expect_same_points(expected, got);
        if (HasFatalFailure()) return;
        ++fitting;
      }
    }
    EXPECT_GT(2 * fitting, asked) << bent;
  }
}

/// The id of the same corner, for whom A and B are exchanged: see edge_label().
std::uint32_t exchanged(std::uint32_t id) {
  if (id == 0x10000) return id;
  const auto renamed = [](std::uint32_t edge) {
    return edge < 8 ? 8 + (6 - edge) % 4 : (6 - (edge - 8)) % 4;
  };
  const std::uint32_t names = id - 1, first = names % 16, second = names / 16 % 16, face_a = names / 256 % 16,
                      face_b = names / 4096 % 16;
  return 1 + renamed(second) + 16 * renamed(first) + 256 * face_b + 4096 * face_a;
}

TEST(NativeManifoldAccuracy, ExchangingTheSolidsExchangesThePoints) {
  Random random(25);
  for (int i = 0; i < 500; ++i) {
    const bool boxes = i % 2 == 0;
    const Hexahedron a = boxes ? random.box() : random.any(), b = boxes ? random.box() : random.any();
    const Pose X_WA = random.pose(0.3), X_WB = random.pose(0.9);
    Query query = whole_clip();
    query.max_points = 1 + i % 8;
    const Answer ab = ask(a, X_WA, b, X_WB, query), ba = ask(b, X_WB, a, X_WA, query);
    ASSERT_EQ(ab.geometry.point_count, ba.geometry.point_count);
    for (int k = 0; k < ab.geometry.point_count; ++k) {
      ASSERT_EQ(ab.points[k].p_A_W, ba.points[k].p_B_W);
      ASSERT_EQ(ab.points[k].p_B_W, ba.points[k].p_A_W);
      ASSERT_EQ(ab.points[k].separation, ba.points[k].separation);
      if (boxes) {
        ASSERT_EQ(ab.points[k].feature_id, exchanged(ba.points[k].feature_id));
      }
    }
  }
}

// A blade of about 4 degrees standing on its edge: both its sides are steep, its edge is what touches.
TEST(NativeManifoldAccuracy, BladeOnItsEdgeTouchesAlongTheEdge) {
  std::vector<Vector3> corners;
  for (int i = 0; i < 8; ++i)
    corners.push_back({i & 4 ? 0.5 : -0.5, (i & 2 ? 1 : -1) * (i & 1 ? 0.035 : 0.0), i & 1 ? 1.0 : 0.0});
  const Hexahedron blade = Hexahedron::from_vertices(corners);
  const Answer answer = ask(Hexahedron::from_size({2, 2, 1}), at(0, 0, 0), blade, at(0, 0, 0.5 - 0x1p-10));
  ASSERT_EQ(answer.geometry.separation, -0x1p-10);
  ASSERT_EQ(answer.geometry.point_count, 2);
  EXPECT_NEAR(norm(answer.points[0].p_B_W - answer.points[1].p_B_W), 1.0, 1e-15);
  for (int i = 0; i < 2; ++i) EXPECT_EQ(answer.points[i].separation, -0x1p-10);
}

}  // namespace
}  // namespace touchstone
