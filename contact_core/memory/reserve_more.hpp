#pragma once

#include <cstddef>
#include <cstdint>

namespace touchstone {

/// Reserves room for `count` elements, and for as many again where the list grows, so that elements added one
/// by one after set-up find room until their number has doubled. Room not used yet takes addresses, but no
/// memory.
///
/// A list grows when between three quarters and all of its room are used. The share depends on the list's
/// place in its owner, so that lists of equal length grow in different frames.
/// @param list a std::vector or a GrowingList.
template <class List>
void reserve_more(List& list, std::size_t count) {
  const std::size_t turn = reinterpret_cast<std::uintptr_t>(&list) / alignof(List) % 64;
  if (count + list.capacity() / 256 * turn > list.capacity()) list.reserve(2 * count);
}

/// resize(), with room reserved by reserve_more().
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
