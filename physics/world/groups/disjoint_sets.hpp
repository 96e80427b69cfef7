#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

// Sets of units that are joined one pair at a time (union-find: Tarjan, Efficiency of a Good But Not Linear
// Set Union Algorithm, 1975; here with path halving).

namespace touchstone::physics::stepping {

/// Each set is named by its leader, one of its units.
class DisjointSets {
 public:
  void reserve(std::size_t units) { leader_.reserve(units); }
  /// Room for units that are then made single().
  void resize(std::size_t units) { leader_.resize(units); }
  void single(std::uint32_t unit) { leader_[unit] = unit; }
  void join(std::uint32_t a, std::uint32_t b) { leader_[leader_of(b)] = leader_of(a); }
  std::uint32_t leader_of(std::uint32_t unit) {
    while (leader_[unit] != unit) unit = leader_[unit] = leader_[leader_[unit]];
    return unit;
  }

 private:
  std::vector<std::uint32_t> leader_;
};

}  // namespace touchstone::physics::stepping
