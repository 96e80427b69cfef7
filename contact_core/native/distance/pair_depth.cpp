#include "touchstone/contact_core/native/distance/pair_depth.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "touchstone/contact_core/native/solids/pair_batch.hpp"

namespace touchstone::native {
namespace {

/// Below, world vertices round by more than u of the solid's size: the kernels' bounds do not hold there.
constexpr double kLeastSize = 0x1p-1010;

/// Largest position of a pair scaled to an extent of 1: finite, so that bounds compare.
constexpr double kMostPosition = 0x1p1000;

// The kernels read eight vertices as they lie in memory: x, y, z.
static_assert(sizeof(WorldVertices) == 24 * sizeof(double));

void ask_kernel(const Kernels& kernels, SolidKind kind, const PoseRecord* poses, const BoxRecord* boxes,
                const ParallelepipedEdges* edges, const PairIndices& pair, DepthRecord& out) {
  out = kNoDepth;
  if (kind == SolidKind::box)
    kernels.compute_box_depths(poses, boxes, &pair, 1, &out);
  else if (kind == SolidKind::parallelepiped)
    kernels.compute_parallelepiped_depths(poses, edges, &pair, 1, &out);
}

Pose scaled(const Pose& X, int exponent) {
  Pose out = X;
  for (int k = 0; k < 3; ++k) out.p(k) = std::scalbn(X.p(k), exponent);
  return out;
}

}  // namespace

BoxRecord scaled(const BoxRecord& box, int exponent) {
  BoxRecord out{};
  for (int k = 0; k < 3; ++k) out.half_extents[k] = std::scalbn(box.half_extents[k], exponent);
  out.reach = (out.half_extents[0] + out.half_extents[1]) + out.half_extents[2];
  return out;
}

void find_pair_depth(const SolidSet& set, const Kernels& kernels, const SolidPair& pair,
                     std::span<const Pose> poses, DepthRecord& out) {
  ask_kernel(kernels, kind_of(set, pair), records_of(poses), set.boxes.data(),
             set.parallelepiped_edges.data(), {pair.a, pair.b}, out);
}

void find_scaled_pair_depth(const SolidSet& set, const Kernels& kernels, const SolidPair& pair,
                            std::span<const Pose> poses, DepthRecord& out) {
  out = kNoDepth;
  const double a = set.solids[pair.a].size, b = set.solids[pair.b].size;
  if (kind_of(set, pair) != SolidKind::box || !(std::min(a, b) >= kLeastSize)) return;
  const Pose& X_WA = poses[pair.a];
  const Pose& X_WB = poses[pair.b];
  const int exponent = -std::ilogb(std::max({a, b, norm_inf(X_WA.p), norm_inf(X_WB.p)}));
  const std::array<Pose, 2> scaled_poses{scaled(X_WA, exponent), scaled(X_WB, exponent)};
  const std::array<BoxRecord, 2> boxes{scaled(set.boxes[pair.a], exponent),
                                       scaled(set.boxes[pair.b], exponent)};
  ask_kernel(kernels, SolidKind::box, records_of(scaled_poses), boxes.data(), nullptr, {0, 1}, out);
  out.separation = std::scalbn(out.separation, -exponent);
  for (double& coordinate : out.p_A) coordinate = std::scalbn(coordinate, -exponent);
}

void prefetch_hull(const SolidSet& set, SolidIndex solid, bool depth, bool faces) {
  const auto fetch = [](const void* from, std::size_t bytes) {
    const auto* const first = static_cast<const char*>(from);
    for (std::size_t line = 0; line < bytes; line += 64) __builtin_prefetch(first + line);
  };
  prefetch(set.vertices[solid]);
  const SolidHull& hull = *set.solids[solid].hull;
  if (depth) fetch(&hull.record, offsetof(HullRecord, normals[1]));  // as for eight faces at most
  // What the kernel of a pair's clip reads whichever faces meet.
  const QuadFaces& quads = hull.features.quads;
  if (faces) fetch(&quads.normals, sizeof quads.normals), fetch(&quads.anchor, 1);
}

void find_hull_depth(const SolidSet& set, const Kernels& kernels, const SolidPair& pair,
                     const PlacedPair& placed, double furthest_pose, DepthRecord& out) {
  const HullView a{&set.solids[pair.a].hull->record, placed.pair.hulls.a.x.data(), placed.pair.R_WA.data()};
  const HullView b{&set.solids[pair.b].hull->record, placed.pair.hulls.b.x.data(), placed.pair.R_WB.data()};
  const double near = placed.from_world(norm_inf(placed.origin_W)) + placed.pair.hulls.extent;
  // A vertex p + R v of coordinates P comes of a v of P + |p| at most: three products' and sums' roundings of
  // |v|, 3 sqrt(3) u, beside the two of P that are counted anyhow. Nothing where the origin is in the solid.
  const double far = kFarRoundoffs * std::max(0.0, placed.from_world(furthest_pose) - near);
  const double position = std::min(near + far, kMostPosition);
  kernels.compute_hull_depth(a, b, placed.pair.hulls.extent, position, &out);
}

}  // namespace touchstone::native
