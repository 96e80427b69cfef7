#pragma once

#include <string>
#include <vector>

#include "touchstone/contact_core/registry.hpp"
#include "touchstone/examples/measures/common/quantiles.hpp"
#include "touchstone/examples/measures/pairs/pair_set.hpp"

namespace touchstone::measures {

/// One backend's distance query (overlap, of a backend without separations) of a whole set, in batches on
/// several threads.
struct ThreadResult {
  std::string backend;
  QueryKind query = QueryKind::distance;
  int threads = 1;
  std::size_t pairs = 0;
  Timing pass;      ///< by the wall's clock [ns a pair]: of whole passes over the set
  std::string gap;  ///< why it was not run
  /// Wrong or missing answers to that query in the set, where they were judged.
  std::size_t wrong = 0;
};

struct ThreadOptions {
  std::vector<int> threads = {1, 2};
  int passes = 9;
  std::size_t batch = 32;
};
/// 1, 2, 4, ... up to the machine's hardware threads, and always 1 and 2.
std::vector<int> thread_counts();

/// Passes of all backends and counts in turn, so that a machine that slows down slows all of them.
std::vector<ThreadResult> run_threads(std::span<const BackendRegistry::NarrowphaseEntry* const> backends,
                                      const PairSet& set, const ThreadOptions& options);

}  // namespace touchstone::measures
