#include <gtest/gtest.h>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/contact_core/registry.hpp"
#include "touchstone/examples/training_run/flight/fly.hpp"
#include "touchstone/tests/support/program_test.hpp"

// Pairs that latches of scenes and scripts allow, and until when.

namespace touchstone::training {
namespace {

// The jaw's face is 0.1 m off the payload's, which is at x = 0.5.
constexpr const char* kScene = R"(name: Gripper
frame_rate: 10
contact_gap: 1.0e-9
policy: advance
duration: 2
objects:
  - {name: wrist, pose: {position: [-3, 0, 0]}, hexahedra: [{name: box, box: {size: [1, 1, 1]}}]}
  - {name: payload, hexahedra: [{name: box, box: {size: [1, 1, 1]}}]}
  - {name: jaw, pose: {position: [0.65, 0, 0]}, hexahedra: [{name: pad, box: {size: [0.1, 1, 1]}}]}
)";
constexpr const char* kHand = "hands:\n  - {object: jaw, rates: [{time: 0, velocity: [-0.1, 0, 0]}]}\n";
constexpr const char* kAllows = "{carrier: wrist, carried: payload, allowed: [[jaw/pad, payload]]}";

class LatchedScript : public FolderTest {
 protected:
  /// Where a jaw that is commanded to come 0.2 m closer ends in the contact world.
  double fly_jaw(const std::string& latches, const std::string& actions) const {
    write("scene.yaml", kScene + latches);
    const Setting setting(load_script(
        write("script.yaml", std::string("name: x\nscene: {file: scene.yaml}\n") + kHand + actions)));
    BackendRegistry registry;
    register_core(registry);
    const auto method = make_contact_world_method(setting, registry.make_narrowphase("native"),
                                                  registry.make_broadphase("native"));
    fly(setting, *method, false);
    const Formation& formation = method->formation();
    is_checked_at_end_ = formation.is_checked({1, 2}, setting.instance());
    return method->poses()[2].p.x();
  }
  mutable bool is_checked_at_end_ = false;
};

TEST_F(LatchedScript, SceneLatchAllowsItsPairsUntilTheScriptReleases) {
  const std::string latches = std::string("latches: [") + kAllows + "]\n";
  EXPECT_NEAR(fly_jaw(latches, ""), 0.45, 1e-12);
  EXPECT_FALSE(is_checked_at_end_);
  EXPECT_NEAR(fly_jaw(latches, "actions: [{time: 0.3, release: payload}]\n"), 0.55, 1e-8);
  EXPECT_TRUE(is_checked_at_end_);
}

TEST_F(LatchedScript, ScriptsLatchAllowsItsPairsUntilTheRelease) {
  const std::string latch = std::string("actions:\n  - {time: 0, latch: ") + kAllows + "}\n";
  EXPECT_NEAR(fly_jaw("", latch), 0.45, 1e-12);
  EXPECT_NEAR(fly_jaw("", latch + "  - {time: 0.3, release: payload}\n"), 0.55, 1e-8);
  // Latched again by a latch that allows nothing.
  EXPECT_NEAR(fly_jaw("", latch + "  - {time: 0.3, release: payload}\n" +
                              "  - {time: 0.4, latch: {carrier: wrist, carried: payload}}\n"),
              0.55, 1e-8);
}

/// An arm's end effector holds a payload below it, above a floor; 0.1 m/s down for 2 s.
constexpr const char* kArmScene = R"(name: Arm
frame_rate: 10
contact_gap: 1.0e-9
policy: advance
duration: 2
objects:
  - {name: payload, pose: {position: [0, 0, -0.26]}, hexahedra: [{name: box, box: {size: [0.5, 0.5, 0.5]}}]}
  - {name: floor, pose: {position: [0, 0, -1.115]}, hexahedra: [{name: box, box: {size: [4, 4, 1]}}]}
)";
constexpr const char* kArmScript = R"(name: x
scene: {file: scene.yaml}
units: {angle: deg}
hands:
  - arm: {model: ssrms, link: tip, joints: [10, 25, -70, 110, -35, 20, 15], pose: {rpy: [0, 90, 0]}}
    rates: [{time: 0, velocity: [0, 0, -0.1]}]
)";
const std::string kHold = "actions:\n  - {time: 0, latch: {carrier: ssrms.tip_lee, carried: payload}}\n";

TEST_F(LatchedScript, ALinkCarriesItsPayloadInEveryWay) {
  write("scene.yaml", kArmScene);
  const Setting setting(load_script(write("script.yaml", kArmScript + kHold)));
  BackendRegistry registry;
  register_core(registry);
  const auto world = make_contact_world_method(setting, registry.make_narrowphase("native"),
                                               registry.make_broadphase("native"));
  fly(setting, *world, false);
  // The payload's lower face stands at -0.51, the floor's upper one at -0.615.
  EXPECT_NEAR(world->poses()[0].p.z(), -0.365, 1e-8);
  // Within a frame the joints go evenly and stray by (0.1 / 4 / 10)^2 x 17 / 8.
  EXPECT_NEAR(world->poses()[0].p.x(), 0.0, 1.4e-5);
  const auto first_build = make_first_build_method(setting);
  fly(setting, *first_build, false);
  EXPECT_NEAR(first_build->poses()[0].p.z(), -0.36, 1e-9);  // what is left of a step before
  const auto unchecked = make_unchecked_method(setting);
  fly(setting, *unchecked, false);
  EXPECT_NEAR(unchecked->poses()[0].p.z(), -0.46, 1e-9);
}

TEST_F(LatchedScript, ABaseThatIsRefusedChangesNothing) {
  write("scene.yaml", kArmScene);
  const Setting setting(load_script(write("script.yaml", kArmScript + kHold)));
  BackendRegistry registry;
  register_core(registry);
  const auto world = make_contact_world_method(setting, registry.make_narrowphase("native"),
                                               registry.make_broadphase("native"));
  FlightLog log = fly(setting, *world, false);
  const Vector3 before = world->poses()[0].p;
  const Arm& arm = setting.arms()[0];
  Arm far = arm, none = arm;
  far.joints.assign(arm.joints.size(), 10.0);  // beyond their limits
  none.mechanism = nullptr;
  EXPECT_THROW(world->set_base(far), InputError);
  EXPECT_THROW(world->set_base(none), InputError);
  // The arm goes back to its start, and carries what it carried.
  const ArmCommand back{&arm, arm.joints};
  world->frame({}, {&back, 1}, log);
  EXPECT_GT((world->poses()[0].p - before).norm(), 0.1);
  EXPECT_EQ(world->formation().carrier[0], setting.actions()[0].carrier);
}

TEST_F(LatchedScript, ALinkLetsGo) {
  write("scene.yaml", kArmScene);
  const Setting setting(
      load_script(write("script.yaml", kArmScript + kHold + "  - {time: 0.5, release: payload}\n")));
  BackendRegistry registry;
  register_core(registry);
  const auto world = make_contact_world_method(setting, registry.make_narrowphase("native"),
                                               registry.make_broadphase("native"));
  fly(setting, *world, false);
  // Let go, it stands where it is, 10 mm below the mouth, and stops the arm.
  EXPECT_NEAR(world->poses()[0].p.z(), -0.31, 1e-9);
  const std::uint32_t lee = setting.actions()[0].carrier;
  EXPECT_EQ(setting.object_name(lee), "ssrms.tip_lee");
  EXPECT_NEAR(world->poses()[lee].p.z(), 1.3589 - 0.06, 1e-8);
}

}  // namespace
}  // namespace touchstone::training
