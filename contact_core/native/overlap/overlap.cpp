#include "touchstone/contact_core/native/overlap/overlap.hpp"
#include "touchstone/contact_core/native/solids/pair_batch.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <optional>
#include <type_traits>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/narrowphase/no_geometry.hpp"
#include "touchstone/contact_core/native/overlap/aligned_hulls.hpp"
#include "touchstone/contact_core/native/overlap/box_box_overlap.hpp"
#include "touchstone/contact_core/native/overlap/flush_hulls.hpp"
#include "touchstone/contact_core/native/overlap/gjk.hpp"
#include "touchstone/contact_core/native/overlap/mpr.hpp"
#include "touchstone/contact_core/native/overlap/parallelepiped_overlap.hpp"
#include "touchstone/contact_core/numerics/exact_pair.hpp"
#include "touchstone/contact_core/numerics/exact_predicates.hpp"
#include "touchstone/contact_core/numerics/triangle_predicate.hpp"

namespace touchstone::native {
namespace {

/// MPR iterations before the scalar fallback; of 4096 random frusta, 2 needed more than 6.
constexpr int kMprSteps = 8;

/// Pairs whose depths are asked for at a time: their records fit the first cache.
constexpr std::size_t kDepths = 32;

PairStatus to_status(bool meet) { return meet ? PairStatus::overlapping : PairStatus::separated; }

void place_pair(const SolidSet& set, const SolidPair& pair, std::span<const Pose> poses, PlacedPair& out) {
  const Pose& X_WA = poses[pair.a];
  const Pose& X_WB = poses[pair.b];
  place(set, pair, X_WA, X_WB, is_ordinary(set, pair.a, X_WA, pair.b, X_WB), out);
}

/// Of all faces' normals, A's and the negated of B's, that along which the hulls are furthest apart.
Vector3 best_face_normal(const PosedPair& pair) {
  Vector3 best = pair.start;
  double furthest = -kInfinity;
  const auto look_at = [&](const SolidFeatures& features, const Matrix3& R, double sign) {
    for (int f = 0; f < features.face_count; ++f) {
      const Vector3 n_W = sign * rotate(R, features.faces[f].normal);
      const double separation = separation_along(pair.hulls, n_W);
      if (separation > furthest) furthest = separation, best = n_W;
    }
  };
  look_at(*pair.a, pair.R_WA, 1.0);
  look_at(*pair.b, pair.R_WB, -1.0);
  return best;
}

/// The plane across n through A's supporting vertex.
FlushVerdict certify_flush_along(const Kernels& kernels, const PlacedPair& placed, const Vector3& n) {
  const int support = support_high(placed.pair.hulls.a, n).index;
  return certify_flush(kernels, placed.a_W, placed.b_W, n, placed.a_W.vertex(support));
}

/// The plane of a portal at W's boundary, where faces touch, or nearly: theirs unless the portal is a sliver,
/// as where vertices coincide.
FlushVerdict certify_flush_along(const Kernels& kernels, const PlacedPair& placed, const Portal& portal) {
  const HullPair& hulls = placed.pair.hulls;
  std::array<Vector3, 3> w;
  for (int k = 0; k < 3; ++k) w[k] = hulls.b.vertex(portal.b[k]) - hulls.a.vertex(portal.a[k]);
  Vector3 n = cross(w[1] - w[0], w[2] - w[0]);
  if (dot(n, placed.pair.start) < 0.0) n = -n;
  return certify_flush(kernels, placed.a_W, placed.b_W, n, placed.a_W.vertex(portal.a[0]));
}

/// Decides pairs that no filter of their kind certified, nor comparing coordinates: by the hulls.
/// @param flush see hulls_meet().
bool placed_meet(const SolidSet& set, const Kernels& kernels, const SolidPair& pair,
                 std::span<const Pose> poses, const DepthRecord& depth, const FlushVerdict* flush = nullptr) {
  PlacedPair placed;
  place_pair(set, pair, poses, placed);
  return native::hulls_meet(kernels, placed, depth, flush);
}

bool has_face_along_an_axis(const Matrix3& R) {
  bool found = false;
  for (int k = 0; k < 9; ++k) found |= std::abs(R.data()[k]) == 1.0;
  return found;
}

/// The same of general hexahedra, which no filter but the hulls' has seen.
bool general_meet(const SolidSet& set, const Kernels& kernels, const SolidPair& pair,
                  std::span<const Pose> poses) {
  PlacedPair placed;
  place_pair(set, pair, poses, placed);
  if (has_face_along_an_axis(poses[pair.a].R) || has_face_along_an_axis(poses[pair.b].R)) {
    const Certified certified = certify_aligned(placed.a_W, placed.b_W);
    if (certified != Certified::unknown) return certified == Certified::overlapping;
  } else if (are_apart_by_coordinates(placed.a_W, placed.b_W)) {
    return false;
  }
  return native::hulls_meet(kernels, placed);
}

/// Directions this close, and gaps this small of a pair's size, are those of faces flush to rounding.
constexpr double kFlushShare = 0x1p-36;

WorldVertices local_vertices(const BoxRecord& box) {
  const auto [x, y, z] = box.half_extents;
  return {{-x, -x, -x, -x, x, x, x, x}, {-y, -y, y, y, -y, -y, y, y}, {-z, z, -z, z, -z, z, -z, z}};
}

/// The axes of A whose faces lie in one plane with one of B's, but for rounding: the first, and how many.
/// None where one is an axis of the world, along which the kernel compares coordinates.
struct FlushAxes {
  int first = 0, count = 0;
};

FlushAxes find_flush_axes(const BoxRecord& a, const Pose& X_WA, const BoxRecord& b, const Pose& X_WB) {
  const Vector3 T = X_WB.p - X_WA.p;
  const double size = (a.reach + b.reach) + norm_1(T);
  const double tolerance = kFlushShare * size + 8 * kRoundoff * (norm_inf(X_WA.p) + norm_inf(X_WB.p));
  const auto are_parallel = [&](const Vector3& n, int j) {
    return std::abs(dot(n, X_WB.R.col((j + 1) % 3))) + std::abs(dot(n, X_WB.R.col((j + 2) % 3))) <=
           kFlushShare;
  };
  FlushAxes found;
  for (int i = 0; i < 3; ++i) {
    const Vector3 n = X_WA.R.col(i);
    const double beyond_a = std::abs(dot(n, T)) - a.half_extents[i];
    for (int j = 0; j < 3; ++j) {
      if (!(std::abs(beyond_a - b.half_extents[j]) <= tolerance && are_parallel(n, j))) continue;
      if (norm_inf(n) == 1.0) return {};
      if (found.count++ == 0) found.first = i;
    }
  }
  return found;
}

/// Boxes that touch face to face, by their heights over the plane of A's face along n, from A to B. No part
/// of its caller, where every pair that touches would pay for its room on the stack.
[[gnu::noinline]] FlushVerdict certify_flush_boxes(const Kernels& kernels, const BoxRecord& a,
                                                   const Pose& X_WA, const BoxRecord& b, const Pose& X_WB,
                                                   int axis, const Vector3& n) {
  WorldVertices a_W, b_W;
  native::world_vertices(local_vertices(a), X_WA, a_W);
  native::world_vertices(local_vertices(b), X_WB, b_W);
  const bool is_forward = dot(n, X_WA.R.col(axis)) > 0.0;
  return certify_flush(kernels, a_W, b_W, n, a_W.vertex(is_forward ? 4 >> axis : 0));
}

/// Whether comparing coordinates may decide the pair. Boxes of which no face looks along an axis of the world
/// touch in planes that coordinates do not tell.
bool may_be_aligned(const SolidSet& set, const SolidPair& pair, std::span<const Pose> poses) {
  return kind_of(set, pair) != SolidKind::box || has_face_along_an_axis(poses[pair.a].R) ||
         has_face_along_an_axis(poses[pair.b].R);
}

/// By comparing the coordinates of the hulls.
Certified certify_by_coordinates(const SolidSet& set, const SolidPair& pair, std::span<const Pose> poses) {
  if (!may_be_aligned(set, pair, poses)) return Certified::unknown;
  WorldVertices a_W, b_W;
  native::world_vertices(local_vertices(set, pair.a), poses[pair.a], a_W);
  native::world_vertices(local_vertices(set, pair.b), poses[pair.b], b_W);
  return certify_aligned(a_W, b_W);
}

struct Block {
  Batch boxes, parallelepipeds, others, hinted, rest;
  std::array<Certified, kBlock> certified;
  std::array<PairAxis, kBlock> axes;
};

/// Writes what is certified; pairs left unknown make up `rest`, which may be the batch.
void write_certified(const Batch& batch, const std::array<Certified, kBlock>& certified,
                     std::span<PairStatus> status, Batch& rest) {
  const std::size_t count = batch.count;
  rest.count = 0;
  for (std::size_t i = 0; i < count; ++i) {
    if (certified[i] == Certified::unknown)
      rest.add({batch.pairs[i].a, batch.pairs[i].b}, batch.slots[i]);
    else
      status[batch.slots[i]] = to_status(certified[i] == Certified::overlapping);
  }
}

/// Takes pairs with a pose that is not finite out of a batch of which kernels have left them unknown.
void fail_not_finite(std::span<const Pose> poses, std::span<PairStatus> status, Batch& batch) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < batch.count; ++i) {
    const PairIndices pair = batch.pairs[i];
    const std::uint16_t slot = batch.slots[i];
    if (has_finite_poses({pair.a, pair.b}, poses))
      batch.pairs[kept] = pair, batch.slots[kept++] = slot;
    else
      status[slot] = PairStatus::failed;
  }
  batch.count = kept;
}

void compute_depths(const SolidSet& set, const Kernels& kernels, SolidKind kind,
                    std::span<const PairIndices> pairs, std::span<const Pose> poses, DepthRecord* depths) {
  if (kind == SolidKind::box)
    kernels.compute_box_depths(records_of(poses), set.boxes.data(), pairs.data(), pairs.size(), depths);
  else
    kernels.compute_parallelepiped_depths(records_of(poses), set.parallelepiped_edges.data(), pairs.data(),
                                          pairs.size(), depths);
}

/// Boxes are few here: the kernel for boxes that touch compares their coordinates, too.
void compare_coordinates(const SolidSet& set, const Kernels& kernels, SolidKind kind, const Batch& batch,
                         std::span<const Pose> poses, std::array<Certified, kBlock>& out) {
  if (kind == SolidKind::box) {
    for (std::size_t i = 0; i < batch.count; ++i)
      out[i] = certify_by_coordinates(set, {batch.pairs[i].a, batch.pairs[i].b}, poses);
    return;
  }
  // Filters read no vertices.
  for (std::size_t i = 0; i < batch.count; ++i)
    prefetch(set.vertices[batch.pairs[i].a]), prefetch(set.vertices[batch.pairs[i].b]);
  kernels.certify_aligned(records_of(poses), vertex_records(set), batch.pairs.data(), batch.count,
                          out.data());
}

/// By comparing coordinates, which decides most pairs that touch exactly, then by the depth kernels, whose
/// margins are the finest and whose axis the hulls touch along, then by the hulls. @pre finite poses.
void settle_closely(const SolidSet& set, const Kernels& kernels, SolidKind kind, std::span<const Pose> poses,
                    std::span<PairStatus> status, std::array<Certified, kBlock>& certified_of, Batch& batch) {
  compare_coordinates(set, kernels, kind, batch, poses, certified_of);
  write_certified(batch, certified_of, status, batch);
  // The depth kernels come next, and the hulls for pairs that these leave unknown.
  std::array<DepthRecord, kDepths> depths;
  for (std::size_t first = 0; first < batch.count; first += kDepths) {
    const std::size_t here = std::min(kDepths, batch.count - first);
    compute_depths(set, kernels, kind, std::span(batch.pairs).subspan(first, here), poses, depths.data());
    for (std::size_t i = 0; i < here; ++i) {
      const PairIndices pair = batch.pairs[first + i];
      const Certified certified = depths[i].certified;
      const bool meet = certified == Certified::unknown
                            ? placed_meet(set, kernels, {pair.a, pair.b}, poses, depths[i])
                            : certified == Certified::overlapping;
      status[batch.slots[first + i]] = to_status(meet);
    }
  }
}

/// The order in which the distance query asks, too: rounded margins, kernels for boxes that touch,
/// coordinates, exact arithmetic last. Both kernels leave open what has a pose that is not finite.
void settle_boxes(const SolidSet& set, const Kernels& kernels, std::span<const Pose> poses,
                  std::span<PairStatus> status, Block& block) {
  kernels.certify_boxes(records_of(poses), set.boxes.data(), block.boxes.pairs.data(), block.boxes.count,
                        block.certified.data());
  write_certified(block.boxes, block.certified, status, block.rest);
  if (block.rest.count == 0) return;
  kernels.certify_touching_boxes(records_of(poses), set.boxes.data(), block.rest.pairs.data(),
                                 block.rest.count, block.certified.data());
  write_certified(block.rest, block.certified, status, block.boxes);
  if (block.boxes.count == 0) return;
  fail_not_finite(poses, status, block.boxes);
  settle_closely(set, kernels, SolidKind::box, poses, status, block.certified, block.boxes);
}

void settle_parallelepipeds(const SolidSet& set, const Kernels& kernels, std::span<const Pose> poses,
                            std::span<PairStatus> status, Block& block) {
  kernels.certify_parallelepipeds(records_of(poses), set.parallelepipeds.data(),
                                  block.parallelepipeds.pairs.data(), block.parallelepipeds.count,
                                  block.certified.data());
  write_certified(block.parallelepipeds, block.certified, status, block.rest);
  fail_not_finite(poses, status, block.rest);
  settle_closely(set, kernels, SolidKind::parallelepiped, poses, status, block.certified, block.rest);
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
  kernels.certify_by_axis(records_of(poses), vertex_records(set), hinted.pairs.data(), hinted.count,
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
  kernels.certify_by_mpr(records_of(poses), vertex_records(set), others.pairs.data(), others.count, kMprSteps,
                         block.certified.data(), cache.empty() ? nullptr : block.axes.data());
  if (!cache.empty()) {
    for (std::size_t i = 0; i < others.count; ++i)
      cache[others.slots[i]] =
          block.certified[i] == Certified::separated ? remember(block.axes[i]) : PairCacheEntry{};
  }
  write_certified(others, block.certified, status, block.rest);
  fail_not_finite(poses, status, block.rest);
  const Batch& rest = block.rest;
  for (std::size_t i = 0; i < rest.count; ++i)
    status[rest.slots[i]] = to_status(general_meet(set, kernels, {rest.pairs[i].a, rest.pairs[i].b}, poses));
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
  if (block.boxes.count > 0) settle_boxes(set, kernels, poses, status, block);
  if (block.parallelepipeds.count > 0) settle_parallelepipeds(set, kernels, poses, status, block);
  if (block.hinted.count > 0) settle_hinted(set, kernels, poses, status, cache, block);
  if (block.others.count > 0) settle_others(set, kernels, poses, status, cache, block);
}

/// Comparing half-extents is as quick as the kernel for a batch, and quicker for one pair.
Certified certify_aligned_pair(const SolidSet& set, const SolidPair& pair, std::span<const Pose> poses) {
  return certify_aligned_boxes(half_extents(set.boxes[pair.a]), poses[pair.a],
                               half_extents(set.boxes[pair.b]), poses[pair.b]);
}

Certified ask_touching_kernel(const SolidSet& set, const Kernels& kernels, const SolidPair& pair,
                              std::span<const Pose> poses) {
  const PairIndices indices{pair.a, pair.b};
  Certified certified;
  kernels.certify_touching_boxes(records_of(poses), set.boxes.data(), &indices, 1, &certified);
  return certified;
}

/// What is known of a pair that filters leave open. Two records: compilers clear one large one in a loop.
struct OpenPair {
  DepthRecord& depth;
  std::optional<FlushVerdict>& flush;  ///< along the depth's axis
};

/// As certify_touching_pair(), which distances ask, with faces that lie flush before the kernel: it decides
/// where they do along several axes. @param open gets the axis of such a face, and what it told
Certified certify_touching_boxes(const SolidSet& set, const Kernels& kernels, const SolidPair& pair,
                                 std::span<const Pose> poses, const OpenPair& open) {
  const Pose &X_WA = poses[pair.a], &X_WB = poses[pair.b];
  if (!is_ordinary(set, pair.a, X_WA, pair.b, X_WB)) return Certified::unknown;
  const Certified certified = certify_aligned_pair(set, pair, poses);
  if (certified != Certified::unknown) return certified;

  const BoxRecord &a = set.boxes[pair.a], &b = set.boxes[pair.b];
  const FlushAxes axes = find_flush_axes(a, X_WA, b, X_WB);
  if (axes.count == 0) return ask_touching_kernel(set, kernels, pair, poses);
  const Vector3 axis = X_WA.R.col(axes.first);
  const Vector3 n = dot(axis, X_WB.p - X_WA.p) >= 0.0 ? axis : Vector3(-axis);
  for (int k = 0; k < 3; ++k) open.depth.n[k] = n(k);
  open.depth.known = DepthKnown::axis;
  if (axes.count > 1) return ask_touching_kernel(set, kernels, pair, poses);
  open.flush = certify_flush_boxes(kernels, a, X_WA, b, X_WB, axes.first, n);
  return open.flush->certified;
}

/// One pair by its kind's filters, the quickest first; see settle_boxes(). @param open set where unknown.
Certified certify_one(const SolidSet& set, const Kernels& kernels, const SolidPair& pair,
                      std::span<const Pose> poses, const OpenPair& open) {
  const SolidKind kind = kind_of(set, pair);
  const PoseRecord* X_W = records_of(poses);
  Certified certified = Certified::unknown;
  // In two lanes the scalar filter, which stops at the first face that separates, is faster.
  if (kind == SolidKind::box && kernels.lanes > 2)
    certified = kernels.certify_box_pair(X_W[pair.a], set.boxes[pair.a], X_W[pair.b], set.boxes[pair.b]);
  if (certified != Certified::unknown) return certified;
  if (!has_finite_poses(pair, poses)) return Certified::unknown;
  if ((kind != SolidKind::box || kernels.lanes == 2) &&
      is_ordinary(set, pair.a, poses[pair.a], pair.b, poses[pair.b]))
    certified = certify_kinds(set, pair, poses);
  if (certified != Certified::unknown) return certified;
  if (kind == SolidKind::box) certified = certify_touching_boxes(set, kernels, pair, poses, open);
  // Along a flush face's axis the hulls decide.
  if (certified != Certified::unknown || open.depth.known == DepthKnown::axis) return certified;
  certified = certify_by_coordinates(set, pair, poses);
  if (certified != Certified::unknown) return certified;
  const PairIndices indices{pair.a, pair.b};
  compute_depths(set, kernels, kind, {&indices, 1}, poses, &open.depth);
  return open.depth.certified;
}

PairStatus overlap_one(const SolidSet& set, const Kernels& kernels, const SolidPair& pair,
                       std::span<const Pose> poses) {
  if (kind_of(set, pair) == SolidKind::general) {
    if (!has_finite_poses(pair, poses)) return PairStatus::failed;
    return to_status(general_meet(set, kernels, pair, poses));
  }
  DepthRecord depth{};
  std::optional<FlushVerdict> flush;
  const Certified certified = certify_one(set, kernels, pair, poses, {depth, flush});
  if (certified != Certified::unknown) return to_status(certified == Certified::overlapping);
  if (!has_finite_poses(pair, poses)) return PairStatus::failed;
  return to_status(placed_meet(set, kernels, pair, poses, depth, flush ? &*flush : nullptr));
}

}  // namespace

Certified certify_touching_pair(const SolidSet& set, const Kernels& kernels, const SolidPair& pair,
                                std::span<const Pose> poses) {
  if (!is_ordinary(set, pair.a, poses[pair.a], pair.b, poses[pair.b])) return Certified::unknown;
  const Certified certified = certify_aligned_pair(set, pair, poses);
  return certified != Certified::unknown ? certified : ask_touching_kernel(set, kernels, pair, poses);
}

Certified certify_kinds(const SolidSet& set, const SolidPair& pair, std::span<const Pose> poses) {
  const SolidKind kind = kind_of(set, pair);
  const Pose& X_WA = poses[pair.a];
  const Pose& X_WB = poses[pair.b];
  if (kind == SolidKind::box)
    return certify_boxes(half_extents(set.boxes[pair.a]), X_WA, half_extents(set.boxes[pair.b]), X_WB);
  if (kind == SolidKind::general) return Certified::unknown;
  return certify_parallelepipeds(set.parallelepipeds[pair.a], X_WA, set.parallelepipeds[pair.b], X_WB);
}

bool hulls_meet(const Kernels& kernels, const PlacedPair& placed, const DepthRecord& depth,
                const FlushVerdict* along) {
  // Along the depth's axis, in scaled heights; what these leave open is nearly decided: exactly, then.
  const bool has_axis = depth.known != DepthKnown::nothing;
  FlushVerdict flush;
  if (along != nullptr)
    flush = *along;
  else if (has_axis)
    flush = certify_flush_along(kernels, placed, Vector3(depth.n[0], depth.n[1], depth.n[2]));
  if (flush.certified != Certified::unknown) return flush.certified == Certified::overlapping;
  numerics::ExactPair exact(placed.a_W, placed.b_W);
  const auto tried = flush.guess;
  Certified certified = tried ? numerics::certify_near(exact, *tried) : Certified::unknown;
  if (certified != Certified::unknown) return certified == Certified::overlapping;
  // In doubles.
  Portal portal;
  certified = certify_by_mpr(placed.pair.hulls, portal);
  if (certified != Certified::unknown) return certified == Certified::overlapping;
  // Along other planes, and exactly at their portals.
  if (portal.found) {
    if (!has_axis || flush.miss == FlushMiss::rounding) flush = certify_flush_along(kernels, placed, portal);
    if (!has_axis && (flush.miss == FlushMiss::rounding || flush.miss == FlushMiss::plane))
      flush = certify_flush_along(kernels, placed, best_face_normal(placed.pair));
    if (flush.certified != Certified::unknown) return flush.certified == Certified::overlapping;
    if (flush.guess && !tried) certified = numerics::certify_near(exact, *flush.guess);
    if (certified == Certified::unknown) certified = numerics::certify_near(exact, {portal.a, portal.b});
    if (certified != Certified::unknown) return certified == Certified::overlapping;
  }
  // By searching all of W.
  certified = certify_hulls(placed.pair.hulls, placed.pair.start);
  if (certified != Certified::unknown) return certified == Certified::overlapping;
  return numerics::hulls_intersect(exact);
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
