#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "touchstone/contact_core/narrowphase/narrowphase.hpp"

// Millions of pairs: class and sign held against the second method (class_settler.hpp), the signed distance
// of a sample against the `exact` adapter, whose class must also be the second method's.

namespace touchstone::proof {

struct LongRunOptions {
  std::uint64_t seed = 1;
  std::size_t count = 10'000'000;          ///< pairs, shared evenly by the families (rounded up)
  std::size_t distances = 150'000;         ///< of these with their distance compared, shared evenly
  std::vector<std::size_t> families = {};  ///< indices; empty: all
  int threads = 2;
  const std::atomic<bool>* stop = nullptr;  ///< set: end early, with what is done
};

/// Units in the last place between native's distance and exact's: 0, 1, 2, up to 4, 16, 256, more.
inline constexpr std::array<std::uint64_t, 6> kUlpLimits = {0, 1, 2, 4, 16, 256};
inline constexpr std::array<std::string_view, 7> kUlpNames = {"0", "1", "2", "3-4", "5-16", "17-256", "more"};

struct FamilyTally {
  std::size_t pairs = 0;
  std::size_t separated = 0, touching = 0, penetrating = 0;  ///< by the second method
  std::size_t unsettled = 0;                                 ///< it has no answer; native is not judged
  std::size_t by_filter = 0;                                 ///< settled without an integer
  std::size_t missed = 0, phantom = 0;                       ///< native's wrong classes, any query
  std::size_t wrong_sign = 0;                                ///< class right, sign of the separation not
  std::size_t distances = 0;
  std::size_t beyond_bound = 0;   ///< of the distances: off by more than bound_over_S()
  std::size_t truths_differ = 0;  ///< of the distances: exact's class is not the second method's
  std::array<std::size_t, kUlpNames.size()> ulps{};
  double worst_over_S = 0.0;

  void add(const FamilyTally& other);
  std::size_t faults() const { return missed + phantom + wrong_sign + beyond_bound + truths_differ; }
};

/// Of the signed distance, over S = max(size, largest |world coordinate|): 1e-14, near-parallel edges 1e-13.
double bound_over_S(std::string_view family);

struct Fault {
  std::size_t family;
  std::uint64_t index;
  std::string what;
};
inline constexpr std::size_t kFaultsKept = 100;

struct LongRunResult {
  std::vector<FamilyTally> families;  ///< in the order of families()
  std::vector<Fault> faults;          ///< the first kFaultsKept that were met
  double seconds = 0.0;

  FamilyTally total() const;
};

/// @param progress called now and then with the number of pairs done, on the caller's thread.
LongRunResult long_run(const LongRunOptions& options,
                       const std::function<std::unique_ptr<Narrowphase>()>& make,
                       const std::function<void(std::size_t)>& progress = {});

}  // namespace touchstone::proof
