#include "touchstone/contact_core/native/measure.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "touchstone/contact_core/narrowphase/no_geometry.hpp"
#include "touchstone/contact_core/native/aligned_hulls.hpp"
#include "touchstone/contact_core/native/apart_pass.hpp"
#include "touchstone/contact_core/native/clip_batch.hpp"
#include "touchstone/contact_core/native/overlap.hpp"
#include "touchstone/contact_core/native/pair_batch.hpp"
#include "touchstone/contact_core/native/pair_depth.hpp"

namespace touchstone::native {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

const PoseRecord* records_of(std::span<const Pose> poses) {
  return reinterpret_cast<const PoseRecord*>(poses.data());  // the layout is asserted in overlap.cpp
}

/// What a search may end below its own hulls' distance, of the extent and of the largest world coordinate:
/// the directions it falls back on are the posed solids', whose hulls those of the rounded vertices leave by
/// 4 u of the coordinate at most (hull_kernels.hpp), there and back.
constexpr double kSearchSlack = 0x1p-40;
constexpr double kPositionSlack = 8 * kRoundoff;

PairStatus fail(PairGeometry& out) {
  out = no_geometry();
  return PairStatus::failed;
}

void write_beyond(PairGeometry& out) {
  out.separation = kInfinity;
  out.n_AB_W = out.p_A_W = out.p_B_W = Vector3::Constant(kNaN);
  out.point_count = 0;
}

OrderedPair ordered(const SolidSet& set, const SolidPair& pair, std::span<const Pose> poses) {
  const Pose& X_WA = poses[pair.a];
  const Pose& X_WB = poses[pair.b];
  const double a = X_WA.p.x(), b = X_WB.p.x();
  const bool swapped = a == b ? !comes_first(set.solids[pair.a], X_WA, set.solids[pair.b], X_WB) : a > b;
  return {{swapped ? pair.b : pair.a, swapped ? pair.a : pair.b}, swapped};
}

void write(const OrderedPair& ordered, double separation, const Vector3& n, const Vector3& p_A,
           PairGeometry& geometry) {
  const Vector3 p_B = p_A + separation * n;
  geometry.separation = separation;
  geometry.n_AB_W = ordered.swapped ? Vector3(-n) : n;
  geometry.p_A_W = ordered.swapped ? p_B : p_A;
  geometry.p_B_W = ordered.swapped ? p_A : p_B;
  geometry.point_count = 0;
}

Vector3 vector_of(const double (&p)[3]) { return {p[0], p[1], p[2]}; }

/// Depth, normal and p_A of a pair that overlaps. @param about_origin whether the record's lengths and points
/// are the placed pair's own, not the world's.
void finish_depth(const DepthRecord& record, bool about_origin, const PlacedPair& placed,
                  SignedDistance& distance) {
  if (!record.has_axis) return penetration(placed.pair, distance);
  distance.separation = about_origin ? record.separation : placed.from_world(record.separation);
  distance.n = vector_of(record.n);
  const Vector3 p_A = vector_of(record.p_A);
  if (record.has_witness)
    distance.p_A = about_origin ? p_A : placed.from_world(p_A);
  else
    penetration_along(placed.pair, distance);
}

/// Distance, normal and p_A of a pair that is apart. False when it is further apart than `limit`.
bool finish_distance(const ApartRecord& record, const Pose& X_WA, double limit, const PlacedPair& placed,
                     SignedDistance& distance) {
  if (!record.fits) return distance_apart(placed.pair, limit, distance);
  distance = {placed.from_world(record.separation), vector_of(record.n),
              placed.from_world(Vector3(X_WA.p + vector_of(record.from_A)))};
  return true;
}

bool is_complete(const DepthRecord& record) {
  return record.certified == Certified::overlapping && record.has_axis && record.has_witness;
}

/// Geometry of a pair that is certainly apart.
void write_apart(const OrderedPair& pair, const ApartRecord& apart, const NarrowphaseInput& input,
                 PairGeometry& geometry) {
  if (apart.separation > input.query.max_separation) return write_beyond(geometry);
  const Vector3 p_A = input.poses[pair.pair.a].p + vector_of(apart.from_A);
  write(pair, apart.separation, vector_of(apart.n), p_A, geometry);
}

/// Whether more than the status of a pair that is apart is asked for.
bool reaches_apart(const Query& query) { return query.max_separation > 0.0; }

bool is_out_of_reach(const DepthRecord& record, const Query& query) {
  return record.certified == Certified::separated && !reaches_apart(query);
}

PairStatus measure_one(const SolidSet& set, const Kernels& kernels, const OrderedPair& given,
                       const DepthRecord& given_depth, const ApartRecord& given_apart,
                       const NarrowphaseInput& input, PairGeometry& geometry, ContactPoint* points,
                       ClipBatch& clips) {
  DepthRecord record = given_depth;
  ApartRecord apart = given_apart;
  const SolidPair& pair = given.pair;
  const double max_separation = input.query.max_separation;
  const Pose& X_WA = input.poses[pair.a];
  const Pose& X_WB = input.poses[pair.b];
  const auto out_of_reach = [&] {
    if (!is_out_of_reach(record, input.query)) return false;
    write_beyond(geometry);
    return true;
  };
  const auto is_done = [&] {
    if (!apart.found) return false;
    write_apart(given, apart, input, geometry);
    return points == nullptr || apart.separation > max_separation;
  };
  const auto try_apart = [&] {
    if (apart.found || record.certified == Certified::overlapping) return false;
    finish_apart(set, kernels, pair, input.poses, record.certified == Certified::separated, apart);
    return is_done();
  };
  if (out_of_reach() || is_done()) return PairStatus::separated;
  const SolidKind kind = kind_of(set, pair);
  const bool general = kind == SolidKind::general;
  bool known = is_complete(record);
  bool ordinary = true, is_placed = false;
  PlacedPair placed;
  Certified certified = Certified::unknown;
  if (!known && !apart.found) {
    ordinary = is_ordinary(set, pair.a, X_WA, pair.b, X_WB);
    if (!ordinary) record = scaled_pair_depth(set, kernels, pair, input.poses);
    if (ordinary && !general && record.certified == Certified::unknown) {
      place(set.solids[pair.a], X_WA, set.solids[pair.b], X_WB, ordinary, placed);
      is_placed = true;
      certified = certify_aligned(placed.a_W, placed.b_W);
      if (certified == Certified::overlapping) record.certified = certified;
      if (certified == Certified::separated && !reaches_apart(input.query)) {
        write_beyond(geometry);
        return PairStatus::separated;
      }
    }
    known = is_complete(record);
  }
  if (known) {
    write(given, record.separation, vector_of(record.n), vector_of(record.p_A), geometry);
    if (points == nullptr) return PairStatus::overlapping;
  }
  if (!general && try_apart()) return PairStatus::separated;
  if ((known || apart.found) && !general && ordinary) {
    clips.add(given, kind, geometry, points);
    return apart.found ? PairStatus::separated : PairStatus::overlapping;
  }
  if (!is_placed) place(set.solids[pair.a], X_WA, set.solids[pair.b], X_WB, ordinary, placed);
  if (general && !apart.found) {
    record = hull_depth(set, kernels, pair, placed);
    if (!ordinary) record.certified = Certified::unknown;
    if (out_of_reach() || try_apart()) return PairStatus::separated;
  }
  known = known || apart.found;
  if (apart.found)
    certified = Certified::separated;
  else if (certified == Certified::unknown)
    certified = record.certified;
  if (certified == Certified::unknown)
    certified = hulls_meet(placed) ? Certified::overlapping : Certified::separated;
  const bool meet = certified == Certified::overlapping;
  const PairStatus status = meet ? PairStatus::overlapping : PairStatus::separated;

  const double limit = placed.from_world(max_separation);
  // What the search rounds must not withhold a pair that is just within: the world's figures decide below.
  const double coordinate = std::max(largest_coordinate(placed.a_W), largest_coordinate(placed.b_W));
  const double search_limit =
      limit + (kSearchSlack * placed.pair.hulls.extent + placed.from_world(kPositionSlack * coordinate));
  SignedDistance distance;
  if (meet) {
    finish_depth(record, general, placed, distance);
  } else if (!finish_distance(apart, X_WA, search_limit, placed, distance)) {
    write_beyond(geometry);
    return status;
  }

  if (!known) {
    double separation = placed.to_world(distance.separation);
    if (!meet) separation = std::max(separation, std::numeric_limits<double>::denorm_min());
    write(given, separation, distance.n, placed.to_world(distance.p_A), geometry);
  }
  if (geometry.separation > max_separation) {
    write_beyond(geometry);
    return status;
  }
  if (points == nullptr) return status;

  if (!general && ordinary)
    clips.add(given, kind, geometry, points);
  else
    write_manifold(placed, distance, given.swapped, input.query, geometry, points);
  return status;
}

void prefetch_general(const SolidSet& set, const SolidPair& pair) {
  if (kind_of(set, pair) != SolidKind::general) return;
  prefetch_hull(set.solids[pair.a]), prefetch_hull(set.solids[pair.b]);
}

/// Fetches the poses of a pair some iterations ahead: where they lie no prefetcher can guess.
void prefetch_poses(const SolidPair& pair, std::span<const Pose> poses) {
  for (const SolidIndex i : {pair.a, pair.b}) {
    __builtin_prefetch(&poses[i].R);
    __builtin_prefetch(&poses[i].p.z());
  }
}

struct Records {
  std::array<DepthRecord, kBlock> depth;
  std::array<ApartRecord, kBlock> apart;
};

/// Depths of one kind's pairs, then the distances of those that this did not certify to overlap.
void run_kernels(const SolidSet& set, const Kernels& kernels, SolidKind kind, std::span<const Pose> poses,
                 const Query& query, const Batch& batch, Records& records) {
  const PoseRecord* X_W = records_of(poses);
  if (kind == SolidKind::box)
    kernels.measure_box_depths(X_W, set.boxes.data(), batch.pairs.data(), batch.count, records.depth.data());
  else
    kernels.measure_form_depths(X_W, set.edge_forms.data(), batch.pairs.data(), batch.count,
                                records.depth.data());
  measure_batch_apart(set, kernels, kind, poses, batch, records.depth.data(), reaches_apart(query),
                      records.apart.data());
}

struct Batches {
  Batch boxes, forms, others;
};

void sort_by_kind(const SolidSet& set, std::span<const Pose> poses, std::span<const OrderedPair> pairs,
                  Batches& out) {
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const SolidPair& pair = pairs[i].pair;
    switch (kind_of(set, pair)) {
      case SolidKind::box:
        prefetch_pair(set.boxes, poses, pair);
        out.boxes.add(pair, i);
        break;
      case SolidKind::parallelepiped:
        prefetch_pair(set.edge_forms, poses, pair);
        out.forms.add(pair, i);
        break;
      case SolidKind::general:
        prefetch_pair(set.vertices, poses, pair);
        out.others.add(pair, i);
        break;
    }
  }
}

/// At most kBlock pairs.
void measure_block(const SolidSet& set, const Kernels& kernels, const NarrowphaseInput& input,
                   std::span<PairStatus> status, std::span<PairGeometry> geometry, ContactPoint* points,
                   std::size_t slots) {
  std::array<OrderedPair, kBlock> pairs;
  ClipBatch clips(set, kernels, input);
  const auto finish = [&](std::size_t i, const DepthRecord& depth, const ApartRecord& apart) {
    if (!has_finite_poses(pairs[i].pair, input.poses)) {
      status[i] = fail(geometry[i]);
      return;
    }
    status[i] = measure_one(set, kernels, pairs[i], depth, apart, input, geometry[i],
                            points ? points + i * slots : nullptr, clips);
  };
  const std::size_t count = input.pairs.size();
  constexpr std::size_t kAhead = 12;
  for (std::size_t i = 0; i < count; ++i) {
    if (i + kAhead < count) prefetch_poses(input.pairs[i + kAhead], input.poses);
    pairs[i] = ordered(set, input.pairs[i], input.poses);
  }
  Batches batches;
  sort_by_kind(set, input.poses, std::span(pairs).first(count), batches);
  Records records;
  for (const auto& [kind, batch] : {std::pair<SolidKind, const Batch&>{SolidKind::box, batches.boxes},
                                    {SolidKind::parallelepiped, batches.forms}}) {
    if (batch.count == 0) continue;
    run_kernels(set, kernels, kind, input.poses, input.query, batch, records);
    for (std::size_t i = 0; i < batch.count; ++i) finish(batch.slots[i], records.depth[i], records.apart[i]);
  }
  const Batch& others = batches.others;
  if (others.count == 0) return;
  std::fill_n(records.apart.data(), others.count, kNoDistance);
  if (reaches_apart(input.query))
    measure_hulls_apart(set, kernels, input.poses, std::span(others.pairs).first(others.count),
                        records.apart.data());
  for (std::size_t i = 0; i < others.count; ++i) {
    if (i + 1 < others.count && (points || !records.apart[i + 1].found))
      prefetch_general(set, {others.pairs[i + 1].a, others.pairs[i + 1].b});
    finish(others.slots[i], kNothingKnown, records.apart[i]);
  }
}

/// pair_depth(), but for boxes that a quicker kernel certifies to be apart no more than that; pair_depth()
/// would certify them too, by a finer margin on the same axes.
DepthRecord alone_depth(const SolidSet& set, const Kernels& kernels, const SolidPair& pair,
                        std::span<const Pose> poses) {
  if (kind_of(set, pair) == SolidKind::box) {
    const PoseRecord* X_W = records_of(poses);
    DepthRecord record = kNothingKnown;
    record.certified =
        kernels.certify_box_pair(X_W[pair.a], set.boxes[pair.a], X_W[pair.b], set.boxes[pair.b]);
    if (record.certified == Certified::separated) return record;
  }
  return pair_depth(set, kernels, pair, poses);
}

PairStatus measure_alone(const SolidSet& set, const Kernels& kernels, const NarrowphaseInput& input,
                         PairGeometry& geometry, ContactPoint* points) {
  prefetch_general(set, input.pairs[0]);
  if (!has_finite_poses(input.pairs[0], input.poses)) return fail(geometry);
  const OrderedPair pair = ordered(set, input.pairs[0], input.poses);
  const DepthRecord record = alone_depth(set, kernels, pair.pair, input.poses);
  ApartRecord apart = kNoDistance;
  if (record.certified == Certified::separated && !is_out_of_reach(record, input.query)) {
    const PairIndices indices{pair.pair.a, pair.pair.b};
    measure_apart(set, kernels, kind_of(set, pair.pair), input.poses, {&indices, 1}, &apart);
  }
  ClipBatch clips(set, kernels, input);
  return measure_one(set, kernels, pair, record, apart, input, geometry, points, clips);
}

}  // namespace

void measure(const SolidSet& set, const Kernels& kernels, const NarrowphaseInput& input,
             std::span<PairStatus> status, std::span<PairGeometry> geometry, std::span<ContactPoint> points) {
  const std::size_t slots =
      points.empty() ? 0
                     : static_cast<std::size_t>(std::clamp(input.query.max_points, 1, kMaxManifoldPoints));
  ContactPoint* const first_point = points.empty() ? nullptr : points.data();
  if (input.pairs.size() == 1) {
    status[0] = measure_alone(set, kernels, input, geometry[0], first_point);
    return;
  }
  for (std::size_t first = 0; first < input.pairs.size(); first += kBlock) {
    NarrowphaseInput block = input;
    block.pairs = input.pairs.subspan(first, std::min(kBlock, input.pairs.size() - first));
    measure_block(set, kernels, block, status.subspan(first), geometry.subspan(first),
                  first_point ? first_point + first * slots : nullptr, slots);
  }
}

}  // namespace touchstone::native
