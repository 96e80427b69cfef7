#include "touchstone/contact_core/native/overlap/flush_hulls.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "touchstone/contact_core/native/common/lanes.hpp"
#include "touchstone/contact_core/native/common/tangent_frame.hpp"
#include "touchstone/contact_core/native/overlap/gjk.hpp"
#include "touchstone/contact_core/native/overlap/mpr.hpp"
#include "touchstone/contact_core/native/solids/solid_set.hpp"

// A linear map with an inverse leaves alone whether hulls meet. This one takes p - p_W to (x . p, y . p, n .
// p), x, y, n orthonormal to a few u as doubles, and then scales the heights n . p by a power of two, 2^k.
// Let D be the largest |p - p_W|_1. What is computed is off by
//  - across: 4 roundings of terms below D, so 8 u D for all three;
//  - heights: 2^-101 D from sums in twice the precision (below), and u of the height from its last rounding;
//    scaled, with k at most kMostScale = 56, 2^-45 D and u of the scaled height.
// All are below 2^11 u D: scaled heights that count are at most 2 D. certify_hulls() allows for coordinates
// off by u * extent, so an extent of 2^12 D covers them, and what pushing (below) rounds.
//
// Heights are (p - p_W) . n with exact differences and products, but that a product below 2^-960 counts as
// rounded: 2^-1013 beside D of at least kLowest. As |n| <= 1, the products' high parts add up to D at most,
// so their low parts, those of the differences times n, and that of each sum of high parts, are u D at most.
// Adding all up, in the order of accurate_height(), rounds by 14 u^2 D < 2^-102 D, and once more with the
// high part.

namespace touchstone::native {
namespace {

using numerics::Certified;

constexpr double kErrors = 0x1p12;  // of u D, see above
constexpr int kMostScale = 56;
/// A vertex within this part of D from the plane is near it: rounding leaves it a few u of its coordinates,
/// which may be 1e5 times D. Scaling then is by at least 2^33.
constexpr double kNear = 0x1p-34;
/// A vertex further from the plane is far from it; between the two, the hulls are not flush. Pushing by 2 D
/// of scaled height goes at most 2^-8 of the way to a far vertex.
constexpr double kFar = 0x1p-24;
/// Of D, for which double-doubles neither overflow nor underflow.
constexpr double kLowest = 0x1p-300, kHighest = 0x1p300;

/// A hull in the plane's frame, heights not scaled.
struct FramedHull {
  WorldVertices p;
  std::array<std::uint8_t, 8> near{};  ///< vertices near the plane
  int near_count = 0;
  unsigned far = 0;  ///< a bit for each of the others
  int deepest = 0;   ///< the vertex furthest inside
};

/// Returns the largest |p - p_W|_1.
double to_frame(const Kernels& kernels, const WorldVertices& a_W, const WorldVertices& b_W,
                const TangentFrame& frame, const Vector3& p_W, FramedHull& a, FramedHull& b) {
  PlaneFrame plane;
  for (int k = 0; k < 3; ++k)
    plane.x[k] = frame.x(k), plane.y[k] = frame.y(k), plane.n[k] = frame.n(k), plane.p_W[k] = p_W(k);
  return kernels.put_into_frame(as_record(a_W), as_record(b_W), plane, as_record(a.p), as_record(b.p));
}

/// @param side +1 for the hull above the plane, -1 for that below.
/// False where a vertex is neither near nor far on the hull's side, or not one to four are near.
bool sort_vertices(FramedHull& hull, double side, double reach) {
  const Double2 sides = all<Double2>(side), near = all<Double2>(kNear * reach),
                far = all<Double2>(kFar * reach);
  Lanes heights;
  unsigned is_near = 0;
  for (int i = 0; i < 4; ++i) {
    heights.d[i] = sides * load(&hull.p.z[2 * i]);
    is_near |= bits(magnitude(heights.d[i]) <= near) << (2 * i);
    hull.far |= bits(heights.d[i] >= far) << (2 * i);
  }
  if ((is_near | hull.far) != 0xff) return false;
  hull.deepest = first_equal(heights, high_of(heights));
  for (unsigned rest = is_near; rest != 0; rest &= rest - 1)
    hull.near[hull.near_count++] = static_cast<std::uint8_t>(std::countr_zero(rest));
  return hull.near_count >= 1 && hull.near_count <= 4;
}

double greatest_height(const FramedHull& hull) {
  double out = 0.0;
  for (int i = 0; i < hull.near_count; ++i) out = std::max(out, std::abs(hull.p.z[hull.near[i]]));
  return out;
}

/// Equal blocks that lie flush have vertices in common: touching exactly there, they are out of reach for
/// margins.
bool share_vertex(const WorldVertices& a_W, const FramedHull& a, const WorldVertices& b_W,
                  const FramedHull& b) {
  for (int i = 0; i < a.near_count; ++i)
    for (int j = 0; j < b.near_count; ++j)
      if (a_W.vertex(a.near[i]) == b_W.vertex(b.near[j])) return true;
  return false;
}

/// The vertices near the plane, scaled; and points of the hull below them, which so has a thickness: from
/// each, and a quarter of the way to the vertex `corner`, a scaled height of `push` towards the deepest
/// vertex.
void scale_near(const FramedHull& hull, int corner, double scale, double push, WorldVertices& out) {
  const auto write = [&out](int i, const Vector3& p) {
    out.x[i] = p.x(), out.y[i] = p.y(), out.z[i] = p.z();
  };
  for (int i = 0; i < 4; ++i) {
    const Vector3 p = hull.p.vertex(hull.near[std::min(i, hull.near_count - 1)]);
    write(i, {p.x(), p.y(), scale * p.z()});
    const Vector3 within = 0.75 * p + 0.25 * hull.p.vertex(corner);
    const Vector3 inwards = hull.p.vertex(hull.deepest) - within;
    const double part = push / (scale * std::abs(inwards.z()));
    write(4 + i, {within.x() + part * inwards.x(), within.y() + part * inwards.y(),
                  scale * within.z() + scale * (part * inwards.z())});
  }
}

/// Whether sign * (axis . p) is certainly at most `limit` for the hull's far vertices, scaled.
bool all_far_within(const FramedHull& hull, const Vector3& axis, double sign, double limit, double scale,
                    double reach) {
  for (unsigned rest = hull.far; rest != 0; rest &= rest - 1) {
    const Vector3 p = hull.p.vertex(std::countr_zero(rest));
    const double height = scale * p.z();
    const double along = (axis.x() * p.x() + axis.y() * p.y()) + axis.z() * height;
    // Coordinates are off by less than 2^12 u of these magnitudes, products and sums by 3 u.
    const double error =
        0x1p-40 * ((std::abs(axis.x()) + std::abs(axis.y())) * reach + std::abs(axis.z() * height));
    if (!(sign * along + error <= limit)) return false;
  }
  return true;
}

FlushVerdict left_open(FlushMiss miss) { return {Certified::unknown, miss}; }

/// @param portal where separated: the axis; else the last portal, if there was one.
Certified certify_scaled(const HullPair& scaled, Portal& portal) {
  const Certified certified = certify_by_mpr(scaled, portal);
  return certified != Certified::unknown ? certified : certify_hulls(scaled, Vector3::UnitZ(), portal.axis);
}

/// Of a scaled hull's vertices, as scale_near() writes them: those that they are, or lie below of.
std::array<std::uint8_t, 3> vertices_near(const FramedHull& hull, const std::array<std::uint8_t, 3>& scaled) {
  std::array<std::uint8_t, 3> out;
  for (int k = 0; k < 3; ++k) out[k] = hull.near[std::min(scaled[k] % 4, hull.near_count - 1)];
  return out;
}

}  // namespace

FlushVerdict certify_flush(const Kernels& kernels, const WorldVertices& a_W, const WorldVertices& b_W,
                           const Vector3& n_AB, const Vector3& p_W) {
  const double length = norm(n_AB);
  if (!(length > kLowest && length < kHighest)) return left_open(FlushMiss::plane);
  const TangentFrame frame = tangent_frame(n_AB / length);
  FramedHull a, b;
  const double reach = to_frame(kernels, a_W, b_W, frame, p_W, a, b);
  if (!(reach > kLowest && reach < kHighest)) return left_open(FlushMiss::pair);
  if (!sort_vertices(a, -1.0, reach) || !sort_vertices(b, 1.0, reach)) return left_open(FlushMiss::plane);
  if (share_vertex(a_W, a, b_W, b)) return {Certified::overlapping, FlushMiss::none};
  const double height = std::max(greatest_height(a), greatest_height(b));
  if (height == 0.0) return left_open(FlushMiss::pair);
  const int exponent = std::ilogb(reach) - std::ilogb(height);
  if (exponent > kMostScale) return left_open(FlushMiss::pair);
  const double scale = std::ldexp(1.0, exponent);

  HullPair scaled;
  // Different corners: of equal faces, one upon the other, the difference would be symmetric about the
  // origin, which then is on an edge of every tetrahedron that either search may end with.
  scale_near(a, a.near[0], scale, 2.0 * reach, scaled.a);
  scale_near(b, b.near[b.near_count - 1], scale, 2.0 * reach, scaled.b);
  scaled.extent = kErrors * reach;
  Portal portal;
  const Certified certified = certify_scaled(scaled, portal);
  if (certified == Certified::overlapping) return {certified, FlushMiss::none};
  if (certified == Certified::separated) {
    const Vector3& axis = portal.axis;
    const double high_of_a = support_high(scaled.a, axis).value, low_of_b = support_low(scaled.b, axis).value;
    if (all_far_within(a, axis, 1.0, high_of_a, scale, reach) &&
        all_far_within(b, axis, -1.0, -low_of_b, scale, reach))
      return {certified, FlushMiss::none};
  }
  const bool are_edges = a.near_count <= 2 && b.near_count <= 2;
  FlushVerdict open = left_open(are_edges ? FlushMiss::pair : FlushMiss::rounding);
  if (portal.found) open.guess = {vertices_near(a, portal.a), vertices_near(b, portal.b)};
  return open;
}

}  // namespace touchstone::native
