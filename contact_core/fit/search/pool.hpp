#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "touchstone/contact_core/fit/space/six_planes.hpp"
#include "touchstone/contact_core/geometry/no_index.hpp"

// Private to contact_core/fit.

namespace touchstone::fit {

/// Some of all cells: cell i is bit i % 64 of word i / 64.
using CellBits = std::vector<std::uint64_t>;

inline void set(CellBits& cells, std::size_t i) { cells[i / 64] |= std::uint64_t{1} << (i % 64); }
inline bool has(const CellBits& cells, std::size_t i) { return (cells[i / 64] >> (i % 64) & 1) != 0; }

/// 64 cells, and which of them are held: those of a candidate are few, for cells are numbered by place.
struct HeldWord {
  std::uint32_t index;
  std::uint64_t bits;
  bool operator==(const HeldWord&) const = default;
};

/// A hexahedron that may be chosen.
struct Candidate {
  SixPlanes solid;
  std::vector<HeldWord> held;      ///< ascending
  std::size_t count = 0;           ///< of cells held
  std::uint32_t prism = kNoIndex;  ///< that it is a slab of: by that alone it keeps to what is allowed

  Candidate(const SixPlanes& hexahedron, std::span<const std::uint32_t> cells);
};

/// Candidates, and of each 64 cells those that hold some.
class CandidatePool {
 public:
  struct Holder {
    std::uint32_t candidate;
    std::uint64_t bits;  ///< of these 64 cells
  };
  explicit CandidatePool(std::size_t cells) : holders_((cells + 63) / 64) {}

  std::size_t size() const { return candidates_.size(); }
  const Candidate& operator[](std::size_t i) const { return candidates_[i]; }
  /// Ascending by candidate.
  std::span<const Holder> holders(std::size_t word) const { return holders_[word]; }
  /// Adds it, unless another one holds the same cells: most that grow in one place do, and are as good.
  void add(Candidate candidate);
  /// From now on this one holds nothing.
  void forget(std::size_t i);

 private:
  std::vector<Candidate> candidates_;
  std::vector<std::vector<Holder>> holders_;
  std::unordered_multimap<std::uint64_t, std::size_t> by_held_;  ///< by a hash of what they hold
};

/// Cells that nothing covers yet, and how many of them each candidate holds, kept while more are covered: so
/// a step costs what it changes. The pool may get more candidates meanwhile, and lose none.
class OpenCells {
 public:
  struct Best {
    std::size_t index, gain;
  };
  OpenCells(const CandidatePool& pool, CellBits open);

  std::size_t count() const { return count_; }
  bool empty() const { return count_ == 0; }
  /// The first open cell from one on, around the end; as many as there are where none is open.
  std::size_t next_from(std::size_t start, std::size_t cells) const;
  /// How many of them a hexahedron holds, be it in the pool or not.
  std::size_t held_by(const Candidate& candidate) const;
  /// The candidate that holds most, of equal ones the first; `gain` is 0 where none holds any.
  Best best();
  /// The same of those that hold a cell.
  Best best_at(std::size_t cell);
  /// They are covered from now on.
  void cover(const Candidate& candidate);

 private:
  void look_at_new();

  const CandidatePool& pool_;
  CellBits open_;
  std::size_t count_ = 0;
  std::vector<std::uint32_t> gains_;  ///< by candidate
};

}  // namespace touchstone::fit
