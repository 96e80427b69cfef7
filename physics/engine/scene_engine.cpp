#include "touchstone/physics/engine/scene_engine.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/geometry/quaternion.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/contact_core/native/native.hpp"
#include "touchstone/contact_core/scene/motion.hpp"
#include "touchstone/contact_core/scene/scene_instance.hpp"
#include "touchstone/physics/scene/scene_latches.hpp"

namespace touchstone::physics {
namespace {

using Clock = std::chrono::steady_clock;

bool moves(ContactSide kind) { return kind == ContactSide::body || kind == ContactSide::link; }

/// R diag(moments) R^T w.
Vector3 spin(const Matrix3& R, const Vector3& moments, const Vector3& w_W) {
  const Vector3 w_B = R.transpose() * w_W;
  return R * Vector3(moments.cwiseProduct(w_B));
}

}  // namespace

/// Native over the scene's solids where they stand.
struct SceneEngine::Judge {
  std::unique_ptr<Broadphase> broadphase;
  std::unique_ptr<Narrowphase> narrowphase = make_native();
  std::unique_ptr<Narrowphase::Workspace> workspace;
  std::vector<Pose> poses;
  std::vector<std::uint32_t> moved;
  std::vector<SolidPair> block = std::vector<SolidPair>(256);
  std::vector<PairStatus> status = std::vector<PairStatus>(256);
  std::vector<PairGeometry> geometry = std::vector<PairGeometry>(256);

  explicit Judge(const EngineScene& bodies) {
    BackendRegistry registry;
    register_core(registry);
    broadphase = registry.make_broadphase("native");
    std::vector<const HexahedronTree*> trees;
    std::vector<Hexahedron> solids;
    std::vector<std::uint8_t> is_static;
    const DynamicScene& scene = bodies.scene();
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
      trees.push_back(&scene.scene.objects[i].tree);
      is_static.push_back(scene.bodies[i].kind == BodyKind::fixed ? 1 : 0);
      if (is_static.back() == 0) moved.push_back(static_cast<std::uint32_t>(i));
    }
    for (const EngineScene::Solid& solid : bodies.solids()) solids.push_back(*solid.solid);
    BroadphaseInput input;
    input.trees = trees;
    input.is_static = is_static;
    broadphase->build(input);
    narrowphase->build(solids);
    workspace = narrowphase->make_workspace();
    poses.resize(solids.size());
  }

  template <class IsChecked>
  double worst(const IsChecked& is_checked) {
    broadphase->update(poses, moved);
    double deepest = 0.0;
    for (PairCursor cursor; !cursor.done;) {
      std::size_t count = broadphase->find_pairs(cursor, block), kept = 0;
      for (std::size_t i = 0; i < count; ++i)
        if (is_checked(block[i].a, block[i].b)) block[kept++] = block[i];
      const Query query{QueryKind::distance, 0.0, kMaxManifoldPoints, 0.0};
      narrowphase->evaluate({std::span(block).first(kept), poses, query, {}},
                            {std::span(status).first(kept), std::span(geometry).first(kept), {}}, *workspace);
      for (std::size_t i = 0; i < kept; ++i)
        if (status[i] == PairStatus::overlapping) deepest = std::max(deepest, -geometry[i].separation);
    }
    return deepest;
  }
};

void SceneEngine::JudgeDeleter::operator()(Judge* judge) const { delete judge; }

SceneEngine::SceneEngine(const DynamicScene& scene)
    : bodies_(scene),
      states_(bodies_.bodies().size()),
      targets_(bodies_.bodies().size()),
      is_out_(bodies_.bodies().size(), 0),
      pushes_(bodies_.bodies().size()),
      joint_states_(bodies_.joints().size() + bodies_.body_joints().size()),
      drives_since_(joint_states_.size(), 0.0),
      root_(bodies_.bodies().size()) {
  for (std::size_t b = 0; b < root_.size(); ++b) {
    const EngineScene::Body& body = bodies_.bodies()[b];
    states_[b] = targets_[b] = {body.X_WB, body.v_W, body.w_W};
    root_[b] = b;
  }
  for (std::size_t j = 0; j < bodies_.joints().size(); ++j) {
    drives_.push_back(bodies_.joints()[j].source->drive);
    joint_states_[j] = {bodies_.joints()[j].source->value, bodies_.joints()[j].source->rate, 0.0};
  }
  for (const EngineScene::BodyJoint& joint : bodies_.body_joints()) drives_.push_back(joint.source->drive);
}

void SceneEngine::start() {
  const Scene& scene = this->scene().scene;
  for (const SceneLatch& each : scene.latches)
    hold(bodies_.body_of(find_object(scene, each.carrier)), bodies_.body_of(find_object(scene, each.carried)),
         each.allowed);
  const std::vector<std::uint8_t> absent = absent_at_start(this->scene());
  for (std::size_t object = 0; object < absent.size(); ++object)
    if (absent[object] != 0) take_out(object);
  apply_drives(true);
}

void SceneEngine::keep_start() { start_ = snapshot(); }

void SceneEngine::carry_out(const SceneAction& action) {
  switch (action.kind) {
    // Joints are driven from now on.
    case SceneAction::Kind::drive: {
      const std::size_t joint = joint_index(action.joint);
      drives_[joint] = action.drive;
      drives_since_[joint] = time();
      break;
    }
    // Bodies are latched, released, joined and parted.
    case SceneAction::Kind::latch:
      hold(bodies_.body_of(action.carrier), bodies_.body_of(action.carried), action.allowed);
      break;
    case SceneAction::Kind::release:
      let_go(bodies_.body_of(action.carried));
      break;
    case SceneAction::Kind::join:
    case SceneAction::Kind::part:
      switch_joint(action.joint.joint, action.kind == SceneAction::Kind::join);
      break;
    // Bodies come and go.
    case SceneAction::Kind::add: {
      const SceneBody& body = scene().bodies[action.carried];
      if (has(action.carried)) take_out(action.carried);  // brought in by hand before
      put_in(action.carried, scene().scene.objects[action.carried].X_WO, body.v_W, body.w_W);
      break;
    }
    case SceneAction::Kind::remove:
      if (has(action.carried)) take_out(action.carried);
      break;
    // Joints are put at values.
    case SceneAction::Kind::set_joint:
      set_joint(joint_index(action.joint), action.value, action.rate);
      break;
  }
}

/// A latch is one that the engine was set up for: of the scene, of its actions, or one of its options.
void SceneEngine::take_action(const SceneAction& action) {
  refuse(action);
  SceneAction now = action;
  if (action.kind == SceneAction::Kind::latch) {
    if (!action.allowed.empty())
      throw InputError("latch: what it allows is said by the scene's own latch of the two, or its option");
    const std::size_t latch = latch_between(scene(), action.carrier, action.carried);
    if (latch == kNoLatch)
      throw InputError(
          "unsupported: a latch that is neither a latch option of the scene nor one of its latches (" +
          object_name(scene(), action.carried) + ")");
    const std::span<const ExemptPair> allowed = allowed_by(scene(), latch);
    now.allowed.assign(allowed.begin(), allowed.end());
  }
  carry_out(now);
  apply_drives(true);
}

std::size_t SceneEngine::carrier_of(std::size_t object) const {
  const std::size_t body = bodies_.body_of(object);
  for (const Held& each : held_)
    if (each.carried == body) return bodies_.bodies()[each.carrier].objects[0];
  return kNoObject;
}

bool SceneEngine::is_carried(std::size_t body) const {
  return std::any_of(held_.begin(), held_.end(), [&](const Held& each) { return each.carried == body; });
}

/// What a program has latched, released, brought in or taken out leaves no place for an action of the scene.
/// @return the reason, or nothing
std::string SceneEngine::why_not(const SceneAction& action) const {
  using Kind = SceneAction::Kind;
  const auto reason = [&](const char* call, std::size_t object, const char* why) {
    return std::string(call) + ": " + object_name(scene(), object) + ": " + why;
  };
  if (action.kind == Kind::latch) {
    const std::size_t carrier = bodies_.body_of(action.carrier), carried = bodies_.body_of(action.carried);
    for (const std::size_t object : {action.carrier, action.carried})
      if (!has(object)) return reason("latch", object, "is not in the world");
    if (is_carried(carried)) return reason("latch", action.carried, "is carried already");
    if (root_[carrier] == carried) return reason("latch", action.carried, "carries what is to carry it");
  }
  if (action.kind == Kind::release && !is_carried(bodies_.body_of(action.carried)))
    return reason("release", action.carried, "is not carried");
  if (action.kind == Kind::add || action.kind == Kind::remove) {
    const std::size_t body = bodies_.body_of(action.carried);
    const char* const call = action.kind == Kind::add ? "add" : "remove";
    for (const Held& each : held_)
      if (each.carrier == body || each.carried == body)
        return reason(call, action.carried, "is carried, or carries another object");
  }
  return {};
}

void SceneEngine::begin_step() {
  const DynamicScene& scene = this->scene();
  refused_.clear();
  bool any = false;
  for (; next_action_ < scene.actions.size(); ++next_action_) {
    const SceneAction& action = scene.actions[next_action_];
    if (static_cast<double>(steps_) < action.time / scene.step * (1.0 - 0x1p-40)) break;
    refused_ = why_not(action);
    if (!refused_.empty()) break;
    carry_out(action);
    any = true;
  }
  apply_drives(any);
  aim(static_cast<double>(steps_ + 1) * scene.step);
}

/// Those whose torque grows; or all.
void SceneEngine::apply_drives(bool all) {
  for (std::size_t j = 0; j < drives_.size(); ++j) {
    if (!all && drives_[j].ramp == 0.0) continue;
    JointDrive drive = drives_[j].drive;
    drive.limit = std::min(drive.limit, effort_of(j));
    drive.torque += drives_[j].ramp * ((time() + 0.5 * step_size()) - drives_since_[j]);
    if (drive.mode == JointDrive::Mode::torque)
      drive.torque = std::clamp(drive.torque, -drive.limit, drive.limit);
    set_drive(j, drive);
  }
}

/// Where kinematic bodies are to be at `time`, and how fast they get there.
void SceneEngine::aim(double time) {
  for (std::size_t b = 0; b < targets_.size(); ++b) {
    const EngineScene::Body& body = bodies_.bodies()[b];
    if (body.kind != ContactSide::kinematic) continue;
    const SceneObject& object = scene().scene.objects[body.objects[0]];
    const Pose& now = states_[b].X_WB;
    State& target = targets_[b];
    target.X_WB = pose_at(object.motion, object.X_WO, time);
    target.v_W = (target.X_WB.p - now.p) / step_size();
    const AxisAngle turn = axis_angle_of(quaternion_of(target.X_WB.R) * conjugate(quaternion_of(now.R)));
    target.w_W = (turn.angle / step_size()) * turn.axis;
  }
}

EngineStep SceneEngine::step() {
  EngineStep out;
  out.failure = refused_;
  if (!refused_.empty()) return out;
  const Clock::time_point start = Clock::now();
  apply_pushes();
  advance(out);
  out.total_us = std::chrono::duration<double, std::micro>(Clock::now() - start).count();
  if (!out.failure.empty()) return out;
  read();
  for (std::size_t b = 0; b < states_.size(); ++b) {
    const State& state = states_[b];
    if (touchstone::is_finite(state.X_WB) && touchstone::is_finite(state.v_W) &&
        touchstone::is_finite(state.w_W))
      continue;
    out.failure = "body: " + bodies_.bodies()[b].name + ": its state is not finite";
    return out;
  }
  ++steps_;
  return out;
}

/// Kept until the step: actions in between may rebuild the body that an engine would have added it to.
void SceneEngine::take_push(std::size_t object, const Vector3& force_W, const Vector3& p_W,
                            const Vector3& moment_W) {
  const std::size_t body = bodies_.body_of(object);
  Push& push = pushes_[body];
  push.is_any = true;
  push.force_W += force_W;
  push.moment_W += moment_W + cross(Vector3(p_W - states_[body].X_WB.p), force_W);
}

void SceneEngine::apply_pushes() {
  for (std::size_t b = 0; b < pushes_.size(); ++b) {
    if (!pushes_[b].is_any) continue;
    apply(b, pushes_[b].force_W, pushes_[b].moment_W);
    pushes_[b] = {};
  }
}

void SceneEngine::read() {
  for (std::size_t b = 0; b < states_.size(); ++b) {
    const ContactSide kind = bodies_.bodies()[b].kind;
    if (is_out(b)) continue;
    if (moves(kind)) states_[b] = read_state(b);
    if (kind == ContactSide::kinematic) states_[b] = targets_[b];
  }
  for (std::size_t j = 0; j < joint_states_.size(); ++j) joint_states_[j] = read_joint(j);
}

// ---- objects that come and go

void SceneEngine::take_out(std::size_t object) {
  const std::size_t body = bodies_.body_of(object);
  for (const Held& each : held_)
    if (each.carrier == body || each.carried == body)
      throw InputError("remove: " + bodies_.bodies()[body].name + ": is carried, or carries another object");
  take_body(body);
  is_out_[body] = 1;
  states_[body].v_W = states_[body].w_W = Vector3::Zero();
  pushes_[body] = {};
}

void SceneEngine::put_in(std::size_t object, const Pose& X_WO, const Vector3& v_W, const Vector3& w_W) {
  const std::size_t body = bodies_.body_of(object);
  const Pose& X_BO = bodies_.X_BO(object);
  const bool is_at = X_BO.R == Matrix3::Identity() && X_BO.p == Vector3::Zero();
  states_[body] = {is_at ? X_WO : compose(X_WO, inverse(X_BO)), v_W, w_W};
  put_body(body, states_[body]);
  is_out_[body] = 0;
}

// ---- back in time

struct SceneEngine::Snapshot final : EngineSnapshot {
  std::shared_ptr<const int> of;
  Run run;
  std::unique_ptr<EngineSnapshot> engines;

  Snapshot(const SceneEngine& engine, Run kept, std::unique_ptr<EngineSnapshot> saved)
      : of(engine.id_), run(std::move(kept)), engines(std::move(saved)) {}
};

std::unique_ptr<EngineSnapshot> SceneEngine::snapshot() const {
  return std::make_unique<Snapshot>(*this,
                                    Run{states_, targets_, is_out_, joint_states_, drives_, drives_since_,
                                        held_, root_, next_action_, steps_},
                                    save());
}

void SceneEngine::restore(const EngineSnapshot& snapshot) {
  const auto* const ours = dynamic_cast<const Snapshot*>(&snapshot);
  if (ours == nullptr || ours->of != id_) throw InputError("restore: the snapshot is of another engine");
  const Run& run = ours->run;
  states_ = run.states, targets_ = run.targets, is_out_ = run.is_out;
  joint_states_ = run.joint_states;
  drives_ = run.drives, drives_since_ = run.drives_since;
  held_ = run.held, root_ = run.root;
  next_action_ = run.next_action;
  steps_ = run.steps;
  refused_.clear();
  std::fill(pushes_.begin(), pushes_.end(), Push{});
  load(*ours->engines);
  apply_drives(true);
}

void SceneEngine::reset() { restore(*start_); }

// ---- latches

void SceneEngine::hold(std::size_t carrier, std::size_t carried, std::span<const ExemptPair> allowed) {
  Held held{carrier, carried, {}};
  for (const ExemptPair& pair : allowed)
    for (const SolidIndex a : find_solids(scene().scene, pair.first))
      for (const SolidIndex b : find_solids(scene().scene, pair.second))
        held.allowed.push_back({std::min(a, b), std::max(a, b)});
  std::sort(held.allowed.begin(), held.allowed.end());
  held_.push_back(std::move(held));
  find_roots();
  latch(carrier, carried);
}

void SceneEngine::let_go(std::size_t carried) {
  std::erase_if(held_, [&](const Held& each) { return each.carried == carried; });
  find_roots();
  release(carried);
}

void SceneEngine::find_roots() {
  for (std::size_t b = 0; b < root_.size(); ++b) root_[b] = b;
  for (std::size_t pass = 0; pass < held_.size(); ++pass)
    for (const Held& each : held_)
      for (std::size_t& root : root_)
        if (root == each.carried) root = root_[each.carrier];
}

bool SceneEngine::is_checked(SolidIndex a, SolidIndex b) const {
  if (!bodies_.is_checked(a, b)) return false;
  if (is_out(bodies_.solids()[a].body) || is_out(bodies_.solids()[b].body)) return false;
  if (held_.empty()) return true;
  const std::size_t root_a = root_[bodies_.solids()[a].body], root_b = root_[bodies_.solids()[b].body];
  if (root_a == root_b || (!moves(bodies_.bodies()[root_a].kind) && !moves(bodies_.bodies()[root_b].kind)))
    return false;
  const SolidPair pair{std::min(a, b), std::max(a, b)};
  return std::none_of(held_.begin(), held_.end(), [&](const Held& each) {
    return std::binary_search(each.allowed.begin(), each.allowed.end(), pair);
  });
}

// ---- state

Vector3 SceneEngine::commanded_velocity(std::size_t body, const Vector3& p_W) const {
  if (bodies_.bodies()[body].kind != ContactSide::kinematic) return Vector3::Zero();
  const State& to = targets_[body];
  return to.v_W + cross(to.w_W, p_W - to.X_WB.p);
}

void SceneEngine::finish_contact(EngineContact& contact) const {
  const std::size_t a = bodies_.solids()[contact.solids.a].body, b = bodies_.solids()[contact.solids.b].body;
  contact.side_a = bodies_.bodies()[root_[a]].kind;
  contact.side_b = bodies_.bodies()[root_[b]].kind;
  contact.kinematic_v_A_W = commanded_velocity(root_[a], contact.p_W);
  contact.kinematic_v_B_W = commanded_velocity(root_[b], contact.p_W);
  contact.impact_W = Vector3::Constant(kNaN);
}

Pose SceneEngine::object_pose(std::size_t object) const {
  const std::size_t body = bodies_.body_of(object);
  const Pose& X_BO = bodies_.X_BO(object);
  const bool is_at = X_BO.R == Matrix3::Identity() && X_BO.p == Vector3::Zero();
  return is_at ? states_[body].X_WB : compose(states_[body].X_WB, X_BO);
}

std::optional<Vector3> SceneEngine::velocity(std::size_t object) const {
  const std::size_t root = root_[bodies_.body_of(object)];
  if (bodies_.bodies()[root].kind != ContactSide::body || is_out(root)) return std::nullopt;
  Vector3 momentum = Vector3::Zero();
  double mass = 0.0;
  for (std::size_t b = 0; b < root_.size(); ++b) {
    if (root_[b] != root) continue;
    momentum += bodies_.bodies()[b].mass * states_[b].v_W;
    mass += bodies_.bodies()[b].mass;
  }
  return Vector3(momentum / mass);
}

std::optional<Vector3> SceneEngine::angular_velocity(std::size_t object) const {
  const std::size_t root = root_[bodies_.body_of(object)];
  if (bodies_.bodies()[root].kind != ContactSide::body || is_out(root)) return std::nullopt;
  return states_[root].w_W;
}

std::size_t SceneEngine::joint_index(const JointAddress& address) const {
  if (address.is_of_bodies()) return bodies_.joints().size() + address.joint;
  for (std::size_t j = 0; j < bodies_.joints().size(); ++j) {
    const JointAddress& each = bodies_.joints()[j].address;
    if (each.mechanism == address.mechanism && each.joint == address.joint) return j;
  }
  return EngineScene::kNone;
}

double SceneEngine::effort_of(std::size_t joint) const {
  const std::size_t of_mechanisms = bodies_.joints().size();
  return joint < of_mechanisms ? bodies_.joints()[joint].source->effort
                               : bodies_.body_joints()[joint - of_mechanisms].source->effort;
}

double SceneEngine::joint_value(const JointAddress& joint) const {
  const std::size_t j = joint_index(joint);
  return j == EngineScene::kNone ? 0.0 : joint_states_[j].value;
}

double SceneEngine::joint_rate(const JointAddress& joint) const {
  const std::size_t j = joint_index(joint);
  return j == EngineScene::kNone ? 0.0 : joint_states_[j].rate;
}

double SceneEngine::joint_torque(const JointAddress& joint) const {
  const std::size_t j = joint_index(joint);
  return j == EngineScene::kNone ? 0.0 : joint_states_[j].torque;
}

Vector3 SceneEngine::linear_momentum() const {
  Vector3 sum = Vector3::Zero();
  for (std::size_t b = 0; b < states_.size(); ++b)
    if (moves(bodies_.bodies()[root_[b]].kind)) sum += bodies_.bodies()[b].mass * states_[b].v_W;
  return sum;
}

Vector3 SceneEngine::angular_momentum() const {
  Vector3 sum = Vector3::Zero();
  for (std::size_t b = 0; b < states_.size(); ++b) {
    const EngineScene::Body& body = bodies_.bodies()[b];
    if (!moves(bodies_.bodies()[root_[b]].kind)) continue;
    sum += body.mass * cross(states_[b].X_WB.p, states_[b].v_W) +
           spin(states_[b].X_WB.R, body.moments, states_[b].w_W);
  }
  return sum;
}

double SceneEngine::energy() const {
  double sum = 0.0;
  for (std::size_t b = 0; b < states_.size(); ++b) {
    const EngineScene::Body& body = bodies_.bodies()[b];
    const State& state = states_[b];
    if (is_out(b) || !moves(bodies_.bodies()[root_[b]].kind)) continue;
    sum += 0.5 * (body.mass * dot(state.v_W, state.v_W) +
                  dot(state.w_W, spin(state.X_WB.R, body.moments, state.w_W))) -
           body.mass * dot(scene().gravity_W, state.X_WB.p);
  }
  return sum;
}

Vector3 SceneEngine::body_momentum() const {
  Vector3 sum = Vector3::Zero();
  for (std::size_t b = 0; b < states_.size(); ++b)
    if (bodies_.bodies()[root_[b]].kind == ContactSide::body)
      sum += bodies_.bodies()[b].mass * states_[b].v_W;
  return sum;
}

double SceneEngine::body_mass() const {
  double sum = 0.0;
  for (std::size_t b = 0; b < states_.size(); ++b)
    if (bodies_.bodies()[root_[b]].kind == ContactSide::body && !is_out(b)) sum += bodies_.bodies()[b].mass;
  return sum;
}

double SceneEngine::worst_depth() {
  if (!judge_) judge_.reset(new Judge(bodies_));
  for (std::size_t s = 0; s < judge_->poses.size(); ++s) {
    const EngineScene::Solid& solid = bodies_.solids()[s];
    judge_->poses[s] = compose(states_[solid.body].X_WB, solid.X_BS);
  }
  return judge_->worst([&](SolidIndex a, SolidIndex b) { return is_checked(a, b); });
}

// ---- defaults of engines without arms and latches

SceneEngine::JointState SceneEngine::read_joint(std::size_t) const { return {}; }
void SceneEngine::set_drive(std::size_t, const JointDrive&) {}
void SceneEngine::set_joint(std::size_t, double, double) {}
void SceneEngine::refuse(const SceneAction&) const {}
void SceneEngine::latch(std::size_t, std::size_t) {}
void SceneEngine::release(std::size_t) {}
void SceneEngine::switch_joint(std::size_t, bool) {}

}  // namespace touchstone::physics
