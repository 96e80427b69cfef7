#include "touchstone/contact_core/motion/edge_stretch.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace touchstone {
namespace {

/// The vertex that an edge starts from.
Vector3 start_of(const PlacedSolid& placed, const ExtremeEdge& edge) {
  return placed.vertices.vertex(std::countr_zero(edge.vertices));
}

/// How fast and how evenly two bodies move where their edges touch.
struct EdgeMotion {
  MotionBounds a, b;
  double turn() const { return a.turn + b.turn; }
  /// |N''| over |e| |f|, N = e x f.
  double turning() const {
    return ((a.turn * a.turn + a.turn_change) + (b.turn * b.turn + b.turn_change)) + 2.0 * (a.turn * b.turn);
  }
};

/// Vertices off an edge e of their body stay behind the plane along e and f: k = N . (p - v) = f . m with m =
/// (p - v) x e fixed in the body, in which f turns by no more than both turn.
class BehindEdge {
 public:
  /// @param rounding of k: a flush face's vertices are at the height of the edge.
  BehindEdge(const Vector3& f, const Vector3& turn_of_f, const EdgeMotion& motion, double rounding,
             double length)
      : f_(f),
        rate_(cross(turn_of_f, f)),
        bend_(norm(f) * (motion.turning() + 2.0 * (motion.a.turn * motion.b.turn))),
        rounding_(rounding),
        length_(length) {}

  /// @param m as above, its sign so that k > 0 behind.
  void take(const Vector3& m) {
    const double height = dot(f_, m), slope = dot(rate_, m), bend = bend_ * norm(m);
    if (!(height >= -rounding_) || !std::isfinite(bend) || !std::isfinite(slope)) length_ = 0.0;
    const double k = std::max(height, 0.0);
    if (!(k + slope * length_ - 0.5 * bend * length_ * length_ >= 0.0))
      length_ = std::min(length_, first_root(k, slope, bend));
  }
  double length() const { return length_; }

 private:
  Vector3 f_, rate_;
  double bend_, rounding_, length_;
};

}  // namespace

ExtremeEdge extreme_edge(const PlacedSolid& placed, const Vector3& n, double tolerance) {
  const WorldVertices& vertices = placed.vertices;
  std::array<double, Hexahedron::kVertices> height{};
  for (int i = 0; i < Hexahedron::kVertices; ++i) height[i] = dot(n, vertices.vertex(i));
  const double highest = *std::max_element(height.begin(), height.end());
  const unsigned distinct = distinct_vertices(*placed.moving->solid, vertices);
  int count = 0;
  std::array<int, Hexahedron::kVertices> extreme{};
  for (int i = 0; i < Hexahedron::kVertices; ++i)
    if ((distinct >> i & 1) && height[i] >= highest - tolerance) extreme[count++] = i;
  if (count != 2) return {};
  return {1u << extreme[0] | 1u << extreme[1], vertices.vertex(extreme[1]) - vertices.vertex(extreme[0])};
}

ExtremeEdges extreme_edges(const PlacedSolid& placed, const Vector3& n, double tolerance) {
  const WorldVertices& vertices = placed.vertices;
  std::array<double, Hexahedron::kVertices> height{};
  for (int i = 0; i < Hexahedron::kVertices; ++i) height[i] = dot(n, vertices.vertex(i));
  const double highest = *std::max_element(height.begin(), height.end());
  const unsigned distinct = distinct_vertices(*placed.moving->solid, vertices);
  ExtremeEdges out;
  for (int i = 0; i < Hexahedron::kVertices; ++i)
    for (int axis = 1; axis < Hexahedron::kVertices; axis *= 2) {
      const int j = i | axis;  // vertices whose numbers differ by one bit share an edge
      if (!(distinct >> i & 1) || !(distinct >> j & 1)) continue;
      if (j == i || std::min(height[i], height[j]) < highest - tolerance) continue;
      if (out.count == static_cast<int>(out.edge.size())) return {};
      out.edge[out.count++] = {1u << i | 1u << j, vertices.vertex(j) - vertices.vertex(i)};
    }
  return out;
}

bool cross_lines(const PlacedSolid& a, const PlacedSolid& b, EdgePair& edges) {
  const Vector3 &e = edges.of_a.along, &f = edges.of_b.along;
  const Vector3 p = start_of(a, edges.of_a), q = start_of(b, edges.of_b), apart = p - q;
  const double ee = dot(e, e), ef = dot(e, f), ff = dot(f, f), on_e = dot(e, apart), on_f = dot(f, apart);
  const double square = ee * ff - ef * ef;  // of |e x f|
  if (!(square > 1e-6 * (ee * ff))) return false;
  edges.p = p + ((ef * on_f - ff * on_e) / square) * e;
  edges.q = q + ((ee * on_f - ef * on_e) / square) * f;
  return true;
}

// N = e x f with edges e of a and f of b goes with both. All of an edge is at one height along it, so that of
// the edges only the points p and q where they cross matter, d = q - p: h = N . d has
//   h' = N' . d + N . d',  h'' = N'' . d + 2 N' . d' + N . d'',
// N' . d' being known at s and changing by no more than |N''| |d'| + |N'| |d''|; and is to stay above
// threshold * |N|, which is at most |N| at s and what it turns by.
Stretch edge_stretch(const PlacedSolid& a, const PlacedSolid& b, const EdgePair& pair, const Vector3& n_AB_W,
                     double tolerance, double threshold, double longest) {
  // The edges are directed so that N points from a to b.
  const Vector3 e = pair.of_a.along;
  const Vector3 f =
      dot(cross(e, pair.of_b.along), n_AB_W) < 0.0 ? Vector3(-pair.of_b.along) : pair.of_b.along;
  const Vector3 N = cross(e, f);
  const double size = norm(N), edges = norm(e) * norm(f);
  const BodyState &on_a = a.state, &on_b = b.state;
  // The motion of both edges is bounded at the points where they cross.
  const auto bounds_of = [](const PlacedSolid& placed, const Vector3& p) {
    return placed.at_rest ? MotionBounds{0.0, 0.0, 0.0, 0.0}
                          : placed.moving->path->bounds(placed.moving->body, placed.state, p);
  };
  const Vector3 &p = pair.p, &q = pair.q, d = q - p;
  const EdgeMotion motion{bounds_of(a, p), bounds_of(b, q)};
  // Rates are exact at s; their bounds hold for the whole stretch.
  const Vector3 rate = point_velocity(on_b, q) - point_velocity(on_a, p);
  const Vector3 N_rate =
      cross(cross(on_a.angular_velocity_W, e), f) + cross(e, cross(on_b.angular_velocity_W, f));
  const double acceleration = motion.a.acceleration + motion.b.acceleration;
  const double speed = std::min(motion.a.speed + motion.b.speed, norm(rate) + longest * acceleration);
  const double turning = edges * motion.turning() / size;
  const double tilt = std::min(edges * motion.turn() / size, norm(N_rate) / size + longest * turning);
  // |N| grows by its share of turning. Where the edges turn apart the bound may curve upwards: it then falls
  // below 0 and comes back, which its value at the end does not show. A straight one lies below it.
  const double bend =
      std::max(0.0, turning * (norm(d) + longest * speed) + (1.0 + longest * tilt) * acceleration +
                        2.0 * (longest * (tilt * acceleration + turning * speed) - dot(N_rate, rate) / size));
  // The distance along N is bounded from below by a parabola, and its root ends the stretch.
  const double height = dot(N, d) / size - threshold;
  const double slope = (dot(N_rate, d) + dot(N, rate)) / size - std::max(threshold, 0.0) * tilt;
  if (!std::isfinite(bend) || !std::isfinite(slope)) return {0.0, false, 0.0};  // squares overflowed
  double length = longest;
  if (!(height + slope * length - 0.5 * bend * length * length >= 0.0))
    length = std::min(length, first_root(height, slope, bend));
  // All other vertices have to stay behind the edges.
  BehindEdge behind_a(f, on_b.angular_velocity_W - on_a.angular_velocity_W, motion, tolerance * size, length);
  BehindEdge behind_b(e, on_a.angular_velocity_W - on_b.angular_velocity_W, motion, tolerance * size, length);
  for (int i = 0; i < Hexahedron::kVertices; ++i) {
    if (!(pair.of_a.vertices >> i & 1)) behind_a.take(cross(p - a.vertices.vertex(i), e));
    if (!(pair.of_b.vertices >> i & 1)) behind_b.take(cross(f, b.vertices.vertex(i) - q));
  }
  length = std::min({length, behind_a.length(), behind_b.length()});
  const bool at_end = length >= longest;
  return {std::min(length, longest), at_end, at_end ? threshold : 0.0};
}

}  // namespace touchstone
