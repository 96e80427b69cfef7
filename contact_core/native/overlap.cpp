#include "contact_core/native/overlap.hpp"

#include <algorithm>
#include <array>
#include <type_traits>

#include "contact_core/native/box_box_overlap.hpp"
#include "contact_core/native/gjk.hpp"
#include "contact_core/native/parallelepiped_overlap.hpp"
#include "contact_core/native/portal.hpp"
#include "contact_core/numerics/exact_predicates.hpp"
#include "contact_core/numerics/portal_predicate.hpp"

namespace touchstone::native {
namespace {

// The kernels read poses as they lie in memory: R by columns, then p.
static_assert(sizeof(Pose) == sizeof(PoseRecord) && std::is_standard_layout_v<Pose>);
static_assert(!Matrix3::IsRowMajor);

constexpr std::size_t kBlock = 256;
/// Of 4096 random frusta two need more than 6; whoever does is near touching.
constexpr int kPortalSteps = 8;

const PoseRecord* records(std::span<const Pose> poses) {
  return reinterpret_cast<const PoseRecord*>(poses.data());
}

Vector3 half_extents(const BoxRecord& box) {
  return {box.half_extents[0], box.half_extents[1], box.half_extents[2]};
}

PairStatus to_status(bool meet) { return meet ? PairStatus::overlapping : PairStatus::separated; }

/// Without the kernels.
bool meet(const SolidSet& set, const SolidPair& pair, std::span<const Pose> poses) {
  const Pose& X_WA = poses[pair.a];
  const Pose& X_WB = poses[pair.b];
  const bool ordinary = is_ordinary(set, pair.a, X_WA, pair.b, X_WB);
  if (ordinary) {
    const Certified certified = certify_kinds(set, pair, poses);
    if (certified != Certified::unknown) return certified == Certified::overlapping;
  }
  PlacedPair placed;
  place(set.solids[pair.a], X_WA, set.solids[pair.b], X_WB, ordinary, placed);
  return hulls_meet(placed);
}

/// The pairs of a block that go to one kernel.
struct Batch {
  std::array<PairIndices, kBlock> pairs;
  std::array<std::uint16_t, kBlock> slots;
  std::size_t count = 0;

  void add(const SolidPair& pair, std::size_t slot) {
    pairs[count] = {pair.a, pair.b};
    slots[count++] = static_cast<std::uint16_t>(slot);
  }
};

struct Block {
  Batch boxes, forms, others;
  std::array<Certified, kBlock> certified;
};

SolidKind kind_of(const SolidSet& set, const SolidPair& pair) {
  return std::max(set.kinds[pair.a], set.kinds[pair.b]);
}

void settle(const SolidSet& set, const Batch& batch, const std::array<Certified, kBlock>& certified,
            std::span<const Pose> poses, std::span<PairStatus> status) {
  for (std::size_t i = 0; i < batch.count; ++i) {
    const Certified c = certified[i];
    const PairIndices pair = batch.pairs[i];
    status[batch.slots[i]] =
        to_status(c == Certified::unknown ? meet(set, {pair.a, pair.b}, poses) : c == Certified::overlapping);
  }
}

void overlap_block(const SolidSet& set, const Kernels& kernels, std::span<const SolidPair> pairs,
                   std::span<const Pose> poses, std::span<PairStatus> status) {
  Block block;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    switch (kind_of(set, pairs[i])) {
      case SolidKind::box:
        block.boxes.add(pairs[i], i);
        break;
      case SolidKind::parallelepiped:
        block.forms.add(pairs[i], i);
        break;
      case SolidKind::general:
        block.others.add(pairs[i], i);
        break;
    }
  }
  if (block.boxes.count > 0) {
    kernels.certify_boxes(records(poses), set.boxes.data(), block.boxes.pairs.data(), block.boxes.count,
                          block.certified.data());
    settle(set, block.boxes, block.certified, poses, status);
  }
  if (block.forms.count > 0) {
    kernels.certify_parallelepipeds(records(poses), set.forms.data(), block.forms.pairs.data(),
                                    block.forms.count, block.certified.data());
    settle(set, block.forms, block.certified, poses, status);
  }
  if (block.others.count > 0) {
    kernels.certify_by_portal(records(poses), set.vertices.data(), block.others.pairs.data(),
                              block.others.count, kPortalSteps, block.certified.data());
    settle(set, block.others, block.certified, poses, status);
  }
}

PairStatus overlap_one(const SolidSet& set, const Kernels& kernels, const SolidPair& pair,
                       std::span<const Pose> poses) {
  if (kind_of(set, pair) == SolidKind::box) {
    const PoseRecord* X_W = records(poses);
    const Certified certified =
        kernels.certify_box_pair(X_W[pair.a], set.boxes[pair.a], X_W[pair.b], set.boxes[pair.b]);
    if (certified != Certified::unknown) return to_status(certified == Certified::overlapping);
  }
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
  Certified certified = certify_by_portal(placed.pair.hulls, portal);
  if (certified != Certified::unknown) return certified == Certified::overlapping;
  if (portal.found) {
    const numerics::Settled settled = numerics::settle_near(placed.a_W, placed.b_W, {portal.a, portal.b});
    if (settled != numerics::Settled::open) return settled == numerics::Settled::intersecting;
  }
  certified = certify_hulls(placed.pair.hulls, placed.pair.start);
  if (certified != Certified::unknown) return certified == Certified::overlapping;
  return numerics::hulls_intersect(placed.a_W, placed.b_W);
}

void overlap(const SolidSet& set, const Kernels& kernels, std::span<const SolidPair> pairs,
             std::span<const Pose> poses, std::span<PairStatus> status) {
  if (pairs.size() == 1) {
    status[0] = overlap_one(set, kernels, pairs[0], poses);
    return;
  }
  for (std::size_t first = 0; first < pairs.size(); first += kBlock) {
    const std::size_t here = std::min(kBlock, pairs.size() - first);
    overlap_block(set, kernels, pairs.subspan(first, here), poses, status.subspan(first, here));
  }
}

}  // namespace touchstone::native
