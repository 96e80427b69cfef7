#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string_view>
#include <vector>

#include "touchstone/contact_core/narrowphase/narrowphase.hpp"

namespace touchstone::proof {

struct HashOptions {
  std::uint64_t seed = 1;
  std::size_t count = 2000;  ///< pairs a family
  int threads = 1;
  std::size_t batch = 256;  ///< pairs a call of evaluate(), >= 1
  bool cache = false;       ///< every batch twice with one pair cache; the second answers count
};

struct FamilyHash {
  std::string_view family;
  std::uint64_t hash;
};

/// FNV-1a, 64 bits, a word at a time.
class Fnv1a {
 public:
  void put(std::uint64_t word) { hash_ = (hash_ ^ word) * 0x100000001b3ULL; }
  std::uint64_t value() const { return hash_; }

 private:
  std::uint64_t hash_ = 0xcbf29ce484222325ULL;
};

/// One hash a family over every bit of the answers to its pairs: overlap, distance, distance up to 0.1 m,
/// manifolds of up to 8 and of up to 4 points. Threads and batches must not show: each pair is hashed
/// alone, the pairs' hashes in their order.
std::vector<FamilyHash> result_hashes(const HashOptions& options,
                                      const std::function<std::unique_ptr<Narrowphase>()>& make);

/// The families' hashes as one.
std::uint64_t total_hash(const std::vector<FamilyHash>& hashes);

}  // namespace touchstone::proof
