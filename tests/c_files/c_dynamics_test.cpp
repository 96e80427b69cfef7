#include <gmock/gmock.h>

#include <cmath>
#include <cstring>
#include <string>
#include <vector>

#include "touchstone/adapters/c_files/touchstone_dynamics.h"
#include "touchstone/adapters/scene_files/dynamics_file.hpp"
#include "touchstone/contact_core/registry.hpp"
#include "touchstone/physics/engine/engine_registry.hpp"

namespace touchstone {
namespace {

using testing::HasSubstr;

struct DestroyRun {
  void operator()(touchstone_simulation* run) const { touchstone_destroy_simulation(run); }
  void operator()(touchstone_saved_run* saved) const { touchstone_destroy_saved_run(saved); }
};
using OwnedRun = std::unique_ptr<touchstone_simulation, DestroyRun>;
using OwnedState = std::unique_ptr<touchstone_saved_run, DestroyRun>;

std::string path_of(const std::string& file) { return std::string(DYNAMIC_SCENES "/") + file; }

OwnedRun loaded(const std::string& file) {
  touchstone_simulation* made = nullptr;
  EXPECT_EQ(touchstone_load_simulation("native", path_of(file).c_str(), nullptr, 0, &made), TOUCHSTONE_OK)
      << touchstone_error();
  return OwnedRun(made);
}

touchstone_step step(const OwnedRun& run, int count = 1) {
  touchstone_step last{};
  for (int i = 0; i < count; ++i)
    EXPECT_EQ(touchstone_step_simulation(run.get(), &last), TOUCHSTONE_OK) << touchstone_error();
  return last;
}

std::vector<touchstone_object_state> states(const OwnedRun& run) {
  touchstone_simulation_facts facts{};
  EXPECT_EQ(touchstone_get_simulation_facts(run.get(), &facts), TOUCHSTONE_OK);
  std::vector<touchstone_object_state> all(facts.objects);
  EXPECT_EQ(touchstone_get_object_states(run.get(), all.data(), all.size()), TOUCHSTONE_OK);
  return all;
}

bool same_bits(const std::vector<touchstone_object_state>& x, const std::vector<touchstone_object_state>& y) {
  return x.size() == y.size() && std::memcmp(x.data(), y.data(), x.size() * sizeof x[0]) == 0;
}

TEST(Dynamics, StepAsThroughCpp) {
  const OwnedRun run = loaded("box_stack.yaml");
  const physics::DynamicScene scene = load_dynamic_scene(path_of("box_stack.yaml"));
  BackendRegistry backends;
  register_core(backends);
  physics::EngineRegistry engines;
  physics::register_own_engine(engines, backends);
  const auto cpp = engines.make({"own", "native"}, scene);
  std::vector<physics::EngineContact> expected;
  for (int i = 0; i < 100; ++i) {
    const touchstone_step taken = step(run);
    cpp->begin_step();
    EXPECT_EQ(taken.contacts, cpp->step().contacts);
    EXPECT_EQ(taken.time, cpp->time());
  }
  // The same poses, velocities and forces.
  const std::vector<touchstone_object_state> all = states(run);
  ASSERT_EQ(all.size(), scene.scene.objects.size());
  for (std::size_t object = 0; object < all.size(); ++object) {
    const Pose X_WO = cpp->object_pose(object);
    EXPECT_EQ(std::memcmp(&all[object].X_WO, &X_WO, sizeof X_WO), 0) << object;
    const auto v_W = cpp->velocity(object);
    EXPECT_EQ(std::isnan(all[object].v_W[0]), !v_W.has_value());
    if (v_W) {
      EXPECT_EQ(std::memcmp(all[object].v_W, v_W->data(), sizeof all[object].v_W), 0) << object;
    }
  }
  const touchstone_contact* contacts = nullptr;
  std::size_t count = 0;
  ASSERT_EQ(touchstone_get_contacts(run.get(), &contacts, &count), TOUCHSTONE_OK);
  cpp->list_contacts(expected);
  ASSERT_EQ(count, expected.size());
  ASSERT_GT(count, 0u);
  for (std::size_t i = 0; i < count; ++i) {
    EXPECT_EQ(contacts[i].force_W[2], expected[i].force_W.z());
    EXPECT_LT(contacts[i].object_a, contacts[i].object_b);
  }
}

TEST(Dynamics, ASavedRunGoesOnToTheSameBits) {
  const OwnedRun run = loaded("08_arm_pushes.yaml");
  const std::vector<touchstone_object_state> start = states(run);
  step(run, 50);
  touchstone_saved_run* made = nullptr;
  ASSERT_EQ(touchstone_save_run(run.get(), &made), TOUCHSTONE_OK);
  const OwnedState saved(made);
  step(run, 50);
  const std::vector<touchstone_object_state> end = states(run);
  EXPECT_FALSE(same_bits(end, start));
  // A push for the next step is forgotten.
  const double force_W[3] = {0, 1000, 0}, p_W[3] = {0, 0, 0};
  std::size_t oru = 0;
  ASSERT_EQ(touchstone_find_simulated_object(run.get(), "oru", &oru), TOUCHSTONE_OK);
  ASSERT_EQ(touchstone_push_object(run.get(), oru, force_W, p_W, nullptr), TOUCHSTONE_OK);
  ASSERT_EQ(touchstone_restore_run(run.get(), saved.get()), TOUCHSTONE_OK);
  EXPECT_EQ(step(run, 50).steps, 100u);
  EXPECT_TRUE(same_bits(states(run), end));
  ASSERT_EQ(touchstone_reset_run(run.get()), TOUCHSTONE_OK);
  EXPECT_TRUE(same_bits(states(run), start));
  // Only its own.
  const OwnedRun other = loaded("08_arm_pushes.yaml");
  EXPECT_EQ(touchstone_restore_run(other.get(), saved.get()), TOUCHSTONE_BAD_INPUT);
}

TEST(Dynamics, AStepThatFailsTakesNoTimeAndIsNamed) {
  const OwnedRun run = loaded("08_arm_pushes.yaml");
  const std::vector<touchstone_object_state> start = states(run);
  const double force_W[3] = {0, 1.7e308, 0}, p_W[3] = {0, 0, 0};
  std::size_t oru = 0;
  ASSERT_EQ(touchstone_find_simulated_object(run.get(), "oru", &oru), TOUCHSTONE_OK);
  for (int twice = 0; twice < 2; ++twice)  // which is infinite
    ASSERT_EQ(touchstone_push_object(run.get(), oru, force_W, p_W, nullptr), TOUCHSTONE_OK);
  touchstone_step taken{};
  for (int turn = 0; turn < 2; ++turn) {  // pushes stay
    EXPECT_EQ(touchstone_step_simulation(run.get(), &taken), TOUCHSTONE_FAILURE);
    EXPECT_THAT(touchstone_error(), HasSubstr("oru"));
    EXPECT_TRUE(same_bits(states(run), start));
  }
  ASSERT_EQ(touchstone_reset_run(run.get()), TOUCHSTONE_OK);
  EXPECT_EQ(step(run).steps, 1u);
}

// A brake of 2332 N m holds until the push asks for more: what it holds is what is asked.
TEST(Dynamics, JointsHaveTheirTorque) {
  const OwnedRun run = loaded("09_both_saturate.yaml");
  step(run, 1250);
  touchstone_joint_state joint{};
  ASSERT_EQ(touchstone_get_joint_state(run.get(), "arm.elbow", &joint), TOUCHSTONE_OK);
  EXPECT_NEAR(joint.torque, 2116.37811, 1e-5);
  EXPECT_NEAR(joint.value, 1.5707963267948966, 1e-9);
  EXPECT_EQ(touchstone_get_joint_state(run.get(), "arm.knee", &joint), TOUCHSTONE_BAD_INPUT);
  EXPECT_THAT(touchstone_error(), HasSubstr("arm.knee: is no joint of the scene"));
}

TEST(Dynamics, WhatIsRefusedIsNamed) {
  touchstone_simulation* none = nullptr;
  const auto refusal = [&](const char* check, const std::string& path) {
    EXPECT_EQ(touchstone_load_simulation(check, path.c_str(), nullptr, 0, &none), TOUCHSTONE_BAD_INPUT);
    EXPECT_EQ(none, nullptr);
    return std::string(touchstone_error());
  };
  EXPECT_THAT(refusal("native", SCENES "/latched_gate.yaml"), HasSubstr("dynamics"));
  EXPECT_THAT(refusal("native", "not_there.yaml"), HasSubstr("not_there.yaml"));
  EXPECT_THAT(refusal("edge_face", path_of("box_stack.yaml")), HasSubstr("edge_face"));
  EXPECT_THAT(refusal("no_such_check", path_of("box_stack.yaml")), HasSubstr("no_such_check"));
  // Of a run.
  const OwnedRun run = loaded("box_stack.yaml");
  const double push[3] = {0, 0, 1}, at[3] = {0, 0, 0}, bad[3] = {0, NAN, 0};
  std::size_t number = 0;
  EXPECT_EQ(touchstone_push_object(run.get(), 1000, push, at, nullptr), TOUCHSTONE_BAD_INPUT);
  EXPECT_EQ(touchstone_push_object(run.get(), states(run).size() - 1, bad, at, nullptr),
            TOUCHSTONE_BAD_INPUT);
  EXPECT_EQ(touchstone_push_object(run.get(), 0, nullptr, at, nullptr), TOUCHSTONE_BAD_INPUT);
  EXPECT_STREQ(touchstone_error(), "force_W: is NULL");
  EXPECT_EQ(touchstone_find_simulated_object(run.get(), "no such box", &number), TOUCHSTONE_BAD_INPUT);
  EXPECT_EQ(touchstone_get_object_states(run.get(), nullptr, 1), TOUCHSTONE_BAD_INPUT);
  std::vector<touchstone_object_state> more(states(run).size() + 1);
  EXPECT_EQ(touchstone_get_object_states(run.get(), more.data(), more.size()), TOUCHSTONE_BAD_INPUT);
  touchstone_destroy_simulation(nullptr);
  touchstone_destroy_saved_run(nullptr);
}

}  // namespace
}  // namespace touchstone
