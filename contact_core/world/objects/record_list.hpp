#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace touchstone {

/// Records by slot that stay where they are as more come: a list in one piece would move all of them whenever
/// it grows.
template <class Record>
class RecordList {
 public:
  std::size_t size() const {
    return chunks_.empty() ? 0 : (chunks_.size() - 1) * kChunk + chunks_.back().size();
  }
  void emplace_back() {
    if (chunks_.empty() || chunks_.back().size() == kChunk) chunks_.emplace_back().reserve(kChunk);
    chunks_.back().emplace_back();
  }
  Record& operator[](std::uint32_t i) { return chunks_[i / kChunk][i % kChunk]; }
  const Record& operator[](std::uint32_t i) const { return chunks_[i / kChunk][i % kChunk]; }

 private:
  static constexpr std::size_t kChunk = 64;

  std::vector<std::vector<Record>> chunks_;
};

}  // namespace touchstone
