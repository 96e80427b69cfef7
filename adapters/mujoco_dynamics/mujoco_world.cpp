#include "touchstone/adapters/mujoco_dynamics/mujoco_world.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "touchstone/adapters/mujoco/engine.hpp"
#include "touchstone/adapters/mujoco/xml_model.hpp"
#include "touchstone/adapters/mujoco_dynamics/mujoco_joints.hpp"
#include "touchstone/adapters/mujoco_dynamics/mujoco_model.hpp"
#include "touchstone/adapters/mujoco_plugin/mujoco_plugin.hpp"
#include "touchstone/contact_core/geometry/quaternion.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/physics/engine/scene_engine.hpp"

namespace touchstone::physics::mujoco_dynamics {
namespace {

Vector3 vector_of(const mjtNum* v) { return {v[0], v[1], v[2]}; }

Matrix3 matrix_of(const mjtNum* R) {
  Matrix3 out;
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) out(i, k) = R[3 * i + k];
  return out;
}

/// Overlaps from here on are taken back at a capped speed where a scene asks for it [m]: as in DynamicsWorld.
constexpr double kMostDepth = 1e-4;

class MujocoEngine final : public SceneEngine {
 public:
  MujocoEngine(const DynamicScene& scene, const WorldCheck& check) : SceneEngine(scene), check_(check) {
    mujoco::require_version();
    model_ = mujoco::load_model(model_text(bodies()));
    data_.reset(mj_makeData(model_.get()));
    if (!data_) throw InputError("engine 'mujoco': no memory for its tables");
    for (std::size_t b = 0; b < bodies().bodies().size(); ++b) place(b);
    for (std::size_t s = 0; s < bodies().solids().size(); ++s) {
      const int geom = mj_name2id(model_.get(), mjOBJ_GEOM, ("s" + std::to_string(s)).c_str());
      solid_of_.resize(std::max(solid_of_.size(), static_cast<std::size_t>(geom) + 1));
      solid_of_[static_cast<std::size_t>(geom)] = static_cast<SolidIndex>(s);
      geom_of_.push_back(geom);
    }
    for (std::size_t j = 0; j < bodies().joints().size(); ++j) add_joint(j);
    add_body_joints();
    start();
    refuse_overlap();
    find_links();
    keep_start();
  }

  EngineReturn after_restore() const override { return EngineReturn::same_bits; }

  void list_contacts(std::vector<EngineContact>& contacts) const override {
    contacts.clear();
    for (int i = 0; i < data_->ncon; ++i) contacts.push_back(contact(i));
  }

 protected:
  void apply(std::size_t body, const Vector3& force_W, const Vector3& moment_W) override {
    mjtNum* const on_body = data_->xfrc_applied + 6 * static_cast<std::size_t>(ids_[body]);
    for (int i = 0; i < 3; ++i) on_body[i] += force_W[i], on_body[3 + i] += moment_W[i];
    is_pushed_ = true;
  }

  void advance(EngineStep& step) override {
    // MuJoCo takes drives and torques as forces of the step.
    for (const Joint& joint : joints_) data_->qfrc_applied[joint.dof] = joint.drive.torque;
    apply_body_torques();
    // Our check replaces the engine's during the step alone.
    try {
      std::optional<MujocoOverride> ours;
      if (check_.is_ours) ours.emplace(MujocoOverride::Options{.inside = check_.inside});
      mj_step(model_.get(), data_.get());
    } catch (const InputError& error) {  // a program's own override stands there
      step.failure = error.what();
      return;
    }
    // Forces end with the step, and bodies that are out stay where they are put.
    if (is_pushed_) mju_zero(data_->xfrc_applied, 6 * model_->nbody);  // MuJoCo keeps it
    is_pushed_ = false;
    for (std::size_t b = 0; b < first_q_.size(); ++b)
      if (is_out(b)) set_free(b, state(b));  // it fell
    // MuJoCo goes on after a warning, but its state is no result any more.
    step.contacts = static_cast<std::size_t>(data_->ncon);
    constexpr std::array<std::pair<mjtWarning, const char*>, 5> kWarnings{
        {{mjWARN_CONTACTFULL, "more contacts than there is room for"},
         {mjWARN_CNSTRFULL, "more constraints than there is room for"},
         {mjWARN_BADQPOS, "a position that is none"},
         {mjWARN_BADQVEL, "a velocity that is none"},
         {mjWARN_BADQACC, "an acceleration that is none"}}};
    for (const auto& [warning, text] : kWarnings)
      if (data_->warning[warning].number > 0) step.failure = std::string("MuJoCo: ") + text;
    // Links and joints follow from the new state.
    if (step.failure.empty()) find_links();
    for (BodyJoint& joint : body_joints_) joint.read(side(joint.child()), side(joint.parent()));
  }

  State read_state(std::size_t body) const override {
    State out;
    if (const int q = first_q_[body]; q >= 0) {
      const mjtNum* const from = data_->qpos + q;
      const mjtNum* const v = data_->qvel + first_v_[body];
      out.X_WB.p = vector_of(from);
      out.X_WB.R = rotation_matrix({from[3], vector_of(from + 4)});
      out.v_W = vector_of(v);
      out.w_W = rotate(out.X_WB.R, vector_of(v + 3));  // MuJoCo has it in the body's axes
      return out;
    }
    const std::size_t id = static_cast<std::size_t>(ids_[body]);
    out.X_WB = {matrix_of(data_->xmat + 9 * id), vector_of(data_->xpos + 3 * id)};
    mjtNum velocity[6];
    mj_objectVelocity(model_.get(), data_.get(), mjOBJ_BODY, ids_[body], velocity, 0);
    out.w_W = vector_of(velocity);
    out.v_W = vector_of(velocity + 3);
    return out;
  }

  JointState read_joint(std::size_t index) const override {
    if (index >= joints_.size()) {
      const BodyJoint& of_bodies = body_joints_[index - joints_.size()];
      return {of_bodies.value(), of_bodies.rate(), of_bodies.torque()};
    }
    const Joint& joint = joints_[index];
    double torque = joint.drive.torque;
    for (int row = 0; row < data_->nefc; ++row)
      if (data_->efc_type[row] == mjCNSTR_FRICTION_DOF && data_->efc_id[row] == joint.dof)
        torque = data_->efc_force[row];
    return {data_->qpos[joint.q], data_->qvel[joint.dof], torque};
  }

  void set_drive(std::size_t index, const JointDrive& drive) override {
    if (index >= joints_.size()) return body_joints_[index - joints_.size()].set_torque(drive.torque);
    Joint& joint = joints_[index];
    joint.drive = drive;
    const bool is_brake = drive.mode == JointDrive::Mode::brake;
    if (is_brake) joint.drive.torque = 0.0;
    model_->dof_frictionloss[joint.dof] = is_brake ? drive.limit : 0.0;
  }

  void set_joint(std::size_t index, double value, double rate) override {
    data_->qpos[joints_[index].q] = value;
    data_->qvel[joints_[index].dof] = rate;
    find_links();
  }

  void switch_joint(std::size_t index, bool is_on) override {
    BodyJoint& joint = body_joints_[index];
    joint.switch_to(is_on, *model_, *data_, side(joint.child()), side(joint.parent()));
  }

  /// MuJoCo's bodies stay: what is out meets nothing, and is put back after each step.
  void take_body(std::size_t body) override {
    set_meeting(body, false);
    set_free(body, {read_state(body).X_WB, Vector3::Zero(), Vector3::Zero()});
  }
  void put_body(std::size_t body, const State& at) override {
    set_meeting(body, true);
    set_free(body, at);
  }

  /// All of mjData: positions, velocities, time, and what the solver starts from.
  struct Saved final : EngineSnapshot {
    explicit Saved(mujoco::DataHandle of) : data(std::move(of)) {}
    mujoco::DataHandle data;
    std::vector<BodyJoint::State> joints;
  };
  std::unique_ptr<EngineSnapshot> save() const override {
    mujoco::DataHandle copy(mj_copyData(nullptr, model_.get(), data_.get()));
    if (!copy) throw InputError("engine 'mujoco': no memory for a snapshot");
    auto out = std::make_unique<Saved>(std::move(copy));
    for (const BodyJoint& joint : body_joints_) out->joints.push_back(joint.state());
    return out;
  }
  void load(const EngineSnapshot& saved) override {
    const auto& from = static_cast<const Saved&>(saved);
    mj_copyData(data_.get(), model_.get(), from.data.get());
    for (std::size_t j = 0; j < body_joints_.size(); ++j)
      body_joints_[j].set_state(from.joints[j], *model_, *data_);
    if (is_pushed_) mju_zero(data_->xfrc_applied, 6 * model_->nbody);
    is_pushed_ = false;
    for (std::size_t b = 0; b < first_q_.size(); ++b)
      if (first_q_[b] >= 0) set_meeting(b, !is_out(b));
  }

 private:
  struct Joint {
    int q, dof;
    JointDrive drive;
  };

  /// Where the body is in MuJoCo's vectors, and its velocity at the start.
  void place(std::size_t index) {
    const EngineScene::Body& body = bodies().bodies()[index];
    ids_.push_back(mj_name2id(model_.get(), mjOBJ_BODY, ("b" + std::to_string(index)).c_str()));
    first_q_.push_back(-1);
    first_v_.push_back(-1);
    if (body.kind != ContactSide::body) return;
    const int joint = model_->body_jntadr[ids_.back()];
    first_q_.back() = model_->jnt_qposadr[joint];
    first_v_.back() = model_->jnt_dofadr[joint];
    const Vector3 w_B = rotate(Matrix3(body.X_WB.R.transpose()), body.w_W);
    for (int i = 0; i < 3; ++i) {
      data_->qvel[first_v_.back() + i] = body.v_W[i];
      data_->qvel[first_v_.back() + 3 + i] = w_B[i];
    }
  }

  /// Those that do not hold from the start wait for their action.
  void add_body_joints() {
    for (const SceneAction& action : scene().actions) refuse(action);
    for (std::size_t j = 0; j < bodies().body_joints().size(); ++j) {
      body_joints_.emplace_back(bodies(), j, *model_);
      if (!bodies().body_joints()[j].source->is_on) switch_joint(j, false);
    }
  }

  BodyJoint::Side side(std::size_t body) const {
    if (body == EngineScene::kNone) return {};
    const State now = read_state(body);
    return {now.X_WB, now.w_W};
  }

  /// Both ways: the drive's on the child.
  void apply_body_torques() {
    for (const BodyJoint& joint : body_joints_) {
      if (joint.torque() == 0.0) continue;
      const Vector3 moment = joint.torque() * joint.axis_W(side(joint.parent()));
      apply(joint.child(), Vector3::Zero(), moment);
      if (joint.parent() != EngineScene::kNone) apply(joint.parent(), Vector3::Zero(), -moment);
    }
  }

  /// Its soft contacts throw apart what starts deep: 5 cm with 0.5 m/s.
  void refuse_overlap() {
    if (scene().push_out == 0.0) return;
    if (const double depth = worst_depth(); depth > kMostDepth)
      throw InputError(
          "engine 'mujoco': unsupported: an overlap at the start that parts at a capped speed (" +
          std::to_string(depth) + " m; push_out)");
  }

  void set_meeting(std::size_t body, bool meets) {
    for (const SolidIndex solid : bodies().bodies()[body].solids) {
      const auto geom = static_cast<std::size_t>(geom_of_[solid]);
      model_->geom_contype[geom] = model_->geom_conaffinity[geom] = meets ? 1 : 0;
    }
  }

  /// A free body's place in MuJoCo's vectors; what its solver remembers of it is forgotten.
  void set_free(std::size_t body, const State& at) {
    mjtNum* const q = data_->qpos + first_q_[body];
    mjtNum* const v = data_->qvel + first_v_[body];
    const Quaternion turn = quaternion_of(at.X_WB.R);
    const Vector3 w_B = rotate(Matrix3(at.X_WB.R.transpose()), at.w_W);
    q[3] = turn.w;
    for (int i = 0; i < 3; ++i) {
      q[i] = at.X_WB.p[i], q[4 + i] = turn.v[i];
      v[i] = at.v_W[i], v[3 + i] = w_B[i];
    }
    mju_zero(data_->qacc_warmstart + first_v_[body], 6);
  }

  void add_joint(std::size_t index) {
    const EngineScene::Joint& source = bodies().joints()[index];
    const int joint = mj_name2id(model_.get(), mjOBJ_JOINT, ("j" + std::to_string(index)).c_str());
    joints_.push_back({model_->jnt_qposadr[joint], model_->jnt_dofadr[joint], {}});
    data_->qvel[joints_.back().dof] = source.source->rate;
    require_limit(source.address, source.source->drive.drive);
  }

  void require_limit(const JointAddress& joint, const JointDrive& drive) const {
    const SceneJoint& source = scene().mechanisms[joint.mechanism].joints[joint.joint];
    if (drive.mode == JointDrive::Mode::brake && !std::isfinite(std::min(drive.limit, source.effort)))
      throw InputError("engine 'mujoco': unsupported: a brake without a limit (joint '" +
                       name_of(scene(), joint) + "')");
  }

  void refuse(const SceneAction& action) const override {
    if (action.kind != SceneAction::Kind::drive) return;
    if (!action.joint.is_of_bodies()) return require_limit(action.joint, action.drive.drive);
    if (action.drive.drive.mode != JointDrive::Mode::torque)
      throw InputError("engine 'mujoco': unsupported: motors of joints between bodies (joint '" +
                       name_of(scene(), action.joint) + "')");
  }

  /// Where links are and how they move now: mj_step() leaves that of its start.
  void find_links() {
    if (joints_.empty()) return;
    mj_kinematics(model_.get(), data_.get());
    mj_comPos(model_.get(), data_.get());
    mj_comVel(model_.get(), data_.get());
  }

  EngineContact contact(int index) const {
    const mjContact& from = data_->contact[index];
    EngineContact out;
    out.solids = {solid_of_[static_cast<std::size_t>(from.geom1)],
                  solid_of_[static_cast<std::size_t>(from.geom2)]};
    out.separation = from.dist;
    out.status = from.dist > 0.0 ? PairStatus::separated : PairStatus::overlapping;
    out.p_W = vector_of(from.pos);
    out.n_AB_W = vector_of(from.frame);
    mjtNum force[6];
    mj_contactForce(model_.get(), data_.get(), index, force);
    out.force_W = Vector3::Zero();
    for (int axis = 0; axis < 3; ++axis) out.force_W += force[axis] * vector_of(from.frame + 3 * axis);
    finish_contact(out);
    return out;
  }

  WorldCheck check_;
  bool is_pushed_ = false;
  mujoco::ModelHandle model_;
  mujoco::DataHandle data_;
  std::vector<int> ids_, first_q_, first_v_;  // by body
  std::vector<SolidIndex> solid_of_;          // by geom
  std::vector<int> geom_of_;                  // by solid
  std::vector<Joint> joints_;
  std::vector<BodyJoint> body_joints_;
};

}  // namespace

std::unique_ptr<DynamicsEngine> make_world(const DynamicScene& scene, const WorldCheck& check) {
  return std::make_unique<MujocoEngine>(scene, check);
}

}  // namespace touchstone::physics::mujoco_dynamics
