#include "touchstone/tests/ode/heap_count.hpp"

#include <atomic>

namespace {
std::atomic<std::size_t> calls{0};
}

extern "C" {
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);

void* malloc(std::size_t size) {
  calls.fetch_add(1, std::memory_order_relaxed);
  return __libc_malloc(size);
}
void* calloc(std::size_t count, std::size_t size) {
  calls.fetch_add(1, std::memory_order_relaxed);
  return __libc_calloc(count, size);
}
void* realloc(void* old, std::size_t size) {
  calls.fetch_add(1, std::memory_order_relaxed);
  return __libc_realloc(old, size);
}
}

namespace touchstone::ode_test {
std::size_t heap_calls() { return calls.load(std::memory_order_relaxed); }
}  // namespace touchstone::ode_test
