#include "touchstone/examples/dynamics_run/robot_scene.hpp"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "touchstone/adapters/robots/simplify.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/examples/robot_files/robot_files.hpp"
#include "touchstone/physics/bodies/inertia.hpp"
#include "touchstone/physics/scene/scene_arm.hpp"

namespace touchstone::dynamics {
namespace {

constexpr double kDensity = 1000.0;  // [kg/m3]
constexpr double kUnseen = 0.01;     // side of what stands for a link without hexahedra [m]

/// Links that joints move and that have no hexahedra, as of a steering hinge: each gets a cube, which meets
/// nothing. Returns their names.
std::vector<std::string> add_unseen(MechanismDescription& robot) {
  std::vector<std::string> unseen;
  for (LinkDescription& link : robot.links) {
    const bool is_moved =
        std::any_of(robot.joints.begin(), robot.joints.end(), [&](const JointDescription& joint) {
          return joint.child == link.name && joint.kind != JointKind::fixed;
        });
    if (!is_moved || !link.solids.empty()) continue;
    const Pose X_LS{Matrix3::Identity(), link.mass.mass > 0.0 ? link.mass.centre_L : Vector3::Zero()};
    link.solids.push_back({"unseen", Hexahedron::from_size({kUnseen, kUnseen, kUnseen}), X_LS});
    unseen.push_back(link.name);
  }
  return unseen;
}

void exempt_from_all(const std::string& object, Scene& scene) {
  for (const SceneObject& other : scene.objects)
    if (other.tree.name() != object) scene.exempt_pairs.push_back({object, other.tree.name()});
}

MechanismDescription with_masses(MechanismDescription robot) {
  for (LinkDescription& link : robot.links) {
    if (link.mass.mass > 0.0 || link.solids.empty()) continue;
    const physics::BodyInertia inertia = physics::inertia_of_density(link.solids, kDensity, link.name);
    link.mass = {inertia.mass, inertia.centre_B, inertia.inertia_B, inertia.centre_B};
  }
  return robot;
}

/// The lowest point and the farthest from the base's origin, in the world.
struct Size {
  double lowest = 0.0, reach = 0.0;
};

Size size_of(const Mechanism& robot, std::span<const double> q) {
  std::vector<Pose> X_WL(robot.links().size());
  robot.link_poses({}, q, X_WL);
  Size size;
  for (std::uint32_t i = 0; i < robot.solids().size(); ++i)
    for (const Vector3& v : robot.solids()[i].vertices()) {
      const Vector3 p = transform(X_WL[robot.link_of(i)], transform(robot.placed(i).X_OS, v));
      size.lowest = std::min(size.lowest, p.z() - robot.solids()[i].radius());
      size.reach = std::max(size.reach, norm(p) + robot.solids()[i].radius());
    }
  return size;
}

void add_floor(const Size& size, physics::DynamicScene& out) {
  const double side = 4.0 * size.reach, thickness = 0.1 * size.reach;
  HexahedronTree floor({{"floor", Hexahedron::from_size({side, side, thickness}, "floor"), {}}}, "floor");
  const double top = size.lowest - 0.01 * size.reach;
  out.scene.objects.push_back(
      {std::move(floor), {Matrix3::Identity(), {0.0, 0.0, top - 0.5 * thickness}}, {}, {}});
  out.bodies.emplace_back();
}

}  // namespace

physics::DynamicScene robot_scene(const MechanismDescription& description) {
  MechanismDescription joined = without_fixed_joints(description);
  const std::vector<std::string> unseen = add_unseen(joined);
  const Mechanism robot(with_masses(std::move(joined)));
  if (robot.value_count() == 0) throw InputError("robot '" + robot.name() + "': no joint moves");
  const std::vector<double> q = robot_files::start_values(robot);
  physics::DynamicScene out;
  out.scene.name = "Robot " + robot.name();
  out.scene.units = "length m, angle rad";
  out.scene.frame_rate = 50.0;
  out.scene.contact_gap = 1e-6;
  out.scene.policy = ContactPolicy::advance;
  out.scene.duration = 0.5;
  out.gravity_W = {0.0, 0.0, -9.81};
  add_floor(size_of(robot, q), out);
  physics::add_arm(out, robot, robot.name(), {}, q, {});
  for (const std::string& link : unseen) exempt_from_all(robot.name() + "." + link, out.scene);
  for (physics::SceneJoint& joint : out.mechanisms[0].joints) joint.drive = {};
  physics::validate(out);
  return out;
}

}  // namespace touchstone::dynamics
