#pragma once

#include <cstddef>
#include <utility>
#include <vector>

namespace touchstone {

/// Records by slot that stay where they are as more come: a list in one piece would move all of them whenever
/// it grows.
/// @tparam kChunk records stand together: that many.
template <class Record, std::size_t kChunk = 64>
class RecordList {
 public:
  std::size_t size() const {
    return chunks_.empty() ? 0 : (chunks_.size() - 1) * kChunk + chunks_.back().size();
  }
  template <class... Args>
  void emplace_back(Args&&... args) {
    if (chunks_.empty() || chunks_.back().size() == kChunk) {
      std::vector<Record> chunk;  // has its room before it is one of them
      chunk.reserve(kChunk);
      chunks_.push_back(std::move(chunk));
    }
    chunks_.back().emplace_back(std::forward<Args>(args)...);
  }
  Record& operator[](std::size_t i) { return chunks_[i / kChunk][i % kChunk]; }
  const Record& operator[](std::size_t i) const { return chunks_[i / kChunk][i % kChunk]; }

 private:
  std::vector<std::vector<Record>> chunks_;
};

}  // namespace touchstone
