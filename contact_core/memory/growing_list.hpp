#pragma once

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <initializer_list>
#include <iterator>
#include <memory>
#include <new>
#include <type_traits>
#include <utility>

#include "touchstone/contact_core/memory/growing_memory.hpp"

namespace touchstone {

/// True where an element may be moved in memory by copying its bits: it owns nothing, and nobody keeps its
/// address while its list may grow. The compiler decides for types without user-written copy constructors.
/// Other types, among them all that hold Eigen's, declare it after a review: `using MovesByBits = ` the type
/// itself.
template <class T>
inline constexpr bool kMovesByBits = std::is_trivially_copyable_v<T> || requires {
  requires std::is_same_v<typename T::MovesByBits, T>;
};
template <class A, class B>
inline constexpr bool kMovesByBits<std::pair<A, B>> = std::min(kMovesByBits<A>, kMovesByBits<B>);

/// A list in one piece, as std::vector is, in memory that grows without being copied (GrowingMemory).
template <class T>
class GrowingList {
  static_assert(kMovesByBits<T> && alignof(T) <= GrowingMemory::kMostAlignment);

 public:
  using value_type = T;
  using iterator = T*;
  using const_iterator = const T*;

  GrowingList() = default;
  GrowingList(std::initializer_list<T> values) { assign(values.begin(), values.end()); }
  GrowingList(GrowingList&& other) noexcept
      : memory_(std::move(other.memory_)),
        size_(std::exchange(other.size_, 0)),
        capacity_(std::exchange(other.capacity_, 0)) {}
  GrowingList& operator=(GrowingList&& other) noexcept {
    swap(other);
    return *this;
  }
  void swap(GrowingList& other) noexcept {
    memory_ = std::move(other.memory_);  // changes places, too
    std::swap(size_, other.size_), std::swap(capacity_, other.capacity_);
  }

  std::size_t size() const { return size_; }
  std::size_t capacity() const { return capacity_; }
  bool empty() const { return size_ == 0; }
  T* data() { return static_cast<T*>(memory_.data()); }
  const T* data() const { return static_cast<const T*>(memory_.data()); }
  T* begin() { return data(); }
  const T* begin() const { return data(); }
  T* end() { return data() + size_; }
  const T* end() const { return data() + size_; }
  T& operator[](std::size_t i) { return data()[i]; }
  const T& operator[](std::size_t i) const { return data()[i]; }
  T& front() { return *begin(); }
  const T& front() const { return *begin(); }
  T& back() { return end()[-1]; }
  const T& back() const { return end()[-1]; }

  void reserve(std::size_t count) {
    if (count <= capacity_) return;
    memory_.grow(size_ * sizeof(T), GrowingMemory::bytes_of(count, sizeof(T)));
    capacity_ = count;
  }
  void clear() { size_ = 0; }
  void resize(std::size_t count) {
    make_room(count);
    if (count > size_) std::uninitialized_value_construct(end(), data() + count);
    size_ = count;
  }
  /// @pre the value is not an element of this list.
  void resize(std::size_t count, const T& value) {
    make_room(count);
    if (count > size_) std::uninitialized_fill(end(), data() + count, value);
    size_ = count;
  }
  void assign(std::size_t count, const T& value) {
    const T copy = value;  // it may be an element that moves
    clear();
    resize(count, copy);
  }
  /// @pre the values are none of this list's.
  template <std::forward_iterator Iterator>
  void assign(Iterator first, Iterator last) {
    clear();
    insert(end(), first, last);
  }
  void push_back(const T& value) { emplace_back(value); }
  template <class... Args>
  T& emplace_back(Args&&... args) {
    if (sizeof...(Args) == 0) make_room(size_ + 1);
    if (size_ < capacity_) return *std::construct_at(data() + size_++, std::forward<Args>(args)...);
    T added(std::forward<Args>(args)...);  // before what they may refer to goes elsewhere
    make_room(size_ + 1);
    return *std::construct_at(data() + size_++, std::move(added));
  }
  void pop_back() { --size_; }

  /// @pre the values are none of this list's.
  template <std::forward_iterator Iterator>
  void insert(const T* place, Iterator first, Iterator last) {
    const std::ptrdiff_t at = place - data();
    const auto count = static_cast<std::size_t>(std::distance(first, last));
    make_room(size_ + count);
    T* const gap = data() + at;
    move_bits(gap, end(), gap + count);
    std::uninitialized_copy(first, last, gap);
    size_ += count;
  }
  void insert(const T* place, const T& value) {
    const T copy = value;
    insert(place, &copy, &copy + 1);
  }
  void erase(const T* place) { erase(place, place + 1); }
  void erase(const T* first, const T* last) {
    move_bits(last, end(), begin() + (first - begin()));
    size_ -= static_cast<std::size_t>(last - first);
  }

  friend bool operator==(const GrowingList& a, const GrowingList& b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end());
  }

 private:
  static void move_bits(const T* first, const T* last, T* to) {
    if (first != last)
      std::memmove(static_cast<void*>(to), static_cast<const void*>(first),
                   static_cast<std::size_t>(last - first) * sizeof(T));
  }
  void make_room(std::size_t count) {
    if (count <= capacity_) return;
    reserve(std::max(count, std::min(2 * capacity_ + 16, GrowingMemory::most_of(sizeof(T)))));
  }

  GrowingMemory memory_{alignof(T)};
  std::size_t size_ = 0, capacity_ = 0;
};

/// Erases the elements that is(element).
template <class T, class Is>
void erase_if(GrowingList<T>& list, Is is) {
  list.erase(std::remove_if(list.begin(), list.end(), is), list.end());
}

}  // namespace touchstone
