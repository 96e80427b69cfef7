#include <algorithm>
#include <cmath>

#include "touchstone/contact_core/geometry/matrix3.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/contact_core/scene/motion.hpp"
#include "touchstone/contact_core/scene/scene_instance.hpp"
#include "touchstone/physics/scene/scene_simulation.hpp"

// Set-up: bodies, mechanisms, contacts.

namespace touchstone::physics {
namespace {

constexpr const char* kGround = "(ground)";

/// The joint's frame at the start: its origin on the axis, turned as the child.
Pose joint_frame(const SceneJoint& joint, const Pose& X_WO) {
  if (joint.kind == JointKind::fixed) return X_WO;
  return rigid_frame({X_WO.R, joint.p_W});
}

/// The same, the joint's value taken back.
Pose frame_at_0(const SceneJoint& joint, const Pose& X_WL) {
  Pose X = X_WL;
  if (joint.kind == JointKind::revolute)
    X.R = product(X_WL.R, rotation_about(rotate_back(X_WL.R, joint.axis_W), -joint.value));
  if (joint.kind == JointKind::prismatic) X.p -= joint.value * joint.axis_W;
  return X;
}

/// A mechanism as it stands at the start, each link's frame at its joint.
struct ArmAtStart {
  MechanismDescription description;
  std::vector<Pose> X_WL;     // by object, of links
  std::vector<double> q, qd;  // by joint that moves
};

JointDescription describe_joint(const SceneJoint& joint, const DynamicScene& scene,
                                std::span<const Pose> X_WL) {
  JointDescription out;
  out.name = joint.name;
  out.kind = joint.kind;
  // A parent that never moves counts as the mechanism's ground.
  const bool is_ground = joint.parent == kNoObject || scene.bodies[joint.parent].kind == BodyKind::fixed;
  out.parent = is_ground ? kGround : scene.scene.objects[joint.parent].tree.name();
  out.child = scene.scene.objects[joint.child].tree.name();
  // The frame is that at value 0, since the scene gives poses at the start.
  const Pose& X_WC = X_WL[joint.child];
  out.X_PJ = rigid_frame(compose(is_ground ? Pose{} : inverse(X_WL[joint.parent]), frame_at_0(joint, X_WC)));
  out.axis_J = rotate_back(X_WC.R, joint.axis_W);
  out.lower = joint.lower, out.upper = joint.upper;
  out.rate = joint.most_rate, out.effort = joint.effort;
  return out;
}

ArmAtStart describe_arm(const SceneMechanism& source, const DynamicScene& scene) {
  ArmAtStart out{.description = {.name = source.name, .links = {{.name = kGround}}, .joints = {}},
                 .X_WL = std::vector<Pose>(scene.bodies.size()),
                 .q = {},
                 .qd = {}};
  // Each link's frame lies at its joint.
  for (const SceneJoint& joint : source.joints)
    out.X_WL[joint.child] = joint_frame(joint, scene.scene.objects[joint.child].X_WO);
  for (const SceneJoint& joint : source.joints) {
    // Each joint and its child link are described, solids in the link's frame.
    const JointDescription described = describe_joint(joint, scene, out.X_WL);
    out.description.links.push_back({.name = described.child, .solids = {}});
    const SceneObject& child = scene.scene.objects[joint.child];
    const Pose X_LO = compose(inverse(out.X_WL[joint.child]), child.X_WO);
    for (const PlacedHexahedron& placed : child.tree.solids())
      out.description.links.back().solids.push_back({placed.name, placed.solid, compose(X_LO, placed.X_OS)});
    out.description.joints.push_back(described);
    // Fixed joints have no value.
    if (joint.kind == JointKind::fixed) continue;
    out.q.push_back(joint.value);
    out.qd.push_back(joint.rate);
    out.description.reference.push_back(joint.value);
  }
  return out;
}

std::vector<double> rotors_of(const SceneMechanism& source) {
  std::vector<double> rotors;
  for (const SceneJoint& joint : source.joints)
    if (joint.kind != JointKind::fixed) rotors.push_back(joint.rotor);
  return rotors;
}

}  // namespace

/// Every object that may ever move by itself is a body of the world; those that are carried are held out.
void SceneSimulation::place_objects() {
  pieces_.resize(scene_->bodies.size());
  for (std::size_t i = 0; i < pieces_.size(); ++i) {
    const SceneBody& body = scene_->bodies[i];
    Piece& piece = pieces_[i];
    piece.root = i;
    piece.name = "object '" + name_of(i) + "'";
    piece.X_WF = scene_->scene.objects[i].X_WO;
    if (body.kind == BodyKind::kinematic)
      piece.root_mover = Mover::of_body(world_->add_kinematic(piece.X_WF, Vector3::Zero(), Vector3::Zero()));
    if (body.kind == BodyKind::dynamic) {
      piece.body.emplace(body.inertia, piece.name);
      piece.root_mover =
          Mover::of_body(world_->add_body(*piece.body, piece.body->state(piece.X_WF, body.v_W, body.w_W)));
    }
    piece.mover = piece.root_mover;
  }
}

/// Objects become links of the mechanism, with their inertias in the links' frames.
void SceneSimulation::make_links(std::size_t mechanism, std::span<const Pose> X_WL) {
  Arm& arm = *arms_[mechanism];
  arm.links.resize(arm.mechanism.links().size());
  for (const SceneJoint& joint : scene_->mechanisms[mechanism].joints) {
    Piece& piece = pieces_[joint.child];
    const std::uint32_t link = arm.mechanism.find_link(name_of(joint.child));
    piece.root_mover = piece.mover = Mover::of_link(static_cast<std::uint32_t>(mechanism), link);
    piece.X_FO = compose(inverse(X_WL[joint.child]), scene_->scene.objects[joint.child].X_WO);
    arm.links[link] = transform(piece.X_FO, scene_->bodies[joint.child].inertia);
  }
}

void SceneSimulation::make_arm(std::size_t mechanism) {
  const SceneMechanism& source = scene_->mechanisms[mechanism];
  const ArmAtStart start = describe_arm(source, *scene_);
  try {
    // The mechanism is built before its links, whose numbers it gives.
    arms_.push_back(
        std::make_unique<Arm>(Arm{Mechanism(start.description), {}, {}, {}, {}, {}, start.qd, {}}));
    Arm& arm = *arms_.back();
    make_links(mechanism, start.X_WL);
    // Drives and rotor inertias go by joint.
    for (const Mechanism::Joint& joint : arm.mechanism.joints()) arm.value_of.push_back(joint.value);
    for (const SceneJoint& joint : source.joints) arm.drives.push_back(joint.drive);
    arm.drives_since.assign(source.joints.size(), 0.0);
    arm.dynamics = std::make_unique<MechanismDynamics>(arm.mechanism, arm.links);
    arm.dynamics->set_rotors(rotors_of(source));
    arm.scratch.emplace(*arm.dynamics);
    // The world takes the arm with its initial values, rates and losses.
    const std::uint32_t index = world_->add_mechanism(*arm.dynamics, {}, start.q, start.qd);
    for (std::size_t j = 0; j < source.joints.size(); ++j)
      if (arm.value_of[j] != Mechanism::kNone)
        world_->set_losses(index, arm.value_of[j], source.joints[j].losses);
  } catch (const InputError& error) {
    throw InputError(source.where + error.what());
  }
}

/// Called where all objects stand; those with joints are never carried, so that their movers stay.
void SceneSimulation::make_body_joints() {
  for (const SceneBodyJoint& source : scene_->joints) {
    // z of its frame is the axis; x and y are arbitrary.
    Matrix3 R;
    const Vector3 z = source.axis_W;
    const int least = std::abs(z.x()) <= std::abs(z.y()) && std::abs(z.x()) <= std::abs(z.z()) ? 0
                      : std::abs(z.y()) <= std::abs(z.z())                                     ? 1
                                                                                               : 2;
    Vector3 x = cross(z, Vector3(Vector3::Unit(least)));
    x = x / norm(x);
    R.col(0) = x, R.col(1) = cross(z, x), R.col(2) = z;
    const Pose X_WJ = rigid_frame({R, source.p_W});
    // Each side's frame is expressed in its mover, or in the world where that is the ground.
    WorldJoint joint;
    const auto frame = [&](std::size_t object, Mover& mover) -> Pose {
      if (object == kNoObject) return X_WJ;
      mover = pieces_[object].mover;
      if (mover.kind == Mover::Kind::ground) return X_WJ;
      return compose(inverse(root_pose(pieces_[object].root)), X_WJ);
    };
    joint.joint.kind = source.kind;
    joint.joint.X_AJ = frame(source.parent, joint.a);
    joint.joint.X_BJ = frame(source.child, joint.b);
    // Limits, losses and the drive are copied.
    joint.lower = source.lower, joint.upper = source.upper;
    joint.losses = source.losses;
    joint.is_on = source.is_on;
    body_drives_.push_back(source.drive);
    body_drives_since_.push_back(0.0);
    // The world validates the joint, and its drive is commanded at once.
    try {
      world_->add_joint(joint);
    } catch (const InputError& error) {
      throw InputError(source.where + "joint '" + source.name + "': " + error.what());
    }
    apply_body_drive(body_drives_.size() - 1);
  }
}

void SceneSimulation::build_world() {
  // The world's settings are those of the scene.
  DynamicsWorld::Settings settings;
  settings.gravity_W = scene_->gravity_W;
  settings.contact_gap = scene_->scene.contact_gap;
  settings.bounce_speed = scene_->bounce_speed;
  settings.push_out = scene_->push_out;
  settings.part_speed = scene_->part_speed;
  settings.sleep_speed = scene_->sleep_speed;
  settings.sleep_time = scene_->sleep_time;
  world_ = std::make_unique<DynamicsWorld>(settings);
  // Objects, arms and initial latches enter the world.
  place_objects();
  for (std::size_t m = 0; m < scene_->mechanisms.size(); ++m) make_arm(m);
  for (std::size_t i = 0; i < scene_->scene.latches.size(); ++i)
    latch(find_object(scene_->scene, scene_->scene.latches[i].carrier),
          find_object(scene_->scene, scene_->scene.latches[i].carried), i);
  // Drives are commanded, and joints between bodies made, once the latches hold.
  for (std::size_t m = 0; m < arms_.size(); ++m)
    for (std::size_t j = 0; j < arms_[m]->drives.size(); ++j) apply_drive({m, j});
  make_body_joints();
  // Objects that come in later are taken out.
  const std::vector<std::uint8_t> is_out = absent_at_start(*scene_);
  for (std::size_t i = 0; i < pieces_.size(); ++i)
    if (is_out[i] != 0) go(i);
  // Memory is reserved, and the contacts are set up.
  world_->reserve(kReservedContacts);
  forces_.reserve(kReservedContacts);
  name_solids();
  list_exempt();
  contacts_ = make_();
  fill(*contacts_);
  contacts_->find(*world_, scene_->step);  // so that the backends' memory is there
  worlds_ = 1;
  // Scratch memory fits the largest arm, and the initial state is kept.
  std::size_t most = 0;
  for (const std::unique_ptr<Arm>& arm : arms_) most = std::max(most, arm->value_of.size());
  joint_q_.reserve(most);
  joint_qd_.reserve(most);
  initial_ = std::make_unique<Snapshot>(snapshot());
}

void SceneSimulation::name_solids() {
  for (std::size_t i = 0; i < pieces_.size(); ++i) {
    const HexahedronTree& tree = scene_->scene.objects[i].tree;
    for (const PlacedHexahedron& placed : tree.solids()) {
      solid_names_.push_back(tree.name() + "/" + placed.name);
      object_of_.push_back(i);
    }
  }
}

void SceneSimulation::fill(NarrowphaseContacts& contacts) const {
  for (std::size_t i = 0; i < pieces_.size(); ++i) {
    const Piece& piece = pieces_[i];
    contacts.add(piece.mover, scene_->scene.objects[i].tree, scene_->bodies[i].surface, pose_in_mover(piece),
                 kind_of(i) == BodyKind::fixed);
  }
  contacts.set_surfaces(surface_pairs(*scene_));
  contacts.reserve_exempt_solids(listed_.size());
  exempt_pairs(contacts);
  contacts.build();
  for (std::size_t i = 0; i < pieces_.size(); ++i) contacts.hold_out(index_of(i), pieces_[i].is_out);
}

void SceneSimulation::list_exempt(std::span<const ExemptPair> pairs, std::size_t carried, std::size_t latch) {
  for (const ExemptPair& pair : pairs)
    for (const SolidIndex a : find_solids(scene_->scene, pair.first))
      for (const SolidIndex b : find_solids(scene_->scene, pair.second))
        if (object_of_[a] != object_of_[b]) listed_.push_back({{a, b}, carried, latch});
}

void SceneSimulation::list_exempt() {
  const Scene& scene = scene_->scene;
  list_exempt(scene.exempt_pairs, kNoObject, kNoLatch);
  for (std::size_t i = 0; i < scene.latches.size(); ++i)
    list_exempt(scene.latches[i].allowed, find_object(scene, scene.latches[i].carried), i);
  for (std::size_t i = 0; i < scene_->actions.size(); ++i)
    list_exempt(scene_->actions[i].allowed, scene_->actions[i].carried, scene.latches.size() + i);
  for (std::size_t i = 0; i < scene_->latch_options.size(); ++i)
    list_exempt(scene_->latch_options[i].allowed, scene_->latch_options[i].carried,
                first_latch_option(*scene_) + i);
  cluster_ = find_clusters();
}

/// Pairs that are not checked: listed ones, links that a joint joins, links that fixed joints make one, and
/// what neither forces nor joints move.
void SceneSimulation::exempt_pairs(NarrowphaseContacts& contacts) const {
  for (const ListedPair& pair : listed_)
    if (pair.carried == kNoObject || pieces_[pair.carried].latch == pair.latch)
      contacts.exempt_solids(pair.solids.a, pair.solids.b);
  for (const SceneMechanism& mechanism : scene_->mechanisms)
    for (const SceneJoint& joint : mechanism.joints)
      if (joint.parent != kNoObject) contacts.exempt_parts(index_of(joint.parent), index_of(joint.child));
  for (std::size_t j = 0; j < scene_->joints.size(); ++j) {
    const SceneBodyJoint& joint = scene_->joints[j];
    if (joint.parent != kNoObject && world_->world_joint(static_cast<std::uint32_t>(j)).is_on)
      contacts.exempt_parts(index_of(joint.parent), index_of(joint.child));
  }
  for (std::size_t i = 0; i < pieces_.size(); ++i)
    for (std::size_t k = 0; k < i; ++k)
      if (cluster_[i] == cluster_[k] || (is_commanded(i) && is_commanded(k)))
        contacts.exempt_parts(index_of(i), index_of(k));
}

/// Links that fixed joints make one have one number.
std::vector<std::size_t> SceneSimulation::find_clusters() const {
  std::vector<std::size_t> cluster(pieces_.size());
  for (std::size_t i = 0; i < cluster.size(); ++i) cluster[i] = i;
  for (const SceneMechanism& mechanism : scene_->mechanisms)
    for (const SceneJoint& joint : mechanism.joints) {
      if (joint.parent == kNoObject || joint.kind != JointKind::fixed) continue;
      const std::size_t from = cluster[joint.child], to = cluster[joint.parent];
      std::replace(cluster.begin(), cluster.end(), from, to);
    }
  return cluster;
}

}  // namespace touchstone::physics
