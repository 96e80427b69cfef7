#pragma once

#include <cstddef>
#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

// Private to the project: sets of numbers that are joined one pair at a time (union-find: Tarjan, Efficiency
// of a Good But Not Linear Set Union Algorithm, JACM 22(2), 1975; here with path halving).

namespace touchstone {

/// Each set is known by its least number.
class DisjointSets {
 public:
  DisjointSets() = default;
  /// Every number below `count` is a set.
  explicit DisjointSets(std::size_t count) : parents_(count) {
    std::iota(parents_.begin(), parents_.end(), std::uint32_t{0});
  }

  void reserve(std::size_t count) { parents_.reserve(count); }
  /// Room for numbers that are then made single().
  void resize(std::size_t count) { parents_.resize(count); }
  void single(std::uint32_t i) { parents_[i] = i; }

  void join(std::uint32_t i, std::uint32_t j) {
    i = least_of(i), j = least_of(j);
    if (j < i) std::swap(i, j);
    parents_[j] = i;
  }
  std::uint32_t least_of(std::uint32_t i) {
    while (parents_[i] != i) i = parents_[i] = parents_[parents_[i]];
    return i;
  }

 private:
  std::vector<std::uint32_t> parents_;
};

}  // namespace touchstone
