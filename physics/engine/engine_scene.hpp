#pragma once

#include <span>
#include <string>
#include <vector>

#include "touchstone/physics/engine/dynamics_engine.hpp"

namespace touchstone::physics {

/// A dynamic scene in the terms of rigid-body engines: bodies in frames B at their centre of mass, along
/// their principal axes. Links that fixed joints make one are one body. Immutable; for adapters.
class EngineScene {
 public:
  static constexpr std::size_t kNone = static_cast<std::size_t>(-1);

  /// A body: solids that move as one.
  struct Body {
    std::string name;  ///< "object 'x'", for messages
    ContactSide kind = ContactSide::ground;
    double mass = 0.0;                  ///< [kg]; of free bodies and links
    Vector3 moments = Vector3::Zero();  ///< along B's axes [kg m2]; a link's may be 0
    Pose X_WB;                          ///< at the start
    Vector3 v_W = Vector3::Zero();      ///< of B's origin [m/s]
    Vector3 w_W = Vector3::Zero();      ///< [rad/s]
    std::vector<std::size_t> objects;   ///< more than one: links
    std::vector<SolidIndex> solids;     ///< of all of them
  };
  /// A joint that moves; fixed joints are part of bodies.
  struct Joint {
    JointAddress address;
    std::string name;  ///< "joint 'arm.elbow'"
    const SceneJoint* source;
    std::size_t parent;  ///< body; kNone: the ground
    std::size_t child;
  };
  /// A joint between bodies, from DynamicScene::joints.
  struct BodyJoint {
    const SceneBodyJoint* source;
    std::size_t parent, child;  ///< bodies; kNone: the ground
  };
  /// A hexahedron of a body.
  struct Solid {
    const Hexahedron* solid;
    std::size_t object, body;
    Pose X_BS;
  };

  /// Keeps a reference to `scene`. @pre it is valid.
  explicit EngineScene(const DynamicScene& scene);

  const DynamicScene& scene() const { return *scene_; }
  std::span<const Body> bodies() const { return bodies_; }
  std::span<const Joint> joints() const { return joints_; }                ///< parents before children
  std::span<const BodyJoint> body_joints() const { return body_joints_; }  ///< as the scene counts them
  std::span<const Solid> solids() const { return solids_; }                ///< as the scene counts them
  std::size_t body_of(std::size_t object) const { return body_of_[object]; }
  const Pose& X_BO(std::size_t object) const { return X_BO_[object]; }
  const Surface& surface(SolidIndex solid) const { return scene_->bodies[solids_[solid].object].surface; }
  /// As the contacts of the own engine have them (NarrowphaseContacts).
  double friction(SolidIndex a, SolidIndex b) const { return pair_surface(a, b).friction; }
  double restitution(SolidIndex a, SolidIndex b) const { return pair_surface(a, b).restitution; }
  /// Whether all pairs follow the usual rules: friction the geometric mean of the two objects', restitution
  /// the larger.
  bool has_usual_surfaces() const { return surfaces_.is_usual(); }

  /// Whether the scene's own rules have the pair checked, latches apart: it is of two bodies, one of them
  /// free or a link, not listed, not of two links that a joint joins.
  bool is_checked(SolidIndex a, SolidIndex b) const;
  /// Pairs of bodies of which no pair of solids is checked though one of them moves. a < b, ascending.
  std::span<const std::pair<std::size_t, std::size_t>> exempt_bodies() const { return exempt_bodies_; }
  /// Two bodies of which some pairs are checked and some are not, in words; empty: there are none.
  const std::string& partly_exempt() const { return partly_exempt_; }
  bool has_exemptions() const { return !exempt_solids_.empty() || !exempt_objects_.empty(); }

 private:
  Surface pair_surface(SolidIndex a, SolidIndex b) const;
  void cluster_links();
  void place(std::size_t body);
  void add_joints();
  void add_body_joints();
  void start_links();
  void list_exempt();
  void compare_exempt();

  const DynamicScene* scene_;
  SurfacePairs surfaces_;  // numbers are objects
  std::vector<Body> bodies_;
  std::vector<Joint> joints_;
  std::vector<BodyJoint> body_joints_;
  std::vector<Solid> solids_;
  std::vector<std::size_t> body_of_;  // by object
  std::vector<Pose> X_BO_;            // by object
  std::vector<SolidPair> exempt_solids_;
  std::vector<std::pair<std::size_t, std::size_t>> exempt_objects_, exempt_bodies_;
  std::string partly_exempt_;
};

}  // namespace touchstone::physics
