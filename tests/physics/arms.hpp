#pragma once

#include <random>
#include <span>
#include <string>
#include <vector>

#include "touchstone/contact_core/mechanism/arms/ssrms.hpp"
#include "touchstone/contact_core/mechanism/mechanism.hpp"
#include "touchstone/physics/bodies/inertia.hpp"
#include "touchstone/tests/support/random_poses.hpp"

// Arms that several tests move.

namespace touchstone::physics {

struct Arm {
  Mechanism mechanism;
  std::vector<BodyInertia> links;
};

/// The arm's published inertias taken as about the links' centres of mass, as about their frames they cannot
/// be.
inline Arm ssrms_arm() {
  Arm arm{Mechanism(make_ssrms()), {}};
  for (const Mechanism::Link& link : arm.mechanism.links())
    arm.links.push_back({link.mass.mass, link.mass.centre_L, link.mass.inertia_L});
  return arm;
}

/// Links along +x of these lengths [m], revolute joints about z at their inner ends.
inline MechanismDescription planar_arm(std::span<const double> lengths, const char* name = "arm") {
  MechanismDescription out{.name = name, .links = {{.name = "base"}}, .joints = {}};
  for (std::size_t i = 0; i < lengths.size(); ++i) {
    JointDescription joint;
    joint.name = "joint" + std::to_string(i + 1);
    joint.kind = JointKind::revolute;
    joint.parent = out.links.back().name;
    joint.child = "link" + std::to_string(i + 1);
    joint.X_PJ.p = {i == 0 ? 0.0 : lengths[i - 1], 0, 0};
    out.links.push_back({joint.child, {}, {}});
    out.joints.push_back(joint);
  }
  return out;
}

/// A chain of seven revolute joints (or a mix with prismatic ones) with turned frames and any inertia.
inline Arm random_arm(std::mt19937_64& random, bool with_prismatic) {
  MechanismDescription description{.name = "arm", .links = {{.name = "0"}}, .joints = {}};
  Arm arm{Mechanism(description), {box_inertia(2.0, {0.3, 0.2, 0.4})}};
  for (int i = 0; i < 7; ++i) {
    JointDescription joint;
    joint.name = "j" + std::to_string(i);
    joint.kind = with_prismatic && i % 3 == 1 ? JointKind::prismatic : JointKind::revolute;
    joint.parent = std::to_string(i);
    joint.child = std::to_string(i + 1);
    joint.X_PJ = random_pose(random, 1.0);
    const Vector3 axis = random_vector(random, 1.0);
    joint.axis_J = axis / norm(axis);
    description.joints.push_back(joint);
    description.links.push_back({joint.child, {}, {}});
    const double mass = uniform(random, 0.5, 5.0);
    BodyInertia box = box_inertia(mass, random_vector(random, 0.1, 0.8));
    const Matrix3 R = random_rotation(random);
    arm.links.push_back(transform({R, random_vector(random, 0.5)}, box));
  }
  arm.mechanism = Mechanism(description);
  return arm;
}

inline std::vector<double> random_values(std::mt19937_64& random, std::size_t count, double extent) {
  std::vector<double> out;
  for (std::size_t i = 0; i < count; ++i) out.push_back(uniform(random, -extent, extent));
  return out;
}

/// Largest difference over largest value.
inline double relative_error(std::span<const double> got, std::span<const double> expected) {
  double error = 0.0, scale = 0.0;
  for (std::size_t i = 0; i < expected.size(); ++i) {
    error = std::max(error, std::abs(got[i] - expected[i]));
    scale = std::max(scale, std::abs(expected[i]));
  }
  return error / scale;
}

/// One prismatic joint along `axis`.
inline Mechanism rail(const Vector3& axis, double lower = -INFINITY, double upper = INFINITY) {
  MechanismDescription description{
      .name = "slider", .links = {{.name = "base"}, {.name = "block"}}, .joints = {}};
  JointDescription joint;
  joint.name = "rail";
  joint.kind = JointKind::prismatic;
  joint.parent = "base";
  joint.child = "block";
  joint.axis_J = axis;
  joint.lower = lower, joint.upper = upper;
  description.joints.push_back(joint);
  return Mechanism(description);
}

}  // namespace touchstone::physics
