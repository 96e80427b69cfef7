#pragma once

#include <algorithm>
#include <array>
#include <limits>
#include <vector>

#include "touchstone/contact_core/broadphase/broadphase.hpp"
#include "touchstone/contact_core/memory/growing_list.hpp"

namespace touchstone {

/// The spheres that every broadphase here copies out of its input.
struct SolidTable {
  GrowingList<Sphere> sphere_S;            ///< one a solid, in the solid's frame
  GrowingList<std::uint32_t> first_solid;  ///< one an object, and the number of solids at the end
  GrowingList<std::uint32_t> object_of;    ///< one a solid
  GrowingList<std::uint8_t> is_static;     ///< one an object
  GrowingList<std::uint8_t> is_gone;       ///< one an object: its solids are in no pair

  std::uint32_t objects() const { return static_cast<std::uint32_t>(first_solid.size()) - 1; }
  std::uint32_t solids() const { return first_solid.back(); }
};

/// @throws InputError on a null tree, a margin that is negative or not finite, or a number of flags that is
/// neither 0 nor the number of trees.
SolidTable make_solid_table(const BroadphaseInput& input);

/// See Broadphase::set_object(). @throws InputError for a tree with another number of solids than the one it
/// replaces.
void set_object(SolidTable& table, std::uint32_t object, const HexahedronTree* tree, bool is_static);

/// A sphere that encloses the solid's world vertices, as rounded by world_vertices(), for every valid pose.
Sphere world_sphere(const Sphere& sphere_S, const Pose& X_WS);

/// A sphere around two spheres, rounding covered. Not finite when either is not.
Sphere enclosing_sphere(const Sphere& a, const Sphere& b);

/// Axis-aligned, in world [m].
struct Box {
  std::array<double, 3> low, high;
};

/// Contains the sphere grown by `margin`; infinite when the sphere is not finite. Generous enough that boxes
/// grown by half of may_touch()'s margin overlap wherever it returns true.
Box bounding_box(const Sphere& sphere, double margin);

/// The least box that contains both.
inline Box union_of(const Box& a, const Box& b) {
  Box box;
  for (std::size_t i = 0; i < 3; ++i)
    box.low[i] = std::min(a.low[i], b.low[i]), box.high[i] = std::max(a.high[i], b.high[i]);
  return box;
}

/// Closed boxes: touching is overlap. False where a bound is NaN.
inline bool overlap(const Box& a, const Box& b) {
  bool all = true;
  for (std::size_t i = 0; i < 3; ++i) all = all && a.low[i] <= b.high[i] && b.low[i] <= a.high[i];
  return all;
}

/// False only when the spheres are more than `margin` apart. Not-finite spheres may touch everything.
inline bool may_touch(const Sphere& a, const Sphere& b, double margin) {
  // At most 4 roundings in the squared distance, 2 in the reach and 1 in its square; DBL_MIN covers what
  // underflows.
  const double dx = a.centre.x() - b.centre.x();
  const double dy = a.centre.y() - b.centre.y();
  const double dz = a.centre.z() - b.centre.z();
  const double reach = ((a.radius + b.radius) + margin) * (1.0 + 8 * std::numeric_limits<double>::epsilon());
  return !((dx * dx + dy * dy) + dz * dz > reach * reach + std::numeric_limits<double>::min());
}

}  // namespace touchstone
