// Joint accelerations and inertia matrices against MuJoCo.

#include <gtest/gtest.h>
#include <mujoco/mujoco.h>
#include <unistd.h>

#include <Eigen/Eigenvalues>
#include <cstdio>
#include <fstream>
#include <memory>
#include <sstream>

#include "touchstone/contact_core/geometry/quaternion.hpp"
#include "touchstone/physics/bodies/mechanism_dynamics.hpp"
#include "touchstone/tests/physics/arms.hpp"

using namespace touchstone;
using namespace touchstone::physics;

namespace {

const Vector3 kGravity(0.3, -9.8, 1.1);

void write_vector(std::ostream& out, const char* name, const Vector3& v) {
  out << ' ' << name << "=\"" << v.x() << ' ' << v.y() << ' ' << v.z() << '"';
}

void write_quaternion(std::ostream& out, const Quaternion& q) {
  out << " quat=\"" << q.w << ' ' << q.v.x() << ' ' << q.v.y() << ' ' << q.v.z() << '"';
}

/// A chain: each body in the one before.
std::string to_mjcf(const Arm& arm) {
  std::ostringstream out;
  out.precision(17);
  out << R"(<mujoco><compiler angle="radian" inertiafromgeom="false" balanceinertia="false"/><option)";
  write_vector(out, "gravity", kGravity);
  out << "/><worldbody>";
  int open = 0;
  for (const std::uint32_t j : arm.mechanism.outwards()) {
    const Mechanism::Joint& joint = arm.mechanism.joints()[j];
    const BodyInertia& link = arm.links[joint.outer];
    out << "<body";
    write_vector(out, "pos", joint.X_PJ.p);
    write_quaternion(out, quaternion_of(joint.X_PJ.R));
    out << '>';
    ++open;
    if (joint.kind != JointKind::fixed) {
      out << "<joint type=\"" << (joint.kind == JointKind::revolute ? "hinge" : "slide") << '"';
      write_vector(out, "axis", joint.axis_J);
      out << "/>";
    }
    if (link.mass == 0.0) continue;
    // Principal axes, as MuJoCo finds them itself only to 1e-8.
    const Eigen::SelfAdjointEigenSolver<Matrix3> principal(link.inertia_B);
    Matrix3 axes = principal.eigenvectors();
    if (axes.determinant() < 0.0) axes.col(0) *= -1.0;
    out << "<inertial mass=\"" << link.mass << '"';
    write_vector(out, "pos", link.centre_B);
    write_vector(out, "diaginertia", principal.eigenvalues());
    write_quaternion(out, quaternion_of(axes));
    out << "/>";
  }
  while (open-- > 0) out << "</body>";
  out << "</worldbody></mujoco>";
  return out.str();
}

using Model = std::unique_ptr<mjModel, decltype(&mj_deleteModel)>;
using Data = std::unique_ptr<mjData, decltype(&mj_deleteData)>;

Model load(const std::string& mjcf) {
  const std::string path = testing::TempDir() + "physics_mujoco_" + std::to_string(getpid()) + ".xml";
  std::ofstream(path) << mjcf;
  char error[1000] = "";
  Model model(mj_loadXML(path.c_str(), nullptr, error, sizeof(error)), &mj_deleteModel);
  std::remove(path.c_str());
  EXPECT_NE(model, nullptr) << error;
  return model;
}

struct Errors {
  double acceleration = 0.0, matrix = 0.0;
};

Errors compare(const Arm& arm, std::mt19937_64& random, int poses) {
  // The same arm in both.
  const Model model = load(to_mjcf(arm));
  if (!model) return {};
  const Data data(mj_makeData(model.get()), &mj_deleteData);
  const MechanismDynamics dynamics(arm.mechanism, arm.links);
  auto workspace = dynamics.make_workspace();
  const std::size_t n = dynamics.size();
  EXPECT_EQ(model->nv, static_cast<int>(n));
  Errors worst;
  for (int i = 0; i < poses; ++i) {
    // At random states, MuJoCo's mass matrix and acceleration.
    const auto q = random_values(random, n, 3.0), qd = random_values(random, n, 1.0),
               tau = random_values(random, n, 50.0);
    std::copy(q.begin(), q.end(), data->qpos);
    std::copy(qd.begin(), qd.end(), data->qvel);
    std::copy(tau.begin(), tau.end(), data->qfrc_applied);
    mj_forward(model.get(), data.get());
    std::vector<double> theirs(n * n), M(n * n), qdd(n);
    mj_fullM(model.get(), theirs.data(), data->qM);
    // Our dynamics at the same values, rates and torques.
    dynamics.place({}, q, qd, workspace);
    dynamics.mass_matrix(M, workspace);
    EXPECT_TRUE(dynamics.forward_dynamics(kGravity, tau, qdd, workspace));
    worst.acceleration = std::max(worst.acceleration, relative_error(qdd, {data->qacc, n}));
    worst.matrix = std::max(worst.matrix, relative_error(M, theirs));
  }
  return worst;
}

TEST(MuJoCo, SpaceStationArmAcceleratesTheSame) {
  std::mt19937_64 random(21);
  const Errors worst = compare(ssrms_arm(), random, 200);
  std::printf("SSRMS: accelerations %.1e, inertia matrix %.1e\n", worst.acceleration, worst.matrix);
  EXPECT_LT(worst.acceleration, 4e-12);  // ten times what comes out, as all here
  EXPECT_LT(worst.matrix, 2e-14);
}

TEST(MuJoCo, RandomArmsAccelerateTheSame) {
  std::mt19937_64 random(22);
  Errors worst;
  for (int i = 0; i < 40; ++i) {
    const Errors errors = compare(random_arm(random, i % 2 == 1), random, 20);
    worst.acceleration = std::max(worst.acceleration, errors.acceleration);
    worst.matrix = std::max(worst.matrix, errors.matrix);
  }
  std::printf("random arms: accelerations %.1e, inertia matrix %.1e\n", worst.acceleration, worst.matrix);
  EXPECT_LT(worst.acceleration, 4e-13);
  EXPECT_LT(worst.matrix, 5e-14);
}

}  // namespace
