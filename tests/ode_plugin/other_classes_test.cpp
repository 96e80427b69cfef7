// A hexahedron geom against the classes that ODE's own check answers for: how many contacts, how deep,
// which way, against closed forms. A box and a frustum of 1 m, whose upper face is z = 0.5.

#include <gtest/gtest.h>
#include <ode/ode.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "touchstone/adapters/ode_plugin/ode_plugin.hpp"
#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/tests/ode_plugin/frustum.hpp"

namespace touchstone {
namespace {

/// A pyramid: its upper face is one point.
Hexahedron pyramid() {
  std::array<Vector3, 8> v;
  for (int i = 0; i < 8; ++i) {
    const double w = (i & 1) != 0 ? 0.0 : 0.5;
    v[i] = {(i & 4) != 0 ? w : -w, (i & 2) != 0 ? w : -w, (i & 1) != 0 ? 0.5 : -0.5};
  }
  return Hexahedron::from_vertices(v);
}

struct Solid {
  const char* name;
  Hexahedron solid;
};
constexpr double kTolerance = 1e-12;

class OdeOtherClasses : public testing::TestWithParam<int> {
 protected:
  OdeOtherClasses()
      : solid_(GetParam() == 0 ? Solid{"box", Hexahedron::from_size({1, 1, 1})}
                               : Solid{"frustum", frustum()}) {
    dInitODE2(0);
    dAllocateODEDataForThread(dAllocateMaskAll);
    hexahedron_ = create_ode_hexahedron(nullptr, solid_.solid);
    // Turned and shifted, so that the twin has to stand where the geom does.
    dRFromAxisAndAngle(turn_, 1, 2, 3, 0.7);
    place(hexahedron_, {0, 0, 0});
  }
  ~OdeOtherClasses() override {
    for (const dGeomID geom : geoms_) dGeomDestroy(geom);
    dGeomDestroy(hexahedron_);
    dCloseODE();
  }

  /// p and the geom's axes in the hexahedron's frame; `along` turns z to x.
  void place(dGeomID geom, const Vector3& p, bool along = false) {
    dVector3 rotated;
    const dVector3 local = {p.x(), p.y(), p.z()};
    dMultiply0_331(rotated, turn_, local);
    dGeomSetPosition(geom, rotated[0] + 3, rotated[1] - 2, rotated[2] + 1);
    dMatrix3 to_x, R;
    dRFromAxisAndAngle(to_x, 0, 1, 0, along ? 0.5 * M_PI : 0.0);
    dMultiply0_333(R, turn_, to_x);
    dGeomSetRotation(geom, R);
  }
  dGeomID keep(dGeomID geom) {
    geoms_.push_back(geom);
    return geom;
  }

  /// Of the hexahedron and the geom, in either order; the normal's z in the hexahedron's frame, toward it.
  struct Met {
    std::vector<dContactGeom> contacts;
    double depth = -1.0;
    double up = 0.0;  ///< of the deepest
  };
  Met meet(dGeomID geom, bool swapped) {
    Met met;
    met.contacts.resize(8);
    const dGeomID first = swapped ? geom : hexahedron_, second = swapped ? hexahedron_ : geom;
    const int count = dCollide(first, second, 8, met.contacts.data(), sizeof(dContactGeom));
    met.contacts.resize(static_cast<std::size_t>(count));
    for (const dContactGeom& contact : met.contacts) {
      EXPECT_EQ(contact.g1, first);
      EXPECT_EQ(contact.g2, second);
      if (contact.depth <= met.depth) continue;
      met.depth = contact.depth;
      dVector3 n;
      dMultiply1_331(n, turn_, contact.normal);
      met.up = swapped ? -n[2] : n[2];  // into the hexahedron
    }
    return met;
  }
  void expect_met(dGeomID geom, double depth, std::size_t least, std::size_t most) {
    for (const bool swapped : {false, true}) {
      const Met met = meet(geom, swapped);
      EXPECT_GE(met.contacts.size(), least) << solid_.name << (swapped ? ", swapped" : "");
      EXPECT_LE(met.contacts.size(), most) << solid_.name << (swapped ? ", swapped" : "");
      EXPECT_NEAR(met.depth, depth, kTolerance) << solid_.name << (swapped ? ", swapped" : "");
      EXPECT_NEAR(met.up, -1.0, 1e-3) << solid_.name;
      std::printf("  %s: %zu contacts, depth off by %.1e\n", solid_.name, met.contacts.size(),
                  std::abs(met.depth - depth));
    }
  }
  void expect_apart(dGeomID geom) {
    for (const bool swapped : {false, true}) EXPECT_TRUE(meet(geom, swapped).contacts.empty());
  }

  Solid solid_;
  dMatrix3 turn_;
  dGeomID hexahedron_;
  std::vector<dGeomID> geoms_;
};

TEST_P(OdeOtherClasses, Spheres) {
  const dGeomID sphere = keep(dCreateSphere(nullptr, 0.3));
  place(sphere, {0.05, -0.02, 0.5 + 0.3 - 0.04});
  expect_met(sphere, 0.04, 1, 1);
  place(sphere, {0.05, -0.02, 0.5 + 0.3 + 0.001});
  expect_apart(sphere);
}

TEST_P(OdeOtherClasses, SpheresAnywhereOverAFace) {
  const dGeomID sphere = keep(dCreateSphere(nullptr, 0.3));
  double worst = 0.0;
  for (double x = -0.24; x < 0.25; x += 0.06)
    for (double y = -0.23; y < 0.25; y += 0.06)
      for (const double depth : {0.001, 0.02, 0.1}) {
        place(sphere, {x, y, 0.5 + 0.3 - depth});
        worst = std::max(worst, std::abs(meet(sphere, false).depth - depth));
      }
  std::printf("  %s: worst depth off by %.1e m\n", solid_.name, worst);
  EXPECT_LE(worst, kTolerance);
}

TEST_P(OdeOtherClasses, Capsules) {
  const dGeomID capsule = keep(dCreateCapsule(nullptr, 0.1, 0.6));
  place(capsule, {0.05, -0.02, 0.5 + 0.3 + 0.1 - 0.03});  // upright
  expect_met(capsule, 0.03, 1, 1);
  place(capsule, {0.05, -0.02, 0.5 + 0.1 - 0.03}, true);  // along the face
  expect_met(capsule, 0.03, 1, 2);
  place(capsule, {0.05, -0.02, 0.5 + 0.1 + 0.001}, true);
  expect_apart(capsule);
}

/// Over an edge of the upper face, and over its corner: the distance to them.
TEST_P(OdeOtherClasses, SpheresOverEdgesAndCorners) {
  const double w = GetParam() == 0 ? 0.5 : 0.25;
  const dGeomID sphere = keep(dCreateSphere(nullptr, 0.3));
  place(sphere, {w + 0.1, 0.05, 0.5 + 0.2});
  EXPECT_NEAR(meet(sphere, false).depth, 0.3 - std::hypot(0.1, 0.2), kTolerance);
  place(sphere, {w + 0.1, w + 0.05, 0.5 + 0.2});
  EXPECT_NEAR(meet(sphere, true).depth, 0.3 - std::hypot(0.1, 0.05, 0.2), kTolerance);
  place(sphere, {w + 0.2, w + 0.2, 0.5 + 0.2});
  expect_apart(sphere);
}

/// A capsule across an edge, its ends beyond: one contact there.
TEST_P(OdeOtherClasses, ACapsuleAcrossAnEdge) {
  const double w = GetParam() == 0 ? 0.5 : 0.25;
  const dGeomID capsule = keep(dCreateCapsule(nullptr, 0.1, 2.0));
  // Square to the edge x = w, z = 0.5, 45 degrees down; 0.07 off it.
  dVector3 p;
  const double off = 0.07 / std::sqrt(2.0);
  const dVector3 local = {w + off, 0.03, 0.5 + off};
  dMultiply0_331(p, turn_, local);
  dGeomSetPosition(capsule, p[0] + 3, p[1] - 2, p[2] + 1);
  dMatrix3 down, R;
  dRFromAxisAndAngle(down, 0, 1, 0, 0.75 * M_PI);
  dMultiply0_333(R, turn_, down);
  dGeomSetRotation(capsule, R);
  const Met met = meet(capsule, false);
  ASSERT_EQ(met.contacts.size(), 1u);
  EXPECT_NEAR(met.depth, 0.03, kTolerance) << solid_.name;
}

/// A capsule over the upper face, tilted so that either end is the lower one: of its two contacts the deeper
/// is the first. (Boxes are met by ODE's own check.)
TEST_P(OdeOtherClasses, ATiltedCapsulesDeeperEndIsFirst) {
  if (GetParam() == 0) return;
  const double radius = 0.1, half = 0.15, tilt = 0.15;
  const dGeomID capsule = keep(dCreateCapsule(nullptr, radius, 2 * half));
  for (const double sign : {-1.0, 1.0}) {
    place(capsule, {0.0, 0.02, 0.5 + radius - 0.03});
    dMatrix3 down, R;
    dRFromAxisAndAngle(down, 0, 1, 0, 0.5 * M_PI + sign * tilt);
    dMultiply0_333(R, turn_, down);
    dGeomSetRotation(capsule, R);
    for (const bool swapped : {false, true}) {
      const Met met = meet(capsule, swapped);
      ASSERT_EQ(met.contacts.size(), 2u);
      EXPECT_NEAR(met.contacts[0].depth, 0.03 + half * std::sin(tilt), kTolerance);
      EXPECT_NEAR(met.contacts[1].depth, 0.03 - half * std::sin(tilt), kTolerance);
    }
  }
}

/// Its middle within the solid: the least way out.
TEST_P(OdeOtherClasses, ASphereWithin) {
  const dGeomID sphere = keep(dCreateSphere(nullptr, 0.1));
  place(sphere, {0.02, 0.01, 0.4});
  expect_met(sphere, 0.2, 1, 1);
}

/// ODE's own answer by libccd, of the twin's class: boxes to a millimetre; a convex's depth was 0.044 m of
/// 0.03.
TEST_P(OdeOtherClasses, CylindersAreMetAsOdeMeetsTheTwin) {
  const dGeomID cylinder = keep(dCreateCylinder(nullptr, 0.1, 0.6));
  place(cylinder, {0.05, -0.02, 0.5 + 0.3 - 0.03});
  for (const bool swapped : {false, true}) {
    const Met met = meet(cylinder, swapped);
    EXPECT_GE(met.contacts.size(), 1u) << solid_.name;
    EXPECT_GE(met.depth, 0.03 - 1e-3) << solid_.name;
    EXPECT_LE(met.depth, GetParam() == 0 ? 0.03 + 1e-3 : 0.06) << solid_.name;
  }
  place(cylinder, {0.05, -0.02, 0.5 + 0.3 + 0.01});
  expect_apart(cylinder);
}

TEST_P(OdeOtherClasses, Rays) {
  const dGeomID ray = keep(dCreateRay(nullptr, 2.0));
  // Down on the face from 0.7 above: a ray looks along its z.
  dVector3 down, from;
  const dVector3 local_down = {0, 0, -1}, local_from = {0.05, -0.02, 1.2};
  dMultiply0_331(down, turn_, local_down);
  dMultiply0_331(from, turn_, local_from);
  dGeomRaySet(ray, from[0] + 3, from[1] - 2, from[2] + 1, down[0], down[1], down[2]);
  for (const bool swapped : {false, true}) {
    const Met met = meet(ray, swapped);
    ASSERT_EQ(met.contacts.size(), 1u) << solid_.name;
    EXPECT_NEAR(met.contacts[0].depth, 0.7, 1e-12) << solid_.name;  // a ray's: how far along it
    EXPECT_NEAR(met.up, -1.0, 1e-12) << solid_.name;
  }
  dGeomRaySet(ray, from[0] + 3, from[1] - 2, from[2] + 1, -down[0], -down[1], -down[2]);
  expect_apart(ray);
}

TEST_P(OdeOtherClasses, Trimeshes) {
  // A square of two triangles, its face up where z is; dTriMesh keeps what it is built from.
  const std::array<double, 12> vertices = {-2, -2, 0, 2, -2, 0, 2, 2, 0, -2, 2, 0};
  const std::array<dTriIndex, 6> faces = {0, 1, 2, 0, 2, 3};
  const dTriMeshDataID data = dGeomTriMeshDataCreate();
  dGeomTriMeshDataBuildDouble(data, vertices.data(), 3 * sizeof(double), 4, faces.data(), 6,
                              3 * sizeof(dTriIndex));
  const dGeomID mesh = keep(dCreateTriMesh(nullptr, data, nullptr, nullptr, nullptr));
  place(mesh, {0, 0, -0.5 + 0.02});  // the lower face is 0.02 below the mesh
  if (GetParam() != 0) {
    const std::uint64_t before = ode_native_refusals();
    expect_apart(mesh);
    EXPECT_EQ(ode_native_refusals() - before, 2u);
    dGeomDestroy(geoms_.back());
    geoms_.pop_back();
    return dGeomTriMeshDataDestroy(data);
  }
  for (const bool swapped : {false, true}) {
    const Met met = meet(mesh, swapped);
    EXPECT_GE(met.contacts.size(), 1u) << solid_.name;
    EXPECT_NEAR(met.depth, 0.02, kTolerance) << solid_.name;
    EXPECT_NEAR(met.up, 1.0, 1e-3) << solid_.name;  // the mesh pushes it up
    std::printf("  %s: %zu contacts, depth off by %.1e\n", solid_.name, met.contacts.size(),
                std::abs(met.depth - 0.02));
  }
  place(mesh, {0, 0, -0.5 - 0.01});
  expect_apart(mesh);
  dGeomDestroy(geoms_.back());
  geoms_.pop_back();
  dGeomTriMeshDataDestroy(data);
}

TEST_P(OdeOtherClasses, Convexes) {
  // A cube as a dConvex of a program's own.
  std::array<double, 24> planes = {1, 0,  0, 0.2, -1, 0, 0, 0.2, 0, 1, 0,  0.2,
                                   0, -1, 0, 0.2, 0,  0, 1, 0.2, 0, 0, -1, 0.2};
  std::array<double, 24> points;
  for (int i = 0; i < 8; ++i)
    for (int k = 0; k < 3; ++k) points[3 * i + k] = (i >> k & 1) != 0 ? 0.2 : -0.2;
  const std::array<unsigned int, 30> polygons = {4, 1, 3, 7, 5, 4, 0, 4, 6, 2, 4, 2, 6, 7, 3,
                                                 4, 0, 1, 5, 4, 4, 4, 5, 7, 6, 4, 0, 2, 3, 1};
  const dGeomID convex = keep(dCreateConvex(nullptr, planes.data(), 6, points.data(), 8, polygons.data()));
  place(convex, {0.02, -0.01, 0.5 + 0.2 - 0.03});
  for (const bool swapped : {false, true}) {
    const Met met = meet(convex, swapped);
    EXPECT_GE(met.contacts.size(), 1u) << solid_.name;
    EXPECT_NEAR(met.depth, 0.03, 1e-3) << solid_.name;
  }
  place(convex, {0.02, -0.01, 0.5 + 0.2 + 0.01});
  expect_apart(convex);
}

TEST_P(OdeOtherClasses, PosesThatAreNoneHaveNoContacts) {
  const dGeomID sphere = keep(dCreateSphere(nullptr, 0.3));
  const std::uint64_t before = ode_native_refusals();
  dGeomSetPosition(sphere, kNaN, 0, 0);
  expect_apart(sphere);
  EXPECT_EQ(ode_native_refusals() - before, 2u);
}

INSTANTIATE_TEST_SUITE_P(BoxAndFrustum, OdeOtherClasses, testing::Values(0, 1),
                         [](const auto& test) { return test.param == 0 ? "Box" : "Frustum"; });

TEST(OdeOtherClasses, ACollapsedFaceIsNoFaceOfTheTwin) {
  dInitODE2(0);
  dAllocateODEDataForThread(dAllocateMaskAll);
  const dGeomID solid = create_ode_hexahedron(nullptr, pyramid());
  const dGeomID sphere = dCreateSphere(nullptr, 0.2), ray = dCreateRay(nullptr, 3.0);
  dContactGeom contact;
  dGeomSetPosition(sphere, 0, 0, -0.5 - 0.2 + 0.05);
  ASSERT_EQ(dCollide(solid, sphere, 1, &contact, sizeof contact), 1);
  EXPECT_NEAR(contact.depth, 0.05, 1e-12);
  // Half-way up a side: where 2 x + z = 0.5.
  dGeomRaySet(ray, 2, 0, 0, -1, 0, 0);
  ASSERT_EQ(dCollide(solid, ray, 1, &contact, sizeof contact), 1);
  EXPECT_NEAR(contact.depth, 1.75, 1e-12);
  for (const dGeomID geom : {solid, sphere, ray}) dGeomDestroy(geom);
  dCloseODE();
}

}  // namespace
}  // namespace touchstone
