#include "touchstone/physics/bodies/inertia.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <random>

#include "touchstone/contact_core/geometry/matrix3.hpp"
#include "touchstone/tests/support/random_poses.hpp"
#include "touchstone/tests/support/refusal.hpp"

using namespace touchstone;
using namespace touchstone::physics;

namespace {

PlacedHexahedron placed(Hexahedron solid, const Pose& X_OS = {}) { return {"solid", std::move(solid), X_OS}; }

double defect(const Matrix3& a, const Matrix3& b) { return (a - b).cwiseAbs().maxCoeff(); }

TEST(BodyInertia, BoxInAnyPoseIsTheClosedForm) {
  std::mt19937_64 random(1);
  for (int i = 0; i < 100; ++i) {
    const Vector3 size = random_vector(random, 0.1, 2.0);
    const Pose X = random_pose(random, 3.0);
    const PlacedHexahedron solid = placed(Hexahedron::from_size(size), X);
    const BodyInertia box = box_inertia(7.0, size);
    const BodyInertia got = inertia_of_mass({&solid, 1}, 7.0, "box");
    EXPECT_LT(norm(got.centre_B - X.p), 4e-15);
    EXPECT_EQ(got.inertia_B, got.inertia_B.transpose());  // mechanisms refuse what is not
    // Second moments of a box 3 m off are computed about the frame's origin: (3 sqrt 3)^2 eps of them.
    EXPECT_LT(defect(got.inertia_B, turned(X.R, box.inertia_B)), 7.0 * 27.0 * 16 * 0x1p-53);
    const double density = 7.0 / (size.x() * size.y() * size.z());
    EXPECT_NEAR(inertia_of_density({&solid, 1}, density, "box").mass, 7.0, 1e-13);
  }
}

TEST(BodyInertia, FrustumIsTheClosedForm) {
  // Square frustum, half-widths 2 at z = 0 and 1 at z = 3: with a(z) = 2 - z/3, V = int 4 a^2 = 28,
  // int z 4 a^2 = 33, int x^2 = int 4/3 a^4 = 124/5.
  std::array<Vector3, 8> corners;
  for (unsigned i = 0; i < 8; ++i) {
    const double a = (i & 1) != 0 ? 1.0 : 2.0;
    corners[i] = {(i & 4) != 0 ? a : -a, (i & 2) != 0 ? a : -a, (i & 1) != 0 ? 3.0 : 0.0};
  }
  const PlacedHexahedron solid = placed(Hexahedron::from_vertices(corners));
  const BodyInertia got = inertia_of_density({&solid, 1}, 1.0, "frustum");
  EXPECT_NEAR(got.mass, 28.0, 1e-13);
  EXPECT_NEAR(got.centre_B.z(), 33.0 / 28.0, 1e-14);
  EXPECT_NEAR(got.inertia_B(2, 2), 2.0 * 124.0 / 5.0, 1e-13);
}

TEST(BodyInertia, WarpedSolidIsItsHull) {
  // A unit cube with one corner lifted by 0.3: its top face's hull has the ridge from that corner across. The
  // hull is the cube and the tetrahedra between the raised corner and the three others of the top, and below
  // the two side faces nothing: they stay planar. Volume 1 + 2 * (1/6 * 0.3).
  std::array<Vector3, 8> corners;
  for (unsigned i = 0; i < 8; ++i)
    corners[i] = {static_cast<double>(i >> 2 & 1), static_cast<double>(i >> 1 & 1),
                  static_cast<double>(i & 1)};
  corners[7].z() = 1.3;
  const auto volume = [&] {
    const PlacedHexahedron solid = placed(Hexahedron::from_vertices(corners, WarpPolicy::accept));
    return inertia_of_density({&solid, 1}, 1.0, "warped").mass;
  };
  EXPECT_NEAR(volume(), 1.0 + 2.0 * 0.3 / 6.0, 1e-15);
  corners[7].z() = 1.0;
  corners[3].z() = 1.3;  // the other diagonal
  EXPECT_NEAR(volume(), 1.0 + 2.0 * 0.3 / 6.0, 1e-15);
}

TEST(BodyInertia, PartsAddUpToTheWhole) {
  Pose left, right;
  left.p = {-0.5, 0, 0};
  right.p = {0.5, 0, 0};
  const std::array halves = {placed(Hexahedron::from_size({1, 2, 3}), left),
                             placed(Hexahedron::from_size({1, 2, 3}), right)};
  const BodyInertia whole = box_inertia(12.0, {2, 2, 3});
  const BodyInertia got = inertia_of_density(halves, 1.0, "two halves");
  EXPECT_NEAR(got.mass, whole.mass, 1e-14);
  EXPECT_LT(defect(got.inertia_B, whole.inertia_B), 1e-14);
  BodyInertia a = box_inertia(6.0, {1, 2, 3}), b = a;
  a.centre_B = left.p;
  b.centre_B = right.p;
  EXPECT_LT(defect(combined(a, b).inertia_B, whole.inertia_B), 1e-14);
}

TEST(BodyInertia, WhatNoSolidHasIsRefusedByName) {
  BodyInertia inertia = box_inertia(1.0, {1, 1, 1});
  const auto error = [&] { return refusal_of([&] { validate(inertia, Thinness::solid, "payload"); }); };
  EXPECT_EQ(error(), "accepted");
  for (const double mass : {0.0, -1.0, std::nan("")}) {
    inertia.mass = mass;
    EXPECT_THAT(error(), testing::StartsWith("payload: the mass is "));
  }
  inertia = box_inertia(1.0, {1, 1, 1});
  inertia.inertia_B(0, 0) = inertia.inertia_B(1, 1) + inertia.inertia_B(2, 2);
  EXPECT_EQ(error(), "accepted");  // a thin plate
  inertia.inertia_B(0, 0) *= 1.0 + 1e-12;
  EXPECT_THAT(error(), testing::HasSubstr("no solid has one larger than the sum of the others"));
  inertia.inertia_B(0, 0) = -0.1;
  EXPECT_THAT(error(), testing::HasSubstr("principal moment -0.1 kg m2 is not positive"));
  inertia = box_inertia(1.0, {1, 1, 1});
  inertia.inertia_B(0, 1) = 0.01;
  EXPECT_THAT(error(), testing::HasSubstr("must be finite and symmetric"));

  inertia = {2.0, Vector3::Zero(), Vector3(0.0, 3.0, 3.0).asDiagonal()};  // a rod
  EXPECT_THAT(error(), testing::HasSubstr("is not positive"));
  EXPECT_NO_THROW(validate(inertia, Thinness::thin, "rod"));
  EXPECT_THAT(refusal_of([] { inertia_of_mass({}, 1.0, "ghost"); }),
              testing::HasSubstr("ghost: no hexahedron"));
}

TEST(BodyInertia, TheSolidWhoseMassIsNotKnownIsNamed) {
  std::array<Vector3, 8> corners = Hexahedron::from_size({1, 1, 1}).vertices();
  for (Vector3& p : corners) p.x() += 0.25 * p.z();
  const std::array solids = {placed(Hexahedron::sphere(0.5)),
                             PlacedHexahedron{"wedge", Hexahedron::from_vertices(corners).padded(0.1), {}}};
  EXPECT_THAT(refusal_of([&] { inertia_of_density(solids, 1.0, "payload"); }),
              testing::StartsWith("payload: hexahedron 'wedge': the mass of a rounded solid"));
  EXPECT_THAT(refusal_of([&] { inertia_of_mass(solids, 1.0, "payload"); }),
              testing::StartsWith("payload: hexahedron 'wedge': the mass of a rounded solid"));
}

TEST(BodyInertia, OfALinkIsShiftedToItsCentreOfMass) {
  // A 5 m, 70 kg rod from its end: m L^2 / 3 there, m L^2 / 12 in the middle.
  MassProperties rod{70.0, {2.5, 0, 0}, Matrix3::Zero(), Vector3::Zero()};
  rod.inertia_L(1, 1) = rod.inertia_L(2, 2) = 70.0 * 25.0 / 3.0;
  EXPECT_NEAR(inertia_of(rod, "rod").inertia_B(2, 2), 70.0 * 25.0 / 12.0, 1e-13);
  rod.inertia_L *= 0.5;  // less than the mass alone has there
  EXPECT_THAT(refusal_of([&] { inertia_of(rod, "rod"); }), testing::StartsWith("rod: principal moment -"));
}

}  // namespace
