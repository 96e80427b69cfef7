#pragma once

#include <array>
#include <cmath>

#include "touchstone/contact_core/mechanism/mechanism.hpp"

// The oracle: forward kinematics written anew, in long double and with the first two derivatives carried
// along.

namespace touchstone::test {

struct Jet {
  long double v = 0, d = 0, dd = 0;

  Jet() = default;
  Jet(long double value, long double first = 0, long double second = 0) : v(value), d(first), dd(second) {}
};

inline Jet operator+(const Jet& a, const Jet& b) { return {a.v + b.v, a.d + b.d, a.dd + b.dd}; }
inline Jet operator-(const Jet& a, const Jet& b) { return {a.v - b.v, a.d - b.d, a.dd - b.dd}; }
inline Jet operator*(const Jet& a, const Jet& b) {
  return {a.v * b.v, a.d * b.v + a.v * b.d, a.dd * b.v + 2 * a.d * b.d + a.v * b.dd};
}
inline Jet sin(const Jet& a) {
  const long double s = std::sin(a.v), c = std::cos(a.v);
  return {s, c * a.d, c * a.dd - s * a.d * a.d};
}
inline Jet cos(const Jet& a) {
  const long double s = std::sin(a.v), c = std::cos(a.v);
  return {c, -s * a.d, -s * a.dd - c * a.d * a.d};
}

using JetVector = std::array<Jet, 3>;
inline JetVector operator+(const JetVector& a, const JetVector& b) {
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}
inline JetVector operator*(const Jet& k, const JetVector& a) { return {k * a[0], k * a[1], k * a[2]}; }
inline JetVector cross(const JetVector& a, const JetVector& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
inline Jet dot(const JetVector& a, const JetVector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
inline JetVector jets(const Vector3& v) { return {Jet(v.x()), Jet(v.y()), Jet(v.z())}; }

inline JetVector placed(const Pose& X, const JetVector& p) {
  JetVector out = jets(X.p);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) out[i] = out[i] + Jet(X.R(i, j)) * p[j];
  return out;
}

/// Rodrigues: v + sin (a x v) + (1 - cos) a x (a x v).
inline JetVector turn(const JetVector& axis, const Jet& angle, const JetVector& v) {
  const JetVector once = cross(axis, v);
  return v + sin(angle) * once + (Jet(1) - cos(angle)) * cross(axis, once);
}

/// A point fixed in the link, in the world, from the description and not from what Mechanism made of it: the
/// base is the description's first link.
inline JetVector world_point(const MechanismDescription& description, const Pose& X_WB,
                             const std::vector<double>& q0, const std::vector<double>& q1, long double s,
                             const std::string& link, const Vector3& p_L) {
  JetVector p = jets(p_L);
  std::string at = link;
  while (at != description.links[0].name) {
    std::size_t value = 0;
    for (const JointDescription& joint : description.joints) {
      const bool moves = joint.kind != JointKind::fixed;
      if (joint.child == at) {
        Jet q;
        if (moves)
          q = Jet(q0[value] + s * (static_cast<long double>(q1[value]) - q0[value]),
                  static_cast<long double>(q1[value]) - q0[value]);
        if (joint.kind == JointKind::revolute) p = turn(jets(joint.axis_J), q, p);
        if (joint.kind == JointKind::prismatic) p = p + q * jets(joint.axis_J);
        p = placed(joint.X_PJ, p);
        at = joint.parent;
        break;
      }
      value += moves;
    }
  }
  return placed(X_WB, p);
}

}  // namespace touchstone::test
