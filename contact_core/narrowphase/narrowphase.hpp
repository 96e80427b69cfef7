#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string_view>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/geometry/hexahedron.hpp"
#include "touchstone/contact_core/geometry/pose.hpp"

/// @file
/// The fine check, behind one interface. Conventions for every backend:
///  * SI units, doubles. Solids are closed sets: touching is contact (`overlapping`, separation 0).
///  * n_AB_W: unit, from A to B, in world. separation > 0 apart, < 0 overlapping (minimal translation
///    distance).
///  * p_B_W = p_A_W + separation * n_AB_W; moving B by -separation * n_AB_W brings the pair to touch.
///  * Results come in the order of the pairs; result i depends on pair i alone.
///
/// Definition of a manifold. Of each solid take the face whose normal is most along n (A) or against it (B),
/// as the user gave it: facets that a file's rounding bent are one face within a tolerance that the backend
/// states. Seen along n, the two faces clip each other. Each corner of that clip is a place on both surfaces,
/// with the separation of the true surfaces there. The manifold has the clip's corners that are no further
/// apart than the point limit, point_limit(): the larger of Query::max_point_separation and the pair's own
/// separation.
///  * No point of any backend lies beyond that limit by more than its resolution: corners as near as the pair
///    to rounding count as within, so that faces that touch or stand apart flat keep all corners whichever
///    way rounding tilts them.
///  * The deepest point always is there, with the pair's separation: a witness point where no corner is as
///    deep. So a pair that is not beyond max_separation has a point at least, however far apart it is.
///  * By default the limit is 0: what touches or overlaps. Callers that build stacks set it to the distance
///    that a body may move in a step, so that a block tilted by a solver's noise keeps its corners (physics
///    and the plug-ins do).
///  * The clip is not cut where its separation passes the limit. Separation is linear over plane faces, so
///    the cut's corners, all at the limit, never touch first. They would displace corners that carry load,
///    and jitter by the pose's noise over the sine of the tilt; the clip's own corners keep their places.
///
/// The *patch* that manifolds are judged against is the hull of the exact clip's corners within the limit.
/// `native` and `exact` give those corners or, where they are too many, a choice of them that covers much of
/// the area; engines give the points that they find within the same limit.

namespace touchstone {

/// Counts solids in the order in which they were given to build().
using SolidIndex = std::uint32_t;

/// Two solids, a < b, as indices into the span given to build().
struct SolidPair {
  SolidIndex a;
  SolidIndex b;

  friend bool operator==(const SolidPair&, const SolidPair&) = default;
  friend auto operator<=>(const SolidPair&, const SolidPair&) = default;
};

/// A backend's answer about one pair. It is never a guess: the last three values stand for what a backend
/// does not know.
enum class PairStatus : std::uint8_t {
  separated,    ///< apart by more than the declared resolution
  overlapping,  ///< touching or penetrating
  undecided,    ///< closer to touching than the declared resolution; still carries geometry
  failed,       ///< did not converge, the engine refused, or a pose is not finite; carries nothing
  unsupported,  ///< this backend cannot answer this query for this pair; carries nothing
};
/// The enumerator's name.
std::string_view to_string(PairStatus status);

/// What is asked about a pair; each kind includes those before it.
enum class QueryKind : std::uint8_t {
  overlap,   ///< status only
  distance,  ///< signed distance, normal and one pair of witness points
  manifold,  ///< the same and up to max_points contact points within the point limit
};
/// The enumerator's name.
std::string_view to_string(QueryKind kind);

/// Most contact points of one pair, whatever the backend.
inline constexpr int kMaxManifoldPoints = 8;

/// What is asked about every pair of a batch. Asking for less costs less.
struct Query {
  QueryKind kind = QueryKind::overlap;
  /// Pairs further apart than this [m] are `separated` with separation +inf (never a bound) and NaN
  /// elsewhere.
  double max_separation = kInfinity;
  /// Slots per pair in NarrowphaseOutput::points, 1 to kMaxManifoldPoints; manifold only.
  int max_points = kMaxManifoldPoints;
  /// Points further apart than this [m], and than the pair, are not in the manifold; see above. Infinite: the
  /// whole clip. Independent of max_separation, which is about pairs.
  double max_point_separation = 0.0;

  /// Slots that a pair needs in NarrowphaseOutput::points.
  std::size_t slots() const { return kind == QueryKind::manifold ? static_cast<std::size_t>(max_points) : 0; }
};

/// The limit on the separations of a pair's points [m]. @param separation the pair's [m].
inline double point_limit(const Query& query, double separation) {
  return query.max_point_separation > separation ? query.max_point_separation : separation;
}

/// One pair's answer to a distance or manifold query. NaN where the status carries nothing.
struct PairGeometry {
  double separation;  ///< signed [m]
  Vector3 n_AB_W;     ///< unit, from A to B
  Vector3 p_A_W;      ///< witness on A's surface [m]
  Vector3 p_B_W;      ///< witness on B's surface: p_A_W + separation * n_AB_W
  /// Slots used in the pair's part of NarrowphaseOutput::points; 0 unless manifold.
  std::int32_t point_count;
};

/// One point of a manifold: a point on each surface, p_B_W = p_A_W + separation * n_AB_W [m].
struct ContactPoint {
  Vector3 p_A_W;
  Vector3 p_B_W;
  double separation;  ///< along the pair's n_AB_W [m]
  /// Names the features that made the point, stable while the contact keeps its shape; backend-defined, 0 if
  /// unknown.
  std::uint32_t feature_id;
};

/// Declared by a backend, verified by the shared suite.
struct Resolution {
  double absolute = 0.0;  ///< [m]
  double relative = 0.0;  ///< per metre of max(|world coordinate|, size + 2 radius)
  double of_depth = 0.0;  ///< added for penetrating pairs, per metre of depth; infinite: no claim

  /// The resolution for pairs that do not penetrate [m]. @param scale max(|world coordinate|, size + 2
  /// radius) [m].
  double at(double scale) const { return absolute + relative * scale; }
};

/// The queries that a backend answers and how accurate it is, as it declares them. A resolution that depends
/// on the solids is that of the last build().
struct Capabilities {
  bool distance = false;     ///< separation, normal and witness points of pairs that are apart
  bool penetration = false;  ///< the same for pairs that overlap
  bool manifold = false;
  /// Takes rounded solids (Hexahedron::radius()): every query, their class exact. Where false, build()
  /// refuses them.
  bool rounded_solids = false;
  /// False: the method has blind spots, stated in its header; missed contacts are expected.
  bool overlap_complete = true;
  int scalar_bits = 64;  ///< of the engine's own arithmetic
  bool deterministic = true;
  bool thread_safe = true;  ///< evaluate() on several threads, each with its own Workspace
  /// Separations are within this of the truth where the backend claims them at all; closer to 0 than this it
  /// may answer `undecided`.
  Resolution resolution;
};

/// Caller-owned memory of one pair between frames (for example the last separating axis). It changes speed
/// only, never answers.
struct PairCacheEntry {
  std::uint32_t data[4] = {0, 0, 0, 0};  ///< zero: nothing known
};

/// A batch of pairs, all asked the same. Spans are borrowed for the call.
struct NarrowphaseInput {
  std::span<const SolidPair> pairs;
  std::span<const Pose> poses;  ///< X_WS of every solid given to build(), in that order
  Query query;
  std::span<PairCacheEntry> cache = {};  ///< empty, or one entry a pair
};

/// Caller-owned slots; pair i writes status[i], geometry[i] and points[i * max_points ...) only, so chunks of
/// a batch run on any threads without locks.
struct NarrowphaseOutput {
  std::span<PairStatus> status = {};      ///< one a pair
  std::span<PairGeometry> geometry = {};  ///< one a pair; may be empty for overlap
  std::span<ContactPoint> points = {};    ///< max_points a pair; may be empty unless manifold

  /// The slots of pair i; none unless manifold.
  std::span<ContactPoint> points_of(std::size_t i, const Query& query) const {
    return points.subspan(i * query.slots(), query.slots());
  }
};

/// The fine check's interface. Built over solids once, then asked about batches of pairs at any poses.
/// evaluate() is const: several threads may call it where Capabilities::thread_safe is true, each with its
/// own Workspace; not during build().
class Narrowphase {
 public:
  /// A thread's scratch memory, made by the backend it is used with.
  class Workspace {
   public:
    virtual ~Workspace() = default;
  };

  virtual ~Narrowphase() = default;

  virtual std::string_view name() const noexcept = 0;
  virtual const Capabilities& capabilities() const noexcept = 0;

  /// Cold path: takes copies of what it needs. On an exception the previous build is still in force.
  /// @throws InputError for a solid that this backend cannot represent, naming its index.
  virtual void build(std::span<const Hexahedron> solids) = 0;
  /// Replaces the solids from `first` on by these; those beyond the last solid are appended. As build(), but
  /// the cost is that of the solids given. Workspaces stay valid.
  /// Returns false, and changes nothing, in a backend that must be built anew; any may.
  /// @pre first <= the number of solids. @throws InputError as build(), nothing changed.
  virtual bool set_solids(SolidIndex first, std::span<const Hexahedron> solids) {
    static_cast<void>(first), static_cast<void>(solids);
    return false;
  }
  virtual std::unique_ptr<Workspace> make_workspace() const = 0;

  /// Hot path: no allocation after the first call with a workspace, no exceptions, no state that a later call
  /// could see.
  /// A pair with a pose that holds an infinite number or NaN is `failed` (or stays `unsupported` where the
  /// backend never answers the query) and changes no other pair's answer; poses of solids in no pair are not
  /// read.
  /// @pre pairs index solids of build(); finite poses are valid (is_valid_pose); spans are as large as stated
  /// above. Builds with assertions check indices and spans; validate() (validate.hpp) checks all, and
  /// checked() (checked.hpp) wraps a backend so that every call is validated.
  virtual void evaluate(const NarrowphaseInput& input, const NarrowphaseOutput& output,
                        Workspace& workspace) const noexcept = 0;
};

}  // namespace touchstone
