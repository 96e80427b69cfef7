#include "touchstone/contact_core/native/overlap/overlap.hpp"
#include "touchstone/contact_core/native/solids/pair_batch.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <type_traits>

#include "touchstone/contact_core/narrowphase/no_geometry.hpp"
#include "touchstone/contact_core/native/overlap/box_box_overlap.hpp"
#include "touchstone/contact_core/native/overlap/gjk.hpp"
#include "touchstone/contact_core/native/overlap/mpr.hpp"
#include "touchstone/contact_core/native/overlap/parallelepiped_overlap.hpp"
#include "touchstone/contact_core/numerics/exact_predicates.hpp"
#include "touchstone/contact_core/numerics/triangle_predicate.hpp"

namespace touchstone::native {
namespace {

// The kernels read poses as they lie in memory: R by columns, then p.
static_assert(sizeof(Pose) == sizeof(PoseRecord) && std::is_standard_layout_v<Pose>);
static_assert(!Matrix3::IsRowMajor);

/// MPR iterations before the scalar fallback; of 4096 random frusta, 2 needed more than 6.
constexpr int kMprSteps = 8;

const PoseRecord* records(std::span<const Pose> poses) {
  return reinterpret_cast<const PoseRecord*>(poses.data());
}

Vector3 half_extents(const BoxRecord& box) {
  return {box.half_extents[0], box.half_extents[1], box.half_extents[2]};
}

PairStatus to_status(bool meet) { return meet ? PairStatus::overlapping : PairStatus::separated; }

void place_pair(const SolidSet& set, const SolidPair& pair, std::span<const Pose> poses, PlacedPair& out) {
  const Pose& X_WA = poses[pair.a];
  const Pose& X_WB = poses[pair.b];
  place(set.solids[pair.a], X_WA, set.solids[pair.b], X_WB, is_ordinary(set, pair.a, X_WA, pair.b, X_WB),
        out);
}

/// The scalar test of a pair of any kind, without kernels.
bool placed_meet(const SolidSet& set, const SolidPair& pair, std::span<const Pose> poses) {
  PlacedPair placed;
  place_pair(set, pair, poses, placed);
  return native::hulls_meet(placed);
}

/// The scalar test, by the kind's filter first. @pre finite poses.
bool meet(const SolidSet& set, const SolidPair& pair, std::span<const Pose> poses) {
  if (is_ordinary(set, pair.a, poses[pair.a], pair.b, poses[pair.b])) {
    const Certified certified = certify_kinds(set, pair, poses);
    if (certified != Certified::unknown) return certified == Certified::overlapping;
  }
  return placed_meet(set, pair, poses);
}

struct Block {
  Batch boxes, parallelepipeds, others, hinted;
  std::array<Certified, kBlock> certified;
  std::array<PairAxis, kBlock> axes;
};

SolidKind kind_of(const SolidSet& set, const SolidPair& pair) {
  return std::max(set.kinds[pair.a], set.kinds[pair.b]);
}

/// @param ask what settles the pairs that the kernel left unknown, as it does all with a pose that is not
/// finite.
template <class Ask>
void settle(const SolidSet& set, const Batch& batch, const std::array<Certified, kBlock>& certified,
            std::span<const Pose> poses, std::span<PairStatus> status, const Ask& ask) {
  for (std::size_t i = 0; i < batch.count; ++i) {
    const Certified c = certified[i];
    const SolidPair pair{batch.pairs[i].a, batch.pairs[i].b};
    if (c != Certified::unknown)
      status[batch.slots[i]] = to_status(c == Certified::overlapping);
    else if (!has_finite_poses(pair, poses))
      status[batch.slots[i]] = PairStatus::failed;
    else
      status[batch.slots[i]] = to_status(ask(set, pair, poses));
  }
}

// The cache keeps a separating axis, from A to B, as floats: rounding it hardly narrows the gap.

constexpr std::uint32_t kHoldsAxis = 0x73697861;

/// The largest component becomes 1, so that any axis fits floats.
PairCacheEntry remember(const PairAxis& axis) {
  const double largest = std::max({std::abs(axis.x), std::abs(axis.y), std::abs(axis.z)});
  const auto bits = [largest](double c) {
    return std::bit_cast<std::uint32_t>(static_cast<float>(c / largest));
  };
  return {{bits(axis.x), bits(axis.y), bits(axis.z), kHoldsAxis}};
}

PairAxis recall(const PairCacheEntry& entry) {
  const auto number = [](std::uint32_t bits) { return static_cast<double>(std::bit_cast<float>(bits)); };
  return {number(entry.data[0]), number(entry.data[1]), number(entry.data[2]), 0.0};
}

/// Pairs with an axis that no longer separates them join `others`.
void settle_hinted(const SolidSet& set, const Kernels& kernels, std::span<const Pose> poses,
                   std::span<PairStatus> status, std::span<const PairCacheEntry> cache, Block& block) {
  const Batch& hinted = block.hinted;
  for (std::size_t i = 0; i < hinted.count; ++i) block.axes[i] = recall(cache[hinted.slots[i]]);
  kernels.certify_by_axis(records(poses), set.vertices.data(), hinted.pairs.data(), hinted.count,
                          block.axes.data(), block.certified.data());
  for (std::size_t i = 0; i < hinted.count; ++i) {
    if (block.certified[i] == Certified::separated)
      status[hinted.slots[i]] = PairStatus::separated;
    else
      block.others.add({hinted.pairs[i].a, hinted.pairs[i].b}, hinted.slots[i]);
  }
}

void settle_others(const SolidSet& set, const Kernels& kernels, std::span<const Pose> poses,
                   std::span<PairStatus> status, std::span<PairCacheEntry> cache, Block& block) {
  const Batch& others = block.others;
  kernels.certify_by_mpr(records(poses), set.vertices.data(), others.pairs.data(), others.count, kMprSteps,
                         block.certified.data(), cache.empty() ? nullptr : block.axes.data());
  if (!cache.empty()) {
    for (std::size_t i = 0; i < others.count; ++i)
      cache[others.slots[i]] =
          block.certified[i] == Certified::separated ? remember(block.axes[i]) : PairCacheEntry{};
  }
  settle(set, others, block.certified, poses, status, placed_meet);
}

void overlap_block(const SolidSet& set, const Kernels& kernels, std::span<const SolidPair> pairs,
                   std::span<const Pose> poses, std::span<PairStatus> status,
                   std::span<PairCacheEntry> cache) {
  Block block;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    switch (kind_of(set, pairs[i])) {
      case SolidKind::box:
        prefetch_pair(set.boxes, poses, pairs[i]);
        block.boxes.add(pairs[i], i);
        break;
      case SolidKind::parallelepiped:
        prefetch_pair(set.parallelepipeds, poses, pairs[i]);
        block.parallelepipeds.add(pairs[i], i);
        break;
      case SolidKind::general:
        prefetch_pair(set.vertices, poses, pairs[i]);
        (!cache.empty() && cache[i].data[3] == kHoldsAxis ? block.hinted : block.others).add(pairs[i], i);
        break;
    }
  }
  if (block.boxes.count > 0) {
    kernels.certify_boxes(records(poses), set.boxes.data(), block.boxes.pairs.data(), block.boxes.count,
                          block.certified.data());
    settle(set, block.boxes, block.certified, poses, status, meet);
  }
  if (block.parallelepipeds.count > 0) {
    kernels.certify_parallelepipeds(records(poses), set.parallelepipeds.data(),
                                    block.parallelepipeds.pairs.data(), block.parallelepipeds.count,
                                    block.certified.data());
    settle(set, block.parallelepipeds, block.certified, poses, status, placed_meet);
  }
  if (block.hinted.count > 0) settle_hinted(set, kernels, poses, status, cache, block);
  if (block.others.count > 0) settle_others(set, kernels, poses, status, cache, block);
}

PairStatus overlap_one(const SolidSet& set, const Kernels& kernels, const SolidPair& pair,
                       std::span<const Pose> poses) {
  // In two lanes the scalar filter, which stops at the first face that separates, is faster.
  if (kernels.lanes > 2 && kind_of(set, pair) == SolidKind::box) {
    const PoseRecord* X_W = records(poses);
    const Certified certified =
        kernels.certify_box_pair(X_W[pair.a], set.boxes[pair.a], X_W[pair.b], set.boxes[pair.b]);
    if (certified != Certified::unknown) return to_status(certified == Certified::overlapping);
  }
  if (!has_finite_poses(pair, poses)) return PairStatus::failed;
  return to_status(meet(set, pair, poses));
}

}  // namespace

Certified certify_kinds(const SolidSet& set, const SolidPair& pair, std::span<const Pose> poses) {
  const SolidKind kind = kind_of(set, pair);
  const Pose& X_WA = poses[pair.a];
  const Pose& X_WB = poses[pair.b];
  if (kind == SolidKind::box)
    return certify_boxes(half_extents(set.boxes[pair.a]), X_WA, half_extents(set.boxes[pair.b]), X_WB);
  if (kind == SolidKind::general) return Certified::unknown;
  return certify_parallelepipeds(set.parallelepipeds[pair.a], X_WA, set.parallelepipeds[pair.b], X_WB);
}

bool hulls_meet(const PlacedPair& placed) {
  Portal portal;
  Certified certified = certify_by_mpr(placed.pair.hulls, portal);
  if (certified != Certified::unknown) return certified == Certified::overlapping;
  if (portal.found) {
    certified = numerics::certify_near(placed.a_W, placed.b_W, {portal.a, portal.b});
    if (certified != Certified::unknown) return certified == Certified::overlapping;
  }
  certified = certify_hulls(placed.pair.hulls, placed.pair.start);
  if (certified != Certified::unknown) return certified == Certified::overlapping;
  return numerics::hulls_intersect(placed.a_W, placed.b_W);
}

void overlap(const SolidSet& set, const Kernels& kernels, std::span<const SolidPair> pairs,
             std::span<const Pose> poses, std::span<PairStatus> status, std::span<PairCacheEntry> cache) {
  if (pairs.size() == 1) {
    status[0] = overlap_one(set, kernels, pairs[0], poses);
    return;
  }
  for (std::size_t first = 0; first < pairs.size(); first += kBlock) {
    const std::size_t here = std::min(kBlock, pairs.size() - first);
    overlap_block(set, kernels, pairs.subspan(first, here), poses, status.subspan(first, here),
                  cache.empty() ? cache : cache.subspan(first, here));
  }
}

}  // namespace touchstone::native
