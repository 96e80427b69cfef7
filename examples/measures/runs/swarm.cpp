#include "touchstone/examples/measures/runs/swarm.hpp"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <numeric>

#include "touchstone/examples/measures/common/parallel.hpp"
#include "touchstone/examples/measures/common/random.hpp"

namespace touchstone::measures {
namespace {

std::vector<PlacedHexahedron> random_block(Random& random, std::size_t count) {
  const auto side = static_cast<std::size_t>(std::ceil(std::cbrt(static_cast<double>(count)) - 1e-9));
  const double middle = 0.5 * static_cast<double>(side - 1);
  std::vector<PlacedHexahedron> block;
  for (std::size_t i = 0; i < count; ++i) {
    const Hexahedron solid =
        Hexahedron::from_size({random.uniform(0.1, 1), random.uniform(0.1, 1), random.uniform(0.1, 1)});
    const Vector3 p = {static_cast<double>(i % side) - middle, static_cast<double>(i / side % side) - middle,
                       static_cast<double>(i / side / side) - middle};
    block.push_back({"box" + std::to_string(i), solid, {Matrix3::Identity(), p}});
  }
  return block;
}

bool is_near(const Swarm& swarm, std::span<const Pose> poses, SolidPair pair, double margin) {
  const Vector3 offset = poses[pair.b].p - poses[pair.a].p;
  const double reach = (swarm.solids[pair.a].bounding_sphere().radius +
                        swarm.solids[pair.b].bounding_sphere().radius + margin) *
                       (1 + 1e-9);  // boxes are centred on their origins; generous to rounding
  return dot(offset, offset) <= reach * reach;
}

}  // namespace

Swarm make_swarm(const SwarmSize& size, std::size_t frames, std::uint64_t seed) {
  Random random(mix_seed(seed, 0x737761726d, size.objects));
  Swarm swarm;
  // The cube grows with the hexahedra, so that their density stays the same.
  const double side = std::cbrt(4.0 * static_cast<double>(size.hexahedra()));
  std::vector<Pose> X_WO;
  std::vector<Vector3> velocity;  // [m per frame]
  std::vector<Matrix3> turn;      // per frame
  // Each object has a steady velocity and turn.
  for (std::size_t i = 0; i < size.objects; ++i) {
    swarm.trees.emplace_back(random_block(random, size.hexahedra_each), "object" + std::to_string(i));
    X_WO.push_back({random_rotation(random),
                    {random.uniform(0, side), random.uniform(0, side), random.uniform(0, side)}});
    velocity.push_back(random_direction(random) * 0.02);
    const Vector3 axis = random_direction(random) * 0.01;
    turn.push_back(rotation_from_quaternion(1.0, axis.x(), axis.y(), axis.z()));
  }
  // Solids of all objects are numbered in one row.
  for (const HexahedronTree& tree : swarm.trees) {
    for (const PlacedHexahedron& placed : tree.solids()) {
      swarm.solids.push_back(placed.solid);
      swarm.object_of.push_back(static_cast<std::uint32_t>(swarm.pointers.size()));
    }
    swarm.pointers.push_back(&tree);
  }
  // Poses of all frames are made here, outside of what is timed.
  for (std::size_t f = 0; f < frames; ++f) {
    std::vector<Pose>& poses = swarm.frames.emplace_back();
    for (std::size_t i = 0; i < size.objects; ++i) {
      for (const PlacedHexahedron& placed : swarm.trees[i].solids())
        poses.push_back(compose(X_WO[i], placed.X_OS));
      X_WO[i] = {compose({turn[i], Vector3::Zero()}, {X_WO[i].R, Vector3::Zero()}).R,
                 X_WO[i].p + velocity[i]};
    }
  }
  swarm.all.resize(size.objects);
  std::iota(swarm.all.begin(), swarm.all.end(), 0u);
  return swarm;
}

std::vector<SolidPair> true_pairs(const Swarm& swarm, std::span<const Pose> poses, double margin,
                                  const Oracle& oracle, int threads) {
  std::vector<SolidPair> found;
  std::mutex mutex;
  std::vector<WorldVertices> vertices(poses.size());
  for (std::size_t i = 0; i < poses.size(); ++i) world_vertices(swarm.solids[i], poses[i], vertices[i]);
  parallel_chunks(poses.size(), 16, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      for (std::size_t j = i + 1; j < poses.size(); ++j) {
        const SolidPair pair = {static_cast<SolidIndex>(i), static_cast<SolidIndex>(j)};
        if (swarm.object_of[i] == swarm.object_of[j] || !is_near(swarm, poses, pair, margin)) continue;
        if (oracle.truth(vertices[i], vertices[j]).separation > margin) continue;
        const std::lock_guard lock(mutex);
        found.push_back(pair);
      }
    }
  });
  std::sort(found.begin(), found.end());
  return found;
}

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

}  // namespace touchstone::measures
