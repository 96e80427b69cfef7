#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "touchstone/contact_core/geometry/hexahedron.hpp"

namespace touchstone {

/// One hexahedron placed in its object's frame O.
struct PlacedHexahedron {
  std::string name;
  Hexahedron solid;
  Pose X_OS;
};

/// The paper's object: a binary tree over the hexahedra of one rigid object, rounded ones too. Each node's
/// sphere encloses all below it.
class HexahedronTree {
 public:
  /// A leaf holds one solid, an inner node two children.
  struct Node {
    Sphere sphere_O;  ///< in the object's frame, encloses every world vertex below to rounding, see .cpp
    std::int32_t left = -1;  ///< node index; -1 at a leaf
    std::int32_t right = -1;
    std::int32_t solid = -1;  ///< index into solids(); -1 at an inner node
  };

  /// Splits at the median of the longest side of the centres' box. Node 0 is the root.
  /// @throws InputError when there is no hexahedron, a name occurs twice or a pose is no rigid transform.
  explicit HexahedronTree(std::vector<PlacedHexahedron> solids, std::string name = "object");

  /// Takes the tree from the user: `left`, `right` and `solid` of the nodes of `layout`, whose node 0 is the
  /// root. The spheres are computed here. nodes() has the same tree, every node before its children, the left
  /// ones first.
  /// @throws InputError as above, and naming the node: an invalid index, a solid beside children, a node
  /// or solid that is reached twice or never, more than kMostLevels levels.
  HexahedronTree(std::vector<PlacedHexahedron> solids, std::span<const Node> layout,
                 std::string name = "object");
  static constexpr int kMostLevels = 1000;  ///< trees are walked by recursion

  const std::string& name() const { return name_; }
  const std::vector<PlacedHexahedron>& solids() const { return solids_; }
  const std::vector<Node>& nodes() const { return nodes_; }

 private:
  std::vector<std::vector<Sphere>> checked_corners() const;

  std::string name_;
  std::vector<PlacedHexahedron> solids_;
  std::vector<Node> nodes_;
};

/// The paper's Find_global_position: walks the tree and writes each hexahedron's world pose X_WS = X_WO *
/// X_OS.
/// @pre out.size() == tree.solids().size()
void find_global_positions(const HexahedronTree& tree, const Pose& X_WO, std::span<Pose> out);

/// Like refuse_rounded() for solids; the error names the object and the hexahedron.
/// @param user who refuses ("backend 'bullet'").
void refuse_rounded(const HexahedronTree& tree, std::string_view user);

}  // namespace touchstone
