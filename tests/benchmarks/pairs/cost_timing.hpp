#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "touchstone/contact_core/registry.hpp"

// Times of a pair of a family for a backend: hot, streamed and cold.
//
// Each pair is timed alone, less what the clock takes, and stands with the least of its repetitions, so that
// other work on the machine counts little; the median, 99th percentile and worst are over pairs. A batch has
// a mean only. Peers run their raw calls.

namespace touchstone {

/// [ns] a pair.
struct Costs {
  double mean, median, p99, worst;
};

struct CostRow {
  std::string family;  ///< of cost_table_families()
  QueryKind kind;
  std::string backend;
  bool is_batch = false;
  /// Of pairs that are apart only the class is asked, which is all that peers' manifolds give.
  bool contacts_only = false;
};

struct RowCosts {
  Costs hot;       ///< 256 pairs in turn
  Costs streamed;  ///< 16 384 pairs in the order of their solids in memory, which do not fit the caches
  Costs cold;      ///< the same in shuffled order
  /// Pairs of the hot set with another class than exact arithmetic gives; -1 where the build has none. A
  /// backend's own margins count as wrong, too.
  int wrong;
};

RowCosts measure_row(const BackendRegistry& registry, const CostRow& row);

/// What reading alone takes of a pair's time, without any arithmetic: one number of each cache line of the
/// poses, and of what native keeps of vertices and normals of general hexahedra, fetched ahead, in batches.
struct ReadingCosts {
  double hot, cold;  ///< of the pairs of RowCosts [ns]
};
ReadingCosts measure_reading(std::string_view family);

/// The names of backends that answer the query in raw calls: other libraries' checks.
std::vector<std::string> raw_peers(const BackendRegistry& registry, QueryKind kind);

}  // namespace touchstone
