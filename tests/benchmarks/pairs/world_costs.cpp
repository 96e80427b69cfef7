#include "touchstone/tests/benchmarks/pairs/world_costs.hpp"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <fstream>

#include "touchstone/adapters/all/all_backends.hpp"
#include "touchstone/contact_core/registry.hpp"
#include "touchstone/contact_core/threads/processor_time.hpp"
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

}  // namespace

std::vector<WorldCost> measure_worlds() {
  std::vector<WorldCost> out;
  add_build(out);  // first, so that memory is not what was freed before
  const double frame = frame_ms(kBoxes, {});
  out.push_back({"100 000 moving boxes, a frame of the broadphase", frame, 12, "ms", "sorting and pairing"});
  out.push_back(
      {"the same, pairs by place", frame_ms(kBoxes, {.by_place = true}), 12, "ms", "tests of neighbours"});
  out.push_back({"with overlap, pairs by place", frame_ms(kBoxes, {.by_place = true, .overlap = true}), 22,
                 "ms", "shuffled records"});
  out.push_back({"with manifolds, pairs by place", frame_ms(kBoxes, {.by_place = true, .manifold = true}), 45,
                 "ms", "manifolds in batches"});
  out.push_back({"1 000 000 moving boxes over 100 000, the broadphase", frame_ms(10 * kBoxes, {}) / frame, 12,
                 "times", "memory beyond the caches"});
  out.push_back({"100 000 boxes of which 1 % move, pairs of what moved with overlap",
                 frame_ms(kBoxes, {.stationary = 0.99, .moved_pairs = true, .overlap = true}), 1, "ms",
                 "a mover costs a query of a cold tree"});
  out.push_back({"4 000 boxes that all overlap, the broadphase", frame_ms(4000, {.spacing = 0.02}), 60, "ms",
                 "8 million pairs are listed"});
  return out;
}

}  // namespace touchstone
