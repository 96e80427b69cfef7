#include <benchmark/benchmark.h>

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <iostream>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "touchstone/adapters/all/all_backends.hpp"
#include "touchstone/contact_core/threads/processor_time.hpp"
#include "touchstone/examples/measures/common/quantiles.hpp"
#include "touchstone/tests/benchmarks/motion/arm_floor.hpp"
#include "touchstone/tests/support/counting_allocator.hpp"

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
//
// Beside each sliding row, what a part of its frames costs alone (arm_floor.hpp): native_told, a world that
// is commanded to where the flight went and has to prove that motion only (`least_` are of the frames in
// which it needs no sub-step, `steps` of all); sweeps_NAME, the engines' own sweeps of the same frames'
// pairs, from where the arm was to its command. `pairs` are the sweeps of a frame, `meets` the share of
// frames in which one meets something.

namespace touchstone {
namespace {

constexpr int kFlights = 5;

/// Flies the same again, and keeps the lesser time of each frame.
void fly_again(const ArmCase& wanted, std::vector<double>& times) {
  ArmFlight flight(wanted);
  for (int i = 0; i < flight.frames_until_settled(); ++i) flight.step();
  for (double& time : times) {
    const double start = processor_us();
    flight.step();
    time = std::min(time, processor_us() - start);
  }
}

/// Of each frame's least time.
void set_least(benchmark::State& state, const std::vector<double>& us) {
  const measures::StepTimes least = measures::step_times(us);
  state.counters["least_median_us"] = least.median_us;
  state.counters["least_p999_us"] = least.p999_us;
}

void fly(benchmark::State& state, const ArmCase& wanted) {
  // Frames are timed once the arm slides steadily.
  ArmFlight flight(wanted);
  for (int i = 0; i < flight.frames_until_settled(); ++i) flight.step();
  std::vector<double> times;
  times.reserve(static_cast<std::size_t>(state.max_iterations));
  double pairs = 0, calls = 0, steps = 0, limits = 0, behind = 0;
  const std::size_t allocations = allocation_count();
  while (state.KeepRunning()) {
    const double start = processor_us();
    const FrameReport report = flight.step();
    times.push_back(processor_us() - start);
    pairs += report.candidate_pairs, calls += static_cast<double>(report.queries),
        steps += report.slide_steps;
    limits += report.iteration_limits;
    behind += flight.behind();
  }
  const double allocated = static_cast<double>(allocation_count() - allocations);
  // The least time of each frame, where the same flight is flown again.
  std::vector<double> least = times;
  for (int i = 1; i < kFlights && wanted.backend == "native"; ++i) fly_again(wanted, least);
  // Figures of the row.
  const double frames = static_cast<double>(times.size());
  const measures::StepTimes once = measures::step_times(times);
  state.counters["median_us"] = once.median_us;
  state.counters["p999_us"] = once.p999_us;
  if (wanted.backend == "native") set_least(state, least);
  state.counters["worst_us"] = once.worst_us;
  state.counters["of_150ms"] = once.worst_us / 150e3;
  state.counters["of_1ms"] = once.worst_us / 1e3;
  state.counters["allocations"] = allocated;
  state.counters["pairs"] = pairs / frames;
  state.counters["calls"] = calls / frames;
  state.counters["steps"] = steps / frames;
  state.counters["limits"] = limits;
  state.counters["behind"] = behind / frames;
}

void register_run(const ArmCase& wanted, const std::string& label, int frames) {
  const std::string name =
      wanted.backend + "/" + label + "/" + std::to_string(static_cast<int>(wanted.rate)) + "_Hz";
  benchmark::RegisterBenchmark(name.c_str(), [wanted](benchmark::State& state) { fly(state, wanted); })
      ->Iterations(frames)
      ->Unit(benchmark::kMicrosecond);
}

/// The row counts a flight's frames as its iterations; all are timed within the first.
template <class Measure>
void register_floor_run(const std::string& what, const ArmCase& wanted, const std::string& label,
                        Measure measure) {
  constexpr std::size_t kFrames = 1000;
  const std::string name = what + "/" + label + "/" + std::to_string(static_cast<int>(wanted.rate)) + "_Hz";
  benchmark::RegisterBenchmark(name.c_str(), [=](benchmark::State& state) {
    measure(state, fly_and_note(wanted, kFrames));
    while (state.KeepRunning()) {
    }
  })->Iterations(kFrames);
}

/// What parts of a sliding row's frames cost alone.
void register_floor(const ArmCase& wanted, const std::string& label) {
  register_floor_run("native_told", wanted, label, [=](benchmark::State& state, const auto& flown) {
    const ToldFrames told = fly_as_told(wanted, flown, kFlights);
    set_least(state, told.us);
    state.counters["calls"] = told.queries;
    state.counters["steps"] = told.steps;
  });
  for (const SweepEntry& entry : all_sweeps()) {
    if (entry.make()->most_turn() == 0.0) continue;  // it turns nothing
    const std::string what = "sweeps_" + entry.name;
    register_floor_run(what, wanted, label, [=](benchmark::State& state, const auto& flown) {
      const SweptFrames swept = sweep(wanted, flown, entry);
      set_least(state, swept.us);
      state.counters["pairs"] = swept.sweeps;
      state.counters["meets"] = swept.meetings;
    });
  }
}

void register_runs(const std::string& backend, int frames) {
  const std::pair<const char*, ArmPhase> phases[] = {
      {"free", ArmPhase::free}, {"near", ArmPhase::near}, {"sliding", ArmPhase::sliding}};
  for (const double rate : {10.0, 1000.0})
    for (const auto& [label, phase] : phases) {
      const ArmCase wanted{backend, phase, rate};
      register_run(wanted, label, phase == ArmPhase::sliding ? std::min(frames, 1000) : frames);
      if (phase == ArmPhase::sliding && backend == "native") register_floor(wanted, label);
    }
}

void register_drawn_run(std::uint64_t seed) {
  const std::string label = "sliding_" + std::to_string(seed);
  for (const double rate : {10.0, 1000.0}) {
    const ArmCase wanted{"native", ArmPhase::sliding, rate, seed};
    register_run(wanted, label, 1000);
    register_floor(wanted, label);
  }
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
