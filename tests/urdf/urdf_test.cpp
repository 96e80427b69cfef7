#include "touchstone/adapters/urdf/urdf.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/mechanism/arms/ssrms.hpp"
#include "touchstone/tests/support/refusal.hpp"

namespace touchstone {
namespace {

using testing::HasSubstr;

const std::filesystem::path kFiles = TOUCHSTONE_URDF_FILES;

TEST(Urdf, TheArmMovesAsTheLibrarysOwn) {
  const Mechanism arm(urdf::load_urdf(kFiles / "arm.urdf"));
  const Mechanism own(make_ssrms());
  EXPECT_EQ(arm.name(), "arm");
  ASSERT_EQ(arm.value_count(), 7u);
  const std::vector<double> q = {0.3, -0.4, 0.5, 1.6, -0.7, 0.8, -0.9};
  std::vector<Pose> X(9), Y(9);
  arm.link_poses({}, q, X);
  own.link_poses({}, q, Y);
  for (std::uint32_t link = 0; link < 9; ++link) {
    const Pose& expected = Y[own.find_link(arm.links()[link].name)];
    EXPECT_LE(norm(X[link].p - expected.p), 1e-13) << arm.links()[link].name;
    EXPECT_LE((X[link].R - expected.R).cwiseAbs().maxCoeff(), 1e-14);
  }
}

TEST(Urdf, LimitsAndReferenceAreTaken) {
  const Mechanism arm(urdf::load_urdf(kFiles / "arm.urdf"));
  const Mechanism::Joint& elbow = arm.joints()[arm.find_joint("elbow_pitch")];
  EXPECT_EQ(elbow.lower, 0.5);
  EXPECT_EQ(elbow.upper, 4.7);
  EXPECT_EQ(elbow.rate, 0.0698);
  EXPECT_EQ(elbow.effort, 2332);
  EXPECT_EQ(arm.reference()[3], 0.5);  // 0 is out of its limits
  EXPECT_EQ(arm.reference()[0], 0.0);
  EXPECT_EQ(arm.joints()[arm.find_joint("wrist_pitch")].upper, kInfinity);
}

TEST(Urdf, SolidsFillTheirShapesAndFacetsAreStated) {
  urdf::LoadOptions options;
  options.cylinder_facets = 16;
  const Mechanism arm(urdf::load_urdf(kFiles / "arm.urdf", options));
  const Mechanism::Link& boom = arm.links()[arm.find_link("upper_boom")];
  ASSERT_EQ(boom.solid_count, 8u);  // seven slices and the box
  double low = 1e9, high = -1e9, widest = 0;
  for (std::uint32_t i = 0; i < 7; ++i) {
    const PlacedHexahedron& slice = arm.placed(boom.first_solid + i);
    // A boom of sixteen facets, in seven slices, and a box.
    EXPECT_EQ(slice.name, "boom." + std::to_string(i));
    for (const Vector3& v : slice.solid.vertices()) {
      const Vector3 p = transform(slice.X_OS, v);
      low = std::min(low, p.x()), high = std::max(high, p.x());
      widest = std::max(widest, std::hypot(p.y(), p.z()));
      // The slices fill its length, and are as wide as facets outside of the cylinder are.
    }
  }
  EXPECT_NEAR(low, 0, 1e-14);
  EXPECT_NEAR(high, 7.11, 1e-14);
  EXPECT_NEAR(widest, 0.175 / std::cos(std::numbers::pi / 16), 1e-14);
  // The box, and the error that is stated.
  EXPECT_EQ(arm.placed(boom.first_solid + 7).name, "collision.1");
  EXPECT_EQ(arm.placed(boom.first_solid + 7).X_OS.p, Vector3(7.11, -0.2375, 0));
  ASSERT_EQ(arm.description().facet_figures.size(), 2u);
  const FacetFigure& figure = arm.description().facet_figures[1];
  EXPECT_EQ(figure.object + "/" + figure.hexahedron, "upper_boom/boom");
  EXPECT_NEAR(figure.error, widest - 0.175, 1e-14);
}

TEST(Urdf, InertiaIsTurnedIntoTheLinksAxes) {
  const Mechanism arm(urdf::load_urdf(kFiles / "arm.urdf"));
  const MassProperties& mass = arm.links()[arm.find_link("upper_boom")].mass;
  EXPECT_EQ(mass.mass, 314.88);
  EXPECT_EQ(mass.centre_L, Vector3(3.555, -0.2375, 0));
  EXPECT_EQ(mass.inertia_about_L, mass.centre_L);
  EXPECT_NEAR(mass.inertia_L(0, 0), 2094.71, 1e-11);  // a quarter turn about z
  EXPECT_NEAR(mass.inertia_L(1, 1), 15.41, 1e-11);
  EXPECT_NEAR(mass.inertia_L(0, 1), -49.52, 1e-11);
}

TEST(Urdf, RotationsAreFixedAxisRollPitchYaw) {
  const Mechanism arm(urdf::parse_urdf(R"(<robot name="r"><link name="a"/><link name="b"/>
    <joint name="j" type="fixed"><parent link="a"/><child link="b"/>
    <origin xyz="1 2 3" rpy="0.1 0.2 0.3"/></joint></robot>)"));
  std::vector<Pose> X(2);
  arm.link_poses({}, {}, X);
  Vector6 position;
  position << 1, 2, 3, 0.1, 0.2, 0.3;
  const Pose expected = pose_from_position_vector(position);
  EXPECT_EQ(X[1].p, expected.p);
  EXPECT_LE((X[1].R - expected.R).cwiseAbs().maxCoeff(), 1e-15);
}

/// Every kind of shape, meshes by package and by path.
TEST(Urdf, MeshesAndRoundShapesAreReplacedAndAccountedFor) {
  const Robot robot = urdf::load_robot(kFiles / "mesh_arm/urdf/mesh_arm.urdf");
  const Mechanism arm(robot.mechanism);
  EXPECT_EQ(arm.value_count(), 6u);
  std::vector<std::string> replaced;
  for (const ShapeReplacement& each : robot.replaced) replaced.push_back(each.link + " " + each.shape);
  EXPECT_THAT(replaced, testing::ElementsAre("shoulder sphere", "upper mesh", "lower mesh", "lower cylinder",
                                             "hand mesh"));
  EXPECT_EQ(robot.replaced[0].hexahedra, 1u);
  EXPECT_EQ(robot.replaced[0].error, 0.0);
  EXPECT_TRUE(arm.placed(arm.links()[arm.find_link("shoulder")].first_solid).solid.is_rounded());
  EXPECT_EQ(robot.replaced[1].triangles, 28u);
  EXPECT_TRUE(robot.notes.empty());
  // The boom's box: 0.6 m long from 0.12 m on, as wide as its octagon (corner radius 0.08).
  const PlacedHexahedron& boom = arm.placed(arm.links()[arm.find_link("upper")].first_solid);
  double low = 1e9, high = -1e9, widest = 0.0;
  for (const Vector3& v : boom.solid.vertices()) {
    const Vector3 p = transform(boom.X_OS, v);
    low = std::min(low, p.x()), high = std::max(high, p.x());
    widest = std::max(widest, p.tail<2>().cwiseAbs().maxCoeff());
  }
  EXPECT_NEAR(low, 0.12, 1e-12);
  EXPECT_NEAR(high, 0.72, 1e-12);
  EXPECT_NEAR(widest, 0.08 * std::cos(std::numbers::pi / 8), 1e-4);
  // The hand's file is in millimetres, which its scale states.
  EXPECT_NEAR(arm.links()[arm.find_link("hand")].tree->solids()[0].solid.size(), 0.187, 1e-3);
}

TEST(Urdf, TheCallersFunctionCoversMeshesOnceAFile) {
  int calls = 0;
  RobotOptions options;
  options.cover_mesh = [&](const TriangleMesh& mesh, const std::string& name) {
    ++calls;
    EXPECT_FALSE(mesh.triangles.empty());
    const Hexahedron part = Hexahedron::from_size({1, 1, 1}, name);
    return MeshCover{{{name + ".0", part, {}}, {name + ".1", part, {}}}, 0.25};
  };
  const Robot robot = urdf::load_robot(kFiles / "mesh_arm/urdf/mesh_arm.urdf", options);
  EXPECT_EQ(calls, 2);
  EXPECT_EQ(robot.replaced[1].error, 0.25);
  EXPECT_EQ(robot.mechanism.links[3].solids[1].name, "boom.1");
}

TEST(Urdf, MimicJointsMoveByThemselvesWhereAskedFor) {
  RobotOptions options;
  options.mimic = MimicJoints::free;
  const Robot robot = urdf::parse_robot(
      R"(<robot name="r"><link name="a"/><link name="b"/><joint name="j" type="continuous"><parent link="a"/>
      <child link="b"/><axis xyz="0 0 1"/><mimic joint="k"/></joint></robot>)",
      "r.urdf", options);
  EXPECT_EQ(Mechanism(robot.mechanism).value_count(), 1u);
  EXPECT_THAT(robot.notes, testing::ElementsAre(HasSubstr("joint 'j': mimics 'k'; here it moves by itself")));
}

TEST(Urdf, AMeshOfWhichTrianglesWereTurnedIsNoted) {
  const std::filesystem::path file = std::filesystem::path(testing::TempDir()) / "turned_triangle.obj";
  std::ofstream(file) << "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 4 3\n";
  const Robot robot =
      urdf::parse_robot(R"(<robot name="r"><link name="a"><collision><geometry><mesh filename="file://)" +
                            file.string() + R"("/></geometry></collision></link></robot>)",
                        "r.urdf", {});
  EXPECT_THAT(
      robot.notes,
      testing::ElementsAre(HasSubstr("1 turned so that the surface faces one way, the first at triangle 3")));
  std::filesystem::remove(file);
}

TEST(Srdf, DisabledCollisionsBecomeExemptPairs) {
  MechanismDescription description = urdf::load_urdf(kFiles / "arm.urdf");
  description.exempt_pairs = urdf::load_srdf(kFiles / "arm.srdf");
  ASSERT_EQ(description.exempt_pairs.size(), 2u);
  const Mechanism arm(description);
  const auto solid = [&](const char* link) { return arm.links()[arm.find_link(link)].first_solid; };
  EXPECT_TRUE(arm.is_exempt(solid("base_lee"), solid("upper_boom")));
  EXPECT_FALSE(arm.is_exempt(solid("base_lee"), solid("lower_boom")));
}

std::string urdf_error(const std::string& body) {
  return refusal_of(
      [&] { const Mechanism arm(urdf::parse_urdf("<robot name=\"r\">" + body + "</robot>", "r.urdf")); });
}

std::string joint_element(const std::string& type, const std::string& rest) {
  return R"(<link name="a"/><link name="b"/><joint name="j" type=")" + type +
         R"("><parent link="a"/><child link="b"/>)" + rest + "</joint>";
}

std::string with_geometry(const std::string& geometry) {
  return R"(<link name="a"><collision><geometry>)" + geometry + "</geometry></collision></link>";
}

TEST(Urdf, AShapeThatCannotBeReadTakesNoOthersAwayUnsaid) {
  const auto link = [](const std::string& bad) {
    return R"(<link name="a">)" + bad +
           R"(<collision><geometry><box size="1 1 1"/></geometry></collision></link>)";
  };
  EXPECT_EQ(urdf_error(link("")), "accepted");
  for (const char* bad :
       {"<visual><geometry><capsule radius=\"0.1\" length=\"1\"/></geometry></visual>",
        "<collision><geometry><box size=\"1,5 1 1\"/></geometry></collision>",
        "<collision><geometry><mesh filename=\"a.stl\" scale=\"nan 1 1\"/></geometry></collision>"})
    EXPECT_THAT(urdf_error(link(bad)), HasSubstr("r.urdf: ")) << bad;
}

TEST(Urdf, WhatIsNoArmOfHexahedraIsRefusedByName) {
  EXPECT_THAT(urdf_error(with_geometry("<sphere radius=\"-1\"/>")),
              HasSubstr("r.urdf: link 'a', collision 'collision.0': radius is -1, must be > 0"));
  const auto mesh = [](const std::string& rest) {
    return urdf_error(with_geometry("<mesh filename=" + rest + "/>"));
  };
  EXPECT_THAT(
      mesh("\"package://nowhere/a.stl\""),
      HasSubstr("r.urdf: link 'a', collision 'collision.0': mesh 'package://nowhere/a.stl': not found"));
  EXPECT_THAT(mesh("\"package://nowhere/../../a.stl\""), HasSubstr("leaves its package"));
  EXPECT_THAT(mesh("\"not_there.stl\""), HasSubstr("there is no file not_there.stl"));
  const std::string srdf = "\"file://" + (kFiles / "arm.srdf").string() + "\"";
  EXPECT_THAT(mesh(srdf), HasSubstr("a mesh is read from .stl, .obj, .ply or .dae"));
  const std::string boom = "\"file://" + (kFiles / "mesh_arm/meshes/boom.stl").string() + "\"";
  EXPECT_THAT(mesh(boom + " scale=\"1 0 1\""), HasSubstr("a scale of 0"));
  EXPECT_THAT(urdf_error(with_geometry("<box size=\"1 0 1\"/>")), HasSubstr("r.urdf: link 'a', collision"));
  EXPECT_THAT(urdf_error(with_geometry("<cylinder radius=\"-1\" length=\"1\"/>")), HasSubstr("radius is -1"));
  EXPECT_THAT(urdf_error(joint_element("floating", "")),
              HasSubstr("r.urdf: joint 'j': floating joints are not"));
  EXPECT_THAT(urdf_error(joint_element("planar", "<axis xyz=\"1 0 0\"/>")),
              HasSubstr("planar joints are not"));
  EXPECT_THAT(urdf_error(joint_element("continuous", "<axis xyz=\"0 0 0\"/>")), HasSubstr("no direction"));
  EXPECT_THAT(urdf_error(joint_element("continuous", "<axis xyz=\"0 0 1\"/><mimic joint=\"k\"/>")),
              HasSubstr("joint 'j': mimics 'k'"));
  EXPECT_THAT(
      urdf_error(joint_element("prismatic", "<limit lower=\"2\" upper=\"1\" velocity=\"1\" effort=\"1\"/>")),
      HasSubstr("mechanism 'r', joint 'j': limits from 2 to 1"));
  // The parser's own words.
  EXPECT_THAT(urdf_error(joint_element("revolute", "<axis xyz=\"0 0 1\"/>")), HasSubstr("r.urdf: "));
  EXPECT_THAT(urdf_error("<link name=\"a\"/><link name=\"b\"/>"), HasSubstr("Two root links found"));
  EXPECT_THAT(refusal_of([] { urdf::parse_urdf("no xml", "x.urdf"); }), HasSubstr("x.urdf: "));
  EXPECT_THAT(refusal_of([] { urdf::load_urdf("missing.urdf"); }), HasSubstr("missing.urdf: cannot be read"));
}

TEST(Urdf, ALoopIsRefused) {
  EXPECT_THAT(urdf_error(R"(<link name="a"/><link name="b"/><link name="c"/>
    <joint name="ab" type="fixed"><parent link="a"/><child link="b"/></joint>
    <joint name="ac" type="fixed"><parent link="a"/><child link="c"/></joint>
    <joint name="bc" type="fixed"><parent link="b"/><child link="c"/></joint>)"),
              HasSubstr("closes a loop"));
  EXPECT_THAT(urdf_error(R"(<link name="a"/><link name="b"/><link name="c"/>
    <joint name="bc" type="fixed"><parent link="b"/><child link="c"/></joint>
    <joint name="cb" type="fixed"><parent link="c"/><child link="b"/></joint>)"),
              HasSubstr("no joint leads to it"));
}

TEST(Srdf, BadEntriesAreRefusedByLine) {
  EXPECT_THAT(
      refusal_of([] { urdf::parse_srdf("<robot>\n<disable_collisions link1=\"a\"/></robot>", "r.srdf"); }),
      HasSubstr("r.srdf:2: <disable_collisions> needs link1 and link2"));
  EXPECT_THAT(refusal_of([] { urdf::parse_srdf("<robot><enable_collisions/></robot>", "r.srdf"); }),
              HasSubstr("r.srdf:1: <enable_collisions> is not supported"));
  EXPECT_THAT(refusal_of([] { urdf::parse_srdf("<arm/>", "r.srdf"); }), HasSubstr("r.srdf: no <robot>"));
  EXPECT_THAT(refusal_of([] { urdf::parse_srdf("<robot>", "r.srdf"); }), HasSubstr("r.srdf:"));
  MechanismDescription description = urdf::load_urdf(kFiles / "arm.urdf");
  description.exempt_pairs = {{"base_lee", "moon"}};
  EXPECT_THAT(refusal_of([&] { const Mechanism arm(description); }), HasSubstr("no link 'moon'"));
}

}  // namespace
}  // namespace touchstone
