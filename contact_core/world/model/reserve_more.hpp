#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace touchstone {

/// Room for `count`, at least doubled where it grows: for set-up between frames, which may come one by one.
template <class T>
void reserve_more(std::vector<T>& list, std::size_t count) {
  if (count > list.capacity()) list.reserve(std::max(count, 2 * list.capacity()));
}

}  // namespace touchstone
