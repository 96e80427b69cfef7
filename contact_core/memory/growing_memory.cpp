#include "touchstone/contact_core/memory/growing_memory.hpp"

#include <atomic>
#include <cstdint>
#include <cstring>
#include <new>
#include <utility>

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define TOUCHSTONE_SANITIZED
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer) || __has_feature(memory_sanitizer)
#define TOUCHSTONE_SANITIZED
#endif
#endif

#if defined(__linux__) && !defined(TOUCHSTONE_SANITIZED)
#include <sys/mman.h>
#define TOUCHSTONE_MAPS_MEMORY
#endif

namespace touchstone {
namespace {

/// The alignment that operator new gives by default, which costs less.
constexpr std::size_t kUsual = __STDCPP_DEFAULT_NEW_ALIGNMENT__;

}  // namespace

#ifdef TOUCHSTONE_MAPS_MEMORY

namespace {

constexpr std::size_t kPage = 4096;  // at least: larger pages make turns that are less even
constexpr std::size_t kLine = GrowingMemory::kMostAlignment;
/// Only how fast lists grow depends on it.
std::size_t next_offset() {
  static std::atomic<std::uint32_t> count{0};
  return kLine * (count.fetch_add(1, std::memory_order_relaxed) % (kPage / kLine));
}

}  // namespace

struct GrowingMemory::Mapping {
  void* base = nullptr;
  std::size_t length = 0;
  std::size_t offset = next_offset();

  Mapping() = default;
  Mapping(const Mapping&) = delete;
  Mapping& operator=(const Mapping&) = delete;
  ~Mapping() {
    if (base != nullptr) munmap(base, length);
  }

  void* data() const { return static_cast<std::byte*>(base) + offset; }
  std::size_t length_for(std::size_t bytes) const { return (offset + bytes + kPage - 1) / kPage * kPage; }

  bool map(std::size_t bytes) {
    length = length_for(bytes);
    void* const memory = mmap(nullptr, length, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (memory == MAP_FAILED) return false;
    base = memory;
    return true;
  }
  /// Takes over the pages of `other`.
  bool remap(Mapping& other, std::size_t bytes) {
    offset = other.offset;
    length = length_for(bytes);
    void* const memory = mremap(other.base, other.length, length, MREMAP_MAYMOVE);
    if (memory == MAP_FAILED) return false;
    base = memory;
    other.base = nullptr;
    return true;
  }
};

#else

struct GrowingMemory::Mapping {
  static void* data() { return nullptr; }
  static bool map(std::size_t) { return false; }
  static bool remap(Mapping&, std::size_t) { return false; }
};

#endif

GrowingMemory::GrowingMemory(std::size_t alignment) noexcept : alignment_(alignment) {}

GrowingMemory::GrowingMemory(GrowingMemory&& other) noexcept
    : alignment_(other.alignment_),
      data_(std::exchange(other.data_, nullptr)),
      mapping_(std::move(other.mapping_)) {}

GrowingMemory& GrowingMemory::operator=(GrowingMemory&& other) noexcept {
  std::swap(data_, other.data_);
  mapping_.swap(other.mapping_);
  return *this;
}

GrowingMemory::~GrowingMemory() { free_heap(); }

void* GrowingMemory::take_heap(std::size_t bytes) const {
  return alignment_ > kUsual ? ::operator new (bytes, std::align_val_t{alignment_}) : ::operator new(bytes);
}

void GrowingMemory::free_heap() noexcept {
  if (mapping_ != nullptr) return;
  if (alignment_ > kUsual)
    ::operator delete (data_, std::align_val_t{alignment_});
  else
    ::operator delete(data_);
}

void GrowingMemory::grow(std::size_t used, std::size_t bytes) {
  // Pages that are mapped are mapped to elsewhere.
  std::unique_ptr<Mapping> next = bytes >= kMapped ? std::make_unique<Mapping>() : nullptr;
  if (next != nullptr && mapping_ != nullptr && next->remap(*mapping_, bytes)) {
    mapping_ = std::move(next);
    data_ = mapping_->data();
    return;
  }
  // Else the contents are copied to new pages, or to the heap.
  if (next != nullptr && !next->map(bytes)) next.reset();
  void* const data = next != nullptr ? next->data() : take_heap(bytes);
  if (used > 0) std::memcpy(data, data_, used);
  free_heap();
  mapping_ = std::move(next);
  data_ = data;
}

}  // namespace touchstone
