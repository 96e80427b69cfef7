#pragma once

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "touchstone/tests/support/random_solid.hpp"
#include "touchstone/tests/world/world_fixture.hpp"

// Levels of objects (ObjectDescription::levels) for tests.

namespace touchstone {

using Levels = std::vector<std::shared_ptr<const HexahedronTree>>;

/// A box along the object's axes that holds these, and as rounded as the roundest.
inline PlacedHexahedron box_about(std::span<const PlacedHexahedron> solids, const std::string& name) {
  constexpr double kMore = 1e-3;  // cores may be flat
  Vector3 low = Vector3::Constant(1e9), high = -low;
  double radius = 0.0;
  for (const PlacedHexahedron& placed : solids) {
    radius = std::max(radius, placed.solid.radius());
    for (const Vector3& p : placed.solid.vertices())
      low = low.cwiseMin(transform(placed.X_OS, p)), high = high.cwiseMax(transform(placed.X_OS, p));
  }
  low -= Vector3::Constant(kMore), high += Vector3::Constant(kMore);
  std::array<Vector3, 8> vertices;
  for (int i = 0; i < 8; ++i)
    vertices[i] = {(i & 4 ? high : low).x(), (i & 2 ? high : low).y(), (i & 1 ? high : low).z()};
  const Hexahedron box = Hexahedron::from_vertices(vertices);
  return {name, radius > 0.0 ? box.padded(radius) : box, Pose{}};
}

/// A box about each so many hexahedra, in their order, then one about all.
inline Levels levels_about(const HexahedronTree& tree, std::size_t at_once) {
  const std::span<const PlacedHexahedron> solids = tree.solids();
  std::vector<PlacedHexahedron> boxes;
  for (std::size_t first = 0; first < solids.size(); first += at_once)
    boxes.push_back(box_about(solids.subspan(first, std::min(at_once, solids.size() - first)),
                              "box " + std::to_string(first)));
  Levels out{std::make_shared<HexahedronTree>(boxes, tree.name())};
  out.push_back(std::make_shared<HexahedronTree>(
      std::vector<PlacedHexahedron>{box_about(boxes, "box about all")}, tree.name()));
  return out;
}

/// A crooked bar of 1.6 m in so many pieces of 4 to 14 cm, one after the other along x.
inline std::shared_ptr<const HexahedronTree> random_bar(Random& random, const std::string& name, int pieces) {
  std::vector<PlacedHexahedron> solids;
  for (int i = 0; i < pieces; ++i) {
    Pose X;
    X.R = rotation_about(Vector3::UnitZ(), random.uniform(-1, 1)) *
          rotation_about(Vector3::UnitX(), random.uniform(-1, 1));
    X.p = {1.6 * i / pieces - 0.8, 0.15 * std::sin(7.0 * i / pieces) + random.uniform(-0.1, 0.1),
           random.uniform(-0.1, 0.1)};
    const Hexahedron large = random_solid(random, 1.0);
    std::array<Vector3, 8> vertices = large.vertices();
    for (Vector3& p : vertices) p *= 0.1;
    solids.push_back(
        {"piece " + std::to_string(i), Hexahedron::from_vertices(vertices, WarpPolicy::accept), X});
  }
  return std::make_shared<HexahedronTree>(solids, name);
}

}  // namespace touchstone
