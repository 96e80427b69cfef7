// Passive losses of joints, and drives with stiffness: closed forms of one joint, and arms.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/physics/solver/implicit_share.hpp"
#include "touchstone/physics/world/dynamics_world.hpp"
#include "touchstone/tests/physics/arms.hpp"
#include "touchstone/tests/support/counting_allocator.hpp"

namespace touchstone::physics {
namespace {

const Vector3 kZero = Vector3::Zero();

TEST(ImplicitShare, DecaysAsTheMotionDoes) {
  for (const double z : {1e-6, 1e-3, 0.0099, 0.0101, 0.3, 1.0, 5.0, 50.0, 1e3, 1e8}) {
    const double end = implicit_share(z);
    EXPECT_NEAR(decay(z), std::exp(-z), 1e-15) << z;
    EXPECT_NEAR((1 - (1 - end) * z) / (1 + end * z), std::exp(-z), 1e-14) << z;
    EXPECT_GE(end, 0.5);
    EXPECT_LE(end, 1.0);
  }
}

/// One wheel about z through its centre, of inertia 0.5 kg m2.
struct Wheel {
  static constexpr double kInertia = 0.5;
  static Mechanism make() {
    MechanismDescription description{
        .name = "wheel", .links = {{.name = "base"}, {.name = "rim", .solids = {}}}, .joints = {}};
    JointDescription joint;
    joint.name = "axle", joint.kind = JointKind::revolute, joint.parent = "base", joint.child = "rim";
    description.joints.push_back(joint);
    return Mechanism(description);
  }
  Mechanism mechanism = make();
  std::vector<BodyInertia> links = {{}, {2.0, kZero, Vector3(0.3, 0.3, kInertia).asDiagonal()}};
  MechanismDynamics dynamics{mechanism, links};
  DynamicsWorld world{{}};

  explicit Wheel(double q = 0.0, double qd = 0.0, double rotor = 0.0) {
    dynamics.set_rotors(std::vector<double>{rotor});
    world.add_mechanism(dynamics, {}, std::vector<double>{q}, std::vector<double>{qd});
  }
  StepReport step(double h, int times = 1) {
    StepReport report;
    for (int i = 0; i < times && report.failure == StepFailure::none; ++i) report = world.step(h, {});
    EXPECT_EQ(report.failure, StepFailure::none);
    return report;
  }
  double q() const { return world.joint_values(0)[0]; }
  double qd() const { return world.joint_rates(0)[0]; }
  double torque() const { return world.joint_torques(0)[0]; }
};

TEST(JointLosses, DampingAloneSlowsByItsExponentialAtAnyStep) {
  for (const double h : {1e-3, 0.1, 1.0}) {
    Wheel wheel(0.0, 2.0);
    wheel.world.set_losses(0, 0, {0.0, 0.75});
    wheel.step(h, static_cast<int>(std::lround(1.0 / h)));
    EXPECT_NEAR(wheel.qd(), 2.0 * std::exp(-0.75 / Wheel::kInertia), 1e-13) << h;
  }
  // However stiff, it never reverses.
  Wheel wheel(0.0, 2.0);
  wheel.world.set_losses(0, 0, {0.0, 1e12});
  wheel.step(0.1);
  EXPECT_NEAR(wheel.qd(), 0.0, 1e-12);
}

TEST(JointLosses, ATorqueAgainstDampingComesToItsRate) {
  Wheel wheel;
  wheel.world.set_losses(0, 0, {0.0, 0.75});
  JointDrive drive;
  drive.torque = 3.0;
  wheel.world.set_drive(0, 0, drive);
  wheel.step(1e-3, 500);
  EXPECT_NEAR(wheel.qd(), 4.0 * (1 - std::exp(-0.75 * 0.5 / Wheel::kInertia)), 1e-12);
  EXPECT_EQ(wheel.torque(), 3.0);  // damping is not a part of the drive's torque
  wheel.step(1e-2, 3000);
  EXPECT_NEAR(wheel.qd(), 4.0, 1e-12);
}

TEST(JointLosses, FrictionStopsWithinTheStepAndHolds) {
  Wheel wheel(0.0, 2.0);
  wheel.world.set_losses(0, 0, {0.4, 0.0});
  const double deceleration = 0.4 / Wheel::kInertia, stop = 2.0 / deceleration;
  double stopped = 0.0;
  for (int i = 0; i < 2600; ++i) {
    const StepReport report = wheel.step(1e-3);
    if (std::isfinite(report.last_stop)) stopped = 1e-3 * i + report.last_stop;
  }
  EXPECT_NEAR(stopped, stop, 1e-9);
  EXPECT_NEAR(wheel.q(), 0.5 * 2.0 * stop, 1e-9);
  EXPECT_NEAR(wheel.qd(), 0.0, 1e-12);
  JointDrive drive;
  for (const double torque : {0.39, 0.41}) {
    drive.torque = torque;
    wheel.world.set_drive(0, 0, drive);
    wheel.step(1e-3, 1000);
    EXPECT_NEAR(wheel.qd(), std::max(0.0, torque - 0.4) / Wheel::kInertia, 1e-11) << torque;
  }
}

TEST(JointLosses, FrictionHelpsBrakesAndHindersRates) {
  Wheel wheel(0.0, 2.0);
  wheel.world.set_losses(0, 0, {0.4, 0.0});
  JointDrive drive{JointDrive::Mode::brake, 0.0, 0.0, 0.6};
  wheel.world.set_drive(0, 0, drive);
  wheel.step(1e-3, 500);
  EXPECT_NEAR(wheel.qd(), 2.0 - 1.0 * 0.5 / Wheel::kInertia, 1e-12);
  EXPECT_NEAR(wheel.torque(), -0.6, 1e-12);  // the brake's share
  drive = {JointDrive::Mode::rate, 0.0, 3.0, 1.0};
  wheel.world.set_drive(0, 0, drive);
  wheel.step(1e-3, 500);
  EXPECT_NEAR(wheel.qd(), 1.0 + 0.6 * 0.5 / Wheel::kInertia, 1e-12);
  wheel.step(1e-3, 3000);
  EXPECT_NEAR(wheel.qd(), 3.0, 1e-12);
  EXPECT_NEAR(wheel.torque(), 0.4, 1e-10);  // what friction takes
}

TEST(PositionDrives, SwingAsTheDampedOscillatorAtOrderTwo) {
  const double k = 200.0, d = 2.0, I = Wheel::kInertia;
  const double w0 = std::sqrt(k / I), zeta = d / (2 * std::sqrt(k * I)), w = w0 * std::sqrt(1 - zeta * zeta);
  const double T = 0.7, left = std::exp(-zeta * w0 * T);
  const double expected = 1.0 - left * (std::cos(w * T) + zeta * w0 / w * std::sin(w * T));
  double last = 0.0;
  for (const double h : {2e-3, 1e-3, 5e-4}) {
    Wheel wheel;
    JointDrive drive;
    drive.mode = JointDrive::Mode::position;
    drive.position = 1.0, drive.stiffness = k, drive.damping = d;
    wheel.world.set_drive(0, 0, drive);
    wheel.step(h, static_cast<int>(std::lround(T / h)));
    const double error = std::abs(wheel.q() - expected);
    if (last > 0.0) {
      EXPECT_NEAR(last / error, 4.0, 0.7) << h;
    }
    last = error;
  }
  EXPECT_LT(last, 5e-5);  // (w0 h)^2 / 12 of 14 rad, a quarter of it left
}

TEST(PositionDrives, AreStableForAnyStiffnessAndGainNoEnergy) {
  for (const double k : {1e2, 1e6, 1e12})
    for (const double d : {0.0, 1.0, 1e6}) {
      Wheel wheel(0.0, 1.0);
      JointDrive drive;
      drive.mode = JointDrive::Mode::position;
      drive.position = 0.3, drive.stiffness = k, drive.damping = d;
      wheel.world.set_drive(0, 0, drive);
      const auto energy = [&] {
        const double e = wheel.q() - 0.3;
        return 0.5 * Wheel::kInertia * wheel.qd() * wheel.qd() + 0.5 * k * e * e;
      };
      const double start = energy();
      for (int i = 0; i < 300; ++i) {
        wheel.step(1e-2);
        EXPECT_LE(energy(), start * (1 + 1e-12)) << k << ' ' << d << ' ' << i;
      }
      // Joints that swing faster than steps resolve, or are damped, have settled.
      if (k >= 1e6 && d <= 1.0) {
        EXPECT_LT(std::abs(wheel.qd()), 1e-6) << k << ' ' << d;
        EXPECT_NEAR(wheel.q(), 0.3, 1e-6) << k << ' ' << d;
      }
    }
}

TEST(PositionDrives, AreCutToTheirLimitAndFollowMovingTargets) {
  Wheel wheel;
  JointDrive drive;
  drive.mode = JointDrive::Mode::position;
  drive.position = 10.0, drive.stiffness = 1e6, drive.damping = 1e4, drive.limit = 2.0;
  wheel.world.set_drive(0, 0, drive);
  wheel.step(1e-3, 500);
  EXPECT_NEAR(wheel.qd(), 2.0 * 0.5 / Wheel::kInertia, 1e-12);
  EXPECT_NEAR(wheel.torque(), 2.0, 1e-12);
  drive.limit = kInfinity;
  drive.stiffness = 0.0, drive.rate = -1.0;  // a rate drive that yields
  wheel.world.set_drive(0, 0, drive);
  wheel.step(1e-3, 100);
  EXPECT_NEAR(wheel.qd(), -1.0, 1e-9);
}

TEST(PositionDrives, HoldAnArmAgainstGravityByTheirOwnTorques) {
  const Arm arm = ssrms_arm();
  const MechanismDynamics dynamics(arm.mechanism, arm.links);
  DynamicsWorld::Settings settings;
  settings.gravity_W = {0, 0, -0.1};
  DynamicsWorld world(settings);
  const std::vector<double> q{0.1, 0.4, -0.3, 0.5, 0.2, -0.6, 0.3}, zero(7, 0.0);
  const auto ssrms = world.add_mechanism(dynamics, {}, q, zero);
  const double k = 1e6;
  for (std::uint32_t i = 0; i < 7; ++i) {
    JointDrive drive;
    drive.mode = JointDrive::Mode::position;
    drive.position = q[i], drive.stiffness = k, drive.damping = 6e5;
    world.set_drive(ssrms, i, drive);
    world.set_losses(ssrms, i, {5.0, 10.0});
  }
  world.reserve(8);
  ASSERT_EQ(world.step(1e-2, {}).failure, StepFailure::none);
  const std::uint64_t before = allocation_count();
  for (int i = 0; i < 3000; ++i) {
    const StepReport report = world.step(1e-2, {});
    ASSERT_EQ(report.failure, StepFailure::none);
    ASSERT_EQ(report.unconverged, 0u) << i;
  }
  EXPECT_EQ(allocation_count() - before, 0u);
  std::vector<double> gravity(7);
  auto placed = dynamics.make_workspace();
  dynamics.place({}, world.joint_values(ssrms), zero, placed);
  dynamics.inverse_dynamics(settings.gravity_W, zero, gravity, placed);
  for (std::size_t i = 0; i < 7; ++i) {
    EXPECT_NEAR(world.joint_rates(ssrms)[i], 0.0, 1e-9);
    // Friction may hold a part of it.
    EXPECT_NEAR(world.joint_torques(ssrms)[i], gravity[i], 5.0 + 1e-6);
    // And damping gives what is left of the rates.
    EXPECT_NEAR(world.joint_torques(ssrms)[i], k * (q[i] - world.joint_values(ssrms)[i]), 6e5 * 1e-9);
  }
}

TEST(Rotors, CountAsInertiaOfTheirJointAlone) {
  Wheel wheel(0.0, 0.0, 1.5);
  JointDrive drive;
  drive.torque = 4.0;
  wheel.world.set_drive(0, 0, drive);
  wheel.step(1e-3, 1000);
  EXPECT_NEAR(wheel.qd(), 4.0 / 2.0, 1e-12);
  EXPECT_NEAR(wheel.world.energy(), 0.5 * 2.0 * 4.0, 1e-11);
  // Recursions agree with each other: tau = M qdd + rest.
  Arm arm = ssrms_arm();
  MechanismDynamics dynamics(arm.mechanism, arm.links);
  dynamics.set_rotors(std::vector<double>{1, 2, 3, 4, 5, 6, 7});
  auto placed = dynamics.make_workspace();
  const std::vector<double> q{0.1, 0.4, -0.3, 0.5, 0.2, -0.6, 0.3}, qd{0.1, -0.2, 0.3, 0.1, 0.2, -0.3, 0.4},
      tau{10, -20, 30, 5, 3, 2, 1};
  std::vector<double> qdd(7), back(7);
  dynamics.place({}, q, qd, placed);
  ASSERT_TRUE(dynamics.forward_dynamics({0, 0, -9.81}, tau, qdd, placed));
  dynamics.inverse_dynamics({0, 0, -9.81}, qdd, back, placed);
  for (std::size_t i = 0; i < 7; ++i) EXPECT_NEAR(back[i], tau[i], 1e-8);
  EXPECT_THROW(dynamics.set_rotors(std::vector<double>{1, 2}), InputError);
  EXPECT_THROW(dynamics.set_rotors(std::vector<double>{1, 2, 3, 4, 5, 6, -1}), InputError);
}

TEST(JointLosses, BadFiguresAreRefused) {
  Wheel wheel;
  EXPECT_THROW(wheel.world.set_losses(0, 0, {-1.0, 0.0}), InputError);
  EXPECT_THROW(wheel.world.set_losses(0, 0, {0.0, kInfinity}), InputError);
  EXPECT_THROW(wheel.world.set_losses(0, 1, {0.0, 0.0}), InputError);
  EXPECT_THROW(wheel.world.set_losses(1, 0, {0.0, 0.0}), InputError);
  JointDrive drive;
  drive.mode = JointDrive::Mode::position;
  drive.stiffness = -1.0;
  EXPECT_THROW(wheel.world.set_drive(0, 0, drive), InputError);
  drive.stiffness = 1.0, drive.position = std::nan("");
  EXPECT_THROW(wheel.world.set_drive(0, 0, drive), InputError);
}

}  // namespace
}  // namespace touchstone::physics
