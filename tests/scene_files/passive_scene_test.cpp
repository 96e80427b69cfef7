#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "touchstone/adapters/scene_files/scene_file.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/contact_core/registry.hpp"
#include "touchstone/contact_core/world/scene_world.hpp"
#include "touchstone/tests/support/written_file.hpp"

// Rules of pairs in scene files, and of objects that are carried off or shoved.

namespace touchstone {
namespace {

constexpr double kGap = 1e-7;

/// A tray of 2 m goes 1 m along x in a second, and 0.2 m up, over a table that it stands on. On it lies a
/// load, 1 m wide, within the gap. At x = 2.5 a block of 1 m stands on the table.
std::string tray_text(const std::string& rules, const std::string& objects = "") {
  return "name: tray\nframe_rate: 50\ncontact_gap: 1.0e-7\npolicy: advance\nduration: 1\nobjects:\n"
         "  - {name: table, pose: {position: [0, 0, -0.6]}, hexahedra: [{name: top, box: {size: [20, 20, "
         "1]}}]}\n"
         "  - name: tray\n    groups: [movers]\n    hexahedra: [{name: plate, box: {size: [2, 2, 0.2]}}]\n"
         "    pose: {position: [0, 0, 0.00000008]}\n"
         "    motion: {segments: [{velocity: [1, 0, 0.2]}]}\n"
         "  - name: load\n    groups: [loads]\n    pose: {position: [0.2, 0, 0.60000015]}\n"
         "    hexahedra: [{name: box, box: {size: [1, 1, 1]}}]\n" +
         objects + rules;
}

constexpr const char* kBlock =
    "  - {name: block, groups: [loads], pose: {position: [2.5, 0, 0.7]}, hexahedra: [{name: box, box: {size: "
    "[1, 1, "
    "0.4]}}]}\n";

/// A scene file flown whole.
struct Flight {
  Scene scene;
  BackendRegistry registry;
  std::unique_ptr<SceneWorld> run;
  std::size_t touching = 0;  ///< frames after which some pair is in contact

  explicit Flight(const std::string& text) : scene(load_scene(written_file(text, ".yaml"))) {
    register_core(registry);
    run = std::make_unique<SceneWorld>(scene, registry.make_narrowphase("native"),
                                       registry.make_broadphase("native"));
    while (run->frame() + 1 < scene.frame_count()) {
      const FrameReport report = run->step();
      for (const ContactEvent& event : report.events)
        if (event.geometry_at_end.separation <= 0.0) ++touching;
    }
  }
  Vector3 at(const char* name) const { return run->world().actual_pose(run->object(name)).p; }
};

TEST(PassiveScene, ATrayCarriesItsLoad) {
  const Flight flight(tray_text("rules: [{between: [tray, load], passive: carried}]\n"));
  EXPECT_NEAR(flight.at("tray").x(), 1.0, 1e-12);
  EXPECT_NEAR(flight.at("tray").z(), 0.2, 1e-6);
  EXPECT_NEAR(flight.at("load").x(), 1.2, 1e-9);
  EXPECT_NEAR(flight.at("load").z(), 0.8, 1e-6);
  EXPECT_EQ(flight.touching, 0u);
}

TEST(PassiveScene, WhatNoRuleTakesAlongStandsStill) {
  // The tray is then held down by its load.
  const Flight flight(tray_text(""));
  EXPECT_EQ(flight.at("load"), Vector3(0.2, 0, 0.60000015));
  EXPECT_LT(flight.at("tray").z(), 1e-6);
}

TEST(PassiveScene, TheScenesOwnChoiceHoldsForAllButStaticObjects) {
  const std::string text = tray_text("", std::string(kBlock));
  const std::string carried = "passive: carried\n" + text;
  std::string fixed = carried;
  fixed.replace(fixed.find("name: table,"), 12, "name: table, static: true,");
  const Flight flight(fixed);
  EXPECT_NEAR(flight.at("load").x(), 1.2, 1e-9);
  EXPECT_EQ(flight.at("table"), Vector3(0, 0, -0.6));
  // The load would meet the block after 1.3 m.
  EXPECT_EQ(flight.at("block"), Vector3(2.5, 0, 0.7));
}

TEST(PassiveScene, ALoadShovesWhatAGroupsRuleLetsItShove) {
  // The load goes along from the first frame on. Its face comes to the block after 0.5 m.
  std::string text = tray_text(
      "rules: [{between: [movers, loads], passive: carried}, {between: [loads, loads], passive: shoved}]\n",
      "  - {name: block, groups: [loads], pose: {position: [1.7, 0, 0.7]}, hexahedra: [{name: box, box: "
      "{size: [1, 1, 0.4]}}]}\n");
  text.replace(text.find("velocity: [1, 0, 0.2]"), 21, "velocity: [1, 0, 0]  ");
  const Flight flight(text);
  EXPECT_NEAR(flight.at("tray").x(), 1.0, 1e-6);
  EXPECT_NEAR(flight.at("load").x(), 1.2, 1e-6);
  EXPECT_NEAR(flight.at("block").x(), 2.2, 1e-5);
  EXPECT_EQ(flight.touching, 0u);
}

TEST(PassiveScene, ARuleThatNamesAnObjectComesBeforeThoseOfGroups) {
  const std::string both =
      "rules: [{between: [tray, load], passive: stays}, {between: [movers, loads], passive: carried}]\n";
  EXPECT_EQ(Flight(tray_text(both)).at("load").x(), 0.2);
  const std::string cued = "rules: [{between: [tray, load], policy: cue}]\n";
  const Flight flight(tray_text(cued));
  EXPECT_EQ(flight.at("load").x(), 0.2);
  EXPECT_NEAR(flight.at("tray").z(), 0.2, 1e-6);
}

TEST(PassiveScene, RulesAreRead) {
  const Scene scene = load_scene(
      written_file("passive: shoved\n" +
                       tray_text("rules:\n  - {between: [tray, loads], policy: slide, warn_distance: 0.1, "
                                 "translation_only: true, passive: carried}\n  - {between: [load, table], "
                                 "warn_distance: 0}\n"),
                   ".yaml"));
  EXPECT_EQ(scene.passive, Passive::shoved);
  ASSERT_EQ(scene.rules.size(), 2u);
  EXPECT_EQ(scene.rules[0].second, "loads");
  EXPECT_EQ(scene.rules[0].policy, ContactPolicy::slide);
  EXPECT_EQ(scene.rules[0].warn_distance, 0.1);
  EXPECT_EQ(scene.rules[0].translation_only, true);
  EXPECT_EQ(scene.rules[0].passive, Passive::carried);
  EXPECT_FALSE(scene.rules[1].policy);
  EXPECT_FALSE(scene.rules[1].passive);
}

std::string error_of(const std::string& text) {
  return error_in_file(text, ".yaml", [](const auto& path) { load_scene(path); });
}

TEST(PassiveScene, BadRulesAreNamedByLine) {
  // The rule stands in line 18.
  const auto expect_error = [](const std::string& rule, const std::string& reason) {
    const std::string error = error_of(tray_text("rules:\n  - " + rule + "\n"));
    EXPECT_EQ(error.substr(0, 3), "18:") << error;
    EXPECT_NE(error.find(reason), std::string::npos) << error;
  };
  // Bad rules.
  expect_error("{between: [tray, lid], passive: stays}", "'lid' names no object or group");
  expect_error("{between: [tray, load/box], passive: stays}", "'load/box' names no object or group");
  expect_error("{between: [tray, tray], passive: stays}", "one object twice");
  expect_error("{between: [tray], passive: stays}", "expected two objects or groups");
  expect_error("{between: [tray, load]}", "sets nothing");
  expect_error("{between: [tray, load], passive: pushed}",
               "unknown choice 'pushed'; known: stays, shoved, carried");
  expect_error("{between: [tray, load], policy: push}", "unknown policy 'push'");
  expect_error("{between: [tray, load], translation_only: 1}", "expected true or false");
  expect_error("{between: [tray, load], warn_distance: -1}", "finite and >= 0");
  expect_error("{between: [tray, load], pasive: stays}", "unknown key 'pasive'");
  // A static object neither moves nor is carried.
  const std::string moving =
      error_of(tray_text("",
                         "  - {name: a, static: true, motion: {segments: [{velocity: [1, 0, "
                         "0]}]}, hexahedra: [{name: b, box: {size: [1, 1, 1]}}]}\n"));
  EXPECT_NE(moving.find("is static and has a motion"), std::string::npos) << moving;
  const std::string carried =
      error_of(tray_text("latches: [{carrier: tray, carried: a}]\n",
                         "  - {name: a, static: true, hexahedra: [{name: b, box: {size: [1, 1, "
                         "1]}}]}\n"));
  EXPECT_NE(carried.find("'a' is static"), std::string::npos) << carried;
}

}  // namespace
}  // namespace touchstone
