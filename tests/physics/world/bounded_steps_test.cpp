// Steps that are bounded: islands of any size, and contacts that contradict each other.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <list>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "touchstone/contact_core/geometry/matrix3.hpp"
#include "touchstone/tests/physics/arms.hpp"
#include "touchstone/tests/physics/cubes.hpp"

namespace touchstone::physics {
namespace {

/// Evenly between two limits, the same from every standard library.
class Draw {
 public:
  explicit Draw(std::uint32_t seed) : random_(seed) {}
  double operator()(double low, double high) {
    return low + (high - low) * static_cast<double>(random_()) / 4294967296.0;
  }

 private:
  std::mt19937 random_;
};

TEST(BoundedSteps, JawsThatSqueezeHoldTheCubeAtOnce) {
  // Nothing gives way but the cube, which cannot: both jaws go on.
  Cubes scene;
  scene.add_driven({-0.2005, 0, 1}, {0.05, 0, 0});
  scene.add_driven({0.2005, 0, 1}, {-0.05, 0, 0});
  const auto cube = scene.add_cube({0, 0, 1});
  scene.contacts->build();
  std::uint32_t contradictory = 0;
  for (int i = 0; i < 400; ++i) {
    const StepReport report = scene.step(1e-3);
    ASSERT_EQ(report.failure, StepFailure::none);
    // Once contradiction is found, other means are not tried first.
    EXPECT_LT(report.newton_steps, contradictory == 0 ? 400U : 12U) << i;
    EXPECT_LE(report.contradictory, report.unconverged);
    contradictory += report.contradictory;
    EXPECT_LT(norm(scene.world.velocity(cube)), 0.15) << i;  // it falls for 10 ms before it is met
  }
  EXPECT_GT(contradictory, 300U);
  EXPECT_LT(norm(scene.world.velocity(cube)), 1e-3);
}

TEST(BoundedSteps, ASqueezeIsFoundInTheStepThatBeginsIt) {
  // Sizes, offsets and speeds as drawn: what presses from two sides is tried softly first.
  Draw draw(1601);
  for (int run = 0; run < 20; ++run) {
    Cubes scene;
    const double speed = draw(0.01, 0.3), y = draw(-0.05, 0.05), z = draw(-0.05, 0.05);
    scene.add_driven({-0.2 - draw(1e-4, 2e-3), y, 1 + z}, {speed, 0, 0});
    scene.add_driven({0.2 + draw(1e-4, 2e-3), -y, 1 - z}, {-speed, 0, 0});
    const auto cube = scene.add_cube({0, 0, 1});
    scene.contacts->build();
    bool is_found = false;
    for (int i = 0; i < 300; ++i) {
      const StepReport report = scene.step(1e-3);
      ASSERT_EQ(report.failure, StepFailure::none);
      is_found = is_found || report.contradictory > 0;
      EXPECT_LT(report.newton_steps, 40U) << run << " at " << i;
      // Never shot out: no faster than what drives it and what it fell before.
      EXPECT_LT(norm(scene.world.velocity(cube)), 2.0 * speed + 9.81e-3 * (i + 1)) << run << " at " << i;
    }
    EXPECT_TRUE(is_found) << run;
  }
}

TEST(BoundedSteps, ALinkBetweenJawsYieldsAlikeWhicheverWayItsHingeStands) {
  // One jaw turns it by 0.1 rad/s, the other one back by 0.05 / 0.7: of impulses alike at both levers, which
  // yield least, 1 / 70. Along the hinge's axis the link has rounding alone: taken for a heavy body's, it
  // gave forces of 1e36 N. Without friction, so that no direction across the normal counts.
  const Arm arm{Mechanism(planar_arm(std::array{1.0})), {{}, box_inertia(2.0, {1, 0.1, 0.1})}};
  const MechanismDynamics dynamics(arm.mechanism, arm.links);
  for (const double angle : {0.0, 0.3, 0.6, 0.9, 1.2}) {
    Pose X_WB;
    X_WB.R = rotation_about({1, 0, 0}, angle);
    DynamicsWorld world({});
    const auto mechanism = world.add_mechanism(dynamics, X_WB, std::array{0.0}, std::array{0.0});
    std::array<Contact, 2> contacts;
    for (const int jaw : {0, 1}) {
      const double side = jaw == 0 ? 1.0 : -1.0;
      const Vector3 n_W = rotate(X_WB.R, Vector3(0, side, 0));
      Contact& contact = contacts[jaw];
      contact.a = Mover::of_body(world.add_kinematic(X_WB, 0.05 * n_W, Vector3::Zero()));
      contact.b = Mover::of_link(mechanism, 1);
      contact.n_AB_W = n_W;
      contact.p_A_W = contact.p_B_W = transform(X_WB, Vector3(jaw == 0 ? 0.5 : 0.7, -0.05 * side, 0));
      contact.key = jaw;
    }
    std::array<ContactForce, 2> forces;
    for (int i = 0; i < 3; ++i) {
      const StepReport report = world.step(1e-3, contacts, forces);
      ASSERT_EQ(report.failure, StepFailure::none);
      EXPECT_GT(report.contradictory, 0U) << angle;
      EXPECT_NEAR(world.joint_rates(mechanism)[0], 1.0 / 70.0, 1e-6) << angle;
      for (const ContactForce& force : forces) EXPECT_LT(norm(force.force_W), 1e5) << angle;
    }
  }
}

TEST(BoundedSteps, WhatIsDrivenAgainstAHingesAxisDoesNotTurnIt) {
  // Along the inner link, through both hinges, the inner one braked or free. An offset that the contact's
  // place is not known to turned the outer link by the speed over it: up to 1e17 rad/s, by 1e34 N.
  constexpr double kSpeed = 0.05;  // by the links' lengths [1/s]
  for (const double length : {1e-3, 1.0, 1e3}) {
    const BodyInertia inertia = box_inertia(2.0, {length, 0.1 * length, 0.1 * length});
    const Arm arm{Mechanism(planar_arm(std::array{length, length})), {{}, inertia, inertia}};
    const MechanismDynamics dynamics(arm.mechanism, arm.links);
    for (const double offset : {0.0, 1e-18, 1e-16, 1e-14, 1e-12, 1e-9})
      for (const double before : {0.0, 1e-17, 0.05})
        for (const int run : {0, 1, 2, 3}) {
          Pose X_WB;
          X_WB.R = rotation_about(Vector3(0.6, 0, 0.8), run < 2 ? 0.3 : 1.1);
          if (run % 2 == 1) X_WB.p = length * Vector3(1370, -1130, 5100);
          DynamicsWorld world({});
          const auto mechanism =
              world.add_mechanism(dynamics, X_WB, std::array{0.3, 0.7}, std::array{0.0, 0.0});
          JointDrive brake;
          brake.mode = JointDrive::Mode::brake;
          brake.limit = kInfinity;
          if (run < 2) world.set_drive(mechanism, 0, brake);
          const Vector3 along_B(std::cos(0.3), std::sin(0.3), 0), across_B(-std::sin(0.3), std::cos(0.3), 0);
          Contact contact;
          contact.n_AB_W = rotate(X_WB.R, along_B);
          contact.a =
              Mover::of_body(world.add_kinematic(X_WB, kSpeed * length * contact.n_AB_W, Vector3::Zero()));
          contact.b = Mover::of_link(mechanism, 2);
          contact.p_A_W = contact.p_B_W =
              transform(X_WB, Vector3(length * ((1.0 - before) * along_B + offset * across_B)));
          contact.friction = run % 2 == 0 ? 0.0 : 0.5;
          contact.key = 1;
          for (int i = 0; i < 3; ++i)
            ASSERT_EQ(world.step(1e-3, std::span(&contact, 1)).failure, StepFailure::none);
          for (const double rate : world.joint_rates(mechanism))
            EXPECT_LT(std::abs(rate), 1.01 * kSpeed)
                << length << ' ' << offset << ' ' << before << ' ' << run;
        }
  }
}

TEST(BoundedSteps, AFallingLinkCarriesWhatLiesOnIt) {
  // A plank on a free hinge, a mass on it at a third of its length: the plank falls beneath it by less than
  // gravity, and carries the rest. Drives and weights of links work, too: no energy is taken for giving some.
  constexpr double kGravity = 9.81, kMass = 2.0;
  for (const double at : {0.2, 1.0 / 3.0, 0.5}) {
    BodyInertia plank = box_inertia(kMass, {1.0, 0.02, 0.1});
    plank.centre_B = {0.5, 0, 0};
    const Arm arm{Mechanism(planar_arm(std::array{1.0})), {{}, plank}};
    const MechanismDynamics dynamics(arm.mechanism, arm.links);
    DynamicsWorld::Settings settings;
    settings.gravity_W = {0, -kGravity, 0};
    DynamicsWorld world(settings);
    const auto mechanism = world.add_mechanism(dynamics, {}, std::array{0.0}, std::array{0.0});
    const RigidBody load(box_inertia(1.0, {0.02, 0.02, 0.02}), "load");
    Pose X_WB;
    X_WB.p = {at, 0, 0};
    const auto body = world.add_body(load, load.state(X_WB, Vector3::Zero(), Vector3::Zero()));
    Contact contact;
    contact.a = Mover::of_link(mechanism, 1), contact.b = Mover::of_body(body);
    contact.n_AB_W = {0, 1, 0};
    contact.p_A_W = contact.p_B_W = X_WB.p;
    contact.key = 1;
    std::array<ContactForce, 1> force;
    const StepReport report = world.step(1e-3, std::span(&contact, 1), force);
    EXPECT_EQ(report.unconverged, 0U) << at;
    const double inertia = plank.inertia_B(2, 2) + 0.25 * kMass;
    const double turning = kGravity * (0.5 * kMass + at) / (inertia + at * at);
    EXPECT_NEAR(force[0].force_W.y(), kGravity - at * turning, 1e-5) << at;
  }
}

TEST(BoundedSteps, ATrayThatBeginsToSinkCarriesWhatLiesOnIt) {
  // It goes evenly in each step, faster in the next: what follows it parts from it, falls freely for a step
  // at most, and is met again.
  for (const double acceleration : {1.0, 4.0}) {
    Cubes scene;
    const auto tray = scene.add_driven({0, 0, 1}, Vector3::Zero());
    const auto cube = scene.add_cube({0, 0, 1.0 + kCubeSide});
    scene.contacts->build();
    const double h = 1e-3;
    for (int i = 0; i < 100; ++i) {
      scene.world.set_velocity(tray, {0, 0, -acceleration * h * i}, Vector3::Zero());
      const StepReport report = scene.step(h);
      EXPECT_EQ(report.unconverged, 0U) << acceleration << ' ' << i;
      EXPECT_NEAR(scene.world.velocity(cube).z(), -acceleration * h * i, 9.81 * h) << i;
    }
  }
}

TEST(BoundedSteps, WhatComesToLieOnAStackGivesNoEnergyOfItsRoom) {
  // In one piece of more than 21 points: the room beneath the topmost cube is no velocity.
  for (const double h : {1e-3, 1.0 / 240.0})
    for (const double room : {1e-7, 1e-6}) {
      Cubes scene;
      scene.add_ground();
      for (int i = 0; i < 6; ++i) scene.add_cube({0, 0, (i + 0.5) * kCubeSide + (i == 5 ? room : 0.0)});
      scene.contacts->build();
      for (int i = 0; i < 30; ++i) EXPECT_EQ(scene.step(h).unconverged, 0U) << h << ' ' << room << ' ' << i;
    }
}

TEST(BoundedSteps, AHeavyLoadRidesOnALightOneThatIsLifted) {
  // A kinematic body is no contradiction by itself, however hard it is pressed.
  for (const double mass : {150.0, 1e3, 1e4}) {
    Cubes scene;
    scene.add_driven({0, 0, -0.5 * kCubeSide}, {0, 0, 0.1});
    const auto light = scene.add_cube({0, 0, 0.5 * kCubeSide});
    const RigidBody load(box_inertia(mass, {kCubeSide, kCubeSide, kCubeSide}), "load");
    const auto heavy =
        scene.world.add_body(load, load.state(at({0, 0, 1.5 * kCubeSide}), Vector3::Zero(), Vector3::Zero()));
    scene.contacts->add(Mover::of_body(heavy), scene.cube_tree, {0.5, 0.0});
    scene.contacts->build();
    for (int i = 0; i < 500; ++i) {
      const StepReport report = scene.step(1e-3);
      ASSERT_EQ(report.failure, StepFailure::none);
      ASSERT_EQ(report.contradictory, 0U) << mass << " at " << i;
    }
    const double floor = 0.1 * 0.5;
    EXPECT_NEAR(scene.world.pose(light).p.z(), 0.5 * kCubeSide + floor, 1e-8) << mass;
    EXPECT_NEAR(scene.world.pose(heavy).p.z(), 1.5 * kCubeSide + floor, 1e-8) << mass;
  }
}

/// Boxes of any size and mass, and where they are to stay.
struct Boxes : Cubes {
  std::list<HexahedronTree> trees;
  std::vector<std::uint32_t> bodies;
  std::vector<Vector3> places;

  void add_box(const Vector3& p, const Vector3& size, double mass) {
    const RigidBody box(box_inertia(mass, size), "box");
    trees.push_back(HexahedronTree({{"box", Hexahedron::from_size(size), {}}}, "box"));
    bodies.push_back(world.add_body(box, box.state(at(p), Vector3::Zero(), Vector3::Zero())));
    contacts->add(Mover::of_body(bodies.back()), trees.back(), {0.5, 0.0});
    places.push_back(p);
  }
  /// Steps on; the farthest that any is off, the fastest, and how often contradiction was found.
  void expect_rest(double h, double seconds, const std::string& name) {
    contacts->build();
    std::uint32_t contradictory = 0;
    for (int i = 0; i < static_cast<int>(seconds / h); ++i) {
      const StepReport report = step(h);
      ASSERT_EQ(report.failure, StepFailure::none) << name;
      contradictory += report.contradictory;
    }
    EXPECT_EQ(contradictory, 0U) << name;
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      EXPECT_LT(norm(world.velocity(bodies[i])), 1e-4) << name << ", box " << i;
      EXPECT_LT(norm(world.pose(bodies[i]).p - places[i]), 1e-4) << name << ", box " << i;
    }
  }
};

TEST(BoundedSteps, HeavyLoadsRestOnLightSupports) {
  for (const double mass : {1e3, 1e4, 1e5, 1e6}) {
    const std::string name = std::to_string(mass);
    for (const double h : {1e-3, 1.0 / 240.0}) {
      Boxes tower;
      tower.add_ground();
      for (int i = 0; i < 6; ++i) tower.add_box({0, 0, kCubeSide * (0.5 + i)}, {0.2, 0.2, 0.2}, 1.0);
      tower.add_box({0, 0, 6.5 * kCubeSide}, {0.2, 0.2, 0.2}, mass);
      tower.expect_rest(h, h < 2e-3 ? 2.0 : 10.0, "tower " + name);
      Boxes table;
      table.add_ground();
      for (int i = 0; i < 6; ++i)
        table.add_box({0.4 * (i % 3) - 0.4, 0.4 * (i / 3) - 0.2, 0.1}, {0.2, 0.2, 0.2}, 1.0);
      table.add_box({0, 0, 0.35}, {1.2, 0.8, 0.3}, mass);
      table.expect_rest(h, h < 2e-3 ? 2.0 : 10.0, "table " + name);
    }
  }
}

TEST(BoundedSteps, StacksAndTablesOfAnyMassesRest) {
  // Masses of 1 kg to 1 000 t in any order. Developed on seeds 1 and 2.
  Draw draw(1606);
  for (int run = 0; run < 24; ++run) {
    Boxes scene;
    scene.add_ground();
    if (run % 2 == 0) {
      double top = 0.0;
      const int height = 2 + run % 7;
      for (int i = 0; i < height; ++i) {
        const double rise = draw(0.15, 0.3), mass = std::pow(10.0, draw(0.0, 6.0));
        scene.add_box({draw(-0.02, 0.02), draw(-0.02, 0.02), top + 0.5 * rise},
                      {draw(0.2, 0.4), draw(0.2, 0.4), rise}, mass);
        top += rise;
      }
    } else {
      for (int i = 0; i < 4; ++i)
        scene.add_box({i % 2 == 0 ? -0.4 : 0.4, i < 2 ? -0.25 : 0.25, 0.1}, {0.2, 0.2, 0.2},
                      std::pow(10.0, draw(0.0, 6.0)));
      scene.add_box({0, 0, 0.25}, {1.1, 0.8, 0.1}, std::pow(10.0, draw(0.0, 6.0)));
    }
    scene.expect_rest(run % 3 == 0 ? 1e-3 : 1.0 / 240.0, 10.0, "scene " + std::to_string(run));
  }
}

TEST(BoundedSteps, LintelsAndPyramidsOfAnyMassesStandAtDisplayRate) {
  // Masses of up to 1e6 to 1, spawned 0.1 mm apart. Developed on seeds 7101 to 7111.
  Draw draw(1608);
  for (int run = 0; run < 40; ++run) {
    Boxes scene;
    scene.add_ground();
    const double gap = 1e-4, most = 3.0 + run % 4;
    const auto add = [&](double x, double z, const Vector3& size, double drop) {
      scene.add_box({x, 0, z + drop}, size, std::pow(10.0, draw(0.0, most)));
      scene.places.back().z() = z;
    };
    if (run % 8 < 4) {
      const Vector3 post(draw(0.2, 0.3), 0.2, draw(0.2, 0.6));
      const double span = draw(0.5, 0.9);
      for (const double side : {-0.5, 0.5}) add(side * span, 0.5 * post.z(), post, gap);
      add(draw(-0.03, 0.03), post.z() + 0.1, {span + 0.3, 0.2, 0.2}, 2.0 * gap);
    } else {
      for (const double side : {-0.11, 0.11}) add(side, 0.1, {0.2, 0.2, 0.2}, gap);
      add(draw(-0.03, 0.03), 0.3, {0.2, 0.2, 0.2}, 2.0 * gap);
    }
    scene.expect_rest(1.0 / 60.0, 2.0, "scene " + std::to_string(run));
  }
}

TEST(BoundedSteps, LightBodiesAmongHeavyOnesInJawsAreNotShotOut) {
  // Jaws close by 2 cm on two to four cubes of 1 kg to 1 000 t.
  Draw draw(1609);
  for (int run = 0; run < 60; ++run) {
    Boxes scene;
    const double h = run % 2 == 0 ? 1e-3 : 1.0 / 240.0, speed = draw(0.02, 0.05), gap = draw(1e-5, 1e-3);
    const int count = 2 + run % 3;
    const double half = 0.1 * count;
    scene.add_driven({-half - 0.1 - gap, 0, 1}, {run % 2 == 0 ? 0.0 : speed, 0, 0});
    scene.add_driven({half + 0.1, 0, 1}, {-speed, 0, 0});
    for (int i = 0; i < count; ++i)
      scene.add_box({0.1 + 0.2 * i - half, draw(-0.02, 0.02), 1}, {0.2, 0.2, 0.2},
                    std::pow(10.0, draw(0.0, 6.0)));
    scene.contacts->build();
    double most = 0.0;
    for (int i = 0; i < static_cast<int>((0.02 + gap) / speed / h); ++i) {
      ASSERT_EQ(scene.step(h).failure, StepFailure::none);
      for (const std::uint32_t body : scene.bodies) {
        Vector3 v = scene.world.velocity(body);
        if (v.z() < 0.0) v.z() = std::min(0.0, v.z() + 9.81 * h * (i + 1));  // beyond its fall
        most = std::max(most, norm(v));
      }
    }
    EXPECT_LT(most - speed, 0.1) << run;
  }
}

TEST(BoundedSteps, AHeavyCubeInAPressSinksIntoALightOneNoFasterThanThePress) {
  // By 19 mm. The soft answer of the light one's contacts yielded to the heavy one's weight, at 0.1 to 1 m/s.
  for (const double mass : {1e4, 1e5, 1e6})
    for (const double h : {1e-3, 1.0 / 240.0}) {
      Boxes scene;
      scene.add_ground();
      const double speed = 0.03;
      scene.add_driven({0, 0, 2.5 * kCubeSide}, {0, 0, -speed});
      scene.add_box({0.015, -0.02, 0.5 * kCubeSide}, {kCubeSide, kCubeSide, kCubeSide}, 3.0);
      scene.add_box({-0.013, 0.006, 1.5 * kCubeSide}, {kCubeSide, kCubeSide, kCubeSide}, mass);
      scene.contacts->build();
      for (int i = 0; i < static_cast<int>(0.019 / speed / h); ++i) {
        ASSERT_EQ(scene.step(h).failure, StepFailure::none);
        for (const std::uint32_t body : scene.bodies)
          ASSERT_LT(norm(scene.world.velocity(body)), speed + 0.01) << mass << ", " << h << " at " << i;
      }
      EXPECT_GT(scene.world.pose(scene.bodies[1]).p.z(), 1.5 * kCubeSide - 0.0195) << mass << ", " << h;
    }
}

TEST(BoundedSteps, TrueContradictionsAreFoundAndHeld) {
  // Jaws, a vice, a press; one to three cubes of up to ten times each other's mass, speeds of 5 cm/s and
  // more.
  Draw draw(1607);
  for (int run = 0; run < 30; ++run) {
    Boxes scene;
    const int count = 1 + run % 3, kind = run / 3 % 3;
    const double speed = draw(0.05, 0.3), gap = draw(1e-5, 1e-3), half = 0.1 * count;
    if (kind == 2) {
      scene.add_ground();
      scene.add_driven({0, 0, 2.0 * half + 0.1 + gap}, {0, 0, -speed});
    } else {
      scene.add_driven({-half - 0.1 - gap, 0, 1}, {kind == 0 ? speed : 0.0, 0, 0});
      scene.add_driven({half + 0.1, 0, 1}, {-speed, 0, 0});
    }
    for (int i = 0; i < count; ++i) {
      const double at = 0.1 + 0.2 * i, aside = draw(-0.02, 0.02);
      scene.add_box(kind == 2 ? Vector3(aside, 0, at) : Vector3(at - half, aside, 1), {0.2, 0.2, 0.2},
                    draw(1.0, 10.0));
    }
    scene.contacts->build();
    const bool is_coarse = run % 2 == 1;
    std::uint32_t contradictory = 0;
    for (int i = 0; i < (is_coarse ? 70 : 300); ++i) {
      const double h = is_coarse ? 1.0 / 240.0 : 1e-3;
      const StepReport report = scene.step(h);
      ASSERT_EQ(report.failure, StepFailure::none);
      contradictory += report.contradictory;
      for (const std::uint32_t body : scene.bodies)
        EXPECT_LT(norm(scene.world.velocity(body)), 2.5 * speed + 9.81 * h * (i + 1)) << run << " at " << i;
    }
    EXPECT_GT(contradictory, is_coarse ? 30U : 100U) << run;
  }
}

TEST(BoundedSteps, JawsThatAreInACubeGetOneSoftAnswer) {
  // Its Newton steps, those of the passive answer in its place and those of parting: 16, 12 and 8. Tries of
  // others after it took up to 98.
  Draw draw(1610);
  for (int run = 0; run < 24; ++run) {
    Cubes scene;
    const double h = run % 2 == 0 ? 1e-3 : 1.0 / 240.0, speed = draw(0.02, 0.3), aside = 0.08;
    for (const double side : {-1.0, 1.0})
      scene.add_driven({side * (kCubeSide + 1e-4), draw(-aside, aside), 3 + draw(-aside, aside)},
                       {-side * speed, 0, 0});
    const Mover cube = Mover::of_body(scene.add_cube({0, 0, 3}));
    scene.contacts->build();
    std::uint32_t most = 0;
    int steps_in = 0;
    for (int i = 0; i < static_cast<int>(2.0 * kCubeSide / speed / h); ++i) {
      const std::span<const Contact> contacts = scene.contacts->find(scene.world, h);
      const bool is_in = std::any_of(contacts.begin(), contacts.end(), [&](const Contact& contact) {
        return (contact.a == cube || contact.b == cube) &&
               dot(contact.n_AB_W, contact.p_A_W - contact.p_B_W) > 1.001e-4;  // deeper than is left
      });
      const StepReport report = scene.world.step(h, contacts);
      ASSERT_EQ(report.failure, StepFailure::none);
      if (is_in) ++steps_in, most = std::max(most, report.newton_steps);
    }
    EXPECT_GT(steps_in, 10) << run;
    EXPECT_LE(most, 36U) << run;
  }
}

TEST(BoundedSteps, CubesThatArePartedTakeNoMoreWorkInLongSteps) {
  // Two or three in each other, at 240 Hz, deep and less deep until they are apart: up to 134 Newton steps
  // where groups of alike masses had as much more as the step is longer.
  Draw draw(1612);
  for (int run = 0; run < 12; ++run) {
    Cubes scene;
    scene.add_ground();
    for (int i = 0; i < 2 + run % 2; ++i) {
      const auto cube = scene.add_cube({0, 0, 1});
      Pose X_WB;
      X_WB.p = {draw(-0.1, 0.1), draw(-0.1, 0.1), 0.1 + draw(0.0, 0.02)};
      X_WB.R = rotation_about(Vector3::Unit(2), draw(-0.3, 0.3));
      scene.world.set_state(cube, scene.cube.state(X_WB, Vector3::Zero(), Vector3::Zero()));
    }
    scene.contacts->build();
    for (int i = 0; i < 720; ++i) {
      const StepReport report = scene.step(1.0 / 240.0);
      ASSERT_EQ(report.failure, StepFailure::none);
      EXPECT_LE(report.newton_steps, 100U) << run << " at " << i;
    }
  }
}

TEST(BoundedSteps, CubesThatLeanInABinComeToRest) {
  // Dropped on each other, turned anyhow, they lean on edges and walls. An impact at the micrometres a second
  // that an unfinished solve leaves spent the work of the forces, which it so left unfinished again: these
  // went on for ever, as 6 of 60 draws did.
  for (const std::uint32_t seed : {4U, 16U, 1015U, 1045U}) {
    Cubes scene;
    scene.add_ground();
    std::list<HexahedronTree> walls;
    for (const double side : {-1.0, 1.0})
      for (const bool is_along : {true, false}) {
        const Vector3 size = is_along ? Vector3(0.2, 0.9, 2.0) : Vector3(0.9, 0.2, 2.0);
        const Vector3 p_W = is_along ? Vector3(0.35 * side, 0, 1) : Vector3(0, 0.35 * side, 1);
        walls.emplace_back(std::vector<PlacedHexahedron>{{"box", Hexahedron::from_size(size), {}}}, "wall");
        scene.contacts->add(Mover::ground(), walls.back(), {0.5, 0.0}, at(p_W));
      }
    Draw draw(seed);
    for (int i = 0; i < 4; ++i) {
      const Vector3 turn_W = {draw(-1.0, 1.0), draw(-1.0, 1.0), draw(-1.0, 1.0)};
      Pose X_WB = at({0, 0, 0.3 + 0.36 * i});
      X_WB.R = rotation_about(turn_W / norm(turn_W), norm(turn_W));
      scene.world.set_state(scene.add_cube(X_WB.p), scene.cube.state(X_WB, Vector3::Zero(), Vector3::Zero()));
    }
    scene.contacts->build();
    constexpr int kSteps = 8000;  // most lie still by 3 000
    std::uint32_t solved = 0;     // of the last 400
    for (int i = 0; i < kSteps; ++i) {
      const StepReport report = scene.step(1e-3);
      ASSERT_EQ(report.failure, StepFailure::none);
      if (i >= kSteps - 400) solved += report.newton_steps > 0 ? 1 : 0;
    }
    EXPECT_LT(solved, 100U) << seed;  // now and then forces are found anew
  }
}

TEST(BoundedSteps, AWedgeLiftsStacksWhoseImpulsesAreFound) {
  // Driven under cubes that a wall holds: slips on both make each other's rounds grow.
  for (const int count : {3, 4}) {
    Boxes scene;
    const double h = 1.0 / 240.0, angle = 0.15;
    const HexahedronTree wall({{"box", Hexahedron::from_size({0.2, 2, 4}), {}}}, "wall");
    const HexahedronTree slab({{"box", Hexahedron::from_size({1.2, 0.4, 0.02}), {}}}, "wedge");
    scene.add_ground();
    const Mover held = Mover::of_body(
        scene.world.add_kinematic(at({0.5 * kCubeSide + 0.1, 0, 2}), Vector3::Zero(), Vector3::Zero()));
    scene.contacts->add(held, wall, {0.5, 0.0});
    // The upper edge of its front lies a little above the ground, before the stack.
    Pose X_WB;
    X_WB.R = rotation_about({0, 1, 0}, angle);
    X_WB.p = Vector3(-0.52 * kCubeSide, 0, 2e-4) - rotate(X_WB.R, Vector3(0.6, 0, 0.01));
    const auto wedge = scene.world.add_kinematic(X_WB, {0.1, 0, 0}, Vector3::Zero());
    scene.contacts->add(Mover::of_body(wedge), slab, {0.5, 0.0});
    std::uint32_t top = 0;
    for (int i = 0; i < count; ++i) top = scene.add_cube({0, 0, kCubeSide * (0.5 + i)});
    scene.contacts->build();
    std::uint32_t solves = 0, unconverged = 0;
    for (int i = 0; i < 480; ++i) {
      const StepReport report = scene.step(h);
      ASSERT_EQ(report.failure, StepFailure::none);
      solves += report.solves, unconverged += report.unconverged;
    }
    EXPECT_GT(scene.world.pose(top).p.z(), kCubeSide * (count - 0.5) + 0.02) << count;
    EXPECT_LT(unconverged, solves / 20) << count << " of " << solves;
  }
}

TEST(BoundedSteps, WhatABeltCarriesHasTheWorkOfWhatStands) {
  // At 60 Hz gravity makes 0.33 m/s in two steps: cubes that follow a belt of 0.2 m/s are as slow as a queue.
  std::uint32_t newton_steps[2] = {};
  for (const bool is_carried : {false, true}) {
    Cubes scene;
    DynamicsWorld::Settings settings = scene.world.settings();
    settings.work = 1.0;
    scene.world = DynamicsWorld(settings);
    const Vector3 v(is_carried ? 0.2 : 0.0, 0, 0);
    scene.contacts->add(Mover::of_body(scene.world.add_kinematic(at({0, 0, -0.5}), v, Vector3::Zero())),
                        scene.ground_tree, {0.5, 0.0});
    for (std::uint32_t i = 1; i <= 6; ++i) {
      scene.add_cube({0.02 * (i % 2), 0, kCubeSide * (i - 0.5)});
      const Vector3 off(0.01 * (i % 3), 0.02 * (i % 2), -0.03 * (i % 4));
      scene.world.set_state(i, scene.cube.state(scene.world.pose(i), v + off, {0.1, 0, 0.05}));
    }
    scene.contacts->build();
    for (int i = 0; i < 5; ++i) {
      const StepReport report = scene.step(1.0 / 60.0);
      ASSERT_EQ(report.failure, StepFailure::none);
      newton_steps[is_carried] += report.newton_steps;
    }
  }
  EXPECT_LE(newton_steps[1], newton_steps[0] + 1);
}

/// One step of cubes, on top of each other, that meet at speed.
struct Jam : Cubes {
  explicit Jam(double work, int count = 12) {
    DynamicsWorld::Settings settings = world.settings();
    settings.work = work;
    world = DynamicsWorld(settings);
    add_ground();
    for (int i = 0; i < count; ++i) add_cube({0.02 * (i % 2), 0, kCubeSide * (0.5 + i)});
    for (std::uint32_t i = 1; i <= static_cast<std::uint32_t>(count); ++i) {
      const Vector3 v(0.2 * (i % 3), 0.1 * (i % 2), -0.3 * (i % 4));
      world.set_state(i, cube.state(world.pose(i), v, {0.5, 0, 0.3}));
    }
    contacts->build();
  }
};

TEST(BoundedSteps, AStepWithoutWorkGoesOnAndSaysSo) {
  Jam scene(0.0);
  const double before = scene.world.energy();
  const StepReport report = scene.step(1e-3);
  EXPECT_EQ(report.failure, StepFailure::none);
  EXPECT_TRUE(report.is_work_spent);
  EXPECT_GT(report.unconverged, 0U);
  EXPECT_GT(report.worst_residual, 1e-9);
  EXPECT_LT(scene.world.energy(), before);  // what is not solved gives none
}

TEST(BoundedSteps, LargeGroupsHaveHalfTheWorkForFurtherContacts) {
  const StepReport report = Jam(8.0, 60).step(1e-3);
  EXPECT_TRUE(report.is_work_spent);
  EXPECT_LE(report.newton_steps, 17U);  // 24 with all of it
}

TEST(BoundedSteps, ACubeThatRattlesLeavesWorkForTheLastPiece) {
  // Dropped on an edge or a corner; as it comes to rest its corners meet the ground one after the other, many
  // times within a step.
  Draw draw(1620);
  std::uint32_t newton_steps = 0, pieces = 0, solves = 0;
  for (int run = 0; run < 24; ++run) {
    Cubes scene;
    scene.add_ground();
    const auto cube = scene.add_cube({0, 0, 0.2});
    Pose X_WB = at({0, 0, 0.2});
    const Vector3 turn_W = {draw(-1.0, 1.0), draw(-1.0, 1.0), draw(-1.0, 1.0)};
    X_WB.R = rotation_about(turn_W / norm(turn_W), norm(turn_W));
    scene.world.set_state(cube,
                          scene.cube.state(X_WB, {draw(-0.5, 0.5), 0, 0}, {draw(-5, 5), draw(-5, 5), 0}));
    scene.contacts->build();
    const double h = run % 2 == 0 ? 1e-3 : 1.0 / 240.0;
    for (int i = 0; i < static_cast<int>(1.5 / h); ++i) {
      const StepReport report = scene.step(h);
      ASSERT_EQ(report.failure, StepFailure::none);
      newton_steps = std::max(newton_steps, report.newton_steps);
      pieces = std::max(pieces, report.substeps);
      solves += report.solves;
    }
    EXPECT_LT(norm(scene.world.velocity(cube)), 1e-6) << run;
    EXPECT_NEAR(scene.world.pose(cube).p.z(), 0.1, 1.1e-4) << run;
  }
  std::printf("%u Newton steps at most, %u pieces, %u solves in all\n", newton_steps, pieces, solves);
  EXPECT_LT(newton_steps, 75U);  // 73
  EXPECT_LT(solves, 30000U);     // 30 857 where stops are sought to a thousandth of the gap
}

TEST(BoundedSteps, WorkMayBeInfinite) {
  for (const double h : {1e-4, 1e-3, 1.0 / 60.0}) EXPECT_FALSE(Jam(kInfinity).step(h).is_work_spent) << h;
}

TEST(BoundedSteps, JawsOfAnyFrictionHoldACubeOrLetItSlip) {
  // Speeds, offsets, friction, masses as drawn: no faster than the jaws and 0.1 m/s, its fall apart, until
  // they are a third of it into it. Developed on seed 9301.
  Draw draw(1610);
  for (int run = 0; run < 40; ++run) {
    Boxes scene;
    const double h = run % 2 == 0 ? 1e-3 : 1.0 / 240.0, speed = draw(0.02, 0.3), gap = draw(1e-5, 1e-3);
    const double friction = draw(0.05, 1.0);
    const auto add = [&](double x, double v) {
      const auto jaw = scene.world.add_kinematic(at({x, draw(-0.05, 0.05), 1 + draw(-0.05, 0.05)}), {v, 0, 0},
                                                 Vector3::Zero());
      scene.contacts->add(Mover::of_body(jaw), scene.cube_tree, {friction, 0.0});
    };
    add(-0.2 - gap, run % 4 < 2 ? 0.0 : speed);
    add(0.2 + gap, -speed);
    const RigidBody held(box_inertia(draw(0.5, 20.0), {kCubeSide, kCubeSide, kCubeSide}), "held");
    const auto cube = scene.world.add_body(held, held.state(at({0, 0, 1}), Vector3::Zero(), Vector3::Zero()));
    scene.contacts->add(Mover::of_body(cube), scene.cube_tree, {friction, 0.0});
    scene.contacts->build();
    for (int i = 0; i < static_cast<int>((0.06 + gap) / speed / h); ++i) {
      ASSERT_EQ(scene.step(h).failure, StepFailure::none);
      Vector3 v = scene.world.velocity(cube);
      if (v.z() < 0.0) v.z() = std::min(0.0, v.z() + 9.81 * h * (i + 1));
      ASSERT_LT(norm(v), speed + 0.1) << run << " at " << i << ", friction " << friction;
    }
  }
}

}  // namespace
}  // namespace touchstone::physics
