#include "touchstone/adapters/scene_files/arm_reader.hpp"

#include "touchstone/adapters/scene_files/scene_head.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/physics/scene/scene_arm.hpp"

namespace touchstone::scene_files {
namespace {

physics::Surface read_surface(const YamlReader& item) {
  physics::Surface surface;
  if (item.has("friction")) surface.friction = item.at("friction").number();
  if (item.has("restitution")) surface.restitution = item.at("restitution").number();
  if (!(surface.friction >= 0.0)) item.at("friction").fail("must be >= 0");
  if (!(surface.restitution >= 0.0 && surface.restitution <= 1.0))
    item.at("restitution").fail("must be from 0 to 1");
  return surface;
}

/// As hands of scripts have it: joint values, and where one of the links then stands.
void read_arm(const YamlReader& item, physics::DynamicScene& scene) {
  item.require_keys({"name", "model", "link", "joints", "pose", "friction", "restitution"});
  const std::string name = item.at("name").text();
  const YamlReader reader = item.within("arm '" + name + "'");
  const Mechanism arm = read_arm_model(reader.at("model"));
  const std::vector<double> q = read_joint_values(reader.at("joints"), arm);
  const YamlReader pose = reader.at("pose");
  pose.require_keys({"position", "rpy"});
  Vector6 position = Vector6::Zero();
  if (pose.has("position")) position.head<3>() = pose.at("position").length3();
  if (pose.has("rpy")) position.tail<3>() = pose.at("rpy").vector3() * reader.source().radians_per_angle;
  const physics::Surface surface = read_surface(reader);
  reader.located([&] {
    const std::uint32_t link = arm.find_link(reader.at("link").text());
    if (q.size() != arm.value_count())
      throw InputError(std::to_string(q.size()) + " joint values for " + std::to_string(arm.value_count()) +
                       " joints");
    std::vector<Pose> X_BL(arm.links().size());
    arm.link_poses({}, q, X_BL);
    const Pose X_WB = rigid_frame(compose(pose_from_position_vector(position), inverse(X_BL[link])));
    physics::add_arm(scene, arm, name, X_WB, q, surface);
  });
}

}  // namespace

void read_arms(const YamlReader& arms, physics::DynamicScene& scene) {
  for (const YamlReader& item : arms.list()) read_arm(item, scene);
}

}  // namespace touchstone::scene_files
