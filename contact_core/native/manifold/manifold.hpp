#pragma once

#include <array>

#include "touchstone/contact_core/narrowphase/narrowphase.hpp"
#include "touchstone/contact_core/native/distance/distance.hpp"
#include "touchstone/contact_core/native/simd/kernels.hpp"

namespace touchstone::native {

/// Contact points about the hulls' common origin.
struct Manifold {
  int count = 0;
  std::array<ContactPoint, kMaxManifoldPoints> points;
};

/// The manifold of a pair of hexahedra that the kernels for boxes and parallelepipeds do not take: those clip
/// one pair of boxes in simd/box_pair_clip.hpp, many pairs in simd/manifold_kernels.hpp, led by
/// clip_batch.hpp. Where faces are the solids' own quadrangles, the same steps are taken in lanes: of one
/// pair by simd/hull_pair_clip.hpp, of a batch's pairs of plane faces by simd/hull_clip_lanes.hpp, and the
/// rest by finish_hull_clip().
///
/// The face of each hull whose normal is most along n (A) and against n (B), seen along n and clipped against
/// each other (polygon_clip.hpp). Each corner of the clip lies on an edge of one face; carried along n onto
/// the other it gives p_A on A, p_B on B and p_B = p_A + separation * n. The separations of one manifold
/// differ where the faces lean, and may be positive for a pair that overlaps; points further apart than
/// `max_point_separation` are left out, but for those as deep as the pair to rounding (64 u extent). A face
/// whose normal leans more than 83 degrees from n counts as its edge furthest along n; faces that are points
/// seen along n (edges on end, solids flattened by rounding) clip nothing.
///
/// Bent faces. Corners that a file rounds bend the face that they belong to: the hull has two triangles there
/// and a ridge between them. Where the triangles' normals agree to a cosine of kManifoldCosine
/// (solid_features.hpp) the polygon has all four corners: the face is chosen by its area vector,
/// whichever triangle's normal n is. All four sides are edges of the hull, so that a corner on one of them
/// lies on its own solid as it does on a plane face; the other solid lies behind both triangles' planes, and
/// the plane that comes later along n is its surface. So the points hold the whole face and do not jump when
/// n changes from one triangle's normal to the other's, while class, distance and every separation stay the
/// true hull's. Where the ridge itself is deepest the pair's witness point is there besides: a clip of eight
/// corners then keeps the seven that hold most (0.927 of a regular octagon). A bent face that is not convex
/// seen along n, possible near 90 degrees only, counts as the one of its triangles that leans less.
///
/// Flush edges are one: an edge of A and one of B that run the same way to 2^-26 (1.5e-8 rad) and lie no
/// further apart than 2^-26 of the shorter one (or coincide to rounding). The clip's corner between them, if
/// they cross, is left out, which takes no more than 2^-26 of the faces' sizes off its area; all other
/// corners keep their places. So faces laid flush on each other have the corners that they have when they lie
/// there exactly, whichever way rounding or a solver's noise turns them.
///
/// The deepest point always is there with exactly the pair's separation: the corner that reaches it, the
/// first of several, else the pair's witness point as one more.
///
/// Reduction to `max_points`: the deepest stays, with the choice of the others that has the largest hull area
/// seen along n (the first in the clip's order among those equal to 1e-9). Four points hold at least 1/2
/// of the clip's area, three 1/4, whichever corner is deepest; beside a witness point four hold 0.41 (see
/// point_reduction.hpp).
///
/// Error, u = 2^-53, S = max(size, largest |world coordinate|), so that extent <= 2 S. On its own edge a
/// point is right to 9 u extent, its interpolation's rounding. From the other face's plane it is off by 35 u
/// extent at most: the plane's normal and height, the step along n; of two planes the later one is off by no
/// more than the worse. A face's plane holds the world vertices to 8 u size (solid_features.hpp; a triangle's
/// to its normal's rounding) and their own rounding, 6 u S. Seen along n a corner lies within 16 u extent of
/// the lines that cut it (23 where edges coincide), so within 8 times that of the polygon, whose sharper
/// corners (below asin(1/4)) are bevelled, and on a plane at cosine c to n it is off the face by that / c.
/// Together 100 u S + 2 * 23 * 8 / c u S: for c = 1/8 at worst 2^12 u S = 5e-13 S, whatever the solids'
/// thickness; for right-angled faces across n 170 u S = 2e-14 S. p_B - p_A = separation * n holds to 8 u S,
/// at the deepest point p_B lies off B by another 64 u extent at most. The bound supposes that n and the
/// separation belong together: a point that lies deeper than `distance.separation` is given that separation.
/// Seen: 5e-16 S, on thin solids 5e-15 S (native_manifold_accuracy_test.cpp).
///
/// Boxes and parallelepipeds go through a kernel (manifold_kernels.hpp, where its own bound, 2^-40 S,
/// stands).
///
/// Tiny motion moves the corners by as much (by that over the sine of the angle, where edges cross at a small
/// one); the ids and the number of points change only where a corner comes to lie across an edge that it is
/// not flush with.
///
/// feature_id: 1 + edge + 16 * edge' + 256 * face of A + 4096 * face of B, where the corner is the meeting of
/// two of the faces' edges (0-7: A's, 8-15: B's; flush ones go by A's); 0x10000 for the witness point. A and
/// B are the caller's, in whichever order the check takes the pair. @param swapped whether the caller's is
/// (b, a).
void make_manifold(const PosedPair& pair, const SignedDistance& distance, double max_point_separation,
                   int max_points, bool swapped, Manifold& manifold);

/// Finishes the points of a kernel's clip, which are in `points` (room for eight), as those of (b, a) where
/// swapped. Returns their number. @param distance_W of (a, b), its p_A in the world.
int finish_clip(const SignedDistance& distance_W, bool swapped, const ClipRecord& clipped, int max_points,
                ContactPoint* points);

/// As make_manifold(), of a pair whose faces clip_hulls or clip_hull_pair has clipped about A's first vertex:
/// the same bits.
/// @pre its record fits. @param max_point_separation of that call.
void finish_hull_clip(const HullClipRecord& clipped, const SignedDistance& distance,
                      double max_point_separation, int max_points, bool swapped, Manifold& manifold);

}  // namespace touchstone::native
