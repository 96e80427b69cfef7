#include <benchmark/benchmark.h>
#include <time.h>

#include <array>
#include <cmath>
#include <random>

#include "contact_core/registry.hpp"
#ifdef TOUCHSTONE_BENCHMARK_BULLET
#include "adapters/bullet/bullet.hpp"
#endif
#ifdef TOUCHSTONE_BENCHMARK_ODE
#include "adapters/ode/ode.hpp"
#endif

// One frame of a broadphase: update() with every object moved, then all of find_pairs().

namespace touchstone {
namespace {

struct Mix {
  double spacing = 1.7;     // [m]; 1.7 gives a box about five candidate partners
  double decades = 0.0;     // sizes are scaled by 10^0 down to 10^-decades
  double stationary = 0.0;  // share of objects that never move
  int solids = 1;           // an object, side by side
};

// Boxes with sides of 0.5 to 1.5 m.
struct MovingBoxes {
  std::vector<HexahedronTree> trees;
  std::vector<const HexahedronTree*> pointers;
  std::vector<Pose> poses;
  std::vector<Vector3> velocities;  // one an object, like moved
  std::vector<std::uint32_t> moved;
  int solids;
  int frame = 0;

  MovingBoxes(int count, const Mix& mix) {
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> side(0.5, 1.5);
    std::uniform_real_distribution<double> place(-0.5, 0.5);
    std::normal_distribution<double> normal;
    const double extent = mix.spacing * std::cbrt(count);
    for (int i = 0; i < count; ++i) {
      const double scale = std::pow(10.0, -mix.decades * (place(random) + 0.5));
      const double x = scale * side(random), y = scale * side(random), z = scale * side(random);
      std::vector<PlacedHexahedron> placed;
      for (int part = 0; part < mix.solids; ++part)
        placed.push_back({"", Hexahedron::from_size({x, y, z}), {Matrix3::Identity(), {part * x, 0, 0}}});
      trees.emplace_back(std::move(placed));
      Pose X;
      X.R = rotation_from_quaternion(normal(random), normal(random), normal(random), normal(random));
      X.p = extent * Vector3(place(random), place(random), place(random));
      poses.resize(poses.size() + mix.solids);
      find_global_positions(trees.back(), X, std::span(poses).last(mix.solids));
      if (place(random) + 0.5 >= mix.stationary) moved.push_back(static_cast<std::uint32_t>(i));
      velocities.push_back(0.02 * Vector3(place(random), place(random), place(random)));
    }
    solids = mix.solids;
    for (const HexahedronTree& tree : trees) pointers.push_back(&tree);
  }

  // To and fro, so that the density stays however many frames are run.
  void step() {
    const double sign = frame++ / 16 % 2 == 0 ? 1.0 : -1.0;
    for (std::uint32_t object : moved)
      for (int part = 0; part < solids; ++part) poses[object * solids + part].p += sign * velocities[object];
  }
};

// This thread's, so that other work on the machine counts little.
double cpu_seconds() {
  timespec t;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

void run_frames(benchmark::State& state, const std::string& name, const Mix& mix) {
  MovingBoxes boxes(static_cast<int>(state.range(0)), mix);
  BackendRegistry registry;
  register_core(registry);
#ifdef TOUCHSTONE_BENCHMARK_BULLET
  register_bullet(registry);
#endif
#ifdef TOUCHSTONE_BENCHMARK_ODE
  register_ode(registry);
#endif
  const auto broadphase = registry.make_broadphase(name);
  broadphase->build({boxes.pointers, 0.0});
  std::array<SolidPair, 4096> block;
  std::size_t pairs = 0;
  double least_update = INFINITY, least_find = INFINITY;
  broadphase->update(boxes.poses, boxes.moved);  // the first frame sets up and is not counted
  for (PairCursor cursor; !cursor.done;) broadphase->find_pairs(cursor, block);
  while (state.KeepRunning()) {
    boxes.step();
    const double start = cpu_seconds();
    broadphase->update(boxes.poses, boxes.moved);
    const double middle = cpu_seconds();
    pairs = 0;
    for (PairCursor cursor; !cursor.done;) pairs += broadphase->find_pairs(cursor, block);
    least_update = std::min(least_update, middle - start);
    least_find = std::min(least_find, cpu_seconds() - middle);
    benchmark::DoNotOptimize(pairs);
  }
  state.counters["update_min_ms"] = 1e3 * least_update;
  state.counters["find_min_ms"] = 1e3 * least_find;
  state.counters["partners"] = 2.0 * static_cast<double>(pairs) / static_cast<double>(boxes.poses.size());
}

void register_runs(const std::string& backend, std::int64_t largest) {
  const std::pair<const char*, Mix> mixes[] = {{"even", {}},
                                               {"sparse", {.spacing = 3.4}},
                                               {"dense", {.spacing = 1.1}},
                                               {"two_decades", {.spacing = 1.1, .decades = 2.0}},
                                               {"nine_tenths_static", {.stationary = 0.9}},
                                               {"four_solids", {.spacing = 3.4, .solids = 4}}};
  for (const auto& [label, mix] : mixes)
    for (std::int64_t count = 1000; count <= largest; count *= 10)
      benchmark::RegisterBenchmark(
          (backend + "/" + label).c_str(),
          [backend, mix = mix](benchmark::State& state) { run_frames(state, backend, mix); })
          ->Arg(count)
          ->Unit(benchmark::kMillisecond);
}

}  // namespace
}  // namespace touchstone

int main(int argc, char** argv) {
  touchstone::register_runs("native", 1000000);
#ifdef TOUCHSTONE_BENCHMARK_BULLET
  touchstone::register_runs("bullet", 1000000);
#endif
#ifdef TOUCHSTONE_BENCHMARK_ODE
  touchstone::register_runs("ode", 100000);
#endif
  touchstone::register_runs("brute_force", 1000);
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  benchmark::RunSpecifiedBenchmarks();
}
