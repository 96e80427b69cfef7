#include "touchstone/examples/dynamics_run/simulate.hpp"

#include <algorithm>
#include <cmath>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/examples/dynamics_run/account.hpp"
#include "touchstone/examples/measures/common/allocations.hpp"

namespace touchstone::dynamics {
namespace {

using physics::DynamicsEngine;
using physics::EngineChoice;
using physics::EngineContact;
using physics::EngineRegistry;
using physics::EngineStep;
using physics::SceneAnswer;

/// Rates that solves leave are below (their tolerance is 1e-10) [rad/s] or [m/s].
constexpr double kAtRest = 1e-9;
/// Of scenes with more objects than kSmall depth is looked at in one step of several, and in the last.
constexpr std::size_t kSmall = 200, kDepthEvery = 10;

class Run {
 public:
  Run(const physics::DynamicScene& scene, std::unique_ptr<DynamicsEngine> engine, std::string name,
      std::size_t every)
      : scene_(&scene),
        every_(every),
        engine_(std::move(engine)),
        account_(*engine_),
        joints_(moving_joints(scene)),
        impacts_(scene.scene.objects.size(), Vector3::Zero()),
        moved_(joints_.size(), kNone) {
    for (std::size_t o = 0; o < scene.scene.objects.size(); ++o)
      object_of_.insert(object_of_.end(), scene.scene.objects[o].tree.solids().size(), o);
    out_.backend = std::move(name);
    out_.answers.resize(scene.answers.size());
    out_.total_us.reserve(scene.step_count());
    out_.detection_us.reserve(scene.step_count());
    if (measures::thread_allocations()) out_.allocations = 0;
  }

  BackendRun run(program::ProgressLine& progress) {
    if (every_ > 0) record();
    while (!engine_->is_over() && out_.stopped.empty()) {
      step();
      progress.share(static_cast<double>(engine_->steps()) / static_cast<double>(scene_->step_count()));
    }
    finish();
    return std::move(out_);
  }

 private:
  void step() {
    account_.before_begin(*engine_);
    engine_->begin_step();
    account_.after_begin(*engine_);
    const auto allocated = measures::thread_allocations();
    const EngineStep step = engine_->step();
    if (out_.allocations && out_.steps > 0) *out_.allocations += *measures::thread_allocations() - *allocated;
    count(step);
    if (!step.failure.empty()) {
      out_.stopped = "at " + std::to_string(engine_->time()) + " s: " + step.failure;
      return;
    }
    ++out_.steps;
    out_.detection_us.push_back(step.detection_us);
    out_.total_us.push_back(step.total_us);
    look(step);
  }

  void count(const EngineStep& step) {
    out_.contact_count += step.contacts;
    out_.undecided += step.undecided;
    out_.failed += step.failed;
    out_.unconverged += step.unconverged;
    out_.worst_residual = std::max(out_.worst_residual, step.worst_residual);
  }

  /// Not timed.
  void look(const EngineStep& step) {
    engine_->list_contacts(contacts_);
    account_.after_step(*engine_, contacts_);
    const bool is_small = scene_->scene.objects.size() <= kSmall;
    if (is_small || out_.steps % kDepthEvery == 0 || engine_->is_over())
      out_.deepest = std::max(out_.deepest, engine_->worst_depth());
    for (const EngineContact& contact : contacts_) {
      impacts_[object_of_[contact.solids.a]] -= contact.impact_W;
      impacts_[object_of_[contact.solids.b]] += contact.impact_W;
    }
    for (std::size_t j = 0; j < joints_.size(); ++j)
      if (std::isnan(moved_[j]) && std::abs(engine_->joint_rate(joints_[j])) > kAtRest)
        moved_[j] = engine_->time();
    if (!std::isnan(step.last_stop)) stopped_ = (engine_->time() - scene_->step) + step.last_stop;
    answer_now();
    if (every_ > 0 && (out_.steps % every_ == 0 || engine_->is_over())) record();
  }

  Vector3 force_on(std::size_t object) const {
    Vector3 sum = Vector3::Zero();
    for (const EngineContact& contact : contacts_) {
      if (object_of_[contact.solids.a] == object) sum -= contact.force_W;
      if (object_of_[contact.solids.b] == object) sum += contact.force_W;
    }
    return sum;
  }

  Vector3 figure(const SceneAnswer& answer) const {
    using Figure = SceneAnswer::Figure;
    switch (answer.figure) {
      // Of bodies, from the engine's state.
      case Figure::position:
        return engine_->object_pose(answer.object).p;
      case Figure::velocity:
        return engine_->velocity(answer.object).value_or(Vector3::Constant(kNone));
      case Figure::angular_velocity:
        return engine_->angular_velocity(answer.object).value_or(Vector3::Constant(kNone));
      // Of bodies, from the contacts of steps.
      case Figure::force:
        return force_on(answer.object);
      case Figure::impact:
        return impacts_[answer.object];
      // Of joints.
      case Figure::value:
        return {engine_->joint_value(answer.joint), 0, 0};
      case Figure::rate:
        return {engine_->joint_rate(answer.joint), 0, 0};
      case Figure::torque:
        return {engine_->joint_torque(answer.joint), 0, 0};
      // Times at which something came to pass.
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
      const bool is_event =
          answer.figure == SceneAnswer::Figure::impact || answer.figure == SceneAnswer::Figure::stopped;
      result.is_given = !is_event || engine_->locates_events();
      if (!result.is_given) continue;
      result.found = figure(answer);
      result.error = norm(result.found - answer.value);
      result.holds = result.error <= answer.tolerance;
    }
  }

  void record() {
    Series& series = out_.series;
    series.samples.push_back(
        {engine_->time(), engine_->linear_momentum(), engine_->angular_momentum(), engine_->energy()});
    const std::size_t objects = scene_->scene.objects.size(), first = series.force_W.size();
    series.force_W.resize(first + objects, Vector3::Zero());
    series.moment_W.resize(first + objects, Vector3::Zero());
    for (std::size_t o = 0; o < objects; ++o) {
      const Pose X_WO = engine_->object_pose(o);
      series.p_W.push_back(X_WO.p);
      series.q_WO.push_back(quaternion_of(X_WO.R));
    }
    for (const physics::JointAddress& joint : joints_) {
      series.value.push_back(engine_->joint_value(joint));
      series.rate.push_back(engine_->joint_rate(joint));
      series.torque.push_back(engine_->joint_torque(joint));
    }
    if (out_.steps > 0) record_contacts(first);
  }

  void record_contacts(std::size_t first) {
    Series& series = out_.series;
    for (const EngineContact& contact : contacts_) {
      series.contacts.push_back({engine_->time(), contact.solids.a, contact.solids.b, contact.status,
                                 contact.p_W, contact.n_AB_W, -contact.separation, contact.force_W,
                                 contact.impact_W});
      const auto add = [&](SolidIndex solid, double sign) {
        const std::size_t at = first + object_of_[solid];
        series.force_W[at] += sign * contact.force_W;
        series.moment_W[at] += sign * cross(contact.p_W, contact.force_W);
      };
      add(contact.solids.a, -1.0);
      add(contact.solids.b, 1.0);
    }
  }

  /// The fastest that a point of the object's bounding spheres about its origin can be.
  double fastest_point(std::size_t object) const {
    const auto v = engine_->velocity(object), w = engine_->angular_velocity(object);
    if (!v || !w) return 0.0;
    const Sphere& sphere = scene_->scene.objects[object].tree.nodes()[0].sphere_O;
    return norm(*v) + norm(*w) * (norm(sphere.centre) + sphere.radius);
  }

  void finish() {
    for (std::size_t o = 0; o < scene_->scene.objects.size(); ++o)
      out_.last.push_back(engine_->object_pose(o));
    out_.rest_speed = 0.0;
    for (std::size_t o = 0; o < scene_->scene.objects.size(); ++o)
      out_.rest_speed = std::max(out_.rest_speed, fastest_point(o));
    out_.unexplained_momentum = account_.unexplained_momentum();
    out_.linear_drift = account_.linear_drift();
    out_.angular_drift = account_.angular_drift();
    out_.energy_drift = account_.energy_drift();
    out_.linear_scale = account_.linear_scale();
    out_.angular_scale = account_.angular_scale();
    out_.energy_made = account_.energy_made();
    out_.energy_lost = account_.energy_lost();
    out_.energy_scale = account_.energy_scale();
  }

  const physics::DynamicScene* scene_;
  std::size_t every_;
  std::unique_ptr<DynamicsEngine> engine_;
  Account account_;
  std::vector<physics::JointAddress> joints_;
  std::vector<std::size_t> object_of_;  // by solid
  std::vector<EngineContact> contacts_;
  std::vector<Vector3> impacts_;  // by object
  std::vector<double> moved_;     // by joint
  double stopped_ = kNone;
  BackendRun out_;
};

}  // namespace

std::string run_name(const EngineChoice& choice) {
  // With its own check an engine is "bullet:own": "bullet" is ours over the contacts of the backend.
  if (choice.engine != "own") return choice.engine + ":" + choice.check;
  return choice.check == physics::kOwnCheck ? "native" : choice.check;
}

BackendRun simulate(const physics::DynamicScene& scene, const EngineRegistry& engines,
                    const EngineChoice& choice, std::size_t every, program::ProgressLine& progress) {
  std::unique_ptr<Run> run;
  try {
    run = std::make_unique<Run>(scene, engines.make(choice, scene), run_name(choice), every);
  } catch (const InputError& error) {  // the scene is valid: the engine or the backend refuses it
    BackendRun out;
    out.backend = run_name(choice);
    out.not_run = error.what();
    return out;
  }
  return run->run(progress);
}

void check(const physics::DynamicScene& scene, const EngineRegistry& engines) {
  if (!scene.mechanisms.empty()) engines.make({"own", "native"}, scene);
}

void repeat_timing(const physics::DynamicScene& scene, const EngineRegistry& engines,
                   const EngineChoice& choice, BackendRun& run, program::ProgressLine& progress) {
  if (!run.not_run.empty()) return;
  const std::unique_ptr<DynamicsEngine> engine = engines.make(choice, scene);
  for (std::size_t i = 0; i < run.total_us.size(); ++i) {
    engine->begin_step();
    const EngineStep step = engine->step();
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
  for (std::size_t j = 0; j < scene.joints.size(); ++j) {
    const physics::JointAddress joint{physics::JointAddress::kBodyJoint, j};
    if (kind_of(scene, joint) != JointKind::fixed) joints.push_back(joint);
  }
  return joints;
}

std::vector<std::string> joint_names(const physics::DynamicScene& scene) {
  std::vector<std::string> names;
  for (const physics::JointAddress& joint : moving_joints(scene)) names.push_back(name_of(scene, joint));
  return names;
}

}  // namespace touchstone::dynamics
