#pragma once

#include <cstddef>
#include <vector>

namespace touchstone {

/// Room for `count`, and for as many again where it grows: what comes one by one after set-up finds room in
/// all lists until it has doubled. Room that nobody used yet takes no memory, only addresses.
template <class T>
void reserve_more(std::vector<T>& list, std::size_t count) {
  if (count > list.capacity()) list.reserve(2 * count);
}

/// resize() with such room.
template <class T>
void resize_more(std::vector<T>& list, std::size_t count, const T& value = {}) {
  reserve_more(list, count);
  list.resize(count, value);
}

}  // namespace touchstone
