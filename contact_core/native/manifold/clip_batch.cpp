#include "touchstone/contact_core/native/manifold/clip_batch.hpp"

#include <algorithm>
#include <cstddef>
#include <type_traits>

#include "touchstone/contact_core/native/manifold/manifold.hpp"

namespace touchstone::native {
namespace {

// The kernel writes points as they lie in memory.
static_assert(sizeof(ContactPoint) == sizeof(PointRecord) && std::is_standard_layout_v<ContactPoint>);
static_assert(offsetof(ContactPoint, p_B_W) == offsetof(PointRecord, p_B));
static_assert(offsetof(ContactPoint, separation) == offsetof(PointRecord, separation));
static_assert(offsetof(ContactPoint, feature_id) == offsetof(PointRecord, feature_id));

constexpr std::size_t kCorners = 8;

/// Of the pair in the check's order.
SignedDistance distance_of(const PairGeometry& geometry, bool swapped) {
  if (swapped) return {geometry.separation, Vector3(-geometry.n_AB_W), geometry.p_B_W};
  return {geometry.separation, geometry.n_AB_W, geometry.p_A_W};
}

}  // namespace

void write_manifold(const PlacedPair& placed, const SignedDistance& distance, bool swapped,
                    const Query& query, PairGeometry& geometry, ContactPoint* points) {
  Manifold manifold;
  make_manifold(placed.pair, distance, placed.from_world(query.max_point_separation),
                std::clamp(query.max_points, 1, kMaxManifoldPoints), swapped, manifold);
  geometry.point_count = manifold.count;
  for (int i = 0; i < manifold.count; ++i) {
    const ContactPoint& from = manifold.points[i];
    points[i].p_A_W = placed.to_world(swapped ? from.p_B_W : from.p_A_W);
    points[i].p_B_W = placed.to_world(swapped ? from.p_A_W : from.p_B_W);
    // The deepest point has the bits of the pair's separation.
    points[i].separation =
        from.separation == distance.separation ? geometry.separation : placed.to_world(from.separation);
    // A distance below rounding is the least double, for every point.
    if (geometry.separation > 0.0) points[i].separation = std::max(points[i].separation, geometry.separation);
    points[i].feature_id = from.feature_id;
  }
}

ClipBatch::ClipBatch(const SolidSet& set, const Kernels& kernels, const NarrowphaseInput& input)
    : set_(set),
      kernels_(kernels),
      input_(input),
      max_points_(std::clamp(input.query.max_points, 1, kMaxManifoldPoints)) {}

void ClipBatch::add(const OrderedPair& pair, SolidKind kind, PairGeometry& geometry, ContactPoint* points) {
  if (count_ == kMost || kind != kind_) run();
  kind_ = kind;
  ClipTask& task = tasks_[count_];
  const double sign = pair.swapped ? -1.0 : 1.0;
  for (int k = 0; k < 3; ++k) task.n_separation[k] = sign * geometry.n_AB_W(k);
  task.n_separation[3] = geometry.separation;
  task.pair = {pair.pair.a, pair.pair.b};
  task.swapped = pair.swapped;
  geometry_[count_] = &geometry;
  points_[count_++] = points;
}

void ClipBatch::run() {
  if (count_ == 0) return;
  std::array<ContactPoint, kMost * kCorners> scratch;
  const bool direct = max_points_ == static_cast<int>(kCorners);
  const auto corners_of = [&](std::size_t i) { return direct ? points_[i] : &scratch[i * kCorners]; };
  for (std::size_t i = 0; i < count_; ++i) tasks_[i].points = reinterpret_cast<PointRecord*>(corners_of(i));
  std::array<ClipRecord, kMost> clipped;
  const auto* const X_W = records_of(input_.poses);
  if (kind_ == SolidKind::box)
    kernels_.clip_boxes(X_W, set_.boxes.data(), tasks_.data(), count_, input_.query.max_point_separation,
                        clipped.data());
  else
    kernels_.clip_parallelepipeds(X_W, set_.parallelepiped_edges.data(), tasks_.data(), count_,
                                  input_.query.max_point_separation, clipped.data());
  for (std::size_t i = 0; i < count_; ++i) finish(i, clipped[i], corners_of(i));
  count_ = 0;
}

void ClipBatch::finish(std::size_t i, const ClipRecord& clipped, ContactPoint* corners) {
  const ClipTask& task = tasks_[i];
  PairGeometry& geometry = *geometry_[i];
  SignedDistance distance = distance_of(geometry, task.swapped);
  if (!clipped.fits) {
    PlacedPair placed;
    place(set_, {task.pair.a, task.pair.b}, input_.poses[task.pair.a], input_.poses[task.pair.b], true,
          placed);
    distance.p_A = placed.from_world(distance.p_A);
    write_manifold(placed, distance, task.swapped, input_.query, geometry, points_[i]);
    return;
  }
  geometry.point_count = finish_clip(distance, task.swapped, clipped, max_points_, corners);
  if (corners != points_[i]) std::copy(corners, corners + geometry.point_count, points_[i]);
}

}  // namespace touchstone::native
