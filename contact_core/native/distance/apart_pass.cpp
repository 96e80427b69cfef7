#include "touchstone/contact_core/native/distance/apart_pass.hpp"

#include <algorithm>
#include <cmath>

#include "touchstone/contact_core/native/distance/pair_depth.hpp"

namespace touchstone::native {
namespace {

/// Below, world vertices round by more than u of the solid's size: the kernels' bounds do not hold there.
constexpr double kLeastSize = 0x1p-1010;

const PoseRecord* records_of(std::span<const Pose> poses) {
  return reinterpret_cast<const PoseRecord*>(poses.data());  // the layout is asserted in overlap.cpp
}

double largest(const Vector3& p) { return std::max({std::abs(p.x()), std::abs(p.y()), std::abs(p.z())}); }

double magnitude_of(const Hexahedron& solid, const Pose& X_WS) {
  return std::max(largest(X_WS.p), solid.size() + largest(solid.bounding_sphere().centre));
}

PoseRecord scaled(const PoseRecord& X, int exponent) {
  PoseRecord out = X;
  for (double& p : out.p) p = std::scalbn(p, exponent);
  return out;
}

BoxRecord scaled_box(const Hexahedron& solid, int exponent) {
  BoxRecord out{};
  for (int i = 0; i < 3; ++i) out.half_extents[i] = std::scalbn(solid.half_extents()(i), exponent);
  out.reach = (out.half_extents[0] + out.half_extents[1]) + out.half_extents[2];
  return out;
}

ParallelepipedRecord scaled_form(const Parallelepiped& form, int exponent) {
  ParallelepipedRecord out{};
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) out.half_edges[i][k] = std::scalbn(form.half_edges[i](k), exponent);
    out.centre[i] = std::scalbn(form.centre(i), exponent);
  }
  out.deviation = std::scalbn(form.deviation, exponent);
  return out;
}

/// Boxes and parallelepipeds that are certainly apart: whether measure_hulls_apart() comes next.
bool vertices_decide(const ApartRecord& record) { return record.state == ApartState::lost; }

/// Measures the pairs whose records `wanted` picks, and writes those records anew.
template <class Wanted, class Measure>
void measure_picked(const Batch& batch, const DepthRecord* depths, ApartRecord* records, const Wanted& wanted,
                    const Measure& measure) {
  Batch picked;
  for (std::size_t i = 0; i < batch.count; ++i)
    if (wanted(depths[i].certified, records[i])) picked.add({batch.pairs[i].a, batch.pairs[i].b}, i);
  if (picked.count == 0) return;
  std::array<ApartRecord, kBlock> found;
  measure(std::span<const PairIndices>(picked.pairs).first(picked.count), found.data());
  for (std::size_t i = 0; i < picked.count; ++i) records[picked.slots[i]] = found[i];
}

/// The first try and the second on a scaled copy.
void measure_scaled(const SolidSet& set, const Kernels& kernels, const SolidPair& pair,
                    std::span<const Pose> poses, ApartRecord& record) {
  const Hexahedron& a = set.solids[pair.a].shape;
  const Hexahedron& b = set.solids[pair.b].shape;
  if (!(std::min(a.size(), b.size()) >= kLeastSize)) return;
  const double high = std::max(magnitude_of(a, poses[pair.a]), magnitude_of(b, poses[pair.b]));
  const int exponent = -std::ilogb(high);
  const PoseRecord X[2] = {scaled(records_of(poses)[pair.a], exponent),
                           scaled(records_of(poses)[pair.b], exponent)};
  const PairIndices indices{0, 1};
  if (kind_of(set, pair) == SolidKind::box) {
    const BoxRecord boxes[2] = {scaled_box(a, exponent), scaled_box(b, exponent)};
    kernels.measure_boxes_apart(X, boxes, &indices, 1, &record);
    if (record.state != ApartState::found)
      kernels.measure_boxes_apart_accurately(X, boxes, &indices, 1, &record);
  } else {
    const ParallelepipedRecord forms[2] = {scaled_form(set.parallelepipeds[pair.a], exponent),
                                           scaled_form(set.parallelepipeds[pair.b], exponent)};
    kernels.measure_parallelepipeds_apart(X, forms, &indices, 1, &record);
    if (record.state != ApartState::found)
      kernels.measure_parallelepipeds_apart_accurately(X, forms, &indices, 1, &record);
  }
  record.separation = std::scalbn(record.separation, -exponent);
  for (double& p : record.from_A) p = std::scalbn(p, -exponent);
}

}  // namespace

void measure_apart(const SolidSet& set, const Kernels& kernels, SolidKind kind, std::span<const Pose> poses,
                   std::span<const PairIndices> pairs, ApartRecord* records) {
  const PoseRecord* X_W = records_of(poses);
  if (kind == SolidKind::box)
    kernels.measure_boxes_apart(X_W, set.boxes.data(), pairs.data(), pairs.size(), records);
  else
    kernels.measure_parallelepipeds_apart(X_W, set.forms.data(), pairs.data(), pairs.size(), records);
}

void measure_apart_accurately(const SolidSet& set, const Kernels& kernels, SolidKind kind,
                              std::span<const Pose> poses, std::span<const PairIndices> pairs,
                              ApartRecord* records) {
  const PoseRecord* X_W = records_of(poses);
  if (kind == SolidKind::box)
    kernels.measure_boxes_apart_accurately(X_W, set.boxes.data(), pairs.data(), pairs.size(), records);
  else
    kernels.measure_parallelepipeds_apart_accurately(X_W, set.forms.data(), pairs.data(), pairs.size(),
                                                     records);
}

void measure_hulls_apart(const SolidSet& set, const Kernels& kernels, std::span<const Pose> poses,
                         std::span<const PairIndices> pairs, ApartRecord* records) {
  kernels.measure_hulls_apart(records_of(poses), set.vertices.data(), pairs.data(), pairs.size(), records);
}

void measure_batch_apart(const SolidSet& set, const Kernels& kernels, SolidKind kind,
                         std::span<const Pose> poses, const Batch& batch, const DepthRecord* depths,
                         bool separated_too, ApartRecord* records) {
  using Pairs = std::span<const PairIndices>;
  std::fill_n(records, batch.count, kNoDistance);
  measure_picked(
      batch, depths, records,
      [&](Certified certified, const ApartRecord&) {
        return separated_too && certified == Certified::separated;
      },
      [&](Pairs pairs, ApartRecord* out) { measure_apart(set, kernels, kind, poses, pairs, out); });
  measure_picked(
      batch, depths, records,
      [&](Certified certified, const ApartRecord& record) {
        if (certified == Certified::separated) return separated_too && record.state != ApartState::found;
        return certified == Certified::unknown;
      },
      [&](Pairs pairs, ApartRecord* out) {
        measure_apart_accurately(set, kernels, kind, poses, pairs, out);
      });
  measure_picked(
      batch, depths, records,
      [&](Certified certified, const ApartRecord& record) {
        return separated_too && certified == Certified::separated && vertices_decide(record);
      },
      [&](Pairs pairs, ApartRecord* out) { measure_hulls_apart(set, kernels, poses, pairs, out); });
}

bool finish_apart(const SolidSet& set, const Kernels& kernels, const SolidPair& pair,
                  std::span<const Pose> poses, bool separated, ApartRecord& record) {
  const SolidKind kind = kind_of(set, pair);
  const PairIndices indices{pair.a, pair.b};
  if (record.state != ApartState::open) return record.state == ApartState::found;
  if (kind == SolidKind::general) {
    measure_hulls_apart(set, kernels, poses, {&indices, 1}, &record);
    return record.state == ApartState::found;
  }
  measure_apart_accurately(set, kernels, kind, poses, {&indices, 1}, &record);
  if (record.state == ApartState::open) measure_scaled(set, kernels, pair, poses, record);
  if (separated && vertices_decide(record)) measure_hulls_apart(set, kernels, poses, {&indices, 1}, &record);
  return record.state == ApartState::found;
}

}  // namespace touchstone::native
