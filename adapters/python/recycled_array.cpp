#include "touchstone/adapters/python/recycled_array.hpp"

#include <algorithm>

namespace touchstone::python {

std::vector<RecycledBytes::Block>& RecycledBytes::spare() {
  static auto* const blocks = [] {
    auto* const made = new std::vector<Block>;
    made->reserve(kSpareBlocks);
    return made;
  }();
  return *blocks;
}

RecycledBytes::RecycledBytes(std::size_t bytes) {
  // One that fits and is not half empty.
  std::vector<Block>& blocks = spare();
  const auto fits = std::find_if(blocks.begin(), blocks.end(), [&](const Block& block) {
    return block.size >= bytes && block.size / 2 <= bytes;
  });
  if (fits == blocks.end()) {
    block_ = {std::make_unique_for_overwrite<std::byte[]>(bytes), bytes};
  } else {
    block_ = std::move(*fits);
    blocks.erase(fits);
  }
}

RecycledBytes::~RecycledBytes() {
  if (block_.size > kSpareBytes) return;
  // The oldest one goes.
  std::vector<Block>& blocks = spare();
  if (blocks.size() == kSpareBlocks) blocks.erase(blocks.begin());
  blocks.push_back(std::move(block_));
}

}  // namespace touchstone::python
