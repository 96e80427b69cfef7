#include <algorithm>
#include <chrono>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/contact_core/native/native.hpp"
#include "touchstone/physics/engine/engine_registry.hpp"
#include "touchstone/physics/scene/scene_simulation.hpp"

namespace touchstone::physics {
namespace {

using Clock = std::chrono::steady_clock;

double microseconds(Clock::duration time) { return std::chrono::duration<double, std::micro>(time).count(); }

SceneSimulation::MakeContacts contacts_by(const DynamicScene& scene, const BackendRegistry& backends,
                                          const std::string& narrowphase) {
  return [&scene, &backends, narrowphase] {
    return std::make_unique<NarrowphaseContacts>(
        backends.make_broadphase("native"), backends.make_narrowphase(narrowphase), scene.contact_margin);
  };
}

class OwnEngine final : public DynamicsEngine {
 public:
  OwnEngine(const DynamicScene& scene, const BackendRegistry& backends, const std::string& narrowphase)
      : backends_(&backends), simulation_(scene, contacts_by(scene, backends, narrowphase)) {}

  const DynamicScene& scene() const override { return simulation_.scene(); }
  std::uint64_t steps() const override { return simulation_.steps(); }
  bool locates_events() const override { return true; }
  void begin_step() override { simulation_.begin_step(); }

  EngineStep step() override {
    const Clock::time_point start = Clock::now();
    simulation_.find_contacts();
    const Clock::time_point found = Clock::now();
    const StepReport report = simulation_.advance();
    EngineStep out;
    out.total_us = microseconds(Clock::now() - start);
    out.detection_us = microseconds(found - start);
    out.contacts = simulation_.contacts().size();
    out.undecided = simulation_.detection().undecided();
    out.failed = simulation_.detection().failed();
    out.unconverged = report.unconverged;
    out.worst_residual = report.worst_residual;
    out.last_stop = report.last_stop;
    if (report.failure == StepFailure::none) return out;
    const std::string name = simulation_.failed_name(report);
    out.failure = std::string(to_string(report.failure)) + (name.empty() ? "" : ": " + name) + ": " +
                  std::string(reason_of(report.failure));
    return out;
  }

  bool has(std::size_t object) const override { return simulation_.has(object); }
  std::size_t carrier_of(std::size_t object) const override { return simulation_.carrier_of(object); }
  EngineReturn after_restore() const override { return EngineReturn::same_bits; }
  std::unique_ptr<EngineSnapshot> snapshot() const override {
    return std::make_unique<Snapshot>(simulation_.snapshot());
  }
  void restore(const EngineSnapshot& snapshot) override {
    const auto* const ours = dynamic_cast<const Snapshot*>(&snapshot);
    if (ours == nullptr) throw InputError("restore: the snapshot is of another engine");
    simulation_.restore(ours->state);
    simulation_.world_to_set().forget_pushes();
  }
  void reset() override { simulation_.reset(); }

  void list_contacts(std::vector<EngineContact>& contacts) const override {
    contacts.clear();
    for (std::size_t i = 0; i < simulation_.contacts().size(); ++i) {
      const Contact& c = simulation_.contacts()[i];
      const ContactForce& force = simulation_.forces()[i];
      const ContactOrigin& origin = simulation_.detection().origins()[i];
      const Vector3 p_W = 0.5 * (c.p_A_W + c.p_B_W);
      contacts.push_back({origin.solids, origin.status, p_W, c.n_AB_W, origin.separation, force.force_W,
                          force.impact_W, side_of(c.a), side_of(c.b), commanded_velocity(c.a, p_W),
                          commanded_velocity(c.b, p_W)});
    }
  }

  bool are_asleep(const SolidPair& solids) const override { return simulation_.are_asleep(solids); }

  Pose object_pose(std::size_t object) const override { return simulation_.object_pose(object); }
  std::optional<Vector3> velocity(std::size_t object) const override { return simulation_.velocity(object); }
  std::optional<Vector3> angular_velocity(std::size_t object) const override {
    return simulation_.angular_velocity(object);
  }
  double joint_value(const JointAddress& joint) const override { return simulation_.joint_value(joint); }
  double joint_rate(const JointAddress& joint) const override { return simulation_.joint_rate(joint); }
  double joint_torque(const JointAddress& joint) const override { return simulation_.joint_torque(joint); }

  Vector3 linear_momentum() const override { return world().linear_momentum(); }
  Vector3 angular_momentum() const override { return world().angular_momentum(); }
  double energy() const override { return world().energy(); }
  Vector3 body_momentum() const override {
    Vector3 sum = Vector3::Zero();
    for (std::uint32_t i = 0; i < world().body_count(); ++i)
      if (!world().is_kinematic(i)) sum += world().state(i).momentum_W;
    return sum;
  }
  double body_mass() const override {
    double sum = 0.0;
    for (std::uint32_t i = 0; i < world().body_count(); ++i)
      if (!world().is_kinematic(i)) sum += world().body(i).inertia().mass;
    return sum;
  }

  double worst_depth() override {
    if (judged_world_ != simulation_.worlds()) {
      judge_ = std::make_unique<NarrowphaseContacts>(backends_->make_broadphase("native"), make_native(),
                                                     scene().contact_margin);
      judge_->keep_edges();
      simulation_.fill(*judge_);
      judged_world_ = simulation_.worlds();
    }
    judge_->find(world());
    double deepest = 0.0;
    for (const ContactOrigin& origin : judge_->origins()) deepest = std::max(deepest, -origin.separation);
    return deepest;
  }

 private:
  struct Snapshot final : EngineSnapshot {
    explicit Snapshot(SceneSimulation::Snapshot of) : state(std::move(of)) {}
    SceneSimulation::Snapshot state;
  };

  void take_out(std::size_t object) override { simulation_.remove(object); }
  void put_in(std::size_t object, const Pose& X_WO, const Vector3& v_W, const Vector3& w_W) override {
    simulation_.add(object, X_WO, v_W, w_W);
  }

  void take_action(const SceneAction& action) override { simulation_.act(action); }

  /// No force moves objects that a kinematic body or the ground carries.
  void take_push(std::size_t object, const Vector3& force_W, const Vector3& p_W,
                 const Vector3& moment_W) override {
    const Mover& mover = simulation_.mover_of(object);
    if (mover.kind != Mover::Kind::ground && !is_kinematic(mover))
      simulation_.world_to_set().push(mover, force_W, p_W, moment_W);
  }

  const DynamicsWorld& world() const { return simulation_.world(); }
  bool is_kinematic(const Mover& mover) const {
    return mover.kind == Mover::Kind::body && world().is_kinematic(mover.index);
  }
  ContactSide side_of(const Mover& mover) const {
    if (mover.kind == Mover::Kind::ground) return ContactSide::ground;
    if (mover.kind == Mover::Kind::link) return ContactSide::link;
    return is_kinematic(mover) ? ContactSide::kinematic : ContactSide::body;
  }
  Vector3 commanded_velocity(const Mover& mover, const Vector3& p_W) const {
    if (!is_kinematic(mover)) return Vector3::Zero();
    return world().velocity(mover.index) +
           cross(world().angular_velocity(mover.index), p_W - world().state(mover.index).p_W);
  }

  const BackendRegistry* backends_;
  SceneSimulation simulation_;
  std::unique_ptr<NarrowphaseContacts> judge_;
  std::uint64_t judged_world_ = 0;
};

}  // namespace

void register_own_engine(EngineRegistry& registry, const BackendRegistry& backends) {
  EngineRegistry::Entry entry;
  entry.name = "own";
  entry.description = "this project's dynamics, over the contacts of any narrowphase";
  entry.checks.emplace_back(kOwnCheck);
  for (const BackendRegistry::NarrowphaseEntry& each : backends.narrowphases())
    entry.checks.push_back(each.name);
  entry.features = [&backends](std::string_view check) {
    const std::unique_ptr<Narrowphase> narrowphase =
        backends.make_narrowphase(check == kOwnCheck ? "native" : std::string(check));
    return narrowphase->capabilities().rounded_solids
               ? EngineFeatures::all()
               : EngineFeatures::all().without(EngineFeature::rounded_solids);
  };
  entry.after_restore = EngineReturn::same_bits;
  entry.make = [&backends](const DynamicScene& scene, const std::string& check) {
    return std::make_unique<OwnEngine>(scene, backends, check == kOwnCheck ? "native" : check);
  };
  registry.add(std::move(entry));
}

}  // namespace touchstone::physics
