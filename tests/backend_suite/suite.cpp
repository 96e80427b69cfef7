#include "touchstone/tests/backend_suite/suite.hpp"

#include "touchstone/tests/support/scale_of.hpp"

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
  narrowphase.build(solids);
  return touchstone::ask(narrowphase, std::array{a.X_WS, b.X_WS}, query);
}

Body box(const Vector3& size, const Pose& X_WS) { return {Hexahedron::from_size(size), X_WS}; }

Body box_at(const Vector3& size, const Vector3& p) { return box(size, at(p.x(), p.y(), p.z())); }

Body sheared_cube(double shear, const Pose& X_WS) {
  std::array<Vector3, 8> vertices = Hexahedron::from_size({2.0, 2.0, 2.0}).vertices();
  for (Vector3& v : vertices) v.x() += shear * v.z();
  return {Hexahedron::from_vertices(vertices), X_WS};
}

Body as_hexahedron(const Body& body) { return {Hexahedron::from_vertices(body.solid.vertices()), body.X_WS}; }

Body moved(const Body& body, const Pose& X_VW) { return {body.solid, compose(X_VW, body.X_WS)}; }

double scale_of(const Body& a, const Body& b) {
  return touchstone::scale_of(a.solid, a.X_WS, b.solid, b.X_WS);
}

bool gives_distance(const Capabilities& capabilities, double exact_separation) {
  return exact_separation > 0.0 ? capabilities.distance : capabilities.penetration;
}

}  // namespace touchstone::suite
