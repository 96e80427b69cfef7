#include "contact_core/native/native.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "contact_core/native/box_box_overlap.hpp"
#include "contact_core/native/distance.hpp"
#include "contact_core/native/gjk.hpp"
#include "contact_core/native/manifold.hpp"
#include "contact_core/native/parallelepiped_overlap.hpp"
#include "contact_core/native/solid_features.hpp"
#include "contact_core/numerics/exact_predicates.hpp"

namespace touchstone {
namespace {

using namespace native;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// Within these magnitudes sixth powers of lengths, all that is ever formed, neither overflow nor underflow
/// harmfully. Sizes and positions outside are scaled.
constexpr double kOrdinaryLow = 0x1p-120;
constexpr double kOrdinaryHigh = 0x1p120;

/// What the overlap of boxes reads: half a cache line.
struct Outline {
  Vector3 half_extents = Vector3::Zero();
  bool is_box = false;
  bool is_parallelepiped = false;  ///< boxes too
  bool is_ordinary = false;
};

struct Solid {
  Hexahedron shape;
  Vector3 middle;
  SolidFeatures features;
};

double largest(const Vector3& p) { return std::max({std::abs(p.x()), std::abs(p.y()), std::abs(p.z())}); }

/// Below zero, zero or above: a total order of posed solids by content, so that (a, b) and (b, a) take the
/// same road.
int compare(const Vector3& p, const Vector3& q) {
  for (int i = 0; i < 3; ++i)
    if (p(i) != q(i)) return p(i) < q(i) ? -1 : 1;
  return 0;
}

bool comes_first(const Solid& a, const Pose& X_WA, const Solid& b, const Pose& X_WB) {
  if (const int order = compare(X_WA.p, X_WB.p)) return order < 0;
  for (int i = 0; i < 3; ++i)
    if (const int order = compare(X_WA.R.col(i), X_WB.R.col(i))) return order < 0;
  for (int i = 0; i < Hexahedron::kVertices; ++i)
    if (const int order = compare(a.shape.vertices()[i], b.shape.vertices()[i])) return order < 0;
  return true;
}

void scale(WorldVertices& v, int exponent) {
  for (int i = 0; i < 8; ++i) {
    v.x[i] = std::scalbn(v.x[i], exponent);
    v.y[i] = std::scalbn(v.y[i], exponent);
    v.z[i] = std::scalbn(v.z[i], exponent);
  }
}

Vector3 scaled(const Vector3& p, int exponent) {
  return {std::scalbn(p.x(), exponent), std::scalbn(p.y(), exponent), std::scalbn(p.z(), exponent)};
}

/// A pair in the check's own order, on a copy scaled by 2^exponent when its magnitudes ask for it.
struct Placed {
  WorldVertices a_W, b_W;
  PosedPair pair;
  Vector3 origin_W;  // unscaled
  int exponent = 0;
};

/// A power of two that brings `magnitude` to [1, 2).
int exponent_for(double magnitude) { return magnitude > 0.0 ? -std::ilogb(magnitude) : 0; }

void place(const Solid& a, const Pose& X_WA, const Solid& b, const Pose& X_WB, bool ordinary, Placed& out) {
  world_vertices(a.shape, X_WA, out.a_W);
  world_vertices(b.shape, X_WB, out.b_W);
  out.origin_W = out.a_W.vertex(0);
  out.exponent = 0;
  PosedPair& pair = out.pair;
  if (ordinary) {
    shift_to_common_origin(out.a_W, out.b_W, pair.hulls);
  } else {
    // First the coordinates, so that differences cannot overflow; then, about the common origin, the extent.
    WorldVertices a_scaled = out.a_W, b_scaled = out.b_W;
    out.exponent = exponent_for(std::max(largest_coordinate(out.a_W), largest_coordinate(out.b_W)));
    scale(a_scaled, out.exponent), scale(b_scaled, out.exponent);
    shift_to_common_origin(a_scaled, b_scaled, pair.hulls);
    const int second = exponent_for(pair.hulls.extent);
    scale(pair.hulls.a, second), scale(pair.hulls.b, second);
    pair.hulls.extent = std::scalbn(pair.hulls.extent, second);
    out.exponent += second;
  }
  pair.a = &a.features, pair.b = &b.features;
  pair.R_WA = X_WA.R, pair.R_WB = X_WB.R;
  pair.start =
      (pair.hulls.b.vertex(0) - pair.hulls.a.vertex(0)) + (pair.hulls.b.vertex(7) - pair.hulls.a.vertex(7));
}

bool hulls_meet(const Placed& placed) {
  const Certified certified = certify_hulls(placed.pair.hulls, placed.pair.start);
  if (certified == Certified::unknown) return numerics::hulls_intersect(placed.a_W, placed.b_W);
  return certified == Certified::overlapping;
}

void write_beyond(PairGeometry& out) {
  out.separation = kInfinity;
  out.n_AB_W = out.p_A_W = out.p_B_W = Vector3::Constant(kNaN);
  out.point_count = 0;
}

class NativeNarrowphase final : public Narrowphase {
 public:
  NativeNarrowphase() {
    capabilities_.distance = capabilities_.penetration = capabilities_.manifold = true;
    // World vertices 2 u, shift 1, projections 6, facet normals and their cross products 8, two bounds'
    // agreement 16 u.
    capabilities_.resolution.relative = 32 * kRoundoff;
  }

  std::string_view name() const noexcept override { return "native"; }
  const Capabilities& capabilities() const noexcept override { return capabilities_; }
  void build(std::span<const Hexahedron> solids) override;
  std::unique_ptr<Workspace> make_workspace() const override { return std::make_unique<Workspace>(); }
  void evaluate(const NarrowphaseInput& input, const NarrowphaseOutput& output,
                Workspace& workspace) const noexcept override;

 private:
  bool is_ordinary(const SolidPair& pair, const NarrowphaseInput& input) const;
  Certified certify_outlines(const SolidPair& pair, const NarrowphaseInput& input) const;
  bool overlaps(const SolidPair& pair, const NarrowphaseInput& input) const;
  PairStatus measure(const SolidPair& pair, const NarrowphaseInput& input, PairGeometry& geometry,
                     ContactPoint* points) const;

  Capabilities capabilities_;
  std::vector<Outline> outlines_;
  std::vector<Parallelepiped> forms_;
  std::vector<Solid> solids_;
};

void NativeNarrowphase::build(std::span<const Hexahedron> solids) {
  std::vector<Outline> outlines;
  std::vector<Parallelepiped> forms;
  std::vector<Solid> kept;
  outlines.reserve(solids.size());
  forms.reserve(solids.size());
  kept.reserve(solids.size());
  for (const Hexahedron& solid : solids) {
    Outline outline;
    outline.half_extents = solid.half_extents();
    outline.is_box = solid.is_box();
    const std::optional<Parallelepiped> form = as_parallelepiped(solid);
    outline.is_parallelepiped = form.has_value();
    forms.push_back(form ? *form : Parallelepiped{});
    outline.is_ordinary = solid.size() >= kOrdinaryLow &&
                          largest(solid.bounding_sphere().centre) <= kOrdinaryHigh &&
                          solid.size() <= kOrdinaryHigh;
    outlines.push_back(outline);
    kept.push_back({solid, solid.bounding_sphere().centre, find_features(solid)});
  }
  outlines_ = std::move(outlines);
  forms_ = std::move(forms);
  solids_ = std::move(kept);
}

bool NativeNarrowphase::is_ordinary(const SolidPair& pair, const NarrowphaseInput& input) const {
  return outlines_[pair.a].is_ordinary && outlines_[pair.b].is_ordinary &&
         largest(input.poses[pair.a].p) <= kOrdinaryHigh && largest(input.poses[pair.b].p) <= kOrdinaryHigh;
}

Certified NativeNarrowphase::certify_outlines(const SolidPair& pair, const NarrowphaseInput& input) const {
  const Outline& a = outlines_[pair.a];
  const Outline& b = outlines_[pair.b];
  const Pose& X_WA = input.poses[pair.a];
  const Pose& X_WB = input.poses[pair.b];
  if (a.is_box && b.is_box) {
    const Certified certified = certify_boxes(a.half_extents, X_WA, b.half_extents, X_WB);
    if (certified != Certified::unknown) return certified;
  }
  if (!a.is_parallelepiped || !b.is_parallelepiped) return Certified::unknown;
  return certify_parallelepipeds(forms_[pair.a], X_WA, forms_[pair.b], X_WB);
}

bool NativeNarrowphase::overlaps(const SolidPair& pair, const NarrowphaseInput& input) const {
  const bool ordinary = is_ordinary(pair, input);
  if (ordinary) {
    const Certified certified = certify_outlines(pair, input);
    if (certified != Certified::unknown) return certified == Certified::overlapping;
  }
  Placed placed;
  place(solids_[pair.a], input.poses[pair.a], solids_[pair.b], input.poses[pair.b], ordinary, placed);
  return hulls_meet(placed);
}

PairStatus NativeNarrowphase::measure(const SolidPair& given, const NarrowphaseInput& input,
                                      PairGeometry& geometry, ContactPoint* points) const {
  const bool swapped =
      !comes_first(solids_[given.a], input.poses[given.a], solids_[given.b], input.poses[given.b]);
  const SolidPair pair = swapped ? SolidPair{given.b, given.a} : given;
  const bool ordinary = is_ordinary(pair, input);
  Placed placed;
  place(solids_[pair.a], input.poses[pair.a], solids_[pair.b], input.poses[pair.b], ordinary, placed);

  Certified certified = ordinary ? certify_outlines(pair, input) : Certified::unknown;
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

  const auto to_world = [&](const Vector3& p) {
    return Vector3(placed.origin_W + scaled(p, -placed.exponent));
  };
  geometry.separation = std::scalbn(distance.separation, -placed.exponent);
  if (!meet) geometry.separation = std::max(geometry.separation, std::numeric_limits<double>::denorm_min());
  if (geometry.separation > max_separation) {
    write_beyond(geometry);
    return status;
  }
  const Vector3 p_A = to_world(distance.p_A);
  const Vector3 p_B = p_A + geometry.separation * distance.n;
  geometry.n_AB_W = swapped ? Vector3(-distance.n) : distance.n;
  geometry.p_A_W = swapped ? p_B : p_A;
  geometry.p_B_W = swapped ? p_A : p_B;
  geometry.point_count = 0;
  if (input.query.kind != QueryKind::manifold || points == nullptr) return status;

  Manifold manifold;
  make_manifold(placed.pair, distance, limit, std::clamp(input.query.max_points, 1, kMaxManifoldPoints),
                manifold);
  geometry.point_count = manifold.count;
  for (int i = 0; i < manifold.count; ++i) {
    const ContactPoint& from = manifold.points[i];
    points[i].p_A_W = to_world(swapped ? from.p_B_W : from.p_A_W);
    points[i].p_B_W = to_world(swapped ? from.p_A_W : from.p_B_W);
    // The deepest point carries the pair's own bits.
    points[i].separation = from.separation == distance.separation
                               ? geometry.separation
                               : std::scalbn(from.separation, -placed.exponent);
    points[i].feature_id = from.feature_id;
  }
  return status;
}

void NativeNarrowphase::evaluate(const NarrowphaseInput& input, const NarrowphaseOutput& output,
                                 Workspace&) const noexcept {
  if (input.query.kind == QueryKind::overlap) {
    for (std::size_t i = 0; i < input.pairs.size(); ++i)
      output.status[i] = overlaps(input.pairs[i], input) ? PairStatus::overlapping : PairStatus::separated;
    return;
  }
  const std::size_t slots =
      static_cast<std::size_t>(std::clamp(input.query.max_points, 1, kMaxManifoldPoints));
  for (std::size_t i = 0; i < input.pairs.size(); ++i) {
    ContactPoint* points = output.points.empty() ? nullptr : &output.points[i * slots];
    output.status[i] = measure(input.pairs[i], input, output.geometry[i], points);
  }
}

}  // namespace

std::unique_ptr<Narrowphase> make_native() { return std::make_unique<NativeNarrowphase>(); }

void register_native(BackendRegistry& registry) {
  registry.add(BackendRegistry::NarrowphaseEntry{
      "native",
      "contact_core's own: certified overlap, signed distance and manifold of convex hexahedra",
      make_native,
      {}});
}

}  // namespace touchstone
