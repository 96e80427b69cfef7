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
SignedDistance distance_of(const PairGeometry& geometry, const ClipTask& task) {
  const Vector3* const p[2] = {&geometry.p_A_W, &geometry.p_B_W};
  const double* const n = task.n_separation;
  return {geometry.separation, {n[0], n[1], n[2]}, *p[task.swapped]};
}

int most_points(const NarrowphaseInput& input) {
  return std::clamp(input.query.max_points, 1, kMaxManifoldPoints);
}

/// All but the place of its points.
void set_task(const OrderedPair& pair, const PairGeometry& geometry, ClipTask& task) {
  for (int k = 0; k < 3; ++k) task.n_separation[k] = pair.sign() * geometry.n_AB_W(k);
  task.n_separation[3] = geometry.separation;
  task.pair = {pair.pair.a, pair.pair.b};
  task.swapped = pair.swapped;
}

void clip(const SolidSet& set, const Kernels& kernels, const NarrowphaseInput& input, SolidKind kind,
          std::span<const ClipTask> tasks, ClipRecord* out) {
  const auto* const X_W = records_of(input.poses);
  const double limit = input.query.max_point_separation;
  if (kind == SolidKind::box)
    kernels.clip_boxes(X_W, set.boxes.data(), tasks.data(), tasks.size(), limit, out);
  else
    kernels.clip_parallelepipeds(X_W, set.parallelepiped_edges.data(), tasks.data(), tasks.size(), limit,
                                 out);
}

/// @param corners where the kernel wrote the task's
void finish_task(const SolidSet& set, const Kernels& kernels, const NarrowphaseInput& input,
                 const ClipTask& task, const ClipRecord& clipped, ContactPoint* corners,
                 PairGeometry& geometry, ContactPoint* points) {
  SignedDistance distance = distance_of(geometry, task);
  if (!clipped.fits) {
    PlacedPair placed;
    place(set, {task.pair.a, task.pair.b}, input.poses[task.pair.a], input.poses[task.pair.b], true, placed);
    distance.p_A = placed.from_world(distance.p_A);
    write_manifold(kernels, placed, distance, task.swapped, input.query, geometry, points);
    return;
  }
  geometry.point_count = finish_clip(distance, task.swapped, clipped, most_points(input), corners);
  if (corners != points) std::copy(corners, corners + geometry.point_count, points);
}

/// Quadrangles by the kernel of one pair. False where it does not take them.
bool make_manifold_in_lanes(const Kernels& kernels, const PosedPair& pair, const SignedDistance& distance,
                            double max_point_separation, int max_points, bool swapped, Manifold& manifold) {
  const QuadFaces &a = pair.a->quads, &b = pair.b->quads;
  if (!a.are_quads || !b.are_quads) return false;
  const Vector3& n = distance.n;
  const double n_separation[4] = {n.x(), n.y(), n.z(), distance.separation};
  HullClipRecord clipped;
  kernels.clip_hull_pair({&a, pair.hulls.a.x.data(), pair.R_WA.data()},
                         {&b, pair.hulls.b.x.data(), pair.R_WB.data()}, n_separation, pair.hulls.extent,
                         max_point_separation, &clipped);
  if ((clipped.bits >> HullClipBits::kFits & 1u) == 0) return false;
  finish_hull_clip(clipped, distance, max_point_separation, max_points, swapped, manifold);
  return true;
}

}  // namespace

void write_manifold(const Kernels& kernels, const PlacedPair& placed, const SignedDistance& distance,
                    bool swapped, const Query& query, PairGeometry& geometry, ContactPoint* points) {
  Manifold manifold;
  const double limit = placed.from_world(query.max_point_separation);
  const int most = std::clamp(query.max_points, 1, kMaxManifoldPoints);
  if (!make_manifold_in_lanes(kernels, placed.pair, distance, limit, most, swapped, manifold))
    make_manifold(placed.pair, distance, limit, most, swapped, manifold);
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

void clip_pair(const SolidSet& set, const Kernels& kernels, const NarrowphaseInput& input,
               const OrderedPair& pair, SolidKind kind, PairGeometry& geometry, ContactPoint* points) {
  std::array<ContactPoint, kCorners> scratch;
  ContactPoint* const corners = most_points(input) == static_cast<int>(kCorners) ? points : scratch.data();
  ClipTask task;
  set_task(pair, geometry, task);
  task.points = reinterpret_cast<PointRecord*>(corners);
  ClipRecord clipped;
  clip(set, kernels, input, kind, {&task, 1}, &clipped);
  finish_task(set, kernels, input, task, clipped, corners, geometry, points);
}

ClipBatch::ClipBatch(const SolidSet& set, const Kernels& kernels, const NarrowphaseInput& input)
    : set_(set), kernels_(kernels), input_(input), max_points_(most_points(input)) {}

void ClipBatch::add(const OrderedPair& pair, SolidKind kind, PairGeometry& geometry, ContactPoint* points) {
  if (count_ == kMost || kind != kind_) run();
  kind_ = kind;
  set_task(pair, geometry, tasks_[count_]);
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
  clip(set_, kernels_, input_, kind_, std::span(tasks_).first(count_), clipped.data());
  for (std::size_t i = 0; i < count_; ++i)
    finish_task(set_, kernels_, input_, tasks_[i], clipped[i], corners_of(i), *geometry_[i], points_[i]);
  count_ = 0;
}

HullClipBatch::HullClipBatch(const SolidSet& set, const Kernels& kernels, const NarrowphaseInput& input)
    : set_(set), kernels_(kernels), input_(input) {}

bool HullClipBatch::takes(const SolidPair& pair) const {
  return set_.solids[pair.a].plain != nullptr && set_.solids[pair.b].plain != nullptr;
}

void HullClipBatch::add(const OrderedPair& pair, const SignedDistance& distance, bool about_origin,
                        PairGeometry& geometry, ContactPoint* points) {
  if (count_ == kMost) run();
  HullClipTask& task = tasks_[count_];
  for (int k = 0; k < 3; ++k) task.n_separation[k] = distance.n(k);
  task.n_separation[3] = distance.separation;
  task.pair = {pair.pair.a, pair.pair.b};
  task.a = set_.solids[pair.pair.a].plain, task.b = set_.solids[pair.pair.b].plain;
  pairs_[count_++] = {distance.p_A, about_origin, pair.swapped, &geometry, points};
}

void HullClipBatch::run() {
  if (count_ == 0) return;
  std::array<HullClipRecord, kMost> clipped;
  kernels_.clip_hulls(records_of(input_.poses), vertex_records(set_), tasks_.data(), count_,
                      input_.query.max_point_separation, clipped.data());
  for (std::size_t i = 0; i < count_; ++i) write(i, clipped[i]);
  count_ = 0;
}

void HullClipBatch::write(std::size_t i, const HullClipRecord& clipped) const {
  const HullClipTask& task = tasks_[i];
  const Pair& pair = pairs_[i];
  const double* const n = task.n_separation;
  SignedDistance distance{n[3], {n[0], n[1], n[2]}, pair.p_A};
  // A pair that does not fit goes alone.
  if ((clipped.bits >> HullClipBits::kFits & 1u) == 0) {
    PlacedPair placed;
    place(set_, {task.pair.a, task.pair.b}, input_.poses[task.pair.a], input_.poses[task.pair.b], true,
          placed);
    if (!pair.about_origin) distance.p_A = placed.from_world(distance.p_A);
    write_manifold(kernels_, placed, distance, pair.swapped, input_.query, *pair.geometry, pair.points);
    return;
  }
  // The others' points are about A's first vertex.
  const Vector3 origin = vector_of(clipped.origin);
  if (!pair.about_origin) distance.p_A = distance.p_A - origin;
  Manifold manifold;
  finish_hull_clip(clipped, distance, input_.query.max_point_separation, most_points(input_), pair.swapped,
                   manifold);
  pair.geometry->point_count = manifold.count;
  for (int k = 0; k < manifold.count; ++k) {
    const ContactPoint& from = manifold.points[k];
    const std::array<const Vector3*, 2> p = {&from.p_A_W, &from.p_B_W};
    ContactPoint& to = pair.points[k];
    to.p_A_W = origin + *p[pair.swapped], to.p_B_W = origin + *p[!pair.swapped];
    to.separation = from.separation, to.feature_id = from.feature_id;
  }
}

}  // namespace touchstone::native
