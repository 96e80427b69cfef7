#include "touchstone/tests/benchmarks/pairs/world_costs.hpp"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <fstream>

#include "touchstone/adapters/all/all_backends.hpp"
#include "touchstone/contact_core/registry.hpp"
#include "touchstone/contact_core/threads/processor_time.hpp"
#ifdef TOUCHSTONE_COSTS_IN_ENGINES
#include "touchstone/examples/engine_check/world.hpp"
#endif
#include "touchstone/tests/benchmarks/pairs/broadphase_frame.hpp"

namespace touchstone {
namespace {

constexpr int kBoxes = 100000;
constexpr int kFrames = 12;
constexpr int kChanges = 2000;

/// The least time of a frame, the first one aside [ms].
double frame_ms(int count, const Mix& mix) {
  BroadphaseFrame frame("native", count, mix);
  double least = INFINITY;
  for (int i = 0; i <= kFrames; ++i) {
    frame.step();
    const double start = frame_seconds(mix);
    frame.update(), frame.find();
    if (i > 0) least = std::min(least, 1e3 * (frame_seconds(mix) - start));
  }
  return least;
}

/// The costliest of the frames in which one in a hundred moves, after ones in which all did: each the least
/// of some turns [ms].
double few_after_many_ms() {
  constexpr int kTurns = 3, kFew = 24;
  const Mix mix{.moved_pairs = true};
  BroadphaseFrame frame("native", kBoxes, mix);
  const std::vector<std::uint32_t> all = frame.boxes.moved;
  std::array<double, kFew> least;
  least.fill(INFINITY);
  for (int turn = 0; turn < kTurns; ++turn) {
    frame.boxes.moved = all;
    for (int i = 0; i < 2; ++i) frame.step(), frame.update(), frame.find();
    for (std::uint32_t i = 0; i < kFew; ++i) {
      std::erase_if(frame.boxes.moved = all, [i](std::uint32_t object) { return object % 100 != i; });
      frame.step();
      const double start = frame_seconds(mix);
      frame.update(), frame.find();
      least[i] = std::min(least[i], 1e3 * (frame_seconds(mix) - start));
    }
  }
  return *std::max_element(least.begin(), least.end());
}

/// How long two threads take for a frame's pairs, of what one does, by the clock.
double share_of_two_threads() {
  BroadphaseFrame frame("native", kBoxes, {.by_place = true, .manifold = true, .contacts = true});
  frame.step(), frame.update(), frame.find();
  const std::span<const SolidPair> pairs = frame.listed;
  const std::size_t slots = static_cast<std::size_t>(kMaxManifoldPoints);
  std::vector<PairStatus> status(pairs.size());
  std::vector<PairGeometry> geometry(pairs.size());
  std::vector<ContactPoint> points(pairs.size() * slots);
  Query query{QueryKind::manifold, 0.0};
  const auto seconds = [&](std::size_t threads) {
    ThreadTeam team(threads);
    std::vector<std::unique_ptr<Narrowphase::Workspace>> workspaces;
    for (std::size_t i = 0; i < threads; ++i) workspaces.push_back(frame.narrowphase->make_workspace());
    double least = INFINITY;
    for (int i = 0; i < kFrames; ++i) {
      auto part = [&](std::size_t task) {
        const std::size_t first = pairs.size() * task / threads,
                          count = pairs.size() * (task + 1) / threads - first;
        frame.narrowphase->evaluate({pairs.subspan(first, count), frame.boxes.poses, query},
                                    {std::span(status).subspan(first), std::span(geometry).subspan(first),
                                     std::span(points).subspan(first * slots)},
                                    *workspaces[task]);
      };
      const auto start = std::chrono::steady_clock::now();
      run_tasks(threads > 1 ? &team : nullptr, threads, part);
      least =
          std::min(least, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
    }
    return least;
  };
  const double one = seconds(1);
  return seconds(2) / one;
}

/// Memory that this process has touched [kB]; reserved addresses do not count.
double resident_kb() {
  std::ifstream statm("/proc/self/statm");
  double size = 0.0, resident = 0.0;
  statm >> size >> resident;
  return 1e-3 * resident * static_cast<double>(sysconf(_SC_PAGESIZE));
}

/// Broadphase and narrowphase over boxes of one object each.
struct Scene {
  MovingBoxes boxes{kBoxes, {}};
  std::vector<Hexahedron> solids = boxes.all_solids();
  BackendRegistry registry;
  std::unique_ptr<Broadphase> broadphase;
  std::unique_ptr<Narrowphase> narrowphase;

  Scene() { register_all_backends(registry); }
};

void add_build(std::vector<WorldCost>& out) {
  Scene scene;
  const double before = resident_kb();
  const double start = processor_us();
  scene.narrowphase = scene.registry.make_narrowphase("native");
  scene.narrowphase->build(scene.solids);
  const double narrow = resident_kb();
  scene.broadphase = scene.registry.make_broadphase("native");
  scene.broadphase->build({scene.boxes.pointers});
  scene.broadphase->update(scene.boxes.poses, {});
  out.push_back({"build of 100 000 boxes with the first update", 1e-6 * (processor_us() - start), 0.1, "s",
                 "the first update sorts all"});
  out.push_back(
      {"memory a box, narrowphase", (narrow - before) / kBoxes, 0.3, "kB", "records of every kind"});
  out.push_back({"memory a box, with the broadphase after an update", (resident_kb() - before) / kBoxes, 0.8,
                 "kB", "trees, sorted copies and pairs"});

  // One box goes and comes back.
  std::vector<double> costs;
  std::vector<std::uint32_t> moved(1);
  for (int i = 0; i < kChanges; ++i) {
    const auto object = static_cast<std::uint32_t>(i * 47 % kBoxes);
    moved[0] = object;
    const double from = processor_us();
    scene.broadphase->set_object(object, nullptr, false);
    scene.broadphase->update(scene.boxes.poses, {});
    scene.narrowphase->set_solids(object, std::span(scene.solids).subspan(object, 1));
    scene.broadphase->set_object(object, scene.boxes.pointers[object], false);
    scene.broadphase->update(scene.boxes.poses, moved);
    costs.push_back(processor_us() - from);
  }
  std::nth_element(costs.begin(), costs.begin() + kChanges / 2, costs.end());
  out.push_back({"a box of 100 000 removed and added, with an update after each, median", costs[kChanges / 2],
                 5, "us", "both updates put the box into the tree and out of it"});
}

#ifdef TOUCHSTONE_COSTS_IN_ENGINES
using Run = engine_check::Outcome (*)(const engine_check::World&, engine_check::Check, PairObserver*);

/// Our check's time over the engine's own in a step, each the median of the steps and the least of some runs.
double over_own(Run run, const engine_check::World& world) {
  double least[2] = {INFINITY, INFINITY};
  for (int i = 0; i < 3; ++i) {
    least[0] = std::min(least[0], run(world, engine_check::Check::native, nullptr).check_us);
    least[1] = std::min(least[1], run(world, engine_check::Check::engine, nullptr).check_us);
  }
  return least[0] / least[1];
}

void add_engine(const std::string& engine, Run run, bool has_hulls, std::vector<WorldCost>& out) {
  constexpr const char* kOurs =
      "of 590 ns a pair 100 to 140 find and certify class and depth, 90 to 100 clip; the engine keeps no "
      "bound";
  out.push_back({"check inside " + engine + " over its own, a stack of boxes",
                 over_own(run, engine_check::stack(10, false)), 1.2, "times", kOurs});
  out.push_back({"a wall of boxes", over_own(run, engine_check::wall(6, false)), 1.2, "times", kOurs});
  if (!has_hulls) return;
  out.push_back({"a stack of boxes as hulls", over_own(run, engine_check::stack(10, true)), 0.333, "times",
                 "the engine keeps its manifolds from step to step"});
}
#endif

void add_engines([[maybe_unused]] std::vector<WorldCost>& out) {
#ifdef TOUCHSTONE_ENGINE_CHECK_BULLET
  add_engine("Bullet", engine_check::run_bullet, true, out);
#endif
#ifdef TOUCHSTONE_ENGINE_CHECK_ODE
  add_engine("ODE", engine_check::run_ode, false, out);  // whose hulls fall
#endif
#ifdef TOUCHSTONE_ENGINE_CHECK_MUJOCO
  add_engine("MuJoCo", engine_check::run_mujoco, true, out);
#endif
}

}  // namespace

std::vector<WorldCost> measure_worlds() {
  std::vector<WorldCost> out;
  add_build(out);  // first, so that memory is not what was freed before
  // All move.
  const double frame = frame_ms(kBoxes, {});
  out.push_back({"100 000 moving boxes, a frame of the broadphase", frame, 12, "ms", "sorting and pairing"});
  out.push_back(
      {"the same, pairs by place", frame_ms(kBoxes, {.by_place = true}), 12, "ms", "tests of neighbours"});
  out.push_back({"with overlap, pairs by place", frame_ms(kBoxes, {.by_place = true, .overlap = true}), 22,
                 "ms", "shuffled records"});
  out.push_back(
      {"with manifolds, pairs by place", frame_ms(kBoxes, {.by_place = true, .manifold = true}), 45, "ms",
       "243 000 pairs at some 210 ns, as batches of random pairs take cold, whose records lie apart"});
  out.push_back({"with contacts (of pairs apart the class), pairs by place",
                 frame_ms(kBoxes, {.by_place = true, .manifold = true, .contacts = true}), 45, "ms",
                 "manifolds in batches"});
  out.push_back({"time of two threads over one's, contacts of those pairs", share_of_two_threads(), 0.53,
                 "times", "by the clock, in which other work counts"});
  out.push_back({"1 000 000 moving boxes over 100 000, the broadphase", frame_ms(10 * kBoxes, {}) / frame, 12,
                 "times", "memory beyond the caches"});
  // Few move.
  out.push_back({"100 000 boxes of which 1 % move, pairs of what moved with overlap",
                 frame_ms(kBoxes, {.stationary = 0.99, .moved_pairs = true, .overlap = true}), 1, "ms",
                 "a mover costs a query of a cold tree"});
  out.push_back(
      {"the same, the others built as static",
       frame_ms(kBoxes, {.stationary = 0.99, .flagged = true, .moved_pairs = true, .overlap = true}), 1, "ms",
       "a mover costs a query of a cold tree"});
  out.push_back({"1 % move after all did, pairs of what moved, the costliest frame", few_after_many_ms(), 1,
                 "ms", "the trees that the grid stood in for are made anew by shares"});
  // Engines, and the densest scene.
  add_engines(out);
  out.push_back({"4 000 boxes that all overlap, the broadphase", frame_ms(4000, {.spacing = 0.02}), 60, "ms",
                 "8 million pairs are listed"});
  return out;
}

}  // namespace touchstone
