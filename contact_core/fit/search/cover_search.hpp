#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "touchstone/contact_core/fit/mesh_distance.hpp"
#include "touchstone/contact_core/fit/search/cells.hpp"
#include "touchstone/contact_core/fit/search/pool.hpp"
#include "touchstone/contact_core/fit/space/allowed_space.hpp"
#include "touchstone/contact_core/fit/space/growth.hpp"
#include "touchstone/contact_core/geometry/no_index.hpp"

// Private to contact_core/fit.

namespace touchstone::fit {

/// How hard to look: counts, not seconds, so that a run gives the same cover everywhere.
struct SearchEffort {
  int first_seeds = 24;    ///< cells that candidates grow from before the first choice
  int seeds_a_choice = 4;  ///< and before each further one
  int repairs = 400;       ///< times that a few hexahedra are taken out and their cells covered anew
  int checks = 12;         ///< times that hexahedra which a check refused are replaced
};

/// Nothing where a hexahedron keeps to what is allowed; else one of its points that does not.
using Check = std::function<std::optional<Vector3>(const SixPlanes&)>;

/// Prisms and rings, by index, with a piece that no hexahedron of theirs nor any other that was tried is
/// allowed to hold: what run() finds may go too far there. Each once.
struct Uncovered {
  std::vector<std::uint32_t> prisms, rings;
};

/// Finds few hexahedra that keep to a space and together hold every cell.
///
/// Candidates grow from cells that are not covered yet, in several frames and orders; greedily the one that
/// covers most is chosen; then some are taken out and the hole is covered by fewer, where that can be; at
/// last fewer are looked for among all candidates.
class CoverSearch {
 public:
  CoverSearch(const MeshDistance& mesh, const Cells& cells, AllowedSpace& space, double over,
              std::span<const Sectors> sectors, std::span<const Prism> prisms, const SearchEffort& effort,
              const std::function<void(double)>& progress);

  /// @return hexahedra that hold all cells, each shrunk to what it alone must hold.
  /// Each at least `thinnest` thick, less where a smaller error is allowed, by as much, and with its faces
  /// `margin` outside [m]. Those that `check` refuses are replaced: what it names is then out of bounds.
  std::vector<SixPlanes> run(double thinnest, double margin, const Check& check);
  const Uncovered& uncovered() const { return uncovered_; }

 private:
  struct Window {
    std::size_t first, last;  ///< strips of a prism
  };

  void grow_from(std::size_t cell);
  bool grow_prism(std::size_t cell);
  std::vector<Window> windows(std::size_t cell, double limit) const;
  std::vector<Vector3> points_of(std::uint32_t prism, const Window& strips, std::size_t first_piece,
                                 std::size_t last_piece) const;
  bool is_about(std::uint32_t prism, const SixPlanes& solid) const;
  bool may_be(const Candidate& candidate, const SixPlanes& instead);
  void grow_sectors(const Sectors& sectors);
  bool grow_ring(std::size_t cell);
  bool grow_sector(const Sectors& sectors, int sector, std::span<const Vector3> points);
  std::vector<Vector3> points_of_sector(std::uint32_t ring, std::uint32_t sector) const;
  double limit_of(std::size_t cell) const;
  Candidate candidate(const SixPlanes& solid) const;
  std::vector<Normals> frames_at(std::size_t cell) const;
  void replace(std::vector<std::size_t>& chosen, std::span<const Vector3> refused);
  void look_for_fewer(std::vector<std::size_t>& chosen, int repairs);
  std::size_t some_open(const OpenCells& open);
  void choose(std::vector<std::size_t>& chosen, OpenCells& open, int seeds, std::size_t most_chosen);
  void improve_best(std::size_t index, const OpenCells& open);
  CellBits left_by(std::span<const std::size_t> chosen) const;
  void drop_redundant(std::vector<std::size_t>& chosen) const;
  bool repair(std::vector<std::size_t>& chosen);
  std::vector<std::vector<std::uint32_t>> pool_as_sets(std::size_t& elements);
  void choose_again(std::vector<std::size_t>& chosen, std::uint64_t work);
  /// The points that each chosen one has to hold: all cells are shared out.
  std::vector<std::vector<Vector3>> share_out(const std::vector<std::size_t>& chosen) const;
  std::vector<SixPlanes> shrunk(const std::vector<std::size_t>& chosen, double thinnest);
  std::uint64_t random();
  /// Says how much is done, as often as anything is chosen: the caller may throw to end the search.
  void tick(double done);

  const MeshDistance& mesh_;
  const Cells& cells_;
  AllowedSpace& space_;
  std::span<const Sectors> sectors_;
  std::span<const Prism> prisms_;
  std::vector<std::size_t> first_of_prism_;  ///< cell: strip by strip, each piece by piece; then the end
  double over_;
  Growth growth_;
  SearchEffort effort_;
  const std::function<void(double)>& progress_;  ///< of a share from 0 to 1; may be empty
  std::vector<Normals> main_frames_;
  CandidatePool pool_;
  CellBits all_;
  CellBits settled_;  ///< cells that sectors of rings hold: what grows from them gains nothing
  Uncovered uncovered_;
  std::uint64_t state_ = 88172645463325252U;
  double done_ = 0.0;  ///< as said last
};

}  // namespace touchstone::fit
