#include "contact_core/native/apart_pass.hpp"

#include <algorithm>
#include <cmath>

#include "contact_core/native/pair_depth.hpp"

namespace touchstone::native {
namespace {

/// Beyond these magnitudes a pair is measured on an exactly scaled copy; well within what the kernels take.
constexpr double kUnscaledLow = 0x1p-60;
constexpr double kUnscaledHigh = 0x1p60;
/// Below, world vertices round by more than u of the solid's size: the kernels' bounds do not hold there.
constexpr double kLeastSize = 0x1p-1010;

const PoseRecord* records_of(std::span<const Pose> poses) {
  return reinterpret_cast<const PoseRecord*>(poses.data());  // the layout is asserted in overlap.cpp
}

double largest(const Vector3& p) { return std::max({std::abs(p.x()), std::abs(p.y()), std::abs(p.z())}); }

double magnitude_of(const Hexahedron& solid, const Pose& X_WS) {
  return std::max(largest(X_WS.p), solid.size() + largest(solid.bounding_sphere().centre));
}

bool needs_scaling(const SolidSet& set, const SolidPair& pair, std::span<const Pose> poses) {
  const Hexahedron& a = set.solids[pair.a].shape;
  const Hexahedron& b = set.solids[pair.b].shape;
  const double high = std::max(magnitude_of(a, poses[pair.a]), magnitude_of(b, poses[pair.b]));
  return !(high < kUnscaledHigh) || std::min(a.size(), b.size()) < kUnscaledLow;
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

}  // namespace

void measure_apart(const SolidSet& set, const Kernels& kernels, SolidKind kind, std::span<const Pose> poses,
                   std::span<const PairIndices> pairs, ApartRecord* records) {
  const PoseRecord* X_W = records_of(poses);
  if (kind == SolidKind::box)
    kernels.measure_boxes_apart(X_W, set.boxes.data(), pairs.data(), pairs.size(), records);
  else if (kind == SolidKind::parallelepiped)
    kernels.measure_parallelepipeds_apart(X_W, set.forms.data(), pairs.data(), pairs.size(), records);
  else
    kernels.measure_hulls_apart(X_W, set.vertices.data(), pairs.data(), pairs.size(), records);
}

bool measure_apart_accurately(const SolidSet& set, const Kernels& kernels, const SolidPair& pair,
                              std::span<const Pose> poses, ApartRecord& record) {
  record.fits = record.found = false;
  const SolidKind kind = kind_of(set, pair);
  if (kind == SolidKind::general) return false;
  const Hexahedron& a = set.solids[pair.a].shape;
  const Hexahedron& b = set.solids[pair.b].shape;
  if (!(std::min(a.size(), b.size()) >= kLeastSize)) return false;
  const bool scaling = needs_scaling(set, pair, poses);
  const double high = std::max(magnitude_of(a, poses[pair.a]), magnitude_of(b, poses[pair.b]));
  const int exponent = scaling ? -std::ilogb(high) : 0;
  const PoseRecord X[2] = {scaled(records_of(poses)[pair.a], exponent),
                           scaled(records_of(poses)[pair.b], exponent)};
  const PairIndices indices{0, 1};
  if (kind == SolidKind::box) {
    const BoxRecord boxes[2] = {scaled_box(a, exponent), scaled_box(b, exponent)};
    if (scaling) kernels.measure_boxes_apart(X, boxes, &indices, 1, &record);
    if (!record.found) kernels.measure_boxes_apart_accurately(X, boxes, indices, record);
  } else {
    const ParallelepipedRecord forms[2] = {scaled_form(set.parallelepipeds[pair.a], exponent),
                                           scaled_form(set.parallelepipeds[pair.b], exponent)};
    if (scaling) kernels.measure_parallelepipeds_apart(X, forms, &indices, 1, &record);
    if (!record.found) kernels.measure_parallelepipeds_apart_accurately(X, forms, indices, record);
  }
  record.separation = std::scalbn(record.separation, -exponent);
  for (double& p : record.from_A) p = std::scalbn(p, -exponent);
  return record.found;
}

}  // namespace touchstone::native
