#include "touchstone/adapters/scene_files/dynamics_file.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <string>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/tests/support/degree.hpp"
#include "touchstone/tests/support/written_file.hpp"

namespace touchstone {
namespace {

// Three boxes; dynamics from line 15 on.
constexpr const char* kHead =
    "name: s\n"
    "units: {length: mm, angle: deg}\n"
    "parameters: {mass: 2}\n"
    "frame_rate: 10\n"
    "contact_gap: 1e-6\n"
    "policy: cue\n"
    "duration: 1\n"
    "objects:\n"
    "  - {name: a, pose: {position: [0, 0, 0]}, hexahedra: [{name: x, box: {size: [100, 200, 300]}}]}\n"
    "  - {name: b, pose: {position: [1000, 0, 0]}, hexahedra: [{name: x, box: {size: [100, 200, 300]}}]}\n"
    "  - {name: c, pose: {position: [2000, 0, 0]}, hexahedra: [{name: x, box: {size: [100, 200, 300]}}]}\n"
    "  - name: d\n"
    "    hexahedra: [{name: x, pose: {position: [0, 0, 5000]}, box: {size: [100, 100, 100]}}]\n"
    "    motion: {segments: [{velocity: [1, 0, 0]}]}\n";

std::filesystem::path written(const std::string& text) { return written_file(text, ".yaml"); }

physics::DynamicScene loaded(const std::string& dynamics, const SceneParameters& parameters = {}) {
  return load_dynamic_scene(written(kHead + dynamics), parameters);
}

// The error's line after the file's name, or "accepted".
std::string error_of(const std::string& dynamics) {
  return error_in_file(kHead + dynamics, ".yaml", [](const auto& path) { load_dynamic_scene(path); });
}

std::string error_in_body(const std::string& body) {
  return error_of("dynamics:\n  step: 0.1\n  bodies:\n    - {object: a, " + body + "}\n");
}

std::string error_in_joint(const std::string& joint) {
  return error_of(
      "dynamics:\n  step: 0.1\n  bodies: [{object: a, mass: 1}]\n  mechanisms:\n    - name: m\n"
      "      joints:\n        - {name: j, " +
      joint + "}\n");
}

// All keys of a scene's dynamics.
constexpr const char* kWhole =
    "dynamics:\n"
    "  gravity: [0, 0, -9810]\n"
    "  step: 0.01\n"
    "  contact_margin: 2\n"
    "  friction: 0.25\n"
    "  restitution: 0.125\n"
    "  bounce_speed: 3\n"
    "  push_out: 4\n"
    "  part_speed: 5\n"
    "  sleep_speed: 6\n"
    "  sleep_time: 0.5\n"
    "  bodies:\n"
    "    - {object: a, kind: dynamic, mass: $mass, velocity: [10, 0, 0], turn: [0, 90, 0], friction: 1}\n"
    "    - {object: b, mass: 3, inertia: {centre: [10, 0, 0], moments: [1, 2, 2.5], products: [0.1, 0.2, "
    "0.3]}}\n"
    "    - {object: c, mass: 12, inertia: {rod: [[-500, 0, 0], [500, 0, 0]]}}\n"
    "  mechanisms:\n"
    "    - name: m\n"
    "      joints:\n"
    "        - {name: turn, kind: revolute, child: b, position: [1000, 0, 0], axis: [0, 0, 2], value: 30, "
    "rate: 6,\n"
    "           limits: {position: [-90, 45], rate: 60, torque: 7}, drive: {brake: 5}}\n"
    "        - {name: shift, kind: prismatic, parent: b, child: c, axis: [1, 0, 0], value: 100,\n"
    "           drive: {torque: 2, ramp: 3, limit: 8}}\n"
    "  actions:\n"
    "    - {time: 0.25, drive: {joint: m.turn, rate: 9, limit: 2}}\n"
    "    - {time: 0.5, latch: {carrier: b, carried: a}}\n"
    "    - {time: 0.75, release: a}\n"
    "  conserved: [momentum, angular_momentum_y, energy]\n"
    "  accept: {depth: 1, position: 2, angle: 3, energy_made: 0.5, drift: 0.25}\n"
    "  answers:\n"
    "    - {of: a, figure: velocity, time: 0.2, value: [10, 0, 0], tolerance: 1}\n"
    "    - {of: m.turn, figure: value, value: 30, tolerance: 1}\n"
    "    - {figure: stopped, value: 0.3, tolerance: 0.1}\n";

TEST(DynamicsFile, ReadsSettingsInTheFilesUnits) {
  const physics::DynamicScene scene = loaded(kWhole);
  EXPECT_DOUBLE_EQ(scene.gravity_W.z(), -9.81);
  EXPECT_EQ(scene.step_count(), 100u);
  EXPECT_DOUBLE_EQ(scene.contact_margin, 0.002);
  EXPECT_DOUBLE_EQ(scene.bounce_speed, 0.003);
  EXPECT_EQ(scene.push_out, 4.0);
  EXPECT_DOUBLE_EQ(scene.part_speed, 0.005);
  EXPECT_DOUBLE_EQ(scene.sleep_speed, 0.006);
  EXPECT_EQ(scene.sleep_time, 0.5);
}

TEST(DynamicsFile, ReadsBodiesInTheFilesUnits) {
  using physics::BodyKind;
  const physics::DynamicScene scene = loaded(kWhole);
  EXPECT_EQ(scene.bodies[0].kind, BodyKind::dynamic);
  EXPECT_EQ(scene.bodies[1].kind, BodyKind::link);
  EXPECT_EQ(scene.bodies[3].kind, BodyKind::kinematic);
  EXPECT_EQ(scene.bodies[0].surface.friction, 1.0);
  EXPECT_EQ(scene.bodies[3].surface.friction, 0.25);
  EXPECT_EQ(scene.bodies[0].surface.restitution, 0.125);
  // m (y^2 + z^2) / 12 of a box of 0.1 x 0.2 x 0.3 m.
  EXPECT_NEAR(scene.bodies[0].inertia.inertia_B(0, 0), 2.0 * 0.13 / 12.0, 1e-16);
  EXPECT_DOUBLE_EQ(scene.bodies[0].v_W.x(), 0.01);
  EXPECT_NEAR(scene.bodies[0].w_W.y(), 90 * kDegree, 1e-15);
  EXPECT_DOUBLE_EQ(scene.bodies[1].inertia.centre_B.x(), 0.01);
  EXPECT_EQ(scene.bodies[1].inertia.inertia_B(0, 2), 0.2);
  EXPECT_EQ(scene.bodies[1].inertia.inertia_B(2, 1), 0.3);
  EXPECT_NEAR(scene.bodies[2].inertia.inertia_B(1, 1), 1.0, 1e-15);  // 12 kg, 1 m
  EXPECT_EQ(scene.bodies[2].inertia.inertia_B(0, 0), 0.0);
}

TEST(DynamicsFile, ReadsJointsAndDrivesInTheFilesUnits) {
  const physics::DynamicScene scene = loaded(kWhole);
  const physics::SceneJoint& turn = scene.mechanisms[0].joints[0];
  EXPECT_EQ(turn.parent, kNoObject);
  EXPECT_EQ(turn.child, 1u);
  EXPECT_DOUBLE_EQ(turn.p_W.x(), 1.0);
  EXPECT_EQ(turn.axis_W, Vector3(0, 0, 1));
  EXPECT_NEAR(turn.value, 30 * kDegree, 1e-15);
  EXPECT_NEAR(turn.rate, 6 * kDegree, 1e-15);
  EXPECT_NEAR(turn.upper, 45 * kDegree, 1e-15);
  EXPECT_NEAR(turn.most_rate, 60 * kDegree, 1e-15);
  EXPECT_EQ(turn.effort, 7.0);
  EXPECT_EQ(turn.drive.drive.mode, physics::JointDrive::Mode::brake);
  EXPECT_EQ(turn.drive.drive.limit, 5.0);
  const physics::SceneJoint& shift = scene.mechanisms[0].joints[1];
  EXPECT_EQ(shift.parent, 1u);
  EXPECT_DOUBLE_EQ(shift.value, 0.1);
  EXPECT_EQ(shift.p_W, Vector3(2, 0, 0));  // left out: where the child stands
  EXPECT_EQ(shift.drive.ramp, 3.0);
}

TEST(DynamicsFile, ReadsActionsAndAnswersInTheFilesUnits) {
  const physics::DynamicScene scene = loaded(kWhole);
  ASSERT_EQ(scene.actions.size(), 3u);
  EXPECT_NEAR(scene.actions[0].drive.drive.rate, 9 * kDegree, 1e-15);
  EXPECT_EQ(scene.actions[1].carrier, 1u);
  EXPECT_EQ(scene.actions[2].kind, physics::SceneAction::Kind::release);
  EXPECT_TRUE(scene.conserved.linear && scene.conserved.angular[1] && scene.conserved.energy);
  EXPECT_FALSE(scene.conserved.angular[0] || scene.conserved.angular[2]);
  EXPECT_DOUBLE_EQ(scene.accept.position, 0.002);
  EXPECT_NEAR(scene.accept.angle, 3 * kDegree, 1e-15);
  EXPECT_EQ(scene.accept.drift, 0.25);
  EXPECT_DOUBLE_EQ(scene.answers[0].value.x(), 0.01);
  EXPECT_NEAR(scene.answers[1].tolerance, kDegree, 1e-15);
  EXPECT_EQ(scene.answers[2].time, 1.0);
  EXPECT_TRUE(scene.answers_hold);
}

// A scene with copies, `more` their further keys.
std::string with_copies(const std::string& more, const std::string& object = "") {
  return "name: s\nframe_rate: 10\ncontact_gap: 1e-6\npolicy: cue\nduration: 1\nobjects:\n"
         "  - name: box\n    pose: {position: [1, 2, 3]}\n" +
         object + "    hexahedra: [{name: x, box: {size: [1, 1, 1]}}]\n    copies: {" + more +
         "}\ndynamics:\n  step: 0.1\n  bodies: [{object: box, kind: dynamic, mass: 2, velocity: [1, 0, 0]}]\n"
         "  accept: {position: any, angle: any, rest: 0.5}\n";
}

TEST(DynamicsFile, CopiesAreObjectsOfAGroupWithOneBodyEach) {
  const physics::DynamicScene scene = load_dynamic_scene(
      written(with_copies("count: [3, 2, 2], spacing: [10, 20, 30], layer_less: 1, layer_shift: [5, 0, 0]")));
  ASSERT_EQ(scene.scene.objects.size(), 3u * 2u + 2u * 2u);
  EXPECT_EQ(scene.scene.objects[0].tree.name(), "box 0");
  EXPECT_EQ(scene.scene.objects[9].tree.name(), "box 9");
  EXPECT_EQ(scene.scene.objects[4].X_WO.p, Vector3(11, 22, 3));
  EXPECT_EQ(scene.scene.objects[9].X_WO.p, Vector3(1 + 5 + 10, 22, 33));
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    EXPECT_EQ(scene.scene.objects[i].groups, (std::vector<std::string>{"box"}));
    EXPECT_EQ(scene.bodies[i].kind, physics::BodyKind::dynamic);
    EXPECT_EQ(scene.bodies[i].inertia.mass, 2.0);
    EXPECT_EQ(scene.bodies[i].v_W, Vector3(1, 0, 0));
  }
  EXPECT_TRUE(std::isinf(scene.accept.position) && std::isinf(scene.accept.angle));
  EXPECT_EQ(scene.accept.rest, 0.5);
}

TEST(DynamicsFile, CopiesTurnTheSameWayEveryTime) {
  const std::string text = with_copies("count: [4, 1, 1], spacing: [2, 2, 2], turned: 7");
  const physics::DynamicScene one = load_dynamic_scene(written(text)),
                              two = load_dynamic_scene(written(text));
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(one.scene.objects[i].X_WO.R, two.scene.objects[i].X_WO.R);
    EXPECT_NE(one.scene.objects[i].X_WO.R, Matrix3(Matrix3::Identity()));
  }
  EXPECT_NE(one.scene.objects[0].X_WO.R, one.scene.objects[1].X_WO.R);
}

TEST(DynamicsFile, BadCopiesAreNamed) {
  const auto error = [](const std::string& more, const std::string& object = "") {
    return error_in_file(with_copies(more, object), ".yaml",
                         [](const auto& path) { load_dynamic_scene(path); });
  };
  EXPECT_NE(error("count: [0, 1, 1], spacing: [1, 1, 1]").find("must be whole and >= 1"), std::string::npos);
  EXPECT_NE(error("count: [1.5, 1, 1], spacing: [1, 1, 1]").find("must be whole and >= 1"),
            std::string::npos);
  EXPECT_NE(error("count: [1000, 1000, 1], spacing: [1, 1, 1]").find("more than 100 000 copies"),
            std::string::npos);
  EXPECT_NE(error("count: [2, 1, 1]").find("spacing"), std::string::npos);
  EXPECT_NE(error("count: [2, 1, 1], spacing: [1, 1, 1]", "    motion: {segments: [{velocity: [1, 0, 0]}]}\n")
                .find("what has a motion has no copies"),
            std::string::npos);
}

TEST(DynamicsFile, AnswersHoldForTheFilesOwnParameters) {
  const std::string dynamics = "dynamics: {step: 0.1, bodies: [{object: a, kind: dynamic, mass: $mass}]}\n";
  EXPECT_TRUE(loaded(dynamics, {{"mass", 2.0}}).answers_hold);
  const physics::DynamicScene other = loaded(dynamics, {{"mass", 3.0}});
  EXPECT_FALSE(other.answers_hold);
  EXPECT_EQ(other.bodies[0].inertia.mass, 3.0);
}

TEST(DynamicsFile, ContactOnlyReadersPassTheDynamicsBy) {
  const Scene scene = load_scene(written(std::string(kHead) + "dynamics: {step: 0.1}\n"));
  EXPECT_EQ(scene.objects.size(), 4u);
  EXPECT_EQ(error_of(""), " the scene asks for no dynamics");
}

TEST(DynamicsFile, BadBodiesAreNamedWithFileAndLine) {
  // Masses are positive, and moments those of some solid.
  EXPECT_EQ(error_in_body("kind: dynamic, mass: 0"), "18: object 'a': the mass is 0, not a positive number");
  EXPECT_EQ(error_in_body("kind: dynamic, mass: -1"),
            "18: object 'a': the mass is -1, not a positive number");
  EXPECT_EQ(error_in_body("kind: dynamic, density: -2"),
            "18: object 'a': the density is -2, not a positive number");
  EXPECT_EQ(
      error_in_body("kind: dynamic, mass: 1, inertia: {moments: [1, 1, 3]}"),
      "18: object 'a': principal moments 1, 1, 3 kg m2: no solid has one larger than the sum of the others");
  EXPECT_EQ(error_in_body("kind: dynamic, mass: 1, inertia: {moments: [1, -1, 1]}"),
            "18: object 'a': principal moment -1 kg m2 is not positive");
  EXPECT_EQ(error_in_body("kind: dynamic, mass: 1, inertia: {point: [0, 0, 0]}"),
            "18: object 'a': principal moment 0 kg m2 is not positive");
  // Fields that are missing, unknown, or of another kind of body.
  EXPECT_EQ(error_in_body("kind: dynamic"), "18: object 'a': expected one of mass, density");
  EXPECT_EQ(error_in_body("kind: dynamic, mass: .nan"), "18: object 'a': mass: not finite: .nan");
  EXPECT_EQ(error_in_body("mass: 1"), "18: object 'a': missing 'kind'");
  EXPECT_EQ(error_in_body("kind: soft"),
            "18: object 'a': kind: unknown kind 'soft'; known: static, kinematic, dynamic");
  EXPECT_EQ(error_in_body("kind: static, mass: 1"), "18: object 'a': mass: is not asked of what is static");
  EXPECT_EQ(
      error_in_body("kind: kinematic, velocity: [1, 0, 0]"),
      "18: object 'a': velocity: only dynamic bodies start with one; kinematic ones have a motion, links "
      "joint rates");
  // Friction and restitution stay in range.
  EXPECT_EQ(error_in_body("kind: dynamic, mass: 1, friction: -0.5"),
            "18: object 'a': friction: must be >= 0");
  EXPECT_EQ(error_in_body("kind: dynamic, mass: 1, restitution: 1.5"),
            "18: object 'a': restitution: must be from 0 to 1");
  EXPECT_EQ(error_in_body("kind: dynamic, mass: 1, colour: red"),
            "18: dynamics: bodies: unknown key 'colour'; known: object, kind, mass, density, inertia, "
            "velocity, turn, friction, "
            "restitution");
  // A body needs an object, which does not move by itself where it is dynamic.
  EXPECT_EQ(error_of("dynamics:\n  step: 0.1\n  bodies:\n    - {object: z, kind: static}\n"),
            "18: dynamics: bodies: object: the scene has no object 'z'");
  EXPECT_EQ(error_of("dynamics:\n  step: 0.1\n  bodies:\n    - {object: d, kind: dynamic, mass: 1}\n"),
            "18: object 'd': has a motion, but is dynamic");
}

TEST(DynamicsFile, BadJointsAreNamedWithFileAndLine) {
  // A joint's limits enclose its value; torques, rates and brakes are not negative.
  const std::string good = "kind: revolute, child: a, position: [0, 0, 0], axis: [0, 0, 1]";
  EXPECT_EQ(error_in_joint(good), "accepted");
  const std::string joint = "21: mechanism 'm': joint 'j': ";
  EXPECT_EQ(error_in_joint(good + ", limits: {torque: -1}"), joint + "limits: torque: must be >= 0");
  EXPECT_EQ(error_in_joint(good + ", limits: {rate: -1}"), joint + "limits: rate: must be >= 0");
  EXPECT_EQ(error_in_joint(good + ", limits: {position: [1, -1]}"),
            joint + "the limits are crossed or not numbers");
  EXPECT_EQ(error_in_joint(good + ", value: 5, limits: {position: [-1, 1]}"),
            joint + "the value is out of its limits");
  EXPECT_EQ(error_in_joint(good + ", drive: {brake: -3}"), joint + "drive: brake: must be >= 0");
  EXPECT_EQ(error_in_joint(good + ", drive: {rate: 1, torque: 2}"),
            joint + "drive: expected one of torque, rate, brake, position");
  // Its objects and its axis.
  EXPECT_EQ(error_in_joint("kind: revolute, child: z, position: [0, 0, 0], axis: [0, 0, 1]"),
            joint + "child: the scene has no object 'z'");
  EXPECT_EQ(error_in_joint("kind: revolute, child: a, parent: a, position: [0, 0, 0], axis: [0, 0, 1]"),
            joint + "parent and child are one object");
  EXPECT_EQ(error_in_joint("kind: revolute, child: a, position: [0, 0, 0], axis: [0, 0, 0]"),
            joint + "axis: the axis is zero");
  EXPECT_EQ(error_in_joint("kind: ball, child: a"),
            joint + "kind: unknown kind 'ball'; known: fixed, revolute, prismatic");
  // Links that move by themselves, have no mass, or hang on what is not of the mechanism.
  EXPECT_EQ(
      error_of("dynamics:\n  step: 0.1\n  bodies: [{object: d, mass: 1}]\n  mechanisms:\n    - name: m\n"
               "      joints:\n"
               "        - {name: j, kind: revolute, child: d, position: [0, 0, 0], axis: [0, 0, 1]}\n"),
      "17: object 'd': has a motion, but is link");
  EXPECT_EQ(error_of("dynamics:\n  step: 0.1\n  mechanisms:\n    - {name: m, joints: []}\n"),
            "18: mechanism 'm': no joint");
  EXPECT_EQ(error_of("dynamics:\n  step: 0.1\n  mechanisms:\n    - name: m\n      joints:\n"
                     "        - {name: j, kind: revolute, child: a, position: [0, 0, 0], axis: [0, 0, 1]}\n"),
            "16: dynamics: object 'a' is a link: 'bodies' does not tell its mass");
  EXPECT_EQ(
      error_of(
          "dynamics:\n  step: 0.1\n  bodies: [{object: a, mass: 1}, {object: b, kind: dynamic, mass: 1}]\n"
          "  mechanisms:\n    - name: m\n      joints:\n"
          "        - {name: j, kind: revolute, parent: b, child: a, position: [0, 0, 0], axis: [0, 0, 1]}\n"),
      joint + "object 'b' is neither fixed nor a link of this mechanism");
  EXPECT_EQ(error_of("dynamics:\n  step: 0.1\n  bodies: [{object: a, mass: 0}]\n"
                     "  mechanisms:\n    - name: m\n      joints:\n"
                     "        - {name: j, kind: revolute, child: a, position: [0, 0, 0], axis: [0, 0, 1]}\n"),
            "accepted");  // read; SceneSimulation refuses a joint that moves no inertia
}

TEST(DynamicsFile, BadSettingsActionsAndAnswersAreNamedWithFileAndLine) {
  // A step is positive, divides the duration, and comes with a margin above the gap.
  EXPECT_EQ(error_of("dynamics: {step: 0}\n"), "15: dynamics: step: must be > 0");
  EXPECT_EQ(error_of("dynamics: {step: 0.3}\n"),
            "15: dynamics: step: does not divide the duration into whole steps");
  EXPECT_EQ(error_of("dynamics: {bodies: []}\n"), "15: dynamics: missing 'step'");
  EXPECT_EQ(error_of("dynamics: {step: 0.1, contact_margin: 1.0e-7}\n"),
            "15: dynamics: contact_margin: is not above the contact gap");
  // Actions are in order of time, and of objects and joints that can do so.
  const std::string start = "dynamics:\n  step: 0.1\n  bodies: [{object: a, kind: dynamic, mass: 1}]\n";
  EXPECT_EQ(error_of(start + "  actions:\n    - {time: 0, release: a}\n"),
            "19: release: object 'a' is not carried");
  EXPECT_EQ(error_of(start + "  actions:\n    - {time: 0, latch: {carrier: a, carried: b}}\n"),
            "19: latch: object 'b' is static: only dynamic ones are carried");
  EXPECT_EQ(error_of(start + "  actions:\n    - {time: 0, latch: {carrier: a, carried: a}}\n"),
            "19: latch: closes a cycle");
  EXPECT_EQ(error_of(start + "  actions:\n    - {time: 1, latch: {carrier: b, carried: a}}\n"
                             "    - {time: 0.5, release: a}\n"),
            "20: action: the time is before the action above, or is none");
  EXPECT_EQ(error_of(start + "  actions:\n    - {time: 0, drive: {joint: m.j, brake: 1}}\n"),
            "19: dynamics: actions: drive: joint: the scene has no joint 'm.j' (mechanism.joint)");
  // Answers ask for a figure that the body has, within a tolerance.
  EXPECT_EQ(error_of(start + "  answers:\n    - {of: b, figure: velocity, value: [0, 0, 0], tolerance: 1}\n"),
            "19: dynamics: answers: of: is not dynamic: it has no such figure");
  EXPECT_EQ(error_of(start + "  answers:\n    - {of: a, figure: velocity, value: [0, 0, 0], tolerance: 0}\n"),
            "19: dynamics: answers: tolerance: must be > 0");
  EXPECT_EQ(error_of(start + "  conserved: [mass]\n"),
            "18: dynamics: conserved: unknown 'mass'; known: momentum, angular_momentum, angular_momentum_x, "
            "_y, _z, energy");
}

TEST(DynamicsFile, PairsHaveFiguresOfTheirOwnAndScenesTheirRule) {
  // Rules and pairs are read.
  const physics::DynamicScene scene = loaded(
      "dynamics:\n"
      "  step: 0.1\n"
      "  combine: {friction: minimum, restitution: product}\n"
      "  pairs:\n"
      "    - {between: [a, b], friction: 0.25}\n"
      "    - {between: [b, c], friction: 0.5, restitution: 0.75}\n");
  EXPECT_EQ(scene.friction_rule, physics::Combination::minimum);
  EXPECT_EQ(scene.restitution_rule, physics::Combination::product);
  ASSERT_EQ(scene.pairs.size(), 2u);
  EXPECT_EQ(scene.pairs[0].a, 0u);
  EXPECT_EQ(scene.pairs[0].b, 1u);
  EXPECT_EQ(scene.pairs[0].friction, 0.25);
  EXPECT_FALSE(scene.pairs[0].restitution.has_value());
  EXPECT_EQ(scene.pairs[1].restitution, 0.75);
  // A pair of copies is each pair of them.
  EXPECT_EQ(load_dynamic_scene(written(with_copies("count: [3, 1, 1], spacing: [2, 2, 2]") +
                                       "  pairs: [{between: [box, box], friction: 0.1}]\n"))
                .pairs.size(),
            6u);
  // Pairs of one object, of none, without figures, and rules that there are not, are named.
  const std::string start = "dynamics:\n  step: 0.1\n  pairs:\n    - ";
  EXPECT_EQ(error_of(start + "{between: [a, a], friction: 1}\n"),
            "18: dynamics: pairs: between: an object is no pair with itself");
  EXPECT_EQ(error_of(start + "{between: [a, z], friction: 1}\n"),
            "18: dynamics: pairs: between: the scene has no object 'z'");
  EXPECT_EQ(error_of(start + "{between: [a, b]}\n"),
            "18: dynamics: pairs: expected friction, restitution or both");
  EXPECT_EQ(error_of(start + "{between: [a, b], friction: -1}\n"),
            "18: dynamics: pairs: friction: must be >= 0");
  EXPECT_EQ(error_of("dynamics:\n  step: 0.1\n  combine: {friction: mean}\n"),
            "17: dynamics: combine: friction: unknown rule 'mean'; known: geometric_mean, arithmetic_mean, "
            "minimum, maximum, product");
}

TEST(DynamicsFile, ActionsPutJointsAtValues) {
  const std::string start =
      "dynamics:\n  step: 0.1\n  bodies: [{object: a, mass: 1}]\n  mechanisms:\n    - name: m\n"
      "      joints:\n        - {name: j, kind: revolute, child: a, position: [0, 0, 0], axis: [0, 0, 1],\n"
      "           limits: {position: [-90, 90]}}\n  actions:\n";
  const physics::DynamicScene scene =
      loaded(start + "    - {time: 0.5, set: {joint: m.j, value: 30, rate: 6}}\n");
  ASSERT_EQ(scene.actions.size(), 1u);
  EXPECT_EQ(scene.actions[0].kind, physics::SceneAction::Kind::set_joint);
  EXPECT_NEAR(scene.actions[0].value, 30 * kDegree, 1e-15);
  EXPECT_NEAR(scene.actions[0].rate, 6 * kDegree, 1e-15);
  EXPECT_EQ(error_of(start + "    - {time: 0.5, set: {joint: m.j, value: 91}}\n"),
            "24: dynamics: actions: set: value: is out of the joint's limits");
  EXPECT_EQ(error_of(start + "    - {time: 0.5, set: {joint: m.j, value: 1}, release: a}\n"),
            "24: dynamics: actions: expected one of drive, latch, release, set, join, part, add, remove");
}

TEST(DynamicsFile, ActionsBringInAndTakeOut) {
  const std::string start =
      "dynamics:\n  step: 0.1\n  bodies: [{object: a, kind: dynamic, mass: 1}, {object: b, kind: dynamic, "
      "mass: 1}]\n"
      "  actions:\n";
  const physics::DynamicScene scene =
      loaded(start + "    - {time: 0.2, remove: a}\n    - {time: 0.5, add: b}\n    - {time: 0.6, add: a}\n");
  ASSERT_EQ(scene.actions.size(), 3u);
  EXPECT_EQ(scene.actions[0].kind, physics::SceneAction::Kind::remove);
  EXPECT_EQ(scene.actions[1].kind, physics::SceneAction::Kind::add);
  const auto absent = physics::absent_at_start(scene);
  EXPECT_EQ(absent[scene.actions[0].carried], 0);
  EXPECT_EQ(absent[scene.actions[1].carried], 1);
  const auto ends_with = [](const std::string& text, const std::string& end) {
    return text.size() >= end.size() && text.substr(text.size() - end.size()) == end;
  };
  const std::string twice = error_of(start + "    - {time: 0.2, remove: a}\n    - {time: 0.3, remove: a}\n");
  EXPECT_TRUE(ends_with(twice, "remove: object 'a' is not there")) << twice;
  const std::string latched =
      error_of(start + "    - {time: 0.2, latch: {carrier: a, carried: b}}\n    - {time: 0.3, remove: b}\n");
  EXPECT_TRUE(ends_with(latched, "remove: object 'b' is carried by object 'a'")) << latched;
  const std::string gone =
      error_of(start + "    - {time: 0.2, remove: b}\n    - {time: 0.3, latch: {carrier: a, carried: b}}\n");
  EXPECT_TRUE(ends_with(gone, "latch: object 'b' is not in the world then")) << gone;
}

/// Three bodies, one of them a link; joints between bodies follow.
const std::string kUpToJoints =
    "dynamics:\n  step: 0.1\n"
    "  bodies: [{object: a, kind: dynamic, mass: 1}, {object: b, kind: dynamic, mass: 1}, {object: c, "
    "mass: 1}]\n"
    "  mechanisms:\n    - name: m\n      joints:\n"
    "        - {name: j, kind: revolute, child: c, position: [0, 0, 0], axis: [0, 0, 1], friction: 3, "
    "damping: 0.5,\n"
    "           rotor: 0.25, drive: {position: 90, stiffness: 10, damping: 2, limit: 7}}\n"
    "  joints:\n";

TEST(DynamicsFile, ReadsJointsBetweenBodiesLossesAndPositionDrives) {
  const physics::DynamicScene scene = loaded(
      kUpToJoints +
      "    - {name: door, kind: revolute, parent: a, child: b, position: [100, 0, 0], axis: [0, 0, 3],\n"
      "       limits: {position: [-90, 45], torque: 4}, friction: 1, drive: {rate: 6, limit: 2}}\n"
      "    - {name: grip, kind: fixed, parent: c, child: a, holds: false}\n"
      "  actions:\n"
      "    - {time: 0.2, join: grip}\n"
      "    - {time: 0.4, drive: {joint: door, brake: 5}}\n"
      "    - {time: 0.6, part: grip}\n"
      "  answers: [{of: door, figure: value, value: 30, tolerance: 1}]\n");
  // The joint of the mechanism: losses, rotor, position drive.
  const physics::SceneJoint& joint = scene.mechanisms[0].joints[0];
  EXPECT_EQ(joint.losses.friction, 3.0);
  EXPECT_EQ(joint.losses.damping, 0.5);
  EXPECT_EQ(joint.rotor, 0.25);
  EXPECT_EQ(joint.drive.drive.mode, physics::JointDrive::Mode::position);
  EXPECT_NEAR(joint.drive.drive.position, 90 * kDegree, 1e-15);
  EXPECT_EQ(joint.drive.drive.stiffness, 10.0);
  EXPECT_EQ(joint.drive.drive.limit, 7.0);
  // The joints between bodies, in SI units.
  ASSERT_EQ(scene.joints.size(), 2u);
  const physics::SceneBodyJoint& door = scene.joints[0];
  EXPECT_EQ(door.kind, physics::BodyJointKind::hinge);
  EXPECT_EQ(door.parent, 0u);
  EXPECT_EQ(door.child, 1u);
  EXPECT_DOUBLE_EQ(door.p_W.x(), 0.1);
  EXPECT_EQ(door.axis_W, Vector3(0, 0, 1));
  EXPECT_NEAR(door.upper, 45 * kDegree, 1e-15);
  EXPECT_EQ(door.effort, 4.0);
  EXPECT_EQ(door.losses.friction, 1.0);
  EXPECT_NEAR(door.drive.drive.rate, 6 * kDegree, 1e-15);
  EXPECT_TRUE(door.is_on);
  EXPECT_FALSE(scene.joints[1].is_on);
  // Actions and answers find them by name.
  ASSERT_EQ(scene.actions.size(), 3u);
  EXPECT_EQ(scene.actions[0].kind, physics::SceneAction::Kind::join);
  EXPECT_EQ(scene.actions[0].joint.joint, 1u);
  EXPECT_TRUE(scene.actions[1].joint.is_of_bodies());
  EXPECT_EQ(scene.actions[2].kind, physics::SceneAction::Kind::part);
  EXPECT_NEAR(scene.answers[0].value.x(), 30 * kDegree, 1e-15);
}

TEST(DynamicsFile, BadJointsBetweenBodiesAreNamedWithTheirLines) {
  EXPECT_EQ(error_of(kUpToJoints + "    - {name: x, kind: weld, child: a}\n"),
            "24: joint 'x': kind: unknown kind 'weld'; known: fixed, revolute, prismatic, ball");
  EXPECT_EQ(error_of(kUpToJoints + "    - {name: x, kind: ball, child: a, friction: 1}\n"),
            "24: joint 'x': friction: only joints with an axis have any");
  EXPECT_EQ(error_of(kUpToJoints + "    - {name: x, kind: fixed, child: d}\n"),
            "24: joint 'x': neither of the two is dynamic or a link");
  EXPECT_EQ(error_of(kUpToJoints +
                     "    - {name: x, kind: fixed, child: a}\n    - {name: x, kind: fixed, child: b}\n"),
            "25: joint 'x' occurs twice");
  EXPECT_EQ(
      error_of(kUpToJoints + "    - {name: x, kind: fixed, child: a}\n  actions: [{time: 0, join: m.j}]\n"),
      "25: dynamics: actions: join: is no joint between bodies");
}

}  // namespace
}  // namespace touchstone
