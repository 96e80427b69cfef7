#include "touchstone/adapters/scene_files/facets.hpp"

#include <algorithm>
#include <array>

#include "touchstone/contact_core/input_error.hpp"

namespace touchstone::scene_files {
namespace {

std::string labelled(const std::string& name) { return "hexahedron '" + name + "'"; }

void require(bool holds, const std::string& name, const char* reason) {
  if (!holds) throw InputError(labelled(name) + ": " + reason);
}

}  // namespace

RoundPart make_ring(const RingSize& size, const Pose& X_OS, const std::string& name) {
  require(size.facets >= 3, name, "a ring needs at least 3 facets");
  require(size.facets <= 4096, name, "a ring has at most 4096 facets");
  require(size.inner_radius > 0.0 && size.outer_radius > size.inner_radius, name,
          "a ring needs 0 < inner_radius < outer_radius");
  require(size.height > 0.0, name, "a ring needs height > 0");
  return make_tube(size.outer_radius, size.inner_radius, size.height, size.facets, size.inscribed, X_OS,
                   name);
}

PlacedHexahedron make_frustum(const FrustumSize& size, const Pose& X_OS, const std::string& name) {
  require(size.height > 0.0, name, "a frustum needs height > 0");
  require(size.bottom_x > 0.0 && size.bottom_y > 0.0, name, "a frustum needs bottom half widths > 0");
  require(size.top_x >= 0.0 && size.top_y >= 0.0, name, "a frustum needs top half widths >= 0");
  std::array<Vector3, 8> v;
  for (int bits = 0; bits < 8; ++bits) {
    const double x = bits & 1 ? size.top_x : size.bottom_x;
    const double y = bits & 1 ? size.top_y : size.bottom_y;
    v[bits] = {bits & 4 ? x : -x, bits & 2 ? y : -y, bits & 1 ? size.height : 0.0};
  }
  return {name, Hexahedron::from_vertices(v, WarpPolicy::refuse, labelled(name)), X_OS};
}

std::vector<PlacedHexahedron> make_walls(const WallsSize& size, const Pose& X_OS, const std::string& name) {
  // Walls have a thickness, and room between them.
  constexpr std::array<const char*, 6> kSide = {"-x", "+x", "-y", "+y", "-z", "+z"};
  require(size.thickness > 0.0, name, "walls need thickness > 0");
  for (int axis = 0; axis < 3; ++axis)
    require(size.inner_size(axis) > 0.0, name, "walls need inner_size > 0");
  const auto is_open = [&](int side) {
    return std::find(size.open.begin(), size.open.end(), side) != size.open.end();
  };
  const Vector3 inner = 0.5 * size.inner_size;
  // The box spanned so far along each axis; a wall reaches over the sides of the axes after its own.
  std::vector<PlacedHexahedron> walls;
  for (int side = 0; side < 6; ++side) {
    if (is_open(side)) continue;
    const int axis = side / 2;
    Vector3 low = -inner;
    Vector3 high = inner;
    for (int other = axis + 1; other < 3; ++other) {
      if (!is_open(2 * other)) low(other) -= size.thickness;
      if (!is_open(2 * other + 1)) high(other) += size.thickness;
    }
    if (side % 2 == 0) {
      low(axis) = -inner(axis) - size.thickness;
      high(axis) = -inner(axis);
    } else {
      low(axis) = inner(axis);
      high(axis) = inner(axis) + size.thickness;
    }
    // A box about its own centre: engines that know boxes alone take walls, and boxes cost least.
    const Pose X_OB{Matrix3::Identity(), 0.5 * (low + high)};
    const std::string wall = name + "." + kSide[side];
    walls.push_back({wall, Hexahedron::from_size(high - low, labelled(wall)), compose(X_OS, X_OB)});
  }
  require(!walls.empty(), name, "walls: every side is open");
  return walls;
}

}  // namespace touchstone::scene_files
