#include <benchmark/benchmark.h>

#include <array>
#include <cmath>
#include <numeric>
#include <random>

#include "contact_core/registry.hpp"

// One frame of a broadphase: update() with every object moved, then all of find_pairs().

namespace touchstone {
namespace {

// Boxes with sides of 0.5 to 1.5 m, at a density that gives each about five candidate partners.
struct MovingBoxes {
  std::vector<HexahedronTree> trees;
  std::vector<const HexahedronTree*> pointers;
  std::vector<Pose> poses;
  std::vector<Vector3> velocities;

  explicit MovingBoxes(int count) {
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> side(0.5, 1.5);
    std::uniform_real_distribution<double> place(-0.5, 0.5);
    std::normal_distribution<double> normal;
    const double extent = 1.7 * std::cbrt(count);
    for (int i = 0; i < count; ++i) {
      const double x = side(random), y = side(random), z = side(random);
      trees.push_back(HexahedronTree({{"", Hexahedron::from_size({x, y, z}), {}}}));
      Pose X;
      X.R = rotation_from_quaternion(normal(random), normal(random), normal(random), normal(random));
      X.p = extent * Vector3(place(random), place(random), place(random));
      poses.push_back(X);
      velocities.push_back(0.02 * Vector3(place(random), place(random), place(random)));
    }
    for (const HexahedronTree& tree : trees) pointers.push_back(&tree);
  }

  void step() {
    for (std::size_t i = 0; i < poses.size(); ++i) poses[i].p += velocities[i];
  }
};

void run_frames(benchmark::State& state, const char* name) {
  MovingBoxes boxes(static_cast<int>(state.range(0)));
  BackendRegistry registry;
  register_core(registry);
  const auto broadphase = registry.make_broadphase(name);
  broadphase->build({boxes.pointers, 0.0});
  std::vector<std::uint32_t> moved(boxes.poses.size());
  std::iota(moved.begin(), moved.end(), 0u);
  std::array<SolidPair, 4096> block;
  std::size_t pairs = 0;
  for (auto _ : state) {
    boxes.step();
    broadphase->update(boxes.poses, moved);
    pairs = 0;
    for (PairCursor cursor; !cursor.done;) pairs += broadphase->find_pairs(cursor, block);
    benchmark::DoNotOptimize(pairs);
  }
  state.counters["partners"] = 2.0 * static_cast<double>(pairs) / static_cast<double>(boxes.poses.size());
}

BENCHMARK_CAPTURE(run_frames, native, "native")
    ->Arg(1000)
    ->Arg(10000)
    ->Arg(100000)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(run_frames, brute_force, "brute_force")
    ->Arg(1000)
    ->Arg(10000)
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace touchstone
