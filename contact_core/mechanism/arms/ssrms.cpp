#include "touchstone/contact_core/mechanism/arms/ssrms.hpp"

#include <array>
#include <numbers>

#include "touchstone/contact_core/mechanism/arms/link_parts.hpp"
#include "touchstone/contact_core/mechanism/round_parts.hpp"

namespace touchstone {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

// Nguyen and Hughes 1994 [m].
constexpr double kLee = 1.3589, kCluster = 0.7026, kOffset = 0.5692, kBoom = 7.11, kElbow = 0.475;
constexpr double kLeeMass = 243.66, kClusterMass = 105.98, kUpperMass = 314.88, kLowerMass = 279.2;  // [kg]

constexpr double kBoomRadius = 0.175, kLeeRadius = 0.208, kBoreRadius = 0.100;  // [m]
constexpr double kBoreDepth = 0.30;                                             // [m], assumed
constexpr int kBoomFacets = 12, kFacets = 8;

enum LinkIndex : std::size_t {
  kBaseLee,
  kShoulderRoll,
  kShoulderYaw,
  kUpperBoom,
  kLowerBoom,
  kWristPitch,
  kWristYaw,
  kTipLee,
  kTip,
  kLinks,
};
constexpr std::array<const char*, kLinks> kNames = {"base_lee",   "shoulder_roll", "shoulder_yaw",
                                                    "upper_boom", "lower_boom",    "wrist_pitch",
                                                    "wrist_yaw",  "tip_lee",       "tip"};

/// A frame at `p` whose z axis is the link's x, -y or z axis: signs and zeros only.
enum class Along { x, minus_y, z };
Pose frame(const Vector3& p, Along along) {
  Pose X;
  X.p = p;
  if (along == Along::x) X.R << 0, 0, 1, 0, 1, 0, -1, 0, 0;
  if (along == Along::minus_y) X.R << 1, 0, 0, 0, 0, -1, 0, 1, 0;
  return X;
}

MassProperties published(double mass, const Vector3& centre_L, double xx, double yy, double zz, double xy) {
  MassProperties out{mass, centre_L, Matrix3::Zero(), Vector3::Zero()};
  out.inertia_L << xx, xy, 0, xy, yy, 0, 0, 0, zz;
  return out;
}

/// Body and bore of an end effector whose joint is at `joint_x` and whose mouth is at `mouth_x`.
void add_lee(LinkIndex link, double joint_x, double mouth_x, MechanismDescription& arm) {
  const bool mouth_first = mouth_x < joint_x;
  const double body_x = mouth_first ? mouth_x + kBoreDepth : joint_x;
  const double bore_x = mouth_first ? mouth_x : mouth_x - kBoreDepth;
  append(
      make_cylinder(kLeeRadius, kLee - kBoreDepth, kFacets, false, frame({body_x, 0, 0}, Along::x), "body"),
      link, arm);
  append(
      make_tube(kLeeRadius, kBoreRadius, kBoreDepth, kFacets, false, frame({bore_x, 0, 0}, Along::x), "bore"),
      link, arm);
  arm.links[link].mass = published(kLeeMass, {0.5 * (joint_x + mouth_x), 0, 0}, 9.336, 44.41, 44.41, 0.0);
}

/// A housing from the link's joint along z or -y, `span` to the next, standing out by its radius at both
/// ends.
void add_cluster(LinkIndex link, const Vector3& next, MechanismDescription& arm) {
  const double span = norm(next);
  const Vector3 direction = next / span;
  const bool is_along_y = next.z() == 0.0;
  const bool is_downwards = next.z() < 0.0;  // the prism then starts at the far end
  const Vector3 start = -kBoomRadius * direction;
  const Vector3 far_end = (span + kBoomRadius) * direction;
  append(
      make_cylinder(kBoomRadius, span + 2.0 * kBoomRadius, kFacets, false,
                    frame(is_downwards ? far_end : start, is_along_y ? Along::minus_y : Along::z), "housing"),
      link, arm);
  Vector3 size = Vector3::Constant(2.0 * kBoomRadius);
  size(is_along_y ? 1 : 2) = span + 2.0 * kBoomRadius;
  arm.links[link].mass = solid_box_mass(kClusterMass, 0.5 * next, size);
}

void add_booms(MechanismDescription& arm) {
  for (const LinkIndex link : {kUpperBoom, kLowerBoom})
    append(make_cylinder(kBoomRadius, kBoom, kBoomFacets, false, frame({0, 0, 0}, Along::x), "boom"), link,
           arm);
  append(make_cylinder(kBoomRadius, kElbow, kFacets, false, frame({kBoom, 0, 0}, Along::minus_y), "elbow"),
         kUpperBoom, arm);
  arm.links[kUpperBoom].mass =
      published(kUpperMass, {0.5 * kBoom, -0.5 * kElbow, 0}, 15.41, 2094.71, 2103.19, 49.52);
  arm.links[kLowerBoom].mass = published(kLowerMass, {0.5 * kBoom, 0, 0}, 9.522, 1966.28, 1966.28, -39.95);
}

void add_joint(const char* name, LinkIndex child, const Vector3& origin, const Vector3& axis,
               MechanismDescription& arm) {
  JointDescription joint;
  joint.name = name;
  joint.kind = JointKind::revolute;
  joint.parent = kNames[child - 1];
  joint.child = kNames[child];
  joint.X_PJ.p = origin;
  joint.axis_J = axis;
  joint.lower = -270.0 * kDegree;
  joint.upper = 270.0 * kDegree;
  joint.rate = 4.0 * kDegree;
  joint.effort = 2332.0;
  arm.joints.push_back(joint);
}

}  // namespace

MechanismDescription make_ssrms() {
  MechanismDescription arm;
  arm.name = "ssrms";
  for (const char* name : kNames) arm.links.push_back({name, {}, {}});

  // The links get their solids, from base to tip.
  add_lee(kBaseLee, kLee, 0.0, arm);
  add_cluster(kShoulderRoll, {0, 0, kCluster}, arm);
  add_cluster(kShoulderYaw, {0, -kOffset, 0}, arm);
  add_booms(arm);
  add_cluster(kWristPitch, {0, -kOffset, 0}, arm);
  add_cluster(kWristYaw, {0, 0, -kCluster}, arm);
  add_lee(kTipLee, 0.0, kLee, arm);

  // Seven joints connect them.
  const Vector3 x = Vector3::UnitX(), y = Vector3::UnitY(), z = Vector3::UnitZ();
  add_joint("shoulder_roll", kShoulderRoll, {kLee, 0, 0}, x, arm);
  add_joint("shoulder_yaw", kShoulderYaw, {0, 0, kCluster}, z, arm);
  add_joint("shoulder_pitch", kUpperBoom, {0, -kOffset, 0}, y, arm);
  add_joint("elbow_pitch", kLowerBoom, {kBoom, -kElbow, 0}, y, arm);
  add_joint("wrist_pitch", kWristPitch, {kBoom, 0, 0}, y, arm);
  add_joint("wrist_yaw", kWristYaw, {0, -kOffset, 0}, z, arm);
  add_joint("wrist_roll", kTipLee, {0, 0, -kCluster}, x, arm);

  // The tip is a frame at the mouth, fixed to the last end effector.
  JointDescription mouth;
  mouth.name = "mouth";
  mouth.parent = kNames[kTipLee];
  mouth.child = kNames[kTip];
  mouth.X_PJ.p = {kLee, 0, 0};
  arm.joints.push_back(mouth);
  return arm;
}

MechanismDescription make_walking_ssrms() {
  MechanismDescription arm = make_ssrms();
  arm.links.push_back({"base_tip", {}, {}});
  JointDescription mouth{"base_mouth", JointKind::fixed, kNames[kBaseLee], "base_tip"};
  mouth.X_PJ.R << -1, 0, 0, 0, -1, 0, 0, 0, 1;
  arm.joints.push_back(mouth);
  return arm;
}

}  // namespace touchstone
