#pragma once

#include <BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h>
#include <BulletDynamics/Featherstone/btMultiBodyJointLimitConstraint.h>
#include <BulletDynamics/Featherstone/btMultiBodyJointMotor.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>

#include <memory>
#include <span>
#include <vector>

#include "touchstone/adapters/bullet/engine.hpp"
#include "touchstone/physics/engine/engine_scene.hpp"

namespace touchstone::physics::bullet_dynamics {

/// How a body moves: its frame B, B's origin, turning.
struct BodyMotion {
  Pose X_WB;
  Vector3 v_W = Vector3::Zero(), w_W = Vector3::Zero();
};

/// [rad, rad/s] or [m, m/s].
struct JointMotion {
  double value = 0.0, rate = 0.0;
};

/// A body of a tree, and what holds it.
struct TreeLink {
  std::size_t body;
  std::size_t parent;               ///< body; EngineScene::kNone: the ground
  const EngineScene::Joint* joint;  ///< null: held fast
  std::size_t joint_index;          ///< of the scene, where there is a joint
  Pose X_PB;                        ///< held fast: where in the parent, or in the world
};

/// Bodies that joints and latches hold together, as one btMultiBody in a world: reduced coordinates
/// (Featherstone's articulated bodies), so that no joint and no latch gives way whatever the masses.
class Tree {
 public:
  /// Adds it to the world, at rest in the scene's initial pose. @param root a free body; EngineScene::kNone:
  /// the ground. @param links parents before children. @param shapes by body
  Tree(const EngineScene& scene, btMultiBodyDynamicsWorld& world, std::size_t root,
       std::vector<TreeLink> links, std::span<btCollisionShape* const> shapes);
  /// Takes it out of the world.
  ~Tree();
  Tree(const Tree&) = delete;
  Tree& operator=(const Tree&) = delete;

  /// The root's pose and velocity, and the joints' values and rates. What other bodies of the tree had more
  /// momentum than these rates give them becomes an impulse on the whole: what is latched in flight is caught
  /// without a loss. @param bodies by body @param joints of the scene
  void set_motion(std::span<const BodyMotion> bodies, std::span<const JointMotion> joints);
  /// From now on; all other joints and the root stay as they are. @param joint of the scene, of this tree
  void set_joint(std::size_t joint, double value, double rate);
  /// For the steps from now on. @param joint of the scene, of this tree
  void set_drive(std::size_t joint, const JointDrive& drive);
  /// Before each step: torques are gone after one.
  void apply_torques();
  /// For the next step, on a body of the tree: at its centre of mass.
  void push(std::size_t body, const Vector3& force_W, const Vector3& moment_W);
  /// After a step: where the links are.
  void read();

  std::span<const TreeLink> links() const { return links_; }
  std::size_t root() const { return root_; }
  /// @pre the body is the root or a link
  BodyMotion motion(std::size_t body) const;
  /// @pre of this tree
  JointMotion joint(std::size_t joint) const;
  /// The drive's over the last step of `step` seconds [N m] or [N].
  double torque(std::size_t joint, double step) const;

 private:
  struct Drive {
    std::size_t joint;
    int link;
    std::unique_ptr<btMultiBodyJointMotor> motor;
    std::unique_ptr<btMultiBodyJointLimitConstraint> stops;
    JointDrive command;
  };

  void set_up(int index, const TreeLink& link);
  void add_collider(int index, std::size_t body, btCollisionShape* shape);
  void add_drive(int index, const TreeLink& link);
  void catch_up(std::span<const BodyMotion> bodies);
  int index_of(std::size_t body) const;  ///< -1: the base
  const Drive& drive_of(std::size_t joint) const;

  const EngineScene& scene_;
  btMultiBodyDynamicsWorld& world_;
  std::size_t root_;
  std::vector<TreeLink> links_;
  std::unique_ptr<btMultiBody> tree_;
  std::vector<std::unique_ptr<btMultiBodyLinkCollider>> colliders_;
  std::vector<Drive> drives_;
  std::vector<btVector3> w_, v_;  // of base and links, in their own axes
  btAlignedObjectArray<btQuaternion> rotations_;
  btAlignedObjectArray<btVector3> origins_;
};

}  // namespace touchstone::physics::bullet_dynamics
