#pragma once

#include <cstddef>
#include <utility>
#include <vector>

namespace touchstone {

/// Records by slot that stay where they are as more come: a list in one piece would move all of them whenever
/// it grows.
/// @tparam kChunk how many records are stored together.
template <class Record, std::size_t kChunk = 64>
class RecordList {
 public:
  std::size_t size() const {
    return chunks_.empty() ? 0 : (chunks_.size() - 1) * kChunk + chunks_.back().size();
  }
  template <class... Args>
  void emplace_back(Args&&... args) {
    make_room();
    if (chunks_.empty() || chunks_.back().size() == kChunk) chunks_.push_back(std::exchange(spare_, {}));
    chunks_.back().emplace_back(std::forward<Args>(args)...);
  }
  /// Reserves room for one more record: the next emplace_back() allocates only what the record itself does.
  void make_room() {
    if (!chunks_.empty() && chunks_.back().size() < kChunk) return;
    if (chunks_.size() == chunks_.capacity()) chunks_.reserve(2 * chunks_.size() + 1);
    spare_.reserve(kChunk);
  }
  Record& operator[](std::size_t i) { return chunks_[i / kChunk][i % kChunk]; }
  const Record& operator[](std::size_t i) const { return chunks_[i / kChunk][i % kChunk]; }

 private:
  std::vector<std::vector<Record>> chunks_;
  std::vector<Record> spare_;  // the next chunk, or none
};

}  // namespace touchstone
