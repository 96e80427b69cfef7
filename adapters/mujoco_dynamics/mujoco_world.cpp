#include "touchstone/adapters/mujoco_dynamics/mujoco_world.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "touchstone/adapters/mujoco/engine.hpp"
#include "touchstone/adapters/mujoco/xml_model.hpp"
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

class MujocoEngine final : public SceneEngine {
 public:
  MujocoEngine(const DynamicScene& scene, bool by_native) : SceneEngine(scene), by_native_(by_native) {
    mujoco::require_version();
    model_ = mujoco::load_model(model_text(bodies()));
    data_.reset(mj_makeData(model_.get()));
    if (!data_) throw InputError("engine 'mujoco': no memory for its tables");
    for (std::size_t b = 0; b < bodies().bodies().size(); ++b) place(b);
    for (std::size_t s = 0; s < bodies().solids().size(); ++s) {
      const int geom = mj_name2id(model_.get(), mjOBJ_GEOM, ("s" + std::to_string(s)).c_str());
      solid_of_.resize(std::max(solid_of_.size(), static_cast<std::size_t>(geom) + 1));
      solid_of_[static_cast<std::size_t>(geom)] = static_cast<SolidIndex>(s);
    }
    for (std::size_t j = 0; j < bodies().joints().size(); ++j) add_joint(j);
    start();
    find_links();
  }

  void list_contacts(std::vector<EngineContact>& contacts) const override {
    contacts.clear();
    for (int i = 0; i < data_->ncon; ++i) contacts.push_back(contact(i));
  }

 protected:
  void apply(std::size_t body, const Vector3& force_W, const Vector3& moment_W) override {
    mjtNum* const on_body = data_->xfrc_applied + 6 * static_cast<std::size_t>(ids_[body]);
    for (int i = 0; i < 3; ++i) on_body[i] = force_W[i], on_body[3 + i] = moment_W[i];
    is_pushed_ = true;
  }

  void advance(EngineStep& step) override {
    for (const Joint& joint : joints_) data_->qfrc_applied[joint.dof] = joint.drive.torque;
    {
      std::optional<MujocoOverride> native;
      if (by_native_) native.emplace();
      mj_step(model_.get(), data_.get());
    }
    if (is_pushed_) mju_zero(data_->xfrc_applied, 6 * model_->nbody);  // MuJoCo keeps it
    is_pushed_ = false;
    step.contacts = static_cast<std::size_t>(data_->ncon);
    constexpr std::array<std::pair<mjtWarning, const char*>, 5> kWarnings{
        {{mjWARN_CONTACTFULL, "more contacts than there is room for"},
         {mjWARN_CNSTRFULL, "more constraints than there is room for"},
         {mjWARN_BADQPOS, "a position that is none"},
         {mjWARN_BADQVEL, "a velocity that is none"},
         {mjWARN_BADQACC, "an acceleration that is none"}}};
    for (const auto& [warning, text] : kWarnings)
      if (data_->warning[warning].number > 0) step.failure = std::string("MuJoCo: ") + text;
    if (step.failure.empty()) find_links();
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
    const Joint& joint = joints_[index];
    double torque = joint.drive.torque;
    for (int row = 0; row < data_->nefc; ++row)
      if (data_->efc_type[row] == mjCNSTR_FRICTION_DOF && data_->efc_id[row] == joint.dof)
        torque = data_->efc_force[row];
    return {data_->qpos[joint.q], data_->qvel[joint.dof], torque};
  }

  void set_drive(std::size_t index, const JointDrive& drive) override {
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

  void add_joint(std::size_t index) {
    const EngineScene::Joint& source = bodies().joints()[index];
    const int joint = mj_name2id(model_.get(), mjOBJ_JOINT, ("j" + std::to_string(index)).c_str());
    joints_.push_back({model_->jnt_qposadr[joint], model_->jnt_dofadr[joint], {}});
    data_->qvel[joints_.back().dof] = source.source->rate;
    const auto require_limit = [&](const JointDrive& drive) {
      if (drive.mode == JointDrive::Mode::brake &&
          !std::isfinite(std::min(drive.limit, source.source->effort)))
        throw InputError("engine 'mujoco': unsupported: a brake without a limit (" + source.name + ")");
    };
    require_limit(source.source->drive.drive);
    for (const SceneAction& action : scene().actions)
      if (action.kind == SceneAction::Kind::drive && action.joint.mechanism == source.address.mechanism &&
          action.joint.joint == source.address.joint)
        require_limit(action.drive.drive);
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

  bool by_native_, is_pushed_ = false;
  mujoco::ModelHandle model_;
  mujoco::DataHandle data_;
  std::vector<int> ids_, first_q_, first_v_;  // by body
  std::vector<SolidIndex> solid_of_;          // by geom
  std::vector<Joint> joints_;
};

}  // namespace

std::unique_ptr<DynamicsEngine> make_world(const DynamicScene& scene, bool by_native) {
  return std::make_unique<MujocoEngine>(scene, by_native);
}

}  // namespace touchstone::physics::mujoco_dynamics
