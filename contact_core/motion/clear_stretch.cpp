#include "touchstone/contact_core/motion/clear_stretch.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/geometry/norms.hpp"
#include "touchstone/contact_core/motion/edge_stretch.hpp"

namespace touchstone {
namespace {

/// Not in contact, other planes are looked for where the closest points' clears less than this share, or
/// after this many queries.
constexpr double kShort = 4.0 * kStalled;
constexpr int kManyQueries = 12;
/// Heights and sums of them round by far less, per metre.
constexpr double kRoundingShare = 0x1p-40;

/// A direction on which two solids are projected, and how it turns from s on. The plane of a face turns
/// with its body; two edges that slide over each other span one that turns with both.
struct Direction {
  Vector3 n;
  Vector3 turn = Vector3::Zero();      ///< angular velocity; zero: fixed in the world
  Vector3 centre = Vector3::Zero();    ///< heights are over this point
  Vector3 velocity = Vector3::Zero();  ///< of that point
  double longest = 0.0;                ///< how far on curvatures hold

  bool is_fixed() const { return turn == Vector3::Zero(); }
};

/// Vertices' paths along n from s on: value + slope t -+ curvature t^2 / 2.
struct Extent {
  int count = 0;
  std::array<double, Hexahedron::kVertices> value, slope, curvature;
};

using Heights = std::array<double, Hexahedron::kVertices>;

double radius_of(const PlacedSolid& placed) { return placed.moving->solid->radius(); }

/// @param beyond the vertices: a radius, below 0 against n. It goes along with every vertex, however the
/// solid and n turn.
Heights heights_along(const PlacedSolid& placed, const Vector3& n, double beyond) {
  Heights out;
  for (int i = 0; i < Hexahedron::kVertices; ++i) out[i] = dot(n, placed.vertices.vertex(i)) + beyond;
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

/// In steady motion, or at rest.
bool is_steady(const PlacedSolid& placed) { return placed.at_rest || placed.moving->path->is_steady(); }

/// The same of a point of a body whose motion is not steady: with p its place and c the direction's centre,
///   (n . (p - c))'' = n'' . (p - c) + 2 n' . (p' - c') + n . p'',
/// where |n'| and |n''| stay as they are and |p''| is bounded.
double uneven_curvature(const Direction& along, const PlacedSolid& placed, const Vector3& p) {
  const BodyState& state = placed.state;
  const double acceleration = placed.moving->path->bounds(placed.moving->body, state, p).acceleration;
  const double tilt = norm(cross(along.turn, along.n));
  const double rate = norm(point_velocity(state, p) - along.velocity) + along.longest * acceleration;
  const double reach = norm(p - along.centre) + along.longest * rate;
  return tilt * (norm(along.turn) * reach + 2.0 * rate) + acceleration;
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
    out.slope[k] = dot(along.n, point_velocity(state, p));
    if (along.is_fixed()) continue;
    out.slope[k] += dot(cross(along.turn, along.n), p - along.centre) - dot(along.n, along.velocity);
    out.curvature[k] =
        is_steady(placed) ? turning_curvature(along, state, p) : uneven_curvature(along, placed, p);
  }
  if (!stands && along.is_fixed())
    placed.moving->path->curvature_bounds(placed.moving->body, state, std::span(points).first(out.count),
                                          along.n, std::span(out.curvature).first(out.count));
  return out;
}

/// Vertices that could matter on a stretch. No travel is long enough for the others: these are only known to
/// stay `least` apart from what is before them.
struct Meeting {
  unsigned of_a = 0, of_b = 0;
  double least = kInfinity;
};

Meeting meeting_vertices(const PlacedSolid& a, const PlacedSolid& b, const Heights& on_a, const Heights& on_b,
                         double threshold, double longest) {
  const auto travel_of = [&](const PlacedSolid& placed) {
    return placed.at_rest ? 0.0 : placed.moving->travel * longest;
  };
  const double highest = *std::max_element(on_a.begin(), on_a.end()) + travel_of(a);
  const double lowest = *std::min_element(on_b.begin(), on_b.end()) - travel_of(b);
  // The rounding of heights and sums is far less.
  const double enough = std::max(threshold, 0.0) + kRoundingShare * (std::abs(highest) + std::abs(lowest));
  Meeting out;
  const auto leave_out = [&](double apart) {
    if (!(apart > enough)) return false;
    out.least = std::min(out.least, apart);
    return true;
  };
  for (int i = 0; i < Hexahedron::kVertices; ++i) {
    if (!leave_out(lowest - (on_a[i] + travel_of(a)))) out.of_a |= 1u << i;
    if (!leave_out((on_b[i] - travel_of(b)) - highest)) out.of_b |= 1u << i;
  }
  return out;
}

/// How far on from s the projections on n are sure to stay apart by `threshold`; at most `longest`.
Stretch clear_stretch(const PlacedSolid& a, const PlacedSolid& b, const Direction& along, double threshold,
                      double longest) {
  // Vertices that cannot meet on the stretch are left out.
  const Heights heights_a = heights_along(a, along.n, radius_of(a));
  const Heights heights_b = heights_along(b, along.n, -radius_of(b));
  Meeting meeting{0xff, 0xff};
  if (along.is_fixed()) meeting = meeting_vertices(a, b, heights_a, heights_b, threshold, longest);
  if (meeting.of_a == 0 || meeting.of_b == 0) return {longest, true, meeting.least};
  // Each pair of vertices has a parabola as its lower bound; the earliest root ends the stretch.
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
  // On a whole stretch the bounds at its end say how far apart the two stay.
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
  return (lowest - highest) - (radius_of(a) + radius_of(b));
}

/// Of the plane that two edges in contact span, each moving with its body: n = e x f / |e x f|, and so is n'.
Direction edge_direction(const PlacedSolid& a, const PlacedSolid& b, const PairGeometry& geometry,
                         double tolerance) {
  Direction along{geometry.n_AB_W};
  const Vector3& n = geometry.n_AB_W;
  const Vector3 e = extreme_edge(a, n, tolerance).along, f = extreme_edge(b, -n, tolerance).along;
  const double across = dot(n, cross(e, f));
  if (!(std::abs(across) > 1e-3 * norm(e) * norm(f))) return along;
  const BodyState &on_a = a.state, &on_b = b.state;
  const Vector3 rate =
      (cross(cross(on_a.angular_velocity_W, e), f) + cross(e, cross(on_b.angular_velocity_W, f))) / across;
  along.turn = cross(n, rate);
  // Midway, so that (b, a) gives the same.
  along.centre = 0.5 * (geometry.p_A_W + geometry.p_B_W);
  along.velocity = 0.5 * (point_velocity(on_a, along.centre) + point_velocity(on_b, along.centre));
  return along;
}

/// Two solids as seen from the mechanism's body that the first one, the viewer, belongs to.
struct SeenPair {
  bool is_known = false;
  MovingSolid viewer, other;
  PlacedSolid placed_viewer, placed_other;

  SeenPair() = default;
  SeenPair(const SeenPair&) = delete;
  SeenPair& operator=(const SeenPair&) = delete;

  void look(const PlacedSolid& from, const PlacedSolid& at) {
    PathViews* views = from.moving->views;
    if (views == nullptr || from.at_rest || from.state.angular_velocity_W == Vector3::Zero()) return;
    const bool is_same_mechanism = at.moving->views == views;
    if (!is_same_mechanism && !at.at_rest) return;
    const MotionPath& path = views->seen_from(from.moving->body);
    viewer = *from.moving, other = *at.moving;
    viewer.path = other.path = &path;
    viewer.vertices_at_start = other.vertices_at_start = nullptr;
    viewer.travel = 0.0, other.travel = kInfinity;
    if (!is_same_mechanism) {
      other.body = views->standing_body();
      other.X_OS = compose(inverse(path.at(other.body, 0.0).X_WO), at.X_WS);
      other.stop = viewer.stop;
    }
    placed_viewer = place(viewer, from.s), placed_other = place(other, from.s);
    is_known = true;
  }
};

/// Closest points of two solids that pass each other at the gap's height point across their corners, and
/// would stop a motion along abutting faces at every seam; a plane fixed in the world is left by a body that
/// turns on a contact. Any other plane that keeps half the gap will do: of the faces' own, fixed or turning
/// with their bodies, and of the edges in contact, the one that lets most of the motion through.
class WidestStretch {
 public:
  /// @param threshold of the path. @param in_contact else no plane may keep less than that.
  WidestStretch(const PlacedSolid& a, const PlacedSolid& b, const GapRule& rule, double scale,
                double threshold, bool in_contact, double longest, const Stretch& so_far)
      : a_(a),
        b_(b),
        rule_(rule),
        scale_(scale),
        from_afar_(in_contact ? 0.0 : threshold),
        least_(std::min(threshold, 0.5 * rule.gap)),
        longest_(longest),
        widest_(so_far) {}

  Stretch find(const PairGeometry& geometry) {
    // A pair that stands as low as it may is not to be left without planes by their rounding.
    least_apart_ =
        std::max(from_afar_, std::min(0.5 * rule_.gap, geometry.separation) - kSeparationRounding * scale_);
    const bool steady = is_steady(a_) && is_steady(b_);
    const double tolerance = 2.0 * kSeparationRounding * scale_;
    if (steady) try_direction(a_, b_, edge_direction(a_, b_, geometry, tolerance), false);
    try_faces();
    if (!widest_.at_end) try_edges(geometry, tolerance);
    if (!widest_.at_end) try_faces_that_turn();
    return widest_;
  }

 private:
  void try_faces() {
    for (int f = 0; f < 12 && !widest_.at_end; ++f) {
      const PlacedSolid& with = f < 6 ? a_ : b_;
      const Vector3 n = normal_of(with, f);
      if (n == Vector3::Zero() || !try_direction(a_, b_, {n}, true)) continue;
      const BodyState& body = with.state;
      if (is_steady(with))
        try_direction(a_, b_, {n, body.angular_velocity_W, body.centre_W, body.velocity_W}, false);
    }
  }

  /// A mechanism's body turns unevenly; seen from it its faces stand still.
  void try_faces_that_turn() {
    for (int side = 0; side < 2 && !widest_.at_end; ++side) {
      SeenPair seen;
      seen.look(side == 0 ? a_ : b_, side == 0 ? b_ : a_);
      if (!seen.is_known) continue;
      const PlacedSolid& a = side == 0 ? seen.placed_viewer : seen.placed_other;
      const PlacedSolid& b = side == 0 ? seen.placed_other : seen.placed_viewer;
      for (int f = 0; f < 6 && !widest_.at_end; ++f) {
        const Vector3 n = normal_of(side == 0 ? a : b, 6 * side + f);
        if (n != Vector3::Zero()) try_direction(a, b, {n}, true);
      }
    }
  }

  void try_edges(const PairGeometry& geometry, double tolerance) {
    if (geometry.separation < least_apart_) return;
    const ExtremeEdges of_a = extreme_edges(a_, geometry.n_AB_W, tolerance);
    const ExtremeEdges of_b = extreme_edges(b_, -geometry.n_AB_W, tolerance);
    for (int i = 0; i < of_a.count; ++i)
      for (int j = 0; j < of_b.count && !widest_.at_end; ++j) {
        EdgePair pair{of_a.edge[i], of_b.edge[j], {}, {}};
        if (!cross_lines(a_, b_, pair)) continue;
        const Vector3 N = cross(pair.of_a.along, pair.of_b.along);
        const double radii = radius_of(a_) + radius_of(b_);  // the edges are the cores'
        const double apart = std::abs(dot(N, pair.q - pair.p)) / norm(N) - radii;
        if (apart < least_apart_) continue;
        Stretch other =
            edge_stretch(a_, b_, pair, geometry.n_AB_W, tolerance, threshold_of(apart) + radii, longest_);
        other.least_at_end -= radii;
        if (other.length > widest_.length) widest_ = other;
      }
  }

  /// Of a's face f or b's face f - 6, towards b; zero where it is collapsed.
  static Vector3 normal_of(const PlacedSolid& with, int f) {
    const Vector3 outward = f < 6
                                ? rotate(with.X_WS.R, with.moving->solid->face_plane(f).normal)
                                : Vector3(-rotate(with.X_WS.R, with.moving->solid->face_plane(f - 6).normal));
    const double length = norm(outward);
    return length > 0.5 ? Vector3(outward / length) : Vector3(Vector3::Zero());
  }

  /// In contact what the plane keeps less its rounding, but not look after look: a path of 250 looks would
  /// sink by as many roundings.
  double threshold_of(double apart) const {
    return from_afar_ > 0.0 ? from_afar_
                            : std::max(least_, rule_.threshold(std::min(apart, rule_.gap), scale_));
  }

  /// False: the pair is not apart along it.
  bool try_direction(const PlacedSolid& a, const PlacedSolid& b, Direction along, bool may_be_fixed) {
    if (widest_.at_end) return true;
    if (!may_be_fixed && along.is_fixed()) return true;
    along.longest = longest_;
    const double apart = separation_along(a, b, along.n);
    if (apart < least_apart_) return false;
    const Stretch other = clear_stretch(a, b, along, threshold_of(apart), longest_);
    if (other.length > widest_.length) widest_ = other;
    return true;
  }

  const PlacedSolid& a_;
  const PlacedSolid& b_;
  const GapRule& rule_;
  double scale_, from_afar_;  // 0: in contact
  double least_;              // in contact: of all looks of the path
  double longest_;
  double least_apart_ = 0.0;
  Stretch widest_;
};

}  // namespace

unsigned distinct_vertices(const Hexahedron& solid, const WorldVertices& vertices) {
  unsigned out = 0xff;
  if (!solid.is_rounded()) return out;
  for (int i = 1; i < Hexahedron::kVertices; ++i)
    for (int j = 0; j < i; ++j)
      if (vertices.vertex(i) == vertices.vertex(j)) out &= ~(1U << i);
  return out;
}

bool is_at_rest(const MovingSolid& moving, double s) { return s >= moving.stop; }

bool stays_apart_along(const MovingSolid& a, const MovingSolid& b, const Vector3& n_AB_W, double threshold) {
  const Stretch stretch = clear_stretch(place(a, 0.0), place(b, 0.0), {n_AB_W}, threshold, 1.0);
  return stretch.at_end && stretch.least_at_end > threshold;
}

PlacedSolid place(const MovingSolid& moving, double s) {
  PlacedSolid out{
      &moving, is_at_rest(moving, s), s, moving.path->at(moving.body, std::min(s, moving.stop)), {}, {}};
  if (moving.vertices_at_start != nullptr && std::min(s, moving.stop) == 0.0) {
    out.X_WS = *moving.X_WS_at_start, out.vertices = *moving.vertices_at_start;
  } else {
    out.X_WS = compose(out.state.X_WO, moving.X_OS);
    world_vertices(*moving.solid, out.X_WS, out.vertices);
  }
  if (out.at_rest) out.state.velocity_W = out.state.angular_velocity_W = Vector3::Zero();
  return out;
}

PathStep next_step(const PlacedSolid& on_a, const PlacedSolid& on_b, const PairGeometry& geometry,
                   const GapRule& rule, double threshold, double interest, int queries, OverlapAhead* ahead) {
  const double s = on_a.s, end = next_break(*on_a.moving, *on_b.moving, s);
  const Stretch stretch = find_clear_stretch(on_a, on_b, geometry, rule, threshold, end - s, queries, ahead);
  PathStep step{stretch.at_end ? end : s + stretch.length};
  step.at_end = stretch.at_end && end == 1.0;
  step.is_far = step.at_end && geometry.separation > interest && stretch.least_at_end > interest;
  const bool is_short = !stretch.at_end && stretch.length < kStalled * (end - s);
  step.is_stalled = is_short && geometry.separation <= rule.gap;
  return step;
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
    return norm_inf(placed.X_WS.p) + (norm(sphere.centre) + 2.0 * sphere.radius);
  };
  return std::max(reach(a), reach(b));
}

double relative_speed(const PlacedSolid& a, const PlacedSolid& b) {
  double fastest = 0.0;
  for (const PlacedSolid* placed : {&a, &b}) {
    for (int i = 0; i < Hexahedron::kVertices; ++i) {
      const Vector3 p = placed->vertices.vertex(i);
      fastest = std::max(fastest, norm(point_velocity(a.state, p) - point_velocity(b.state, p)));
    }
  }
  const double reach = std::max(radius_of(a), radius_of(b));
  if (reach == 0.0) return fastest;
  return fastest + reach * norm(a.state.angular_velocity_W - b.state.angular_velocity_W);
}

bool has_geometry(PairStatus status) {
  return status == PairStatus::separated || status == PairStatus::overlapping ||
         status == PairStatus::undecided;
}

Stretch find_clear_stretch(const PlacedSolid& a, const PlacedSolid& b, const PairGeometry& geometry,
                           const GapRule& rule, double threshold, double longest, int queries,
                           OverlapAhead* ahead) {
  const Stretch stretch = clear_stretch(a, b, {geometry.n_AB_W}, threshold, longest);
  const bool in_contact = geometry.separation <= rule.gap;
  const bool is_slow = stretch.length < kShort * longest || queries > kManyQueries;
  if (geometry.separation <= 0.0 || stretch.at_end || !(in_contact || is_slow)) return stretch;
  // Every plane below keeps at least `threshold`, or half the gap: none clears what ends in an overlap. Far
  // less than the gap it would be a matter of rounding which of the two is right.
  const double enough = kStalled * longest;
  if (ahead != nullptr && in_contact && threshold >= 0.25 * rule.gap && stretch.length < enough &&
      ahead->overlaps_at(a.s + enough))
    return stretch;
  return WidestStretch(a, b, rule, scale_of(a, b), threshold, in_contact, longest, stretch).find(geometry);
}

}  // namespace touchstone
