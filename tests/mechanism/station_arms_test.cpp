#include <gtest/gtest.h>

#include <cmath>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/contact_core/mechanism/arms/bundled_arms.hpp"
#include "touchstone/contact_core/mechanism/arms/mobile_transporter.hpp"
#include "touchstone/contact_core/mechanism/arms/spdm.hpp"
#include "touchstone/contact_core/mechanism/reference_overlaps.hpp"
#include "touchstone/contact_core/native/native.hpp"
#include "touchstone/tests/support/degree.hpp"

// The bundled arms besides the SSRMS: the SPDM, one of its arms, the SSRMS on the Mobile Transporter.

namespace touchstone {
namespace {

std::vector<Pose> poses_of(const Mechanism& arm, const std::vector<double>& q) {
  std::vector<Pose> X(arm.links().size());
  arm.link_poses({}, q, X);
  return X;
}

double mass_of(const Mechanism& arm) {
  double mass = 0;
  for (const Mechanism::Link& link : arm.links()) mass += link.mass.mass;
  return mass;
}

TEST(Spdm, HasThePublishedMassAndJointOrigins) {
  const Mechanism arm(make_spdm());
  EXPECT_EQ(arm.value_count(), 19U);
  EXPECT_NEAR(mass_of(arm), 1662, 1e-9);
  const std::vector<Pose> X = poses_of(arm, std::vector<double>(19, 0.0));
  EXPECT_EQ(X[arm.find_link("shoulder_roll_1")].p, Vector3(-1.380, 0.0, 1.425));
  // Of the arm's own chain at 0: the sum of its origins, along axes pitched by 45 degrees.
  const double along = -0.338 - 0.296 - 1.087 - 1.087 - 0.282 - 0.919 - 0.03,
               up = 0.192 + 0.132 + 0.013 - 0.013 - 0.120, c = std::cos(45 * kDegree);
  const Vector3 tip(-1.380 + c * along + c * up, -0.269 - 0.143 - 0.061 + 0.327 + 0.112,
                    1.425 - c * along + c * up);
  EXPECT_LE(norm(X[arm.find_link("tip_1")].p - tip), 1e-14);
  // The arm without its tool reaches as far as public figures have it, 3.35 to 3.5 m.
  const double reach = norm(Vector3(-0.338, -0.269, 0.192)) + norm(Vector3(-0.296, -0.143, 0.132)) +
                       norm(Vector3(-1.087, -0.061, 0.013)) + norm(Vector3(-1.087, 0.327, -0.013)) +
                       norm(Vector3(-0.282, 0.112, -0.120));
  EXPECT_GT(reach, 3.3);
  EXPECT_LT(reach, 3.5);
}

TEST(Spdm, HasTwoArmsThatMirrorEachOther) {
  const Mechanism arm(make_spdm());
  std::vector<double> q(19, 0.0);
  // A turn about x or y mirrors with the other sign, one about z with the same.
  const std::array<double, 7> sign = {-1, 1, -1, -1, -1, 1, -1};
  for (std::size_t i = 0; i < 7; ++i)
    q[1 + i] = 0.1 * static_cast<double>(i + 1), q[10 + i] = sign[i] * q[1 + i];
  const std::vector<Pose> X = poses_of(arm, q);
  for (const char* link : {"forearm", "wrist_yaw", "otcm", "tip"}) {
    const Vector3 one = X[arm.find_link(std::string(link) + "_1")].p,
                  two = X[arm.find_link(std::string(link) + "_2")].p;
    EXPECT_LE(norm(one - Vector3(two.x(), two.y(), -two.z())), 1e-14) << link;
  }
}

TEST(Spdm, ClosesItsJawsEvenlyAroundTheTip) {
  const Mechanism arm(make_spdm_arm());
  ASSERT_EQ(arm.value_count(), 9U);
  for (const double closed : {0.0, 0.011, 0.029}) {
    std::vector<double> q(9, 0.0);
    q[7] = q[8] = closed;
    const std::vector<Pose> X = poses_of(arm, q);
    const Vector3 left = X[arm.find_link("left_jaw_1")].p, right = X[arm.find_link("right_jaw_1")].p;
    EXPECT_LE(norm(0.5 * (left + right) - X[arm.find_link("tip_1")].p), 1e-14);
    EXPECT_NEAR(norm(left - right) - 0.02, 0.06 - 2 * closed, 1e-14);  // between their faces
  }
}

TEST(BundledArms, AreFreeOfThemselvesAndKnownByName) {
  const auto native = make_native();
  for (const char* name : {"ssrms", "ssrms_walking", "ssrms_on_transporter", "spdm", "spdm_arm"}) {
    const Mechanism arm(make_bundled_arm(name));
    const std::vector<ReferenceOverlap> overlaps = find_reference_overlaps(arm, *native);
    EXPECT_TRUE(overlaps.empty()) << name << ": " << to_string(overlaps[0], arm);
  }
  EXPECT_THROW(make_bundled_arm("canadarm"), InputError);
}

TEST(WalkingSsrms, StandsOnEitherEndAndLooksOutOfBothMouths) {
  const Mechanism arm(make_bundled_arm("ssrms_walking"));
  const std::vector<double> q = {0.3, -0.2, 0.5, 1.9, 0.4, 0.1, -0.7};
  const std::vector<Pose> X = poses_of(arm, q);
  const Pose& X_base = X[arm.find_link("base_tip")];
  EXPECT_EQ(X_base.p, Vector3(0, 0, 0));  // the plane of the mouth
  EXPECT_EQ(X_base.R.col(0), Vector3(-1, 0, 0));
  // Held by its other end where that was, every link is where it was.
  const Mechanism other = arm.with_base("tip_lee");
  std::vector<Pose> X_again(other.links().size());
  other.link_poses(X[arm.find_link("tip_lee")], q, X_again);
  for (std::uint32_t link = 0; link < X.size(); ++link) {
    EXPECT_EQ(other.links()[link].name, arm.links()[link].name);
    EXPECT_LE(norm(X_again[link].p - X[link].p), 1e-13) << arm.links()[link].name;
    EXPECT_LE((X_again[link].R - X[link].R).cwiseAbs().maxCoeff(), 1e-14) << arm.links()[link].name;
  }
}

TEST(MobileTransporter, MovesTheArmAlongItsRails) {
  const Mechanism arm(make_ssrms_on_transporter());
  ASSERT_EQ(arm.value_count(), 8U);
  EXPECT_NEAR(mass_of(arm), 1505 + 885, 0.5);
  std::vector<double> q = {0, 0, 0, -10 * kDegree, 100 * kDegree, 90 * kDegree, 0, 0};
  const Vector3 before = poses_of(arm, q)[arm.find_link("tip")].p;
  q[0] = 3.0;
  const Vector3 after = poses_of(arm, q)[arm.find_link("tip")].p;
  EXPECT_LE(norm(after - before - Vector3(3, 0, 0)), 1e-14);
  EXPECT_EQ(arm.joints()[arm.find_joint("rail")].kind, JointKind::prismatic);
}

}  // namespace
}  // namespace touchstone
