#include "touchstone/tests/benchmarks/motion/arm_flight.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "touchstone/adapters/all/all_backends.hpp"
#include "touchstone/contact_core/mechanism/arms/ssrms.hpp"
#include "touchstone/contact_core/registry.hpp"

namespace touchstone {
namespace {

constexpr int kTiles = 20;
constexpr int kOthers = 100;

}  // namespace

double Swing::at(double time) const {
  const double turns = 2 * std::numbers::pi / period;
  return rate / turns * (std::sin(turns * time + phase) - std::sin(phase));
}

ArmFlight::ArmFlight(const ArmCase& wanted)
    : case_(wanted), drawing_(wanted.seed), arm_(std::make_shared<const Mechanism>(make_ssrms())) {
  choose_motion();
  BackendRegistry registry;
  register_all_backends(registry);
  world_ = std::make_unique<ContactWorld>(registry.make_narrowphase(case_.backend),
                                          registry.make_broadphase("native"), 1e-9);
  PairRule slide;
  slide.policy = ContactPolicy::slide;
  world_->set_default_rule(slide);
  handle_ = world_->add_mechanism({arm_, {}, start_});
  const double below = case_.phase == ArmPhase::free ? 1.5 : 0.05;
  add_floor(lowest_point() - below);
  add_others();
  joints_ = start_;
  world_->prepare();
}

FrameReport ArmFlight::step() {
  ++frame_;
  const double time = frame_ / case_.rate;
  for (std::size_t k = 0; k < joints_.size(); ++k) joints_[k] = start_[k] + swings_[k].at(time);
  // Pressed down after three seconds.
  if (case_.phase == ArmPhase::sliding) joints_[2] += std::min(1.0, time / 3.0) * press_;
  return step_to(joints_);
}

FrameReport ArmFlight::step_to(std::span<const double> joints) {
  const JointCommand command{handle_, joints};
  return world_->frame({}, {&command, 1});
}

double ArmFlight::behind() const {
  double sum = 0.0;
  for (std::size_t k = 0; k < joints_.size(); ++k)
    sum += (joints_[k] - actual()[k]) * (joints_[k] - actual()[k]);
  return std::sqrt(sum);
}

void ArmFlight::choose_motion() {
  constexpr double kRate = 4 * kDegree;
  swings_[1].rate = swings_[6].rate = kRate;
  if (case_.phase == ArmPhase::free)
    for (const std::size_t k : {0, 2, 3, 4, 5}) swings_[k].rate = (k % 2 ? 0.3 : -0.3) * kRate;
  if (case_.seed == 0) return;
  for (Swing& swing : swings_)
    swing = {drawing_.real(-kRate, kRate), drawing_.real(4.0, 20.0),
             drawing_.real(0.0, 2 * std::numbers::pi)};
  // Shoulder and elbow would lift it by far.
  for (const std::size_t k : {2, 3, 4}) swings_[k].rate *= 0.02;
  press_ = drawing_.real(0.3, 1.0) * kDegree;
}

double ArmFlight::lowest_point() const {
  std::vector<Pose> X_WL(arm_->links().size());
  arm_->link_poses({}, start_, X_WL);
  double lowest = 1e9;
  for (std::uint32_t solid = 0; solid < arm_->solids().size(); ++solid) {
    const std::uint32_t link = arm_->link_of(solid);
    if (link != arm_->find_link("tip_lee")) continue;
    const Pose X = compose(X_WL[link], arm_->placed(solid).X_OS);
    for (const Vector3& v : arm_->solids()[solid].vertices()) lowest = std::min(lowest, transform(X, v).z());
  }
  return lowest;
}

void ArmFlight::add_floor(double top) {
  for (int i = 0; i < kTiles; ++i)
    for (int j = 0; j < kTiles; ++j) {
      Pose X;
      const double lower = case_.seed == 0 ? 0.0 : drawing_.real(0.0, 0.002);
      X.p = {3.5 + i, j - 9.5, top - 0.15 - lower};
      add("tile " + std::to_string(i) + " " + std::to_string(j), {1, 1, 0.3}, X);
    }
}

// Above and around, at least 2 m from where the arm comes.
void ArmFlight::add_others() {
  Drawing drawing(1);
  const auto real = [&](double low, double high) { return drawing.real(low, high); };
  for (int i = 0; i < kOthers; ++i) {
    Pose X;
    X.p = {real(-5, 25), real(-15, 15), real(9, 14)};
    X.R = rotation_about(Vector3::UnitX(), real(-3, 3));
    add("box " + std::to_string(i), {real(0.3, 1.5), real(0.3, 1.5), real(0.3, 1.5)}, X);
  }
}

void ArmFlight::add(const std::string& name, const Vector3& size, const Pose& X_WS) {
  blocks_.push_back({Hexahedron::from_size(size), X_WS});
  const std::vector<PlacedHexahedron> solids{{"box", blocks_.back().solid, Pose{}}};
  world_->add({std::make_shared<const HexahedronTree>(solids, name), X_WS, true});
}

}  // namespace touchstone
