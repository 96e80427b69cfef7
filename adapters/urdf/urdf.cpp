#include "touchstone/adapters/urdf/urdf.hpp"

#include <console_bridge/console.h>
#include <urdf_model/model.h>
#include <urdf_parser/urdf_parser.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "touchstone/adapters/robots/builder.hpp"
#include "touchstone/adapters/robots/mesh_units.hpp"
#include "touchstone/adapters/robots/text_file.hpp"
#include "touchstone/contact_core/geometry/matrix3.hpp"

namespace touchstone::urdf {
namespace {

/// Keeps what urdfdom reports as errors for as long as it lives.
class ErrorLog final : public console_bridge::OutputHandler {
 public:
  ErrorLog() { console_bridge::useOutputHandler(this); }
  ~ErrorLog() override { console_bridge::restorePreviousOutputHandler(); }
  ErrorLog(const ErrorLog&) = delete;
  ErrorLog& operator=(const ErrorLog&) = delete;

  void log(const std::string& text, console_bridge::LogLevel level, const char*, int) override {
    if (level >= console_bridge::CONSOLE_BRIDGE_LOG_ERROR) errors += (errors.empty() ? "" : "; ") + text;
  }

  std::string errors;
};

Vector3 vector(const ::urdf::Vector3& v) { return {v.x, v.y, v.z}; }

Pose pose(const ::urdf::Pose& X, const std::string& name) {
  double x = 0, y = 0, z = 0, w = 1;
  X.rotation.getQuaternion(x, y, z, w);
  Pose out;
  out.R = rotation_from_quaternion(w, x, y, z, name);
  out.p = vector(X.position);
  return out;
}

struct Reader {
  const ::urdf::ModelInterface& model;
  const std::string& source;
  const RobotOptions& options;
  Robot robot = {};
  MechanismDescription& out = robot.mechanism;
  RobotBuilder builder{robot, options, source};
  std::set<std::string> links_taken = {}, joints_taken = {};

  std::string link_label(const std::string& link) const { return source + ": link '" + link + "'"; }
  std::string joint_label(const std::string& joint) const { return source + ": joint '" + joint + "'"; }

  void read() {
    out.name = model.getName();
    take_link(*model.getRoot());
    // Links that the root does not lead to come last, for Mechanism to name.
    for (const auto& entry : model.links_)
      if (!links_taken.contains(entry.first)) take_link(*entry.second);
    for (const auto& entry : model.joints_)
      if (!joints_taken.contains(entry.first)) take_joint(*entry.second);
  }

  void take_link(const ::urdf::Link& link) {
    if (!links_taken.insert(link.name).second) return;
    const std::size_t index = builder.add_link(link.name);
    if (link.inertial) out.links[index].mass = mass_of(link);
    for (std::size_t i = 0; i < link.collision_array.size(); ++i) take_solid(link, i, index);
    for (const auto& joint : link.child_joints) {
      take_joint(*joint);
      if (const auto child = model.getLink(joint->child_link_name)) take_link(*child);
    }
  }

  MassProperties mass_of(const ::urdf::Link& link) const {
    const ::urdf::Inertial& inertial = *link.inertial;
    const Pose X_LI = pose(inertial.origin, link_label(link.name) + ", inertial");
    Matrix3 inertia_I;
    inertia_I << inertial.ixx, inertial.ixy, inertial.ixz,  //
        inertial.ixy, inertial.iyy, inertial.iyz,           //
        inertial.ixz, inertial.iyz, inertial.izz;
    const bool is_turned = X_LI.R != Matrix3::Identity();
    return {inertial.mass, X_LI.p, is_turned ? turned(X_LI.R, inertia_I) : inertia_I, X_LI.p};
  }

  std::string solid_name(const ::urdf::Link& link, std::size_t i) const {
    const std::string& name = link.collision_array[i]->name;
    const auto is_taken = [&] {
      for (std::size_t k = 0; k < i; ++k)
        if (link.collision_array[k]->name == name) return true;
      return false;
    };
    return name.empty() || is_taken() ? "collision." + std::to_string(i) : name;
  }

  void take_solid(const ::urdf::Link& link, std::size_t i, std::size_t index) {
    const ::urdf::Collision& collision = *link.collision_array[i];
    const std::string name = solid_name(link, i);
    const std::string label = link_label(link.name) + ", collision '" + name + "'";
    if (!collision.geometry) throw InputError(label + ": no geometry");
    const ShapePlace place{index, name, label, pose(collision.origin, label)};
    const ::urdf::Geometry& geometry = *collision.geometry;
    if (const auto* box = dynamic_cast<const ::urdf::Box*>(&geometry))
      builder.add_box(place, vector(box->dim));
    else if (const auto* cylinder = dynamic_cast<const ::urdf::Cylinder*>(&geometry))
      builder.add_cylinder(place, cylinder->radius, cylinder->length);
    else if (const auto* sphere = dynamic_cast<const ::urdf::Sphere*>(&geometry))
      builder.add_sphere(place, sphere->radius);
    else if (const auto* mesh = dynamic_cast<const ::urdf::Mesh*>(&geometry))
      builder.add_mesh_file(place, mesh->filename, vector(mesh->scale));
    else
      throw InputError(label + ": an unknown shape");
  }

  JointKind kind_of(const ::urdf::Joint& joint) {
    const std::string label = joint_label(joint.name);
    if (joint.mimic && options.mimic == MimicJoints::refuse)
      throw InputError(label + ": mimics '" + joint.mimic->joint_name +
                       "', coupled joints are not supported");
    if (joint.mimic)
      robot.notes.push_back(label + ": mimics '" + joint.mimic->joint_name + "'; here it moves by itself");
    switch (joint.type) {
      case ::urdf::Joint::REVOLUTE:
      case ::urdf::Joint::CONTINUOUS:
        return JointKind::revolute;
      case ::urdf::Joint::PRISMATIC:
        return JointKind::prismatic;
      case ::urdf::Joint::FIXED:
        return JointKind::fixed;
      case ::urdf::Joint::FLOATING:
        throw InputError(label + ": floating joints are not supported");
      case ::urdf::Joint::PLANAR:
        throw InputError(label + ": planar joints are not supported");
      default:
        throw InputError(label + ": unknown type");
    }
  }

  void take_joint(const ::urdf::Joint& from) {
    if (!joints_taken.insert(from.name).second) return;
    const std::string label = joint_label(from.name);
    JointDescription joint;
    joint.name = from.name;
    joint.kind = kind_of(from);
    joint.parent = from.parent_link_name;
    joint.child = from.child_link_name;
    joint.X_PJ = pose(from.parent_to_joint_origin_transform, label);
    if (joint.kind != JointKind::fixed) {
      const Vector3 axis = vector(from.axis);
      if (!(norm(axis) > 0.0) || !std::isfinite(norm(axis)))
        throw InputError(label + ": the axis has no direction");
      joint.axis_J = axis / norm(axis);
      take_limits(from, joint);
      out.reference.push_back(std::clamp(0.0, joint.lower, std::max(joint.lower, joint.upper)));
    }
    out.joints.push_back(joint);
  }

  static void take_limits(const ::urdf::Joint& from, JointDescription& joint) {
    if (!from.limits) return;
    joint.rate = from.limits->velocity;
    joint.effort = from.limits->effort;
    if (from.type == ::urdf::Joint::CONTINUOUS) return;
    joint.lower = from.limits->lower;
    joint.upper = from.limits->upper;
  }
};

/// Links that own each other in a ring would never be freed.
struct UnlinkOnExit {
  const ::urdf::ModelInterfaceSharedPtr& model;

  explicit UnlinkOnExit(const ::urdf::ModelInterfaceSharedPtr& of) : model(of) {}
  UnlinkOnExit(const UnlinkOnExit&) = delete;
  UnlinkOnExit& operator=(const UnlinkOnExit&) = delete;
  ~UnlinkOnExit() {
    if (!model) return;
    for (const auto& [name, link] : model->links_) link->child_links.clear();
  }
};

}  // namespace

Robot parse_robot(const std::string& xml, const std::string& source, const RobotOptions& options) {
  ::urdf::ModelInterfaceSharedPtr model;
  const UnlinkOnExit unlink(model);
  {
    ErrorLog log;
    model = ::urdf::parseURDF(xml);
    if (!model || !model->getRoot())
      throw InputError(source + ": " + (log.errors.empty() ? "not a URDF model" : log.errors));
    // urdfdom gives a model all the same, without the rest of the link after the shape that it could not
    // read.
    if (!log.errors.empty()) throw InputError(source + ": " + log.errors);
  }
  Reader reader{*model, source, options};
  reader.read();
  check_mesh_units(source, options, reader.robot);
  return std::move(reader.robot);
}

Robot load_robot(const std::filesystem::path& file, const RobotOptions& options) {
  return parse_robot(read_robot_text(file), file.string(), options);
}

MechanismDescription parse_urdf(const std::string& xml, const std::string& source,
                                const LoadOptions& options) {
  return parse_robot(xml, source, options).mechanism;
}

MechanismDescription load_urdf(const std::filesystem::path& file, const LoadOptions& options) {
  return load_robot(file, options).mechanism;
}

}  // namespace touchstone::urdf
