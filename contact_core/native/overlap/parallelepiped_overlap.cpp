#include "touchstone/contact_core/native/overlap/parallelepiped_overlap.hpp"

#include <algorithm>
#include <cmath>

#include "touchstone/contact_core/native/common/hull_pair.hpp"

// Notation. u = 2^-53; a_i, b_j: the rotated half edges and T: the difference of the centres, all as
// computed; |.| the 1-norm; h = sum |a_i| + sum |b_j| + |centre_a| + |centre_b|, t = |T|, P = |p_A|_inf +
// |p_B|_inf, D = both deviations.
//
// The hulls of the rounded world vertices are within e = 32 u (h + t) + 4 u P + 2 D (Hausdorff, both
// together) of the parallelepipeds that a_i, b_j and T span exactly: a vertex rounds by 3 u of its rotated
// part and u of the sum, a rotated half edge by 3 u, the centre and T by 3 u and u, the factor sqrt(3) from
// coordinates to length included.
//
// On an axis L, a cross product of two of the edges p and q, the slack is s = r_A + r_B - |T . L|. |L| <= |p|
// |q|; each triple product is off by at most 8 u |p| |q| times its third factor, so s by at most 32 u |p| |q|
// (h + t). Hence with m = |p| |q| (e + 32 u (h + t)): s < -m certifies separation, s > m on all 15 axes
// overlap by a depth above e.

namespace touchstone::native {
namespace {

constexpr double kSizeRoundoffs = 64.0;
constexpr double kPositionRoundoffs = 4.0;

struct Edges {
  std::array<Vector3, 3> edge;
  std::array<Vector3, 3> normal;  // edge[i + 1] x edge[i + 2]
  std::array<double, 3> length;   // 1-norms
  double size;
};

void rotate_edges(const Parallelepiped& p, const Matrix3& R, Edges& out) {
  for (int i = 0; i < 3; ++i) {
    out.edge[i] = rotate(R, vector_of(p.half_edges[i]));
    out.length[i] = norm_1(out.edge[i]);
  }
  for (int i = 0; i < 3; ++i) out.normal[i] = cross(out.edge[(i + 1) % 3], out.edge[(i + 2) % 3]);
  out.size = (out.length[0] + out.length[1]) + out.length[2];
}

/// |normal_i . edge_j| of one against the other.
using Triples = std::array<std::array<double, 3>, 3>;

Triples triples(const Edges& of, const Edges& against) {
  Triples out;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) out[i][j] = std::abs(dot(of.normal[i], against.edge[j]));
  return out;
}

/// The verdict of one axis after another.
struct Verdict {
  double error;  // e + 32 u (h + t)
  bool separated = false;
  bool overlapping = true;

  void add(double slack, double scale) {
    const double margin = scale * error;
    separated |= slack < -margin;
    overlapping &= slack > margin;
  }
};

void add_faces(const Edges& p, const Triples& p_against_q, const Vector3& T, Verdict& verdict) {
  const double radius = std::abs(dot(p.normal[0], p.edge[0]));
  for (int i = 0; i < 3; ++i) {
    const double reach = (p_against_q[i][0] + p_against_q[i][1]) + p_against_q[i][2];
    verdict.add((radius + reach) - std::abs(dot(p.normal[i], T)),
                p.length[(i + 1) % 3] * p.length[(i + 2) % 3]);
  }
}

}  // namespace

Certified certify_parallelepipeds(const Parallelepiped& a, const Pose& X_WA, const Parallelepiped& b,
                                  const Pose& X_WB) {
  Edges A, B;
  rotate_edges(a, X_WA.R, A);
  rotate_edges(b, X_WB.R, B);
  const Vector3 centre_a = vector_of(a.centre), centre_b = vector_of(b.centre);
  const Vector3 T = (X_WB.p - X_WA.p) + (rotate(X_WB.R, centre_b) - rotate(X_WA.R, centre_a));
  const double size = ((A.size + B.size) + (norm_1(centre_a) + norm_1(centre_b))) + norm_1(T);
  Verdict verdict{kSizeRoundoffs * kRoundoff * size +
                  kPositionRoundoffs * kRoundoff * (norm_inf(X_WA.p) + norm_inf(X_WB.p)) +
                  2 * (a.deviation + b.deviation)};
  const Triples a_b = triples(A, B);
  add_faces(A, a_b, T, verdict);
  if (verdict.separated) return Certified::separated;
  const Triples b_a = triples(B, A);
  add_faces(B, b_a, T, verdict);
  if (verdict.separated) return Certified::separated;
  for (int i = 0; i < 3; ++i) {
    const int i1 = (i + 1) % 3, i2 = (i + 2) % 3;
    const Vector3 moment = cross(T, A.edge[i]);  // T . (a_i x b_j) = b_j . (T x a_i)
    for (int j = 0; j < 3; ++j) {
      const int j1 = (j + 1) % 3, j2 = (j + 2) % 3;
      // (a_i x b_j) . a_k is up to sign b_j . normal of A opposite both; likewise for B.
      const double radii = (a_b[i1][j] + a_b[i2][j]) + (b_a[j1][i] + b_a[j2][i]);
      verdict.add(radii - std::abs(dot(moment, B.edge[j])), A.length[i] * B.length[j]);
    }
  }
  if (verdict.separated) return Certified::separated;
  return verdict.overlapping ? Certified::overlapping : Certified::unknown;
}

}  // namespace touchstone::native
