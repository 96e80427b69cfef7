#include "tests/backend_suite/suite.hpp"

#include <algorithm>

namespace touchstone::suite {

const BackendRegistry& backends() {
  static const BackendRegistry registry = [] {
    BackendRegistry filled;
    register_suite_backends(filled);
    return filled;
  }();
  return registry;
}

std::vector<std::string> narrowphase_names() {
  std::vector<std::string> names;
  for (const BackendRegistry::NarrowphaseEntry& entry : backends().narrowphases())
    names.push_back(entry.name);
  return names;
}

std::vector<std::string> broadphase_names() {
  std::vector<std::string> names;
  for (const BackendRegistry::BroadphaseEntry& entry : backends().broadphases()) names.push_back(entry.name);
  return names;
}

Answer ask(Narrowphase& narrowphase, const Body& a, const Body& b, const Query& query) {
  const std::array solids = {a.solid, b.solid};
  const std::array poses = {a.X_WS, b.X_WS};
  const std::array pairs = {SolidPair{0, 1}};
  narrowphase.build(solids);
  const auto workspace = narrowphase.make_workspace();
  std::array<PairStatus, 1> status{};
  std::array<PairGeometry, 1> geometry{};
  std::vector<ContactPoint> points(query.kind == QueryKind::manifold ? query.max_points : 0);
  narrowphase.evaluate({.pairs = pairs, .poses = poses, .query = query},
                       {.status = status, .geometry = geometry, .points = points}, *workspace);
  Answer answer{status[0], geometry[0], {}};
  if (query.kind == QueryKind::manifold)
    answer.points.assign(points.begin(),
                         points.begin() + std::clamp(geometry[0].point_count, 0, query.max_points));
  return answer;
}

Body box(const Vector3& size, const Pose& X_WS) { return {Hexahedron::from_size(size), X_WS}; }

Body box_at(const Vector3& size, const Vector3& p) {
  Pose X_WS;
  X_WS.p = p;
  return box(size, X_WS);
}

Body sheared_cube(double shear, const Pose& X_WS) {
  std::array<Vector3, 8> vertices = Hexahedron::from_size({2.0, 2.0, 2.0}).vertices();
  for (Vector3& v : vertices) v.x() += shear * v.z();
  return {Hexahedron::from_vertices(vertices), X_WS};
}

Body as_hexahedron(const Body& body) { return {Hexahedron::from_vertices(body.solid.vertices()), body.X_WS}; }

Body moved(const Body& body, const Pose& X_VW) { return {body.solid, compose(X_VW, body.X_WS)}; }

double scale_of(const Body& a, const Body& b) {
  WorldVertices va, vb;
  world_vertices(a.solid, a.X_WS, va);
  world_vertices(b.solid, b.X_WS, vb);
  return std::max({a.solid.size(), b.solid.size(), largest_coordinate(va), largest_coordinate(vb)});
}

bool gives_distance(const Capabilities& capabilities, double exact_separation) {
  return exact_separation > 0.0 ? capabilities.distance : capabilities.penetration;
}

}  // namespace touchstone::suite
