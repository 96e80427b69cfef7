#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "touchstone/contact_core/fit/mesh_distance.hpp"
#include "touchstone/contact_core/geometry/hexahedron_tree.hpp"
#include "touchstone/contact_core/geometry/pose.hpp"

namespace touchstone::fitting {

/// How another object went, seen from a mesh's frame T.
struct SeenObject {
  std::size_t object = 0;                ///< of the scene
  std::optional<std::size_t> mesh = {};  ///< of the request, where that object is served too
  std::vector<Bounds> parts_O;           ///< a box about each hexahedron, in the object's frame [m]
  std::vector<Pose> X_TO;                ///< in the order of time
  /// [i]: between X_TO[i - 1] and X_TO[i] no point of it is farther from where it is at one of both; [0]: 0
  /// [m].
  std::vector<double> strays;
};

/// A box about each hexahedron, with its radius.
std::vector<Bounds> part_boxes(const HexahedronTree& tree);

/// The places about a mesh that others come near, as cells of a grid.
class NearCells {
 public:
  /// @param beyond only cells within this of the mesh's solid count [m]
  NearCells(const MeshDistance& mesh, double beyond);

  /// From now on the cells count that the other comes within `by` of. [m]
  void add(const SeenObject& other, double by);
  /// Few boxes that together hold every cell that counts, with as few others of the mesh as that allows.
  std::vector<Bounds> boxes() const;

 private:
  struct Part;
  using Index = std::array<int, 3>;
  std::size_t at(const Index& cell) const {
    return (static_cast<std::size_t>(cell[0]) * counts_[1] + cell[1]) * counts_[2] + cell[2];
  }
  Vector3 corner(const Index& cell) const { return low_ + width_ * Vector3(cell[0], cell[1], cell[2]); }
  void mark(std::span<const Bounds> parts_O, const Pose& X_TO, double by);
  Part part_of(std::vector<Index> cells) const;
  std::size_t count_in(const Index& first, const Index& last) const;

  Vector3 low_;
  double width_;  ///< of a cell [m]
  Index counts_;
  std::vector<std::uint8_t> is_near_mesh_, is_marked_;
};

/// Whether the zones together hold all of the boxes that is within `margin` of where the other goes.
bool are_held(std::span<const Bounds> boxes, const SeenObject& other, double margin,
              std::span<const Bounds> zones);

}  // namespace touchstone::fitting
