#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "touchstone/contact_core/memory/growing_list.hpp"
#include "touchstone/contact_core/memory/reserve_more.hpp"
#include "touchstone/contact_core/narrowphase/narrowphase.hpp"

namespace touchstone {

/// The open solids of objects with levels: they are looked at one by one. For all others the coarser
/// hexahedra say enough.
class OpenSolids {
 public:
  void take_room(std::size_t slots, std::size_t solids, bool anew) {
    if (anew) count_.clear(), is_open_.clear();
    resize_more(count_, slots), resize_more(is_open_, solids), resize_more(list_, solids);
  }
  bool is_open(SolidIndex solid) const { return is_open_[solid] != 0; }
  /// Ascending. @param first of the slot's solids.
  std::span<const SolidIndex> of(std::uint32_t slot, SolidIndex first) const {
    return std::span(list_).subspan(first, count_[slot]);
  }
  /// @pre it is closed.
  void open(std::uint32_t slot, SolidIndex first, SolidIndex solid) {
    const auto begin = list_.begin() + first, end = begin + count_[slot];
    const auto place = std::lower_bound(begin, end, solid);
    std::copy_backward(place, end, end + 1);
    *place = solid;
    ++count_[slot], is_open_[solid] = 1;
  }
  /// Closes those for which is_idle(solid).
  template <class IsIdle>
  void close_idle(std::uint32_t slot, SolidIndex first, IsIdle is_idle) {
    const auto begin = list_.begin() + first, end = begin + count_[slot];
    const auto kept_end = std::remove_if(begin, end, [&](SolidIndex solid) {
      if (!is_idle(solid)) return false;
      is_open_[solid] = 0;
      return true;
    });
    count_[slot] = static_cast<std::uint32_t>(kept_end - begin);
  }

 private:
  GrowingList<std::uint32_t> count_;   // by slot
  GrowingList<std::uint8_t> is_open_;  // by solid
  GrowingList<SolidIndex> list_;       // from the slot's first solid on
};

}  // namespace touchstone
