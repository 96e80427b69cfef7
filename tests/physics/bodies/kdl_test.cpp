// Joint accelerations against Orocos KDL.

#include <gtest/gtest.h>

#include <cstdio>
#include <kdl/chain.hpp>
#include <kdl/chainfdsolver_recursive_newton_euler.hpp>

#include "touchstone/physics/bodies/mechanism_dynamics.hpp"
#include "touchstone/tests/physics/arms.hpp"

using namespace touchstone;
using namespace touchstone::physics;

namespace {

const Vector3 kGravity(0.3, -9.8, 1.1);

KDL::Vector to_kdl(const Vector3& v) { return {v.x(), v.y(), v.z()}; }
KDL::Frame to_kdl(const Pose& X) {
  const Matrix3& R = X.R;
  return {KDL::Rotation(R(0, 0), R(0, 1), R(0, 2), R(1, 0), R(1, 1), R(1, 2), R(2, 0), R(2, 1), R(2, 2)),
          to_kdl(X.p)};
}

/// Each joint as two segments: the way to it, which is fixed, and the joint with its link.
KDL::Chain to_kdl(const Arm& arm) {
  KDL::Chain chain;
  for (const std::uint32_t j : arm.mechanism.outwards()) {
    const Mechanism::Joint& joint = arm.mechanism.joints()[j];
    chain.addSegment(KDL::Segment(KDL::Joint(KDL::Joint::Fixed), to_kdl(joint.X_PJ)));
    if (joint.kind == JointKind::fixed) continue;
    const BodyInertia& link = arm.links[joint.outer];
    const Matrix3& I = link.inertia_B;
    const auto type = joint.kind == JointKind::revolute ? KDL::Joint::RotAxis : KDL::Joint::TransAxis;
    chain.addSegment(KDL::Segment(
        KDL::Joint(joint.name, KDL::Vector::Zero(), to_kdl(joint.axis_J), type), KDL::Frame::Identity(),
        KDL::RigidBodyInertia(link.mass, to_kdl(link.centre_B),
                              KDL::RotationalInertia(I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2)))));
  }
  return chain;
}

double compare(const Arm& arm, std::mt19937_64& random, int poses) {
  const KDL::Chain chain = to_kdl(arm);
  KDL::ChainFdSolver_RNE solver(chain, to_kdl(kGravity));
  const MechanismDynamics dynamics(arm.mechanism, arm.links);
  auto workspace = dynamics.make_workspace();
  const unsigned n = dynamics.size();
  EXPECT_EQ(chain.getNrOfJoints(), n);
  double worst = 0.0;
  for (int i = 0; i < poses; ++i) {
    const auto q = random_values(random, n, 3.0), qd = random_values(random, n, 1.0),
               tau = random_values(random, n, 50.0);
    KDL::JntArray kdl_q(n), kdl_qd(n), kdl_tau(n), kdl_qdd(n);
    for (unsigned k = 0; k < n; ++k) kdl_q(k) = q[k], kdl_qd(k) = qd[k], kdl_tau(k) = tau[k];
    const KDL::Wrenches none(chain.getNrOfSegments(), KDL::Wrench::Zero());
    EXPECT_EQ(solver.CartToJnt(kdl_q, kdl_qd, kdl_tau, none, kdl_qdd), 0);
    std::vector<double> qdd(n);
    dynamics.place({}, q, qd, workspace);
    EXPECT_TRUE(dynamics.forward_dynamics(kGravity, tau, qdd, workspace));
    worst = std::max(worst, relative_error(qdd, {kdl_qdd.data.data(), n}));
  }
  return worst;
}

TEST(Kdl, SpaceStationArmAcceleratesTheSame) {
  std::mt19937_64 random(31);
  const double worst = compare(ssrms_arm(), random, 200);
  std::printf("SSRMS: accelerations %.1e\n", worst);
  EXPECT_LT(worst, 3e-12);  // ten times what comes out, as below
}

TEST(Kdl, RandomArmsAccelerateTheSame) {
  std::mt19937_64 random(32);
  double worst = 0.0;
  for (int i = 0; i < 40; ++i) worst = std::max(worst, compare(random_arm(random, i % 2 == 1), random, 20));
  std::printf("random arms: accelerations %.1e\n", worst);
  EXPECT_LT(worst, 2.5e-13);
}

}  // namespace
