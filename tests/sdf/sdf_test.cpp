#include "touchstone/adapters/sdf/sdf.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/tests/support/program_test.hpp"
#include "touchstone/tests/support/refusal.hpp"

namespace touchstone {
namespace {

using testing::AllOf;
using testing::HasSubstr;

const std::string kMeshes = TOUCHSTONE_ROBOTS "/mesh_arm/meshes/";

std::string model(const std::string& body, const std::string& version = "1.9") {
  return "<sdf version='" + version + "'>\n<model name='arm'>\n" + body + "\n</model></sdf>";
}

std::string collision(const std::string& geometry, const std::string& more = "") {
  return "<collision name='c'>" + more + "<geometry>" + geometry + "</geometry></collision>";
}

const std::string kBox = "<box><size>0.2 0.2 1</size></box>";

/// Two links 1 m apart along x, the second turned by 90 degrees about z; a joint 0.1 m before the second.
std::string two_links(const std::string& axis, const std::string& version = "1.9",
                      const std::string& pose_of_b = "<pose degrees='true'>1 0 0 0 0 90</pose>") {
  return model("<link name='a'><pose>0 0 2 0 0 0</pose>" + collision(kBox) + "</link><link name='b'>" +
                   pose_of_b +
                   "<inertial><mass>2</mass><pose>0 0.5 0 0 0 0</pose><inertia><ixx>1</ixx><iyy>2</iyy>"
                   "<izz>2.5</izz></inertia></inertial>" +
                   collision(kBox, "<pose>0 0 0.5 0 0 0</pose>") +
                   "</link><joint name='j' type='revolute'><pose>0 0 -0.1 0 0 0</pose><parent>a</parent>"
                   "<child>b</child><axis>" +
                   axis +
                   "<limit><lower>-1</lower><upper>2</upper><velocity>-1</velocity><effort>1e16</effort>"
                   "</limit></axis></joint>",
               version);
}

std::vector<Pose> poses(const Mechanism& arm, double q) {
  std::vector<Pose> X(arm.links().size());
  arm.link_poses({}, std::vector<double>{q}, X);
  return X;
}

Vector3 middle(const Mechanism& arm, double q, std::uint32_t solid) {
  return transform(poses(arm, q)[arm.link_of(solid)], arm.placed(solid).X_OS.p);
}

TEST(Sdf, LinksStandAsTheFileHasThemAndTurnAboutTheJoint) {
  const Mechanism arm(sdf::parse_robot(two_links("<xyz>1 0 0</xyz>")).mechanism);
  ASSERT_EQ(arm.value_count(), 1u);
  // The base is a, and stands where the caller puts it: b's box is at (1, 0, 0.5 - 2) in a.
  EXPECT_LE(norm(middle(arm, 0.0, 1) - Vector3(1, 0, -1.5)), 1e-14);
  // The joint's x is the model's y; its origin is at (1, 0, -0.1): a quarter turn takes z + 0.6 to x + 0.6.
  EXPECT_LE(norm(middle(arm, std::acos(-1.0) / 2, 1) - Vector3(1.6, 0, -2.1)), 1e-14);
  const Mechanism::Joint& joint = arm.joints()[0];
  EXPECT_EQ(joint.lower, -1.0);
  EXPECT_EQ(joint.upper, 2.0);
  EXPECT_EQ(joint.rate, kInfinity);
  EXPECT_EQ(joint.effort, kInfinity);
  const MassProperties& mass = arm.links()[1].mass;
  EXPECT_EQ(mass.mass, 2.0);
  EXPECT_LE(norm(mass.centre_L - Vector3(0, 0.5, 0.1)), 1e-14);
}

TEST(Sdf, AxesAreInTheFrameThatIsSaid) {
  const auto axis = [](const std::string& text, const std::string& version) {
    return Mechanism(sdf::parse_robot(two_links(text, version)).mechanism).joints()[0].axis_J;
  };
  const Vector3 in_model(0, -1, 0);  // the model's x, seen from b
  EXPECT_LE(norm(axis("<xyz>1 0 0</xyz>", "1.9") - Vector3(1, 0, 0)), 1e-15);
  EXPECT_LE(norm(axis("<xyz>1 0 0</xyz>", "1.4") - in_model), 1e-15);
  EXPECT_LE(norm(axis("<xyz expressed_in='__model__'>1 0 0</xyz>", "1.9") - in_model), 1e-15);
  EXPECT_LE(norm(axis("<xyz expressed_in='a'>2 0 0</xyz>", "1.9") - in_model), 1e-15);
  EXPECT_LE(
      norm(axis("<xyz>1 0 0</xyz><use_parent_model_frame>1</use_parent_model_frame>", "1.6") - in_model),
      1e-15);
}

TEST(Sdf, PosesAreRelativeToLinksAndFrames) {
  const Mechanism arm(
      sdf::parse_robot(two_links("<xyz>0 0 1</xyz>", "1.9", "<pose relative_to='a'>1 0 0 0 0 0</pose>"))
          .mechanism);
  EXPECT_LE(norm(middle(arm, 0.0, 1) - Vector3(1, 0, 0.5)), 1e-14);
  const std::string by_frame =
      "<link name='a'/><frame name='f' attached_to='a'><pose>0 3 0 0 0 0</pose></frame><link name='b'>"
      "<pose relative_to='f' rotation_format='quat_xyzw'>0 1 0 0 0 0 1</pose>" +
      collision(kBox) + "</link><joint name='j' type='fixed'><parent>a</parent><child>b</child></joint>";
  EXPECT_EQ(Mechanism(sdf::parse_robot(model(by_frame)).mechanism).joints()[0].X_PJ.p, Vector3(0, 4, 0));
}

TEST(Sdf, AJointMayBeCalledAsALinkIs) {
  const auto named = [](const std::string& joint) {
    return Mechanism(
        sdf::parse_robot(model("<link name='a'/><link name='b'><pose>1 0 0 0 0 0</pose>" + collision(kBox) +
                                   "</link><joint name='" + joint +
                                   "' type='revolute'><pose>0 0 0.5 0 0 0</pose><parent>a</parent>"
                                   "<child>b</child><axis><xyz>0 0 1</xyz></axis></joint>",
                               "1.6"))
            .mechanism);
  };
  EXPECT_EQ(named("b").joints()[0].X_PJ.p, Vector3(1, 0, 0.5));
  EXPECT_EQ(named("b").joints()[0].X_PJ.p, named("j").joints()[0].X_PJ.p);
}

TEST(Sdf, EveryShapeIsRead) {
  const auto count = [](const std::string& geometry) {
    const Robot robot = sdf::parse_robot(model("<link name='a'>" + collision(geometry) + "</link>"));
    return robot.mechanism.links[0].solids.size();
  };
  EXPECT_EQ(count(kBox), 1u);
  EXPECT_EQ(count("<cylinder><radius>1</radius><length>2</length></cylinder>"), 5u);
  EXPECT_EQ(count("<sphere><radius>1</radius></sphere>"), 1u);
  EXPECT_EQ(count("<capsule><radius>1</radius><length>2</length></capsule>"), 1u);
  EXPECT_EQ(count("<ellipsoid><radii>1 2 3</radii></ellipsoid>"), 9u);
  EXPECT_EQ(count("<mesh><uri>file://" + kMeshes + "hand.obj</uri><scale>0.001 0.001 0.001</scale></mesh>"),
            1u);
  EXPECT_EQ(count("<empty/>"), 0u);
}

// A sphere's hexahedra are c.0, c.1, ...: a box of such a name comes before or behind them.
TEST(Sdf, HexahedraHaveNamesOfTheirOwn) {
  const std::string sphere = collision("<sphere><radius>1</radius></sphere>");
  const std::string box = "<collision name='c.2'><geometry>" + kBox + "</geometry></collision>";
  for (const std::string& shapes : {sphere + box, box + sphere, sphere + sphere + box}) {
    const Robot robot = sdf::parse_robot(model("<link name='a'>" + shapes + "</link>"));
    std::set<std::string> names;
    for (const auto& solid : robot.mechanism.links[0].solids)
      EXPECT_TRUE(names.insert(solid.name).second) << solid.name;
  }
}

TEST(Sdf, AJointToTheWorldHoldsIt) {
  const Mechanism arm(sdf::parse_robot(model("<link name='a'><pose>0 0 2 0 0 0</pose>" + collision(kBox) +
                                             "</link><joint name='j' type='prismatic'><parent>world</parent>"
                                             "<child>a</child><axis><xyz>0 0 1</xyz></axis></joint>"))
                          .mechanism);
  EXPECT_EQ(arm.links()[arm.base()].name, "world");
  EXPECT_LE(norm(middle(arm, 0.5, 0) - Vector3(0, 0, 2.5)), 1e-15);
}

std::string error(const std::string& xml) {
  return refusal_of([&] { const Mechanism arm(sdf::parse_robot(xml, "r.sdf").mechanism); });
}

std::string shape_error(const std::string& geometry) {
  return error(model("<link name='a'>" + collision(geometry) + "</link>"));
}

TEST(Sdf, BadFilesAreRefusedByLine) {
  // A document is XML with a model that has links, and its files are there.
  EXPECT_THAT(error("no xml"), HasSubstr("r.sdf:"));
  EXPECT_THAT(error(model("<link name='a'>")), HasSubstr("r.sdf:"));
  EXPECT_THAT(error("<robot/>"), HasSubstr("r.sdf: no <sdf>"));
  EXPECT_THAT(error("<sdf version='1.9'/>"), HasSubstr("r.sdf: no <model>"));
  EXPECT_THAT(error(model("")), HasSubstr("r.sdf:2: <model> 'arm': has no link"));
  EXPECT_THAT(error(model("<include><uri>a</uri></include>")),
              HasSubstr("r.sdf:3: <include>: mesh 'a': there is no file a"));
  // Links and their poses.
  EXPECT_THAT(error(model("<link/>")), HasSubstr("r.sdf:3: <link>: has no name"));
  EXPECT_THAT(error(model("<link name='a'><pose>0 0 nan 0 0 0</pose></link>")),
              HasSubstr("'nan' is no finite"));
  EXPECT_THAT(error(model("<link name='a'><pose>0 0 0</pose></link>")), HasSubstr("3 numbers where 6"));
  EXPECT_THAT(error(model("<link name='a'><pose relative_to='x'>0 0 0 0 0 0</pose></link>")),
              HasSubstr("there is no frame 'x'"));
  EXPECT_THAT(
      error(model("<link name='a'><pose relative_to='b'/></link><link name='b'><pose relative_to='a'/>"
                  "</link>")),
      HasSubstr("goes round in a ring"));
  // Joints are of a known type, join links that there are, and have a direction.
  EXPECT_THAT(error(model("<link name='a'/><link name='b'/><joint name='j' type='ball'><parent>a</parent>"
                          "<child>b</child></joint>")),
              HasSubstr("<joint> 'j': joints of type 'ball' are not supported"));
  EXPECT_THAT(error(model("<link name='a'/><joint name='j' type='fixed'><parent>a</parent><child>b</child>"
                          "</joint>")),
              HasSubstr("there is no link 'b'"));
  EXPECT_THAT(error(two_links("<xyz>0 0 0</xyz>")), HasSubstr("the axis has no direction"));
}

TEST(Sdf, BadShapesAreRefusedByLink) {
  EXPECT_THAT(shape_error("<plane><normal>0 0 1</normal></plane>"), HasSubstr("<plane>: is no shape"));
  EXPECT_THAT(shape_error("<box><size>1 0 1</size></box>"), HasSubstr("r.sdf:3: link 'a', collision 'c'"));
  EXPECT_THAT(
      shape_error("<mesh><uri>file://" + kMeshes + "hand.obj</uri><scale>1e308 1e308 1e308</scale></mesh>"),
      HasSubstr("hand.obj: its scaled coordinates are not finite"));
  EXPECT_THAT(shape_error("<sphere/>"), HasSubstr("<sphere>: has no <radius>"));
  EXPECT_THAT(shape_error("<mesh><uri>model://x/../../a.stl</uri></mesh>"), HasSubstr("leaves its package"));
  EXPECT_THAT(shape_error("<mesh><uri>model://nowhere/a.stl</uri></mesh>"), HasSubstr("not found"));
}

/// A folder of models: `palm`, a link with a box and a mesh beside its file; `hand`, which includes it.
class SdfInclude : public FolderTest {
 protected:
  SdfInclude() {
    std::filesystem::create_directories(folder_ / "palm/meshes");
    std::filesystem::create_directories(folder_ / "hand");
    std::filesystem::copy_file(kMeshes + "hand.obj", folder_ / "palm/meshes/hand.obj");
    write("palm/model.config",
          "<model><sdf version='1.4'>old.sdf</sdf><sdf version='1.10'>palm.sdf</sdf></model>");
    write(
        "palm/palm.sdf",
        "<sdf version='1.9'><model name='palm'><link name='bone'><pose>0 0 1 0 0 0</pose>" + collision(kBox) +
            "<collision name='m'><geometry><mesh><uri>meshes/hand.obj</uri>" +
            "<scale>0.001 0.001 0.001</scale></mesh></geometry></collision></link><link name='tip'/>" +
            "<joint name='j' type='revolute'><parent>bone</parent><child>tip</child><axis><xyz>1 0 0</xyz>" +
            "</axis></joint></model></sdf>");
  }
  Robot load(const std::string& body) const {
    return sdf::load_robot(write("robot.sdf", model("<link name='base'/>" + body)));
  }
  std::string error_of(const std::string& body) const {
    return refusal_of([&] { load(body); });
  }
  /// A fixed joint from the base to the link.
  static std::string held(const std::string& link) {
    return "<joint name='to " + link + "' type='fixed'><parent>base</parent><child>" + link +
           "</child></joint>";
  }
};

TEST_F(SdfInclude, BringsAModelTwiceUnderNamesOfItsOwn) {
  const Mechanism arm(load("<include><uri>model://palm</uri><name>left</name>"
                           "<pose degrees='true'>0 5 0 0 0 90</pose></include><include><uri>palm</uri>"
                           "<name>right</name></include>" +
                           held("left::bone") + held("right::bone"))
                          .mechanism);
  ASSERT_EQ(arm.links().size(), 5u);
  EXPECT_EQ(arm.links()[1].name, "left::bone");
  EXPECT_EQ(arm.links()[4].name, "right::tip");
  EXPECT_EQ(arm.value_count(), 2u);
  std::vector<Pose> X(arm.links().size());
  arm.link_poses({}, std::vector<double>{0, 0}, X);
  EXPECT_LE(norm(X[1].p - Vector3(0, 5, 1)), 1e-15);
  EXPECT_LE(norm(rotate(X[1].R, Vector3(1, 0, 0)) - Vector3(0, 1, 0)), 1e-15);
  EXPECT_LE(norm(X[3].p - Vector3(0, 0, 1)), 1e-15);
  EXPECT_LE(norm(rotate(X[2].R, Vector3(1, 0, 0)) - Vector3(0, 1, 0)), 1e-15);
}

TEST_F(SdfInclude, AMergedModelsLinksAreTheModelsOwn) {
  const Mechanism arm(load("<include merge='true'><uri>model://palm</uri><pose relative_to='base'>0 0 3 0 0 0"
                           "</pose></include>" +
                           held("bone"))
                          .mechanism);
  std::vector<Pose> X(arm.links().size());
  arm.link_poses({}, std::vector<double>{0}, X);
  EXPECT_LE(norm(X[arm.find_link("bone")].p - Vector3(0, 0, 4)), 1e-15);
}

TEST_F(SdfInclude, NestsAndNamesThePlaceOfWhatIsWrong) {
  write("hand/model.config", "<model><sdf>hand.sdf</sdf></model>");
  write("hand/hand.sdf",
        "<sdf version='1.9'><model name='hand'>\n<include><uri>model://palm</uri></include>"
        "</model></sdf>");
  const Robot robot = load("<include><uri>model://hand</uri></include>" + held("hand::palm::bone"));
  EXPECT_EQ(robot.mechanism.links[1].name, "hand::palm::bone");
  write("hand/hand.sdf",
        "<sdf version='1.9'><model name='hand'>\n<include><uri>model://nowhere</uri>"
        "</include></model></sdf>");
  EXPECT_THAT(error_of("<include><uri>model://hand</uri></include>"),
              AllOf(HasSubstr("hand.sdf:2: <include>: "), HasSubstr("not found")));
}

TEST_F(SdfInclude, BadIncludesAreRefused) {
  write("robot.sdf", "");
  EXPECT_THAT(error_of("<include><uri>robot.sdf</uri></include>"), HasSubstr("in itself"));
  EXPECT_THAT(error_of("<include><uri>model://../palm</uri></include>"), HasSubstr("names no package"));
  write("palm/model.config", "<model><sdf>../robot.sdf</sdf></model>");
  EXPECT_THAT(error_of("<include><uri>model://palm</uri></include>"), HasSubstr("leaves its folder"));
  EXPECT_THAT(error_of("<include/>"), HasSubstr("has no <uri>"));
}

TEST_F(SdfInclude, AWorldsFirstModelMayBeIncluded) {
  const Robot robot = sdf::load_robot(
      write("world.sdf",
            "<sdf version='1.9'><world name='w'><include><uri>model://palm</uri></include></world></sdf>"));
  EXPECT_EQ(robot.mechanism.name, "palm");
  EXPECT_EQ(robot.mechanism.links[0].solids.size(), 2u);
}

}  // namespace
}  // namespace touchstone
