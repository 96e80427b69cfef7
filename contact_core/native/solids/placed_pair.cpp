#include "touchstone/contact_core/native/solids/placed_pair.hpp"

#include <algorithm>
#include <cmath>

namespace touchstone::native {
namespace {

/// Below zero, zero or above.
int compare(const Vector3& p, const Vector3& q) {
  for (int i = 0; i < 3; ++i)
    if (p(i) != q(i)) return p(i) < q(i) ? -1 : 1;
  return 0;
}

void scale(WorldVertices& v, int exponent) {
  for (int i = 0; i < 8; ++i) {
    v.x[i] = std::scalbn(v.x[i], exponent);
    v.y[i] = std::scalbn(v.y[i], exponent);
    v.z[i] = std::scalbn(v.z[i], exponent);
  }
}

double scaled(double length, int exponent) { return exponent == 0 ? length : std::scalbn(length, exponent); }

Vector3 scaled(const Vector3& p, int exponent) {
  if (exponent == 0) return p;
  return {std::scalbn(p.x(), exponent), std::scalbn(p.y(), exponent), std::scalbn(p.z(), exponent)};
}

/// All but the vertices.
void complete(const SolidSet& set, const SolidPair& solids, const Pose& X_WA, const Pose& X_WB,
              PosedPair& pair) {
  pair.a = &set.solids[solids.a].hull->features, pair.b = &set.solids[solids.b].hull->features;
  pair.R_WA = X_WA.R, pair.R_WB = X_WB.R;
  pair.start =
      (pair.hulls.b.vertex(0) - pair.hulls.a.vertex(0)) + (pair.hulls.b.vertex(7) - pair.hulls.a.vertex(7));
}

/// A power of two that brings `magnitude` to [1, 2).
int exponent_for(double magnitude) { return magnitude > 0.0 ? -std::ilogb(magnitude) : 0; }

}  // namespace

bool is_ordinary(const SolidSet& set, SolidIndex a, const Pose& X_WA, SolidIndex b, const Pose& X_WB) {
  return set.ordinary[a] && set.ordinary[b] && norm_inf(X_WA.p) <= kOrdinaryHigh &&
         norm_inf(X_WB.p) <= kOrdinaryHigh;
}

bool comes_first(const SolidSet& set, const SolidPair& pair, const Pose& X_WA, const Pose& X_WB) {
  if (const int order = compare(X_WA.p, X_WB.p)) return order < 0;
  for (int i = 0; i < 3; ++i)
    if (const int order = compare(X_WA.R.col(i), X_WB.R.col(i))) return order < 0;
  const WorldVertices& a = local_vertices(set, pair.a);
  const WorldVertices& b = local_vertices(set, pair.b);
  for (int i = 0; i < Hexahedron::kVertices; ++i)
    if (const int order = compare(a.vertex(i), b.vertex(i))) return order < 0;
  return true;
}

Vector3 PlacedPair::scaled_to_world(const Vector3& p) const { return origin_W + scaled(p, -exponent); }

double PlacedPair::to_world(double length) const { return scaled(length, -exponent); }

/// Scaled first: the difference could overflow.
Vector3 PlacedPair::from_world(const Vector3& p_W) const {
  return scaled(p_W, exponent) - scaled(origin_W, exponent);
}

double PlacedPair::from_world(double length) const { return scaled(length, exponent); }

void place(const SolidSet& set, const SolidPair& solids, const Pose& X_WA, const Pose& X_WB, bool ordinary,
           PlacedPair& out) {
  native::world_vertices(local_vertices(set, solids.a), X_WA, out.a_W);
  native::world_vertices(local_vertices(set, solids.b), X_WB, out.b_W);
  out.origin_W = out.a_W.vertex(0);
  out.exponent = 0;
  PosedPair& pair = out.pair;
  if (ordinary) {
    shift_to_common_origin(out.a_W, out.b_W, pair.hulls);
  } else {
    // First the coordinates, so that differences cannot overflow; then, about the common origin, the extent.
    WorldVertices a_scaled = out.a_W, b_scaled = out.b_W;
    out.exponent = exponent_for(std::max(largest_coordinate(out.a_W), largest_coordinate(out.b_W)));
    scale(a_scaled, out.exponent), scale(b_scaled, out.exponent);
    shift_to_common_origin(a_scaled, b_scaled, pair.hulls);
    const int second = exponent_for(pair.hulls.extent);
    scale(pair.hulls.a, second), scale(pair.hulls.b, second);
    pair.hulls.extent = std::scalbn(pair.hulls.extent, second);
    out.exponent += second;
  }
  complete(set, solids, X_WA, X_WB, pair);
}

void place_in_lanes(const SolidSet& set, const Kernels& kernels, const SolidPair& solids,
                    std::span<const Pose> poses, PlacedPair& out) {
  const PoseRecord* const X_W = records_of(poses);
  const VertexRecord* const v_S = vertex_records(set);
  HullPair& hulls = out.pair.hulls;
  hulls.extent =
      kernels.place_hulls(X_W[solids.a], v_S[solids.a], X_W[solids.b], v_S[solids.b], as_record(out.a_W),
                          as_record(out.b_W), as_record(hulls.a), as_record(hulls.b));
  out.origin_W = out.a_W.vertex(0);
  out.exponent = 0;
  complete(set, solids, poses[solids.a], poses[solids.b], out.pair);
}

}  // namespace touchstone::native
