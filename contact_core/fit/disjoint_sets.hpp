#pragma once

#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

// Private to this folder.

namespace touchstone {

/// Numbers in sets that are joined; a set is known by its least (Tarjan, JACM 22(2), 1975; paths halved).
class DisjointSets {
 public:
  explicit DisjointSets(std::size_t count) : parents_(count) {
    std::iota(parents_.begin(), parents_.end(), std::uint32_t{0});
  }

  std::uint32_t least_of(std::uint32_t i) {
    while (parents_[i] != i) i = parents_[i] = parents_[parents_[i]];
    return i;
  }
  void join(std::uint32_t i, std::uint32_t j) {
    i = least_of(i), j = least_of(j);
    if (j < i) std::swap(i, j);
    parents_[j] = i;
  }

 private:
  std::vector<std::uint32_t> parents_;
};

}  // namespace touchstone
