#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <vector>

#include "touchstone/contact_core/narrowphase/narrowphase.hpp"

namespace touchstone {

/// Recent signed distances, by pair and poses, bit for bit. A narrowphase's answer depends on these alone, so
/// a remembered answer is the one that it would give again, and only speed depends on the memory. A frame
/// asks about the same poses for its paths, its plans and its report, and the next frame starts at them. The
/// memory is void after Narrowphase::build(). Does not allocate once made.
class SeparationMemo {
 public:
  /// An answer of Narrowphase::evaluate().
  struct Answer {
    using MovesByBits = Answer;  ///< see kMovesByBits

    PairStatus status;
    PairGeometry geometry;
  };

  /// @param sets of two answers each; a power of two.
  explicit SeparationMemo(std::size_t sets) : entries_(2 * sets), keys_(2 * sets, 0), mask_(sets - 1) {}

  void forget() noexcept { std::fill(keys_.begin(), keys_.end(), 0); }

  /// The remembered answer, or null.
  const Answer* find(const SolidPair& pair, const Pose& X_WA, const Pose& X_WB) const noexcept {
    const std::uint64_t key = key_of(pair, X_WA, X_WB);
    for (const std::size_t i : places(key)) {
      const Entry& entry = entries_[i];
      if (keys_[i] == key && entry.pair == pair && has_same_bits(entry.X_WA, X_WA) &&
          has_same_bits(entry.X_WB, X_WB))
        return &entry.answer;
    }
    return nullptr;
  }

  /// Notes an answer in place of the older of its set's two. @pre it is not known yet.
  void put(const SolidPair& pair, const Pose& X_WA, const Pose& X_WB, PairStatus status,
           const PairGeometry& geometry) noexcept {
    const std::uint64_t key = key_of(pair, X_WA, X_WB);
    const auto [newer, older] = places(key);
    entries_[older] = entries_[newer], keys_[older] = keys_[newer];
    entries_[newer] = {pair, X_WA, X_WB, {status, geometry}}, keys_[newer] = key;
  }

 private:
  struct Entry {
    SolidPair pair{0, 0};
    Pose X_WA, X_WB;
    Answer answer{};
  };

  std::array<std::size_t, 2> places(std::uint64_t key) const noexcept {
    const std::size_t first = 2 * (static_cast<std::size_t>(key >> 32) & mask_);
    return {first, first + 1};
  }

  /// A hash that is never 0, which marks an empty place. Four chains of three words each, so that products
  /// overlap.
  static std::uint64_t key_of(const SolidPair& pair, const Pose& X_WA, const Pose& X_WB) noexcept {
    constexpr std::uint64_t kFactor = 0x9e3779b97f4a7c15;
    std::array<std::uint64_t, 4> sum{pair.a, pair.b, 2, 3};
    for (const Pose* X : {&X_WA, &X_WB}) {
      const auto words = words_of(*X);
      for (std::size_t i = 0; i < words.size(); ++i)
        sum[i % 4] = (std::rotl(sum[i % 4], 23) ^ words[i]) * kFactor;
    }
    return (((sum[0] * kFactor + sum[1]) * kFactor + sum[2]) * kFactor + sum[3]) | 1;
  }

  std::vector<Entry> entries_;
  std::vector<std::uint64_t> keys_;
  std::size_t mask_;
};

}  // namespace touchstone
