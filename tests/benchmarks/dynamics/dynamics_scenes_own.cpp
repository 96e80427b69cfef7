#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <span>

#include "touchstone/contact_core/geometry/matrix3.hpp"
#include "touchstone/contact_core/registry.hpp"
#include "touchstone/physics/contacts/narrowphase_contacts.hpp"
#include "touchstone/tests/benchmarks/dynamics/dynamics_scenes.hpp"

namespace touchstone::benchmarks {
namespace {

using physics::DynamicsWorld;
using physics::Mover;
using Clock = std::chrono::steady_clock;

constexpr double kMargin = 1e-3;  // [m]
// Fewer boxes may be in one heap, of which all meet all.
constexpr std::size_t kFew = 100;

class Own final : public BoxEngine {
 public:
  Own(const BoxScene& scene, double work) : step_(scene.step) {
    register_core(registry_);
    contacts_ = std::make_unique<physics::NarrowphaseContacts>(registry_.make_broadphase("native"),
                                                               registry_.make_narrowphase("native"), kMargin);
    DynamicsWorld::Settings settings;
    settings.gravity_W = {0, 0, -9.81};
    if (scene.sleeps) settings.sleep_time = 0.5;
    if (work > 0.0) {
      settings.work = work;
      std::snprintf(name_, sizeof(name_), "own@%g", work);
    }
    world_ = std::make_unique<DynamicsWorld>(settings);
    trees_.reserve(scene.boxes.size());
    for (const SceneBox& box : scene.boxes) add(box, scene.friction);
    contacts_->build();
    const std::size_t room = (scene.boxes.size() < kFew ? 48 : 16) * scene.boxes.size();
    contacts_->reserve(room, room);
    world_->reserve(room);
    log_.reserve(kMostLogged);
  }
  const char* name() const override { return name_; }
  void step() override {
    for (const Push& push : pushes_)
      world_->push(Mover::of_body(push.body), push.force_W, world_->pose(push.body).p);
    const Clock::time_point begin = Clock::now();
    const std::span<const physics::Contact> contacts = contacts_->find(*world_, step_);
    const double find_us = std::chrono::duration<double, std::micro>(Clock::now() - begin).count();
    const auto report = world_->step(step_, contacts);
    points_ = contacts.size();
    if (log_.size() < log_.capacity())
      log_.push_back({report, static_cast<std::uint32_t>(contacts.size()), find_us});
    if (report.solves > 0) {
      residuals_ += std::log10(std::max(report.worst_residual, kLeastResidual));
      ++solving_;
    }
    solves_ += report.solves;
    unconverged_ += report.unconverged;
    contradictory_ += report.contradictory;
    spent_ += report.is_work_spent ? 1 : 0;
    failed_ += report.failure != physics::StepFailure::none ? 1 : 0;
    most_newton_steps_ = std::max(most_newton_steps_, report.newton_steps);
  }
  BoxMotion motion(std::size_t box) const override {
    const auto body = static_cast<std::uint32_t>(box);
    return {world_->pose(body).p, world_->velocity(body), world_->angular_velocity(body)};
  }
  std::size_t points() const override { return points_; }
  std::string remarks() const override {
    char residual[32];
    const double mean = std::pow(10.0, residuals_ / std::max(static_cast<double>(solving_), 1.0));
    std::snprintf(residual, sizeof(residual), "%.1e", mean);
    return std::to_string(unconverged_) + " of " + std::to_string(solves_) + " solves unconverged, " +
           std::to_string(contradictory_) + " contradictory, work ended in " + std::to_string(spent_) +
           " steps, most Newton steps " + std::to_string(most_newton_steps_) +
           (solving_ > 0
                ? std::string(", worst residual of a step in the geometric mean ") + residual + " m/s"
                : "") +
           (failed_ > 0 ? ", " + std::to_string(failed_) + " steps FAILED" : "");
  }
  std::string remarks_on(std::size_t step) const override {
    if (step >= log_.size()) return {};
    const physics::StepReport& report = log_[step].report;
    char found[32];
    std::snprintf(found, sizeof(found), "%.0f", log_[step].find_us);
    return std::to_string(log_[step].contacts) + " contacts, found in " + found + " us, " +
           std::to_string(report.substeps) + " pieces, " + std::to_string(report.solves) + " solves (" +
           std::to_string(report.unconverged) + " unconverged), " + std::to_string(report.newton_steps) +
           " Newton steps" + (report.is_work_spent ? ", work ended" : "");
  }

 private:
  void add(const SceneBox& box, double friction) {
    trees_.push_back(std::make_unique<HexahedronTree>(
        std::vector<PlacedHexahedron>{{"box", Hexahedron::from_size(box.size), {}}}, "box"));
    Pose X_WB;
    X_WB.p = box.p_W;
    const double angle = norm(box.turn_W);
    if (angle > 0.0) X_WB.R = rotation_about(box.turn_W / angle, angle);
    const Vector3 zero = Vector3::Zero();
    std::uint32_t index = 0;
    if (box.kind == SceneBox::Kind::free) {
      const physics::RigidBody body(physics::box_inertia(box.mass, box.size), "box");
      index = world_->add_body(body, body.state(X_WB, box.v_W, zero));
      if (box.force_W != zero) pushes_.push_back({index, box.force_W});
    } else {
      index = world_->add_kinematic(X_WB, box.v_W, box.w_W);  // fixed: for its number alone
    }
    const bool is_fixed = box.kind == SceneBox::Kind::fixed;
    contacts_->add(is_fixed ? Mover::ground() : Mover::of_body(index), *trees_.back(), {friction, 0.0},
                   is_fixed ? X_WB : Pose{});
  }

  struct Push {
    std::uint32_t body;
    Vector3 force_W;
  };
  /// A step as it went, for remarks_on().
  struct Logged {
    physics::StepReport report;
    std::uint32_t contacts;
    double find_us;  // what finding them took
  };
  static constexpr std::size_t kMostLogged = 1 << 17;

  static constexpr double kLeastResidual = 1e-16;  // [m/s]: of a geometric mean

  double step_;
  char name_[32] = "own";
  double residuals_ = 0.0;  // of steps with solves: logarithms of the worst
  std::size_t solving_ = 0;
  std::size_t points_ = 0;
  BackendRegistry registry_;
  std::vector<std::unique_ptr<HexahedronTree>> trees_;
  std::unique_ptr<physics::NarrowphaseContacts> contacts_;
  std::unique_ptr<DynamicsWorld> world_;
  std::uint64_t solves_ = 0, unconverged_ = 0, contradictory_ = 0, spent_ = 0, failed_ = 0;
  std::uint32_t most_newton_steps_ = 0;
  std::vector<Logged> log_;
  std::vector<Push> pushes_;
};

}  // namespace

std::unique_ptr<BoxEngine> make_own(const BoxScene& scene, double work) {
  return std::make_unique<Own>(scene, work);
}

}  // namespace touchstone::benchmarks
