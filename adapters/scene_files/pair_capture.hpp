#pragma once

#include <filesystem>
#include <mutex>
#include <random>
#include <vector>

#include "touchstone/adapters/scene_files/pair_file.hpp"
#include "touchstone/contact_core/narrowphase/pair_observer.hpp"

namespace touchstone {

/// Keeps what an engine was asked and answered, to be written as a pair file: every pair up to a number, then
/// a fair sample of that many of all (reservoir sampling, Vitter's algorithm R, from a fixed seed), so that a
/// long run keeps its own distribution. Allocates: for runs that capture. May be called from several threads;
/// which pairs are kept then depends on the order of the calls.
class PairCapture final : public PairObserver {
 public:
  /// @pre most >= 1
  explicit PairCapture(std::size_t most, std::uint64_t seed = 1) : most_(most), random_(seed) {}

  void observe(const ObservedPair& pair) noexcept override;

  std::size_t observed() const;  ///< pairs in all
  /// Those kept, in the order of their calls. The id of a case is "pair-" and its number, counted from 1.
  std::vector<PairCase> cases() const;
  /// @throws InputError when the file cannot be written.
  void save(const std::filesystem::path& path) const { save_pairs(path, cases()); }

 private:
  struct Kept {
    std::size_t number;
    PairCase pair;
  };

  const std::size_t most_;
  mutable std::mutex mutex_;
  std::mt19937_64 random_;
  std::size_t observed_ = 0;
  std::vector<Kept> kept_;
};

}  // namespace touchstone
