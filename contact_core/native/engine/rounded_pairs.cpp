#include <algorithm>
#include <cmath>
#include <limits>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/narrowphase/no_geometry.hpp"
#include "touchstone/contact_core/narrowphase/rounded_manifold.hpp"
#include "touchstone/contact_core/native/distance/distance.hpp"
#include "touchstone/contact_core/native/engine/evaluation.hpp"
#include "touchstone/contact_core/native/engine/pair_geometry.hpp"
#include "touchstone/contact_core/native/overlap/overlap.hpp"
#include "touchstone/contact_core/numerics/rounded_predicate.hpp"

namespace touchstone::native {
namespace {

/// Of a pair's scale: 256 times the resolution that is declared for the cores' distances. What is nearer to
/// the sum of the radii is decided in integers.
constexpr double kSurely = 0x1p-40;

struct Solid {
  SolidIndex index;
  double radius;
  bool is_point;  ///< the core
  bool is_flat;   ///< the core has no volume
};

Solid solid_of(const SolidSet& set, SolidIndex index) {
  Solid out{index, radius_of(set, index), false, false};
  if (set.kinds[index] != SolidKind::box) return out;
  const Vector3 half = half_extents(set.boxes[index]);
  out.is_flat = !(half.x() > 0.0 && half.y() > 0.0 && half.z() > 0.0);
  out.is_point = norm_inf(half) == 0.0;
  return out;
}

/// At least every coordinate, length and radius of the pair [m].
double scale_of(const SolidSet& set, const Solid& solid, const Pose& X_WS) {
  const SolidData& data = set.solids[solid.index];
  return norm_inf(X_WS.p) + 2.0 * (data.middle + data.size) + solid.radius;
}

/// Distance and direction of two points of any magnitudes.
double distance_between(const Vector3& p, const Vector3& q, Vector3& n) {
  const double largest = norm_inf(0.5 * q - 0.5 * p);
  n = Vector3::Unit(2);
  if (largest == 0.0) return 0.0;
  const int exponent = std::ilogb(largest);
  const auto scaled = [exponent](const Vector3& v, int k) -> Vector3 {
    return {std::scalbn(v.x(), k - exponent), std::scalbn(v.y(), k - exponent),
            std::scalbn(v.z(), k - exponent)};
  };
  const Vector3 d = scaled(largest < 0x1p900 ? Vector3(q - p) : Vector3(0.5 * q - 0.5 * p), 0);
  const double length = norm(d);
  n = d / length;
  return std::scalbn(length, largest < 0x1p900 ? exponent : exponent + 1);
}

/// Limits between which their squares, and those of lengths that exceed them, are ordinary [m].
constexpr double kLeastSquared = 1e-100, kMostSquared = 1e100;

/// Squared lengths of axes from here on leave their products with those squares ordinary.
constexpr double kLeastAxisSquared = 1e-60;

/// Whether two boxes' hulls are further apart than this along one of the fifteen axes on which boxes part. On
/// any axis the gap is at most the distance, and off by some roundings of the axis' length times the pair's
/// scale: with a slack in the limit that is far above these, a yes is certain. Axes across edges so nearly
/// parallel that products with them underflow tell nothing.
bool are_apart_by(double limit, const Vector3& half_A, const Pose& X_WA, const Vector3& half_B,
                  const Pose& X_WB) {
  if (!(limit >= kLeastSquared && limit <= kMostSquared)) return false;
  const Vector3 p_AB_W = X_WB.p - X_WA.p;
  const auto reach = [](const Vector3& n, const Vector3& half, const Matrix3& R) {
    return std::abs(dot(n, R.col(0))) * half.x() + std::abs(dot(n, R.col(1))) * half.y() +
           std::abs(dot(n, R.col(2))) * half.z();
  };
  const auto parts = [&](const Vector3& n) {
    const double gap = std::abs(dot(n, p_AB_W)) - reach(n, half_A, X_WA.R) - reach(n, half_B, X_WB.R);
    if (!(gap > 0.0 && gap <= kMostSquared)) return false;
    const double length_squared = dot(n, n);
    return length_squared >= kLeastAxisSquared && gap * gap > limit * limit * length_squared;
  };
  for (int i = 0; i < 3; ++i)
    if (parts(X_WA.R.col(i)) || parts(X_WB.R.col(i))) return true;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      if (parts(cross(X_WA.R.col(i), X_WB.R.col(j)))) return true;
  return false;
}

class RoundedPair {
 public:
  RoundedPair(const SolidSet& set, const Kernels& kernels, const SolidPair& pair,
              const NarrowphaseInput& input)
      : set_(set),
        kernels_(kernels),
        input_(input),
        pair_(pair),
        a_(solid_of(set, pair.a)),
        b_(solid_of(set, pair.b)),
        sum_(a_.radius + b_.radius),
        slack_(kSurely * (scale_of(set, a_, X_WA()) + scale_of(set, b_, X_WB())) +
               std::numeric_limits<double>::min()) {}

  /// Whether they meet, of two boxes whose cores are apart.
  PairStatus run_apart() {
    PairGeometry geometry;
    return are_apart_by(sum_ + slack_, half_extents(set_.boxes[pair_.a]), X_WA(),
                        half_extents(set_.boxes[pair_.b]), X_WB())
               ? PairStatus::separated
               : run(geometry, nullptr);
  }

  PairStatus run(PairGeometry& geometry, ContactPoint* points) {
    const bool overlap_only = input_.query.kind == QueryKind::overlap;
    const double limit = overlap_only ? 0.0 : std::max(input_.query.max_separation, 0.0);
    if (!find_core_geometry(limit + sum_ + slack_, geometry)) {
      geometry = no_geometry(kInfinity);
      return PairStatus::separated;
    }
    const PairStatus status = decide(geometry.separation);
    if (overlap_only) return status;
    grow_by_radii(a_.radius, b_.radius, geometry);
    geometry.point_count = 0;
    if (status == PairStatus::separated)
      geometry.separation = std::max(geometry.separation, std::numeric_limits<double>::denorm_min());
    else
      geometry.separation = std::min(geometry.separation, 0.0);
    if (geometry.separation > limit) {
      geometry = no_geometry(kInfinity);
      return status;
    }
    if (points != nullptr) write_points(geometry, points);
    return status;
  }

 private:
  const Pose& X_WA() const { return input_.poses[pair_.a]; }
  const Pose& X_WB() const { return input_.poses[pair_.b]; }

  /// False where the cores are further apart than `limit`.
  bool find_core_geometry(double limit, PairGeometry& out) {
    if (a_.is_point && b_.is_point) return find_point_geometry(out);
    const bool boxes = set_.kinds[pair_.a] == SolidKind::box && set_.kinds[pair_.b] == SolidKind::box;
    if (!boxes && (a_.is_flat || b_.is_flat)) return find_placed_geometry(limit, out);
    NarrowphaseInput input{{&pair_, 1}, input_.poses, {QueryKind::distance, limit}};
    PairStatus status;
    compute_geometry(set_, kernels_, input, {&status, 1}, {&out, 1}, {});
    return out.separation < kInfinity;
  }

  bool find_point_geometry(PairGeometry& out) const {
    out.separation = distance_between(X_WA().p, X_WB().p, out.n_AB_W);
    out.p_A_W = X_WA().p, out.p_B_W = X_WB().p;
    return true;
  }

  /// A flat box beside a solid that is no box: its faces are no parallelepiped's.
  bool find_placed_geometry(double limit, PairGeometry& out) const {
    const bool swapped = !comes_first(set_, pair_, X_WA(), X_WB());
    const SolidPair pair = swapped ? SolidPair{pair_.b, pair_.a} : pair_;
    const Pose &X_WA = input_.poses[pair.a], &X_WB = input_.poses[pair.b];
    PlacedPair placed;
    place(set_, pair, X_WA, X_WB, is_ordinary(set_, pair.a, X_WA, pair.b, X_WB), placed);
    SignedDistance distance;
    if (hulls_meet(kernels_, placed))
      penetration(placed.pair, distance);
    else if (!separated_distance(placed.pair, placed.from_world(limit), distance))
      return false;
    out.separation = placed.to_world(distance.separation);
    const Vector3 p_A = placed.to_world(distance.p_A);
    const Vector3 p_B = p_A + out.separation * distance.n;
    out.n_AB_W = swapped ? Vector3(-distance.n) : distance.n;
    out.p_A_W = swapped ? p_B : p_A, out.p_B_W = swapped ? p_A : p_B;
    return true;
  }

  PairStatus decide(double core_separation) const {
    if (core_separation > sum_ + slack_) return PairStatus::separated;
    if (core_separation < sum_ - slack_) return PairStatus::overlapping;
    WorldVertices a_W, b_W;
    find_world_vertices(a_W, b_W);
    return numerics::rounded_hulls_intersect(a_W, a_.radius, b_W, b_.radius) ? PairStatus::overlapping
                                                                             : PairStatus::separated;
  }

  void find_world_vertices(WorldVertices& a_W, WorldVertices& b_W) const {
    native::world_vertices(local_vertices(set_, pair_.a), X_WA(), a_W);
    native::world_vertices(local_vertices(set_, pair_.b), X_WB(), b_W);
  }

  void write_points(PairGeometry& geometry, ContactPoint* points) const {
    WorldVertices a_W, b_W;
    find_world_vertices(a_W, b_W);
    const auto slots = static_cast<std::size_t>(std::clamp(input_.query.max_points, 1, kMaxManifoldPoints));
    geometry.point_count =
        find_rounded_points({a_W, a_.radius}, {b_W, b_.radius}, geometry, input_.query, {points, slots});
  }

  const SolidSet& set_;
  const Kernels& kernels_;
  const NarrowphaseInput& input_;
  SolidPair pair_;
  Solid a_, b_;
  double sum_, slack_;
};

bool is_rounded(const SolidSet& set, const SolidPair& pair) {
  return set.radii[pair.a] > 0.0 || set.radii[pair.b] > 0.0;
}

/// Whether cores are asked in lanes, with pairs without a radius, for whether they meet: of two boxes,
/// neither of them flat.
bool has_solid_box_cores(const SolidSet& set, const SolidPair& pair) {
  return set.kinds[pair.a] == SolidKind::box && set.kinds[pair.b] == SolidKind::box &&
         !solid_of(set, pair.a).is_flat && !solid_of(set, pair.b).is_flat;
}

template <class Slot>
std::span<Slot> part(std::span<Slot> slots, std::size_t first, std::size_t count) {
  return slots.empty() ? slots : slots.subspan(first, count);
}

/// Pairs side by side in the batch: without a radius, or by their cores.
void evaluate_run(const SolidSet& set, const Kernels& kernels, const NarrowphaseInput& input,
                  const NarrowphaseOutput& output, std::size_t first, std::size_t count) {
  const auto slots = static_cast<std::size_t>(std::clamp(input.query.max_points, 1, kMaxManifoldPoints));
  NarrowphaseInput run = input;
  run.pairs = part(input.pairs, first, count), run.cache = part(input.cache, first, count);
  const bool wants_points = input.query.kind == QueryKind::manifold;
  evaluate(set, kernels, run,
           {part(output.status, first, count), part(output.geometry, first, count),
            wants_points ? part(output.points, first * slots, count * slots) : output.points});
}

}  // namespace

void evaluate_rounded(const SolidSet& set, const Kernels& kernels, const NarrowphaseInput& input,
                      const NarrowphaseOutput& output) {
  const auto slots = static_cast<std::size_t>(std::clamp(input.query.max_points, 1, kMaxManifoldPoints));
  const bool overlap_only = input.query.kind == QueryKind::overlap;
  const auto is_in_run = [&](const SolidPair& pair) {
    return !is_rounded(set, pair) || (overlap_only && has_solid_box_cores(set, pair));
  };
  for (std::size_t i = 0; i < input.pairs.size();) {
    // Those that go in lanes; boxes whose cores are apart may meet by their radii.
    std::size_t end = i;
    bool has_rounded = false;
    for (; end < input.pairs.size() && is_in_run(input.pairs[end]); ++end)
      has_rounded = has_rounded || (overlap_only && is_rounded(set, input.pairs[end]));
    if (end > i) evaluate_run(set, kernels, input, output, i, end - i);
    for (std::size_t k = has_rounded ? i : end; k < end; ++k)
      if (output.status[k] == PairStatus::separated && is_rounded(set, input.pairs[k]))
        output.status[k] = RoundedPair(set, kernels, input.pairs[k], input).run_apart();
    if (end == input.pairs.size()) return;
    // All others one by one.
    i = end + 1;
    const SolidPair& pair = input.pairs[end];
    PairGeometry unused;
    PairGeometry& geometry = overlap_only ? unused : output.geometry[end];
    if (!has_finite_poses(pair, input.poses)) {
      geometry = no_geometry();
      output.status[end] = PairStatus::failed;
      continue;
    }
    ContactPoint* const points =
        input.query.kind == QueryKind::manifold ? output.points.data() + end * slots : nullptr;
    output.status[end] = RoundedPair(set, kernels, pair, input).run(geometry, points);
  }
}

}  // namespace touchstone::native
