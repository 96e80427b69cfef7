// Dynamics whose motion a contact world executes: what is shown never merges, what is cut comes back as
// impulse.

#include "touchstone/physics/guarded/guarded_simulation.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/contact_core/native/native.hpp"
#include "touchstone/contact_core/registry.hpp"
#include "touchstone/tests/physics/hand_made_scene.hpp"
#include "touchstone/tests/support/counting_allocator.hpp"
#ifdef TOUCHSTONE_HAS_EXACT
#include "touchstone/adapters/exact/exact.hpp"
#include "touchstone/contact_core/geometry/constants.hpp"
#endif

namespace touchstone::physics {
namespace {

constexpr double kGap = 1e-7;
/// Half of it, less rounding of separations in scenes of this size.
constexpr double kLeast = 0.5 * kGap - 1e-14;

std::unique_ptr<Broadphase> native_broadphase() {
  BackendRegistry registry;
  register_core(registry);
  return registry.make_broadphase("native");
}

/// Sees no contact, so that all that dynamics does is cut.
class Blind final : public Narrowphase {
 public:
  std::string_view name() const noexcept override { return "blind"; }
  const Capabilities& capabilities() const noexcept override { return native_->capabilities(); }
  void build(std::span<const Hexahedron> solids) override { native_->build(solids); }
  std::unique_ptr<Workspace> make_workspace() const override { return native_->make_workspace(); }
  void evaluate(const NarrowphaseInput& input, const NarrowphaseOutput& output,
                Workspace&) const noexcept override {
    const Vector3 none = Vector3::Constant(kNaN);
    for (std::size_t i = 0; i < input.pairs.size(); ++i) {
      output.status[i] = PairStatus::separated;
      output.geometry[i] = {kInfinity, none, none, none, 0};
    }
  }

 private:
  std::unique_ptr<Narrowphase> native_ = make_native();
};

std::unique_ptr<Narrowphase> make_blind() { return std::make_unique<Blind>(); }

GuardedSimulation guarded(const DynamicScene& scene, const GuardSettings& settings = {},
                          GuardedSimulation::MakeNarrowphase contacts = nullptr) {
  return GuardedSimulation(scene, settings, make_native, native_broadphase, std::move(contacts));
}

SceneBody rough_body(double mass, const Vector3& size, double friction, const Vector3& v_W = kZero) {
  SceneBody body = free_body(mass, size, v_W);
  body.surface = {friction, 0.0};
  return body;
}

/// Signed distance of two objects of one hexahedron each, as shown.
double shown_separation(const DynamicScene& scene, const GuardedSimulation& run, std::size_t a,
                        std::size_t b) {
  const auto native = make_native();
  const PlacedHexahedron &solid_a = scene.scene.objects[a].tree.solids()[0],
                         &solid_b = scene.scene.objects[b].tree.solids()[0];
  const std::vector<Hexahedron> solids{solid_a.solid, solid_b.solid};
  native->build(solids);
  const auto workspace = native->make_workspace();
  const std::vector<Pose> poses{compose(run.shown_pose(a), solid_a.X_OS),
                                compose(run.shown_pose(b), solid_b.X_OS)};
  const SolidPair pair{0, 1};
  PairStatus status{};
  PairGeometry geometry{};
  native->evaluate({{&pair, 1}, poses, {QueryKind::distance}}, {{&status, 1}, {&geometry, 1}, {}},
                   *workspace);
  return geometry.separation;
}

TEST(GuardedSimulation, PushedAgainstAWallItStandsAtTheGap) {
  DynamicScene scene = empty_scene(0.5);
  scene.gravity_W = {-4, 0, 0};
  const Vector3 size(0.2, 0.2, 0.2);
  add(scene, box("wall", {1, 1, 1}, at({-0.5, 0, 0})), {});
  add(scene, box("mass", size, at({0.3, 0, 0})), free_body(3, size));
  GuardedSimulation run = guarded(scene);
  std::uint32_t cut = 0;
  while (!run.is_over()) {
    const GuardedStep step = run.step();
    ASSERT_EQ(step.dynamics.failure, StepFailure::none);
    cut += step.cut;
    ASSERT_GE(shown_separation(scene, run, 0, 1), kLeast);
  }
  EXPECT_EQ(cut, 0U);  // dynamics sees the wall: nothing is left to take
  EXPECT_NEAR(shown_separation(scene, run, 0, 1), kGap, 2e-9);
  EXPECT_LT(norm(*run.simulation().velocity(1)), 1e-9);
  Vector3 force = kZero;
  for (const ContactForce& each : run.simulation().forces()) force += each.force_W;
  EXPECT_NEAR(norm(force), 12.0, 1e-7);
}

TEST(GuardedSimulation, AWallThatDynamicsDoesNotSeeTakesTheMomentum) {
  for (const double bounce : {0.0, 0.5}) {
    DynamicScene scene = empty_scene(0.3);
    const Vector3 size(0.2, 0.2, 0.2);
    add(scene, box("wall", {1, 1, 1}, at({-0.5, 0, 0})), {});
    add(scene, box("mass", size, at({0.2, 0, 0})), free_body(3, size, {-1, 0.25, 0}));
    scene.bodies[1].surface.restitution = bounce;
    GuardedSimulation run = guarded(scene, {}, make_blind);
    Vector3 taken = kZero;
    double energy = 0.0;
    while (!run.is_over()) {
      const GuardedStep step = run.step();
      EXPECT_LT(norm(step.linear_W - step.impulses.impulse_W), 1e-14);
      taken += step.impulses.impulse_W;
      energy += step.energy;
      ASSERT_GE(shown_separation(scene, run, 0, 1), kLeast);
    }
    EXPECT_LT(norm(taken - Vector3(3 * (1 + bounce), 0, 0)), 1e-13);
    EXPECT_NEAR(energy, -1.5 * (1 - bounce * bounce), 1e-13);
    EXPECT_LT(norm(*run.simulation().velocity(1) - Vector3(bounce, 0.25, 0)), 1e-14);  // no friction in a cut
    EXPECT_NEAR(run.shown_pose(1).p.y(), 0.3 * 0.25, 1e-3);  // it slides on; a step's rest is lost
  }
}

TEST(GuardedSimulation, ACutBetweenFreeBodiesKeepsTheirMomentum) {
  DynamicScene scene = empty_scene(0.4);
  const Vector3 size(0.2, 0.2, 0.2);
  add(scene, box("a", size, at({-0.2, 0, 0})), free_body(3, size, {1, 0, 0}));
  add(scene, box("b", size, at({0.2, 0.05, 0.02})), free_body(1, size, {-0.5, 0.1, 0}, {0.3, 0.2, 0.1}));
  GuardedSimulation run = guarded(scene, {}, make_blind);
  const Vector3 before = run.simulation().world().linear_momentum();
  double worst_energy = 0.0;
  std::uint32_t cut = 0;
  while (!run.is_over()) {
    const GuardedStep step = run.step();
    cut += step.cut;
    worst_energy = std::max(worst_energy, step.energy);
    EXPECT_LT(norm(step.linear_W), 1e-14);
    // Only that they were held back of their way turns the momentum about the origin.
    EXPECT_LE(norm(step.angular_W), step.held_back * 4.0 + 1e-14);
    ASSERT_GE(shown_separation(scene, run, 0, 1), kLeast);
  }
  EXPECT_GT(cut, 0U);
  EXPECT_LT(norm(run.simulation().world().linear_momentum() - before), 1e-13);
  EXPECT_LT(worst_energy, 1e-14);
}

TEST(GuardedSimulation, PoliciesArePerPair) {
  const Vector3 size(0.2, 0.2, 0.2);
  struct Case {
    GuardPolicy policy;
    double speed, least, most;  // at the end; where
  };
  // 0.6 m/s along x from 0.5 m before the wall's face, and 0.3 along y: at the face after 0.667 s of 1 s.
  for (const Case& c : {Case{GuardPolicy::cue, 0.6, 0.5999, 0.6001}, Case{GuardPolicy::hold, 0, 0.399, 0.4},
                        Case{GuardPolicy::advance, 0, 0.3999, 0.4}, Case{GuardPolicy::slide, 0, 0.3999, 0.4},
                        Case{GuardPolicy::push, 0, 0.3999, 0.4}}) {
    SCOPED_TRACE(to_string(c.policy));
    DynamicScene scene = empty_scene(1.0);
    add(scene, box("wall", {1, 4, 1}, at({1, 0, 0})), {});
    add(scene, box("mass", size, at({0, 0, 0})), free_body(2, size, {0.6, 0.3, 0}));
    GuardSettings settings;
    settings.policy = GuardPolicy::push;
    settings.rules = {{"mass", "wall", c.policy}};
    GuardedSimulation run = guarded(scene, settings);
    Vector3 held = kZero;
    while (!run.is_over()) held += run.step().held_W;
    const Vector3 v = *run.simulation().velocity(1);
    const bool stands = c.policy == GuardPolicy::hold || c.policy == GuardPolicy::advance;
    EXPECT_NEAR(v.x(), c.speed, 1e-9);
    EXPECT_NEAR(v.y(), stands ? 0.0 : 0.3, 1e-9);
    EXPECT_LT(norm(held - (stands ? Vector3(1.2, 0.6, 0) : kZero)), 1e-12);
    EXPECT_GE(run.shown_pose(1).p.x(), c.least);
    EXPECT_LE(run.shown_pose(1).p.x(), c.most);
  }
}

/// A rod along x on a pivot at the origin, its far end's +y side before a block.
DynamicScene rod_and(const SceneObject& other, const SceneBody& body, double limit, double duration) {
  DynamicScene scene = empty_scene(duration);
  const Vector3 rod(1.0, 0.1, 0.1);
  add(scene, box("rod", rod, at({0.5, 0, 0})), {.kind = BodyKind::link, .inertia = box_inertia(4, rod)});
  scene.bodies[0].surface = {0.0, 0.0};
  add(scene, other, body);
  SceneMechanism arm{"arm", {pivot(0, kZero)}, {}};
  arm.joints[0].effort = limit;
  scene.mechanisms.push_back(arm);
  return scene;
}

TEST(GuardedSimulation, AnArmStallsWhereItsTorqueEnds) {
  // The hand wants the rod's end up at 0.2 m/s; a fixed edge stands above x = 0.9 m: the force there is 6 N m
  // / 0.9 m.
  const DynamicScene scene =
      rod_and(box("block", {0.1, 0.1, 0.1}, at({0.95, 0.13, 0})), {.surface = {0.0, 0.0}}, 6.0, 1.0);
  GuardedSimulation run = guarded(scene);
  const std::size_t hand = run.add_hand({.link = 0, .p_O = {0.5, 0, 0}});
  while (!run.is_over()) {
    run.command(hand, {{0, 0.2, 0}, kZero});
    ASSERT_EQ(run.step().dynamics.failure, StepFailure::none);
    ASSERT_GE(shown_separation(scene, run, 0, 1), kLeast);
  }
  EXPECT_LT(std::abs(run.simulation().joint_rate({0, 0})), 1e-9);
  EXPECT_NEAR(run.simulation().joint_torque({0, 0}), 6.0, 1e-6);
  // J^-T tau: the moment of the contact force about the pivot.
  double moment = 0.0;
  for (std::size_t i = 0; i < run.simulation().contacts().size(); ++i) {
    const Contact& contact = run.simulation().contacts()[i];
    moment += cross(contact.p_A_W, run.simulation().forces()[i].force_W).z();
  }
  EXPECT_NEAR(std::abs(moment), 6.0, 1e-6);
}

TEST(GuardedSimulation, AnArmIsDrivenBackByMoreThanItsTorque) {
  // A block on a slide pushes down with 10 N on the rod at x = 0.9 (its edge): the hand holds against it with
  // 6 N m.
  const Vector3 size(0.2, 0.1, 0.1);
  DynamicScene scene =
      rod_and(box("block", size, at({1.0, 0.1 + 2e-7, 0})),
              {.kind = BodyKind::link, .inertia = box_inertia(2, size), .surface = {0.0, 0.0}}, 6.0, 0.05);
  SceneJoint slide;
  slide.name = "slide", slide.kind = JointKind::prismatic, slide.child = 1, slide.axis_W = {0, 1, 0};
  slide.drive.drive.torque = -10.0;
  scene.mechanisms.push_back({"pusher", {slide}, {}});
  GuardedSimulation run = guarded(scene);
  const std::size_t hand = run.add_hand({.link = 0, .p_O = {0.5, 0, 0}});
  while (!run.is_over()) {
    run.command(hand, {{0, 0.2, 0}, kZero});
    ASSERT_EQ(run.step().dynamics.failure, StepFailure::none);
    ASSERT_GE(shown_separation(scene, run, 0, 1), kLeast);
  }
  // At small angles the two go as one, the block's edge on the rod: lever 0.9 m; the rod has 4/3 kg m2 and,
  // for its width, 4 0.01 / 12.
  const double expected = (10.0 * 0.9 - 6.0) / (4.0 / 3.0 + 4.0 * 0.01 / 12.0 + 2.0 * 0.81);
  EXPECT_LT(run.simulation().joint_rate({0, 0}), 0.0);
  EXPECT_NEAR(run.simulation().joint_rate({0, 0}), -expected * 0.05, 0.005 * expected * 0.05);
  EXPECT_NEAR(run.simulation().joint_torque({0, 0}), 6.0, 1e-9);
}

TEST(GuardedSimulation, AHandPressedOnAPlateGoesAlongItAsFrictionLets) {
  // A gantry's hand, wanted at 0.1 m/s along a plate and as fast into it: 40 N at most along, 100 N into.
  // Where 100 N times friction is less it goes on at its rate, else it stands.
  struct Case {
    GuardPolicy policy;
    double friction, speed;
  };
  const Vector3 size(0.2, 0.2, 0.2);
  for (const Case& c : {Case{GuardPolicy::slide, 0.5, 0.1}, Case{GuardPolicy::push, 0.0, 0.1},
                        Case{GuardPolicy::push, 0.1, 0.1}, Case{GuardPolicy::push, 0.3, 0.1},
                        Case{GuardPolicy::push, 0.6, 0.0}}) {
    SCOPED_TRACE(c.friction);
    DynamicScene scene = empty_scene(1.0);
    const SceneBody link{.kind = BodyKind::link, .inertia = box_inertia(3, size), .surface = {c.friction, 0}};
    add(scene, box("plate", {2, 2, 0.2}, at({0, 0, -0.1})), {.surface = {c.friction, 0}});
    add(scene, box("beam", size, at({-0.5, 0, 2})), link);
    add(scene, box("hand", size, at({-0.5, 0, 0.11})), link);
    SceneJoint along, into;
    along.name = "along", along.kind = JointKind::prismatic, along.child = 1, along.axis_W = {1, 0, 0};
    into.name = "into", into.kind = JointKind::prismatic, into.parent = 1, into.child = 2;
    into.axis_W = {0, 0, 1};
    along.effort = 40.0, into.effort = 100.0;
    scene.mechanisms.push_back({"gantry", {along, into}, {}});
    GuardSettings settings;
    settings.policy = c.policy;
    GuardedSimulation run = guarded(scene, settings);
    // Two joints for six rates are damped always: so little takes 1e-8 of the rates.
    const std::size_t hand = run.add_hand({.link = 2, .rates = {.damping = 1e-4}});
    run.command(hand, {{0.1, 0, -0.1}, kZero});
    double met_at = 0.0;
    while (!run.is_over()) {
      const double before = run.shown_pose(2).p.x();
      ASSERT_EQ(run.step().dynamics.failure, StepFailure::none);
      ASSERT_GE(shown_separation(scene, run, 0, 2), kLeast);
      if (shown_separation(scene, run, 0, 2) < 2 * kGap && met_at == 0.0) met_at = run.simulation().time();
      // What is shown goes as the rates say, in each step, once the impact is over.
      if (met_at > 0.0 && run.simulation().time() > met_at + 0.1) {
        ASSERT_NEAR((run.shown_pose(2).p.x() - before) / scene.step, c.speed, 1e-8);
      }
    }
    EXPECT_NEAR(met_at, 0.1, 0.02);
    EXPECT_NEAR(run.simulation().joint_rate({0, 0}), c.speed, 1e-8);
  }
}

TEST(GuardedSimulation, ABoxSlidesToAStopByFrictionAndNeverMerges) {
  DynamicScene scene = empty_scene(1.0);
  scene.gravity_W = {0, 0, -9.81};
  const Vector3 size(0.4, 0.4, 0.2);
  add(scene, box("floor", {10, 10, 1}, at({0, 0, -0.5})), {.surface = {0.5, 0.0}});
  add(scene, box("box", size, at({0, 0, 0.1 + kGap})), rough_body(5, size, 0.5, {2, 0, 0}));
  GuardedSimulation run = guarded(scene);
  while (!run.is_over()) {
    run.step();
    ASSERT_GE(shown_separation(scene, run, 0, 1), kLeast);
  }
  EXPECT_NEAR(run.shown_pose(1).p.x(), 4.0 / (2.0 * 0.5 * 9.81), 1e-6);
  EXPECT_LT(norm(*run.simulation().velocity(1)), 1e-9);
}

/// Boxes that fall on a floor, a rod that sweeps through them; policies of all kinds.
DynamicScene crowd(unsigned seed, bool is_reversed = false) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  const auto vector = [&](double scale) {
    return Vector3(scale * unit(random), scale * unit(random), scale * unit(random));
  };
  // A rod on a pivot above a floor.
  DynamicScene scene =
      rod_and(box("floor", {6, 6, 1}, at({0, 0, -0.8})), {.surface = {0.3, 0.0}}, 400.0, 0.3);
  scene.gravity_W = {0, 0, -9.81};
  struct Part {
    SceneObject object;
    SceneBody body;
  };
  // Six boxes that fly about.
  std::vector<Part> parts;
  for (int i = 0; i < 6; ++i) {
    const Vector3 size(0.2 + 0.1 * unit(random), 0.2 + 0.1 * unit(random), 0.2 + 0.1 * unit(random));
    Vector3 axis = vector(1.0);
    const Pose X{rotation_about(axis / norm(axis), 3.0 * unit(random)),
                 Vector3(0.3 + 0.5 * (i % 3), i < 3 ? 0.4 : -0.4, 0.1 + 0.1 * unit(random))};
    SceneBody body = free_body(1.0 + 0.5 * unit(random), size, vector(2.0), vector(6.0));
    body.surface = {0.3, 0.2};
    parts.push_back({box("part " + std::to_string(i), size, X), body});
  }
  // In order, or in reverse.
  if (is_reversed) std::reverse(parts.begin(), parts.end());
  for (const Part& part : parts) add(scene, part.object, part.body);
  return scene;
}

GuardSettings mixed_rules() {
  GuardSettings settings;
  settings.rules = {{"part 0", "floor", GuardPolicy::hold},
                    {"part 1", "rod", GuardPolicy::slide},
                    {"part 2", "part 1", GuardPolicy::advance},
                    {"part 3", "rod", GuardPolicy::hold}};
  return settings;
}

/// The crowd with three joints between bodies: a ball, a fixed one, and a ball on the rod.
DynamicScene joined_crowd(unsigned seed) {
  DynamicScene scene = crowd(seed);
  const auto join = [&](const char* name, BodyJointKind kind, std::size_t parent, std::size_t child) {
    SceneBodyJoint joint;
    joint.name = name;
    joint.kind = kind;
    joint.parent = parent, joint.child = child;
    const Vector3 sum = scene.scene.objects[parent].X_WO.p + scene.scene.objects[child].X_WO.p;
    joint.p_W = parent == 0 ? scene.scene.objects[child].X_WO.p : Vector3(0.5 * sum);
    scene.joints.push_back(joint);
  };
  join("ball", BodyJointKind::ball, 2, 3);
  join("fixed", BodyJointKind::fixed, 4, 5);
  join("on the rod", BodyJointKind::ball, 0, 6);
  return scene;
}

bool are_joined(const DynamicScene& scene, const SolidPair& pair) {
  return std::any_of(scene.joints.begin(), scene.joints.end(), [&](const SceneBodyJoint& joint) {
    return (joint.parent == pair.a && joint.child == pair.b) ||
           (joint.parent == pair.b && joint.child == pair.a);
  });
}

/// Two cubes joined by a ball fly at a wall that dynamics does not see: one is stopped, and the other with
/// it.
TEST(GuardedSimulation, WhatAJointHoldsToWhatWasCutFollowsIt) {
  for (const GuardPolicy policy : {GuardPolicy::push, GuardPolicy::advance, GuardPolicy::hold}) {
    // Two boxes on a ball joint fly at a wall, of which dynamics sees nothing.
    DynamicScene scene = empty_scene(0.6);
    const Vector3 size(0.2, 0.2, 0.2);
    add(scene, box("wall", {1, 1, 1}, at({-0.5, 0, 0})), {});
    add(scene, box("first", size, at({0.2, 0, 0})), free_body(3, size, {-1, 0.1, 0}));
    add(scene, box("second", size, at({0.6, 0.05, 0})), free_body(1, size, {-1, 0.1, 0}));
    SceneBodyJoint joint;
    joint.name = "ball", joint.kind = BodyJointKind::ball, joint.parent = 1, joint.child = 2;
    joint.p_W = {0.4, 0, 0};
    scene.joints.push_back(joint);
    GuardedSimulation run = guarded(scene, {.policy = policy}, make_blind);
    // The first is cut at the wall, and the second stays with it.
    double worst = 0.0, fastest = 0.0;
    std::uint32_t cut = 0;
    while (!run.is_over()) {
      const GuardedStep step = run.step();
      ASSERT_EQ(step.dynamics.failure, StepFailure::none);
      for (std::size_t i : {1, 2}) ASSERT_GE(shown_separation(scene, run, 0, i), kLeast) << i;
      worst = std::max(worst, step.joint_error);
      fastest = std::max(fastest, norm(*run.simulation().velocity(2)));
      cut += step.cut;
    }
    EXPECT_GT(cut, 0U);
    EXPECT_LT(worst, 1e-9) << to_string(policy);
    EXPECT_LT(fastest, 1.2) << to_string(policy);  // nobody is shot off
    std::printf("  %s: %u cut, joint off by %.2e, fastest %.3f m/s\n", to_string(policy).data(), cut, worst,
                fastest);
  }
}

/// A pair that a joint joins is checked again once it has let go, and no more once it holds again.
TEST(GuardedSimulation, JointsLetTheirPairThroughWhileTheyHold) {
  // A slider joins two bodies that fly at each other, until 0.05 s.
  DynamicScene scene = empty_scene(0.6);
  const Vector3 size(0.2, 0.2, 0.2);
  add(scene, box("a", size, at({0, 0, 0})), free_body(3, size));
  add(scene, box("b", size, at({0.3, 0, 0})), free_body(1, size, {-1, 0, 0}));
  SceneBodyJoint joint;
  joint.name = "slide", joint.kind = BodyJointKind::slider, joint.parent = 0, joint.child = 1;
  joint.axis_W = {1, 0, 0};
  scene.joints.push_back(joint);
  SceneAction part;
  part.kind = SceneAction::Kind::part;
  part.time = 0.05;
  part.joint = {JointAddress::kBodyJoint, 0};
  scene.actions.push_back(part);
  // Parted they meet.
  GuardedSimulation run = guarded(scene, {}, make_blind);
  while (!run.is_over()) {
    ASSERT_EQ(run.step().dynamics.failure, StepFailure::none);
    ASSERT_GE(shown_separation(scene, run, 0, 1), kLeast);
  }
  EXPECT_GT(run.shown_pose(0).p.x(), -0.3);  // pushed along from 0.05 s on, by what met it at 0.1 s
  EXPECT_NEAR(run.simulation().world().linear_momentum().x(), -1.0, 1e-12);

  // Joined for good they pass.
  scene.actions.clear();
  GuardedSimulation held = guarded(scene, {}, make_blind);
  double least = kInfinity;
  while (!held.is_over()) {
    ASSERT_EQ(held.step().dynamics.failure, StepFailure::none);
    least = std::min(least, shown_separation(scene, held, 0, 1));
  }
  EXPECT_LT(least, -0.1);  // through each other, as in dynamics
}

#ifdef TOUCHSTONE_HAS_EXACT
/// Counts pairs of a run that `exact` finds in each other, over all steps; those that a joint joins apart.
/// @param joint_error raised to the run's
std::size_t merged(const DynamicScene& scene, GuardedSimulation& run, double* joint_error = nullptr) {
  BackendRegistry registry;
  register_exact(registry);
  const auto exact = registry.make_narrowphase("exact");
  std::vector<Hexahedron> solids;
  std::vector<SolidPair> pairs;
  for (const SceneObject& object : scene.scene.objects) solids.push_back(object.tree.solids()[0].solid);
  for (SolidIndex b = 0; b < solids.size(); ++b)
    for (SolidIndex a = 0; a < b; ++a)
      if (!are_joined(scene, {a, b})) pairs.push_back({a, b});
  exact->build(solids);
  const auto workspace = exact->make_workspace();
  std::vector<Pose> poses(solids.size());
  std::vector<PairStatus> status(pairs.size());
  std::size_t count = 0;
  while (!run.is_over()) {
    const GuardedStep step = run.step();
    EXPECT_EQ(step.dynamics.failure, StepFailure::none);
    if (joint_error != nullptr) *joint_error = std::max(*joint_error, step.joint_error);
    for (std::size_t i = 0; i < poses.size(); ++i) poses[i] = run.shown_pose(i);
    exact->evaluate({pairs, poses, {QueryKind::overlap}}, {status, {}, {}}, *workspace);
    for (const PairStatus each : status) count += each != PairStatus::separated ? 1 : 0;
  }
  return count;
}

/// A hand pushes at the first body of a crowd, with dynamics that see contacts and blind: nothing shown
/// merges. Returns how far joints came apart at most [m].
double expect_nothing_merges(const DynamicScene& scene, unsigned seed) {
  SCOPED_TRACE(seed);
  double worst_error = 0.0;
  for (const bool is_blind : {false, true}) {
    GuardedSimulation run =
        is_blind ? guarded(scene, mixed_rules(), make_blind) : guarded(scene, mixed_rules());
    const std::size_t hand = run.add_hand({.link = 0, .p_O = {0.5, 0, 0}});
    run.command(hand, {{0, seed % 2 ? 1.0 : -1.0, 0}, kZero});
    double joint_error = 0.0;
    EXPECT_EQ(merged(scene, run, &joint_error), 0U) << (is_blind ? "blind" : "seeing");
    worst_error = std::max(worst_error, joint_error);
  }
  return worst_error;
}

TEST(GuardedSimulation, NoShownPoseMergesWhateverDynamicsSees) {
  for (unsigned seed = 1; seed <= 6; ++seed) expect_nothing_merges(crowd(seed), seed);
}

TEST(GuardedSimulation, NoShownPoseMergesWithJointsBetweenBodies) {
  for (unsigned seed = 21; seed <= 26; ++seed) {
    const double joint_error = expect_nothing_merges(joined_crowd(seed), seed);
    std::printf("  seed %u: joints off by %.2e\n", seed, joint_error);
    EXPECT_LT(joint_error, 2e-2) << seed;
  }
}
#endif

TEST(GuardedSimulation, AStepAllocatesNothing) {
  for (const auto& [is_joined, is_blind] :
       {std::pair(false, false), std::pair(false, true), std::pair(true, false), std::pair(true, true)}) {
    const DynamicScene scene = is_joined ? joined_crowd(3) : crowd(3);
    GuardedSimulation run =
        is_blind ? guarded(scene, mixed_rules(), make_blind) : guarded(scene, mixed_rules());
    const std::size_t hand = run.add_hand({.link = 0, .p_O = {0.5, 0, 0}});
    run.command(hand, {{0, 1.0, 0}, kZero});
    std::size_t allocated = 0;
    for (int i = 0; !run.is_over(); ++i) {
      const std::size_t before = allocation_count();
      run.step();
      if (i >= 100) allocated += allocation_count() - before;  // warm
    }
    EXPECT_EQ(allocated, 0U) << is_blind << is_joined;
  }
}

TEST(GuardedSimulation, OrderOfRegistrationDoesNotShow) {
  // Contacts are many and friction is Coulomb's: what rounding takes grows in chaos, so the runs are short.
  for (unsigned seed = 1; seed <= 4; ++seed) {
    DynamicScene scene = crowd(seed), reversed = crowd(seed, true);
    scene.scene.duration = reversed.scene.duration = 0.1;
    GuardedSimulation one = guarded(scene), other = guarded(reversed);
    while (!one.is_over()) {
      one.step();
      other.step();
    }
    const std::size_t n = scene.scene.objects.size();
    for (std::size_t i = 2; i < n; ++i)
      EXPECT_LT(norm(one.shown_pose(i).p - other.shown_pose(n + 1 - i).p), 1e-8) << seed << " " << i;
  }
}

TEST(GuardedSimulation, BodiesComeAndGoWhereThereIsRoom) {
  DynamicScene scene = empty_scene(1.0);
  scene.gravity_W = {0, 0, -10};
  const Vector3 size(0.2, 0.2, 0.2), away(0.5, 0, 0.15);
  add(scene, box("floor", {4, 4, 1}, at({0, 0, -0.5})), {});
  add(scene, box("rests", size, at({0, 0, 0.1 + 1e-6})), free_body(3, size));
  add(scene, box("comes", size, at({0, 0, 3})), free_body(3, size));
  GuardedSimulation run = guarded(scene);
  const auto go = [&](int steps) {
    for (int i = 0; i < steps; ++i) {
      ASSERT_EQ(run.step().dynamics.failure, StepFailure::none);
      const bool is_1 = run.simulation().has(1), is_2 = run.simulation().has(2);
      ASSERT_TRUE(!is_1 || shown_separation(scene, run, 0, 1) >= kLeast);
      ASSERT_TRUE(!is_2 || shown_separation(scene, run, 0, 2) >= kLeast);
      ASSERT_TRUE(!(is_1 && is_2) || shown_separation(scene, run, 1, 2) >= kLeast);
    }
  };
  run.remove(2);
  EXPECT_THROW(run.remove(2), InputError);
  go(50);
  EXPECT_EQ(run.shown_pose(2).p.z(), 3.0);
  // Not into what is there, nor nearer than half of the gap; all goes on as before.
  for (const double height : {0.25, run.shown_pose(1).p.z() + 0.2 + 0.4 * kGap})
    EXPECT_THROW(run.add(2, at({0, 0, height}), kZero, kZero), InputError) << height;
  // Nor edge on edge, or corner on corner.
  for (const double y : {0.0, 0.2})
    EXPECT_THROW(run.add(2, at(run.shown_pose(1).p + Vector3(0.2, y, 0.2)), kZero, kZero), InputError) << y;
  EXPECT_FALSE(run.simulation().has(2));
  go(10);
  EXPECT_EQ(run.shown_pose(2).p.z(), 3.0);
  // What was switched off comes in switched off, and then is where others may be.
  run.select(2, false);
  run.add(2, run.shown_pose(1), kZero, kZero);
  run.remove(2);
  run.select(2, true);
  // Beside it, where it falls and comes to rest a gap above the floor; then on top, and away from there.
  run.add(2, at(away), kZero, kZero);
  EXPECT_EQ(run.shown_pose(2).p, away);
  go(300);
  EXPECT_NEAR(shown_separation(scene, run, 0, 2), kGap, 2e-9);
  run.remove(2);
  run.add(2, at({0, 0, 0.31}), kZero, kZero);
  go(300);
  EXPECT_NEAR(shown_separation(scene, run, 1, 2), kGap, 2e-9);
  // What lies on it falls when it is switched off.
  const Pose bears = run.shown_pose(1), lies = run.shown_pose(2);
  run.select(1, false);
  for (int i = 0; i < 100; ++i) ASSERT_EQ(run.step().dynamics.failure, StepFailure::none);
  EXPECT_NEAR(run.shown_pose(2).p.z(), lies.p.z() - 0.05, 1e-3);
  for (const std::size_t object : {1u, 2u}) run.remove(object);
  run.select(1, true);
  run.add(1, bears, kZero, kZero);
  run.add(2, lies, kZero, kZero);
  go(10);
  EXPECT_NEAR(run.shown_pose(2).p.z(), lies.p.z(), 1e-8);
  run.remove(1);
  run.select(1, true);  // out all the same: it bears nothing
  go(300);
  EXPECT_NEAR(shown_separation(scene, run, 0, 2), kGap, 2e-9);
  // And through what it may pass from now on.
  run.set_policy(GuardPolicy::cue);
  for (int i = 0; i < 100; ++i) ASSERT_EQ(run.step().dynamics.failure, StepFailure::none);
  EXPECT_NEAR(run.shown_pose(2).p.z(), 0.05, 1e-3);
}

TEST(GuardedSimulation, WhatStandsOverASlotOfItsWidthGathersNoMomentum) {
  // On an edge at either side, which the proof lets nothing pass.
  const Vector3 size(0.2, 0.2, 0.2);
  for (const GuardPolicy policy : {GuardPolicy::push, GuardPolicy::slide})
    for (const double drop : {1e-6, 1e-4, 1e-2}) {
      DynamicScene scene = empty_scene(1.0);
      scene.gravity_W = {0, 0, -10};
      for (const double side : {-1.0, 1.0})
        add(scene, box(side < 0.0 ? "left" : "right", size, at({0.2 * side, 0, 0.1})), {});
      add(scene, box("falls", size, at({0, 0, 0.3 + drop})), free_body(3, size));
      GuardSettings settings;
      settings.policy = policy;
      GuardedSimulation run = guarded(scene, settings);
      double fastest = 0.0;
      for (int i = 0; i < 500; ++i) {
        ASSERT_EQ(run.step().dynamics.failure, StepFailure::none);
        for (const std::size_t wall : {0U, 1U}) ASSERT_GE(shown_separation(scene, run, wall, 2), kLeast);
        if (i > 100) fastest = std::max(fastest, norm(*run.simulation().velocity(2)));
      }
      EXPECT_LT(fastest, 1.5 * 10 * scene.step) << static_cast<int>(policy) << " " << drop;
      EXPECT_NEAR(run.shown_pose(2).p.z(), 0.3, 2e-6) << static_cast<int>(policy) << " " << drop;
    }
}

TEST(GuardedSimulation, RefusesWhatItCannotGuard) {
  DynamicScene scene = empty_scene(0.1);
  const Vector3 size(0.2, 0.2, 0.2);
  add(scene, box("a", size, at({0, 0, 0})), free_body(3, size));
  GuardSettings settings;
  settings.rules = {{"a", "nobody", GuardPolicy::hold}};
  EXPECT_THROW(guarded(scene, settings), InputError);
  settings.rules.clear();
  settings.gap = 5e-9;
  EXPECT_THROW(guarded(scene, settings), InputError);
  settings.gap = 1e-7;
  GuardedSimulation run = guarded(scene, settings);
  EXPECT_THROW(run.add_hand({.link = 0}), InputError);
}

}  // namespace
}  // namespace touchstone::physics
