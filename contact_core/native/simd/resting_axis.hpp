#pragma once

#include "touchstone/contact_core/native/simd/box_pair.hpp"

// Of two boxes that rest on each other, face on face, the axis of least overlap from six of the fifteen axes:
// the two faces' normals, and those across edges that bound these faces. All six point nearly the same way
// and overlap by nearly as much; they are formed and compared as search_pair_axes() does, so that it would
// find the same axis. The other nine surely lose.
//
// Notation as in depth_kernels.hpp; h(n) is the overlap along a unit axis n, the support of P = A - B along n
// or -n, whichever is less. Faces z of A and w of B lie on each other; e is the largest of |n_z . B_j|, |n_i
// . B_w| for the other i and j: how far the boxes lean. D is the least slack of the six faces, m of the four
// that are not z and w. Directions are orthonormal to 2^-19.9 (valid poses), so normals and directions, and
// |L| and 1, may be exchanged at 2^-18: with e' = 2 e + 2^-16 each direction of either box is along, or
// across, n_z to e'.
//
// Of the nine, four are the other faces, with m or more, and five are across A_z or B_w, at an angle of 90
// degrees from n_z to 2 e'. Seen along n_z, A_i and B_j span a polygon in P whose sides are at those faces:
// its distance from the origin is m - 3 e' size at least, and P holds it at a height of e' size at most over
// the origin, for D is above 0, and as much below. So along the five axes h >= (1 - 2 e'^2) (m - 3 e' size) -
// 2 e' size >= m - 6 e' size - 2^-8 m for e' <= 2^-5. Where m >= (1 + 2^-6) D + (16 e + 2^-12) size that is D
// and 2^-13 size more: what rounding and the handicap of edges change is far less. Their slacks are above D,
// too, for |L| is 1 to 2^-12, but across A_z and B_w, whose slack is divided by it.

namespace touchstone::native::TOUCHSTONE_ISA {

/// Faces' normals as axes of a pair: A's in the lanes of [0], B's of [1].
struct PairFaceAxes {
  Double4 along[2][3];  ///< of the other's direction k
  Double4 slack[2];

  TOUCHSTONE_INLINE explicit PairFaceAxes(const BoxPair& boxes) {
    for (int s = 0; s < 2; ++s) {
      const Double4(&half)[3] = boxes.half[1 - s];
      for (int k = 0; k < 3; ++k) along[s][k] = magnitude(dot(boxes.normal[s], boxes.each[1 - s][k]));
      const Double4 reach = (half[0] * along[s][0] + half[1] * along[s][1]) + half[2] * along[s][2];
      slack[s] = (boxes.extents[s] * boxes.volume[s] + reach) - magnitude(dot(boxes.normal[s], boxes.T));
    }
  }
};

/// What is known of a pair.
struct RestingPair {
  const BoxPair& boxes;
  const PairFaceAxes& faces;
  double least_slack;  ///< of all six faces
  double size;
  double margin;  ///< beyond which slacks certify overlap
};

/// Face z of A lies on face w of B. i and j: the other directions, in order.
template <int z, int w>
struct RestingFaces {
  static constexpr int i1 = z == 0 ? 1 : 0, i2 = z == 2 ? 1 : 2, j1 = w == 0 ? 1 : 0, j2 = w == 2 ? 1 : 2;
  /// Of edges that the search leaves out: three at most, each turns the boxes by 8 (|L|_1 + 8 u), |L| <= 8 u.
  static constexpr double kTurnMost = 3 * 8 * 22 * kU;

  /// @return the axis' code, or -1
  TOUCHSTONE_INLINE static int find(const RestingPair& pair) {
    const Double4(&of_a)[3] = pair.faces.along[0], (&of_b)[3] = pair.faces.along[1];
    const Double4 z_on_j = __builtin_shufflevector(of_a[j1], of_a[j2], z, 4 + z, z, 4 + z);
    if (!others_lose(pair, z_on_j)) return -1;
    // Across edges, as search_pair_axes() does: lanes (i1, j1), (i1, j2), (i2, j1), (i2, j2).
    const BoxPair& boxes = pair.boxes;
    const auto by_i = [](Double4 p, Double4 q) { return __builtin_shufflevector(p, q, 0, 1, 6, 7); };
    const auto by_j = [](Double4 p, Double4 q) { return __builtin_shufflevector(p, q, 0, 5, 2, 7); };
    const Vector3Of<Double4>&A1 = boxes.each[0][i1], &A2 = boxes.each[0][i2], &B1 = boxes.each[1][j1],
          &B2 = boxes.each[1][j2];
    const Vector3Of<Double4> L =
        cross(Vector3Of<Double4>{by_i(A1.x, A2.x), by_i(A1.y, A2.y), by_i(A1.z, A2.z)},
              Vector3Of<Double4>{by_j(B1.x, B2.x), by_j(B1.y, B2.y), by_j(B1.z, B2.z)});
    // Of sums of two the order does not matter.
    const Double4 w_on_i = __builtin_shufflevector(of_b[i1], of_b[i2], w, w, 4 + w, 4 + w);
    const Double4 k_on_j = __builtin_shufflevector(of_a[j1], of_a[j2], i2, 4 + i2, i1, 4 + i1);
    const Double4 l_on_i = __builtin_shufflevector(of_b[i1], of_b[i2], j2, j1, 4 + j2, 4 + j1);
    const Double4(&half_a)[3] = boxes.half[0], (&half_b)[3] = boxes.half[1];
    const Double4 radius_a = by_i(half_a[i2], half_a[i1]) * z_on_j + half_a[z] * k_on_j;
    const Double4 radius_b = by_j(half_b[j2], half_b[j1]) * w_on_i + half_b[w] * l_on_i;
    return choose(pair, (radius_a + radius_b) - magnitude(dot(L, boxes.T)), dot(L, L));
  }

 private:
  TOUCHSTONE_INLINE static bool others_lose(const RestingPair& pair, Double4 z_on_j) {
    const PairFaceAxes& faces = pair.faces;
    const Double4 w_at = faces.along[0][w];
    const Double4 lean = greatest(z_on_j, __builtin_shufflevector(w_at, w_at, i1, i2, i1, i2));
    const double e = lean[0] > lean[1] ? lean[0] : lean[1];
    const double on_a = faces.slack[0][i1] < faces.slack[0][i2] ? faces.slack[0][i1] : faces.slack[0][i2];
    const double on_b = faces.slack[1][j1] < faces.slack[1][j2] ? faces.slack[1][j1] : faces.slack[1][j2];
    return (on_a < on_b ? on_a : on_b) >=
           pair.least_slack * (1.0 + 0x1p-6) + (16.0 * e + 0x1p-12) * pair.size;
  }

  TOUCHSTONE_INLINE static int choose(const RestingPair& pair, Double4 slack, Double4 L2) {
    // Edges at small angles are no axes, surely lose, or the search tells.
    const double unit_size = kU * pair.size, sure = pair.margin + kTurnMost * pair.size;
    const double face_square = pair.least_slack * pair.least_slack;
    const Mask4 is_short = L2 < all<Double4>(kShortAxis2), none = L2 <= all<Double4>(kSurelyNoAxis2);
    const Mask4 loses = is_short & surely_loses<Double4>(slack, L2, all<Double4>(kSlackRoundoffs * unit_size),
                                                         all<Double4>(face_square), all<Double4>(1.0));
    const Mask4 is_axis = ~(none | loses);
    if (!(pair.least_slack > sure) || bits(is_axis & (is_short | ~(slack > all<Double4>(sure)))) != 0)
      return -1;
    // As PairSearch::choose(): faces, then edges where they are better.
    const Vector3Of<Double4>&n_a = pair.boxes.normal[0], &n_b = pair.boxes.normal[1];
    const double o_z = pair.faces.slack[0][z], o_w = pair.faces.slack[1][w];
    const double z2 = dot(n_a, n_a)[z], w2 = dot(n_b, n_b)[w];
    const bool is_w = (o_w * o_w) * z2 < (o_z * o_z) * w2;
    double best_square = is_w ? o_w * o_w : o_z * o_z, best_length2 = is_w ? w2 : z2;
    int code = is_w ? 3 + w : z;
    const Double4 overlap = slack + all<Double4>(kTieRoundoffs * unit_size), square = overlap * overlap;
    for (unsigned near = bits(is_axis & (square <= all<Double4>(near_limit(face_square)) * L2)); near != 0;
         near &= near - 1) {
      const int lane = __builtin_ctz(near);
      if (!(square[lane] * best_length2 < best_square * L2[lane])) continue;
      best_square = square[lane], best_length2 = L2[lane];
      code = 6 + 3 * (lane < 2 ? i1 : i2) + (lane % 2 == 0 ? j1 : j2);
    }
    return code;
  }
};

/// Faces lean by 2^-7 at most, with 2^-9 of rounding and poses.
constexpr double kFlat = 1.0 - 0x1p-15;

/// Whether a face of A and one of B are so nearly parallel.
TOUCHSTONE_INLINE bool are_flat(const PairTurn& turn) {
  const Double4 flattest =
      greatest(greatest(magnitude(turn.C[0]), magnitude(turn.C[1])), magnitude(turn.C[2]));
  return (bits(flattest >= all<Double4>(kFlat)) & 7u) != 0;
}

/// The faces that lie on each other, one of which has the least slack, as 3 w + z; 9: there are none.
TOUCHSTONE_INLINE int find_resting_faces(const RestingPair& pair) {
  const PairFaceAxes& faces = pair.faces;
  const Double4 flat = all<Double4>(kFlat), lowest = all<Double4>(pair.least_slack);
  unsigned flush = 0;
  for (int k = 0; k < 3; ++k) flush |= (bits(faces.along[0][k] >= flat) & 7u) << 3 * k;
  const unsigned a = bits(faces.slack[0] <= lowest) & 7u, b = bits(faces.slack[1] <= lowest) & 7u;
  const unsigned with_b = ((b & 1u) | (b & 2u) << 2 | (b & 4u) << 4) * 7u;
  return __builtin_ctz((flush & (a != 0 ? a * 0x49u : with_b)) | 1u << 9);
}

/// The axis of least overlap of a pair that certainly overlaps, two of whose faces lie on each other, where
/// the other nine axes surely lose: its code, else -1.
TOUCHSTONE_INLINE int find_resting_axis(const RestingPair& pair) {
  switch (find_resting_faces(pair)) {
    case 0:
      return RestingFaces<0, 0>::find(pair);
    case 1:
      return RestingFaces<1, 0>::find(pair);
    case 2:
      return RestingFaces<2, 0>::find(pair);
    case 3:
      return RestingFaces<0, 1>::find(pair);
    case 4:
      return RestingFaces<1, 1>::find(pair);
    case 5:
      return RestingFaces<2, 1>::find(pair);
    case 6:
      return RestingFaces<0, 2>::find(pair);
    case 7:
      return RestingFaces<1, 2>::find(pair);
    case 8:
      return RestingFaces<2, 2>::find(pair);
    default:
      return -1;
  }
}

}  // namespace touchstone::native::TOUCHSTONE_ISA
