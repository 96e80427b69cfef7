#include "touchstone/contact_core/motion/clear_stretch.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace touchstone {
namespace {

/// Not in contact, other planes are looked for where the closest points' clears less than this share, or
/// after so many queries.
constexpr double kShort = 4.0 * kStalled;
constexpr int kManyQueries = 12;
/// Heights and sums of them round by far less, per metre.
constexpr double kRoundingShare = 0x1p-40;

/// A direction on which two solids are projected, and how it turns from s on. What turns with a body is the
/// plane of one of its faces; two edges that slide over each other span one that turns with both.
struct Direction {
  Vector3 n;
  Vector3 turn = Vector3::Zero();      ///< angular velocity; zero: fixed in the world
  Vector3 centre = Vector3::Zero();    ///< heights are over this point
  Vector3 velocity = Vector3::Zero();  ///< its own
  double longest = 0.0;                ///< how far on curvatures hold

  bool is_fixed() const { return turn == Vector3::Zero(); }
};

/// Vertices' paths along n from s on: value + slope t -+ curvature t^2 / 2.
struct Extent {
  int count = 0;
  std::array<double, Hexahedron::kVertices> value, slope, curvature;
};

using Heights = std::array<double, Hexahedron::kVertices>;

Heights heights_along(const PlacedSolid& placed, const Vector3& n) {
  Heights out;
  for (int i = 0; i < Hexahedron::kVertices; ++i) out[i] = dot(n, placed.vertices.vertex(i));
  return out;
}

/// Of a point that a steady body carries, seen from a direction that turns. With D from the direction's
/// centre to the body's, r from there to the point, w the body's and o the direction's angular velocity:
///   (n . (D + r))'' = (o x (o x n)) . D + 2 (o x n) . D' + n . (d x (d x r) + (d x o) x r),  d = w - o,
/// where |o x n|, |r| and |D'| stay as they are and D changes by at most `longest` |D'|. A body that does not
/// turn has its centre in the point.
double turning_curvature(const Direction& along, const BodyState& state, const Vector3& p) {
  const bool turns = state.angular_velocity_W != Vector3::Zero();
  const Vector3 D = (turns ? state.centre_W : p) - along.centre;
  const Vector3 rate = state.velocity_W - along.velocity;
  const double tilt = norm(cross(along.turn, along.n));
  const double reach = norm(cross(along.turn, D)) + along.longest * norm(cross(along.turn, rate));
  double bound = tilt * (reach + 2.0 * norm(rate));
  const double relative = norm(state.angular_velocity_W - along.turn);
  if (turns && relative > 0.0) bound += relative * (relative + norm(along.turn)) * norm(p - state.centre_W);
  return bound;
}

/// Of the vertices whose bit in `which` is set.
Extent extent_along(const PlacedSolid& placed, const Direction& along, const Heights& heights,
                    unsigned which) {
  Extent out;
  const BodyState& state = placed.state;
  const bool stands = placed.at_rest && along.is_fixed();
  std::array<Vector3, Hexahedron::kVertices> points;
  for (int i = 0; i < Hexahedron::kVertices; ++i) {
    if (!(which >> i & 1)) continue;
    const int k = out.count++;
    out.value[k] = heights[i];
    out.slope[k] = out.curvature[k] = 0.0;
    if (stands) continue;
    const Vector3 p = points[k] = placed.vertices.vertex(i);
    out.slope[k] = dot(along.n, state.velocity_W + cross(state.angular_velocity_W, p - state.centre_W));
    if (along.is_fixed()) continue;
    out.slope[k] += dot(cross(along.turn, along.n), p - along.centre) - dot(along.n, along.velocity);
    out.curvature[k] = turning_curvature(along, state, p);
  }
  if (!stands && along.is_fixed())
    placed.moving->path->curvature_bounds(placed.moving->body, state, std::span(points).first(out.count),
                                          along.n, std::span(out.curvature).first(out.count));
  return out;
}

/// Vertices that could matter on a stretch: those of the others that no way is long enough for are only
/// known to stay `least` apart from what is before them.
struct Meeting {
  unsigned of_a = 0, of_b = 0;
  double least = std::numeric_limits<double>::infinity();
};

Meeting meeting_vertices(const PlacedSolid& a, const PlacedSolid& b, const Heights& on_a, const Heights& on_b,
                         double threshold, double longest) {
  const auto way = [&](const PlacedSolid& placed) {
    return placed.at_rest ? 0.0 : placed.moving->travel * longest;
  };
  const double highest = *std::max_element(on_a.begin(), on_a.end()) + way(a);
  const double lowest = *std::min_element(on_b.begin(), on_b.end()) - way(b);
  // What heights and sums round is far less.
  const double enough = std::max(threshold, 0.0) + kRoundingShare * (std::abs(highest) + std::abs(lowest));
  Meeting out;
  const auto leave_out = [&](double apart) {
    if (!(apart > enough)) return false;
    out.least = std::min(out.least, apart);
    return true;
  };
  for (int i = 0; i < Hexahedron::kVertices; ++i) {
    if (!leave_out(lowest - (on_a[i] + way(a)))) out.of_a |= 1u << i;
    if (!leave_out((on_b[i] - way(b)) - highest)) out.of_b |= 1u << i;
  }
  return out;
}

/// The first t at which c + b t - q t^2 / 2 falls below 0; c is taken as at least 0.
double first_root(double c, double b, double q) {
  if (c < 0.0) c = 0.0;
  if (q <= 0.0) return b < 0.0 ? c / -b : std::numeric_limits<double>::infinity();
  const double root = std::sqrt(b * b + 2.0 * q * c);
  return b < 0.0 ? 2.0 * c / (root - b) : (root + b) / q;
}

/// How far on from s the projections on n are sure to stay apart by `threshold`; at most `longest`.
Stretch clear_stretch(const PlacedSolid& a, const PlacedSolid& b, const Direction& along, double threshold,
                      double longest) {
  const Heights heights_a = heights_along(a, along.n), heights_b = heights_along(b, along.n);
  Meeting meeting{0xff, 0xff};
  if (along.is_fixed()) meeting = meeting_vertices(a, b, heights_a, heights_b, threshold, longest);
  if (meeting.of_a == 0 || meeting.of_b == 0) return {longest, true, meeting.least};
  const Extent on_a = extent_along(a, along, heights_a, meeting.of_a);
  const Extent on_b = extent_along(b, along, heights_b, meeting.of_b);
  double stretch = longest;
  for (int i = 0; i < on_a.count; ++i) {
    for (int j = 0; j < on_b.count; ++j) {
      const double c = (on_b.value[j] - on_a.value[i]) - threshold;
      const double slope = on_b.slope[j] - on_a.slope[i];
      const double curvature = on_b.curvature[j] + on_a.curvature[i];
      if (c + slope * stretch - 0.5 * curvature * stretch * stretch >= 0.0) continue;
      stretch = std::min(stretch, first_root(c, slope, curvature));
    }
  }
  if (stretch < longest) return {stretch, false, 0.0};
  double least = meeting.least;
  for (int i = 0; i < on_a.count; ++i)
    for (int j = 0; j < on_b.count; ++j)
      least = std::min(least, (on_b.value[j] - on_a.value[i]) + (on_b.slope[j] - on_a.slope[i]) * longest -
                                  0.5 * (on_b.curvature[j] + on_a.curvature[i]) * longest * longest);
  return {stretch, true, least};
}

/// Separation of the two along n as they are placed.
double separation_along(const PlacedSolid& a, const PlacedSolid& b, const Vector3& n) {
  double highest = dot(n, a.vertices.vertex(0)), lowest = dot(n, b.vertices.vertex(0));
  for (int i = 1; i < Hexahedron::kVertices; ++i) {
    highest = std::max(highest, dot(n, a.vertices.vertex(i)));
    lowest = std::min(lowest, dot(n, b.vertices.vertex(i)));
  }
  return lowest - highest;
}

/// Steady on its way, or at rest.
bool is_steady(const PlacedSolid& placed) { return placed.at_rest || placed.moving->path->is_steady(); }

/// The edge that is a solid's extreme along n, to `tolerance`: its direction. Zero if a vertex or a face is.
Vector3 extreme_edge(const PlacedSolid& placed, const Vector3& n, double tolerance) {
  const WorldVertices& vertices = placed.vertices;
  std::array<double, Hexahedron::kVertices> height{};
  for (int i = 0; i < Hexahedron::kVertices; ++i) height[i] = dot(n, vertices.vertex(i));
  const double highest = *std::max_element(height.begin(), height.end());
  int count = 0;
  std::array<int, Hexahedron::kVertices> extreme{};
  for (int i = 0; i < Hexahedron::kVertices; ++i)
    if (height[i] >= highest - tolerance) extreme[count++] = i;
  return count == 2 ? Vector3(vertices.vertex(extreme[1]) - vertices.vertex(extreme[0])) : Vector3::Zero();
}

/// Of the plane that two edges in contact span, both going their ways: n = e x f / |e x f|, and so is n'.
Direction edge_direction(const PlacedSolid& a, const PlacedSolid& b, const PairGeometry& geometry,
                         double tolerance) {
  Direction along{geometry.n_AB_W};
  const Vector3& n = geometry.n_AB_W;
  const Vector3 e = extreme_edge(a, n, tolerance), f = extreme_edge(b, -n, tolerance);
  const double across = dot(n, cross(e, f));
  if (!(std::abs(across) > 1e-3 * norm(e) * norm(f))) return along;
  const BodyState &on_a = a.state, &on_b = b.state;
  const Vector3 rate =
      (cross(cross(on_a.angular_velocity_W, e), f) + cross(e, cross(on_b.angular_velocity_W, f))) / across;
  along.turn = cross(n, rate);
  // Midway, so that (b, a) gives the same.
  along.centre = 0.5 * (geometry.p_A_W + geometry.p_B_W);
  const auto velocity_on = [&](const BodyState& state) {
    return Vector3(state.velocity_W + cross(state.angular_velocity_W, along.centre - state.centre_W));
  };
  along.velocity = 0.5 * (velocity_on(on_a) + velocity_on(on_b));
  return along;
}

/// Closest points of two solids that pass each other at the gap's height point across their corners, and
/// would stop a motion along abutting faces at every seam; a plane fixed in the world is left by a body that
/// turns on a contact. Any other plane that keeps half the gap will do: of the faces' own, fixed or turning
/// with their bodies, and of the edges in contact, the one that lets most of the motion through.
class WidestStretch {
 public:
  /// @param from_afar the threshold of a pair that is not in contact; 0: it is.
  WidestStretch(const PlacedSolid& a, const PlacedSolid& b, const GapRule& rule, double scale,
                double from_afar, double longest, const Stretch& so_far)
      : a_(a), b_(b), rule_(rule), scale_(scale), from_afar_(from_afar), longest_(longest), widest_(so_far) {}

  Stretch find(const PairGeometry& geometry) {
    const bool steady = is_steady(a_) && is_steady(b_);
    if (steady) try_direction(edge_direction(a_, b_, geometry, 2.0 * kSeparationRounding * scale_), false);
    for (int f = 0; f < 12 && !widest_.at_end; ++f) {
      const Vector3 outward = f < 6 ? rotate(a_.X_WS.R, a_.moving->solid->face_plane(f).normal)
                                    : Vector3(-rotate(b_.X_WS.R, b_.moving->solid->face_plane(f - 6).normal));
      const double length = norm(outward);
      if (!(length > 0.5)) continue;  // a collapsed face
      const Vector3 n = outward / length;
      const BodyState& own = f < 6 ? a_.state : b_.state;
      if (!try_direction({n}, true)) continue;
      if (steady) try_direction({n, own.angular_velocity_W, own.centre_W, own.velocity_W}, false);
    }
    return widest_;
  }

 private:
  /// False: the pair is not apart along it.
  bool try_direction(Direction along, bool may_be_fixed) {
    if (widest_.at_end) return true;
    if (!may_be_fixed && along.is_fixed()) return true;
    along.longest = longest_;
    const double apart = separation_along(a_, b_, along.n);
    if (apart < std::max(from_afar_, 0.5 * rule_.gap - kSeparationRounding * scale_)) return false;
    const double threshold =
        from_afar_ > 0.0 ? from_afar_ : rule_.threshold(std::min(apart, rule_.gap), scale_);
    const Stretch other = clear_stretch(a_, b_, along, threshold, longest_);
    if (other.length > widest_.length) widest_ = other;
    return true;
  }

  const PlacedSolid& a_;
  const PlacedSolid& b_;
  const GapRule& rule_;
  double scale_, from_afar_, longest_;
  Stretch widest_;
};

double largest(const Vector3& p) { return std::max({std::abs(p.x()), std::abs(p.y()), std::abs(p.z())}); }

}  // namespace

bool is_at_rest(const MovingSolid& moving, double s) { return s >= moving.stop; }

bool stays_apart_along(const MovingSolid& a, const MovingSolid& b, const Vector3& n_AB_W, double threshold) {
  const Stretch stretch = clear_stretch(place(a, 0.0), place(b, 0.0), {n_AB_W}, threshold, 1.0);
  return stretch.at_end && stretch.least_at_end > threshold;
}

PlacedSolid place(const MovingSolid& moving, double s) {
  PlacedSolid out{
      &moving, is_at_rest(moving, s), moving.path->at(moving.body, std::min(s, moving.stop)), {}, {}};
  out.X_WS = compose(out.state.X_WO, moving.X_OS);
  world_vertices(*moving.solid, out.X_WS, out.vertices);
  if (out.at_rest) out.state.velocity_W = out.state.angular_velocity_W = Vector3::Zero();
  return out;
}

double next_break(const MovingSolid& a, const MovingSolid& b, double s) {
  double end = 1.0;
  if (a.stop > s) end = std::min(end, a.stop);
  if (b.stop > s) end = std::min(end, b.stop);
  return end;
}

double scale_of(const PlacedSolid& a, const PlacedSolid& b) {
  const auto reach = [](const PlacedSolid& placed) {
    const Sphere& sphere = placed.moving->solid->bounding_sphere();
    return largest(placed.X_WS.p) + (norm(sphere.centre) + 2.0 * sphere.radius);
  };
  return std::max(reach(a), reach(b));
}

double relative_speed(const PlacedSolid& a, const PlacedSolid& b) {
  const auto velocity = [](const BodyState& state, const Vector3& p) {
    return Vector3(state.velocity_W + cross(state.angular_velocity_W, p - state.centre_W));
  };
  double fastest = 0.0;
  for (const PlacedSolid* placed : {&a, &b}) {
    for (int i = 0; i < Hexahedron::kVertices; ++i) {
      const Vector3 p = placed->vertices.vertex(i);
      fastest = std::max(fastest, norm(velocity(a.state, p) - velocity(b.state, p)));
    }
  }
  return fastest;
}

bool has_geometry(PairStatus status) {
  return status == PairStatus::separated || status == PairStatus::overlapping ||
         status == PairStatus::undecided;
}

Stretch find_clear_stretch(const PlacedSolid& a, const PlacedSolid& b, const PairGeometry& geometry,
                           const GapRule& rule, double threshold, double longest, int queries) {
  const Stretch stretch = clear_stretch(a, b, {geometry.n_AB_W}, threshold, longest);
  const bool in_contact = geometry.separation <= rule.gap;
  const bool is_slow = stretch.length < kShort * longest || queries > kManyQueries;
  if (geometry.separation <= 0.0 || stretch.at_end || !(in_contact || is_slow)) return stretch;
  return WidestStretch(a, b, rule, scale_of(a, b), in_contact ? 0.0 : threshold, longest, stretch)
      .find(geometry);
}

}  // namespace touchstone
