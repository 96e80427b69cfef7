#include "separating_axes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/narrowphase/no_geometry.hpp"

namespace {

using namespace touchstone;

constexpr double kEps = std::numeric_limits<double>::epsilon();
/// Edges closer to parallel than this [rad] give no axis: rounding would turn it.
constexpr double kLeastAngle = 1e-6;

struct Interval {
  double low = kInfinity, high = -low;
};

/// A solid placed about a common origin near the pair, so that coordinates are as small as the solids allow.
struct Placed {
  std::array<Vector3, 8> vertices;
  std::array<Vector3, 6> normals;
  std::array<Vector3, 12> edges;  ///< unit; zero where the edge has no length
  double reach = 0.0;             ///< largest |coordinate| [m]

  Placed(const Hexahedron& solid, const Pose& X_WS, const Vector3& origin_W) {
    const Vector3 p = X_WS.p - origin_W;
    for (int i = 0; i < 8; ++i) {
      vertices[i] = X_WS.R * solid.vertices()[i] + p;
      reach = std::max(reach, vertices[i].cwiseAbs().maxCoeff());
    }
    for (int f = 0; f < 6; ++f) normals[f] = X_WS.R * solid.face_plane(f).normal;
    std::size_t e = 0;
    for (const auto& [from, to] : Hexahedron::kEdgeVertices) {
      const Vector3 edge = vertices[to] - vertices[from];
      const double length = edge.norm();
      edges[e++] = length > 0.0 ? Vector3(edge / length) : Vector3(Vector3::Zero());
    }
  }

  Interval along(const Vector3& n) const {
    Interval out;
    for (const Vector3& v : vertices) {
      const double x = n.dot(v);
      out.low = std::min(out.low, x);
      out.high = std::max(out.high, x);
    }
    return out;
  }
};

double gap_along(const Placed& a, const Placed& b, const Vector3& n) {
  const Interval of_a = a.along(n), of_b = b.along(n);
  return std::max(of_b.low - of_a.high, of_a.low - of_b.high);
}

PairStatus check(const Placed& a, const Placed& b, double moved_by) {
  const double size = std::max(a.reach, b.reach);
  // Dot products of three terms, of vertices that posing rounded: a few eps of the coordinates each.
  const double rounding = 16.0 * kEps * size + 4.0 * kEps * moved_by;
  double widest = -kInfinity;
  for (const Placed* solid : {&a, &b}) {
    for (const Vector3& n : solid->normals) {
      const double gap = gap_along(a, b, n);
      if (gap > rounding) return PairStatus::separated;
      widest = std::max(widest, gap);
    }
  }
  for (const Vector3& edge_a : a.edges) {
    for (const Vector3& edge_b : b.edges) {
      const Vector3 axis = cross(edge_a, edge_b);
      const double sine = norm(axis);
      if (sine < kLeastAngle) continue;  // also of edges without length
      const double gap = gap_along(a, b, axis / sine);
      if (gap > rounding / sine) return PairStatus::separated;
      widest = std::max(widest, gap);
    }
  }
  // An axis that was left out lies within kLeastAngle of an arc between two face normals, on which the
  // overlap is least at an end: it can be less than the least found by that angle times the way across both
  // solids.
  const double left_out = rounding + 4.0 * kLeastAngle * size;
  return widest < -left_out ? PairStatus::overlapping : PairStatus::undecided;
}

class SeparatingAxes final : public Narrowphase {
 public:
  SeparatingAxes() {
    capabilities_.resolution = {0.0, 1e-5};
  }  // distance, penetration, manifold: not offered

  std::string_view name() const noexcept override { return "separating_axes"; }
  const Capabilities& capabilities() const noexcept override { return capabilities_; }
  void build(std::span<const Hexahedron> solids) override {
    refuse_rounded(solids, name());
    solids_.assign(solids.begin(), solids.end());
  }
  std::unique_ptr<Workspace> make_workspace() const override { return std::make_unique<Workspace>(); }

  void evaluate(const NarrowphaseInput& input, const NarrowphaseOutput& output,
                Workspace&) const noexcept override {
    for (std::size_t i = 0; i < input.pairs.size(); ++i) {
      output.status[i] =
          input.query.kind == QueryKind::overlap ? answer(input, input.pairs[i]) : PairStatus::unsupported;
      if (!output.geometry.empty()) output.geometry[i] = no_geometry();
    }
  }

 private:
  PairStatus answer(const NarrowphaseInput& input, SolidPair pair) const noexcept {
    if (!has_finite_poses(pair, input.poses)) return PairStatus::failed;
    const Pose &X_WA = input.poses[pair.a], &X_WB = input.poses[pair.b];
    const double moved_by = std::max(X_WA.p.cwiseAbs().maxCoeff(), X_WB.p.cwiseAbs().maxCoeff());
    return check(Placed(solids_[pair.a], X_WA, X_WA.p), Placed(solids_[pair.b], X_WB, X_WA.p), moved_by);
  }

  std::vector<Hexahedron> solids_;
  Capabilities capabilities_;
};

}  // namespace

void register_separating_axes(BackendRegistry& registry) {
  registry.add(BackendRegistry::NarrowphaseEntry{"separating_axes",
                                                 "face normals and crossed edges; overlap only",
                                                 [] { return std::make_unique<SeparatingAxes>(); },
                                                 {}});
}
