#include "touchstone/contact_core/native/engine/measure.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "touchstone/contact_core/narrowphase/no_geometry.hpp"
#include "touchstone/contact_core/native/distance/apart_pass.hpp"
#include "touchstone/contact_core/native/distance/distance.hpp"
#include "touchstone/contact_core/native/distance/pair_depth.hpp"
#include "touchstone/contact_core/native/manifold/clip_batch.hpp"
#include "touchstone/contact_core/native/overlap/aligned_hulls.hpp"
#include "touchstone/contact_core/native/overlap/overlap.hpp"
#include "touchstone/contact_core/native/solids/pair_batch.hpp"

namespace touchstone::native {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

const PoseRecord* records_of(std::span<const Pose> poses) {
  return reinterpret_cast<const PoseRecord*>(poses.data());  // the layout is asserted in overlap.cpp
}

/// How far a search may end below its own hulls' distance, of the extent and of the largest world coordinate:
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
  if (record.known == DepthKnown::nothing) return penetration(placed.pair, distance);
  distance.separation = about_origin ? record.separation : placed.from_world(record.separation);
  distance.n = vector_of(record.n);
  const Vector3 p_A = vector_of(record.p_A);
  if (record.known == DepthKnown::witness)
    distance.p_A = about_origin ? p_A : placed.from_world(p_A);
  else
    penetration_along(placed.pair, distance);
}

/// Distance, normal and p_A of a pair that is apart. False when it is further apart than `limit`.
bool finish_distance(const ApartRecord& record, const Pose& X_WA, double limit, const PlacedPair& placed,
                     SignedDistance& distance) {
  if (!is_valid_if_apart(record)) return distance_apart(placed.pair, limit, distance);
  distance = {placed.from_world(record.separation), vector_of(record.n),
              placed.from_world(Vector3(X_WA.p + vector_of(record.from_A)))};
  return true;
}

bool is_complete(const DepthRecord& record) {
  return record.certified == Certified::overlapping && record.known == DepthKnown::witness;
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

/// One pair on its way through the stages, the cheapest first. A stage returns the pair's status where it
/// settles the pair, and leaves what it found to the next one where it does not.
class PairEvaluation {
 public:
  PairEvaluation(const SolidSet& set, const Kernels& kernels, const NarrowphaseInput& input,
                 const OrderedPair& given, const DepthRecord& depth, const ApartRecord& apart)
      : set_(set), kernels_(kernels), input_(input), given_(given), depth_(depth), apart_(apart) {}

  PairStatus run(PairGeometry& geometry, ContactPoint* points, ClipBatch& clips) {
    if (const auto status = take_records(geometry, points)) return *status;
    kind_ = kind_of(set_, given_.pair);
    if (const auto status = certify_alone(geometry)) return *status;
    if (const auto status = write_depth(geometry, points)) return *status;
    if (const auto status = find_distance(geometry, points)) return *status;
    if (const auto status = clip_in_lanes(geometry, points, clips)) return *status;
    if (const auto status = measure_hulls(geometry, points)) return *status;
    return finish(geometry, points, clips);
  }

 private:
  using Settled = std::optional<PairStatus>;

  const Pose& X_WA() const { return input_.poses[given_.pair.a]; }
  const Pose& X_WB() const { return input_.poses[given_.pair.b]; }
  bool is_general() const { return kind_ == SolidKind::general; }
  bool has_distance() const { return apart_.state == ApartState::found; }

  void place_pair() {
    place(set_.solids[given_.pair.a], X_WA(), set_.solids[given_.pair.b], X_WB(), is_ordinary_, placed_);
    is_placed_ = true;
  }

  /// Whether the pair is certainly apart, and no more than that is asked for.
  bool is_beyond(PairGeometry& geometry) const {
    if (!is_out_of_reach(depth_, input_.query)) return false;
    write_beyond(geometry);
    return true;
  }

  /// Writes a distance that is found. True where nothing else is asked for.
  bool write_distance(PairGeometry& geometry, const ContactPoint* points) const {
    if (!has_distance()) return false;
    write_apart(given_, apart_, input_, geometry);
    return points == nullptr || apart_.separation > input_.query.max_separation;
  }

  /// The records of the batch's kernels settle a pair that is apart and has no manifold.
  Settled take_records(PairGeometry& geometry, const ContactPoint* points) const {
    if (is_beyond(geometry) || write_distance(geometry, points)) return PairStatus::separated;
    return std::nullopt;
  }

  /// Filters of single pairs: kernels on a scaled copy, comparison of coordinates.
  Settled certify_alone(PairGeometry& geometry) {
    has_depth_ = is_complete(depth_);
    if (has_depth_ || has_distance()) return std::nullopt;
    is_ordinary_ = is_ordinary(set_, given_.pair.a, X_WA(), given_.pair.b, X_WB());
    // Magnitudes that kernels do not take: the same pair scaled by a power of two.
    if (!is_ordinary_) depth_ = scaled_pair_depth(set_, kernels_, given_.pair, input_.poses);
    // Boxes along the world's axes that lie flush: no margin decides, comparison does.
    if (is_ordinary_ && !is_general() && depth_.certified == Certified::unknown) {
      place_pair();
      certified_ = certify_aligned(placed_.a_W, placed_.b_W);
      if (certified_ == Certified::overlapping) depth_.certified = certified_;
      if (certified_ == Certified::separated && !reaches_apart(input_.query)) {
        write_beyond(geometry);
        return PairStatus::separated;
      }
    }
    has_depth_ = is_complete(depth_);
    return std::nullopt;
  }

  Settled write_depth(PairGeometry& geometry, const ContactPoint* points) const {
    if (!has_depth_) return std::nullopt;
    write(given_, depth_.separation, vector_of(depth_.n), vector_of(depth_.p_A), geometry);
    return points == nullptr ? Settled(PairStatus::overlapping) : std::nullopt;
  }

  /// Distance of boxes and parallelepipeds, by the kernels that are left to try.
  Settled find_distance(PairGeometry& geometry, const ContactPoint* points) {
    if (is_general()) return std::nullopt;
    return try_distance(geometry, points) ? Settled(PairStatus::separated) : std::nullopt;
  }

  bool try_distance(PairGeometry& geometry, const ContactPoint* points) {
    if (has_distance() || depth_.certified == Certified::overlapping) return false;
    finish_apart(set_, kernels_, given_.pair, input_.poses, depth_.certified == Certified::separated, apart_);
    return write_distance(geometry, points);
  }

  /// Manifolds of boxes and parallelepipeds whose geometry is written: several at a time.
  Settled clip_in_lanes(PairGeometry& geometry, ContactPoint* points, ClipBatch& clips) const {
    if (!(has_depth_ || has_distance()) || is_general() || !is_ordinary_) return std::nullopt;
    clips.add(given_, kind_, geometry, points);
    return has_distance() ? PairStatus::separated : PairStatus::overlapping;
  }

  /// Depth, then distance, of general hexahedra.
  Settled measure_hulls(PairGeometry& geometry, const ContactPoint* points) {
    if (!is_placed_) place_pair();
    if (!is_general() || has_distance()) return std::nullopt;
    depth_ = hull_depth(set_, kernels_, given_.pair, placed_);
    if (!is_ordinary_) depth_.certified = Certified::unknown;
    if (is_beyond(geometry) || try_distance(geometry, points)) return PairStatus::separated;
    return std::nullopt;
  }

  /// Exact where no filter has certified the pair.
  bool do_meet() const {
    if (has_distance()) return false;
    const Certified certified = certified_ == Certified::unknown ? depth_.certified : certified_;
    return certified == Certified::unknown ? hulls_meet(placed_) : certified == Certified::overlapping;
  }

  /// Distance or depth by search in doubles where the kernels have none, then the manifold.
  PairStatus finish(PairGeometry& geometry, ContactPoint* points, ClipBatch& clips) const {
    const bool meet = do_meet();
    const PairStatus status = meet ? PairStatus::overlapping : PairStatus::separated;
    SignedDistance distance;
    if (meet) {
      finish_depth(depth_, is_general(), placed_, distance);
    } else if (!finish_distance(apart_, X_WA(), search_limit(), placed_, distance)) {
      write_beyond(geometry);
      return status;
    }

    // The world's figures decide whether the pair is within reach.
    if (!has_depth_ && !has_distance()) {
      double separation = placed_.to_world(distance.separation);
      if (!meet) separation = std::max(separation, std::numeric_limits<double>::denorm_min());
      write(given_, separation, distance.n, placed_.to_world(distance.p_A), geometry);
    }
    if (geometry.separation > input_.query.max_separation) {
      write_beyond(geometry);
      return status;
    }

    if (points == nullptr) return status;
    if (!is_general() && is_ordinary_)
      clips.add(given_, kind_, geometry, points);
    else
      write_manifold(placed_, distance, given_.swapped, input_.query, geometry, points);
    return status;
  }

  /// The search's rounding must not withhold a pair that is just within: the world's figures decide later.
  double search_limit() const {
    const double coordinate = std::max(largest_coordinate(placed_.a_W), largest_coordinate(placed_.b_W));
    return placed_.from_world(input_.query.max_separation) +
           (kSearchSlack * placed_.pair.hulls.extent + placed_.from_world(kPositionSlack * coordinate));
  }

  const SolidSet& set_;
  const Kernels& kernels_;
  const NarrowphaseInput& input_;
  const OrderedPair& given_;
  DepthRecord depth_;
  ApartRecord apart_;
  SolidKind kind_ = SolidKind::general;
  Certified certified_ = Certified::unknown;  ///< by comparison of coordinates
  bool has_depth_ = false;                    ///< the record of the depth is complete, and overlapping
  bool is_ordinary_ = true;
  bool is_placed_ = false;
  PlacedPair placed_;
};

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
    status[i] = PairEvaluation(set, kernels, input, pairs[i], depth, apart)
                    .run(geometry[i], points ? points + i * slots : nullptr, clips);
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
    if (i + 1 < others.count && (points || records.apart[i + 1].state != ApartState::found))
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
  return PairEvaluation(set, kernels, input, pair, record, apart).run(geometry, points, clips);
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
