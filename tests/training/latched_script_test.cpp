#include <gtest/gtest.h>

#include "touchstone/contact_core/registry.hpp"
#include "touchstone/examples/training_run/fly.hpp"
#include "touchstone/tests/support/program_test.hpp"

// What latches of scenes and scripts allow, and until when.

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
  /// Where a jaw that is told to come 0.2 m closer ends in the contact world.
  double fly_jaw(const std::string& latches, const std::string& actions) const {
    write("scene.yaml", kScene + latches);
    const Setting setting(load_script(
        write("script.yaml", std::string("name: x\nscene: {file: scene.yaml}\n") + kHand + actions)));
    BackendRegistry registry;
    register_core(registry);
    const auto way = make_contact_world_way(setting, registry.make_narrowphase("native"),
                                            registry.make_broadphase("native"));
    fly(setting, *way, false);
    const Formation& formation = way->formation();
    is_checked_at_end_ = formation.is_checked({1, 2}, setting.instance());
    return way->poses()[2].p.x();
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

}  // namespace
}  // namespace touchstone::training
