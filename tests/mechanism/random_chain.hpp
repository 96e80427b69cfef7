#pragma once

#include <random>

#include "touchstone/contact_core/mechanism/mechanism.hpp"

namespace touchstone::test {

/// Links in a row, each joint `step` along x from the one before, all turning about `axis`.
inline MechanismDescription straight_arm(int joints, double step, const Vector3& axis) {
  MechanismDescription out;
  out.name = "arm";
  out.links.push_back({"0", {}, {}});
  for (int j = 0; j < joints; ++j) {
    JointDescription joint;
    joint.name = "j" + std::to_string(j);
    joint.kind = JointKind::revolute;
    joint.parent = std::to_string(j);
    joint.child = std::to_string(j + 1);
    joint.X_PJ.p.x() = j == 0 ? 0.0 : step;
    joint.axis_J = axis;
    out.joints.push_back(joint);
    out.links.push_back({joint.child, {}, {}});
  }
  return out;
}

/// Draws mechanisms and paths; the same on every standard library for a seed.
class Draw {
 public:
  explicit Draw(std::uint64_t seed) : engine_(seed) {}

  double real(double low, double high) {
    return low + (high - low) * static_cast<double>(engine_() >> 11) * 0x1p-53;
  }
  int integer(int low, int high) {
    return low + static_cast<int>(engine_() % static_cast<std::uint64_t>(high - low + 1));
  }
  bool chance(double p) { return real(0, 1) < p; }
  Vector3 vector(double size) { return {real(-size, size), real(-size, size), real(-size, size)}; }
  Vector3 direction() {
    for (;;) {
      const Vector3 v = vector(1);
      const double length = norm(v);
      if (length > 0.1 && length < 1) return v / length;
    }
  }
  Pose pose(double size) {
    Pose X;
    X.R = rotation_about(direction(), real(-3, 3));
    X.p = vector(size);
    return X;
  }

  /// A tree of up to 9 links; a third have all axes parallel, as planar arms do.
  MechanismDescription mechanism() {
    MechanismDescription out;
    out.name = "random";
    out.links.push_back({"0", {}, {}});
    const bool planar = chance(1.0 / 3), along = chance(0.3);
    const int joints = integer(1, 8);
    for (int j = 0; j < joints; ++j) {
      JointDescription joint;
      joint.name = "j" + std::to_string(j);
      joint.kind = chance(0.75) ? JointKind::revolute : chance(0.7) ? JointKind::prismatic : JointKind::fixed;
      joint.parent = std::to_string(chance(0.85) ? j : integer(0, j));
      joint.child = std::to_string(j + 1);
      joint.X_PJ.p = along ? Vector3(real(0, 5), 0, 0) : vector(3);
      if (!planar && chance(0.5)) joint.X_PJ.R = rotation_about(direction(), real(-3, 3));
      joint.axis_J = planar        ? Vector3::UnitZ()
                     : chance(0.5) ? Vector3(Vector3::Unit(integer(0, 2)))
                                   : direction();
      out.joints.push_back(joint);
      out.links.push_back({joint.child, {}, {}});
    }
    return out;
  }

 private:
  std::mt19937_64 engine_;
};

}  // namespace touchstone::test
