#include "touchstone/examples/dynamics_run/simulate.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/contact_core/native/native.hpp"
#include "touchstone/examples/dynamics_run/account.hpp"
#include "touchstone/examples/measures/allocations.hpp"
#include "touchstone/physics/scene_simulation.hpp"

namespace touchstone::dynamics {
namespace {

using physics::Contact;
using physics::NarrowphaseContacts;
using physics::SceneAnswer;
using physics::SceneSimulation;
using Clock = std::chrono::steady_clock;

/// Rates that solves leave are below (their tolerance is 1e-10) [rad/s] or [m/s].
constexpr double kAtRest = 1e-9;

double microseconds(Clock::duration time) { return std::chrono::duration<double, std::micro>(time).count(); }

/// Fresh contacts of the backend.
SceneSimulation::MakeContacts contacts_by(const physics::DynamicScene& scene, const BackendRegistry& registry,
                                          const std::string& backend) {
  return [&scene, &registry, backend] {
    return std::make_unique<NarrowphaseContacts>(registry.make_broadphase("native"),
                                                 registry.make_narrowphase(backend), scene.contact_margin);
  };
}

struct TimedStep {
  physics::StepReport report;
  double detection_us, total_us;
};

/// Contacts and forces, by the clock on the wall.
TimedStep timed_step(SceneSimulation& simulation) {
  const Clock::time_point start = Clock::now();
  simulation.find_contacts();
  const Clock::time_point found = Clock::now();
  const physics::StepReport report = simulation.advance();
  return {report, microseconds(found - start), microseconds(Clock::now() - start)};
}

class Run {
 public:
  Run(const physics::DynamicScene& scene, const BackendRegistry& registry, const std::string& backend,
      std::size_t every)
      : scene_(&scene),
        registry_(&registry),
        every_(every),
        simulation_(scene, contacts_by(scene, registry, backend)),
        account_(simulation_),
        joints_(moving_joints(scene)),
        impacts_(scene.scene.objects.size(), Vector3::Zero()),
        moved_(joints_.size(), kNone) {
    out_.backend = backend;
    out_.answers.resize(scene.answers.size());
    out_.total_us.reserve(scene.step_count());
    out_.detection_us.reserve(scene.step_count());
    if (comparison::thread_allocations()) out_.allocations = 0;
  }

  BackendRun run(comparison::ProgressLine& progress) {
    if (every_ > 0) record();
    while (!simulation_.is_over() && out_.stopped.empty()) {
      step();
      const double done =
          static_cast<double>(simulation_.steps()) / static_cast<double>(scene_->step_count());
      progress.share(done);
    }
    finish();
    return std::move(out_);
  }

 private:
  void step() {
    account_.before_begin(simulation_);
    simulation_.begin_step();
    account_.after_begin(simulation_);
    const auto allocated = comparison::thread_allocations();
    const auto [report, detection_us, total_us] = timed_step(simulation_);
    if (out_.allocations && out_.steps > 0)
      *out_.allocations += *comparison::thread_allocations() - *allocated;
    count(report);
    if (report.failure != physics::StepFailure::none) {
      const std::string name = simulation_.failed_name(report);
      out_.stopped = "at " + std::to_string(simulation_.time()) +
                     " s: " + std::string(to_string(report.failure)) + (name.empty() ? "" : ": " + name) +
                     ": " + std::string(reason_of(report.failure));
      return;
    }
    ++out_.steps;
    out_.detection_us.push_back(detection_us);
    out_.total_us.push_back(total_us);
    look(report);
  }

  void count(const physics::StepReport& report) {
    out_.contact_count += simulation_.contacts().size();
    out_.undecided += simulation_.detection().undecided();
    out_.failed += simulation_.detection().failed();
    out_.unconverged += report.unconverged;
    out_.worst_residual = std::max(out_.worst_residual, report.worst_residual);
  }

  /// Not timed.
  void look(const physics::StepReport& report) {
    account_.after_step(simulation_);
    measure_depth();
    for (std::size_t i = 0; i < simulation_.contacts().size(); ++i) {
      const physics::ContactOrigin& origin = simulation_.detection().origins()[i];
      impacts_[simulation_.object_of(origin.solids.a)] -= simulation_.forces()[i].impact_W;
      impacts_[simulation_.object_of(origin.solids.b)] += simulation_.forces()[i].impact_W;
    }
    for (std::size_t j = 0; j < joints_.size(); ++j)
      if (std::isnan(moved_[j]) && std::abs(simulation_.joint_rate(joints_[j])) > kAtRest)
        moved_[j] = simulation_.time();
    if (!std::isnan(report.last_stop)) stopped_ = (simulation_.time() - scene_->step) + report.last_stop;
    answer_now();
    if (every_ > 0 && (out_.steps % every_ == 0 || simulation_.is_over())) record();
  }

  /// By native, whichever backend the contacts come from.
  void measure_depth() {
    if (judged_world_ != simulation_.worlds()) {
      judge_ = std::make_unique<NarrowphaseContacts>(registry_->make_broadphase("native"), make_native(),
                                                     scene_->contact_margin);
      simulation_.fill(*judge_);
      judged_world_ = simulation_.worlds();
    }
    judge_->find(simulation_.world());
    for (const physics::ContactOrigin& origin : judge_->origins())
      out_.deepest = std::max(out_.deepest, -origin.separation);
  }

  Vector3 force_on(std::size_t object) const {
    Vector3 sum = Vector3::Zero();
    for (std::size_t i = 0; i < simulation_.contacts().size(); ++i) {
      const physics::ContactOrigin& origin = simulation_.detection().origins()[i];
      if (simulation_.object_of(origin.solids.a) == object) sum -= simulation_.forces()[i].force_W;
      if (simulation_.object_of(origin.solids.b) == object) sum += simulation_.forces()[i].force_W;
    }
    return sum;
  }

  Vector3 figure(const SceneAnswer& answer) const {
    using Figure = SceneAnswer::Figure;
    switch (answer.figure) {
      case Figure::position:
        return simulation_.object_pose(answer.object).p;
      case Figure::velocity:
        return simulation_.velocity(answer.object).value_or(Vector3::Constant(kNone));
      case Figure::angular_velocity:
        return simulation_.angular_velocity(answer.object).value_or(Vector3::Constant(kNone));
      case Figure::force:
        return force_on(answer.object);
      case Figure::impact:
        return impacts_[answer.object];
      case Figure::value:
        return {simulation_.joint_value(answer.joint), 0, 0};
      case Figure::rate:
        return {simulation_.joint_rate(answer.joint), 0, 0};
      case Figure::torque:
        return {simulation_.joint_torque(answer.joint), 0, 0};
      case Figure::moved:
        for (std::size_t j = 0; j < joints_.size(); ++j)
          if (joints_[j].mechanism == answer.joint.mechanism && joints_[j].joint == answer.joint.joint)
            return {moved_[j], 0, 0};
        return Vector3::Constant(kNone);
      case Figure::stopped:
        return {stopped_, 0, 0};
    }
    return Vector3::Constant(kNone);
  }

  void answer_now() {
    for (std::size_t i = 0; i < scene_->answers.size(); ++i) {
      const SceneAnswer& answer = scene_->answers[i];
      if (std::llround(answer.time / scene_->step) != static_cast<long long>(out_.steps)) continue;
      AnswerResult& result = out_.answers[i];
      result.found = figure(answer);
      result.error = norm(result.found - answer.value);
      result.holds = result.error <= answer.tolerance;
    }
  }

  void record() {
    Series& series = out_.series;
    const physics::DynamicsWorld& world = simulation_.world();
    series.samples.push_back(
        {simulation_.time(), world.linear_momentum(), world.angular_momentum(), world.energy()});
    const std::size_t objects = scene_->scene.objects.size(), first = series.force_W.size();
    series.force_W.resize(first + objects, Vector3::Zero());
    series.moment_W.resize(first + objects, Vector3::Zero());
    for (std::size_t o = 0; o < objects; ++o) series.p_W.push_back(simulation_.object_pose(o).p);
    for (const physics::JointAddress& joint : joints_) {
      series.value.push_back(simulation_.joint_value(joint));
      series.rate.push_back(simulation_.joint_rate(joint));
      series.torque.push_back(simulation_.joint_torque(joint));
    }
    if (out_.steps > 0) record_contacts(first);
  }

  void record_contacts(std::size_t first) {
    Series& series = out_.series;
    for (std::size_t i = 0; i < simulation_.contacts().size(); ++i) {
      const Contact& contact = simulation_.contacts()[i];
      const physics::ContactForce& force = simulation_.forces()[i];
      const physics::ContactOrigin& origin = simulation_.detection().origins()[i];
      const Vector3 p_W = 0.5 * (contact.p_A_W + contact.p_B_W);
      series.contacts.push_back({simulation_.time(), origin.solids.a, origin.solids.b, origin.status, p_W,
                                 contact.n_AB_W, -origin.separation, force.force_W, force.impact_W});
      const auto add = [&](SolidIndex solid, double sign) {
        const std::size_t at = first + simulation_.object_of(solid);
        series.force_W[at] += sign * force.force_W;
        series.moment_W[at] += sign * cross(p_W, force.force_W);
      };
      add(origin.solids.a, -1.0);
      add(origin.solids.b, 1.0);
    }
  }

  void finish() {
    for (std::size_t o = 0; o < scene_->scene.objects.size(); ++o)
      out_.last.push_back(simulation_.object_pose(o));
    out_.unexplained_momentum = account_.unexplained_momentum();
    out_.linear_drift = account_.linear_drift();
    out_.angular_drift = account_.angular_drift();
    out_.energy_drift = account_.energy_drift();
    out_.energy_made = account_.energy_made();
    out_.energy_lost = account_.energy_lost();
    out_.energy_scale = account_.energy_scale();
  }

  const physics::DynamicScene* scene_;
  const BackendRegistry* registry_;
  std::size_t every_;
  SceneSimulation simulation_;
  Account account_;
  std::vector<physics::JointAddress> joints_;
  std::unique_ptr<NarrowphaseContacts> judge_;
  std::uint64_t judged_world_ = 0;
  std::vector<Vector3> impacts_;  // by object
  std::vector<double> moved_;     // by joint
  double stopped_ = kNone;
  BackendRun out_;
};

}  // namespace

BackendRun simulate(const physics::DynamicScene& scene, const BackendRegistry& registry,
                    const std::string& backend, std::size_t every, comparison::ProgressLine& progress) {
  std::unique_ptr<Run> run;
  try {
    run = std::make_unique<Run>(scene, registry, backend, every);
  } catch (const InputError& error) {  // the scene is valid: the backend refuses it
    BackendRun out;
    out.backend = backend;
    out.not_run = error.what();
    return out;
  }
  return run->run(progress);
}

void check(const physics::DynamicScene& scene, const BackendRegistry& registry) {
  const SceneSimulation simulation(scene, contacts_by(scene, registry, "native"));
}

void repeat_timing(const physics::DynamicScene& scene, const BackendRegistry& registry, BackendRun& run,
                   comparison::ProgressLine& progress) {
  if (!run.not_run.empty()) return;
  SceneSimulation simulation(scene, contacts_by(scene, registry, run.backend));
  for (std::size_t i = 0; i < run.total_us.size(); ++i) {
    simulation.begin_step();
    const TimedStep step = timed_step(simulation);
    run.detection_us[i] = std::min(run.detection_us[i], step.detection_us);
    run.total_us[i] = std::min(run.total_us[i], step.total_us);
    progress.share(static_cast<double>(i) / static_cast<double>(run.total_us.size()));
  }
}

std::vector<std::string> solid_names(const physics::DynamicScene& scene) {
  std::vector<std::string> names;
  for (const SceneObject& object : scene.scene.objects)
    for (const PlacedHexahedron& placed : object.tree.solids())
      names.push_back(object.tree.name() + "/" + placed.name);
  return names;
}

std::vector<physics::JointAddress> moving_joints(const physics::DynamicScene& scene) {
  std::vector<physics::JointAddress> joints;
  for (std::size_t m = 0; m < scene.mechanisms.size(); ++m)
    for (std::size_t j = 0; j < scene.mechanisms[m].joints.size(); ++j)
      if (scene.mechanisms[m].joints[j].kind != JointKind::fixed) joints.push_back({m, j});
  return joints;
}

std::vector<std::string> joint_names(const physics::DynamicScene& scene) {
  std::vector<std::string> names;
  for (const physics::JointAddress& joint : moving_joints(scene))
    names.push_back(scene.mechanisms[joint.mechanism].name + "." +
                    scene.mechanisms[joint.mechanism].joints[joint.joint].name);
  return names;
}

}  // namespace touchstone::dynamics
