#pragma once

#include "touchstone/contact_core/mechanism/arms/ssrms.hpp"
#include "touchstone/tests/support/degree.hpp"
#include "touchstone/tests/world/world_fixture.hpp"

namespace touchstone {

/// Bars of 2 x 0.2 x 0.2 m in a row along x, each turning about z at the end of the one before; bar k is link
/// `k`, the base `base` has none. The last link is followed by `tip`, a frame at its end.
inline MechanismDescription planar_arm(const std::string& name, int bars) {
  MechanismDescription out;
  out.name = name;
  out.links.push_back({"base", {}, {}});
  for (int k = 1; k <= bars; ++k) {
    const std::string link = std::to_string(k);
    out.links.push_back({link, {{"bar", Hexahedron::from_size({2, 0.2, 0.2}), at(1, 0, 0)}}, {}});
    JointDescription joint;
    joint.name = "j" + link;
    joint.kind = JointKind::revolute;
    joint.parent = k == 1 ? "base" : std::to_string(k - 1);
    joint.child = link;
    joint.X_PJ = at(k == 1 ? 0 : 2, 0, 0);
    joint.lower = -4, joint.upper = 4;
    out.joints.push_back(joint);
  }
  out.links.push_back({"tip", {}, {}});
  JointDescription end;
  end.name = "end";
  end.parent = std::to_string(bars);
  end.child = "tip";
  end.X_PJ = at(2, 0, 0);
  out.joints.push_back(end);
  return out;
}

inline std::shared_ptr<const Mechanism> make_arm(const std::string& name, int bars,
                                                 const std::string& base = "base") {
  MechanismDescription description = planar_arm(name, bars);
  description.base = base;
  return std::make_shared<const Mechanism>(description);
}

inline std::shared_ptr<const Mechanism> make_ssrms_arm(const std::string& name = "ssrms",
                                                       const std::string& base = "base_lee") {
  MechanismDescription description = make_ssrms();
  description.name = name;
  description.base = base;
  return std::make_shared<const Mechanism>(description);
}

inline FrameReport move_joints(ContactWorld& world, MechanismHandle arm, const std::vector<double>& values) {
  const JointCommand command{arm, values};
  return world.frame({}, {&command, 1});
}

inline std::vector<double> joints_of(const ContactWorld& world, MechanismHandle arm) {
  const std::span<const double> values = world.joint_values(arm);
  return {values.begin(), values.end()};
}

}  // namespace touchstone
