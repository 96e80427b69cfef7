#include <benchmark/benchmark.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <iostream>
#include <numbers>
#include <random>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "touchstone/adapters/all/all_backends.hpp"
#include "touchstone/contact_core/mechanism/arms/ssrms.hpp"
#include "touchstone/contact_core/registry.hpp"
#include "touchstone/contact_core/threads/processor_time.hpp"
#include "touchstone/contact_core/world/contact_world.hpp"
#include "touchstone/tests/support/counting_allocator.hpp"
#include "touchstone/tests/support/degree.hpp"

// One frame of a contact world: the SSRMS-type arm (47 hexahedra) in a scene of 500, policy slide. Rows are
// backend/phase/frames a second; the arm's joints go at up to 4 deg/s. Phases:
//   free     no part within 1 m of the scene
//   near     the end effector sweeps 5 cm above a floor of abutting tiles
//   sliding  it is pressed against the floor and sweeps on, across the seams
// Counters are of this thread's time of a frame: median, 99.9th percentile and worst [us], the worst as a
// share of budgets of 150 ms and 1 ms, allocations of all frames, and per frame pairs examined, narrowphase
// calls and sub-steps of slides. A flight is the same each time: `least_` are of each frame's least time in
// five flights, which others on the machine do not show in.
//
// arm_step_benchmark [SEED ...] --benchmark_...: rows backend/sliding_SEED/frames a second, too, of motions
// drawn from a seed: pressed by up to 1 deg, all joints to and fro at periods and rates of their own, over
// tiles at heights that differ by up to 2 mm. `behind` is how far the joints are from their command at the
// end of a frame, on average [rad].

namespace touchstone {
namespace {

constexpr int kTiles = 20;
constexpr int kOthers = 100;

enum class Phase { free, near, sliding };

struct Case {
  std::string backend;
  Phase phase;
  double rate;             // [frames a second]
  std::uint64_t seed = 0;  // of a drawn motion; 0: the one above
};

/// Numbers that are the same with every standard library.
class Drawing {
 public:
  explicit Drawing(std::uint64_t seed) : random_(seed) {}
  double real(double low, double high) {
    return low + (high - low) * (static_cast<double>(random_() >> 11) * 0x1p-53);
  }

 private:
  std::mt19937_64 random_;
};

/// To and fro, never faster than `rate`.
struct Swing {
  double rate = 0.0, period = 20.0, phase = 0.0;  // [rad/s], [s], [rad]

  double at(double time) const {
    const double turns = 2 * std::numbers::pi / period;
    return rate / turns * (std::sin(turns * time + phase) - std::sin(phase));
  }
};

BackendRegistry make_registry() {
  BackendRegistry registry;
  register_all_backends(registry);
  return registry;
}

std::shared_ptr<const HexahedronTree> box(const std::string& name, const Vector3& size) {
  return std::make_shared<const HexahedronTree>(
      std::vector<PlacedHexahedron>{{"box", Hexahedron::from_size(size), Pose{}}}, name);
}

/// The arm over its scene: shoulder up, elbow down, end effector level, reaching out along x.
class Flight {
 public:
  explicit Flight(const Case& wanted)
      : case_(wanted), drawing_(wanted.seed), arm_(std::make_shared<const Mechanism>(make_ssrms())) {
    choose_motion();
    const BackendRegistry registry = make_registry();
    world_ = std::make_unique<ContactWorld>(registry.make_narrowphase(case_.backend),
                                            registry.make_broadphase("native"), 1e-9);
    PairRule slide;
    slide.policy = ContactPolicy::slide;
    world_->set_default_rule(slide);
    handle_ = world_->add_mechanism({arm_, {}, start_});
    const double below = case_.phase == Phase::free ? 1.5 : 0.05;
    add_floor(lowest_point() - below);
    add_others();
    joints_ = start_;
    world_->prepare();
  }

  FrameReport step() {
    ++frame_;
    const double time = frame_ / case_.rate;
    for (std::size_t k = 0; k < joints_.size(); ++k) joints_[k] = start_[k] + swings_[k].at(time);
    // Pressed down after three seconds.
    if (case_.phase == Phase::sliding) joints_[2] += std::min(1.0, time / 3.0) * press_;
    const JointCommand command{handle_, joints_};
    return world_->frame({}, {&command, 1});
  }

  int frames_until_settled() const { return static_cast<int>(4 * case_.rate); }

  /// How far the joints are from their command [rad].
  double behind() const {
    double sum = 0.0;
    const std::span<const double> actual = world_->joint_values(handle_);
    for (std::size_t k = 0; k < joints_.size(); ++k)
      sum += (joints_[k] - actual[k]) * (joints_[k] - actual[k]);
    return std::sqrt(sum);
  }

 private:
  void choose_motion() {
    constexpr double kRate = 4 * kDegree;
    swings_[1].rate = swings_[6].rate = kRate;
    if (case_.phase == Phase::free)
      for (const std::size_t k : {0, 2, 3, 4, 5}) swings_[k].rate = (k % 2 ? 0.3 : -0.3) * kRate;
    if (case_.seed == 0) return;
    for (Swing& swing : swings_)
      swing = {drawing_.real(-kRate, kRate), drawing_.real(4.0, 20.0),
               drawing_.real(0.0, 2 * std::numbers::pi)};
    // Shoulder and elbow would lift it by far.
    for (const std::size_t k : {2, 3, 4}) swings_[k].rate *= 0.02;
    press_ = drawing_.real(0.3, 1.0) * kDegree;
  }

  double lowest_point() const {
    std::vector<Pose> X_WL(arm_->links().size());
    arm_->link_poses({}, start_, X_WL);
    double lowest = 1e9;
    for (std::uint32_t solid = 0; solid < arm_->solids().size(); ++solid) {
      const std::uint32_t link = arm_->link_of(solid);
      if (link != arm_->find_link("tip_lee")) continue;
      const Pose X = compose(X_WL[link], arm_->placed(solid).X_OS);
      for (const Vector3& v : arm_->solids()[solid].vertices())
        lowest = std::min(lowest, transform(X, v).z());
    }
    return lowest;
  }

  void add_floor(double top) {
    for (int i = 0; i < kTiles; ++i)
      for (int j = 0; j < kTiles; ++j) {
        Pose X;
        const double lower = case_.seed == 0 ? 0.0 : drawing_.real(0.0, 0.002);
        X.p = {3.5 + i, j - 9.5, top - 0.15 - lower};
        world_->add({box("tile " + std::to_string(i) + " " + std::to_string(j), {1, 1, 0.3}), X, true});
      }
  }

  // Above and around, at least 2 m from where the arm comes.
  void add_others() {
    Drawing drawing(1);
    const auto real = [&](double low, double high) { return drawing.real(low, high); };
    for (int i = 0; i < kOthers; ++i) {
      Pose X;
      X.p = {real(-5, 25), real(-15, 15), real(9, 14)};
      X.R = rotation_about(Vector3::UnitX(), real(-3, 3));
      world_->add(
          {box("box " + std::to_string(i), {real(0.3, 1.5), real(0.3, 1.5), real(0.3, 1.5)}), X, true});
    }
  }

  Case case_;
  Drawing drawing_;
  std::array<Swing, 7> swings_;
  double press_ = 0.6 * kDegree;
  std::shared_ptr<const Mechanism> arm_;
  std::vector<double> start_ = {0, 0, -30 * kDegree, 60 * kDegree, -30 * kDegree, 0, 0}, joints_;
  std::unique_ptr<ContactWorld> world_;
  MechanismHandle handle_;
  int frame_ = 0;
};

constexpr int kFlights = 5;

/// Flies the same again, and keeps the lesser time of each frame.
void fly_again(const Case& wanted, std::vector<double>& times) {
  Flight flight(wanted);
  for (int i = 0; i < flight.frames_until_settled(); ++i) flight.step();
  for (double& time : times) {
    const double start = 1e-6 * processor_us();
    flight.step();
    time = std::min(time, 1e-6 * processor_us() - start);
  }
}

/// @param times sorted.
double at_share(const std::vector<double>& times, double share) {
  return times[std::min(times.size() - 1,
                        static_cast<std::size_t>(share * static_cast<double>(times.size())))];
}

void fly(benchmark::State& state, const Case& wanted) {
  // Frames are timed once the arm slides steadily.
  Flight flight(wanted);
  for (int i = 0; i < flight.frames_until_settled(); ++i) flight.step();
  std::vector<double> times;
  times.reserve(static_cast<std::size_t>(state.max_iterations));
  double pairs = 0, calls = 0, steps = 0, limits = 0, behind = 0;
  const std::size_t allocations = allocation_count();
  while (state.KeepRunning()) {
    const double start = 1e-6 * processor_us();
    const FrameReport report = flight.step();
    times.push_back(1e-6 * processor_us() - start);
    pairs += report.candidate_pairs, calls += static_cast<double>(report.queries),
        steps += report.slide_steps;
    limits += report.iteration_limits;
    behind += flight.behind();
  }
  const double allocated = static_cast<double>(allocation_count() - allocations);
  // The least time of each frame, where the same flight is flown again.
  std::vector<double> least = times;
  for (int i = 1; i < kFlights && wanted.backend == "native"; ++i) fly_again(wanted, least);
  std::sort(times.begin(), times.end()), std::sort(least.begin(), least.end());
  // Figures of the row.
  const double frames = static_cast<double>(times.size());
  state.counters["median_us"] = 1e6 * at_share(times, 0.5);
  state.counters["p999_us"] = 1e6 * at_share(times, 0.999);
  if (wanted.backend == "native") {
    state.counters["least_median_us"] = 1e6 * at_share(least, 0.5);
    state.counters["least_p999_us"] = 1e6 * at_share(least, 0.999);
  }
  state.counters["worst_us"] = 1e6 * times.back();
  state.counters["of_150ms"] = times.back() / 0.150;
  state.counters["of_1ms"] = times.back() / 0.001;
  state.counters["allocations"] = allocated;
  state.counters["pairs"] = pairs / frames;
  state.counters["calls"] = calls / frames;
  state.counters["steps"] = steps / frames;
  state.counters["limits"] = limits;
  state.counters["behind"] = behind / frames;
}

void register_run(const Case& wanted, const std::string& label, int frames) {
  const std::string name =
      wanted.backend + "/" + label + "/" + std::to_string(static_cast<int>(wanted.rate)) + "_Hz";
  benchmark::RegisterBenchmark(name.c_str(), [wanted](benchmark::State& state) { fly(state, wanted); })
      ->Iterations(frames)
      ->Unit(benchmark::kMicrosecond);
}

void register_runs(const std::string& backend, int frames) {
  const std::pair<const char*, Phase> phases[] = {
      {"free", Phase::free}, {"near", Phase::near}, {"sliding", Phase::sliding}};
  for (const double rate : {10.0, 1000.0})
    for (const auto& [label, phase] : phases)
      register_run({backend, phase, rate}, label, phase == Phase::sliding ? std::min(frames, 1000) : frames);
}

void register_drawn_run(std::uint64_t seed) {
  for (const double rate : {10.0, 1000.0})
    register_run({"native", Phase::sliding, rate, seed}, "sliding_" + std::to_string(seed), 1000);
}

/// The arguments that Benchmark left are seeds. @returns false where one is not a seed.
bool take_seeds(int argc, char** argv) {
  for (const std::string_view word : std::span(argv, static_cast<std::size_t>(argc)).subspan(1)) {
    std::uint64_t seed = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), seed);
    if (error != std::errc{} || end != word.data() + word.size() || seed == 0) {
      std::cerr << "arm_step_benchmark: '" << word << "' is no seed from 1 on\n";
      return false;
    }
    register_drawn_run(seed);
  }
  return true;
}

}  // namespace
}  // namespace touchstone

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  for (const auto& [backend, frames] : {std::pair{"native", 5000}, {"bullet", 1000}, {"exact", 500}})
    if (touchstone::has_backend(backend)) touchstone::register_runs(backend, frames);
  if (!touchstone::take_seeds(argc, argv)) return 1;
  benchmark::RunSpecifiedBenchmarks();
}
