#pragma once

#include <cstddef>
#include <string>

namespace touchstone::comparison {

/// One of n parts of a run, counted from 1: of every set the pairs k - 1, k - 1 + n, k - 1 + 2 n, ...
struct Shard {
  std::size_t k = 1, n = 1;

  /// As --shard takes it: "3/8".
  std::string text() const { return std::to_string(k) + "/" + std::to_string(n); }
  bool operator==(const Shard&) const = default;
  /// Of a set's cases those that it has.
  std::size_t cases_of(std::size_t cases) const { return cases < k ? 0 : (cases - k) / n + 1; }
};

/// More shards than a run is cut into.
inline constexpr std::size_t kMostShards = 100000;

}  // namespace touchstone::comparison
