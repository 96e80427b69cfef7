#include "physics/scene_simulation.hpp"

#include <algorithm>
#include <cmath>

#include "contact_core/input_error.hpp"
#include "contact_core/scene/motion.hpp"
#include "physics/matrix3.hpp"
#include "physics/quaternion.hpp"

namespace touchstone::physics {
namespace {

constexpr const char* kGround = "(ground)";
/// Contacts that memory is there for; more cost an allocation when they first come.
constexpr std::size_t kReserved = 128;

bool is_identity(const Pose& X) { return X.R == Matrix3::Identity() && X.p == Vector3::Zero(); }

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

/// The angular velocity that turns one attitude into another in `h`, the shorter way round.
Vector3 rate_between(const Quaternion& from, const Quaternion& to, double h) {
  Quaternion turn = to * Quaternion{from.w, -from.v};
  if (turn.w < 0.0) turn = {-turn.w, -turn.v};
  const double sine = norm(turn.v);
  if (sine == 0.0) return Vector3::Zero();
  return (2.0 * std::atan2(sine, turn.w) / (sine * h)) * turn.v;
}

/// Any of them may have no mass.
void add_inertia(BodyInertia& sum, const BodyInertia& part) {
  if (part.mass == 0.0) return;
  sum = sum.mass == 0.0 ? part : combined(sum, part);
}

}  // namespace

SceneSimulation::SceneSimulation(const DynamicScene& scene, MakeContacts make)
    : scene_(&scene), make_(std::move(make)) {
  validate(scene);
  place_objects();
  for (std::size_t m = 0; m < scene.mechanisms.size(); ++m) make_arm(m);
  for (const SceneLatch& each : scene.scene.latches)
    latch(find_object(scene.scene, each.carrier), find_object(scene.scene, each.carried));
  build_world();
}

// ---- set-up

void SceneSimulation::place_objects() {
  pieces_.resize(scene_->bodies.size());
  for (std::size_t i = 0; i < pieces_.size(); ++i) {
    const SceneBody& body = scene_->bodies[i];
    Piece& piece = pieces_[i];
    piece.root = i;
    piece.X_WF = scene_->scene.objects[i].X_WO;
    if (body.kind != BodyKind::dynamic) continue;
    piece.body.emplace(body.inertia, "object '" + name_of(i) + "'");
    piece.state = piece.body->state(piece.X_WF, body.v_W, body.w_W);
  }
}

void SceneSimulation::make_arm(std::size_t mechanism) {
  const SceneMechanism& source = scene_->mechanisms[mechanism];
  MechanismDescription description{.name = source.name, .links = {{.name = kGround}}, .joints = {}};
  std::vector<Pose> X_WL(pieces_.size());  // by object, of links
  for (const SceneJoint& joint : source.joints)
    X_WL[joint.child] = joint_frame(joint, scene_->scene.objects[joint.child].X_WO);
  std::vector<double> q, qd;
  for (const SceneJoint& joint : source.joints) {
    JointDescription out;
    out.name = joint.name;
    out.kind = joint.kind;
    const bool is_ground = joint.parent == kNoObject || kind_of(joint.parent) == BodyKind::fixed;
    out.parent = is_ground ? kGround : name_of(joint.parent);
    out.child = name_of(joint.child);
    const Pose& X_WC = X_WL[joint.child];
    out.X_PJ =
        rigid_frame(compose(is_ground ? Pose{} : inverse(X_WL[joint.parent]), frame_at_0(joint, X_WC)));
    out.axis_J = rotate_back(X_WC.R, joint.axis_W);
    out.lower = joint.lower, out.upper = joint.upper;
    out.rate = joint.most_rate, out.effort = joint.effort;
    description.links.push_back({.name = out.child});
    description.joints.push_back(out);
    if (joint.kind == JointKind::fixed) continue;
    q.push_back(joint.value);
    qd.push_back(joint.rate);
    description.reference.push_back(joint.value);
  }
  try {
    arms_.push_back(std::make_unique<Arm>(Arm{Mechanism(description), {}, {}, {}, {}, {}, q, qd, {}}));
    Arm& arm = *arms_.back();
    arm.links.resize(arm.mechanism.links().size());
    for (const SceneJoint& joint : source.joints) {
      Piece& piece = pieces_[joint.child];
      const std::uint32_t link = arm.mechanism.find_link(name_of(joint.child));
      piece.mover = Mover::of_link(static_cast<std::uint32_t>(mechanism), link);
      piece.X_FO = compose(inverse(X_WL[joint.child]), scene_->scene.objects[joint.child].X_WO);
      arm.links[link] = transform(piece.X_FO, scene_->bodies[joint.child].inertia);
    }
    for (const Mechanism::Joint& joint : arm.mechanism.joints()) arm.value_of.push_back(joint.value);
    for (const SceneJoint& joint : source.joints) arm.drives.push_back(joint.drive);
    arm.drives_since.assign(source.joints.size(), 0.0);
    place_arm(arm);
  } catch (const InputError& error) {
    throw InputError(source.where + error.what());
  }
}

/// For the links' inertias as they are now.
void SceneSimulation::place_arm(Arm& arm) {
  arm.dynamics = std::make_unique<MechanismDynamics>(arm.mechanism, arm.links);
  arm.placed = arm.dynamics->make_workspace();
  arm.dynamics->place({}, arm.q, arm.qd, arm.placed);
}

void SceneSimulation::build_world() {
  DynamicsWorld::Settings settings;
  settings.gravity_W = scene_->gravity_W;
  settings.contact_gap = scene_->scene.contact_gap;
  settings.bounce_speed = scene_->bounce_speed;
  settings.push_out = scene_->push_out;
  contacts_.reset();
  world_ = std::make_unique<DynamicsWorld>(settings);
  add_movers();
  world_->reserve(kReserved);
  forces_.reserve(kReserved);
  place_trees();
  contacts_ = make_();
  fill(*contacts_);
  found_ = {};
  ++worlds_;
}

void SceneSimulation::add_movers() {
  for (std::size_t i = 0; i < pieces_.size(); ++i) {
    Piece& piece = pieces_[i];
    if (piece.root != i) continue;
    if (kind_of(i) == BodyKind::kinematic)
      piece.mover = Mover::of_body(world_->add_kinematic(piece.X_WF, Vector3::Zero(), Vector3::Zero()));
    if (kind_of(i) == BodyKind::dynamic)
      piece.mover = Mover::of_body(world_->add_body(*piece.body, piece.state));
  }
  for (Piece& piece : pieces_) piece.mover = pieces_[piece.root].mover;
  for (std::size_t m = 0; m < arms_.size(); ++m) {
    world_->add_mechanism(*arms_[m]->dynamics, {}, arms_[m]->q, arms_[m]->qd);
    for (std::size_t j = 0; j < arms_[m]->drives.size(); ++j) tell_drive({m, j});
  }
}

/// Trees in their movers' frames.
void SceneSimulation::place_trees() {
  solid_names_.clear();
  object_of_.clear();
  for (std::size_t i = 0; i < pieces_.size(); ++i) {
    Piece& piece = pieces_[i];
    const HexahedronTree& tree = scene_->scene.objects[i].tree;
    const bool is_ground = piece.mover.kind == Mover::Kind::ground;
    const Pose X_MO = is_ground ? compose(pieces_[piece.root].X_WF, piece.X_FO) : piece.X_FO;
    piece.tree_M.reset();
    for (const PlacedHexahedron& placed : tree.solids()) {
      solid_names_.push_back(tree.name() + "/" + placed.name);
      object_of_.push_back(i);
    }
    if (is_identity(X_MO)) continue;
    std::vector<PlacedHexahedron> solids = tree.solids();
    for (PlacedHexahedron& placed : solids) placed.X_OS = compose(X_MO, placed.X_OS);
    piece.tree_M.emplace(std::move(solids), tree.name());
  }
}

void SceneSimulation::fill(NarrowphaseContacts& contacts) const {
  for (std::size_t i = 0; i < pieces_.size(); ++i) {
    const Piece& piece = pieces_[i];
    contacts.add(piece.mover, piece.tree_M ? *piece.tree_M : scene_->scene.objects[i].tree,
                 scene_->bodies[i].surface);
  }
  exempt_listed(contacts);
  exempt_joined(contacts);
  contacts.build();
}

std::vector<std::size_t> SceneSimulation::objects_of(const std::string& name) const {
  std::vector<std::size_t> out;
  for (std::size_t i = 0; i < pieces_.size(); ++i) {
    const std::vector<std::string>& groups = scene_->scene.objects[i].groups;
    if (name_of(i) == name || std::find(groups.begin(), groups.end(), name) != groups.end()) out.push_back(i);
  }
  return out;
}

void SceneSimulation::exempt_listed(NarrowphaseContacts& contacts) const {
  const auto exempt = [&](const ExemptPair& pair) {
    for (const std::size_t a : objects_of(pair.first))
      for (const std::size_t b : objects_of(pair.second))
        contacts.exempt_parts(static_cast<std::uint32_t>(a), static_cast<std::uint32_t>(b));
  };
  for (const ExemptPair& pair : scene_->scene.exempt_pairs) exempt(pair);
  for (const SceneLatch& each : scene_->scene.latches)
    if (pieces_[find_object(scene_->scene, each.carried)].carrier != kNoObject)
      for (const ExemptPair& pair : each.allowed) exempt(pair);
}

/// Links that a joint joins, links that fixed joints make one, and what neither forces nor joints move.
void SceneSimulation::exempt_joined(NarrowphaseContacts& contacts) const {
  const auto exempt = [&](std::size_t a, std::size_t b) {
    contacts.exempt_parts(static_cast<std::uint32_t>(a), static_cast<std::uint32_t>(b));
  };
  std::vector<std::size_t> cluster(pieces_.size());
  for (std::size_t i = 0; i < cluster.size(); ++i) cluster[i] = i;
  for (const SceneMechanism& mechanism : scene_->mechanisms)
    for (const SceneJoint& joint : mechanism.joints) {
      if (joint.parent == kNoObject) continue;
      exempt(joint.parent, joint.child);
      if (joint.kind != JointKind::fixed) continue;
      const std::size_t from = cluster[joint.child], to = cluster[joint.parent];
      std::replace(cluster.begin(), cluster.end(), from, to);
    }
  const auto is_told = [&](std::size_t i) {
    return pieces_[i].mover.kind != Mover::Kind::link && !dynamic_body(i);
  };
  for (std::size_t i = 0; i < pieces_.size(); ++i)
    for (std::size_t k = 0; k < i; ++k)
      if (cluster[i] == cluster[k] || (is_told(i) && is_told(k))) exempt(i, k);
}

// ---- latches

Pose SceneSimulation::root_pose(std::size_t root) const {
  const Piece& piece = pieces_[root];
  if (piece.body) return piece.body->pose(piece.state);
  if (kind_of(root) != BodyKind::link) return piece.X_WF;
  const Arm& arm = *arms_[piece.mover.index];
  return arm.dynamics->link_pose(piece.mover.link, arm.placed);
}

bool SceneSimulation::is_carried_by(std::size_t object, std::size_t carrier) const {
  for (std::size_t i = object; i != kNoObject; i = pieces_[i].carrier)
    if (i == carrier) return true;
  return false;
}

/// Of the root with all that moves with it, in the root's frame.
BodyInertia SceneSimulation::inertia_of_root(std::size_t root) const {
  BodyInertia sum;
  for (std::size_t i = 0; i < pieces_.size(); ++i)
    if (pieces_[i].root == root) add_inertia(sum, transform(pieces_[i].X_FO, scene_->bodies[i].inertia));
  return sum;
}

void SceneSimulation::latch(std::size_t carrier, std::size_t carried) {
  const std::size_t root = pieces_[carrier].root;
  Piece &to = pieces_[root], &from = pieces_[carried];
  const Pose X_FG = compose(inverse(root_pose(root)), root_pose(carried));
  if (to.body) {
    const LatchedBodies both = physics::latch(*to.body, to.state, *from.body, from.state, name_of(root));
    to.body = both.body;
    to.state = both.state;
  } else if (kind_of(root) == BodyKind::link) {
    Arm& arm = *arms_[to.mover.index];
    const std::unique_ptr<MechanismDynamics> before = std::move(arm.dynamics);
    const MechanismDynamics::Workspace placed = std::move(arm.placed);
    BodyInertia& link = arm.links[to.mover.link];
    link = latched_link(link, before->link_pose(to.mover.link, placed), *from.body, from.state);
    place_arm(arm);
    capture(*before, placed, *arm.dynamics, to.mover.link, from.state, arm.q, arm.qd);
    arm.dynamics->place({}, arm.q, arm.qd, arm.placed);
  }
  from.carrier = carrier;
  from.body.reset();
  for (Piece& piece : pieces_) {
    if (piece.root != carried) continue;
    piece.root = root;
    piece.X_FO = compose(X_FG, piece.X_FO);
  }
}

void SceneSimulation::release(std::size_t carried) {
  const std::size_t root = pieces_[carried].root;
  const Pose X_FG = pieces_[carried].X_FO;
  for (std::size_t i = 0; i < pieces_.size(); ++i) {
    if (!is_carried_by(i, carried)) continue;
    pieces_[i].root = carried;
    pieces_[i].X_FO = i == carried ? Pose{} : compose(inverse(X_FG), pieces_[i].X_FO);
  }
  const RigidBody part(inertia_of_root(carried), "object '" + name_of(carried) + "'");
  const Pose X_WG = compose(root_pose(root), X_FG);
  Piece &from = pieces_[root], &to = pieces_[carried];
  to.carrier = kNoObject;
  if (from.body) {
    to.state = physics::release(*from.body, from.state, part, X_FG);
    const RigidBody rest(inertia_of_root(root), "object '" + name_of(root) + "'");
    from.state = physics::release(*from.body, from.state, rest, {});
    from.body = rest;
  } else if (kind_of(root) == BodyKind::link) {
    Arm& arm = *arms_[from.mover.index];
    std::vector<double> J(arm.q.size());
    const auto turn_about = [&](int axis) {
      arm.dynamics->turn_jacobian(from.mover.link, Vector3::Unit(axis), J, arm.placed);
      double sum = 0.0;
      for (std::size_t k = 0; k < J.size(); ++k) sum += J[k] * arm.qd[k];
      return sum;
    };
    const Vector3 centre_W = touchstone::transform(X_WG, part.inertia().centre_B);
    to.state = part.state(X_WG, arm.dynamics->point_velocity(from.mover.link, centre_W, arm.placed),
                          {turn_about(0), turn_about(1), turn_about(2)});
    arm.links[from.mover.link] = inertia_of_root(root);
    place_arm(arm);
  } else {
    const bool moves = from.mover.kind == Mover::Kind::body;
    const Vector3 w = moves ? world_->angular_velocity(from.mover.index) : Vector3(Vector3::Zero());
    const Vector3 v = moves ? world_->velocity(from.mover.index) : Vector3(Vector3::Zero());
    const Vector3 centre_W = touchstone::transform(X_WG, part.inertia().centre_B);
    to.state = part.state(X_WG, v + cross(w, centre_W - from.X_WF.p), w);
  }
  to.body = part;
}

/// What the world has, for the next one.
void SceneSimulation::keep_states() {
  for (std::size_t i = 0; i < pieces_.size(); ++i) {
    Piece& piece = pieces_[i];
    if (piece.root != i || piece.mover.kind != Mover::Kind::body) continue;
    if (piece.body)
      piece.state = world_->state(piece.mover.index);
    else
      piece.X_WF = world_->pose(piece.mover.index);
  }
  for (std::uint32_t m = 0; m < arms_.size(); ++m) {
    Arm& arm = *arms_[m];
    const auto q = world_->joint_values(m), qd = world_->joint_rates(m);
    arm.qd.assign(qd.begin(), qd.end());
    // At an end stop a value is out of its limits by a rounding.
    for (std::size_t j = 0; j < arm.drives.size(); ++j) {
      const SceneJoint& joint = scene_->mechanisms[m].joints[j];
      if (const std::uint32_t value = arm.value_of[j]; value != Mechanism::kNone)
        arm.q[value] = std::min(std::max(q[value], joint.lower), joint.upper);
    }
    arm.dynamics->place({}, arm.q, arm.qd, arm.placed);
  }
}

// ---- a step

bool SceneSimulation::is_due(const SceneAction& action) const {
  return static_cast<double>(steps_) >= action.time / scene_->step * (1.0 - 0x1p-40);
}

void SceneSimulation::set_drive(const JointAddress& joint, const SceneDrive& drive) {
  Arm& arm = *arms_[joint.mechanism];
  arm.drives[joint.joint] = drive;
  arm.drives_since[joint.joint] = time();
  tell_drive(joint);
}

void SceneSimulation::tell_drive(const JointAddress& joint) {
  const Arm& arm = *arms_[joint.mechanism];
  const std::uint32_t value = arm.value_of[joint.joint];
  if (value == Mechanism::kNone) return;
  SceneDrive drive = arm.drives[joint.joint];
  drive.drive.limit =
      std::min(drive.drive.limit, scene_->mechanisms[joint.mechanism].joints[joint.joint].effort);
  // Constant over the step: as in its middle.
  drive.drive.torque += drive.ramp * ((time() + 0.5 * scene_->step) - arm.drives_since[joint.joint]);
  world_->set_drive(static_cast<std::uint32_t>(joint.mechanism), value, drive.drive);
}

/// So that it is where it is told at the step's end, from where it is: what rounding takes does not add up.
void SceneSimulation::move_kinematic(std::size_t object) {
  const SceneObject& source = scene_->scene.objects[object];
  const std::uint32_t index = pieces_[object].mover.index;
  const Pose X = pose_at(source.motion, source.X_WO, static_cast<double>(steps_ + 1) * scene_->step);
  const RigidBodyState& state = world_->state(index);
  world_->set_velocity(index, (X.p - state.p_W) / scene_->step,
                       rate_between(state.q_WB, quaternion_of(X.R), scene_->step));
}

void SceneSimulation::begin_step() {
  bool is_new = false;
  const auto take_apart = [&] {
    if (!is_new) keep_states();
    is_new = true;
  };
  for (; next_action_ < scene_->actions.size() && is_due(scene_->actions[next_action_]); ++next_action_) {
    const SceneAction& action = scene_->actions[next_action_];
    if (action.kind == SceneAction::Kind::drive) set_drive(action.joint, action.drive);
    if (action.kind == SceneAction::Kind::latch) take_apart(), latch(action.carrier, action.carried);
    if (action.kind == SceneAction::Kind::release) take_apart(), release(action.carried);
  }
  if (is_new) build_world();
  for (std::size_t m = 0; m < arms_.size(); ++m)
    for (std::size_t j = 0; j < arms_[m]->drives.size(); ++j)
      if (arms_[m]->drives[j].ramp != 0.0) tell_drive({m, j});
  for (std::size_t i = 0; i < pieces_.size(); ++i)
    if (kind_of(i) == BodyKind::kinematic) move_kinematic(i);
}

std::span<const Contact> SceneSimulation::find_contacts() {
  found_ = contacts_->find(*world_);
  forces_.assign(found_.size(), ContactForce{Vector3::Zero(), Vector3::Zero()});
  return found_;
}

StepReport SceneSimulation::advance() {
  const StepReport report = world_->step(scene_->step, found_, std::span(forces_).first(found_.size()));
  if (report.failure == StepFailure::none) ++steps_;
  return report;
}

// ---- what there is

Pose SceneSimulation::object_pose(std::size_t object) const {
  const Piece& piece = pieces_[object];
  if (piece.mover.kind == Mover::Kind::body) return compose(world_->pose(piece.mover.index), piece.X_FO);
  if (piece.mover.kind == Mover::Kind::link)
    return compose(world_->link_pose(piece.mover.index, piece.mover.link), piece.X_FO);
  return compose(pieces_[piece.root].X_WF, piece.X_FO);
}

std::optional<std::uint32_t> SceneSimulation::dynamic_body(std::size_t object) const {
  const Piece& piece = pieces_[pieces_[object].root];
  if (!piece.body) return std::nullopt;
  return piece.mover.index;
}

std::optional<Vector3> SceneSimulation::velocity(std::size_t object) const {
  const auto body = dynamic_body(object);
  return body ? std::optional(world_->velocity(*body)) : std::nullopt;
}

std::optional<Vector3> SceneSimulation::angular_velocity(std::size_t object) const {
  const auto body = dynamic_body(object);
  return body ? std::optional(world_->angular_velocity(*body)) : std::nullopt;
}

double SceneSimulation::joint_value(const JointAddress& joint) const {
  const std::uint32_t value = arms_[joint.mechanism]->value_of[joint.joint];
  if (value == Mechanism::kNone) return 0.0;
  return world_->joint_values(static_cast<std::uint32_t>(joint.mechanism))[value];
}

double SceneSimulation::joint_rate(const JointAddress& joint) const {
  const std::uint32_t value = arms_[joint.mechanism]->value_of[joint.joint];
  if (value == Mechanism::kNone) return 0.0;
  return world_->joint_rates(static_cast<std::uint32_t>(joint.mechanism))[value];
}

double SceneSimulation::joint_torque(const JointAddress& joint) const {
  const std::uint32_t value = arms_[joint.mechanism]->value_of[joint.joint];
  if (value == Mechanism::kNone) return 0.0;
  return world_->joint_torques(static_cast<std::uint32_t>(joint.mechanism))[value];
}

std::string SceneSimulation::failed_name(const StepReport& report) const {
  if (report.failure == StepFailure::mechanism)
    return "mechanism '" + scene_->mechanisms[report.failed_index].name + "'";
  for (std::size_t i = 0; report.failure == StepFailure::body && i < pieces_.size(); ++i)
    if (pieces_[i].mover == Mover::of_body(report.failed_index)) return "object '" + name_of(i) + "'";
  return "";
}

}  // namespace touchstone::physics
