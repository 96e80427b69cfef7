#include "touchstone/examples/measures/pairs/drawn_solids.hpp"

namespace touchstone::measures {

Hexahedron random_box(Random& random) {
  return Hexahedron::from_size({random.uniform(0.2, 2), random.uniform(0.2, 2), random.uniform(0.2, 2)});
}

std::array<Vector3, 8> box_vertices(const Vector3& half) {
  std::array<Vector3, 8> vertices;
  for (int i = 0; i < 8; ++i) {
    vertices[i] = {i & 4 ? half.x() : -half.x(), i & 2 ? half.y() : -half.y(), i & 1 ? half.z() : -half.z()};
  }
  return vertices;
}

Vector3 dyadic_half(Random& random) {
  return {random.dyadic(0.125, 1, 6), random.dyadic(0.125, 1, 6), random.dyadic(0.125, 1, 6)};
}

// Coordinates are multiples of 2^-12, so the faces are exactly plane before they are posed.
Hexahedron sheared_box(Random& random) {
  auto vertices = box_vertices(dyadic_half(random));
  const double xy = random.dyadic(-1, 1, 6), xz = random.dyadic(-1, 1, 6), yz = random.dyadic(-1, 1, 6);
  for (Vector3& v : vertices) v = {(v.x() + xy * v.y()) + xz * v.z(), v.y() + yz * v.z(), v.z()};
  return Hexahedron::from_vertices(vertices);
}

// A frustum with a rectangular base, its top shrunk in x and y and moved sideways: side faces stay plane.
Hexahedron tapered_box(Random& random) {
  auto vertices = box_vertices(dyadic_half(random));
  const double sx = random.dyadic(0.25, 1, 6), sy = random.dyadic(0.25, 1, 6);
  const double dx = random.dyadic(-0.5, 0.5, 6), dy = random.dyadic(-0.5, 0.5, 6);
  for (Vector3& v : vertices) {
    if (v.z() > 0) v = {sx * v.x() + dx, sy * v.y() + dy, v.z()};
  }
  return Hexahedron::from_vertices(vertices);
}

// One side (slab) or two sides (needle) 1e-2 to 1e-6 of the others.
Hexahedron thin_box(Random& random) {
  Vector3 size = uniform_vector(random, 0.5, 2);
  const std::uint32_t axis = random.below(3);
  const double thinness = random.binary_scale(-20, -7);
  if (random.below(2) == 0) {
    size[axis] *= thinness;
  } else {
    size[(axis + 1) % 3] *= thinness;
    size[(axis + 2) % 3] *= thinness;
  }
  return Hexahedron::from_size(size);
}

}  // namespace touchstone::measures
