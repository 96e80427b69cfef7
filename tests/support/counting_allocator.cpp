#include "touchstone/tests/support/counting_allocator.hpp"

#include <atomic>
#include <cstdlib>
#include <new>

namespace {

constexpr std::size_t kNever = static_cast<std::size_t>(-1);

std::atomic<std::size_t> count{0}, failing{kNever}, last_failing{kNever};

void* counted(std::size_t size, std::size_t alignment) noexcept {
  if (const std::size_t n = count++; n >= failing && n <= last_failing) return nullptr;
  const std::size_t rounded = (size + alignment - 1) / alignment * alignment;
  return std::aligned_alloc(alignment, rounded > 0 ? rounded : alignment);
}

void* counted_or_throw(std::size_t size, std::size_t alignment) {
  if (void* memory = counted(size, alignment)) return memory;
  throw std::bad_alloc();
}

constexpr std::size_t kDefault = alignof(std::max_align_t);

}  // namespace

namespace touchstone {

std::size_t allocation_count() { return count; }

FailingAllocation::FailingAllocation(std::size_t after, Fails fails) {
  last_failing = fails == Fails::all ? kNever : count + after;
  failing = count + after;
}
FailingAllocation::~FailingAllocation() { failing = kNever; }

}  // namespace touchstone

// Every form of new and delete: AddressSanitizer brings its own, and takes one of them beside one of ours for
// a mismatch.
void* operator new(std::size_t size) { return counted_or_throw(size, kDefault); }
void* operator new[](std::size_t size) { return counted_or_throw(size, kDefault); }
void* operator new(std::size_t size, const std::nothrow_t&) noexcept { return counted(size, kDefault); }
void* operator new[](std::size_t size, const std::nothrow_t&) noexcept { return counted(size, kDefault); }
void* operator new(std::size_t size, std::align_val_t alignment) {
  return counted_or_throw(size, static_cast<std::size_t>(alignment));
}
void* operator new[](std::size_t size, std::align_val_t alignment) {
  return counted_or_throw(size, static_cast<std::size_t>(alignment));
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete[](void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete(void* memory, const std::nothrow_t&) noexcept { std::free(memory); }
void operator delete[](void* memory, const std::nothrow_t&) noexcept { std::free(memory); }
void operator delete(void* memory, std::align_val_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::align_val_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::size_t, std::align_val_t) noexcept { std::free(memory); }
