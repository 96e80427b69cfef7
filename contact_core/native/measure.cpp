#include "contact_core/native/measure.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "contact_core/native/manifold.hpp"
#include "contact_core/native/overlap.hpp"

namespace touchstone::native {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

void write_beyond(PairGeometry& out) {
  out.separation = kInfinity;
  out.n_AB_W = out.p_A_W = out.p_B_W = Vector3::Constant(kNaN);
  out.point_count = 0;
}

PairStatus measure_one(const SolidSet& set, const SolidPair& given, const NarrowphaseInput& input,
                       PairGeometry& geometry, ContactPoint* points) {
  const bool swapped =
      !comes_first(set.solids[given.a], input.poses[given.a], set.solids[given.b], input.poses[given.b]);
  const SolidPair pair = swapped ? SolidPair{given.b, given.a} : given;
  const Pose& X_WA = input.poses[pair.a];
  const Pose& X_WB = input.poses[pair.b];
  const bool ordinary = is_ordinary(set, pair.a, X_WA, pair.b, X_WB);
  PlacedPair placed;
  place(set.solids[pair.a], X_WA, set.solids[pair.b], X_WB, ordinary, placed);

  Certified certified = ordinary ? certify_kinds(set, pair, input.poses) : Certified::unknown;
  if (certified == Certified::unknown)
    certified = hulls_meet(placed) ? Certified::overlapping : Certified::separated;
  const bool meet = certified == Certified::overlapping;
  const PairStatus status = meet ? PairStatus::overlapping : PairStatus::separated;

  const double max_separation = input.query.max_separation;
  const double limit = std::scalbn(max_separation, placed.exponent);
  SignedDistance distance;
  if (meet) {
    penetration(placed.pair, distance);
  } else if (!distance_apart(placed.pair, limit, distance)) {
    write_beyond(geometry);
    return status;
  }

  geometry.separation = placed.to_world(distance.separation);
  if (!meet) geometry.separation = std::max(geometry.separation, std::numeric_limits<double>::denorm_min());
  if (geometry.separation > max_separation) {
    write_beyond(geometry);
    return status;
  }
  const Vector3 p_A = placed.to_world(distance.p_A);
  const Vector3 p_B = p_A + geometry.separation * distance.n;
  geometry.n_AB_W = swapped ? Vector3(-distance.n) : distance.n;
  geometry.p_A_W = swapped ? p_B : p_A;
  geometry.p_B_W = swapped ? p_A : p_B;
  geometry.point_count = 0;
  if (points == nullptr) return status;

  Manifold manifold;
  make_manifold(placed.pair, distance, limit, std::clamp(input.query.max_points, 1, kMaxManifoldPoints),
                manifold);
  geometry.point_count = manifold.count;
  for (int i = 0; i < manifold.count; ++i) {
    const ContactPoint& from = manifold.points[i];
    points[i].p_A_W = placed.to_world(swapped ? from.p_B_W : from.p_A_W);
    points[i].p_B_W = placed.to_world(swapped ? from.p_A_W : from.p_B_W);
    // The deepest point carries the pair's own bits.
    points[i].separation =
        from.separation == distance.separation ? geometry.separation : placed.to_world(from.separation);
    points[i].feature_id = from.feature_id;
  }
  return status;
}

}  // namespace

void measure(const SolidSet& set, const Kernels&, const NarrowphaseInput& input, std::span<PairStatus> status,
             std::span<PairGeometry> geometry, std::span<ContactPoint> points) {
  const std::size_t slots =
      static_cast<std::size_t>(std::clamp(input.query.max_points, 1, kMaxManifoldPoints));
  for (std::size_t i = 0; i < input.pairs.size(); ++i) {
    ContactPoint* pair_points = points.empty() ? nullptr : &points[i * slots];
    status[i] = measure_one(set, input.pairs[i], input, geometry[i], pair_points);
  }
}

}  // namespace touchstone::native
