#include "touchstone/physics/scene/scene_arm.hpp"

#include <vector>

#include "touchstone/contact_core/geometry/matrix3.hpp"
#include "touchstone/contact_core/input_error.hpp"

namespace touchstone::physics {
namespace {

/// Adds links as objects; returns the object of each, kNoObject for frames.
std::vector<std::size_t> add_links(DynamicScene& scene, const Mechanism& arm, const std::string& name,
                                   std::span<const Pose> X_WL, const Surface& surface) {
  std::vector<std::size_t> object_of;
  for (std::size_t i = 0; i < arm.links().size(); ++i) {
    const Mechanism::Link& link = arm.links()[i];
    object_of.push_back(link.tree ? scene.scene.objects.size() : kNoObject);
    if (!link.tree) continue;
    const std::string full = name + "." + link.name;
    if (find_object(scene.scene, full) != kNoObject)
      throw InputError("the scene has an object '" + full + "'");
    scene.scene.objects.push_back({HexahedronTree(link.tree->solids(), full), X_WL[i], {}, {}});
    SceneBody body;
    body.surface = surface;
    if (link.joint != Mechanism::kNone) {
      body.kind = BodyKind::link;
      body.inertia = {link.mass.mass, link.mass.centre_L, link.mass.inertia_L};
    }
    scene.bodies.push_back(body);
  }
  return object_of;
}

SceneJoint joint_of(const Mechanism::Joint& joint, std::span<const Pose> X_WL,
                    std::span<const std::size_t> object_of, std::span<const double> q) {
  SceneJoint out;
  out.name = joint.name;
  out.kind = joint.kind;
  out.parent = object_of[joint.inner];
  out.child = object_of[joint.outer];
  const Pose X_WJ = compose(X_WL[joint.inner], joint.X_PJ);
  out.p_W = X_WJ.p;
  out.axis_W = rotate(X_WJ.R, joint.axis_J);
  out.axis_W = out.axis_W / norm(out.axis_W);
  if (joint.kind == JointKind::fixed) return out;
  out.value = q[joint.value];
  out.lower = joint.lower, out.upper = joint.upper;
  out.most_rate = joint.rate, out.effort = joint.effort;
  out.drive.drive.mode = JointDrive::Mode::brake;
  out.drive.drive.limit = joint.effort;
  return out;
}

void add_exempt_pairs(Scene& scene, const Mechanism& arm, const std::string& name) {
  const auto count = static_cast<std::uint32_t>(arm.solids().size());
  for (std::uint32_t a = 0; a < count; ++a)
    for (std::uint32_t b = a + 1; b < count; ++b)
      if (arm.link_of(a) != arm.link_of(b) && arm.is_exempt(a, b))
        scene.exempt_pairs.push_back({name + "." + arm.solid_name(a), name + "." + arm.solid_name(b)});
}

}  // namespace

void add_arm(DynamicScene& scene, const Mechanism& arm, const std::string& name, const Pose& X_WB,
             std::span<const double> q, const Surface& surface) {
  if (q.size() != arm.value_count())
    throw InputError("arm '" + name + "': " + std::to_string(q.size()) + " joint values for " +
                     std::to_string(arm.value_count()) + " joints");
  if (!arm.is_within_limits(q)) throw InputError("arm '" + name + "': joint values out of limits");
  for (const SceneMechanism& other : scene.mechanisms)
    if (other.name == name) throw InputError("the mechanism '" + name + "' occurs twice");
  std::vector<Pose> X_WL(arm.links().size());
  arm.link_poses(X_WB, q, X_WL);
  const std::vector<std::size_t> object_of = add_links(scene, arm, name, X_WL, surface);
  SceneMechanism mechanism{name, {}, {}};
  for (const std::uint32_t index : arm.outwards()) {
    const Mechanism::Joint& joint = arm.joints()[index];
    if (object_of[joint.outer] == kNoObject && joint.kind == JointKind::fixed) continue;
    const bool inner_is_ground = joint.inner == arm.base();  // held, with hexahedra or without
    if (object_of[joint.outer] == kNoObject || (object_of[joint.inner] == kNoObject && !inner_is_ground))
      throw InputError("arm '" + name + "': joint '" + joint.name +
                       "' moves or holds a link without hexahedra");
    mechanism.joints.push_back(joint_of(joint, X_WL, object_of, q));
  }
  scene.mechanisms.push_back(mechanism);
  add_exempt_pairs(scene.scene, arm, name);
}

}  // namespace touchstone::physics
