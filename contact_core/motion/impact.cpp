#include "contact_core/motion/impact.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace touchstone {
namespace {

/// A pair that comes from further away is held above this share of the gap: what lies between it and a half
/// is room for rounding and for motion along the contact.
constexpr double kStopShare = 0.75;
/// A pair in contact whose next step clears less than this share of what is left could not finish within
/// kImpactIterations: it is blocked.
constexpr double kStalled = 1.0 / kImpactIterations;
/// Rounding of a separation and of the projections here, per metre of the largest coordinate (native's
/// declared resolution): a motion along a face must not be stopped by it.
constexpr double kRounding = 32 * 0x1p-53;

/// A vertex's path along n from s on: value + slope t -+ curvature t^2 / 2.
struct Extent {
  std::array<double, Hexahedron::kVertices> value, slope, curvature;
};

bool is_at_rest(const MovingSolid& moving, double s) { return s >= moving.stop; }

Extent extent_along(const MovingSolid& moving, double s, const Vector3& n) {
  Extent out{};
  const BodyState state = moving.path->at(moving.body, std::min(s, moving.stop));
  WorldVertices vertices;
  world_vertices(*moving.solid, compose(state.X_WO, moving.X_OS), vertices);
  const bool at_rest = is_at_rest(moving, s);
  for (int i = 0; i < Hexahedron::kVertices; ++i) {
    const Vector3 p = vertices.vertex(i);
    out.value[i] = dot(n, p);
    if (at_rest) continue;
    out.slope[i] = dot(n, state.velocity_W + cross(state.angular_velocity_W, p - state.centre_W));
    out.curvature[i] = moving.path->curvature_bound(moving.body, state, p, n);
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

struct Stretch {
  double length;
  bool at_end;
  double least_at_end;  ///< the projections are at least this far apart there; only if at_end
};

/// How far on from s the projections on n are sure to stay apart by `threshold`; at most `longest`.
Stretch clear_stretch(const MovingSolid& a, const MovingSolid& b, double s, const Vector3& n,
                      double threshold, double longest) {
  const Extent on_a = extent_along(a, s, n), on_b = extent_along(b, s, n);
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

/// Closest points of two solids that pass each other at the gap's height point across their corners, and
/// would stop a motion along abutting faces at every seam. Any other plane that keeps half the gap will do:
/// of the faces' own, the one that lets most of the motion through.
Stretch widest_stretch(const MovingSolid& a, const MovingSolid& b, double s, const GapRule& rule,
                       double scale, double longest, const Stretch& so_far) {
  Stretch widest = so_far;
  const Matrix3 R_WA = a.pose_at(s).R, R_WB = b.pose_at(s).R;
  for (int f = 0; f < 12 && !widest.at_end; ++f) {
    const Vector3 outward = f < 6 ? rotate(R_WA, a.solid->face_plane(f).normal)
                                  : Vector3(-rotate(R_WB, b.solid->face_plane(f - 6).normal));
    const double length = norm(outward);
    if (!(length > 0.5)) continue;  // a collapsed face
    const Vector3 n = outward / length;
    const double apart = separation_along(extent_along(a, s, n), extent_along(b, s, n));
    if (apart < 0.5 * rule.gap - kRounding * scale) continue;
    const Stretch other =
        clear_stretch(a, b, s, n, rule.threshold(std::min(apart, rule.gap), scale), longest);
    if (other.length > widest.length) widest = other;
  }
  return widest;
}

/// Where the next solid comes to rest, or the end: between such points both paths are smooth.
double next_break(const MovingSolid& a, const MovingSolid& b, double s) {
  double end = 1.0;
  if (a.stop > s) end = std::min(end, a.stop);
  if (b.stop > s) end = std::min(end, b.stop);
  return end;
}

double largest(const Vector3& p) { return std::max({std::abs(p.x()), std::abs(p.y()), std::abs(p.z())}); }

/// At least S of the error measures.
double scale_of(const MovingSolid& a, const Pose& X_WA, const MovingSolid& b, const Pose& X_WB) {
  const auto reach = [](const Hexahedron& solid, const Pose& X) {
    const Sphere& sphere = solid.bounding_sphere();
    return largest(X.p) + (norm(sphere.centre) + 2.0 * sphere.radius);
  };
  return std::max(reach(*a.solid, X_WA), reach(*b.solid, X_WB));
}

bool has_geometry(PairStatus status) {
  return status == PairStatus::separated || status == PairStatus::overlapping ||
         status == PairStatus::undecided;
}

}  // namespace

Pose MovingSolid::pose_at(double s) const noexcept {
  return compose(path->at(body, std::min(s, stop)).X_WO, X_OS);
}

double GapRule::threshold(double start, double scale) const {
  if (start > gap) return kStopShare * gap;
  // Below g/2 the room for rounding shrinks, to none at g/4: rounding alone never brings a pair to touch.
  const double room = start < 0.0 ? 1.0 : std::clamp((start - 0.25 * gap) / (0.25 * gap), 0.0, 1.0);
  return std::min(0.5 * gap, start) - room * kRounding * scale;
}

Impact find_impact(const MovingSolid& a, const MovingSolid& b, const GapRule& rule, SeparationQuery& query,
                   double interest) noexcept {
  Impact impact;
  double threshold = 0.0;
  bool from_afar = false;
  for (double s = 0.0;;) {
    const Pose X_WA = a.pose_at(s), X_WB = b.pose_at(s);
    const PairStatus status = query.separation(X_WA, X_WB, impact.geometry);
    impact.lo = s;
    if (!has_geometry(status)) {
      impact.status = ImpactStatus::failed;
      return impact;
    }
    const double separation = impact.geometry.separation;
    // Once apart, a pair that started in contact is like any other.
    if (impact.queries == 0 || (!from_afar && separation > rule.gap)) {
      threshold = rule.threshold(separation, scale_of(a, X_WA, b, X_WB));
      from_afar = separation > rule.gap;
    }
    if (impact.queries++ == 0) impact.start_separation = separation;
    impact.least_separation = std::min(impact.least_separation, separation);
    if (s >= 1.0 || (is_at_rest(a, s) && is_at_rest(b, s))) {
      impact.lo = 1.0;
      return impact;
    }
    const double end = next_break(a, b, s);
    Stretch stretch = clear_stretch(a, b, s, impact.geometry.n_AB_W, threshold, end - s);
    if (separation <= rule.gap && separation > 0.0 && !stretch.at_end)
      stretch = widest_stretch(a, b, s, rule, scale_of(a, X_WA, b, X_WB), end - s, stretch);
    if (stretch.at_end && end == 1.0 && separation > interest && stretch.least_at_end > interest) {
      impact.is_far = true;
      impact.lo = 1.0;
      return impact;
    }
    const double next = stretch.at_end ? end : s + stretch.length;
    const bool stopped = stretch.length < kStalled * (end - s);
    if (separation <= rule.gap && !stretch.at_end && stopped) {
      impact.status = ImpactStatus::blocked;
      impact.hi = next;
      return impact;
    }
    if (impact.queries >= kImpactIterations || !(next > s)) {
      impact.status = ImpactStatus::iteration_limit;
      return impact;
    }
    s = next;
  }
}

}  // namespace touchstone
