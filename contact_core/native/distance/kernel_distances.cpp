#include "touchstone/contact_core/native/distance/kernel_distances.hpp"

#include <algorithm>
#include <cmath>

#include "touchstone/contact_core/native/distance/pair_depth.hpp"

namespace touchstone::native {
namespace {

/// Below, world vertices round by more than u of the solid's size: the kernels' bounds do not hold there.
constexpr double kLeastSize = 0x1p-1010;

double magnitude_of(const SolidData& solid, const Pose& X_WS) {
  return std::max(norm_inf(X_WS.p), solid.size + solid.middle);
}

PoseRecord scaled(const PoseRecord& X, int exponent) {
  PoseRecord out = X;
  for (double& p : out.p) p = std::scalbn(p, exponent);
  return out;
}

Parallelepiped scaled_parallelepiped(const SolidSet& set, SolidIndex solid, int exponent) {
  // Fitted again: the set's record is infinite where magnitudes are not ordinary.
  Parallelepiped out =
      as_parallelepiped(local_vertices(set, solid), set.solids[solid].size).value_or(Parallelepiped{});
  for (int i = 0; i < 3; ++i) {
    for (double& p : out.half_edges[i]) p = std::scalbn(p, exponent);
    out.centre[i] = std::scalbn(out.centre[i], exponent);
  }
  out.deviation = std::scalbn(out.deviation, exponent);
  return out;
}

/// Whether compute_hull_distances() comes next, for boxes and parallelepipeds that are certainly separated.
bool vertices_decide(const DistanceRecord& record) { return record.state == DistanceState::exhausted; }

/// Computes the distances of the pairs that `wanted` picks and replaces their records.
/// @param measure (pairs, their slots in the batch, records)
template <class Wanted, class Measure>
void compute_picked(const Batch& batch, DistanceRecord* records, const Wanted& wanted,
                    const Measure& measure) {
  Batch picked;
  for (std::size_t i = 0; i < batch.count; ++i)
    if (wanted(i)) picked.add({batch.pairs[i].a, batch.pairs[i].b}, i);
  if (picked.count == 0) return;
  std::array<DistanceRecord, kBlock> found;
  measure(std::span<const PairIndices>(picked.pairs).first(picked.count), picked.slots.data(), found.data());
  for (std::size_t i = 0; i < picked.count; ++i) records[picked.slots[i]] = found[i];
}

/// The two kernels of the pair's kind on a scaled copy.
void compute_scaled_distance(const SolidSet& set, const Kernels& kernels, const SolidPair& pair,
                             std::span<const Pose> poses, DistanceRecord& record) {
  const SolidData& a = set.solids[pair.a];
  const SolidData& b = set.solids[pair.b];
  // Both are scaled by a power of two, exactly, so that the larger figure is of order one.
  if (!(std::min(a.size, b.size) >= kLeastSize)) return;
  const double high = std::max(magnitude_of(a, poses[pair.a]), magnitude_of(b, poses[pair.b]));
  const int exponent = -std::ilogb(high);
  const PoseRecord X[2] = {scaled(records_of(poses)[pair.a], exponent),
                           scaled(records_of(poses)[pair.b], exponent)};
  const PairIndices indices{0, 1};
  // The kernels, then the accurate ones.
  if (kind_of(set, pair) == SolidKind::box) {
    const BoxRecord boxes[2] = {scaled(set.boxes[pair.a], exponent), scaled(set.boxes[pair.b], exponent)};
    DepthRecord depth = kNoDepth;
    kernels.compute_box_depths(X, boxes, &indices, 1, &depth);
    const bool has_axis = depth.certified == Certified::separated;
    kernels.compute_box_distances(X, boxes, &indices, has_axis ? &depth.axis : nullptr, 1, &record);
    if (record.state != DistanceState::found)
      kernels.compute_box_distances_accurately(X, boxes, &indices, 1, &record);
  } else {
    const Parallelepiped shapes[2] = {scaled_parallelepiped(set, pair.a, exponent),
                                      scaled_parallelepiped(set, pair.b, exponent)};
    kernels.compute_parallelepiped_distances(X, shapes, &indices, nullptr, 1, &record);
    if (record.state != DistanceState::found)
      kernels.compute_parallelepiped_distances_accurately(X, shapes, &indices, 1, &record);
  }
  record.separation = std::scalbn(record.separation, -exponent);
  // Back by the same power.
  for (double& p : record.from_A) p = std::scalbn(p, -exponent);
}

}  // namespace

void compute_distances(const SolidSet& set, const Kernels& kernels, SolidKind kind,
                       std::span<const Pose> poses, std::span<const PairIndices> pairs,
                       const std::uint8_t* axes, DistanceRecord* records) {
  const PoseRecord* X_W = records_of(poses);
  if (kind == SolidKind::box)
    kernels.compute_box_distances(X_W, set.boxes.data(), pairs.data(), axes, pairs.size(), records);
  else
    kernels.compute_parallelepiped_distances(X_W, set.parallelepipeds.data(), pairs.data(), axes,
                                             pairs.size(), records);
}

void compute_distances_accurately(const SolidSet& set, const Kernels& kernels, SolidKind kind,
                                  std::span<const Pose> poses, std::span<const PairIndices> pairs,
                                  DistanceRecord* records) {
  const PoseRecord* X_W = records_of(poses);
  if (kind == SolidKind::box)
    kernels.compute_box_distances_accurately(X_W, set.boxes.data(), pairs.data(), pairs.size(), records);
  else
    kernels.compute_parallelepiped_distances_accurately(X_W, set.parallelepipeds.data(), pairs.data(),
                                                        pairs.size(), records);
}

void compute_hull_distances(const SolidSet& set, const Kernels& kernels, std::span<const Pose> poses,
                            std::span<const PairIndices> pairs, DistanceRecord* records) {
  kernels.compute_hull_distances(records_of(poses), vertex_records(set), pairs.data(), pairs.size(), records);
}

void compute_batch_distances(const SolidSet& set, const Kernels& kernels, SolidKind kind,
                             std::span<const Pose> poses, const Batch& batch, const DepthRecord* depths,
                             const Certified* decided, bool separated_too, DistanceRecord* records) {
  using Pairs = std::span<const PairIndices>;
  std::fill_n(records, batch.count, kNoDistance);
  // Pairs that the lanes certify as separated, from the axis that they found.
  const auto is_certain = [&](std::size_t i) {
    return separated_too && depths[i].certified == Certified::separated;
  };
  compute_picked(batch, records, is_certain,
                 [&](Pairs pairs, const std::uint16_t* slots, DistanceRecord* out) {
                   std::array<std::uint8_t, kBlock> axes;
                   for (std::size_t i = 0; i < pairs.size(); ++i) axes[i] = depths[slots[i]].axis;
                   compute_distances(set, kernels, kind, poses, pairs, axes.data(), out);
                 });
  // Those that are not found so, and those that other means have decided: accurately.
  compute_picked(
      batch, records,
      [&](std::size_t i) {
        if (is_certain(i)) return records[i].state != DistanceState::found;
        return separated_too && decided[i] == Certified::separated;
      },
      [&](Pairs pairs, const std::uint16_t*, DistanceRecord* out) {
        compute_distances_accurately(set, kernels, kind, poses, pairs, out);
      });
  // Hulls where vertices alone decide.
  compute_picked(
      batch, records, [&](std::size_t i) { return is_certain(i) && vertices_decide(records[i]); },
      [&](Pairs pairs, const std::uint16_t*, DistanceRecord* out) {
        compute_hull_distances(set, kernels, poses, pairs, out);
      });
}

bool finish_kernel_distance(const SolidSet& set, const Kernels& kernels, const SolidPair& pair,
                            std::span<const Pose> poses, bool separated, DistanceRecord& record) {
  const SolidKind kind = kind_of(set, pair);
  const PairIndices indices{pair.a, pair.b};
  if (record.state != DistanceState::undecided) return record.state == DistanceState::found;
  if (kind == SolidKind::general) {
    compute_hull_distances(set, kernels, poses, {&indices, 1}, &record);
    return record.state == DistanceState::found;
  }
  compute_distances_accurately(set, kernels, kind, poses, {&indices, 1}, &record);
  if (record.state == DistanceState::undecided) compute_scaled_distance(set, kernels, pair, poses, record);
  if (separated && vertices_decide(record))
    compute_hull_distances(set, kernels, poses, {&indices, 1}, &record);
  return record.state == DistanceState::found;
}

}  // namespace touchstone::native
