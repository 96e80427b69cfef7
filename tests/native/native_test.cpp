#include "touchstone/contact_core/native/native.hpp"

#include <gmock/gmock.h>

#include <bit>
#include <cmath>

#include "touchstone/tests/native/distance/all_features_reference.hpp"
#include "touchstone/tests/native/native_fixture.hpp"

namespace touchstone {
namespace {

const Hexahedron kCube = Hexahedron::from_size({1, 1, 1});

/// Everything an answer promises, against the reference. Bounds are those of the header: a few u (2^-53) of
/// S; 32 u is the declared resolution, witness points add the rounding of world coordinates.
void expect_right(const Hexahedron& a, const Pose& X_WA, const Hexahedron& b, const Pose& X_WB) {
  // The distance in long double.
  WorldVertices va, vb;
  world_vertices(a, X_WA, va);
  world_vertices(b, X_WB, vb);
  const double S = scale_of(a, X_WA, b, X_WB);
  const long double exact = reference_signed_distance(va, vb);
  // Class, separation and normal.
  const Answer answer = ask(a, X_WA, b, X_WB);
  const PairGeometry& g = answer.geometry;
  EXPECT_EQ(answer.status, ask(a, X_WA, b, X_WB, QueryKind::overlap).status);
  if (std::abs(exact) > 1e-16L * S) {
    EXPECT_EQ(answer.status, exact > 0 ? PairStatus::separated : PairStatus::overlapping);
  }
  EXPECT_EQ(answer.status == PairStatus::separated, g.separation > 0.0);
  EXPECT_NEAR(g.separation, static_cast<double>(exact), 4e-15 * S);
  EXPECT_NEAR(norm(g.n_AB_W), 1.0, 1e-15);
  EXPECT_NEAR(static_cast<double>(reference_separation_along(va, vb, g.n_AB_W)), static_cast<double>(exact),
              1e-14 * S);
  // Witness points.
  EXPECT_LE(norm(g.p_B_W - (g.p_A_W + g.separation * g.n_AB_W)), 1e-15 * S);
  EXPECT_NEAR(static_cast<double>(reference_height(va, g.p_A_W)), 0.0, 1e-13 * S);
  EXPECT_NEAR(static_cast<double>(reference_height(vb, g.p_B_W)), 0.0, 1e-13 * S);

  // Contact points.
  ASSERT_GE(g.point_count, 1);
  ASSERT_LE(g.point_count, kMaxManifoldPoints);
  double deepest = INFINITY;
  for (int i = 0; i < g.point_count; ++i) {
    const ContactPoint& point = answer.points[i];
    deepest = std::min(deepest, point.separation);
    EXPECT_LE(norm(point.p_B_W - (point.p_A_W + point.separation * g.n_AB_W)), 1e-13 * S);
  }
  EXPECT_EQ(deepest, g.separation);
}

TEST(Native, IsRegisteredAndDeclaresWhatItCanDo) {
  BackendRegistry registry;
  register_core(registry);
  const auto native = registry.make_narrowphase("native");
  EXPECT_EQ(native->name(), "native");
  const Capabilities& c = native->capabilities();
  EXPECT_TRUE(c.distance && c.penetration && c.manifold && c.overlap_complete && c.deterministic &&
              c.thread_safe);
  EXPECT_LE(c.resolution.relative, 4e-15);
  EXPECT_EQ(c.resolution.absolute, 0.0);
}

TEST(Native, NormalPointsFromAToBApartAndOverlapping) {
  for (const double x : {3.0, 1.0, 0.75}) {
    const Answer answer = ask(kCube, at(0, 0, 0), kCube, at(x, 0, 0));
    EXPECT_EQ(answer.status, x > 1.0 ? PairStatus::separated : PairStatus::overlapping);
    EXPECT_EQ(answer.geometry.separation, x - 1.0);
    EXPECT_EQ(answer.geometry.n_AB_W, Vector3(1, 0, 0));
    EXPECT_EQ(answer.geometry.p_A_W.x(), 0.5);
    EXPECT_EQ(answer.geometry.p_B_W.x(), x - 0.5);
  }
}

TEST(Native, IsRightOnRandomPairsOfAllKinds) {
  Random random(1);
  for (int i = 0; i < 1500; ++i) {
    SCOPED_TRACE(i);
    const Hexahedron a = random.any(), b = random.any();
    const Pose X_WA = random.pose(0.3), X_WB = random.pose(1.2);
    expect_right(a, X_WA, b, X_WB);
    if (HasFailure()) return;
  }
}

/// Moves B along the normal so that the pair comes to rest `gap` apart (or as deep).
Pose moved_to(const Hexahedron& a, const Pose& X_WA, const Hexahedron& b, const Pose& X_WB, double gap) {
  const PairGeometry g = ask(a, X_WA, b, X_WB, QueryKind::distance).geometry;
  Pose out = X_WB;
  out.p += (gap - g.separation) * g.n_AB_W;
  return out;
}

TEST(Native, IsRightWhenNearlyTouching) {
  Random random(2);
  for (int i = 0; i < 600; ++i) {
    SCOPED_TRACE(i);
    const Hexahedron a = random.any(), b = random.any();
    const Pose X_WA = random.pose(0.3);
    const double fraction = random.uniform(-1, 1), gap = std::ldexp(fraction, -random.below(54));
    expect_right(a, X_WA, b, moved_to(a, X_WA, b, random.pose(1.2), gap));
    if (HasFailure()) return;
  }
}

TEST(Native, IsRightForNearlyAlignedSolids) {
  Random random(3);
  for (int i = 0; i < 600; ++i) {
    SCOPED_TRACE(i);
    const bool boxes = random.below(2) == 0;
    const Hexahedron a = boxes ? random.box() : random.sheared(), b = boxes ? random.box() : a;
    const Pose X_WA = random.pose(0.3);
    const double tilt = random.below(4) == 0 ? 0.0 : std::ldexp(1.0, -4 - random.below(50));
    Pose X_WB;
    Pose turn;
    const double x = random.uniform(-1, 1), y = random.uniform(-1, 1);
    turn.R = rotation_from_quaternion(1.0, tilt * x, tilt * y, tilt);
    X_WB.R = compose(X_WA, turn).R;
    X_WB.p = random.vector(1.2);
    expect_right(a, X_WA, b, X_WB);
    if (HasFailure()) return;
  }
}

TEST(Native, IsRightFarFromTheOrigin) {
  Random random(4);
  for (const double far : {1e6, 1e9, 1e12, 1e15}) {
    for (int i = 0; i < 50; ++i) {
      SCOPED_TRACE(far);
      const Hexahedron a = random.box(), b = random.any();
      Pose X_WA = random.pose(0.3), X_WB = random.pose(1.0);
      X_WA.p += Vector3(far, -far, 0.5 * far), X_WB.p += Vector3(far, -far, 0.5 * far);
      WorldVertices va, vb;
      world_vertices(a, X_WA, va), world_vertices(b, X_WB, vb);
      const long double exact = reference_signed_distance(va, vb);
      const Answer answer = ask(a, X_WA, b, X_WB);
      EXPECT_EQ(answer.status, ask(a, X_WA, b, X_WB, QueryKind::overlap).status);
      EXPECT_NEAR(answer.geometry.separation, static_cast<double>(exact), 4e-15 * far);
      if (std::abs(exact) > 1e-6L) {
        EXPECT_EQ(answer.status == PairStatus::separated, exact > 0);
      }
    }
  }
}

TEST(Native, FindsContainmentAndItsDepth) {
  const Hexahedron small = Hexahedron::from_size({0.5, 0.5, 0.5});
  const Answer answer = ask(Hexahedron::from_size({4, 6, 8}), at(0, 0, 0), small, at(0.25, 0, 0));
  EXPECT_EQ(answer.status, PairStatus::overlapping);
  EXPECT_EQ(answer.geometry.separation, -2.0);
  EXPECT_EQ(answer.geometry.n_AB_W, Vector3(1, 0, 0));
}

TEST(Native, FindsTheDepthOfIdenticalSolids) {
  const Hexahedron box = Hexahedron::from_size({1, 2, 3});
  const Answer answer = ask(box, at(1, 1, 1), box, at(1, 1, 1));
  EXPECT_EQ(answer.status, PairStatus::overlapping);
  EXPECT_EQ(answer.geometry.separation, -1.0);
  EXPECT_EQ(std::abs(answer.geometry.n_AB_W.x()), 1.0);
}

TEST(Native, TouchingByFaceEdgeAndVertexIsOverlapWithZeroSeparation) {
  for (const Vector3& p : {Vector3(1, 0, 0), Vector3(1, 1, 0), Vector3(1, 1, 1), Vector3(-1, 0.5, -1)}) {
    const Answer answer = ask(kCube, at(0, 0, 0), kCube, at(p.x(), p.y(), p.z()));
    EXPECT_EQ(answer.status, PairStatus::overlapping);
    EXPECT_EQ(answer.geometry.separation, 0.0);
  }
}

TEST(Native, TellsApartWhatLiesOneUlpApart) {
  for (const Vector3& p : {Vector3(1, 0, 0), Vector3(1, 1, 0), Vector3(1, 1, 1)}) {
    const double off = std::nextafter(1.0, 2.0);
    const Answer answer = ask(kCube, at(0, 0, 0), kCube, at(p.x() * off, p.y() * off, p.z() * off));
    EXPECT_EQ(answer.status, PairStatus::separated);
    EXPECT_GT(answer.geometry.separation, 0.0);
  }
}

void expect_bits(double x, double y) {
  EXPECT_EQ(std::bit_cast<std::uint64_t>(x), std::bit_cast<std::uint64_t>(y));
}

TEST(Native, ExchangingTheSolidsNegatesTheNormalAndKeepsEveryBit) {
  Random random(5);
  for (int i = 0; i < 1000; ++i) {
    const Hexahedron a = random.any(), b = random.any();
    const Pose X_WA = random.pose(0.3), X_WB = random.pose(1.0);
    const Answer ab = ask(a, X_WA, b, X_WB), ba = ask(b, X_WB, a, X_WA);
    ASSERT_EQ(ab.status, ba.status);
    expect_bits(ab.geometry.separation, ba.geometry.separation);
    ASSERT_EQ(ab.geometry.n_AB_W, Vector3(-ba.geometry.n_AB_W));
    ASSERT_EQ(ab.geometry.p_A_W, ba.geometry.p_B_W);
    ASSERT_EQ(ab.geometry.p_B_W, ba.geometry.p_A_W);
    ASSERT_EQ(ab.geometry.point_count, ba.geometry.point_count);
    for (int k = 0; k < ab.geometry.point_count; ++k) {
      expect_bits(ab.points[k].separation, ba.points[k].separation);
      ASSERT_EQ(ab.points[k].p_A_W, ba.points[k].p_B_W);
    }
  }
}

TEST(Native, ScalingByAPowerOfTwoScalesEveryBit) {
  Random random(6);
  for (int i = 0; i < 300; ++i) {
    const Vector3 size_a = random.vector(1).cwiseAbs() + Vector3::Constant(0.1);
    const Vector3 size_b = random.vector(1).cwiseAbs() + Vector3::Constant(0.1);
    const Pose X_WA = random.pose(0.3), X_WB = random.pose(1.0);
    const Answer plain = ask(Hexahedron::from_size(size_a), X_WA, Hexahedron::from_size(size_b), X_WB);
    for (const int exponent : {-900, -400, -119, -20, 30, 121, 400, 1000}) {
      const double k = std::ldexp(1.0, exponent);
      Pose X_WAk = X_WA, X_WBk = X_WB;
      X_WAk.p *= k, X_WBk.p *= k;
      const Answer scaled =
          ask(Hexahedron::from_size(size_a * k), X_WAk, Hexahedron::from_size(size_b * k), X_WBk);
      ASSERT_EQ(scaled.status, plain.status);
      expect_bits(scaled.geometry.separation, plain.geometry.separation * k);
      ASSERT_EQ(scaled.geometry.n_AB_W, plain.geometry.n_AB_W);
      ASSERT_EQ(scaled.geometry.p_A_W, Vector3(plain.geometry.p_A_W * k));
      ASSERT_EQ(scaled.geometry.point_count, plain.geometry.point_count);
    }
  }
}

TEST(Native, MovingThePairRigidlyMovesTheAnswer) {
  Random random(7);
  for (int i = 0; i < 500; ++i) {
    const Hexahedron a = random.any(), b = random.any();
    const Pose X_WA = random.pose(0.3), X_WB = random.pose(1.0), X_VW = random.pose(3.0);
    const Answer before = ask(a, X_WA, b, X_WB), after = ask(a, compose(X_VW, X_WA), b, compose(X_VW, X_WB));
    // Poses, vertices and answer round twice over: 1e-14 of S (about 6 m here).
    if (std::abs(before.geometry.separation) > 1e-13) {
      ASSERT_EQ(before.status, after.status);
    }
    ASSERT_NEAR(before.geometry.separation, after.geometry.separation, 6e-14);
  }
}

TEST(Native, BeyondMaxSeparationTheSeparationIsInfinite) {
  Query query = whole_clip();
  query.max_separation = 0.5;
  const Answer beyond = ask(kCube, at(0, 0, 0), kCube, at(1.75, 0.1, 0), query);
  EXPECT_EQ(beyond.status, PairStatus::separated);
  EXPECT_EQ(beyond.geometry.separation, INFINITY);
  EXPECT_TRUE(std::isnan(beyond.geometry.n_AB_W.x()) && std::isnan(beyond.geometry.p_A_W.y()) &&
              std::isnan(beyond.geometry.p_B_W.z()));
  EXPECT_EQ(beyond.geometry.point_count, 0);
  const Answer within = ask(kCube, at(0, 0, 0), kCube, at(1.5, 0.1, 0), query);
  EXPECT_EQ(within.geometry.separation, 0.5);
  EXPECT_EQ(within.geometry.point_count, 4);
}

TEST(Native, PosesOffOrthonormalAreTakenAsGiven) {
  Random random(8);
  for (int i = 0; i < 300; ++i) {
    SCOPED_TRACE(i);
    Pose X_WA = random.pose(0.3), X_WB = random.pose(1.0);
    X_WA.R = X_WA.R.cast<float>().cast<double>();
    X_WB.R = X_WB.R.cast<float>().cast<double>();
    const Hexahedron a = random.box(), b = random.box();
    expect_right(a, X_WA, b, X_WB);
    if (HasFailure()) return;
  }
}

TEST(Native, AnswersDoNotDependOnTheRestOfTheBatch) {
  Random random(9);
  const AllPairs scene = random.crowd(30);
  const auto native = make_native();
  native->build(scene.solids);
  Query query = whole_clip();
  query.max_points = 4;
  const Answers together = ask(*native, scene.pairs, scene.poses, query);
  for (std::size_t i = 0; i < scene.pairs.size(); ++i) {
    const SolidPair pair = scene.pairs[i];
    const Answer alone =
        ask(scene.solids[pair.a], scene.poses[pair.a], scene.solids[pair.b], scene.poses[pair.b], query);
    ASSERT_EQ(together.status[i], alone.status);
    ASSERT_EQ(together.geometry[i].separation, alone.geometry.separation);
    ASSERT_EQ(together.geometry[i].point_count, alone.geometry.point_count);
    for (std::size_t k = 0; k < alone.points.size(); ++k)
      ASSERT_EQ(together.points[4 * i + k].p_A_W, alone.points[k].p_A_W);
  }
}

}  // namespace
}  // namespace touchstone
