#pragma once

#include <array>

#include "contact_core/narrowphase/narrowphase.hpp"
#include "contact_core/native/distance.hpp"

namespace touchstone::native {

/// Contact points about the hulls' common origin.
struct Manifold {
  int count = 0;
  std::array<ContactPoint, kMaxManifoldPoints> points;
};

/// The face of each hull whose normal is most along n (A) and against n (B), both projected along n, clipped
/// against each other (Sutherland, Hodgman 1974). Each corner of the clip is carried along n back onto both
/// faces, so p_A lies on A, p_B on B and p_B = p_A + separation * n; the separations of one manifold differ
/// where the faces lean, and may be positive for a pair that overlaps. That holds to rounding for faces wider
/// than the world vertices' rounding; a face that rounding has flattened does not clip, and points on solids
/// nearly that thin were seen 6e-9 S off the surface, in the worst (two nearly flat warped solids, 500 m out)
/// 1e-4 S. Points further apart than `max_separation` are left out. The deepest point always is there with
/// exactly the pair's separation: the corner that reaches it, else the pair's witness point as one more.
///
/// More than `max_points`: the deepest stays, and of all choices of the others the one with the largest hull
/// area projected along n (the first in the clip's order among those equal to 1e-9).
///
/// feature_id: 1 + edge + 16 * edge' + 256 * face of A + 4096 * face of B, where the corner is the meeting of
/// two of the faces' edges (0-7: A's, 8-15: B's); 0x10000 for the witness point. It names A and B in the
/// check's own order of the pair.
void make_manifold(const PosedPair& pair, const SignedDistance& distance, double max_separation,
                   int max_points, Manifold& manifold);

}  // namespace touchstone::native
