#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "touchstone/adapters/cover_proof/cover_proof.hpp"
#include "touchstone/adapters/cover_proof/exact_cover.hpp"
#include "touchstone/adapters/cover_proof/solid_side.hpp"

// Private to this folder.

namespace touchstone::cover_proof {

/// Proves that no point of hulls is farther from a solid than a limit.
class ExcessProof {
 public:
  /// @param margin of all distances, against rounding [m]
  ExcessProof(const TriangleBoxes& surface, const SolidSide& solid, double margin, std::size_t most_pieces)
      : surface_(surface), solid_(solid), margin_(margin), most_pieces_(most_pieces) {}

  /// @param region only points in it count; nullptr: all
  /// @return empty when proven; else why not, with a point.
  std::string prove(const Hull& hull, const std::array<Vector3, 8>& vertices, double limit,
                    const CoverClaim::Region* region);
  std::size_t pieces() const { return pieces_; }

 private:
  using Tetrahedron = std::array<Vector3, 4>;
  enum class Finding { within, beyond, open };
  /// What is known of a corner: pieces that meet in it share that.
  struct Corner {
    Vector3 p = Vector3::Zero();
    std::uint32_t triangle = 0;  ///< the nearest to it
    double distance = -1.0;      ///< to that [m]; below 0: not asked yet
    std::optional<bool> is_inside = {};
  };
  struct Piece {
    std::array<Corner, 4> corners;
    std::uint32_t hint;
    Tetrahedron points() const { return {corners[0].p, corners[1].p, corners[2].p, corners[3].p}; }
  };
  Finding look_at(Piece& piece);
  void find_nearest(Corner& corner, std::uint32_t hint) const;
  bool is_within_one(const Tetrahedron& piece, std::uint32_t triangle) const;
  bool is_within_solid(Piece& piece) const;
  std::optional<std::vector<std::uint32_t>> met_by(const Tetrahedron& piece) const;
  std::size_t groups_of_backs(const Vector3& from, const std::vector<std::uint32_t>& met) const;
  bool is_solid(const Tetrahedron& piece) const;
  bool is_beside(const Tetrahedron& piece) const;
  bool is_beyond(const Corner& corner);

  const TriangleBoxes& surface_;
  const SolidSide& solid_;
  double margin_;
  std::size_t most_pieces_;
  std::size_t pieces_ = 0;
  double limit_ = 0.0;
  const CoverClaim::Region* region_ = nullptr;
  Vector3 beyond_ = Vector3::Zero();
};

}  // namespace touchstone::cover_proof
