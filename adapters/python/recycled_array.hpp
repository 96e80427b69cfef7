#pragma once

#include <cstddef>
#include <memory>
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
  explicit RecycledArray(std::size_t count) : bytes_(count * sizeof(T)) {
    static_assert(std::is_trivially_destructible_v<T> && alignof(T) <= __STDCPP_DEFAULT_NEW_ALIGNMENT__);
    std::uninitialized_default_construct_n(get(), count);
  }
  T* get() const { return reinterpret_cast<T*>(bytes_.data()); }

 private:
  RecycledBytes bytes_;
};

}  // namespace touchstone::python
