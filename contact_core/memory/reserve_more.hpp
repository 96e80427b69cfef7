#pragma once

#include <cstddef>
#include <cstdint>

namespace touchstone {

/// Room for `count`, and for as many again where the list grows: what comes one by one after set-up finds
/// room in all lists until it has doubled. Room that nobody used yet takes no memory, only addresses.
///
/// A list grows when between three quarters and all of its room are used, by where it stands in its owner:
/// lists that hold as many take turns, so that no frame pays for the growth of all.
/// @param list a std::vector or a GrowingList.
template <class List>
void reserve_more(List& list, std::size_t count) {
  const std::size_t turn = reinterpret_cast<std::uintptr_t>(&list) / alignof(List) % 64;
  if (count + list.capacity() / 256 * turn > list.capacity()) list.reserve(2 * count);
}

/// resize() with such room.
template <class List>
void resize_more(List& list, std::size_t count) {
  reserve_more(list, count);
  list.resize(count);
}
/// The same with copies of a value.
template <class List>
void resize_more(List& list, std::size_t count, const typename List::value_type& value) {
  reserve_more(list, count);
  list.resize(count, value);
}

}  // namespace touchstone
