#pragma once

#include <memory>
#include <span>
#include <vector>

#include "touchstone/adapters/bullet/engine.hpp"
#include "touchstone/contact_core/geometry/hexahedron.hpp"

namespace touchstone::TOUCHSTONE_BULLET_NAMESPACE {

/// One solid as the engine holds it: a btBoxShape or a btConvexHullShape of its eight local vertices, margin
/// 0.
struct Shape {
  std::unique_ptr<btConvexShape> shape;
  bool is_box;
  double size;   ///< of the solid [m]
  double reach;  ///< largest distance of a vertex from the local origin [m]
};

/// @throws InputError naming the index of a solid that rounding to btScalar flattens or overflows.
std::vector<Shape> make_shapes(std::span<const Hexahedron> solids);

}  // namespace touchstone::TOUCHSTONE_BULLET_NAMESPACE
