#include "touchstone/adapters/exact/exact.hpp"

#include <gmp.h>
#include <cassert>

#include <algorithm>
#include <string>
#include <vector>

#include "touchstone/adapters/exact/contact_patch.hpp"
#include "touchstone/adapters/exact/signed_distance.hpp"
#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/narrowphase/narrowphase.hpp"
#include "touchstone/contact_core/narrowphase/no_geometry.hpp"
#include "touchstone/contact_core/narrowphase/rounded_manifold.hpp"
#include "touchstone/contact_core/narrowphase/validate.hpp"

namespace touchstone {
namespace {

bool same_vertices(const WorldVertices& a, const WorldVertices& b) {
  return a.x == b.x && a.y == b.y && a.z == b.z;
}

class ExactNarrowphase final : public Narrowphase {
 public:
  ExactNarrowphase() {
    capabilities_.distance = true;
    capabilities_.penetration = true;
    capabilities_.manifold = true;
    capabilities_.rounded_solids = true;
  }

  std::string_view name() const noexcept override { return "exact"; }
  const Capabilities& capabilities() const noexcept override { return capabilities_; }
  void build(std::span<const Hexahedron> solids) override { solids_ = {solids.begin(), solids.end()}; }
  bool set_solids(SolidIndex first, std::span<const Hexahedron> solids) override {
    if (first + solids.size() > solids_.size()) solids_.resize(first + solids.size(), solids.front());
    std::copy(solids.begin(), solids.end(), solids_.begin() + first);
    return true;
  }
  std::unique_ptr<Workspace> make_workspace() const override { return std::make_unique<Workspace>(); }

  void evaluate(const NarrowphaseInput& input, const NarrowphaseOutput& output,
                Workspace&) const noexcept override {
    assert(fits(input, output, solids_.size()));
    for (std::size_t i = 0; i < input.pairs.size(); ++i) {
      const SolidPair pair = input.pairs[i];
      if (!has_finite_poses(pair, input.poses)) {
        output.status[i] = PairStatus::failed;
        if (!output.geometry.empty()) output.geometry[i] = no_geometry();
        continue;
      }
      WorldVertices a, b;
      world_vertices(solids_[pair.a], input.poses[pair.a], a);
      world_vertices(solids_[pair.b], input.poses[pair.b], b);
      const double radius_a = solids_[pair.a].radius(), radius_b = solids_[pair.b].radius();
      if (input.query.kind == QueryKind::overlap) {
        output.status[i] =
            do_meet({a, radius_a}, {b, radius_b}) ? PairStatus::overlapping : PairStatus::separated;
        if (!output.geometry.empty()) output.geometry[i] = no_geometry();
        continue;
      }
      evaluate_pair(pair, {a, radius_a}, {b, radius_b}, input.query, output.status[i], output.geometry[i],
                    output.points_of(i, input.query));
    }
  }

 private:
  static bool do_meet(const RoundedHull& a, const RoundedHull& b) {
    if (a.radius == 0.0 && b.radius == 0.0) return exact_overlap(a.core_W, b.core_W);
    return exact_rounded_distance(a.core_W, a.radius, b.core_W, b.radius).pair_class != PairClass::separated;
  }

  static void evaluate_pair(SolidPair pair, const RoundedHull& a, const RoundedHull& b, const Query& query,
                            PairStatus& status, PairGeometry& geometry, std::span<ContactPoint> points) {
    ExactResult result = exact_rounded_distance(a.core_W, a.radius, b.core_W, b.radius);
    status = result.pair_class == PairClass::separated ? PairStatus::separated : PairStatus::overlapping;
    if (status == PairStatus::separated && result.separation > query.max_separation) {
      geometry = no_geometry(kInfinity);
      return;
    }
    // Two solids with the very same vertices: only their indices tell (a,b) from (b,a).
    if (pair.a > pair.b && same_vertices(a.core_W, b.core_W)) {
      result.n_AB_W = -result.n_AB_W;
      std::swap(result.p_A_W, result.p_B_W);
    }
    geometry = {result.separation, result.n_AB_W, result.p_A_W, result.p_B_W, 0};
    if (points.empty()) return;
    geometry.point_count = a.radius > 0.0 || b.radius > 0.0
                               ? find_rounded_points(a, b, geometry, query, points)
                               : fill_points(a.core_W, b.core_W, query, result, points);
  }

  // The witness pair comes first where no corner of the patch is as deep as it: an edge or a corner touches,
  // or the two faces do not lie over each other at all.
  static std::int32_t fill_points(const WorldVertices& a, const WorldVertices& b, const Query& query,
                                  const ExactResult& result, std::span<ContactPoint> points) {
    const double as_deep = result.separation + patch_rounding(a, b);
    const ContactPatch patch =
        part_within(find_contact_patch(a, b, result.n_AB_W), result.n_AB_W, point_limit(query, as_deep));
    double deepest = kInfinity;
    for (int k = 0; k < patch.vertex_count; ++k) deepest = std::min(deepest, patch.vertices[k].separation);
    if (deepest <= as_deep) return select_contact_points(patch, result.n_AB_W, points);
    points[0] = {result.p_A_W, result.p_B_W, result.separation, 0};
    return 1 + select_contact_points(patch, result.n_AB_W, points.subspan(1));
  }

  std::vector<Hexahedron> solids_;
  Capabilities capabilities_;
};

}  // namespace

void register_exact(BackendRegistry& registry) {
  registry.add(BackendRegistry::NarrowphaseEntry{
      "exact",
      std::string("decided in integers, the ground truth (GMP ") + gmp_version + ")",
      [] { return std::make_unique<ExactNarrowphase>(); },
      {}});
}

}  // namespace touchstone
