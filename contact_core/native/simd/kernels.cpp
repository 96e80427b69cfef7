#include "touchstone/contact_core/native/simd/kernels.hpp"

#include <algorithm>
#include <cstdlib>
#include <iterator>
#include <string>
#include <string_view>

#include "touchstone/contact_core/input_error.hpp"

namespace touchstone::native {

extern const Kernels kernels_generic;
#if defined(__x86_64__)
extern const Kernels kernels_avx2;
extern const Kernels kernels_avx512;
#endif

namespace {

KernelList find_available() {
  KernelList list{{&kernels_generic, nullptr, nullptr}, 1};
#if defined(__x86_64__)
  // These ask the operating system too: whether it saves the wide registers.
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) list.of[list.count++] = &kernels_avx2;
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
      __builtin_cpu_supports("avx512vl") && list.count == 2)
    list.of[list.count++] = &kernels_avx512;
#endif
  return list;
}

constexpr std::string_view kNames[] = {"generic", "avx2", "avx512"};

const Kernels& choose() {
  const KernelList& list = available_kernels();
  const char* const wanted = std::getenv("TOUCHSTONE_ISA");
  if (wanted == nullptr || *wanted == '\0') return *list.of[list.count - 1];
  if (std::find(std::begin(kNames), std::end(kNames), wanted) == std::end(kNames))
    throw InputError(std::string("TOUCHSTONE_ISA=") + wanted +
                     ": there is no such instruction set; known: generic, avx2, avx512");
  for (int i = 0; i < list.count; ++i)
    if (std::string_view(wanted) == list.of[i]->isa) return *list.of[i];
  return *list.of[list.count - 1];
}

}  // namespace

const KernelList& available_kernels() {
  static const KernelList list = find_available();
  return list;
}

const Kernels& kernels() {
  static const Kernels& chosen = choose();
  return chosen;
}

}  // namespace touchstone::native
