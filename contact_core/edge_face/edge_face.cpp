#include "touchstone/contact_core/edge_face/edge_face.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <vector>

#include "touchstone/contact_core/narrowphase/no_geometry.hpp"
#include "touchstone/contact_core/narrowphase/validate.hpp"

namespace touchstone {
namespace {

// The paper's coefficients: A, B, C, D of each face's plane (equation 2), not normalised.
struct FacePlanes {
  std::array<double, 6> a, b, c, d;
};

// Equations 1A and 1B: the edges' start points and directions.
struct EdgeLines {
  std::array<double, 12> x, y, z, dx, dy, dz;
};

struct PlacedSolid {
  WorldVertices vertices;
  FacePlanes planes;
  EdgeLines edges;
};

Sphere vertex_sphere(const WorldVertices& v) {
  Sphere sphere{Vector3::Zero(), 0.0};
  for (int i = 0; i < 8; ++i) sphere.centre += 0.125 * v.vertex(i);
  for (int i = 0; i < 8; ++i) sphere.radius = std::max(sphere.radius, norm(v.vertex(i) - sphere.centre));
  return sphere;
}

void find_planes(const WorldVertices& v, FacePlanes& planes) {
  for (int f = 0; f < 6; ++f) {
    const auto& quad = Hexahedron::kFaceVertices[f];
    const Vector3 corner = v.vertex(quad[0]);
    const Vector3 normal = cross(v.vertex(quad[1]) - corner, v.vertex(quad[2]) - corner);
    planes.a[f] = normal.x(), planes.b[f] = normal.y(), planes.c[f] = normal.z();
    planes.d[f] = -dot(normal, corner);
  }
}

void find_edges(const WorldVertices& v, EdgeLines& edges) {
  for (int e = 0; e < 12; ++e) {
    const auto [start, end] = Hexahedron::kEdgeVertices[e];
    edges.x[e] = v.x[start], edges.y[e] = v.y[start], edges.z[e] = v.z[start];
    edges.dx[e] = v.x[end] - v.x[start], edges.dy[e] = v.y[end] - v.y[start],
    edges.dz[e] = v.z[end] - v.z[start];
  }
}

// The cross products of the polygon's edges with the vectors to the point all point the same way; zero counts
// as inside.
bool lies_in_face(const PlacedSolid& solid, int face, const Vector3& point) {
  const Vector3 normal(solid.planes.a[face], solid.planes.b[face], solid.planes.c[face]);
  const auto& quad = Hexahedron::kFaceVertices[face];
  bool along = false;
  bool against = false;
  for (int k = 0; k < 4; ++k) {
    const Vector3 corner = solid.vertices.vertex(quad[k]);
    const Vector3 side = solid.vertices.vertex(quad[(k + 1) & 3]) - corner;
    const double turn = dot(cross(side, point - corner), normal);
    along = along || turn > 0.0;
    against = against || turn < 0.0;
  }
  return !(along && against);
}

bool edges_cross_faces(const EdgeLines& edges, const PlacedSolid& solid) {
  const FacePlanes& planes = solid.planes;
  for (int f = 0; f < 6; ++f) {
    std::array<double, 12> t;
    for (int e = 0; e < 12; ++e) {
      const double height =
          ((planes.a[f] * edges.x[e] + planes.b[f] * edges.y[e]) + planes.c[f] * edges.z[e]) + planes.d[f];
      const double slope =
          (planes.a[f] * edges.dx[e] + planes.b[f] * edges.dy[e]) + planes.c[f] * edges.dz[e];
      // A parallel edge divides by zero: t is infinite or NaN, in no case within [0, 1].
      t[e] = -height / slope;
    }
    for (int e = 0; e < 12; ++e) {
      if (!(t[e] >= 0.0 && t[e] <= 1.0)) continue;
      const Vector3 point(edges.x[e] + t[e] * edges.dx[e], edges.y[e] + t[e] * edges.dy[e],
                          edges.z[e] + t[e] * edges.dz[e]);
      if (lies_in_face(solid, f, point)) return true;
    }
  }
  return false;
}

bool solids_meet(PlacedSolid& a, PlacedSolid& b) {
  const Sphere sphere_a = vertex_sphere(a.vertices);
  const Sphere sphere_b = vertex_sphere(b.vertices);
  if (!(norm(sphere_a.centre - sphere_b.centre) < sphere_a.radius + sphere_b.radius)) return false;
  find_edges(a.vertices, a.edges);
  find_planes(b.vertices, b.planes);
  if (edges_cross_faces(a.edges, b)) return true;
  find_edges(b.vertices, b.edges);
  find_planes(a.vertices, a.planes);
  return edges_cross_faces(b.edges, a);
}

class EdgeFace final : public Narrowphase {
 public:
  EdgeFace() {
    capabilities_.overlap_complete = false;
    // Where the method sees a contact at all: plane and crossing point of faces with angles between 30 and
    // 150 degrees are off by less than 32 roundings of the largest coordinate each.
    capabilities_.resolution.relative = 64 * std::numeric_limits<double>::epsilon();
  }

  std::string_view name() const noexcept override { return "edge_face"; }
  const Capabilities& capabilities() const noexcept override { return capabilities_; }
  void build(std::span<const Hexahedron> solids) override {
    refuse_rounded(solids, name());
    solids_ = {solids.begin(), solids.end()};
  }
  bool set_solids(SolidIndex first, std::span<const Hexahedron> solids) override {
    refuse_rounded(solids, name());
    if (first + solids.size() > solids_.size()) solids_.resize(first + solids.size(), solids.front());
    std::copy(solids.begin(), solids.end(), solids_.begin() + first);
    return true;
  }
  std::unique_ptr<Workspace> make_workspace() const override { return std::make_unique<Workspace>(); }

  void evaluate(const NarrowphaseInput& input, const NarrowphaseOutput& output,
                Workspace&) const noexcept override {
    assert(fits(input, output, solids_.size()));
    for (std::size_t i = 0; i < input.pairs.size(); ++i) {
      if (!output.geometry.empty()) output.geometry[i] = no_geometry();
      output.status[i] = input.query.kind == QueryKind::overlap ? check(input.pairs[i], input.poses)
                                                                : PairStatus::unsupported;
    }
  }

 private:
  PairStatus check(SolidPair pair, std::span<const Pose> poses) const noexcept {
    if (!has_finite_poses(pair, poses)) return PairStatus::failed;
    PlacedSolid a, b;
    world_vertices(solids_[pair.a], poses[pair.a], a.vertices);
    world_vertices(solids_[pair.b], poses[pair.b], b.vertices);
    return solids_meet(a, b) ? PairStatus::overlapping : PairStatus::separated;
  }

  std::vector<Hexahedron> solids_;
  Capabilities capabilities_;
};

}  // namespace

void register_edge_face(BackendRegistry& registry) {
  registry.add(BackendRegistry::NarrowphaseEntry{
      "edge_face",
      "the paper's first build: bounding spheres, then edges against faces; overlap only",
      [] { return std::make_unique<EdgeFace>(); },
      {}});
}

}  // namespace touchstone
