#include "contact_core/motion/clear_stretch.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace touchstone {
namespace {

/// Not in contact, other planes are looked for where the closest points' clears less than this share, or
/// after so many queries.
constexpr double kShort = 4.0 * kStalled;
constexpr int kManyQueries = 12;

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

/// A vertex's path along n from s on: value + slope t -+ curvature t^2 / 2.
struct Extent {
  std::array<double, Hexahedron::kVertices> value, slope, curvature;
};

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

Extent extent_along(const MovingSolid& moving, double s, const Direction& along) {
  Extent out{};
  BodyState state = moving.path->at(moving.body, std::min(s, moving.stop));
  WorldVertices vertices;
  world_vertices(*moving.solid, compose(state.X_WO, moving.X_OS), vertices);
  const bool at_rest = is_at_rest(moving, s);
  if (at_rest) state.velocity_W = state.angular_velocity_W = Vector3::Zero();
  for (int i = 0; i < Hexahedron::kVertices; ++i) {
    const Vector3 p = vertices.vertex(i);
    out.value[i] = dot(along.n, p);
    if (at_rest && along.is_fixed()) continue;
    out.slope[i] = dot(along.n, state.velocity_W + cross(state.angular_velocity_W, p - state.centre_W));
    if (along.is_fixed()) {
      out.curvature[i] = moving.path->curvature_bound(moving.body, state, p, along.n);
      continue;
    }
    out.slope[i] += dot(cross(along.turn, along.n), p - along.centre) - dot(along.n, along.velocity);
    out.curvature[i] = turning_curvature(along, state, p);
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
Stretch clear_stretch(const MovingSolid& a, const MovingSolid& b, double s, const Direction& along,
                      double threshold, double longest) {
  const Extent on_a = extent_along(a, s, along), on_b = extent_along(b, s, along);
  double stretch = longest;
  for (int i = 0; i < Hexahedron::kVertices; ++i) {
    for (int j = 0; j < Hexahedron::kVertices; ++j) {
      const double c = (on_b.value[j] - on_a.value[i]) - threshold;
      const double slope = on_b.slope[j] - on_a.slope[i];
      const double curvature = on_b.curvature[j] + on_a.curvature[i];
      if (c + slope * stretch - 0.5 * curvature * stretch * stretch >= 0.0) continue;
      stretch = std::min(stretch, first_root(c, slope, curvature));
    }
  }
  if (stretch < longest) return {stretch, false, 0.0};
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i < Hexahedron::kVertices; ++i)
    for (int j = 0; j < Hexahedron::kVertices; ++j)
      least = std::min(least, (on_b.value[j] - on_a.value[i]) + (on_b.slope[j] - on_a.slope[i]) * longest -
                                  0.5 * (on_b.curvature[j] + on_a.curvature[i]) * longest * longest);
  return {stretch, true, least};
}

/// Separation of the two along n, as extents at one s have it.
double separation_along(const Extent& a, const Extent& b) {
  return *std::min_element(b.value.begin(), b.value.end()) -
         *std::max_element(a.value.begin(), a.value.end());
}

/// Steady on its way, or at rest.
bool is_steady(const MovingSolid& moving, double s) {
  return is_at_rest(moving, s) || moving.path->is_steady();
}

BodyState state_of(const MovingSolid& moving, double s) {
  BodyState state = moving.path->at(moving.body, std::min(s, moving.stop));
  if (is_at_rest(moving, s)) state.velocity_W = state.angular_velocity_W = Vector3::Zero();
  return state;
}

/// The edge that is a solid's extreme along n, to `tolerance`: its direction. Zero if a vertex or a face is.
Vector3 extreme_edge(const MovingSolid& moving, double s, const Vector3& n, double tolerance) {
  WorldVertices vertices;
  world_vertices(*moving.solid, moving.pose_at(s), vertices);
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
Direction edge_direction(const MovingSolid& a, const MovingSolid& b, double s, const PairGeometry& geometry,
                         double tolerance) {
  Direction along{geometry.n_AB_W};
  const Vector3& n = geometry.n_AB_W;
  const Vector3 e = extreme_edge(a, s, n, tolerance), f = extreme_edge(b, s, -n, tolerance);
  const double across = dot(n, cross(e, f));
  if (!(std::abs(across) > 1e-3 * norm(e) * norm(f))) return along;
  const BodyState on_a = state_of(a, s), on_b = state_of(b, s);
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
  WidestStretch(const MovingSolid& a, const MovingSolid& b, double s, const GapRule& rule, double scale,
                double from_afar, double longest, const Stretch& so_far)
      : a_(a),
        b_(b),
        s_(s),
        rule_(rule),
        scale_(scale),
        from_afar_(from_afar),
        longest_(longest),
        widest_(so_far) {}

  Stretch find(const PairGeometry& geometry) {
    const bool steady = is_steady(a_, s_) && is_steady(b_, s_);
    if (steady)
      try_direction(edge_direction(a_, b_, s_, geometry, 2.0 * kSeparationRounding * scale_), false);
    const Matrix3 R_WA = a_.pose_at(s_).R, R_WB = b_.pose_at(s_).R;
    const BodyState on_a = state_of(a_, s_), on_b = state_of(b_, s_);
    for (int f = 0; f < 12 && !widest_.at_end; ++f) {
      const Vector3 outward = f < 6 ? rotate(R_WA, a_.solid->face_plane(f).normal)
                                    : Vector3(-rotate(R_WB, b_.solid->face_plane(f - 6).normal));
      const double length = norm(outward);
      if (!(length > 0.5)) continue;  // a collapsed face
      const Vector3 n = outward / length;
      const BodyState& own = f < 6 ? on_a : on_b;
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
    const double apart = separation_along(extent_along(a_, s_, along), extent_along(b_, s_, along));
    if (apart < std::max(from_afar_, 0.5 * rule_.gap - kSeparationRounding * scale_)) return false;
    const double threshold =
        from_afar_ > 0.0 ? from_afar_ : rule_.threshold(std::min(apart, rule_.gap), scale_);
    const Stretch other = clear_stretch(a_, b_, s_, along, threshold, longest_);
    if (other.length > widest_.length) widest_ = other;
    return true;
  }

  const MovingSolid& a_;
  const MovingSolid& b_;
  double s_;
  const GapRule& rule_;
  double scale_, from_afar_, longest_;
  Stretch widest_;
};

double largest(const Vector3& p) { return std::max({std::abs(p.x()), std::abs(p.y()), std::abs(p.z())}); }

}  // namespace

bool is_at_rest(const MovingSolid& moving, double s) { return s >= moving.stop; }

double next_break(const MovingSolid& a, const MovingSolid& b, double s) {
  double end = 1.0;
  if (a.stop > s) end = std::min(end, a.stop);
  if (b.stop > s) end = std::min(end, b.stop);
  return end;
}

double scale_of(const MovingSolid& a, const Pose& X_WA, const MovingSolid& b, const Pose& X_WB) {
  const auto reach = [](const Hexahedron& solid, const Pose& X) {
    const Sphere& sphere = solid.bounding_sphere();
    return largest(X.p) + (norm(sphere.centre) + 2.0 * sphere.radius);
  };
  return std::max(reach(*a.solid, X_WA), reach(*b.solid, X_WB));
}

double relative_speed(const MovingSolid& a, const MovingSolid& b, double s) {
  const BodyState on_a = state_of(a, s), on_b = state_of(b, s);
  const auto velocity = [](const BodyState& state, const Vector3& p) {
    return Vector3(state.velocity_W + cross(state.angular_velocity_W, p - state.centre_W));
  };
  double fastest = 0.0;
  for (const MovingSolid* moving : {&a, &b}) {
    WorldVertices vertices;
    world_vertices(*moving->solid, moving->pose_at(s), vertices);
    for (int i = 0; i < Hexahedron::kVertices; ++i) {
      const Vector3 p = vertices.vertex(i);
      fastest = std::max(fastest, norm(velocity(on_a, p) - velocity(on_b, p)));
    }
  }
  return fastest;
}

bool has_geometry(PairStatus status) {
  return status == PairStatus::separated || status == PairStatus::overlapping ||
         status == PairStatus::undecided;
}

Stretch find_clear_stretch(const MovingSolid& a, const MovingSolid& b, double s, const PairGeometry& geometry,
                           const GapRule& rule, double threshold, double end, int queries) {
  const Stretch stretch = clear_stretch(a, b, s, {geometry.n_AB_W}, threshold, end - s);
  const bool in_contact = geometry.separation <= rule.gap;
  const bool is_slow = stretch.length < kShort * (end - s) || queries > kManyQueries;
  if (geometry.separation <= 0.0 || stretch.at_end || !(in_contact || is_slow)) return stretch;
  const double scale = scale_of(a, a.pose_at(s), b, b.pose_at(s));
  return WidestStretch(a, b, s, rule, scale, in_contact ? 0.0 : threshold, end - s, stretch).find(geometry);
}

}  // namespace touchstone
