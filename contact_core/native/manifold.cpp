#include "contact_core/native/manifold.hpp"

#include <algorithm>
#include <cmath>

#include "contact_core/native/largest_choice.hpp"
#include "contact_core/native/outline_clip.hpp"
#include "contact_core/native/tangent_frame.hpp"

namespace touchstone::native {
namespace {

/// Edges this close coincide, points this close to the deepest are as deep: so many u * extent.
constexpr double kCoincide = 16;
constexpr double kAsDeep = 64;
constexpr std::uint32_t kWitnessId = 0x10000;

/// The corners of the clip that may become contact points.
struct Candidates {
  int count = 0;
  int deepest = -1;  ///< the first of those as deep as the deepest
  std::array<std::uint8_t, FlatPolygon::kMost> edge;
  std::array<std::uint32_t, FlatPolygon::kMost> id;
};

template <int N>
struct Patch {
  Outline<N> a, b;
  Clip<N> clip;

  std::uint32_t label(int edge) const { return edge < N ? a.label[edge] : b.label[edge - N]; }
};

template <int N>
void find_candidates(const Patch<N>& patch, double limit, double tie, Candidates& out) {
  const Clip<N>& clip = patch.clip;
  double least = limit;
  std::uint32_t before = clip.count > 0 ? patch.label(clip.edge[clip.count - 1]) : 0;
  out.count = 0;
  for (int i = 0; i < clip.count; ++i) {
    const int edge = clip.edge[i];
    const std::uint32_t label = patch.label(edge);
    const double separation = clip.separation[edge];
    out.edge[out.count] = static_cast<std::uint8_t>(edge);
    out.id[out.count] = 1 + before + 16 * label;
    out.count += separation <= limit;
    least = separation < least ? separation : least;
    before = label;
  }
  out.deepest = -1;
  for (int i = out.count - 1; i >= 0; --i)
    out.deepest = clip.separation[out.edge[i]] <= least + tie ? i : out.deepest;
}

/// Which of the candidates stay, when there are more than `room`.
template <int N>
int reduce(const Patch<N>& patch, const Candidates& candidates, const TangentFrame& frame, int room, int must,
           Choice& chosen) {
  FlatPolygon polygon;
  polygon.count = candidates.count;
  for (int i = 0; i < candidates.count; ++i) {
    const int edge = candidates.edge[i];
    const Vector3 p(patch.clip.p_x[edge], patch.clip.p_y[edge], patch.clip.p_z[edge]);
    polygon.x[i] = dot(p, frame.x), polygon.y[i] = dot(p, frame.y);
  }
  if (room > 0) choose_largest(polygon, room, must, chosen);
  return room;
}

template <int N>
void write_points(const Patch<N>& patch, const TangentFrame& frame, std::uint32_t faces,
                  const SignedDistance& distance, double max_separation, int max_points, double extent,
                  Manifold& manifold) {
  const double limit = std::max(max_separation, distance.separation);
  const double tie = kAsDeep * kRoundoff * extent;
  Candidates candidates;
  find_candidates(patch, limit, tie, candidates);
  const bool reached =
      candidates.deepest >= 0 &&
      std::abs(patch.clip.separation[candidates.edge[candidates.deepest]] - distance.separation) <= tie;
  const int deepest = reached ? candidates.deepest : -1;
  const int room = reached ? max_points : max_points - 1;

  Choice chosen;
  int count = candidates.count;
  if (count > room) {
    count = reduce(patch, candidates, frame, room, deepest, chosen);
  } else {
    for (int i = 0; i < count; ++i) chosen[i] = i;
  }
  for (int k = 0; k < count; ++k) {
    const int i = chosen[k], edge = candidates.edge[i];
    ContactPoint& point = manifold.points[k];
    const Vector3 p(patch.clip.p_x[edge], patch.clip.p_y[edge], patch.clip.p_z[edge]);
    // No pair of points lies deeper than the pair; what rounding puts below is as deep.
    const double s = patch.clip.separation[edge];
    const double separation = i == deepest || !(s > distance.separation) ? distance.separation : s;
    const bool on_a = edge < N;
    point.p_A_W = p + (on_a ? 0.0 : -separation) * frame.n;
    point.p_B_W = p + (on_a ? separation : 0.0) * frame.n;
    point.separation = separation;
    point.feature_id = candidates.id[i] + faces;
  }
  if (!reached) {
    ContactPoint& point = manifold.points[count++];
    point.p_A_W = distance.p_A;
    point.p_B_W = distance.p_A + distance.separation * distance.n;
    point.separation = distance.separation;
    point.feature_id = kWitnessId;
  }
  manifold.count = count;
}

}  // namespace

void make_manifold(const PosedPair& pair, const SignedDistance& distance, double max_separation,
                   int max_points, Manifold& manifold) {
  const TangentFrame frame = tangent_frame(distance.n);
  const double extent = pair.hulls.extent;
  Facing a = facing(*pair.a, pair.R_WA, pair.hulls.a, frame.n, 1.0);
  Facing b = facing(*pair.b, pair.R_WB, pair.hulls.b, frame.n, -1.0);
  const auto faces = static_cast<std::uint32_t>(256 * a.face + 4096 * b.face);
  const double tolerance = kCoincide * kRoundoff * extent, shortest = kSameCorner * extent;

  Patch<4> plain;
  if (plain_outlines(pair, frame, a, b, plain.a, plain.b)) {
    clip(plain.a, plain.b, frame.n, a, b, tolerance, shortest, plain.clip);
    write_points(plain, frame, faces, distance, max_separation, max_points, extent, manifold);
    return;
  }
  Patch<kMostCorners> patch;
  if (careful_outline(pair.a->faces[a.face], pair.hulls.a, extent, frame, 1.0, a, patch.a) &&
      careful_outline(pair.b->faces[b.face], pair.hulls.b, extent, frame, -1.0, b, patch.b))
    clip(patch.a, patch.b, frame.n, a, b, tolerance, shortest, patch.clip);
  write_points(patch, frame, faces, distance, max_separation, max_points, extent, manifold);
}

}  // namespace touchstone::native
