#include "touchstone/examples/station/flight/scene_robot.hpp"

#include <algorithm>
#include <cmath>

#include "touchstone/contact_core/mechanism/arms/bundled_arms.hpp"
#include "touchstone/examples/station/flight/bytes.hpp"
#include "touchstone/examples/training_run/setting/robot_script.hpp"

namespace touchstone::station {
namespace {

using station::append;  // beside those of vectors and poses

void append(std::string& bits, const Vector3& v) {
  for (int axis = 0; axis < 3; ++axis) append(bits, v[axis]);
}

void append(std::string& bits, const Pose& X) {
  for (int column = 0; column < 3; ++column) append(bits, Vector3(X.R.col(column)));
  append(bits, X.p);
}

/// The hexahedra of an object that stand for none of the link's meshes.
std::shared_ptr<const TriangleMesh> rest_of(const HexahedronTree& tree, const std::vector<LinkMesh>& meshes,
                                            const std::string& link) {
  auto rest = std::make_shared<TriangleMesh>();
  for (const PlacedHexahedron& part : tree.solids()) {
    const auto stands_for = [&](const LinkMesh& mesh) {
      return mesh.link == link &&
             std::find(mesh.hexahedra.begin(), mesh.hexahedra.end(), part.name) != mesh.hexahedra.end();
    };
    if (std::any_of(meshes.begin(), meshes.end(), stands_for)) continue;
    const auto first = static_cast<std::uint32_t>(rest->vertices.size());
    for (const Vector3& vertex : part.solid.vertices())
      rest->vertices.push_back(transform(part.X_OS, vertex));
    for (const auto& face : Hexahedron::kFaceVertices)
      for (const int last : {2, 3})
        rest->triangles.push_back(
            {first + static_cast<std::uint32_t>(face[0]),
             first + static_cast<std::uint32_t>(face[static_cast<std::size_t>(last - 1)]),
             first + static_cast<std::uint32_t>(face[static_cast<std::size_t>(last)])});
  }
  return rest->triangles.empty() ? nullptr : rest;
}

}  // namespace

MechanismDescription SceneRobot::read(const std::filesystem::path& file, const SceneRobots& robots) {
  robot_files::RobotChoices choices = robots.choices;
  choices.keep_meshes = robots.shows_meshes;
  Robot robot = robot_files::load_robot_file(file, choices);
  if (robots.on_account) robots.on_account(robot_files::account_of(robot));
  meshes_ = std::move(robot.meshes);
  is_flown_ = true;
  return std::move(robot.mechanism);
}

Script SceneRobot::read_script(const std::filesystem::path& file, const SceneRobots& robots) {
  if (is_robot_file(file)) return training::robot_script(read(file, robots));
  return load_script(file, [&](const std::string& model, const std::filesystem::path& folder) {
    return is_robot_file(model) ? read(folder / model, robots) : make_bundled_arm(model);
  });
}

std::vector<ObjectMesh> SceneRobot::meshes(const training::Setting& setting) const {
  std::vector<ObjectMesh> out;
  if (setting.arms().empty()) return out;
  const training::Arm& arm = setting.arms()[0];
  for (std::uint32_t i = 0; i < arm.object_count; ++i) {
    // A link's frame is its object's.
    const std::uint32_t object = arm.first_object + i;
    const std::string& link = arm.mechanism->links()[arm.link_of_object[i]].name;
    const std::size_t before = out.size();
    for (const LinkMesh& mesh : meshes_)
      if (mesh.link == link) out.push_back({object, mesh.X_LM, mesh.mesh});
    if (out.size() == before) continue;
    if (auto rest = rest_of(*setting.instance().trees()[object], meshes_, link))
      out.push_back({object, {}, std::move(rest)});
  }
  return out;
}

std::string flown_bits(const training::Arm& arm) {
  std::string bits;
  // Hexahedra, joints and masses.
  const Mechanism& mechanism = *arm.mechanism;
  for (std::uint32_t i = 0; i < mechanism.solids().size(); ++i) {
    append(bits, mechanism.link_of(i));
    append(bits, mechanism.placed(i).X_OS);
    for (const Vector3& vertex : mechanism.placed(i).solid.vertices()) append(bits, vertex);
  }
  for (const Mechanism::Joint& joint : mechanism.joints()) {
    append(bits, joint.kind);
    append(bits, joint.inner);
    append(bits, joint.outer);
    append(bits, joint.X_PJ);
    append(bits, joint.axis_J);
    for (const double limit : {joint.lower, joint.upper, joint.rate, joint.effort}) append(bits, limit);
  }
  for (const Mechanism::Link& link : mechanism.links()) {
    append(bits, link.mass.mass);
    append(bits, link.mass.centre_L);
    append(bits, Pose{link.mass.inertia_L, link.mass.inertia_about_L});
  }
  // Pairs that are not checked; where the arm stands.
  const auto solids = static_cast<std::uint32_t>(mechanism.solids().size());
  for (std::uint32_t a = 0; a < solids; ++a)
    for (std::uint32_t b = a + 1; b < solids; ++b) append(bits, mechanism.is_exempt(a, b));
  append(bits, arm.X_WB);
  for (const double value : arm.joints) append(bits, value);
  return bits;
}

double extent_of(const training::Setting& setting, const training::Arm& arm) {
  double extent = 0.0;
  for (std::uint32_t i = arm.first_object; i < arm.first_object + arm.object_count; ++i) {
    const Sphere& sphere = setting.instance().trees()[i]->nodes()[0].sphere_O;
    const Vector3 centre = transform(setting.scene().objects[i].X_WO, sphere.centre);
    extent = std::max(extent, norm(centre - arm.X_WB.p) + sphere.radius);
  }
  return extent;
}

double reach_of(const Mechanism& mechanism) {
  std::vector<double> to_link(mechanism.links().size(), 0.0);  // from the base's origin to each link's
  for (const std::uint32_t index : mechanism.outwards()) {
    const Mechanism::Joint& joint = mechanism.joints()[index];
    const double slide = joint.kind == JointKind::prismatic && joint.value != Mechanism::kNone
                             ? std::max(std::abs(joint.lower), std::abs(joint.upper))
                             : 0.0;
    to_link[joint.outer] = to_link[joint.inner] + norm(joint.X_PJ.p) + slide + norm(joint.X_JC.p);
  }
  double reach = 0.0;
  for (std::size_t i = 0; i < mechanism.links().size(); ++i) {
    const HexahedronTree* tree = mechanism.links()[i].tree.get();
    if (tree == nullptr) continue;
    const Sphere& sphere = tree->nodes()[0].sphere_O;
    reach = std::max(reach, to_link[i] + norm(sphere.centre) + sphere.radius);
  }
  return reach;
}

}  // namespace touchstone::station
