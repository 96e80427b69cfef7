#include "touchstone/contact_core/mechanism/arms/spdm.hpp"

#include <numbers>
#include <string>

#include "touchstone/contact_core/mechanism/arms/link_parts.hpp"
#include "touchstone/contact_core/mechanism/round_parts.hpp"

namespace touchstone {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kHalfRoot = 0.70710678118654752;  // of 2: cos 45 deg

// Joint origins in the frame of the joint before [m]: read in a public source.
const Vector3 kShoulder(-1.380, 0.0, 1.425);
const Vector3 kShoulderYaw(-0.338, -0.269, 0.192);
const Vector3 kShoulderPitch(-0.296, -0.143, 0.132);
const Vector3 kElbow(-1.087, -0.061, 0.013);
const Vector3 kWrist(-1.087, 0.327, -0.013);
const Vector3 kWristRoll(-0.282, 0.112, -0.120);
constexpr double kOtcmLength = 0.919, kOtcmRadius = 0.154, kOtcmThick = 0.228;  // [m]

// Assumed.
constexpr double kThickFrom = 0.35, kThickTo = 0.60;  // along the OTCM [m]
constexpr double kShoulderWidth = 0.22, kArmWidth = 0.18, kWristWidth = 0.16, kBodyWidth = 0.5;
constexpr double kJawLength = 0.06, kJawThickness = 0.02, kJawWidth = 0.04, kJawsOpen = 0.06;
constexpr int kFacets = 8;

/// The side that an arm is on: the two are alike, with z mirrored on arm 2.
struct Side {
  std::string number;
  double sign;
  std::string parent;  ///< that its shoulder is on
  std::string named(const char* part) const { return part + ("_" + number); }
  Vector3 at(const Vector3& p) const { return {p.x(), p.y(), sign * p.z()}; }
};

void add_joint(const std::string& name, const std::string& parent, const std::string& child, const Pose& X_PJ,
               const Vector3& axis, MechanismDescription& arm) {
  JointDescription joint{name, JointKind::revolute, parent, child, X_PJ, axis};
  joint.lower = -170.0 * kDegree;
  joint.upper = 170.0 * kDegree;
  joint.rate = 4.0 * kDegree;
  joint.effort = 500.0;
  arm.joints.push_back(joint);
}

Pose at(const Vector3& p) {
  Pose X;
  X.p = p;
  return X;
}

/// A link that is a bar from its joint to the next one.
void add_bar(const std::string& name, const Vector3& to_L, double width, double mass,
             MechanismDescription& arm) {
  LinkDescription link{name, {}, bar_mass(mass, Vector3::Zero(), to_L, width)};
  link.solids.push_back(make_bar(Vector3::Zero(), to_L, width, 0.25 * width, "bar"));
  arm.links.push_back(link);
}

/// A cylinder along -x, from `from` to `to` before the link's origin.
RoundPart cylinder(double radius, double from, double to, const char* name) {
  Pose X = at({-to, 0.0, 0.0});
  X.R << 0, 0, 1, 0, 1, 0, -1, 0, 0;  // the cylinder's z along x
  return make_cylinder(radius, to - from, kFacets, false, X, name);
}

void add_jaw(const Side& side, const char* part, double sign, MechanismDescription& arm) {
  const std::string name = side.named(part);
  LinkDescription jaw{name, {}, solid_box_mass(1.0, Vector3::Zero(), {kJawLength, kJawThickness, kJawWidth})};
  jaw.solids.push_back({"jaw", Hexahedron::from_size({kJawLength, kJawThickness, kJawWidth}), Pose{}});
  arm.links.push_back(jaw);
  JointDescription joint{name, JointKind::prismatic, side.named("otcm"), name};
  joint.X_PJ = at({-kOtcmLength - 0.5 * kJawLength, sign * 0.5 * (kJawsOpen + kJawThickness), 0.0});
  joint.axis_J = {0.0, -sign, 0.0};  // inwards
  joint.lower = 0.0;
  joint.upper = 0.029;  // 1 mm short of their middle
  joint.rate = 0.005;
  joint.effort = 500.0;
  arm.joints.push_back(joint);
}

void add_otcm(const Side& side, MechanismDescription& arm) {
  const std::string name = side.named("otcm");
  const Vector3 end(-kOtcmLength, 0.0, 0.0);
  arm.links.push_back({name, {}, bar_mass(75.0, Vector3::Zero(), end, 2.0 * kOtcmRadius)});
  const std::size_t link = arm.links.size() - 1;
  append(cylinder(kOtcmRadius, 0.0, kOtcmLength, "body"), link, arm);
  append(cylinder(kOtcmThick, kThickFrom, kThickTo, "drives"), link, arm);
  add_joint(side.named("wrist_roll"), side.named("wrist_yaw"), name, at(side.at(kWristRoll)),
            Vector3::UnitX(), arm);
  add_jaw(side, "left_jaw", 1.0, arm);
  add_jaw(side, "right_jaw", -1.0, arm);
  arm.links.push_back({side.named("tip"), {}, {}});
  JointDescription tip{side.named("tip_frame"), JointKind::fixed, name, side.named("tip")};
  tip.X_PJ.p = {-kOtcmLength - 0.5 * kJawLength, 0.0, 0.0};
  tip.X_PJ.R << -1, 0, 0, 0, -1, 0, 0, 0, 1;  // x out of the tool
  arm.joints.push_back(tip);
}

void add_arm(const Side& side, const Pose& X_shoulder, MechanismDescription& arm) {
  const auto name = [&](const char* part) { return side.named(part); };
  const Vector3 x = Vector3::UnitX(), y = Vector3::UnitY(), z = Vector3::UnitZ();
  add_bar(name("shoulder_roll"), side.at(kShoulderYaw), kShoulderWidth, 60.0, arm);
  add_joint(name("shoulder_roll"), side.parent, name("shoulder_roll"), X_shoulder, x, arm);
  add_bar(name("shoulder_yaw"), side.at(kShoulderPitch), kShoulderWidth, 60.0, arm);
  add_joint(name("shoulder_yaw"), name("shoulder_roll"), name("shoulder_yaw"), at(side.at(kShoulderYaw)), z,
            arm);
  add_bar(name("upper_arm"), side.at(kElbow), kArmWidth, 90.0, arm);
  add_joint(name("shoulder_pitch"), name("shoulder_yaw"), name("upper_arm"), at(side.at(kShoulderPitch)), y,
            arm);
  add_bar(name("forearm"), side.at(kWrist), kArmWidth, 90.0, arm);
  add_joint(name("elbow_pitch"), name("upper_arm"), name("forearm"), at(side.at(kElbow)), y, arm);
  const Vector3 wrist = Vector3::Constant(kWristWidth);
  arm.links.push_back({name("wrist_pitch"), {}, solid_box_mass(20.0, Vector3::Zero(), wrist)});
  arm.links.back().solids.push_back({"housing", Hexahedron::from_size(wrist), Pose{}});
  add_joint(name("wrist_pitch"), name("forearm"), name("wrist_pitch"), at(side.at(kWrist)), y, arm);
  add_bar(name("wrist_yaw"), side.at(kWristRoll), kWristWidth, 30.0, arm);
  add_joint(name("wrist_yaw"), name("wrist_pitch"), name("wrist_yaw"), Pose{}, z, arm);
  add_otcm(side, arm);
  // Bars that a short link or none lies between meet in the joint that they share: not checked.
  arm.exempt_pairs.push_back({side.parent, name("shoulder_yaw")});
  arm.exempt_pairs.push_back({name("shoulder_roll"), name("upper_arm")});
  arm.exempt_pairs.push_back({name("forearm"), name("wrist_yaw")});
}

}  // namespace

MechanismDescription make_spdm() {
  MechanismDescription arm;
  arm.name = "spdm";
  const Vector3 crossing(kShoulder.x(), 0.0, 0.0), end(0.35, 0.0, 0.0);
  LinkDescription mount{"mount", {}, bar_mass(8.0, Vector3::Zero(), end, kBodyWidth)};
  mount.solids.push_back(make_bar(Vector3::Zero(), end, kBodyWidth, 0.0, "mount"));
  LinkDescription body{"body", {}, bar_mass(800.0, Vector3::Zero(), crossing, kBodyWidth)};
  body.solids.push_back(make_bar(Vector3::Zero(), crossing, kBodyWidth, 0.0, "trunk"));
  body.solids.push_back(make_bar({kShoulder.x(), 0.0, -kShoulder.z()}, kShoulder, kShoulderWidth,
                                 0.25 * kShoulderWidth, "beam"));
  arm.links = {mount, body};
  add_joint("body_roll", "mount", "body", Pose{}, Vector3::UnitX(), arm);

  Pose X = at(kShoulder);
  X.R << kHalfRoot, 0, kHalfRoot, 0, 1, 0, -kHalfRoot, 0, kHalfRoot;
  add_arm({"1", 1.0, "body"}, rigid_frame(X), arm);
  X.p.z() = -kShoulder.z();
  X.R << kHalfRoot, 0, -kHalfRoot, 0, 1, 0, kHalfRoot, 0, kHalfRoot;
  add_arm({"2", -1.0, "body"}, rigid_frame(X), arm);
  return arm;
}

MechanismDescription make_spdm_arm() {
  MechanismDescription arm;
  arm.name = "spdm_arm";
  const Vector3 foot(0.8, 0.0, 0.0);
  LinkDescription post{"post", {}, bar_mass(100.0, Vector3::Zero(), foot, 0.3)};
  post.solids.push_back(make_bar(Vector3::Zero(), foot, 0.3, 0.0, "post"));
  arm.links = {post};
  add_arm({"1", 1.0, "post"}, Pose{}, arm);
  return arm;
}

}  // namespace touchstone
