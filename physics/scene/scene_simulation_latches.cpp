#include "touchstone/contact_core/geometry/pose.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/physics/scene/scene_simulation.hpp"

// Latches and releases, objects that come and go, in place.

namespace touchstone::physics {
Pose SceneSimulation::root_pose(std::size_t root) const {
  const Piece& piece = pieces_[root];
  if (piece.root_mover.kind == Mover::Kind::body) return world_->pose(piece.root_mover.index);
  if (piece.root_mover.kind == Mover::Kind::link)
    return world_->link_pose(piece.root_mover.index, piece.root_mover.link);
  return piece.X_WF;
}

bool SceneSimulation::is_carried_by(std::size_t object, std::size_t carrier) const {
  for (std::size_t i = object; i != kNoObject; i = pieces_[i].carrier)
    if (i == carrier) return true;
  return false;
}

/// Of a carried object with all that it carries, in that object's frame.
BodyInertia SceneSimulation::inertia_of_part(std::size_t carried) const {
  const Pose X_GF = inverse(pieces_[carried].X_FO);
  BodyInertia sum;
  for (std::size_t i = 0; i < pieces_.size(); ++i) {
    if (!is_carried_by(i, carried)) continue;
    const Pose X_GO = i == carried ? Pose{} : compose(X_GF, pieces_[i].X_FO);
    add_inertia(sum, transform(X_GO, scene_->bodies[i].inertia));
  }
  return sum;
}

/// Of all that moves with the root but that part, in the root's frame.
BodyInertia SceneSimulation::inertia_without(std::size_t root, std::size_t carried) const {
  BodyInertia sum;
  for (std::size_t i = 0; i < pieces_.size(); ++i)
    if (pieces_[i].root == root && !is_carried_by(i, carried))
      add_inertia(sum, transform(pieces_[i].X_FO, scene_->bodies[i].inertia));
  return sum;
}

/// The object in its mover's frame; the ground's is the world's.
Pose SceneSimulation::pose_in_mover(const Piece& piece) const {
  const bool is_ground = piece.mover.kind == Mover::Kind::ground;
  return is_ground ? compose(pieces_[piece.root].X_WF, piece.X_FO) : piece.X_FO;
}

/// Neither forces nor joints move it.
bool SceneSimulation::is_commanded(std::size_t object) const {
  return pieces_[object].mover.kind != Mover::Kind::link && !dynamic_body(object);
}

void SceneSimulation::change_contacts() {
  for (std::size_t i = 0; i < pieces_.size(); ++i) {
    contacts_->move_to(index_of(i), pieces_[i].mover, pose_in_mover(pieces_[i]));
    contacts_->hold_out(index_of(i), pieces_[i].is_out);
  }
  contacts_->exempt_anew([this](NarrowphaseContacts& contacts) { exempt_pairs(contacts); });
  found_ = {};
  ++worlds_;
}

/// Both are in the world, the one is not carried, nor would it come to carry itself.
bool SceneSimulation::may_latch(std::size_t carrier, std::size_t carried) const {
  if (pieces_[carrier].is_out || pieces_[carried].is_out) return false;
  return pieces_[carried].carrier == kNoObject && !is_carried_by(carrier, carried);
}

/// Nothing changes before all that may refuse has been asked: a program may have latched, released, brought
/// in or taken out meanwhile what the scene's action names. @return false where it is refused.
bool SceneSimulation::carry_out(const SceneAction& action, std::size_t latch_index) {
  const bool is_latch = action.kind == SceneAction::Kind::latch;
  if (is_latch && !may_latch(action.carrier, action.carried)) return false;
  const bool is_release = action.kind == SceneAction::Kind::release;
  if (is_release && pieces_[action.carried].carrier == kNoObject) return false;
  try {
    if (is_latch) latch(action.carrier, action.carried, latch_index);
    if (is_release) release(action.carried);
    if (action.kind == SceneAction::Kind::join)
      world_->join_as_they_stand(static_cast<std::uint32_t>(action.joint.joint));
    if (action.kind == SceneAction::Kind::part)
      world_->switch_joint(static_cast<std::uint32_t>(action.joint.joint), false);
    if (action.kind == SceneAction::Kind::add) {
      const SceneBody& body = scene_->bodies[action.carried];
      if (!pieces_[action.carried].is_out) go(action.carried);  // brought in by hand before
      come(action.carried, scene_->scene.objects[action.carried].X_WO, body.v_W, body.w_W);
    }
    if (action.kind == SceneAction::Kind::remove && !pieces_[action.carried].is_out) go(action.carried);
  } catch (const InputError&) {
    return false;
  }
  return true;
}

void SceneSimulation::act(const SceneAction& action) {
  ScenePlaces now;
  for (const Piece& piece : pieces_) {
    now.carriers.push_back(piece.carrier);
    now.is_out.push_back(piece.is_out ? 1 : 0);
  }
  validate_action(*scene_, action, now);
  if (!action.allowed.empty())
    throw InputError("latch: what it allows is said by the scene's own latch of the two, or its option");
  if (action.kind == SceneAction::Kind::drive) return set_drive(action.joint, action.drive);
  if (action.kind == SceneAction::Kind::set_joint) return set_joint(action.joint, action.value, action.rate);
  if (!carry_out(action, latch_between(*scene_, action.carrier, action.carried)))
    throw InputError("act: object '" + name_of(action.carried) + "': a body would have no valid inertia");
  change_contacts();
}

bool SceneSimulation::latch_now(std::size_t option) {
  if (option >= scene_->latch_options.size()) return false;
  const SceneLatchOption& wanted = scene_->latch_options[option];
  if (!may_latch(wanted.carrier, wanted.carried)) return false;
  try {
    latch(wanted.carrier, wanted.carried, first_latch_option(*scene_) + option);
  } catch (const InputError&) {
    return false;
  }
  change_contacts();
  return true;
}

bool SceneSimulation::release_now(std::size_t carried) {
  if (carried >= pieces_.size() || pieces_[carried].carrier == kNoObject) return false;
  try {
    release(carried);
  } catch (const InputError&) {
    return false;
  }
  change_contacts();
  return true;
}

void SceneSimulation::latch(std::size_t carrier, std::size_t carried, std::size_t latch) {
  const std::size_t root = pieces_[carrier].root;
  Piece &to = pieces_[root], &from = pieces_[carried];
  const Pose X_FG = compose(inverse(root_pose(root)), root_pose(carried));
  const RigidBodyState& state = world_->state(from.root_mover.index);
  if (to.body) {
    const LatchedBodies both =
        physics::latch(*to.body, world_->state(to.root_mover.index), *from.body, state, to.name);
    world_->set_body(to.root_mover.index, both.body, both.state);
    to.body = both.body;
  } else if (to.root_mover.kind == Mover::Kind::link) {
    capture_by_link(to.root_mover, *from.body, state);
  }
  world_->hold_out(from.root_mover.index);
  from.carrier = carrier;
  from.latch = latch;
  from.body.reset();
  for (Piece& piece : pieces_) {
    if (piece.root != carried) continue;
    piece.root = root;
    piece.mover = to.mover;
    piece.X_FO = compose(X_FG, piece.X_FO);
  }
}

// ---- objects that come and go

void SceneSimulation::require_free(std::size_t object, bool is_out, const char* call) const {
  if (object >= pieces_.size()) throw InputError(std::string(call) + ": no such object");
  const auto refuse = [&](const std::string& why) {
    throw InputError(std::string(call) + ": " + pieces_[object].name + ": " + why);
  };
  if (kind_of(object) != BodyKind::dynamic) refuse("is not dynamic");
  if (pieces_[object].is_out != is_out) refuse(is_out ? "is there already" : "is not there");
  if (pieces_[object].carrier != kNoObject) refuse("is carried");
  for (const Piece& piece : pieces_)
    if (piece.carrier == object) refuse("carries another object");
  if (const std::string joint = joint_that_holds(*scene_, object); !joint.empty())
    refuse("is held by joint '" + joint + "'");
}

void SceneSimulation::go(std::size_t object) {
  require_free(object, false, "remove");
  world_->hold_out(pieces_[object].root_mover.index);
  pieces_[object].is_out = true;
}

void SceneSimulation::come(std::size_t object, const Pose& X_WO, const Vector3& v_W, const Vector3& w_W) {
  require_free(object, true, "add");
  Piece& piece = pieces_[object];
  if (!is_valid_pose(X_WO)) throw InputError("add: " + piece.name + ": a bad pose");
  world_->set_body(piece.root_mover.index, *piece.body, piece.body->state(X_WO, v_W, w_W));
  piece.is_out = false;
}

void SceneSimulation::look_anew() {
  for (std::size_t i = 0; i < pieces_.size(); ++i)
    if (const auto body = dynamic_body(i)) world_->wake(*body);
  contacts_->look_anew();
}

void SceneSimulation::remove(std::size_t object) {
  go(object);
  change_contacts();
}

void SceneSimulation::add(std::size_t object, const Pose& X_WO, const Vector3& v_W, const Vector3& w_W) {
  come(object, X_WO, v_W, w_W);
  change_contacts();
}

void SceneSimulation::capture_by_link(const Mover& link, const RigidBody& body, const RigidBodyState& state) {
  Arm& arm = *arms_[link.index];
  const std::span<const double> q = world_->joint_values(link.index), qd = world_->joint_rates(link.index);
  arm.qd.assign(qd.begin(), qd.end());
  gather_capture(*arm.dynamics, {}, link.link, state, q, arm.qd, *arm.scratch);
  BodyInertia& inertia = arm.links[link.link];
  inertia = latched_link(inertia, world_->link_pose(link.index, link.link), body, state);
  arm.dynamics->set_links(arm.links);
  finish_capture(*arm.dynamics, {}, q, arm.qd, *arm.scratch);
  world_->set_rates(link.index, arm.qd);
}

/// Of a part that its root lets go: it goes on as it moved.
RigidBodyState SceneSimulation::released_state(std::size_t root, const RigidBody& part,
                                               const Pose& X_FG) const {
  const Piece& from = pieces_[root];
  if (from.body) return physics::release(*from.body, world_->state(from.root_mover.index), part, X_FG);
  const Pose X_WG = compose(root_pose(root), X_FG);
  const Vector3 centre_W = touchstone::transform(X_WG, part.inertia().centre_B);
  const Vector3 v = world_->velocity_at(from.root_mover, centre_W);
  Vector3 w = Vector3::Zero();
  if (from.root_mover.kind == Mover::Kind::body) w = world_->angular_velocity(from.root_mover.index);
  if (from.root_mover.kind == Mover::Kind::link)
    w = world_->link_angular_velocity(from.root_mover.index, from.root_mover.link);
  return part.state(X_WG, v, w);
}

void SceneSimulation::release(std::size_t carried) {
  const std::size_t root = pieces_[carried].root;
  const Pose X_FG = pieces_[carried].X_FO;
  Piece &from = pieces_[root], &to = pieces_[carried];
  // The released part and the remaining carrier have their inertias.
  const RigidBody part(inertia_of_part(carried), to.name);
  const BodyInertia rest = inertia_without(root, carried);
  std::optional<RigidBody> rest_body;
  if (from.body) rest_body.emplace(rest, from.name);
  // The part becomes the root of all that it carries.
  for (std::size_t i = 0; i < pieces_.size(); ++i) {
    if (!is_carried_by(i, carried)) continue;
    pieces_[i].root = carried;
    pieces_[i].mover = to.root_mover;
    pieces_[i].X_FO = i == carried ? Pose{} : compose(inverse(X_FG), pieces_[i].X_FO);
  }
  // The part's state is taken while the carrier is still unchanged.
  const RigidBodyState state = released_state(root, part, X_FG);
  to.carrier = kNoObject;
  to.latch = kNoLatch;
  // The carrier continues with the remaining inertia.
  if (from.body) {
    world_->set_body(from.root_mover.index, *rest_body,
                     physics::release(*from.body, world_->state(from.root_mover.index), *rest_body, {}));
    from.body = rest_body;
  } else if (from.root_mover.kind == Mover::Kind::link) {
    Arm& arm = *arms_[from.root_mover.index];
    arm.links[from.root_mover.link] = rest;
    arm.dynamics->set_links(arm.links);
    world_->set_rates(from.root_mover.index, world_->joint_rates(from.root_mover.index));
  }
  // The part is a free body again.
  to.body = part;
  world_->set_body(to.root_mover.index, part, state);
}

}  // namespace touchstone::physics
