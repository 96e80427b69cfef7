#include "touchstone/examples/guarded_run/run.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/contact_core/threads/processor_time.hpp"
#include "touchstone/examples/measures/common/allocations.hpp"
#include "touchstone/physics/guarded/guarded_simulation.hpp"

namespace touchstone::guarded {
namespace {

using physics::GuardedSimulation;
using physics::GuardedStep;
using physics::NarrowphaseContacts;
using Clock = std::chrono::steady_clock;

constexpr double kNone = kNaN;
/// Of a joint's limit: it gives all that it has.
constexpr double kAll = 1.0 - 1e-9;
constexpr std::size_t kWarmFrames = 10;

double microseconds(Clock::duration time) { return std::chrono::duration<double, std::micro>(time).count(); }

/// Flies one scene: hands, dynamics, proof, output, frame by frame; what is only looked at is not timed.
class Flight {
 public:
  Flight(const GuardedScene& scene, const BackendRegistry& registry, const std::string& contacts)
      : scene_(&scene),
        registry_(&registry),
        run_(
            scene.scene, scene.settings, [&] { return registry.make_narrowphase("native"); },
            [&] { return registry.make_broadphase("native"); },
            [&] { return registry.make_narrowphase(contacts); }) {
    out_.contacts = contacts;
    for (const SceneHand& hand : scene.hands) run_.add_hand(hand.hand);
    if (!scene.hands.empty()) asked_W_ = run_.hand_point(0);
    shown_.resize(scene.scene.scene.objects.size());
    for (const auto& entry : registry.narrowphases())
      if (entry.name == "exact") out_.judge = entry.name;
    if (out_.judge.empty()) out_.judge = "native";
    if (measures::thread_allocations()) out_.allocations = 0;
    step_us_.reserve(scene.scene.step_count());
    const double frame = 1.0 / scene.scene.scene.frame_rate;
    steps_ = std::max<std::size_t>(1, static_cast<std::size_t>(std::llround(frame / scene.scene.step)));
  }

  GuardedRun fly(program::ProgressLine& progress) {
    judge_start();
    while (!run_.is_over() && out_.stopped.empty()) {
      frame();
      progress.share(static_cast<double>(run_.simulation().steps()) /
                     static_cast<double>(scene_->scene.step_count()));
    }
    out_.frame = measures::step_times(std::move(frame_us_));
    out_.step = measures::step_times(std::move(step_us_));
    out_.wall = measures::step_times(std::move(wall_us_));
    return std::move(out_);
  }

 private:
  void command() {
    for (std::size_t i = 0; i < scene_->hands.size(); ++i) {
      Twist wanted;
      for (const GuardedRates& row : scene_->hands[i].rates)
        if (row.time <= run_.simulation().time() + 0.5 * scene_->scene.step) wanted = row.wanted_W;
      run_.command(i, wanted);
      if (i == 0) wanted_W_ = wanted.v;
    }
  }

  void frame() {
    sample_ = {kNone, Vector3::Zero(), Vector3::Zero(), 0.0, 0.0, kNone, 0.0};
    const Vector3 before = scene_->hands.empty() ? Vector3::Zero() : run_.hand_point(0);
    const std::uint64_t worlds = run_.simulation().worlds();
    double frame_us = 0.0, wall_us = 0.0;
    std::uint64_t allocated = 0;
    std::size_t steps = 0;
    for (; steps < steps_ && !run_.is_over(); ++steps) {
      // Each step is timed by the processor's clock, and by the wall's.
      const auto counted = measures::thread_allocations();
      const Clock::time_point wall = Clock::now();
      const double start = processor_us();
      if (steps == 0) command();
      const GuardedStep step = run_.step();
      if (steps + 1 == steps_) show();
      step_us_.push_back(processor_us() - start);
      frame_us += step_us_.back();
      wall_us += microseconds(Clock::now() - wall);
      if (counted) allocated += *measures::thread_allocations() - *counted;
      // A step that fails ends the run, with the object's name.
      if (step.dynamics.failure != physics::StepFailure::none) {
        out_.stopped = "at " + std::to_string(run_.simulation().time()) +
                       " s: " + std::string(physics::reason_of(step.dynamics.failure)) + " (" +
                       run_.simulation().failed_name(step.dynamics) + ")";
        return;
      }
      look(step);
    }
    // A frame is the sum of its steps; a world that is made anew may allocate.
    frame_us_.push_back(frame_us);
    wall_us_.push_back(wall_us);
    if (out_.allocations && out_.frames >= kWarmFrames && worlds == run_.simulation().worlds())
      *out_.allocations += allocated;
    ++out_.frames;
    finish_frame(before, steps);
  }

  /// To the image generator.
  void show() {
    for (std::size_t i = 0; i < shown_.size(); ++i) shown_[i] = run_.shown_pose(i);
  }

  void finish_frame(const Vector3& before, std::size_t steps) {
    sample_.time = run_.simulation().time();
    sample_.force /= static_cast<double>(steps);
    if (!scene_->hands.empty()) {
      asked_W_ += (static_cast<double>(steps) * scene_->scene.step) * wanted_W_;
      sample_.asked_W = asked_W_;
      sample_.hand_W = run_.hand_point(0);
      const double asked = norm(wanted_W_), along = dot(sample_.hand_W - before, wanted_W_);
      const double share =
          asked > 0.0 ? along / (asked * asked * static_cast<double>(steps) * scene_->scene.step) : 1.0;
      // A hundredth of what was asked.
      const bool stands = sample_.torque_share >= kAll && share < 0.01;
      out_.stalled += stands ? 1 : 0;
      out_.driven_back += stands && share < -0.01 ? 1 : 0;
    }
    out_.samples.push_back(sample_);
  }

  void look(const GuardedStep& step) {
    ++out_.steps;
    out_.cut += step.cut > 0 ? 1 : 0;
    out_.standing += step.standing > 0 ? 1 : 0;
    out_.linear = std::max(out_.linear, norm(step.linear_W - (step.impulses.impulse_W - step.held_W)));
    out_.energy -= step.energy;
    out_.held_back = std::max(out_.held_back, step.held_back);
    out_.slides_ended += step.slides_ended > 0 ? 1 : 0;
    sample_.impulse += norm(step.impulses.impulse_W) + norm(step.held_W);
    look_at_hand();
    judge([&](const physics::ContactOrigin& origin) {
      out_.merged += origin.separation <= 0.0 ? 1 : 0;
      out_.least_separation = std::min(out_.least_separation, origin.separation);
      sample_.separation = std::fmin(sample_.separation, origin.separation);
    });
  }

  void look_at_hand() {
    if (scene_->hands.empty()) return;
    const physics::SceneSimulation& simulation = run_.simulation();
    const std::size_t link = scene_->hands[0].hand.link;
    sample_.force += norm(
        physics::wrench_on(simulation.mover_of(link), simulation.contacts(), simulation.forces()).force_W);
    const std::size_t m = simulation.mover_of(link).index;
    for (std::size_t j = 0; j < scene_->scene.mechanisms[m].joints.size(); ++j) {
      const double effort = scene_->scene.mechanisms[m].joints[j].effort;
      if (std::isfinite(effort) && effort > 0.0)
        sample_.torque_share =
            std::max(sample_.torque_share, std::abs(simulation.joint_torque({m, j})) / effort);
    }
  }

  /// Pairs near each other that any policy but `cue` is about, where they are shown.
  template <class Look>
  void judge(const Look& look) {
    if (!judge_ || judged_ != run_.simulation().worlds()) {
      judge_ = std::make_unique<NarrowphaseContacts>(registry_->make_broadphase("native"),
                                                     registry_->make_narrowphase(out_.judge), 1e-4);
      judge_->keep_edges();
      run_.simulation().fill(*judge_);
      judged_ = run_.simulation().worlds();
    }
    judge_->find(run_.simulation().world());
    for (const physics::ContactOrigin& origin : judge_->origins()) {
      const std::size_t a = run_.simulation().object_of(origin.solids.a),
                        b = run_.simulation().object_of(origin.solids.b);
      if (run_.policy(a, b) != physics::GuardPolicy::cue) look(origin);
    }
  }

  /// What merges before anything has moved is the scene's, and lasts until it parts.
  void judge_start() {
    judge([&](const physics::ContactOrigin& origin) {
      if (origin.separation > 0.0) return;
      const physics::SceneSimulation& simulation = run_.simulation();
      if (out_.began_merged++ == 0)
        out_.first_merged = "'" + simulation.solid_name(origin.solids.a) + "' and '" +
                            simulation.solid_name(origin.solids.b) + "'";
    });
  }

  const GuardedScene* scene_;
  const BackendRegistry* registry_;
  GuardedSimulation run_;
  std::size_t steps_ = 1;  // a frame
  std::vector<Pose> shown_;
  std::unique_ptr<NarrowphaseContacts> judge_;
  std::uint64_t judged_ = 0;
  Vector3 asked_W_ = Vector3::Zero(), wanted_W_ = Vector3::Zero();
  Sample sample_{};
  std::vector<double> frame_us_, wall_us_, step_us_;
  GuardedRun out_;
};

}  // namespace

GuardedRun run_scene(const GuardedScene& scene, const BackendRegistry& registry, const std::string& contacts,
                     program::ProgressLine& progress) {
  std::unique_ptr<Flight> flight;
  try {
    flight = std::make_unique<Flight>(scene, registry, contacts);
  } catch (const InputError& error) {
    GuardedRun out;
    out.contacts = contacts;
    out.not_run = error.what();
    return out;
  }
  return flight->fly(progress);
}

}  // namespace touchstone::guarded
