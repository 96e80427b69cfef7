// The state of a run: snapshots, states set from outside, touches.

#include <algorithm>
#include <cmath>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/physics/scene/scene_simulation.hpp"

namespace touchstone::physics {

SceneSimulation::~SceneSimulation() = default;

SceneSimulation::Snapshot SceneSimulation::snapshot() const {
  Snapshot out(*world_);
  out.of_ = id_;
  out.pieces_ = pieces_;
  for (const std::unique_ptr<Arm>& arm : arms_) {
    out.links_.push_back(arm->links);
    out.drives_.push_back(arm->drives);
    out.drives_since_.push_back(arm->drives_since);
  }
  out.body_drives_ = body_drives_;
  out.body_drives_since_ = body_drives_since_;
  out.next_action_ = next_action_;
  out.is_refused_ = is_refused_;
  out.steps_ = steps_;
  return out;
}

void SceneSimulation::restore(const Snapshot& snapshot) {
  if (snapshot.of_ != id_) throw InputError("restore: the snapshot is of another simulation");
  *world_ = snapshot.world_;
  pieces_ = snapshot.pieces_;
  for (std::size_t m = 0; m < arms_.size(); ++m) {
    Arm& arm = *arms_[m];
    arm.links = snapshot.links_[m];
    arm.drives = snapshot.drives_[m];
    arm.drives_since = snapshot.drives_since_[m];
    arm.dynamics->set_links(arm.links);
  }
  body_drives_ = snapshot.body_drives_;
  body_drives_since_ = snapshot.body_drives_since_;
  next_action_ = snapshot.next_action_;
  is_refused_ = snapshot.is_refused_;
  steps_ = snapshot.steps_;
  change_contacts();
  touches_.forget();
}

void SceneSimulation::reset() { restore(*initial_); }

void SceneSimulation::set_joint(const JointAddress& joint, double value, double rate) {
  if (joint.is_of_bodies()) throw InputError("set_joint: only joints of mechanisms are put at values");
  if (joint.mechanism >= arms_.size() || joint.joint >= arms_[joint.mechanism]->value_of.size())
    throw InputError("set_joint: no such joint");
  const SceneMechanism& mechanism = scene_->mechanisms[joint.mechanism];
  const SceneJoint& source = mechanism.joints[joint.joint];
  const std::uint32_t at = arms_[joint.mechanism]->value_of[joint.joint];
  const auto refuse = [&](const char* why) {
    throw InputError("mechanism '" + mechanism.name + "': joint '" + source.name + "': " + why);
  };
  if (at == Mechanism::kNone) refuse("is fixed: it has no value to set");
  if (!std::isfinite(value) || !std::isfinite(rate)) refuse("value or rate is not finite");
  if (value < source.lower || value > source.upper) refuse("the value is out of its limits");
  const auto m = static_cast<std::uint32_t>(joint.mechanism);
  const std::span<const double> q = world_->joint_values(m), qd = world_->joint_rates(m);
  joint_q_.assign(q.begin(), q.end());
  joint_qd_.assign(qd.begin(), qd.end());
  joint_q_[at] = value;
  joint_qd_[at] = rate;
  world_->set_joints(m, joint_q_, joint_qd_);
}

void SceneSimulation::watch_touches(bool is_watched) {
  touches_.reserve(reserved_);
  is_watched_ = is_watched;
  touches_.forget();
}

void SceneSimulation::reserve(std::size_t contacts) {
  const std::size_t most = std::max(reserved_, contacts);
  world_->reserve(most);
  forces_.reserve(most);
  contacts_->reserve(most, most);
  if (is_watched_) touches_.reserve(most);
  reserved_ = most;
}

/// Neither forces nor commands move it now.
bool SceneSimulation::rests(std::size_t object) const { return !world_->is_restless(pieces_[object].mover); }

bool SceneSimulation::are_asleep(const SolidPair& solids) const {
  const std::size_t a = object_of_[solids.a], b = object_of_[solids.b];
  return has(a) && has(b) && rests(a) && rests(b) && world_->sleepers() > 0;
}

void SceneSimulation::take_touches() {
  touches_.begin();
  for (std::size_t i = 0; i < found_.size(); ++i) {
    const Contact& contact = found_[i];
    const ContactOrigin& origin = contacts_->origins()[i];
    touches_.add({origin.solids, 0.5 * (contact.p_A_W + contact.p_B_W), contact.n_AB_W, origin.separation,
                  scene_->step * forces_[i].force_W, forces_[i].impact_W});
  }
  touches_.finish([&](const SolidPair& pair) { return are_asleep(pair); });
}

}  // namespace touchstone::physics
