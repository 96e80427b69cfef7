#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "touchstone/contact_core/geometry/hexahedron_tree.hpp"

namespace touchstone {

/// Bounds of a rigid object's hexahedra, from one about all of them down to themselves: a binary tree of
/// spheres, some of whose nodes also have a coarser hexahedron that the user gave
/// (ObjectDescription::levels). Every bound holds all hexahedra below it, so where two bounds are apart, all
/// below them are.
class ObjectLevels {
 public:
  /// A coarser hexahedron in the object's frame O.
  struct Shape {
    WorldVertices vertices_O;
    std::array<Vector3, 6> normals_O;  ///< of its faces; zero: collapsed
    double radius;                     ///< [m]
  };
  /// Below an inner node is a pair of nodes, a leaf holds a solid.
  struct Node {
    Sphere sphere_O;          ///< encloses all hexahedra below, to rounding
    std::int32_t shape = -1;  ///< index into shapes(); -1: none
    std::int32_t left = -1;   ///< node index; -1 at a leaf
    std::int32_t right = -1;  ///< as left
    std::int32_t solid = -1;  ///< index into the tree's solids(); -1 at an inner node
  };

  /// @param levels finest first: as ObjectDescription::levels.
  /// @throws InputError naming the object, the level and the hexahedron: one that lies in no hexahedron of
  /// the next level, judged exactly in the object's frame.
  ObjectLevels(const HexahedronTree& tree, std::span<const std::shared_ptr<const HexahedronTree>> levels);

  const std::vector<Node>& nodes() const { return nodes_; }  ///< node 0 is the root
  const std::vector<Shape>& shapes() const { return shapes_; }
  /// One box about all hexahedra: what broadphases see of the object.
  const HexahedronTree& box() const { return box_; }
  /// About all hexahedra: that of the box.
  const Sphere& sphere_O() const { return sphere_O_; }
  /// No solid's sphere reaches further from the object's origin, its own frame's origin taken along [m].
  double extent() const { return extent_; }
  /// The mean radius of the hexahedra's spheres [m].
  double mean_radius() const { return mean_radius_; }

 private:
  using Corners = std::vector<Sphere>;
  using Members = std::vector<std::vector<std::int32_t>>;  // by hexahedron of a level: those that it holds

  std::int32_t build(std::size_t level, std::span<std::int32_t> hexahedra);
  std::int32_t build_below(std::size_t level, std::int32_t hexahedron);
  Sphere sphere_about(std::size_t first_placed) const;

  std::vector<Node> nodes_;
  std::vector<Shape> shapes_;
  HexahedronTree box_;
  Sphere sphere_O_;
  double extent_ = 0.0, mean_radius_ = 0.0;

  // While nodes are built.
  std::vector<std::vector<Corners>> corners_;  // by level, 0 the solids', and hexahedron
  std::vector<Members> members_;               // by level above 0
  std::vector<const HexahedronTree*> trees_;   // by level
  std::vector<std::int32_t> placed_;           // solids so far: those below a node come one after the other
};

}  // namespace touchstone
