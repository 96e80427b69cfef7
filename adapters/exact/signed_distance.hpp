#pragma once

#include <string>

#include "touchstone/contact_core/geometry/hexahedron.hpp"
#include "touchstone/contact_core/narrowphase/pair_class.hpp"

/// @file
/// The signed distance of two convex hulls of eight vertices, decided in integers: the ground truth. Hulls
/// may have any rank (rounding far from the origin flattens solids to polygons, segments, points).
/// Coordinates may be any finite doubles. Pure functions, safe on any thread; they allocate (GMP) and are not
/// for a frame loop.

namespace touchstone {

/// The truth about a pair, each figure rounded once from its exact value.
struct ExactResult {
  PairClass pair_class;
  /// The exact signed distance rounded to the nearest double [m]: below 0 the minimal translation distance.
  double separation;
  /// Unit, from A to B, each component rounded to nearest from the exact direction; a separating direction
  /// when touching. Of directions that tie exactly: the last in the order of x, then y, then z, with A the
  /// solid whose list of vertices (by vertex: x, y, z) comes first, and negated if that is the second
  /// argument. So (b,a) has the negated normal, except for two solids with the same eight vertices in the
  /// same order, where the two questions are one.
  Vector3 n_AB_W;
  bool normal_unique;
  /// Exactly tied normals: 1 when apart; overlapping: distinct facet normals of the difference at this depth
  /// (touching by less than a facet: all between them serve too); 0 when both solids lie on one line and
  /// touch.
  int tied_normals;
  /// One closest pair, or surface points a minimal translation apart; exact points rounded to nearest [m].
  Vector3 p_A_W, p_B_W;
};

/// @pre all coordinates are finite (so for all functions here).
ExactResult exact_signed_distance(const WorldVertices& a, const WorldVertices& b);

/// The same of rounded solids, by their cores' vertices and their radii: class and separation are right to
/// the last bit, the class by comparing squares. The normal is the cores'; where cores touch, cross or
/// overlap, the depth is theirs and both radii. Witness points: the cores', moved by the radii along the
/// normal in doubles.
/// @pre radii are finite and >= 0.
ExactResult exact_rounded_distance(const WorldVertices& a, double radius_a, const WorldVertices& b,
                                   double radius_b);

/// The class alone: cheaper.
PairClass exact_pair_class(const WorldVertices& a, const WorldVertices& b);
/// True for `touching` and `penetrating`: cheaper still.
bool exact_overlap(const WorldVertices& a, const WorldVertices& b);

/// The signed distance as a decimal d.ddde[+-]x with `digits` significant digits, rounded to nearest; "0"
/// when touching.
/// @pre digits >= 1
std::string exact_signed_distance_decimal(const WorldVertices& a, const WorldVertices& b, int digits);

/// (min_j n.b_j - max_i n.a_i) / |n| for this n as it is, rounded to nearest [m]; NaN if n is zero or not
/// finite.
double exact_separation_along(const WorldVertices& a, const WorldVertices& b, const Vector3& n);

/// Distance from p to the surface of the solid (from inside too; a flat solid is all surface), rounded to
/// nearest [m].
double exact_surface_distance(const WorldVertices& solid, const Vector3& p);

}  // namespace touchstone
