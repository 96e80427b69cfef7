#include <gmock/gmock.h>

#include <cstring>
#include <fstream>
#include <string>
#include <vector>

#include "touchstone/adapters/c_files/touchstone_files.h"
#include "touchstone/adapters/robot_formats/robot_formats.hpp"
#include "touchstone/adapters/scene_files/scene_file.hpp"
#include "touchstone/contact_core/native/native.hpp"
#include "touchstone/contact_core/registry.hpp"
#include "touchstone/contact_core/world/scene_world.hpp"
#include "touchstone/tests/c_interface/owned_world.hpp"

namespace touchstone {
namespace {

using testing::HasSubstr;

OwnedWorld loaded(const std::string& file, const std::vector<touchstone_parameter>& parameters = {}) {
  touchstone_world* made = nullptr;
  EXPECT_EQ(touchstone_load_scene("native", (std::string(SCENES "/") + file).c_str(), parameters.data(),
                                  parameters.size(), &made),
            TOUCHSTONE_OK)
      << touchstone_error();
  return OwnedWorld(made);
}

touchstone_pose pose_of(const OwnedWorld& world, touchstone_object object) {
  touchstone_pose out{};
  EXPECT_EQ(touchstone_get_poses(world.get(), &object, 1, &out), TOUCHSTONE_OK) << touchstone_error();
  return out;
}

bool same_bits(const touchstone_pose& x, const Pose& y) { return std::memcmp(&x, &y, sizeof y) == 0; }

// ---- scenes

struct SceneCase {
  const char* file;
  std::vector<touchstone_parameter> parameters;
};
class Scenes : public testing::TestWithParam<SceneCase> {};

TEST_P(Scenes, FlyAsThroughCpp) {
  const OwnedWorld world = loaded(GetParam().file, GetParam().parameters);
  SceneParameters parameters;
  for (const touchstone_parameter& each : GetParam().parameters) parameters[each.name] = each.value;
  const Scene scene = load_scene(std::string(SCENES "/") + GetParam().file, parameters);
  BackendRegistry registry;
  register_core(registry);
  SceneWorld cpp(scene, make_native(), registry.make_broadphase("native"));
  // The same facts, objects and names.
  touchstone_scene_facts facts{};
  ASSERT_EQ(touchstone_get_scene_facts(world.get(), &facts), TOUCHSTONE_OK);
  EXPECT_EQ(facts.frames, scene.frame_count());
  EXPECT_EQ(facts.gap, scene.contact_gap);
  std::size_t count = 0;
  ASSERT_EQ(touchstone_get_scene_object_count(world.get(), &count), TOUCHSTONE_OK);
  ASSERT_EQ(count, scene.objects.size());
  std::vector<touchstone_object> objects(count);
  for (std::size_t i = 0; i < count; ++i) {
    touchstone_object named = TOUCHSTONE_NO_OBJECT;
    ASSERT_EQ(touchstone_get_scene_object(world.get(), i, &objects[i]), TOUCHSTONE_OK);
    ASSERT_EQ(touchstone_find_object(world.get(), scene.objects[i].tree.name().c_str(), &named),
              TOUCHSTONE_OK);
    EXPECT_EQ(named, objects[i]);
  }
  // Frame by frame the same poses and events.
  std::uint64_t events = 0;
  const std::uint64_t frames = std::min<std::uint64_t>(facts.frames, 400);
  for (std::uint64_t frame = 1; frame < frames; ++frame) {  // the first one is at time 0
    touchstone_report report{};
    ASSERT_EQ(touchstone_step_scene(world.get(), &report), TOUCHSTONE_OK) << touchstone_error();
    const FrameReport expected = cpp.step();
    ASSERT_EQ(report.event_count, expected.events.size()) << frame;
    events += report.event_count;
    for (std::size_t i = 0; i < count; ++i)
      ASSERT_TRUE(same_bits(pose_of(world, objects[i]), cpp.world().actual_pose(cpp.object(i)))) << frame;
  }
  EXPECT_GT(events, 0u);
}

INSTANTIATE_TEST_SUITE_P(Bundled, Scenes,
                         testing::Values(SceneCase{"latched_gate.yaml", {}},
                                         SceneCase{"tunnelling_bar.yaml", {}},
                                         SceneCase{"oru_insertion.yaml", {{"tilt", 3.0}}}));

TEST(Scene, ItsStepsComeToItsEnd) {
  const OwnedWorld world = loaded("tunnelling_bar.yaml");
  touchstone_scene_facts facts{};
  ASSERT_EQ(touchstone_get_scene_facts(world.get(), &facts), TOUCHSTONE_OK);
  EXPECT_LE(static_cast<double>(facts.frames - 1) / facts.frame_rate, facts.duration * (1 + 1e-12));
  EXPECT_GT(static_cast<double>(facts.frames) / facts.frame_rate, facts.duration);
}

TEST(Scene, GoesOnWithoutAnObjectThatWasRemoved) {
  const OwnedWorld world = loaded("tunnelling_bar.yaml");
  touchstone_report report{};
  touchstone_object arm = 0;  // the one that the file moves
  ASSERT_EQ(touchstone_step_scene(world.get(), &report), TOUCHSTONE_OK);
  EXPECT_EQ(report.blocked_movers, 1u);
  ASSERT_EQ(touchstone_find_object(world.get(), "arm", &arm), TOUCHSTONE_OK);
  ASSERT_EQ(touchstone_remove_object(world.get(), arm), TOUCHSTONE_OK) << touchstone_error();
  for (int frame = 0; frame < 3; ++frame) {
    ASSERT_EQ(touchstone_step_scene(world.get(), &report), TOUCHSTONE_OK) << touchstone_error();
    EXPECT_EQ(report.blocked_movers, 0u);
  }
}

TEST(Scene, WhatIsNoneIsRefusedByName) {
  touchstone_world* made = nullptr;
  const auto refused = [&](const char* backend, const char* path, const touchstone_parameter* parameters,
                           std::size_t count, const char* text) {
    EXPECT_EQ(touchstone_load_scene(backend, path, parameters, count, &made), TOUCHSTONE_BAD_INPUT);
    EXPECT_THAT(touchstone_error(), HasSubstr(text));
    EXPECT_EQ(made, nullptr);
  };
  const char* const gate = SCENES "/latched_gate.yaml";
  const touchstone_parameter unknown = {"nobody", 1.0}, nameless = {nullptr, 1.0};
  refused("native", SCENES "/nowhere.yaml", nullptr, 0, "nowhere.yaml");
  refused("native", ROBOTS "/arm.urdf", nullptr, 0, "arm.urdf");
  refused("no_backend", gate, nullptr, 0, "no_backend");
  refused("native", gate, &unknown, 1, "nobody");
  refused("native", gate, &nameless, 1, "parameters: name: is NULL");
  refused("native", gate, nullptr, 1, "parameters: is NULL");
  refused("native", nullptr, nullptr, 0, "path: is NULL");
}

TEST(Scene, AWorldOfItsOwnIsNone) {
  touchstone_world* made = nullptr;
  ASSERT_EQ(touchstone_create_world("native", 0.0, &made), TOUCHSTONE_OK);
  const OwnedWorld world(made);
  touchstone_report report{};
  touchstone_scene_facts facts{};
  EXPECT_EQ(touchstone_step_scene(world.get(), &report), TOUCHSTONE_BAD_INPUT);
  EXPECT_THAT(touchstone_error(), HasSubstr("is of no scene file"));
  EXPECT_EQ(touchstone_get_scene_facts(world.get(), &facts), TOUCHSTONE_BAD_INPUT);
  touchstone_object object = 0;
  const OwnedWorld scene = loaded("latched_gate.yaml");
  EXPECT_EQ(touchstone_get_scene_object(scene.get(), 3, &object), TOUCHSTONE_BAD_INPUT);
  EXPECT_THAT(touchstone_error(), HasSubstr("3 is none of the scene's 3"));
}

// Coarser hexahedra come with the file, and are looked at: what does not hold the finer ones is refused.
TEST(Scene, LevelsComeWithTheFile) {
  // A block with a coarse level, which has to hold it.
  const std::string path = testing::TempDir() + "/levels_in_c.yaml";
  touchstone_world* made = nullptr;
  const auto load = [&](const std::string& size) {
    std::ofstream(path) << R"(name: levels
units: {length: m, angle: deg}
frame_rate: 10
contact_gap: 1.0e-9
duration: 1
policy: advance
objects:
  - name: block
    hexahedra: [{name: a, box: {size: [1, 1, 1]}}, {name: b, box: {size: [0.5, 0.5, 0.5]}}]
    levels: [[{name: all, box: {size: )"
                        << size << R"(}}]]
    pose: {position: [-3, 0, 0]}
    motion: {segments: [{velocity: [5, 0, 0]}]}
  - name: wall
    hexahedra: [{name: wall, box: {size: [1, 9, 9]}}]
)";
    return touchstone_load_scene("native", path.c_str(), nullptr, 0, &made);
  };
  // A level that does not is refused by name.
  ASSERT_EQ(load("[0.9, 2, 2]"), TOUCHSTONE_BAD_INPUT);
  EXPECT_THAT(touchstone_error(), HasSubstr("block"));
  // Flown at a wall the block stops where its own faces meet it.
  ASSERT_EQ(load("[2, 2, 2]"), TOUCHSTONE_OK) << touchstone_error();
  const OwnedWorld world(made);
  touchstone_report report{};
  for (int frame = 0; frame < 9; ++frame)
    ASSERT_EQ(touchstone_step_scene(world.get(), &report), TOUCHSTONE_OK);
  touchstone_object block = 0;
  touchstone_pose pose{};
  ASSERT_EQ(touchstone_find_object(world.get(), "block", &block), TOUCHSTONE_OK);
  ASSERT_EQ(touchstone_get_poses(world.get(), &block, 1, &pose), TOUCHSTONE_OK);
  EXPECT_NEAR(pose.p[0], -1.0, 1e-6);  // its faces touch the wall's, but for the gap
}

// ---- robots

class Robots : public testing::Test {
 protected:
  OwnedWorld world;
  touchstone_pose aside = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 0, 50}};

  Robots() {
    touchstone_world* made = nullptr;
    EXPECT_EQ(touchstone_create_world("native", 0.0, &made), TOUCHSTONE_OK);
    world.reset(made);
  }
};

TEST_F(Robots, StandAsThroughCpp) {
  const std::vector<double> values = {0.1, -0.2, 0.3, 0.6, -0.5, 0.2, 0.4};
  touchstone_mechanism robot = 0;
  ASSERT_EQ(touchstone_add_robot(world.get(), "lifter", ROBOTS "/arm.urdf", nullptr, &aside, values.data(),
                                 values.size(), &robot),
            TOUCHSTONE_OK)
      << touchstone_error();
  const Mechanism cpp(load_robot(ROBOTS "/arm.urdf").mechanism);
  std::vector<Pose> X_WL(cpp.links().size());
  Pose X_WB;
  X_WB.p = {0, 0, 50};
  cpp.link_poses(X_WB, values, X_WL);
  for (const char* link : {"base_lee", "upper_boom", "lower_boom"}) {
    touchstone_object part = 0, named = 0;
    ASSERT_EQ(touchstone_get_link(world.get(), robot, link, &part), TOUCHSTONE_OK) << link;
    ASSERT_EQ(touchstone_find_object(world.get(), (std::string("lifter.") + link).c_str(), &named),
              TOUCHSTONE_OK);
    EXPECT_EQ(part, named);
    EXPECT_TRUE(same_bits(pose_of(world, part), X_WL[cpp.find_link(link)])) << link;
  }
}

TEST_F(Robots, AnSrdfFileExemptsLinks) {
  // There the upper boom goes through the middle of the base; only an exempt pair lets it.
  const auto stopped = [&](const char* name, const char* srdf) {
    touchstone_robot_options options{};
    options.srdf = srdf;
    touchstone_mechanism robot = 0;
    EXPECT_EQ(
        touchstone_add_robot(world.get(), name, ROBOTS "/arm.urdf", &options, &aside, nullptr, 0, &robot),
        TOUCHSTONE_OK)
        << touchstone_error();
    std::vector<double> goal = {0, -1.043, 2.013, 0.5, 0, 0, 0};
    const touchstone_joint_command command{robot, goal.data(), goal.size()};
    touchstone_report report{};
    EXPECT_EQ(touchstone_frame_with_joints(world.get(), nullptr, 0, &command, 1, &report), TOUCHSTONE_OK);
    EXPECT_EQ(touchstone_remove_mechanism(world.get(), robot), TOUCHSTONE_OK);
    return report.blocked_movers;
  };
  EXPECT_EQ(stopped("checked", nullptr), 1u);
  EXPECT_EQ(stopped("exempt", ROBOTS "/arm.srdf"), 0u);
}

TEST_F(Robots, WhatIsNoneIsRefusedByName) {
  touchstone_mechanism robot = 7;
  const auto refused = [&](const char* path, const touchstone_robot_options& options, const char* text) {
    EXPECT_EQ(touchstone_add_robot(world.get(), nullptr, path, &options, &aside, nullptr, 0, &robot),
              TOUCHSTONE_BAD_INPUT);
    EXPECT_THAT(touchstone_error(), HasSubstr(text));
    EXPECT_EQ(robot, 7u);
  };
  touchstone_robot_options options{};
  refused(ROBOTS "/nowhere.urdf", options, "nowhere.urdf");
  refused(SCENES "/latched_gate.yaml", options, "a robot is read from .urdf");
  refused(nullptr, options, "path: is NULL");
  touchstone_mechanism_options weights{};
  weights.weight_count = 1;
  options.mechanism = &weights;
  refused(ROBOTS "/arm.urdf", options, "options: weights: is NULL");
  options = {};
  options.srdf = ROBOTS "/arm.urdf";  // has no such entries
  options.sphere_facets = 3;
  refused(ROBOTS "/nowhere.urdf", options, "nowhere.urdf");
}

}  // namespace
}  // namespace touchstone
