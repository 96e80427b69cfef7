#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <new>

namespace touchstone {

/// Memory of one list, which grows without being copied where the system can: on Linux from kMapped bytes on,
/// where the pages stay and their addresses change. Elsewhere, and under sanitizers, which look after the
/// heap, it is copied.
///
/// Most of what growth then costs is new pages, 1.5 us each on a virtual machine. Lists of equal elements
/// that grow by one in a frame would all need their next page in the same frame. So memories begin at
/// different places of their first page, in turn.
class GrowingMemory {
 public:
  static constexpr std::size_t kMapped = std::size_t{1} << 16;

  static constexpr std::size_t kMostAlignment = 64;

  /// @param alignment of the elements, kMostAlignment at most.
  explicit GrowingMemory(std::size_t alignment) noexcept;
  GrowingMemory(GrowingMemory&& other) noexcept;
  GrowingMemory& operator=(GrowingMemory&& other) noexcept;
  ~GrowingMemory();

  /// The bytes that `count` elements take. @throws std::bad_alloc where no memory holds them.
  static std::size_t bytes_of(std::size_t count, std::size_t size) {
    if (count > most_of(size)) throw std::bad_alloc();
    return count * size;
  }
  static constexpr std::size_t most_of(std::size_t size) { return PTRDIFF_MAX / size; }

  void* data() const { return data_; }
  /// Makes room for this many bytes, and keeps the first `used` ones, by their bits.
  /// Always calls operator new, for those who count allocations. @throws std::bad_alloc, and nothing changed.
  void grow(std::size_t used, std::size_t bytes);

 private:
  struct Mapping;

  void* take_heap(std::size_t bytes) const;
  void free_heap() noexcept;

  std::size_t alignment_;
  void* data_ = nullptr;
  std::unique_ptr<Mapping> mapping_;  // null: data_ comes from operator new, or is null
};

}  // namespace touchstone
