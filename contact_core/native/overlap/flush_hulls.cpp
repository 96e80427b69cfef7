#include "touchstone/contact_core/native/overlap/flush_hulls.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "touchstone/contact_core/native/common/double_double.hpp"
#include "touchstone/contact_core/native/common/lanes.hpp"
#include "touchstone/contact_core/native/common/tangent_frame.hpp"
#include "touchstone/contact_core/native/overlap/gjk.hpp"
#include "touchstone/contact_core/native/overlap/mpr.hpp"

// A linear map with an inverse leaves alone whether hulls meet. This one takes p - p_W to (x . p, y . p, n .
// p), x, y, n orthonormal to a few u as doubles, and then scales the heights n . p by a power of two, 2^k.
// Let D be the largest |p - p_W|_1. What is computed is off by
//  - across: 4 roundings of terms below D, so 8 u D for all three;
//  - heights of at least kPlain = 2^-6 of their own hull's D: 4 u of that D, so 2^8 u of the height, which
//    scaling leaves;
//  - other heights: 2^-101 D from sums in twice the precision (accurate_heights() below), and u of the height
//    from its last rounding; scaled, with k at most kMostScale = 56, 2^-45 D and u of the scaled height.
// All are below 2^11 u D: scaled heights that count are at most 2 D. certify_hulls() allows for coordinates
// off by u * extent, so an extent of 2^12 D covers them, and what pushing (below) rounds.

namespace touchstone::native {
namespace {

using numerics::Certified;
using WideLanes = DoubleDoubleOf<Double2>;

constexpr double kErrors = 0x1p12;  // of u D, see above
constexpr int kMostScale = 56;
constexpr double kPlain = 0x1p-6;
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
  std::array<Vector3, 8> p;
  std::array<std::uint8_t, 8> near{};  ///< vertices near the plane
  int near_count = 0;
  unsigned far = 0;  ///< a bit for each of the others
  int deepest = 0;   ///< the vertex furthest inside
};

Double2 along(const Vector3& axis, Double2 x, Double2 y, Double2 z) {
  return (axis.x() * x + axis.y() * y) + axis.z() * z;
}

/// The heights of two vertices, right to their last bit however small (the dot product in twice the
/// precision of Ogita, Rump and Oishi 2005). Differences and products are exact with their low parts. As |n|
/// <= 1, the products' high parts add up to D at most, so their low parts, those of the differences times
/// n, and that of each sum of high parts, are u D at most. Adding all up, in the order below, rounds
/// by 14 u^2 D < 2^-102 D, and once more with the high part.
Double2 accurate_heights(const WorldVertices& v_W, int i, int j, const Vector3& n, const Vector3& p_W) {
  const WideLanes dx = two_sum(Double2{v_W.x[i], v_W.x[j]}, all<Double2>(-p_W.x())),
                  dy = two_sum(Double2{v_W.y[i], v_W.y[j]}, all<Double2>(-p_W.y())),
                  dz = two_sum(Double2{v_W.z[i], v_W.z[j]}, all<Double2>(-p_W.z()));
  const WideLanes x = two_product(dx.high, all<Double2>(n.x())),
                  y = two_product(dy.high, all<Double2>(n.y())),
                  z = two_product(dz.high, all<Double2>(n.z()));
  const WideLanes xy = two_sum(x.high, y.high), xyz = two_sum(xy.high, z.high);
  const Double2 of_differences = (dx.low * n.x() + dy.low * n.y()) + dz.low * n.z();
  const Double2 of_products = (x.low + y.low) + z.low;
  return xyz.high + (((xy.low + xyz.low) + of_products) + of_differences);
}

/// Returns the largest |p - p_W|_1.
double to_frame(const WorldVertices& v_W, const TangentFrame& frame, const Vector3& p_W, FramedHull& out) {
  Double2 reaches{};
  for (int i = 0; i < 8; i += 2) {
    const Double2 dx = load(&v_W.x[i]) - p_W.x(), dy = load(&v_W.y[i]) - p_W.y(),
                  dz = load(&v_W.z[i]) - p_W.z();
    const Double2 x = along(frame.x, dx, dy, dz), y = along(frame.y, dx, dy, dz),
                  z = along(frame.n, dx, dy, dz);
    for (int k = 0; k < 2; ++k) out.p[i + k] = {x[k], y[k], z[k]};
    reaches = greatest(reaches, (magnitude(dx) + magnitude(dy)) + magnitude(dz));
  }
  const double reach = std::max(reaches[0], reaches[1]);
  std::array<int, 9> low{};
  int count = 0;
  for (int i = 0; i < 8; ++i)
    if (!(std::abs(out.p[i].z()) >= kPlain * reach)) low[count++] = i;
  low[count] = low[std::max(count - 1, 0)];  // an odd one is its own partner
  for (int k = 0; k < count; k += 2) {
    const Double2 height = accurate_heights(v_W, low[k], low[k + 1], frame.n, p_W);
    out.p[low[k]].z() = height[0], out.p[low[k + 1]].z() = height[1];
  }
  return reach;
}

/// @param side +1 for the hull above the plane, -1 for that below.
/// False where a vertex is neither near nor far on the hull's side, or not one to four are near.
bool sort_vertices(FramedHull& hull, double side, double reach) {
  for (int i = 0; i < 8; ++i) {
    const double height = side * hull.p[i].z();
    if (height > side * hull.p[hull.deepest].z()) hull.deepest = i;
    if (std::abs(height) <= kNear * reach)
      hull.near[hull.near_count++] = static_cast<std::uint8_t>(i);
    else if (height >= kFar * reach)
      hull.far |= 1u << i;
    else
      return false;
  }
  return hull.near_count >= 1 && hull.near_count <= 4;
}

double greatest_height(const FramedHull& hull) {
  double out = 0.0;
  for (int i = 0; i < hull.near_count; ++i) out = std::max(out, std::abs(hull.p[hull.near[i]].z()));
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
    const Vector3& p = hull.p[hull.near[std::min(i, hull.near_count - 1)]];
    write(i, {p.x(), p.y(), scale * p.z()});
    const Vector3 within = 0.75 * p + 0.25 * hull.p[corner];
    const Vector3 inwards = hull.p[hull.deepest] - within;
    const double part = push / (scale * std::abs(inwards.z()));
    write(4 + i, {within.x() + part * inwards.x(), within.y() + part * inwards.y(),
                  scale * within.z() + scale * (part * inwards.z())});
  }
}

/// Whether sign * (axis . p) is certainly at most `limit` for the hull's far vertices, scaled.
bool all_far_within(const FramedHull& hull, const Vector3& axis, double sign, double limit, double scale,
                    double reach) {
  for (unsigned rest = hull.far; rest != 0; rest &= rest - 1) {
    const Vector3& p = hull.p[std::countr_zero(rest)];
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

FlushVerdict certify_flush(const WorldVertices& a_W, const WorldVertices& b_W, const Vector3& n_AB,
                           const Vector3& p_W) {
  const double length = norm(n_AB);
  if (!(length > kLowest && length < kHighest)) return left_open(FlushMiss::plane);
  const TangentFrame frame = tangent_frame(n_AB / length);
  FramedHull a, b;
  const double reach = std::max(to_frame(a_W, frame, p_W, a), to_frame(b_W, frame, p_W, b));
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
