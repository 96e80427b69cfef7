#include "touchstone/adapters/scene_files/scene_file.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <iomanip>
#include <numbers>
#include <sstream>
#include <string>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/contact_core/scene/scene_instance.hpp"
#include "touchstone/tests/support/written_file.hpp"

namespace touchstone {
namespace {

constexpr const char* kHead =
    "name: s\nframe_rate: 10\ncontact_gap: 1e-9\npolicy: hold\nduration: 1\nobjects:\n";  // objects from line
                                                                                          // 7

std::filesystem::path written(const std::string& text) { return written_file(text, ".yaml"); }

// The error's line after the file's name, or "accepted".
std::string error_of(const std::string& text, const SceneParameters& parameters = {}) {
  return error_in_file(text, ".yaml", [&](const auto& path) { load_scene(path, parameters); });
}

std::string error_in_objects(const std::string& objects) { return error_of(kHead + objects); }

std::string turned_block_with_three_decimals() {
  const Pose X{rotation_from_quaternion(0.5, 0.4, -0.2, 0.6), {0.1, 0.2, 0.3}};
  const Hexahedron block = Hexahedron::from_size({1, 2, 3});
  std::ostringstream text;
  text << std::fixed << std::setprecision(3);
  for (int i : {5, 0, 3, 7, 1, 6, 2, 4}) {
    const Vector3 p = transform(X, block.vertices()[i]);
    text << (i == 5 ? "[" : ", [") << p.x() << ", " << p.y() << ", " << p.z() << "]";
  }
  return text.str();
}

TEST(SceneFile, ReadsUnitsPosesGroupsAndExemptions) {
  // Units, parameters, groups, and exemptions of a group and of a hexahedron.
  const Scene scene = load_scene(
      written("name: s\nunits: {length: mm, angle: deg}\nparameters: {side: 2000, turn: 90}\nframe_rate: "
              "4\ncontact_gap: 1e-6\n"
              "policy: slide\nduration: 2.5\nobjects:\n"
              "  - name: a\n    groups: [jaws]\n    pose: {position: [1000, 0, 0], rpy: [0, 0, $turn]}\n"
              "    hexahedra:\n      - {name: x, box: {size: [$side, 1000, 1000]}}\n"
              "      - {name: y, pose: {position: [0, 0, 500]}, frustum: {bottom: [500, 250], top: 0, "
              "height: 1000}}\n"
              "  - name: b\n    hexahedra: [{name: x, box: {size: [10, 10, 10]}}]\n"
              "  - name: c\n    groups: [jaws]\n    hexahedra: [{name: x, box: {size: [10, 10, 10]}}]\n"
              "exempt: [[jaws, b], [a/y, c]]\n"));
  // Lengths are in metres, angles in radians.
  EXPECT_EQ(scene.policy, ContactPolicy::slide);
  EXPECT_DOUBLE_EQ(scene.contact_gap, 1e-9);
  EXPECT_EQ(scene.frame_count(), 11u);
  const SceneObject& a = scene.objects[0];
  EXPECT_EQ(a.X_WO.p, Vector3(1, 0, 0));
  EXPECT_NEAR(a.X_WO.R(1, 0), 1.0, 1e-16);
  EXPECT_EQ(a.tree.solids()[0].solid.half_extents(), Vector3(1.0, 0.5, 0.5));
  // All pairs but one are exempt.
  const SceneInstance instance(scene);
  EXPECT_EQ(instance.solid_name(1), "a/y");
  EXPECT_TRUE(instance.is_exempt(0, 1));  // one object
  EXPECT_TRUE(instance.is_exempt(2, 0));
  EXPECT_TRUE(instance.is_exempt(2, 3));
  EXPECT_TRUE(instance.is_exempt(1, 3));
  EXPECT_FALSE(instance.is_exempt(0, 3));
  EXPECT_EQ(instance.checked_pairs(), (std::vector<SolidPair>{{0, 3}}));
}

TEST(SceneFile, ReadsRoundedSolids) {
  const Scene scene = load_scene(
      written(std::string("units: {length: mm}\n") + kHead +
              "  - name: a\n    hexahedra:\n      - {name: ball, sphere: {radius: 250}}\n"
              "      - {name: rod, pose: {position: [0, 0, 9]}, capsule: {radius: 100, length: 600}}\n"
              "      - {name: lid, rounded_box: {core_size: [300, 200, 0], radius: 50}}\n"));
  const std::vector<PlacedHexahedron>& solids = scene.objects[0].tree.solids();
  ASSERT_EQ(solids.size(), 3u);
  EXPECT_EQ(solids[0].solid.radius(), 0.25);
  EXPECT_EQ(solids[0].solid.size(), 0.0);
  EXPECT_EQ(solids[1].solid.radius(), 0.1);
  EXPECT_EQ(solids[1].solid.half_extents(), Vector3(0, 0, 0.3));
  EXPECT_EQ(solids[1].X_OS.p.z(), 0.009);
  EXPECT_EQ(solids[2].solid.radius(), 0.05);
  EXPECT_EQ(solids[2].solid.half_extents(), Vector3(0.15, 0.1, 0));
}

TEST(SceneFile, RefusesBadRoundedSolids) {
  const auto error_with = [](const std::string& shape) {
    return error_in_objects("  - name: a\n    hexahedra:\n      - {name: h, " + shape + "}\n");
  };
  EXPECT_EQ(error_with("sphere: {radius: 0}"), "9: object 'a': hexahedron 'h': radius is 0, must be > 0");
  EXPECT_EQ(error_with("sphere: {diameter: 1}"),
            "9: object 'a': hexahedron 'h': sphere: unknown key 'diameter'; known: radius");
  EXPECT_EQ(error_with("capsule: {radius: 1, length: -1}"),
            "9: object 'a': hexahedron 'h': length is -1, must be >= 0");
  EXPECT_EQ(error_with("rounded_box: {size: [1, 1, 1], radius: 1}"),
            "9: object 'a': hexahedron 'h': rounded_box: unknown key 'size'; known: core_size, radius");
}

TEST(SceneFile, ReadsLevelsAndRefusesWhatDoesNotHoldTheObject) {
  const auto object_with = [](const std::string& level) {
    return "  - name: a\n    hexahedra: [{name: h, box: {size: [1, 1, 1]}}]\n    levels:\n" + level;
  };
  const std::string two =
      "      - [{name: x, box: {size: [1, 2, 1]}}]\n      - [{name: x, box: {size: [1, 2, 2]}}]\n";
  const Scene scene =
      load_scene(written(kHead + object_with(two) + "    copies: {count: [2, 1, 1], spacing: [9, 9, 9]}\n"));
  ASSERT_EQ(scene.objects.size(), 2U);
  for (const SceneObject& object : scene.objects) {
    ASSERT_EQ(object.levels.size(), 2U);
    EXPECT_EQ(object.levels[1]->solids()[0].solid.half_extents(), Vector3(0.5, 1, 1));
  }
  EXPECT_EQ(error_in_objects(object_with("      - [{name: x, box: {size: [1, 1, 0.999]}}]\n")),
            "10: object 'a': hexahedron 'h' (index 0) of level 0 lies in no hexahedron of level 1");
  EXPECT_EQ(error_in_objects(object_with("      - []\n")), "10: object 'a': levels: no hexahedron");
}

TEST(SceneFile, ParametersAreOverriddenByTheCaller) {
  const std::string text =
      std::string("parameters: {side: 2}\n") + kHead +
      "  - {name: a, hexahedra: [{name: x, box: {size: [$side, 1, 1]}}], pose: {position: [-$side, 0, 0]}}\n";
  const Scene scene = load_scene(written(text), {{"side", 3.0}});
  EXPECT_EQ(scene.objects[0].tree.solids()[0].solid.half_extents().x(), 1.5);
  EXPECT_EQ(scene.objects[0].X_WO.p.x(), -3.0);
  EXPECT_EQ(scene.parameters.at("side"), 3.0);
  EXPECT_EQ(error_of(text, {{"width", 1.0}}), " the scene has no parameter 'width'; known: side");
  EXPECT_EQ(error_of(text, {{"side", std::nan("")}}), " parameter 'side' is not finite");
}

TEST(SceneFile, RingIsWatertightAndInscribedOrCircumscribed) {
  for (const char* convention : {"inscribed", "circumscribed"}) {
    const Scene scene =
        load_scene(written(std::string(kHead) +
                           "  - name: a\n    hexahedra: [{name: r, ring: {outer_radius: 2, inner_radius: 1, "
                           "height: 1, facets: 7, radius: " +
                           convention + "}}]\n"));
    const auto& solids = scene.objects[0].tree.solids();
    ASSERT_EQ(solids.size(), 7u);
    const double c = std::cos(std::numbers::pi / 7);
    const bool inscribed = std::string(convention) == "inscribed";
    // Facet 0: corners at +-pi/7, midpoint on +x.
    EXPECT_NEAR(solids[0].solid.vertices()[0].x(), inscribed ? c : 1.0, 1e-15);
    EXPECT_NEAR(scene.facet_figures[0].error, 2 * (inscribed ? 1 - c : 1 / c - 1), 1e-15);
    const auto has = [](const Hexahedron& solid, const Vector3& p) {
      for (const Vector3& v : solid.vertices())
        if (v == p) return true;
      return false;
    };
    for (int i = 0; i < 7; ++i) {
      int shared = 0;
      for (const Vector3& v : solids[i].solid.vertices()) shared += has(solids[(i + 1) % 7].solid, v);
      EXPECT_EQ(shared, 4) << i;
    }
  }
}

TEST(SceneFile, WarpedBeyondTheToleranceOnlyWhenAsked) {
  const std::string object =
      "  - name: a\n    hexahedra:\n      - name: h\n        hexahedron:\n"
      "          vertices: [[-1,-1,-1],[-1,-1,1],[-1,1,-1],[-1,1,1],[1,-1,-1],[1,-1,1],[1,1,-1],[1,1,1.5]]\n";
  EXPECT_EQ(
      error_in_objects(object),
      "9: object 'a': hexahedron 'h': face 5 (vertices 1 5 7 3) is warped: a vertex is 0.123091 m out of "
      "plane, tolerated up to 0.0377494 m; accept warped solids explicitly to have them checked "
      "triangulated");
  EXPECT_EQ(error_in_objects(object + "          warped: within_tolerance\n"), error_in_objects(object));
  EXPECT_EQ(error_in_objects(object + "          warped: accept\n"), "accepted");
  EXPECT_EQ(error_in_objects(object + "          warped: yes\n"),
            "12: object 'a': hexahedron 'h': hexahedron: warped: unknown choice 'yes'; known: refuse, "
            "within_tolerance, accept");
}

// A block of 1 x 2 x 3 m turned, its corners with three decimals and out of order.
TEST(SceneFile, CornersAsFilesWriteThemLoadInAnyOrder) {
  const std::string object =
      "  - name: a\n    hexahedra:\n      - name: h\n        hexahedron:\n"
      "          vertices: [" +
      turned_block_with_three_decimals() + "]\n";
  const Scene scene = load_scene(written(std::string(kHead) + object));
  const Hexahedron& solid = scene.objects[0].tree.solids()[0].solid;
  EXPECT_TRUE(solid.is_warped());
  EXPECT_GT(solid.out_of_plane(), 1e-5);
  EXPECT_LT(solid.out_of_plane(), 9e-4);
  EXPECT_NE(error_in_objects(object + "          warped: refuse\n").find("planar up to"), std::string::npos);
}

TEST(SceneFile, ErrorsNameFileLineObjectAndHexahedron) {
  // Sizes are three finite positive numbers.
  EXPECT_EQ(
      error_in_objects("  - name: a\n    hexahedra:\n      - name: h\n        box: {size: [1, -2, 1]}\n"),
      "9: object 'a': hexahedron 'h': size along y is -2, must be > 0");
  EXPECT_EQ(error_in_objects(
                "  - name: a\n    hexahedra:\n      - name: h\n        box:\n          size: [1, .nan, 1]\n"),
            "11: object 'a': hexahedron 'h': box: size: not finite: .nan");
  EXPECT_EQ(error_in_objects(
                "  - name: a\n    hexahedra:\n      - name: h\n        box:\n          size: [1, 2]\n"),
            "11: object 'a': hexahedron 'h': box: size: expected 3 numbers, got 2");
  EXPECT_EQ(error_in_objects(
                "  - name: a\n    hexahedra:\n      - name: h\n        box:\n          size: [1, two, 1]\n"),
            "11: object 'a': hexahedron 'h': box: size: expected a number, got 'two'");
  EXPECT_EQ(
      error_in_objects(
          "  - name: a\n    hexahedra:\n      - name: h\n        box:\n          size: [1, \"2\", 1]\n"),
      "11: object 'a': hexahedron 'h': box: size: expected a number, got the text '2'");
  EXPECT_EQ(
      error_in_objects(
          "  - name: a\n    hexahedra:\n      - name: h\n        box:\n          size: [1, 1e400, 1]\n"),
      "11: object 'a': hexahedron 'h': box: size: beyond the range of a double: 1e400");
  // Parameters, keys and shapes.
  EXPECT_EQ(error_in_objects(
                "  - name: a\n    hexahedra:\n      - name: h\n        box:\n          size: [1, $w, 1]\n"),
            "11: object 'a': hexahedron 'h': box: size: unknown parameter '$w'; known: none");
  EXPECT_EQ(
      error_in_objects("  - name: a\n    hexahedra:\n      - name: h\n        cone: 1\n"),
      "10: object 'a': unknown key 'cone'; known: name, pose, box, hexahedron, frustum, ring, walls, sphere, "
      "capsule, rounded_box");
  EXPECT_EQ(error_in_objects("  - name: a\n    hexahedra:\n      - name: h\n"),
            "9: object 'a': hexahedron 'h': needs exactly one of box, hexahedron, frustum, ring, walls, "
            "sphere, capsule, rounded_box; has 0");
  EXPECT_EQ(error_in_objects(
                "  - name: a\n    hexahedra:\n      - {name: h, hexahedron: {vertices: [[0, 0, 0]]}}\n"),
            "9: object 'a': hexahedron 'h': has 1 vertices, a hexahedron has 8");
}

TEST(SceneFile, RefusesWhatOccursTwice) {
  const std::string box = "{name: h, box: {size: [1, 1, 1]}}";
  EXPECT_EQ(
      error_in_objects("  - {name: a, hexahedra: [" + box + "]}\n  - {name: a, hexahedra: [" + box + "]}\n"),
      "8: object 'a': the name occurs twice");
  EXPECT_EQ(error_in_objects("  - name: a\n    hexahedra:\n      - " + box + "\n      - " + box + "\n"),
            "10: object 'a': hexahedron 'h': the name occurs twice in the object");
  EXPECT_EQ(error_of(std::string("name: s\n") + kHead + "  - {name: a, hexahedra: [" + box + "]}\n"),
            "2: key 'name' occurs twice");
}

TEST(SceneFile, RefusesBadReferencesPosesAndMotions) {
  const std::string a = "  - name: a\n    hexahedra: [{name: h, box: {size: [1, 1, 1]}}]\n";
  EXPECT_EQ(error_in_objects(a + "exempt:\n  - [a, b]\n"),
            "10: exempt: 'b' names no object, object/hexahedron or group of the scene");
  EXPECT_EQ(error_in_objects(a + "    pose: {quaternion_wxyz: [0, 0, 0, 0]}\n"),
            "9: object 'a': pose: quaternion_wxyz: the quaternion is zero");
  EXPECT_EQ(
      error_in_objects(a + "    pose:\n      matrix: [[2,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]\n"),
      "10: object 'a': pose: matrix: pose: not a rotation: columns are off orthonormal by 3, allowed 1e-06");
  EXPECT_EQ(error_in_objects(a + "    motion:\n      segments: [{duration: -1}]\n"),
            "10: object 'a': motion segment 0: the duration is not a time > 0");
  EXPECT_EQ(error_in_objects(a + "    motion:\n      segments: [{rotation: {axis: [0, 0, 0], rate: 1}}]\n"),
            "10: object 'a': motion: segments: rotation: axis: the axis is zero");
}

TEST(SceneFile, ReadsLatches) {
  const std::string box = "hexahedra: [{name: h, box: {size: [1, 1, 1]}}]";
  const std::string turning = "motion: {segments: [{rotation: {axis: [0, 0, 1], rate: 1}}]}";
  const Scene scene = load_scene(written(
      std::string(kHead) + "  - {name: arm, " + box + ", " + turning + "}\n  - {name: oru, pose: " +
      "{position: [2, 0, 0]}, " + box + "}\n  - {name: lid, pose: {position: [4, 0, 0]}, " + box +
      "}\n  - {name: wall, pose: {position: [9, 0, 0]}, " + box + "}\nlatches:\n" +
      "  - {carrier: oru, carried: lid}\n  - {carrier: arm, carried: oru, allowed: [[arm, wall/h]]}\n"));
  ASSERT_EQ(scene.latches.size(), 2u);
  EXPECT_EQ(scene.latches[1].carrier, "arm");
  EXPECT_EQ(scene.latches[1].allowed[0].second, "wall/h");
  const SceneInstance instance(scene);
  // Solids that move as one are not checked, nor are those that the latch allows.
  EXPECT_EQ(instance.checked_pairs(), (std::vector<SolidPair>{{1, 3}, {2, 3}}));
  std::vector<Pose> poses(4);
  instance.poses_at(0.5, poses);
  EXPECT_NEAR(poses[2].p.x(), 4 * std::cos(0.5), 1e-15);
  EXPECT_NEAR(poses[2].p.y(), 4 * std::sin(0.5), 1e-15);
}

TEST(SceneFile, RefusesBadLatches) {
  const auto error_with = [](const std::string& latches) {
    const std::string box = "hexahedra: [{name: h, box: {size: [1, 1, 1]}}]";
    return error_in_objects("  - {name: a, " + box + "}\n  - {name: b, " + box + "}\n  - {name: c, " + box +
                            ", motion: {segments: [{velocity: [1, 0, 0]}]}}\nlatches:\n" + latches);
  };
  EXPECT_EQ(error_with("  - {carrier: a, carried: b}\n"), "accepted");
  EXPECT_EQ(error_with("  - {carrier: a}\n"), "11: latches: missing 'carried'");
  EXPECT_EQ(error_with("  - {carrier: a, carried: b, until: 3}\n"),
            "11: latches: unknown key 'until'; known: carrier, carried, allowed");
  EXPECT_EQ(error_with("  - {carrier: a, carried: d}\n"),
            "11: latch of 'd' to 'a': 'd' names no object of the scene");
  EXPECT_EQ(error_with("  - {carrier: a, carried: c}\n"),
            "11: latch of 'c' to 'a': 'c' has a motion of its own");
  EXPECT_EQ(error_with("  - {carrier: a, carried: a}\n"), "11: latch of 'a' to 'a': closes a cycle");
  EXPECT_EQ(error_with("  - {carrier: a, carried: b}\n  - {carrier: b, carried: a}\n"),
            "12: latch of 'a' to 'b': closes a cycle");
  EXPECT_EQ(error_with("  - {carrier: a, carried: b}\n  - {carrier: c, carried: b}\n"),
            "12: latch of 'b' to 'c': 'b' is already carried by 'a'");
  EXPECT_EQ(error_with("  - carrier: a\n    carried: b\n    allowed:\n      - [a, x]\n"),
            "14: exempt: 'x' names no object, object/hexahedron or group of the scene");
}

TEST(SceneFile, RefusesBadHeads) {
  EXPECT_EQ(error_of("name: s\n"), "1: missing 'frame_rate'");
  EXPECT_EQ(error_of("name: s\nframe_rate: 0\n"), "2: frame_rate: must be > 0");
  EXPECT_EQ(error_of("name: s\nframe_rate: 1\ncontact_gap: 1e-9\nduration: 1\npolicy: stop\n"),
            "5: policy: unknown policy 'stop'; known: cue, hold, advance, slide");
  EXPECT_EQ(error_of("units: {length: ft}\n"), "1: units: length: unknown unit 'ft'; known: m, mm");
  EXPECT_EQ(error_of("name: [a\n"), "2: malformed YAML: end of sequence flow not found");
  EXPECT_NE(error_of("").find("expected a map with the keys name, "), std::string::npos);
  EXPECT_EQ(error_of("name: s\n---\nname: t\n"), "2: expected one YAML document, here it ends");
  EXPECT_NE(error_of("# a comment\n, stray\nname: s\n"), "accepted");  // yaml-cpp's LoadAll never returns
  EXPECT_EQ(error_of("- a\n"),
            "1: expected a map with the keys name, description, units, parameters, frame_rate, "
            "contact_gap, policy, passive, duration, objects, rules, exempt, latches, dynamics, got a list");
  try {
    load_scene("/nonexistent/scene.yaml");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(), "/nonexistent/scene.yaml: cannot be read");
  }
}

}  // namespace
}  // namespace touchstone
