#include "touchstone/contact_core/native/certificate.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <optional>
#include <utility>

#include "touchstone/contact_core/geometry/difference_determinant.hpp"
#include "touchstone/contact_core/native/common/hull_pair.hpp"
#include "touchstone/contact_core/numerics/exact_predicates.hpp"

// Complete but for flat pairs. Apart: where {b - a} has volume some facet of it has the origin strictly
// beyond, and its normal is a facet's of A or B or across an edge of each (see hulls_intersect); all triples
// and pairs of lines are tried. Meeting: an extreme point of the intersection is the only common point of a
// face of A and a face of B, and lies in a simplex of either whose affine hulls have no more in common; these
// have at most five vertices in all, and where the 16 vertices span space others join, with c = 0, to make
// five that do. All fives are tried.

namespace touchstone {
namespace {

using numerics::DifferenceDeterminant;
using Difference = DifferenceDeterminant::Difference;
using Kind = OverlapCertificate::Kind;

constexpr int kFirstOfB = 8;
constexpr int kPoints = 16;

/// Covers underflow, where a product's roundings are not relative.
constexpr double kUnderflow = 0x1p-1000;

std::uint8_t index(int i) { return static_cast<std::uint8_t>(i); }

/// Both hulls about a common origin, by a power of two at an extent of 1 to 2.
native::HullPair scaled_hulls(WorldVertices a, WorldVertices b) {
  const auto scale = [](double magnitude, WorldVertices& p, WorldVertices& q) {
    const int exponent = magnitude > 0.0 ? -std::ilogb(magnitude) : 0;
    for (WorldVertices* v : {&p, &q})
      for (auto* coordinates : {&v->x, &v->y, &v->z})
        for (double& c : *coordinates) c = std::scalbn(c, exponent);
  };
  scale(std::max(largest_coordinate(a), largest_coordinate(b)), a, b);
  native::HullPair out;
  native::shift_to_common_origin(a, b, out);
  scale(out.extent, out.a, out.b);
  out.extent = 2.0;
  return out;
}

/// Calls visit(u, v) for each pair of differences whose cross product may be a facet normal of {b - a}, until
/// it returns true.
template <class Visit>
bool any_facet_direction(const Visit& visit) {
  for (const int first : {0, kFirstOfB})
    for (int i = first; i < first + 8; ++i)
      for (int j = i + 1; j < first + 8; ++j)
        for (int k = j + 1; k < first + 8; ++k)
          if (visit(Difference{i, j}, Difference{i, k})) return true;
  for (int i = 0; i < kFirstOfB; ++i)
    for (int j = i + 1; j < kFirstOfB; ++j)
      for (int k = kFirstOfB; k < kPoints; ++k)
        for (int l = k + 1; l < kPoints; ++l)
          if (visit(Difference{i, j}, Difference{k, l})) return true;
  return false;
}

struct BestAxis {
  Vector3 axis = Vector3::Zero();
  double gap = 0.0;  // above the error bound, per length of the axis

  void consider(const native::HullPair& hulls, const Vector3& n) {
    const double length = norm(n);
    if (!(length > 0.0)) return;
    const double certain =
        native::separation_along(hulls, n) - (native::projection_error(n, hulls.extent) + kUnderflow);
    if (certain > gap * length) axis = n, gap = certain / length;
  }
};

std::optional<Vector3> find_axis(const WorldVertices& a_W, const WorldVertices& b_W) {
  const native::HullPair hulls = scaled_hulls(a_W, b_W);
  const auto vertex = [&](int i) {
    return i < kFirstOfB ? hulls.a.vertex(i) : hulls.b.vertex(i - kFirstOfB);
  };
  BestAxis best;
  any_facet_direction([&](Difference u, Difference v) {
    const Vector3 n = cross(vertex(u.q) - vertex(u.p), vertex(v.q) - vertex(v.p));
    best.consider(hulls, n);
    best.consider(hulls, -n);
    return false;
  });
  if (best.gap > 0.0) return best.axis;
  return std::nullopt;
}

/// The side of u x v that all of B - A is strictly on, or 0.
int separating_side(DifferenceDeterminant& determinant, Difference u, Difference v) {
  int side = 0;
  for (int i = 0; i < kFirstOfB; ++i) {
    for (int j = kFirstOfB; j < kPoints; ++j) {
      const int s = determinant.sign(u, v, {i, j});
      if (s == 0 || s == -side) return 0;
      side = s;
    }
  }
  return side;
}

bool find_lines(DifferenceDeterminant& determinant, OverlapCertificate& out) {
  return any_facet_direction([&](Difference u, Difference v) {
    const int side = separating_side(determinant, u, v);
    if (side == 0) return false;
    if (side < 0) std::swap(u.p, u.q);
    out.lines = {{{index(u.p), index(u.q)}, {index(v.p), index(v.q)}}};
    return true;
  });
}

/// Whether the five have a Radon point with A's on one side, see OverlapCertificate.
bool has_common_point(DifferenceDeterminant& determinant, const std::array<int, 5>& points) {
  int side = 0;
  for (int k = 0; k < 5; ++k) {
    std::array<int, 4> other;
    for (int i = 0, n = 0; i < 5; ++i)
      if (i != k) other[n++] = points[i];
    const int sign = determinant.sign({other[0], other[1]}, {other[0], other[2]}, {other[0], other[3]});
    const int c = (k % 2 == 0 ? sign : -sign) * (points[k] < kFirstOfB ? 1 : -1);
    if (c * side < 0) return false;
    if (c != 0) side = c;
  }
  // All c of A have one sign, all of B the other, and their sum is zero: A's are not all zero.
  return side != 0;
}

/// The next larger number of as many bits.
unsigned next_set(unsigned set) {
  const unsigned lowest = set & (~set + 1), carried = set + lowest;
  return carried | ((carried ^ set) >> 2) / lowest;
}

bool find_common_point(DifferenceDeterminant& determinant, OverlapCertificate& out) {
  for (unsigned set = 0x1f; set < 1u << kPoints; set = next_set(set)) {
    if ((set & 0xff) == 0 || (set & 0xff00) == 0) continue;
    std::array<int, 5> points;
    unsigned rest = set;
    for (int& point : points) point = std::countr_zero(rest), rest &= rest - 1;
    if (!has_common_point(determinant, points)) continue;
    for (int k = 0; k < 5; ++k) out.vertices[k] = index(points[k]);
    return true;
  }
  return false;
}

}  // namespace

OverlapCertificate certify_overlap(const Hexahedron& a, const Pose& X_WA, const Hexahedron& b,
                                   const Pose& X_WB) {
  if (a.is_rounded() || b.is_rounded()) return {};
  WorldVertices a_W, b_W;
  world_vertices(a, X_WA, a_W);
  world_vertices(b, X_WB, b_W);
  std::array<Vector3, kPoints> points;
  for (int i = 0; i < 8; ++i) points[i] = a_W.vertex(i), points[kFirstOfB + i] = b_W.vertex(i);
  DifferenceDeterminant determinant(points);
  OverlapCertificate out;
  if (numerics::hulls_intersect(a_W, b_W)) {
    if (find_common_point(determinant, out)) out.kind = Kind::common_point;
  } else if (const std::optional<Vector3> axis = find_axis(a_W, b_W)) {
    out.kind = Kind::separating_axis;
    out.axis_W = *axis;
  } else if (find_lines(determinant, out)) {
    out.kind = Kind::separating_lines;
  }
  return out;
}

}  // namespace touchstone
