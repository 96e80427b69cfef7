#include "examples/measures/broadphase_run.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <mutex>
#include <numeric>

#include "examples/measures/allocations.hpp"
#include "examples/measures/parallel.hpp"
#include "examples/measures/random.hpp"

namespace touchstone::comparison {
namespace {

using Clock = std::chrono::steady_clock;

// Boxes of 0.1 to 1 m in a cube that gives each 4 m3, drifting and turning.
struct Swarm {
  std::vector<HexahedronTree> trees;
  std::vector<const HexahedronTree*> pointers;
  std::vector<Hexahedron> solids;
  std::vector<Vector3> velocity;  // [m per frame]
  std::vector<Matrix3> turn;      // per frame
  std::vector<std::vector<Pose>> frames;
  std::vector<std::uint32_t> all;
};

Swarm make_swarm(std::size_t boxes, std::size_t frames, std::uint64_t seed) {
  Random random(mix_seed(seed, 0x737761726d, boxes));
  Swarm swarm;
  const double side = std::cbrt(4.0 * static_cast<double>(boxes));
  std::vector<Pose> poses;
  for (std::size_t i = 0; i < boxes; ++i) {
    const Hexahedron solid =
        Hexahedron::from_size({random.uniform(0.1, 1), random.uniform(0.1, 1), random.uniform(0.1, 1)});
    swarm.solids.push_back(solid);
    swarm.trees.emplace_back(std::vector<PlacedHexahedron>{{"box", solid, Pose{}}},
                             "box" + std::to_string(i));
    poses.push_back({random_rotation(random),
                     {random.uniform(0, side), random.uniform(0, side), random.uniform(0, side)}});
    swarm.velocity.push_back(random_direction(random) * 0.02);
    const Vector3 axis = random_direction(random) * 0.01;
    swarm.turn.push_back(rotation_from_quaternion(1.0, axis.x(), axis.y(), axis.z()));
  }
  for (std::size_t f = 0; f < frames; ++f) {
    swarm.frames.push_back(poses);
    for (std::size_t i = 0; i < boxes; ++i) {
      poses[i] = {compose({swarm.turn[i], Vector3::Zero()}, {poses[i].R, Vector3::Zero()}).R,
                  poses[i].p + swarm.velocity[i]};
    }
  }
  for (const HexahedronTree& tree : swarm.trees) swarm.pointers.push_back(&tree);
  swarm.all.resize(boxes);
  std::iota(swarm.all.begin(), swarm.all.end(), 0u);
  return swarm;
}

// Pairs whose solids are within the margin, from all pairs: bounding spheres that are further apart settle
// most of them.
std::vector<SolidPair> true_pairs(const Swarm& swarm, std::span<const Pose> poses, double margin,
                                  const Oracle& oracle, int threads) {
  std::vector<SolidPair> found;
  std::mutex mutex;
  std::vector<WorldVertices> vertices(poses.size());
  for (std::size_t i = 0; i < poses.size(); ++i) world_vertices(swarm.solids[i], poses[i], vertices[i]);
  parallel_chunks(poses.size(), 16, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      for (std::size_t j = i + 1; j < poses.size(); ++j) {
        const Vector3 offset = poses[j].p - poses[i].p;
        const double reach =
            (swarm.solids[i].bounding_sphere().radius + swarm.solids[j].bounding_sphere().radius + margin) *
            (1 + 1e-9);  // boxes are centred on their origins; generous to rounding
        if (dot(offset, offset) > reach * reach) continue;
        if (oracle.truth(vertices[i], vertices[j]).separation > margin) continue;
        const std::lock_guard lock(mutex);
        found.push_back({static_cast<SolidIndex>(i), static_cast<SolidIndex>(j)});
      }
    }
  });
  std::sort(found.begin(), found.end());
  return found;
}

// Pairs within the margin among those that any broadphase found: what one misses and another finds shows.
std::vector<SolidPair> confirmed_pairs(const Swarm& swarm, std::span<const Pose> poses, double margin,
                                       std::vector<SolidPair> candidates, const Oracle& oracle, int threads) {
  std::sort(candidates.begin(), candidates.end());
  candidates.erase(std::unique(candidates.begin(), candidates.end()), candidates.end());
  std::vector<std::uint8_t> within(candidates.size());
  parallel_chunks(candidates.size(), 256, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      WorldVertices a, b;
      world_vertices(swarm.solids[candidates[i].a], poses[candidates[i].a], a);
      world_vertices(swarm.solids[candidates[i].b], poses[candidates[i].b], b);
      within[i] = oracle.truth(a, b).separation <= margin ? 1 : 0;
    }
  });
  std::vector<SolidPair> found;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    if (within[i] != 0) found.push_back(candidates[i]);
  }
  return found;
}

struct Runner {
  std::unique_ptr<Broadphase> broadphase;
  std::unique_ptr<Narrowphase> narrowphase;  // of the same name; may be none
  std::unique_ptr<Narrowphase::Workspace> workspace;
  std::vector<PairStatus> status;
  std::vector<double> times;
  std::vector<double> whole_times;  // with the narrowphase
  std::vector<SolidPair> last_pairs;
  std::size_t candidates = 0;
  std::uint64_t allocations = 0;
};

void run_frame(Runner& runner, const Swarm& swarm, std::size_t frame, std::vector<SolidPair>& block,
               bool counts, bool keeps) {
  runner.last_pairs.clear();
  const std::uint64_t allocated = thread_allocations().value_or(0);
  const auto begin = Clock::now();
  runner.broadphase->update(swarm.frames[frame], swarm.all);
  PairCursor cursor;
  std::size_t candidates = 0;
  std::uint64_t kept = 0;
  while (!cursor.done) {
    const std::size_t written = runner.broadphase->find_pairs(cursor, block);
    candidates += written;
    if (keeps) {
      const std::uint64_t before = thread_allocations().value_or(0);
      runner.last_pairs.insert(runner.last_pairs.end(), block.begin(),
                               block.begin() + static_cast<std::ptrdiff_t>(written));
      kept += thread_allocations().value_or(0) - before;
    }
  }
  const auto end = Clock::now();
  if (!counts) return;
  runner.times.push_back(std::chrono::duration<double, std::nano>(end - begin).count());
  runner.candidates += candidates;
  runner.allocations += thread_allocations().value_or(0) - allocated - kept;
}

/// The narrowphase on the frame's pairs, as one batch; they were just found, and are collected here untimed.
void run_overlap(Runner& runner, const Swarm& swarm, std::size_t frame, std::vector<SolidPair>& block) {
  runner.last_pairs.clear();
  PairCursor cursor;
  while (!cursor.done) {
    const std::size_t written = runner.broadphase->find_pairs(cursor, block);
    runner.last_pairs.insert(runner.last_pairs.end(), block.begin(),
                             block.begin() + static_cast<std::ptrdiff_t>(written));
  }
  runner.status.resize(runner.last_pairs.size());
  const auto begin = Clock::now();
  runner.narrowphase->evaluate({runner.last_pairs, swarm.frames[frame], Query{}}, {runner.status, {}, {}},
                               *runner.workspace);
  const auto end = Clock::now();
  runner.whole_times.push_back(runner.times.back() +
                               std::chrono::duration<double, std::nano>(end - begin).count());
}

std::unique_ptr<Narrowphase> narrowphase_named(const BackendRegistry& registry, const std::string& name) {
  for (const BackendRegistry::NarrowphaseEntry& entry : registry.narrowphases())
    if (entry.name == name) return entry.make();
  return nullptr;
}

std::size_t frames_for(std::size_t boxes) { return boxes <= 1000 ? 60 : boxes <= 10000 ? 20 : 8; }

}  // namespace

std::vector<BroadphaseResult> run_broadphases(const BackendRegistry& registry,
                                              const BroadphaseOptions& options, const Oracle* oracle,
                                              const Progress& progress) {
  const std::vector<BackendRegistry::BroadphaseEntry>& broadphases = registry.broadphases();
  std::vector<BroadphaseResult> results;
  std::vector<SolidPair> block(4096);
  for (std::size_t s = 0; s < options.sizes.size(); ++s) {
    const std::size_t boxes = options.sizes[s];
    const std::size_t frames = frames_for(boxes);
    const Swarm swarm = make_swarm(boxes, frames + 1, options.seed);
    std::vector<Runner> runners(broadphases.size());
    const auto skipped = [&](std::size_t b) {
      return broadphases[b].name == "brute_force" && boxes > options.largest_quadratic;
    };
    for (std::size_t b = 0; b < broadphases.size(); ++b) {
      if (skipped(b)) continue;
      runners[b].broadphase = broadphases[b].make();
      runners[b].times.reserve(frames);
      runners[b].broadphase->build({swarm.pointers, options.margin});
      runners[b].narrowphase = narrowphase_named(registry, broadphases[b].name);
      if (!runners[b].narrowphase) continue;
      runners[b].narrowphase->build(swarm.solids);
      runners[b].workspace = runners[b].narrowphase->make_workspace();
    }
    for (std::size_t f = 0; f <= frames; ++f) {
      for (Runner& runner : runners) {
        if (!runner.broadphase) continue;
        run_frame(runner, swarm, f, block, f > 0 && f < frames, f == frames);
        if (runner.narrowphase && f > 0 && f < frames) run_overlap(runner, swarm, f, block);
      }
      if (progress) {
        progress((static_cast<double>(s) + static_cast<double>(f) / static_cast<double>(frames)) /
                 static_cast<double>(options.sizes.size()));
      }
    }
    std::optional<std::vector<SolidPair>> truth;
    if (oracle != nullptr && boxes <= options.largest_checked) {
      truth = true_pairs(swarm, swarm.frames[frames], options.margin, *oracle, options.threads);
    } else if (oracle != nullptr) {
      std::vector<SolidPair> candidates;
      for (const Runner& runner : runners)
        candidates.insert(candidates.end(), runner.last_pairs.begin(), runner.last_pairs.end());
      truth = confirmed_pairs(swarm, swarm.frames[frames], options.margin, std::move(candidates), *oracle,
                              options.threads);
    }
    for (std::size_t b = 0; b < broadphases.size(); ++b) {
      BroadphaseResult result;
      result.name = broadphases[b].name;
      result.description = broadphases[b].description;
      result.boxes = boxes;
      if (skipped(b)) {
        result.gap = "not run: its cost grows with the square of the count";
        results.push_back(std::move(result));
        continue;
      }
      Runner& runner = runners[b];
      result.frames = runner.times.size();
      result.frame = summarise_blocks(runner.times);
      if (!runner.whole_times.empty()) result.with_overlap = summarise_blocks(runner.whole_times);
      result.candidates = static_cast<double>(runner.candidates) / static_cast<double>(result.frames);
      if (thread_allocations()) {
        result.allocations = static_cast<double>(runner.allocations) / static_cast<double>(result.frames);
      }
      if (truth) {
        result.true_pairs = truth->size();
        result.from_candidates = boxes > options.largest_checked;
        result.missed =
            static_cast<std::size_t>(std::count_if(truth->begin(), truth->end(), [&](SolidPair pair) {
              return !std::binary_search(runner.last_pairs.begin(), runner.last_pairs.end(), pair);
            }));
      }
      results.push_back(std::move(result));
    }
  }
  return results;
}

}  // namespace touchstone::comparison
