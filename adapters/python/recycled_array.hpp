#pragma once

#include <cstddef>
#include <limits>
#include <memory>
#include <new>
#include <type_traits>
#include <vector>

// Private to this folder: memory of answers.

namespace touchstone::python {

/// An array whose memory goes to the next ones when it is gone: the system takes freed blocks of a batch's
/// size back, and each page of a new one costs a fault, 3 % of an overlap batch. At most kSpareBlocks of
/// kSpareBytes stay. With Python's lock.
class RecycledBytes {
 public:
  explicit RecycledBytes(std::size_t bytes);
  ~RecycledBytes();
  RecycledBytes(const RecycledBytes&) = delete;
  RecycledBytes& operator=(const RecycledBytes&) = delete;

  std::byte* data() const { return block_.bytes.get(); }

  static constexpr std::size_t kSpareBlocks = 4, kSpareBytes = std::size_t{1} << 22U;

 private:
  struct Block {
    std::unique_ptr<std::byte[]> bytes;
    std::size_t size = 0;
  };
  static std::vector<Block>& spare();

  Block block_;
};

/// Elements in recycled memory, without values yet.
template <class T>
class RecycledArray {
 public:
  /// @throws std::bad_alloc where there is no room.
  explicit RecycledArray(std::size_t count) : bytes_(bytes_of(count)) {
    static_assert(std::is_trivially_destructible_v<T> && alignof(T) <= __STDCPP_DEFAULT_NEW_ALIGNMENT__);
    std::uninitialized_default_construct_n(get(), count);
  }
  T* get() const { return reinterpret_cast<T*>(bytes_.data()); }

 private:
  static std::size_t bytes_of(std::size_t count) {
    if (count > std::numeric_limits<std::size_t>::max() / sizeof(T)) throw std::bad_alloc();
    return count * sizeof(T);
  }

  RecycledBytes bytes_;
};

}  // namespace touchstone::python
