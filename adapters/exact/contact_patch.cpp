#include "touchstone/adapters/exact/contact_patch.hpp"

#include <algorithm>
#include <cmath>

#include "touchstone/contact_core/geometry/constants.hpp"

namespace touchstone {
namespace {

struct Point2 {
  double u, v;
};

double cross2(const Point2& p, const Point2& q, const Point2& r) {
  return (q.u - p.u) * (r.v - p.v) - (q.v - p.v) * (r.u - p.u);
}

struct Polygon {
  int size = 0;
  std::array<Point2, 12> points;

  void push(const Point2& p) {
    if (size < static_cast<int>(points.size())) points[size++] = p;
  }
};

// A frame with two axes across n, and its origin near the contact so that far-away coordinates cancel first.
struct PatchFrame {
  Vector3 origin, u, v, n;

  Vector3 to_local(const Vector3& p) const {
    const Vector3 d = p - origin;
    return {dot(d, u), dot(d, v), dot(d, n)};
  }
  Vector3 to_world(const Point2& p, double height) const { return origin + u * p.u + v * p.v + n * height; }
};

PatchFrame make_frame(const Vector3& origin, const Vector3& n) {
  PatchFrame frame{origin, {}, {}, n};
  const double x = std::abs(n.x()), y = std::abs(n.y()), z = std::abs(n.z());
  Vector3 axis = x <= y && x <= z ? Vector3(1, 0, 0) : (y <= z ? Vector3(0, 1, 0) : Vector3(0, 0, 1));
  frame.u = cross(axis, n);
  frame.u /= norm(frame.u);
  frame.v = cross(n, frame.u);
  return frame;
}

using Quad = std::array<Vector3, 4>;  // in the patch frame: u, v, height

Quad quad_of(const WorldVertices& solid, int face, const PatchFrame& frame) {
  Quad quad;
  for (int k = 0; k < 4; ++k) quad[k] = frame.to_local(solid.vertex(Hexahedron::kFaceVertices[face][k]));
  return quad;
}

// Twice the vector area; its direction is the bent face's mean normal.
Vector3 area_vector(const WorldVertices& v, int face) {
  const auto& loop = Hexahedron::kFaceVertices[face];
  return cross(v.vertex(loop[2]) - v.vertex(loop[0]), v.vertex(loop[3]) - v.vertex(loop[1]));
}

int most_parallel_face(const WorldVertices& solid, const Vector3& n) {
  int best = 0;
  double best_cosine = -kInfinity;
  for (int f = 0; f < 6; ++f) {
    const Vector3 normal = area_vector(solid, f);
    const double length = norm(normal);
    if (!(length > 0.0)) continue;
    const double cosine = dot(normal, n) / length;
    if (cosine > best_cosine) {
      best_cosine = cosine;
      best = f;
    }
  }
  return best;
}

Polygon footprint(const Quad& quad) {
  Polygon polygon;
  for (const Vector3& p : quad) polygon.push({p.x(), p.y()});
  return polygon;
}

double area_of(const Polygon& polygon) {
  double twice = 0.0;
  for (int k = 1; k + 1 < polygon.size; ++k)
    twice += cross2(polygon.points[0], polygon.points[k], polygon.points[k + 1]);
  return 0.5 * twice;
}

// Sutherland and Hodgman (CACM 17(1), 1974): keeps what is left of the line from p to q.
Polygon clip(const Polygon& polygon, const Point2& p, const Point2& q) {
  Polygon out;
  for (int k = 0; k < polygon.size; ++k) {
    const Point2& from = polygon.points[k];
    const Point2& to = polygon.points[(k + 1) % polygon.size];
    const double s = cross2(p, q, from), t = cross2(p, q, to);
    if (s >= 0.0) out.push(from);
    if ((s > 0.0 && t < 0.0) || (s < 0.0 && t > 0.0)) {
      const double r = s / (s - t);
      out.push({from.u + r * (to.u - from.u), from.v + r * (to.v - from.v)});
    }
  }
  return out;
}

void make_counter_clockwise(Polygon& polygon) {
  if (area_of(polygon) < 0.0) std::reverse(polygon.points.begin(), polygon.points.begin() + polygon.size);
}

// Height over `p` of the plane through a triangle, and how far inside the triangle p is (its least
// barycentric weight).
struct Height {
  double value, inside;
};

Height height_over(const Vector3& a, const Vector3& b, const Vector3& c, const Point2& p) {
  const Point2 pa{a.x(), a.y()}, pb{b.x(), b.y()}, pc{c.x(), c.y()};
  const double whole = cross2(pa, pb, pc);
  if (whole == 0.0) return {0.0, -kInfinity};
  double wa = cross2(p, pb, pc) / whole, wb = cross2(p, pc, pa) / whole, wc = cross2(p, pa, pb) / whole;
  const double inside = std::min({wa, wb, wc});
  wa = std::max(wa, 0.0), wb = std::max(wb, 0.0), wc = std::max(wc, 0.0);
  return {(wa * a.z() + wb * b.z() + wc * c.z()) / (wa + wb + wc), inside};
}

double height_over_split(const Quad& q, int first, const Point2& p) {
  const Vector3 &a = q[first], &b = q[(first + 1) % 4], &c = q[(first + 2) % 4], &d = q[(first + 3) % 4];
  const Height abc = height_over(a, b, c, p), acd = height_over(a, c, d, p);
  return abc.inside >= acd.inside ? abc.value : acd.value;
}

// The hull's side of a bent face is the outer of its two splits.
double outer_height(const Quad& q, const Point2& p, double outward) {
  const double first = height_over_split(q, 0, p), second = height_over_split(q, 1, p);
  return outward * std::max(outward * first, outward * second);
}

}  // namespace

ContactPatch find_contact_patch(const WorldVertices& a, const WorldVertices& b, const Vector3& n_AB_W) {
  ContactPatch patch;
  patch.face_a = most_parallel_face(a, n_AB_W);
  patch.face_b = most_parallel_face(b, -n_AB_W);
  const PatchFrame frame = make_frame(a.vertex(Hexahedron::kFaceVertices[patch.face_a][0]), n_AB_W);
  const Quad quad_a = quad_of(a, patch.face_a, frame), quad_b = quad_of(b, patch.face_b, frame);
  Polygon polygon = footprint(quad_a), window = footprint(quad_b);
  make_counter_clockwise(polygon);
  make_counter_clockwise(window);
  for (int k = 0; k < window.size && polygon.size > 0; ++k) {
    polygon = clip(polygon, window.points[k], window.points[(k + 1) % window.size]);
  }
  patch.area = std::max(area_of(polygon), 0.0);
  patch.vertex_count = std::min(polygon.size, ContactPatch::kMaxVertices);
  for (int k = 0; k < patch.vertex_count; ++k) {
    const Point2& p = polygon.points[k];
    const double on_a = outer_height(quad_a, p, 1.0), on_b = outer_height(quad_b, p, -1.0);
    patch.vertices[k] = {frame.to_world(p, on_a), frame.to_world(p, on_b), on_b - on_a, 0};
  }
  return patch;
}

double patch_rounding(const WorldVertices& a, const WorldVertices& b) {
  return 0x1p-47 * std::max(largest_coordinate(a), largest_coordinate(b));
}

ContactPatch part_within(const ContactPatch& clip, const Vector3& n_AB_W, double limit) {
  ContactPatch part = clip;
  part.vertex_count = 0;
  for (int k = 0; k < clip.vertex_count; ++k)
    if (clip.vertices[k].separation <= limit) part.vertices[part.vertex_count++] = clip.vertices[k];
  if (part.vertex_count == clip.vertex_count) return part;
  Vector3 twice = Vector3::Zero();  // some corners of a convex polygon, in order, are one too
  for (int k = 1; k + 1 < part.vertex_count; ++k)
    twice += cross(part.vertices[k].p_A_W - part.vertices[0].p_A_W,
                   part.vertices[k + 1].p_A_W - part.vertices[0].p_A_W);
  part.area = 0.5 * std::abs(dot(twice, n_AB_W));
  return part;
}

int select_contact_points(const ContactPatch& patch, const Vector3& n_AB_W, std::span<ContactPoint> out) {
  std::array<ContactPoint, ContactPatch::kMaxVertices> rest = patch.vertices;
  int remaining = patch.vertex_count, count = 0;
  const auto take = [&](int k) {
    out[count++] = rest[k];
    std::copy(rest.begin() + k + 1, rest.begin() + remaining, rest.begin() + k);
    --remaining;
  };
  // Nothing is chosen where all points fit.
  const int wanted = std::min(static_cast<int>(out.size()), patch.vertex_count);
  if (wanted == patch.vertex_count) {
    std::copy_n(rest.begin(), wanted, out.begin());
    return wanted;
  }
  // The deepest comes first, since it decides the contact's depth.
  const auto deepest =
      std::min_element(rest.begin(), rest.begin() + remaining,
                       [](const auto& p, const auto& q) { return p.separation < q.separation; });
  if (wanted > 0) take(static_cast<int>(deepest - rest.begin()));
  // The farthest from it follows, then what spans the largest triangle with a chosen edge.
  while (count < wanted) {
    int best = 0;
    double best_gain = -1.0;
    for (int k = 0; k < remaining; ++k) {
      double gain = 0.0;
      if (count == 1) {
        gain = norm(rest[k].p_A_W - out[0].p_A_W);
      } else {
        for (int i = 0; i < count; ++i) {
          for (int j = i + 1; j < count; ++j) {
            const Vector3 area = cross(out[j].p_A_W - out[i].p_A_W, rest[k].p_A_W - out[i].p_A_W);
            gain = std::max(gain, std::abs(dot(area, n_AB_W)));
          }
        }
      }
      if (gain > best_gain) {
        best_gain = gain;
        best = k;
      }
    }
    take(best);
  }
  return count;
}

}  // namespace touchstone
