#include "touchstone/contact_core/native/engine/pair_geometry.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/narrowphase/no_geometry.hpp"
#include "touchstone/contact_core/native/distance/distance.hpp"
#include "touchstone/contact_core/native/distance/kernel_distances.hpp"
#include "touchstone/contact_core/native/distance/pair_depth.hpp"
#include "touchstone/contact_core/native/manifold/clip_batch.hpp"
#include "touchstone/contact_core/native/overlap/aligned_hulls.hpp"
#include "touchstone/contact_core/native/overlap/overlap.hpp"
#include "touchstone/contact_core/native/solids/pair_batch.hpp"

namespace touchstone::native {
namespace {

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
  const bool swapped = a == b ? !comes_first(set, pair, X_WA, X_WB) : a > b;
  // Without a branch, as in write(), and through no memory: a single pair's kernel waits for it.
  const SolidIndex exchange = (pair.a ^ pair.b) & (SolidIndex{0} - SolidIndex{swapped});
  return {{pair.a ^ exchange, pair.b ^ exchange}, swapped};
}

void write(const OrderedPair& ordered, double separation, const Vector3& n, const Vector3& p_A,
           PairGeometry& geometry) {
  // Without a branch: whether a pair is swapped no predictor can guess.
  const std::array<Vector3, 2> p = {p_A, p_A + separation * n};
  geometry.separation = separation;
  geometry.n_AB_W = ordered.sign() * n;
  geometry.p_A_W = p[ordered.swapped];
  geometry.p_B_W = p[!ordered.swapped];
  geometry.point_count = 0;
}

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

/// Leaves room for the search's rounding, so that no pair just within the limit is withheld: world values
/// decide later.
double search_limit(const PlacedPair& placed, double limit) {
  const double coordinate = std::max(largest_coordinate(placed.a_W), largest_coordinate(placed.b_W));
  return placed.from_world(limit) +
         (kSearchSlack * placed.pair.hulls.extent + placed.from_world(kPositionSlack * coordinate));
}

/// Distance, normal and p_A of a separated pair. False when its distance is above `limit`.
bool finish_distance(const DistanceRecord& record, const Pose& X_WA, double limit, const PlacedPair& placed,
                     SignedDistance& distance) {
  if (!is_valid_if_separated(record))
    return separated_distance(placed.pair, search_limit(placed, limit), distance);
  distance = {placed.from_world(record.separation), vector_of(record.n),
              placed.from_world(Vector3(X_WA.p + vector_of(record.from_A)))};
  return true;
}

bool is_complete(const DepthRecord& record) {
  return record.certified == Certified::overlapping && record.known == DepthKnown::witness;
}

/// Writes the geometry of a pair whose depth is complete.
void write_contact(const OrderedPair& pair, const DepthRecord& record, PairGeometry& geometry) {
  write(pair, record.separation, vector_of(record.n), vector_of(record.p_A), geometry);
}

/// Writes the geometry of a certainly separated pair.
void write_separated(const OrderedPair& pair, const DistanceRecord& record, const NarrowphaseInput& input,
                     PairGeometry& geometry) {
  if (record.separation > input.query.max_separation) return write_beyond(geometry);
  const Vector3 p_A = input.poses[pair.pair.a].p + vector_of(record.from_A);
  write(pair, record.separation, vector_of(record.n), p_A, geometry);
}

/// Whether the query asks for more than the status of separated pairs.
bool wants_distance(const Query& query) { return query.max_separation > 0.0; }

bool is_out_of_reach(const DepthRecord& record, const Query& query) {
  return record.certified == Certified::separated && !wants_distance(query);
}

/// Evaluates one pair in stages, the cheapest first. A stage returns the pair's status where it
/// settles the pair, and leaves what it found to the next one where it does not. Records stay where the
/// kernels wrote them: a copy of one just written waits for its stores.
class PairEvaluation {
 public:
  PairEvaluation(const SolidSet& set, const Kernels& kernels, const NarrowphaseInput& input,
                 const OrderedPair& given, DepthRecord& depth, DistanceRecord& distance, Certified decided)
      : set_(set),
        kernels_(kernels),
        input_(input),
        given_(given),
        depth_(depth),
        distance_(distance),
        certified_(decided) {}

  PairStatus run(PairGeometry& geometry, ContactPoint* points, ClipBatch& clips) {
    if (const auto status = take_records(geometry, points)) return *status;
    kind_ = kind_of(set_, given_.pair);
    certify_single();
    if (const auto status = write_depth(geometry, points)) return *status;
    if (const auto status = decide_class(geometry)) return *status;
    if (const auto status = find_distance(geometry, points)) return *status;
    if (const auto status = clip_in_lanes(geometry, points, clips)) return *status;
    if (const auto status = compute_hulls(geometry, points)) return *status;
    return finish(geometry, points, clips);
  }

 private:
  using Outcome = std::optional<PairStatus>;

  const Pose& X_WA() const { return input_.poses[given_.pair.a]; }
  const Pose& X_WB() const { return input_.poses[given_.pair.b]; }
  bool is_general() const { return kind_ == SolidKind::general; }
  bool has_distance() const { return distance_.state == DistanceState::found; }
  bool is_undecided() const {
    return depth_.certified == Certified::unknown && certified_ == Certified::unknown;
  }

  void place_pair() {
    if (is_ordinary_)
      place_in_lanes(set_, kernels_, given_.pair, input_.poses, placed_);
    else
      place(set_, given_.pair, X_WA(), X_WB(), false, placed_);
    is_placed_ = true;
  }

  /// Writes the answer for a certainly separated pair of which no more is asked; false for others.
  bool is_beyond(PairGeometry& geometry) const {
    if (!is_out_of_reach(depth_, input_.query)) return false;
    write_beyond(geometry);
    return true;
  }

  /// Writes a distance that was found. True where nothing else is asked for.
  bool write_distance(PairGeometry& geometry, const ContactPoint* points) const {
    if (!has_distance()) return false;
    write_separated(given_, distance_, input_, geometry);
    return points == nullptr || distance_.separation > input_.query.max_separation;
  }

  /// The records of the batch's kernels settle a separated pair without a manifold.
  Outcome take_records(PairGeometry& geometry, const ContactPoint* points) const {
    if (is_beyond(geometry) || write_distance(geometry, points)) return PairStatus::separated;
    return std::nullopt;
  }

  /// Filters of single pairs: kernels on a scaled copy, comparison of coordinates.
  void certify_single() {
    has_depth_ = is_complete(depth_);
    if (has_depth_ || has_distance()) return;
    is_ordinary_ = is_ordinary(set_, given_.pair.a, X_WA(), given_.pair.b, X_WB());
    // Magnitudes that kernels do not take: the same pair scaled by a power of two.
    if (!is_ordinary_) find_scaled_pair_depth(set_, kernels_, given_.pair, input_.poses, depth_);
    if (is_ordinary_ && !is_general() && is_undecided()) {
      if (kind_ == SolidKind::box)
        certified_ = certify_touching_pair(set_, kernels_, given_.pair, input_.poses);
      if (certified_ == Certified::unknown) {
        place_pair();
        certified_ = certify_aligned(placed_.a_W, placed_.b_W);
      }
      if (certified_ == Certified::overlapping) depth_.certified = certified_;
    }
    has_depth_ = is_complete(depth_);
  }

  Outcome write_depth(PairGeometry& geometry, const ContactPoint* points) const {
    if (!has_depth_) return std::nullopt;
    write_contact(given_, depth_, geometry);
    return points == nullptr ? Outcome(PairStatus::overlapping) : std::nullopt;
  }

  /// The class of boxes and parallelepipeds that no filter certified, before their distance: most of them
  /// touch, and a distance of pairs that do is work for nothing.
  Outcome decide_class(PairGeometry& geometry) {
    if (is_general() || has_depth_ || has_distance()) return std::nullopt;
    if (is_undecided()) {
      if (!is_placed_) place_pair();
      certified_ = hulls_meet(kernels_, placed_, depth_) ? Certified::overlapping : Certified::separated;
    }
    if (certified_ != Certified::separated || wants_distance(input_.query)) return std::nullopt;
    write_beyond(geometry);
    return PairStatus::separated;
  }

  /// Distance of boxes and parallelepipeds, by the kernels not tried yet.
  Outcome find_distance(PairGeometry& geometry, const ContactPoint* points) {
    if (is_general()) return std::nullopt;
    return try_distance(geometry, points) ? Outcome(PairStatus::separated) : std::nullopt;
  }

  bool try_distance(PairGeometry& geometry, const ContactPoint* points) {
    if (has_distance() || depth_.certified == Certified::overlapping || certified_ == Certified::overlapping)
      return false;
    finish_kernel_distance(set_, kernels_, given_.pair, input_.poses,
                           depth_.certified == Certified::separated, distance_);
    return write_distance(geometry, points);
  }

  /// Manifolds of boxes and parallelepipeds whose geometry is written: gathered for the clipping kernel.
  Outcome clip_in_lanes(PairGeometry& geometry, ContactPoint* points, ClipBatch& clips) const {
    if (!(has_depth_ || has_distance()) || is_general() || !is_ordinary_) return std::nullopt;
    clips.add(given_, kind_, geometry, points);
    return has_distance() ? PairStatus::separated : PairStatus::overlapping;
  }

  /// Depth, then distance, of general hexahedra.
  Outcome compute_hulls(PairGeometry& geometry, const ContactPoint* points) {
    if (!is_placed_) place_pair();
    if (!is_general() || has_distance()) return std::nullopt;
    if (!depth_.is_of_hulls)
      find_hull_depth(set_, kernels_, given_.pair, placed_, std::max(norm_inf(X_WA().p), norm_inf(X_WB().p)),
                      depth_);
    if (!is_ordinary_) depth_.certified = Certified::unknown;
    if (is_beyond(geometry) || try_distance(geometry, points)) return PairStatus::separated;
    return std::nullopt;
  }

  /// Decides exactly where no filter has certified the pair.
  bool do_meet() const {
    if (has_distance()) return false;
    const Certified certified = certified_ == Certified::unknown ? depth_.certified : certified_;
    return certified == Certified::unknown ? hulls_meet(kernels_, placed_, depth_)
                                           : certified == Certified::overlapping;
  }

  /// Distance or depth by search in doubles where the kernels have none, then the manifold.
  PairStatus finish(PairGeometry& geometry, ContactPoint* points, ClipBatch& clips) const {
    const bool meet = do_meet();
    const PairStatus status = meet ? PairStatus::overlapping : PairStatus::separated;
    SignedDistance distance;
    if (meet) {
      finish_depth(depth_, is_general(), placed_, distance);
    } else if (!finish_distance(distance_, X_WA(), input_.query.max_separation, placed_, distance)) {
      write_beyond(geometry);
      return status;
    }

    // World values decide whether the pair is within the limit.
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
      write_manifold(kernels_, placed_, distance, given_.swapped, input_.query, geometry, points);
    return status;
  }

  const SolidSet& set_;
  const Kernels& kernels_;
  const NarrowphaseInput& input_;
  const OrderedPair& given_;
  DepthRecord& depth_;
  DistanceRecord& distance_;
  SolidKind kind_ = SolidKind::general;
  Certified certified_;     ///< by comparison of coordinates, or exactly
  bool has_depth_ = false;  ///< the record of the depth is complete, and overlapping
  bool is_ordinary_ = true;
  bool is_placed_ = false;
  PlacedPair placed_;
};

void prefetch_general(const SolidSet& set, const SolidPair& pair, bool depth, bool faces) {
  if (kind_of(set, pair) != SolidKind::general) return;
  prefetch_hull(set, pair.a, depth, faces), prefetch_hull(set, pair.b, depth, faces);
}

/// Fetches what manifolds of a batch read of a solid's faces.
void prefetch_faces(const SolidSet& set, SolidIndex solid) {
  if (const PlainHull* const plain = set.solids[solid].plain)
    prefetch(plain->normals);
  else
    prefetch_hull(set, solid, false, true);
}

/// Fetches the poses of a pair some iterations ahead: pairs are in no order that hardware could predict.
void prefetch_poses(const SolidPair& pair, std::span<const Pose> poses) {
  for (const SolidIndex i : {pair.a, pair.b}) {
    __builtin_prefetch(&poses[i].R);
    __builtin_prefetch(&poses[i].p.z());
  }
}

struct Records {
  std::array<DepthRecord, kBlock> depth;
  std::array<Certified, kBlock> decided;  ///< beside the depths' certificates, which leave these unknown
  std::array<DistanceRecord, kBlock> distance;
};

/// The classes of pairs that the depth kernels did not certify, in the order of PairEvaluation: those that
/// overlap need no search for a distance.
void decide_classes(const SolidSet& set, const Kernels& kernels, SolidKind kind, std::span<const Pose> poses,
                    const Batch& batch, Records& records) {
  // Those of ordinary magnitudes, which the kernels take.
  Batch open;
  std::fill_n(records.decided.data(), batch.count, Certified::unknown);
  for (std::size_t i = 0; i < batch.count; ++i) {
    if (records.depth[i].certified != Certified::unknown) continue;
    const SolidPair pair{batch.pairs[i].a, batch.pairs[i].b};
    if (has_finite_poses(pair, poses) && is_ordinary(set, pair.a, poses[pair.a], pair.b, poses[pair.b]))
      open.add(pair, i);
  }
  std::array<Certified, kBlock> touching;
  std::fill_n(touching.data(), open.count, Certified::unknown);
  if (kind == SolidKind::box)
    kernels.certify_touching_boxes(records_of(poses), set.boxes.data(), open.pairs.data(), open.count,
                                   touching.data());
  // The others one by one.
  for (std::size_t k = 0; k < open.count; ++k) {
    const std::size_t i = open.slots[k];
    Certified certified = touching[k];
    if (certified == Certified::unknown) {
      const SolidPair pair{open.pairs[k].a, open.pairs[k].b};
      PlacedPair placed;
      place(set, pair, poses[pair.a], poses[pair.b], true, placed);
      certified = certify_aligned(placed.a_W, placed.b_W);
      if (certified == Certified::unknown) {
        records.decided[i] =
            hulls_meet(kernels, placed, records.depth[i]) ? Certified::overlapping : Certified::separated;
        continue;
      }
    }
    // Comparison's certificate is the depth's.
    (certified == Certified::overlapping ? records.depth[i].certified : records.decided[i]) = certified;
  }
}

/// Depths of one kind's pairs, then the distances of those not certified as overlapping.
void run_kernels(const SolidSet& set, const Kernels& kernels, SolidKind kind, std::span<const Pose> poses,
                 const Query& query, const Batch& batch, Records& records) {
  const PoseRecord* X_W = records_of(poses);
  const bool is_one = batch.count == 1;
  if (is_one && !has_finite_poses({batch.pairs[0].a, batch.pairs[0].b}, poses)) {
    records.depth[0] = kNoDepth;
  } else if (kind == SolidKind::box) {
    kernels.compute_box_depths(X_W, set.boxes.data(), batch.pairs.data(), batch.count, records.depth.data());
  } else {
    kernels.compute_parallelepiped_depths(X_W, set.parallelepiped_edges.data(), batch.pairs.data(),
                                          batch.count, records.depth.data());
  }
  decide_classes(set, kernels, kind, poses, batch, records);
  compute_batch_distances(set, kernels, kind, poses, batch, records.depth.data(), records.decided.data(),
                          wants_distance(query), records.distance.data());
}

struct Batches {
  Batch boxes, parallelepipeds, others;
};

/// Answers the boxes of a batch that are certainly beyond the query's reach, and takes them out of it, where
/// enough are: some of them, asked first, tell.
void settle_beyond(const SolidSet& set, const Kernels& kernels, const NarrowphaseInput& input, Batch& boxes,
                   std::span<PairStatus> status, std::span<PairGeometry> geometry) {
  // The look costs a quarter of what a pair beyond saves.
  constexpr std::size_t kAskedFirst = 32, kLeastShare = 4;
  if (boxes.count < kAskedFirst || !(input.query.max_separation < kInfinity)) return;
  std::array<Certified, kBlock> beyond;
  const double reach = std::max(input.query.max_separation, 0.0);
  const auto ask = [&](std::size_t first, std::size_t end) {
    kernels.find_boxes_beyond(records_of(input.poses), set.boxes.data(), boxes.pairs.data() + first,
                              end - first, reach, beyond.data() + first);
  };
  ask(0, kAskedFirst);
  const std::span<const Certified> first(beyond.data(), kAskedFirst);
  const auto found = static_cast<std::size_t>(std::count(first.begin(), first.end(), Certified::separated));
  if (found * kLeastShare < kAskedFirst) return;
  ask(kAskedFirst, boxes.count);
  // The others stay, in their order.
  std::size_t kept = 0;
  for (std::size_t i = 0; i < boxes.count; ++i) {
    const std::uint16_t slot = boxes.slots[i];
    if (beyond[i] == Certified::separated) {
      write_beyond(geometry[slot]);
      status[slot] = PairStatus::separated;
      continue;
    }
    boxes.pairs[kept] = boxes.pairs[i], boxes.slots[kept++] = slot;
  }
  boxes.count = kept;
}

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
        prefetch_pair(set.parallelepiped_edges, poses, pair);
        out.parallelepipeds.add(pair, i);
        break;
      case SolidKind::general:
        // What these lead to is fetched as pairs are computed.
        for (const SolidIndex solid : {pair.a, pair.b}) prefetch(set.solids[solid]);
        out.others.add(pair, i);
        break;
    }
  }
}

/// One of a batch, from its records.
PairStatus finish_pair(const SolidSet& set, const Kernels& kernels, const NarrowphaseInput& input,
                       const OrderedPair& pair, DepthRecord& depth, DistanceRecord& distance,
                       Certified decided, PairGeometry& geometry, ContactPoint* points, ClipBatch& clips) {
  // What is certified has finite poses.
  if (depth.certified == Certified::unknown && !has_finite_poses(pair.pair, input.poses))
    return fail(geometry);
  // Most pairs in contact need none of the stages.
  if (is_complete(depth)) {
    write_contact(pair, depth, geometry);
    if (points) clips.add(pair, kind_of(set, pair.pair), geometry, points);
    return PairStatus::overlapping;
  }
  return PairEvaluation(set, kernels, input, pair, depth, distance, decided).run(geometry, points, clips);
}

/// Writes the contact of two general hexahedra whose depth is complete, about `origin`.
void write_hull_contact(const SolidSet& set, const Kernels& kernels, const NarrowphaseInput& input,
                        const OrderedPair& pair, const DepthRecord& depth, const Vector3& origin,
                        PairGeometry& geometry, ContactPoint* points, HullClipBatch& clips) {
  const SignedDistance distance{depth.separation, vector_of(depth.n), vector_of(depth.p_A)};
  write(pair, distance.separation, distance.n, origin + distance.p_A, geometry);
  if (points == nullptr) return;
  if (clips.takes(pair.pair)) return clips.add(pair, distance, true, geometry, points);
  PlacedPair placed;
  place(set, pair.pair, input.poses[pair.pair.a], input.poses[pair.pair.b], true, placed);
  write_manifold(kernels, placed, distance, pair.swapped, input.query, geometry, points);
}

/// Pairs whose depths are computed at a time, so that their placed vertices stay in the first cache.
constexpr std::size_t kPlaced = 32;

/// The pairs of a batch that the kernel of regular hulls takes.
struct HullTasks {
  std::array<HullTask, kBlock> tasks;
  std::array<std::uint16_t, kBlock> of_batch;
  std::array<PlacedHulls, kPlaced> placed;
  std::size_t count = 0;

  HullTasks(const SolidSet& set, const NarrowphaseInput& input, const Batch& batch, Records& records) {
    if (!(input.query.max_separation >= 0.0)) return;
    constexpr std::size_t kFetchedHere = 8;  // the kernel fetches those after them
    for (std::size_t i = 0; i < batch.count; ++i) {
      const PairIndices& indices = batch.pairs[i];
      const SolidPair pair{indices.a, indices.b};
      const PlainHull *const a = set.solids[pair.a].plain, *const b = set.solids[pair.b].plain;
      if (a == nullptr || b == nullptr || !has_finite_poses(pair, input.poses) ||
          !is_ordinary(set, pair.a, input.poses[pair.a], pair.b, input.poses[pair.b]))
        continue;
      if (count < kFetchedHere)
        prefetch(set.vertices[pair.a]), prefetch(set.vertices[pair.b]), prefetch(*a), prefetch(*b);
      tasks[count] = {indices, a, b, &records.depth[i], &placed[count % kPlaced]};
      of_batch[count++] = static_cast<std::uint16_t>(i);
    }
  }
};

/// @param finish (place in the batch, hulls): of each pair whose depth is complete
template <class Finish>
void compute_general_depths(const SolidSet& set, const Kernels& kernels, std::span<const Pose> poses,
                            const HullTasks& tasks, const Finish& finish) {
  for (std::size_t first = 0; first < tasks.count; first += kPlaced) {
    const std::size_t here = std::min(kPlaced, tasks.count - first);
    kernels.compute_hull_depths(records_of(poses), vertex_records(set), &tasks.tasks[first], here,
                                tasks.count - first);
    for (std::size_t k = 0; k < here; ++k)
      if (is_complete(*tasks.tasks[first + k].depth)) finish(tasks.of_batch[first + k], tasks.placed[k]);
  }
}

/// Where a block's answers go.
struct BlockOutput {
  std::span<PairStatus> status;
  std::span<PairGeometry> geometry;
  ContactPoint* points;  ///< null where none are asked for
  std::size_t slots;

  ContactPoint* points_of(std::size_t i) const { return points ? points + i * slots : nullptr; }
};

/// Distances of the pairs of a batch that have no depth: most are known to be apart.
void compute_general_distances(const SolidSet& set, const Kernels& kernels, std::span<const Pose> poses,
                               const Batch& batch, Records& records) {
  Batch apart;
  for (std::size_t i = 0; i < batch.count; ++i)
    if (!is_complete(records.depth[i])) apart.add({batch.pairs[i].a, batch.pairs[i].b}, i);
  std::array<DistanceRecord, kBlock> found;
  compute_hull_distances(set, kernels, poses, std::span(apart.pairs).first(apart.count), found.data());
  for (std::size_t i = 0; i < apart.count; ++i) records.distance[apart.slots[i]] = found[i];
}

/// General hexahedra of a block: depths and distances, pairs in lanes, then the pairs that are left, one by
/// one. Depths come first: a face tells that most pairs apart are, for less than a search takes. @param
/// finish as compute_block() has it
template <class Finish>
void compute_general(const SolidSet& set, const Kernels& kernels, const NarrowphaseInput& input,
                     const Batch& batch, std::span<const OrderedPair> pairs, Records& records,
                     const BlockOutput& out, const Finish& finish) {
  if (batch.count == 0) return;
  std::fill_n(records.distance.data(), batch.count, kNoDistance);
  std::fill_n(records.depth.data(), batch.count, kNoDepth);
  const bool faces = out.points != nullptr;
  HullClipBatch clips(set, kernels, input);
  const HullTasks tasks(set, input, batch, records);
  compute_general_depths(set, kernels, input.poses, tasks, [&](std::size_t i, const PlacedHulls& hulls) {
    const std::size_t slot = batch.slots[i];
    write_hull_contact(set, kernels, input, pairs[slot], records.depth[i], vector_of(hulls.origin),
                       out.geometry[slot], out.points_of(slot), clips);
    out.status[slot] = PairStatus::overlapping;
  });
  if (wants_distance(input.query)) compute_general_distances(set, kernels, input.poses, batch, records);
  // A pair's solids are fetched some pairs before its hulls, which they lead to.
  constexpr std::size_t kSolidsAhead = 6, kHullsAhead = 2;
  for (std::size_t i = 0; i < batch.count; ++i) {
    if (i + kSolidsAhead < batch.count) {
      const PairIndices& later = batch.pairs[i + kSolidsAhead];
      prefetch(set.solids[later.a]), prefetch(set.solids[later.b]);
    }
    if (const std::size_t next = i + kHullsAhead; next < batch.count && !is_complete(records.depth[next])) {
      const bool depth = records.distance[next].state != DistanceState::found;
      for (const std::uint32_t solid : {batch.pairs[next].a, batch.pairs[next].b}) {
        if (depth) prefetch_hull(set, solid, true, false);
        if (faces) prefetch_faces(set, solid);
      }
    }
    if (is_complete(records.depth[i])) continue;
    const std::size_t slot = batch.slots[i];
    const OrderedPair& pair = pairs[slot];
    const DistanceRecord& distance = records.distance[i];
    // Pairs apart whose points go in lanes, too. No distance is found of poses that are not finite: they fail
    // in finish().
    if (faces && distance.state == DistanceState::found && clips.takes(pair.pair)) {
      write_separated(pair, distance, input, out.geometry[slot]);
      out.status[slot] = PairStatus::separated;
      if (distance.separation > input.query.max_separation) continue;
      const Vector3 p_A = input.poses[pair.pair.a].p + vector_of(distance.from_A);
      clips.add(pair, {distance.separation, vector_of(distance.n), p_A}, false, out.geometry[slot],
                out.points_of(slot));
      continue;
    }
    finish(slot, records.depth[i], records.distance[i], Certified::unknown);
  }
}

/// At most kBlock pairs.
void compute_block(const SolidSet& set, const Kernels& kernels, const NarrowphaseInput& input,
                   std::span<PairStatus> status, std::span<PairGeometry> geometry, ContactPoint* points,
                   std::size_t slots) {
  std::array<OrderedPair, kBlock> pairs;
  ClipBatch clips(set, kernels, input);
  const auto finish = [&](std::size_t i, DepthRecord& depth, DistanceRecord& distance, Certified decided) {
    status[i] = finish_pair(set, kernels, input, pairs[i], depth, distance, decided, geometry[i],
                            points ? points + i * slots : nullptr, clips);
  };
  // Pairs by kind, each in the order of comes_first().
  const std::size_t count = input.pairs.size();
  constexpr std::size_t kAhead = 12;
  for (std::size_t i = 0; i < count; ++i) {
    if (i + kAhead < count) prefetch_poses(input.pairs[i + kAhead], input.poses);
    pairs[i] = ordered(set, input.pairs[i], input.poses);
  }
  Batches batches;
  sort_by_kind(set, input.poses, std::span(pairs).first(count), batches);
  settle_beyond(set, kernels, input, batches.boxes, status, geometry);
  // Boxes and parallelepipeds by their kernels.
  Records records;
  for (const auto& [kind, batch] : {std::pair<SolidKind, const Batch&>{SolidKind::box, batches.boxes},
                                    {SolidKind::parallelepiped, batches.parallelepipeds}}) {
    if (batch.count == 0) continue;
    run_kernels(set, kernels, kind, input.poses, input.query, batch, records);
    for (std::size_t i = 0; i < batch.count; ++i)
      finish(batch.slots[i], records.depth[i], records.distance[i], records.decided[i]);
  }
  compute_general(set, kernels, input, batches.others, pairs, records, {status, geometry, points, slots},
                  finish);
}

void find_single_depth(const SolidSet& set, const Kernels& kernels, SolidKind kind, const SolidPair& pair,
                       std::span<const Pose> poses, PairNeed need, DepthRecord& out) {
  if (kind != SolidKind::box) return find_pair_depth(set, kernels, pair, poses, out);
  kernels.compute_box_pair_depth(records_of(poses), set.boxes.data(), {pair.a, pair.b}, need, &out);
}

PairStatus compute_single(const SolidSet& set, const Kernels& kernels, const NarrowphaseInput& input,
                          PairGeometry& geometry, ContactPoint* points) {
  prefetch_general(set, input.pairs[0], true, points != nullptr);
  if (!has_finite_poses(input.pairs[0], input.poses)) return fail(geometry);
  const OrderedPair pair = ordered(set, input.pairs[0], input.poses);
  const SolidKind kind = kind_of(set, pair.pair);
  DepthRecord record;
  const PairNeed need = !wants_distance(input.query) ? PairNeed::contacts
                        : points != nullptr          ? PairNeed::manifold
                                                     : PairNeed::distance;
  find_single_depth(set, kernels, kind, pair.pair, input.poses, need, record);
  // Most pairs that are apart end here where contacts alone are asked for.
  if (is_out_of_reach(record, input.query)) {
    write_beyond(geometry);
    return PairStatus::separated;
  }
  // And most of the others in contact.
  if (is_complete(record)) {
    write_contact(pair, record, geometry);
    if (points) clip_pair(set, kernels, input, pair, kind, geometry, points);
    return PairStatus::overlapping;
  }
  DistanceRecord distance = kNoDistance;
  if (record.certified == Certified::separated) {
    const PairIndices indices{pair.pair.a, pair.pair.b};
    compute_distances(set, kernels, kind, input.poses, {&indices, 1}, &record.axis, &distance);
    if (distance.state == DistanceState::found && points == nullptr) {
      write_separated(pair, distance, input, geometry);
      return PairStatus::separated;
    }
  }
  ClipBatch clips(set, kernels, input);
  return PairEvaluation(set, kernels, input, pair, record, distance, Certified::unknown)
      .run(geometry, points, clips);
}

}  // namespace

void compute_geometry(const SolidSet& set, const Kernels& kernels, const NarrowphaseInput& input,
                      std::span<PairStatus> status, std::span<PairGeometry> geometry,
                      std::span<ContactPoint> points) {
  const std::size_t slots =
      points.empty() ? 0
                     : static_cast<std::size_t>(std::clamp(input.query.max_points, 1, kMaxManifoldPoints));
  ContactPoint* const first_point = points.empty() ? nullptr : points.data();
  if (input.pairs.size() == 1) {
    status[0] = compute_single(set, kernels, input, geometry[0], first_point);
    return;
  }
  for (std::size_t first = 0; first < input.pairs.size(); first += kBlock) {
    NarrowphaseInput block = input;
    block.pairs = input.pairs.subspan(first, std::min(kBlock, input.pairs.size() - first));
    compute_block(set, kernels, block, status.subspan(first), geometry.subspan(first),
                  first_point ? first_point + first * slots : nullptr, slots);
  }
}

}  // namespace touchstone::native
