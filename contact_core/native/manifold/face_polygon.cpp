#include "touchstone/contact_core/native/manifold/face_polygon.hpp"

#include <algorithm>

namespace touchstone::native {
namespace {

/// Corners closer than this many u * extent are one corner: the edge between has no direction.
constexpr double kSameCorner = 32;
using hull_clip::kSameLean;

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
  for (int i = 0; i < N / 2; ++i) out.d[i] = __builtin_shufflevector(p.d[i], p.d[(i + 1) % (N / 2)], 1, 2);
  return out;
}

void gather(const HullFace& face, const WorldVertices& v, double sign, FacePolygon<4>& out) {
  for (int i = 0; i < 2; ++i) {
    const int k = vertex_of(face, sign, 2 * i), l = vertex_of(face, sign, 2 * i + 1);
    out.p_x.d[i] = Double2{v.x[k], v.x[l]};
    out.p_y.d[i] = Double2{v.y[k], v.y[l]};
    out.p_z.d[i] = Double2{v.z[k], v.z[l]};
  }
}

/// False when a corner is sharp.
bool project_plain(const TangentFrame& frame, bool is_b, bool swapped, FacePolygon<4>& out) {
  out.count = 4;
  for (int i = 0; i < 4; ++i) out.label[i] = edge_label(i, 4, is_b, swapped);
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
  bool all_blunt = true;
  for (int i = 0; i < 2; ++i) {
    const Double2 turn = out.edge_x.d[i] * fy.d[i] - out.edge_y.d[i] * fx.d[i];
    const Double2 least2 = (kSharp * kSharp) * (out.length2.d[i] * length2.d[i]);
    all_blunt &= bits((turn > 0.0) & (turn * turn > least2)) == 3;
  }
  return all_blunt;
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

void append(const Corner& c, double ex, double ey, double length2, FacePolygon<kMostCorners>& out) {
  const int i = out.count++;
  out.p_x.set(i, c.p.x()), out.p_y.set(i, c.p.y()), out.p_z.set(i, c.p.z());
  out.x.set(i, c.x), out.y.set(i, c.y);
  out.edge_x.set(i, ex), out.edge_y.set(i, ey);
  out.length2.set(i, length2);
  out.label[i] = c.label;
}

void append_bevelled(const Corners& polygon, FacePolygon<kMostCorners>& out) {
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
      // Half-way from the edge before to the edge after: their unit directions' difference turned left.
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

/// Replaces the polygon by its edge furthest along sign * n, and the face's plane by one through that edge.
/// False when the edge stands on end.
bool keep_edge(const TangentFrame& frame, double sign, Corners& polygon, ContactFace& face) {
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
  face.planes.anchor = from.p, face.planes.count = 1;
  face.planes.of[0] = {across, 1.0 / lean};
  return true;
}

/// Whether a corner's angle is more than 180 degrees by more than rounding.
bool is_reflex(const Corners& polygon) {
  constexpr double kStraight = 64 * kRoundoff;
  for (int i = 0; i < polygon.count; ++i) {
    const Corner &c = polygon.corners[i], &d = polygon.next(i),
                 &e = polygon.next(i + 1 < polygon.count ? i + 1 : 0);
    const double ix = d.x - c.x, iy = d.y - c.y, ox = e.x - d.x, oy = e.y - d.y;
    const double turn = ix * oy - iy * ox;
    if (turn < 0.0 && square(turn) > square(kStraight) * ((ix * ix + iy * iy) * (ox * ox + oy * oy)))
      return true;
  }
  return false;
}

/// Replaces a bent face by the one of its triangles that leans less. @param polygon in the order of the
/// face's loop where `sign` is 1, else against it.
void keep_triangle(const Bend& bend, double sign, Corners& polygon, ContactFace& face) {
  FacePlanes& planes = face.planes;
  const int kept = sign * planes.of[1].inverse < sign * planes.of[0].inverse ? 1 : 0;
  const int left_out = (bend.ridge + (kept == 0 ? 3 : 1)) % 4;  // of the loop
  const int k = sign > 0.0 ? left_out : 3 - left_out;
  // The edge over the ridge has a name that no other has.
  polygon.corners[(k + 3) % 4].label = edge_label(4, 5, sign < 0.0, face.swapped);
  std::copy(polygon.corners.begin() + k + 1, polygon.corners.begin() + 4, polygon.corners.begin() + k);
  polygon.count = 3;
  planes.of[0] = planes.of[kept], planes.count = 1;
}

}  // namespace

void find_contact_faces(const PosedPair& pair, const Vector3& n, ContactFace& a, ContactFace& b) {
  // Lane 0 is A, lane 1 is B. n_S: n in the solid's frame, times what makes dot(n_S, local normal) equal
  // dot(n, cofactor(R) * local normal).
  const Matrix3 &R_WA = pair.R_WA, &R_WB = pair.R_WB;
  std::array<std::array<Double2, 3>, 3> R, N;  // [column][row]
  for (int c = 0; c < 3; ++c)
    for (int i = 0; i < 3; ++i) R[c][i] = Double2{R_WA(i, c), R_WB(i, c)};
  std::array<Double2, 3> n_S;
  const Double2 sign = {1.0, -1.0};
  for (int c = 0; c < 3; ++c) {
    const auto &u = R[(c + 1) % 3], &v = R[(c + 2) % 3];
    for (int i = 0; i < 3; ++i) N[c][i] = u[(i + 1) % 3] * v[(i + 2) % 3] - u[(i + 2) % 3] * v[(i + 1) % 3];
    n_S[c] = ((N[c][0] * n.x() + N[c][1] * n.y()) + N[c][2] * n.z()) * sign;
  }
  const auto normals = [&](int f) {
    const Vector3 &p = pair.a->faces[f].normal, &q = pair.b->faces[f].normal;
    return std::array<Double2, 3>{Double2{p.x(), q.x()}, Double2{p.y(), q.y()}, Double2{p.z(), q.z()}};
  };
  // Faces beyond a solid's count have normal zero and lean 0, less than the best.
  const int faces = std::max(pair.a->face_count, pair.b->face_count);
  Double2 best_lean = {-1.0, -1.0}, best = {0.0, 0.0};
  for (int f = 0; f < faces; ++f) {
    const auto normal = normals(f);
    const Double2 lean = (normal[0] * n_S[0] + normal[1] * n_S[1]) + normal[2] * n_S[2];
    const auto better = lean > best_lean + kSameLean;
    const double index = f;
    best = better ? Double2{index, index} : best;
    best_lean = better ? lean : best_lean;
  }
  const Double2 inverse = sign / best_lean;  // each face found becomes one plane, two where it is bent
  const std::array<ContactFace*, 2> out = {&a, &b};
  for (int k = 0; k < 2; ++k) {
    const int index = static_cast<int>(best[k]);
    const HullFace& face = (k == 0 ? pair.a : pair.b)->faces[index];
    out[k]->face = index;
    const auto to_world = [&N, k](const Vector3& normal) {
      Vector3 out_W;
      for (int i = 0; i < 3; ++i)
        out_W(i) = (N[0][i][k] * normal.x() + N[1][i][k] * normal.y()) + N[2][i][k] * normal.z();
      return out_W;
    };
    const WorldVertices& vertices = k == 0 ? pair.hulls.a : pair.hulls.b;
    out[k]->is_steep = !(best_lean[k] >= kSteep);
    if (face.bend == HullFace::kPlane) {
      out[k]->planes.anchor = vertices.vertex(face.vertices[0]);
      out[k]->planes.count = 1;
      out[k]->planes.of[0] = {to_world(face.normal), inverse[k]};
      continue;
    }
    const Bend& bend = (k == 0 ? pair.a : pair.b)->bends[face.bend];
    out[k]->planes.anchor = vertices.vertex(face.vertices[bend.ridge]);
    out[k]->planes.count = 2;
    for (int i = 0; i < 2; ++i) {
      const Vector3 normal = to_world(bend.normals[i]);
      const double lean = dot(normal, n);
      out[k]->planes.of[i] = {normal, 1.0 / lean};
      out[k]->is_steep |= !(sign[k] * lean >= kSteep);
    }
  }
}

bool plain_polygons(const PosedPair& pair, const TangentFrame& frame, const ContactFace& a,
                    const ContactFace& b, FacePolygon<4>& polygon_a, FacePolygon<4>& polygon_b) {
  const HullFace &face_a = pair.a->faces[a.face], &face_b = pair.b->faces[b.face];
  if (face_a.count != 4 || face_b.count != 4 || a.is_steep || b.is_steep) return false;
  gather(face_a, pair.hulls.a, 1.0, polygon_a);
  gather(face_b, pair.hulls.b, -1.0, polygon_b);
  const bool plain_a = project_plain(frame, false, a.swapped, polygon_a),
             plain_b = project_plain(frame, true, b.swapped, polygon_b);
  return plain_a && plain_b;
}

bool general_polygon(const SolidFeatures& solid, const WorldVertices& vertices, double extent,
                     const TangentFrame& frame, double sign, ContactFace& face,
                     FacePolygon<kMostCorners>& out) {
  const HullFace& hull_face = solid.faces[face.face];
  const Bend* const bend = hull_face.bend == HullFace::kPlane ? nullptr : &solid.bends[hull_face.bend];
  Corners polygon;
  polygon.count = hull_face.count;
  for (int k = 0; k < hull_face.count; ++k) {
    const Vector3 p = vertices.vertex(vertex_of(hull_face, sign, k));
    polygon.corners[k] = {p, dot(p, frame.x), dot(p, frame.y),
                          edge_label(k, hull_face.count, sign < 0.0, face.swapped)};
  }
  if (face.is_steep) {
    if (!keep_edge(frame, sign, polygon, face)) return false;
  } else if (bend != nullptr && is_reflex(polygon)) {
    keep_triangle(*bend, sign, polygon, face);
  }
  polygon = distinct_corners(polygon, kSameCorner * kRoundoff * extent);
  if (polygon.count < 2) return false;
  append_bevelled(polygon, out);
  return true;
}

}  // namespace touchstone::native
