#include "touchstone/contact_core/broadphase/first_contact.hpp"

#include <algorithm>

namespace touchstone {

std::optional<FirstContact> find_first_contact(Broadphase& broadphase, const Narrowphase& narrowphase,
                                               std::span<const Pose> poses, Narrowphase::Workspace& workspace,
                                               std::span<SolidPair> block,
                                               std::span<PairStatus> status) noexcept {
  std::size_t size = 16;
  for (PairCursor cursor; !cursor.done; size *= 2) {
    const std::size_t count = broadphase.find_pairs(cursor, block.first(std::min(size, block.size())));
    narrowphase.evaluate({.pairs = block.first(count), .poses = poses, .query = {}},
                         {.status = status.first(count)}, workspace);
    for (std::size_t i = 0; i < count; ++i)
      if (status[i] != PairStatus::separated) return FirstContact{block[i], status[i]};
    size = std::min(size, block.size());
  }
  return std::nullopt;
}

}  // namespace touchstone
