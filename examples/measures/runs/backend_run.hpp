#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "touchstone/contact_core/registry.hpp"
#include "touchstone/examples/measures/common/quantiles.hpp"
#include "touchstone/examples/measures/pairs/pair_set.hpp"
#include "touchstone/examples/measures/runs/consistency.hpp"
#include "touchstone/examples/measures/truth/oracle.hpp"

namespace touchstone::measures {

inline constexpr std::array<QueryKind, 3> kQueryKinds = {QueryKind::overlap, QueryKind::distance,
                                                         QueryKind::manifold};
constexpr std::size_t index_of(QueryKind kind) { return static_cast<std::size_t>(kind); }

/// The query behind each kind. Manifolds are asked as stacks ask for them: of contacts only (max_separation
/// 0: a pair that is apart is rightly answered by `separated` alone), with all points up to a millimetre
/// apart.
Query query_for(QueryKind kind);

/// What a backend said of a case when it was asked again.
struct LaterAnswer {
  std::size_t index;  ///< the case's
  PairStatus status;
  PairGeometry geometry;             ///< not for overlap
  std::vector<ContactPoint> points;  ///< manifold: kMaxManifoldPoints
};

/// One backend's answers to one kind of query, case by case, and what they cost.
struct QueryAnswers {
  std::vector<PairStatus> status;
  std::vector<PairGeometry> geometry;  ///< not for overlap
  std::vector<ContactPoint> points;    ///< manifold: kMaxManifoldPoints a case
  std::optional<Timing> single;        ///< through the interface, one pair a call
  std::optional<Timing> batch;         ///< through the interface, `batch` pairs a call
  std::optional<Timing> raw;           ///< the engine's own call on posed objects, cached
  std::optional<Timing> cached;        ///< as single, on a block that was just run through
  std::optional<double> allocations;   ///< per query, in steady state
  /// After the timing, by index: the cases whose answer is another then. take_worse_answers() judges them.
  std::vector<LaterAnswer> later;
};

struct BackendAnswers {
  std::string name;
  std::string description;
  Capabilities capabilities;
  std::array<QueryAnswers, 3> queries;  ///< by QueryKind
  QueryAnswers perturbed;               ///< manifolds with B moved by 1e-9 S, see perturbed_set
  /// Scenes: every pair of a frame in one call [ns per frame].
  std::array<std::optional<Timing>, 3> frame_by_query;
  std::optional<Consistency> consistency;  ///< where it was asked for and every solid was taken
  std::string failure;                     ///< why there are no answers; empty otherwise
};

struct MeasureOptions {
  std::uint64_t seed = 1;
  bool time_pairs = true;    ///< single, batch and raw
  bool time_frames = false;  ///< whole frames, for scenes
  bool perturb = true;
  bool check_consistency = false;  ///< of sets of one frame
  /// Of a part of a set: its pair i is the set's pair first_case + i * case_stride.
  std::size_t first_case = 0, case_stride = 1;
  int threads = 1;  ///< for answers; timing always runs on one
  int repetitions = 5;
  std::size_t block = 128;           ///< pairs a timed block
  std::size_t batch = 1024;          ///< pairs a call of the batch row
  double slow_seconds = 0.02;        ///< a repetition of one row is cut to about this, whole blocks
  double tail_seconds = 0.1;         ///< single calls of a row for its 99.9 %, cut to about this
  double slow_frame_seconds = 0.05;  ///< the same for scenes, whole frames
};

/// The set with every pair's B moved by 1e-9 S in a seeded direction. Solids are not shared between the pairs
/// of a family; where they are (scenes), the set cannot be perturbed pair by pair and comes back unchanged.
/// The direction is of (seed, case number), as MeasureOptions has that.
PairSet perturbed_set(const PairSet& set, const MeasureOptions& options);

/// Runs the backends on the set in this process: answers first, then timing with backends, queries and blocks
/// shuffled, so that a machine that slows down slows all of them. All pairs of a set that is timed by pairs
/// are asked once more after the timing, in the workspace that was timed: what differs then is in
/// QueryAnswers::later. A solid that a backend refuses makes its cases `unsupported`.
std::vector<BackendAnswers> run_backends(std::span<const BackendRegistry::NarrowphaseEntry* const> backends,
                                         const PairSet& set, const MeasureOptions& options,
                                         const Progress& progress = {});

}  // namespace touchstone::measures
