#include "contact_core/native/outline.hpp"

#include <algorithm>

namespace touchstone::native {
namespace {

/// Leans closer than this are equal.
constexpr double kSameLean = 4 * kRoundoff;

struct Corner {
  Vector3 p = Vector3::Zero();
  double x = 0.0, y = 0.0;
  std::uint8_t label = 0;
};

struct Corners {
  int count = 0;
  std::array<Corner, 8> corners;

  const Corner& next(int i) const { return corners[i + 1 < count ? i + 1 : 0]; }
};

double square(double x) { return x * x; }

/// Vertex k of the face in an order that is counter-clockwise seen against n.
int vertex_of(const HullFace& face, double sign, int k) {
  return face.vertices[sign > 0.0 ? k : face.count - 1 - k];
}

template <int N>
Row<N> next(const Row<N>& p) {
  Row<N> out;
  for (int i = 0; i < N / 2; ++i)
    out.d[i] = __builtin_shufflevector(p.d[i], p.d[(i + 1) % (N / 2)], 1, 2);
  return out;
}

void gather(const HullFace& face, const WorldVertices& v, double sign, Outline<4>& out) {
  for (int i = 0; i < 2; ++i) {
    const int k = vertex_of(face, sign, 2 * i), l = vertex_of(face, sign, 2 * i + 1);
    out.p_x.d[i] = Double2{v.x[k], v.x[l]};
    out.p_y.d[i] = Double2{v.y[k], v.y[l]};
    out.p_z.d[i] = Double2{v.z[k], v.z[l]};
  }
}

/// False when a corner is sharp.
bool project_plain(const TangentFrame& frame, int first_label, Outline<4>& out) {
  out.count = 4;
  for (int i = 0; i < 4; ++i) out.label[i] = static_cast<std::uint8_t>(first_label + i);
  for (int i = 0; i < 2; ++i) {
    const Double2 px = out.p_x.d[i], py = out.p_y.d[i], pz = out.p_z.d[i];
    out.x.d[i] = (px * frame.x.x() + py * frame.x.y()) + pz * frame.x.z();
    out.y.d[i] = (px * frame.y.x() + py * frame.y.y()) + pz * frame.y.z();
  }
  const Row<4> x = next(out.x), y = next(out.y);
  for (int i = 0; i < 2; ++i) {
    const Double2 ex = x.d[i] - out.x.d[i], ey = y.d[i] - out.y.d[i];
    out.edge_x.d[i] = ex, out.edge_y.d[i] = ey;
    out.length2.d[i] = ex * ex + ey * ey;
  }
  const Row<4> fx = next(out.edge_x), fy = next(out.edge_y), length2 = next(out.length2);
  unsigned blunt = 0;
  for (int i = 0; i < 2; ++i) {
    const Double2 turn = out.edge_x.d[i] * fy.d[i] - out.edge_y.d[i] * fx.d[i];
    const auto sine_is_large = turn * turn > (kSharp * kSharp) * (out.length2.d[i] * length2.d[i]);
    const auto is_blunt = sine_is_large & (turn > 0.0);
    blunt += (is_blunt[0] != 0) + (is_blunt[1] != 0);
  }
  return blunt == 4;
}

/// Into the tangent frame, without corners that repeat their predecessor.
Corners distinct_corners(const Corners& from, double tolerance) {
  Corners out;
  const auto same = [tolerance](const Corner& c, const Corner& d) {
    return std::abs(c.x - d.x) <= tolerance && std::abs(c.y - d.y) <= tolerance;
  };
  for (int i = 0; i < from.count; ++i) {
    if (out.count > 0 && same(out.corners[out.count - 1], from.corners[i])) {
      out.corners[out.count - 1].label = from.corners[i].label;  // the edge that leaves it
      continue;
    }
    out.corners[out.count++] = from.corners[i];
  }
  while (out.count > 1 && same(out.corners[out.count - 1], out.corners[0])) --out.count;
  return out;
}

void append(const Corner& c, double ex, double ey, double length2, Outline<kMostCorners>& out) {
  const int i = out.count++;
  out.p_x.set(i, c.p.x()), out.p_y.set(i, c.p.y()), out.p_z.set(i, c.p.z());
  out.x.set(i, c.x), out.y.set(i, c.y);
  out.edge_x.set(i, ex), out.edge_y.set(i, ey);
  out.length2.set(i, length2);
  out.label[i] = c.label;
}

void append_bevelled(const Corners& polygon, Outline<kMostCorners>& out) {
  out.count = 0;
  int bevels = 0;
  for (int i = 0; i < polygon.count; ++i) {
    const Corner &before = polygon.corners[i > 0 ? i - 1 : polygon.count - 1], &c = polygon.corners[i],
                 &after = polygon.next(i);
    const double ix = c.x - before.x, iy = c.y - before.y, ox = after.x - c.x, oy = after.y - c.y;
    const double in2 = ix * ix + iy * iy, out2 = ox * ox + oy * oy;
    const double turn = ix * oy - iy * ox;
    const bool blunt = turn > 0.0 && square(turn) > square(kSharp) * (in2 * out2);
    if (!blunt && ix * ox + iy * oy <= 0.0 && bevels < 2) {
      // Half way round from the edge before to the edge after: their unit directions' difference turned left.
      const double in = std::sqrt(in2), leaving = std::sqrt(out2);
      append(c, -(iy / in - oy / leaving), ix / in - ox / leaving, 0.0, out);
      ++bevels;
    }
    append(c, ox, oy, out2, out);
  }
  const int count = out.count;
  Corner last = polygon.corners[0];  // so that the last real edge ends where it should
  while (out.count < kMostCorners) append(last, 0.0, 0.0, 0.0, out);
  out.count = count;
}

/// Replaces the polygon by its edge furthest along sign * n, and the facing's plane by one through that edge.
/// False when the edge stands on end.
bool keep_edge(const TangentFrame& frame, double sign, Corners& polygon, Facing& facing) {
  int best = 0;
  double best_height = 0.0;
  for (int i = 0; i < polygon.count; ++i) {
    const double height = sign * dot(polygon.corners[i].p + polygon.next(i).p, frame.n);
    if (i == 0 || height > best_height) best = i, best_height = height;
  }
  const Corner from = polygon.corners[best], to = polygon.next(best);
  polygon.count = 2;
  polygon.corners[0] = from, polygon.corners[1] = to;
  const Vector3 along = to.p - from.p;
  const double length2 = dot(along, along);
  if (!(length2 > 0.0)) return false;
  const Vector3 across = sign * (frame.n - (dot(along, frame.n) / length2) * along);
  const double lean = dot(across, frame.n);
  if (!(sign * lean > kSteep)) return false;
  facing.normal = across, facing.anchor = from.p, facing.inverse = 1.0 / lean;
  return true;
}

}  // namespace

Facing facing(const SolidFeatures& features, const Matrix3& R, const WorldVertices& vertices, const Vector3& n,
              double sign) {
  const Vector3 x = cross(R.col(1), R.col(2)), y = cross(R.col(2), R.col(0)), z = cross(R.col(0), R.col(1));
  const Vector3 n_S = sign * Vector3(dot(x, n), dot(y, n), dot(z, n));
  int best = 0;
  double best_lean = dot(features.faces[0].normal, n_S);
  for (int f = 1; f < features.face_count; ++f) {
    const double lean = dot(features.faces[f].normal, n_S);
    const bool better = lean > best_lean + kSameLean;
    best = better ? f : best;
    best_lean = better ? lean : best_lean;
  }
  const HullFace& face = features.faces[best];
  Facing out;
  out.face = best;
  for (int i = 0; i < 3; ++i)
    out.normal(i) = (x(i) * face.normal.x() + y(i) * face.normal.y()) + z(i) * face.normal.z();
  out.anchor = vertices.vertex(face.vertices[0]);
  out.inverse = 1.0 / dot(out.normal, n);
  out.is_steep = !(best_lean >= kSteep);
  return out;
}

bool plain_outlines(const PosedPair& pair, const TangentFrame& frame, const Facing& a, const Facing& b,
                    Outline<4>& outline_a, Outline<4>& outline_b) {
  const HullFace &face_a = pair.a->faces[a.face], &face_b = pair.b->faces[b.face];
  if (face_a.count != 4 || face_b.count != 4 || a.is_steep || b.is_steep) return false;
  gather(face_a, pair.hulls.a, 1.0, outline_a);
  gather(face_b, pair.hulls.b, -1.0, outline_b);
  const bool plain_a = project_plain(frame, 0, outline_a), plain_b = project_plain(frame, 8, outline_b);
  return plain_a && plain_b;
}

bool careful_outline(const HullFace& face, const WorldVertices& vertices, double extent,
                     const TangentFrame& frame, double sign, Facing& facing, Outline<kMostCorners>& outline) {
  Corners polygon;
  polygon.count = face.count;
  for (int k = 0; k < face.count; ++k) {
    const Vector3 p = vertices.vertex(vertex_of(face, sign, k));
    polygon.corners[k] = {p, dot(p, frame.x), dot(p, frame.y),
                          static_cast<std::uint8_t>(sign > 0.0 ? k : 8 + k)};
  }
  if (facing.is_steep && !keep_edge(frame, sign, polygon, facing)) return false;
  polygon = distinct_corners(polygon, kSameCorner * extent);
  if (polygon.count < 2) return false;
  append_bevelled(polygon, outline);
  return true;
}

}  // namespace touchstone::native
