#define TOUCHSTONE_ISA avx512
#include "touchstone/contact_core/native/simd/kernel_table.hpp"

namespace touchstone::native {

extern const Kernels kernels_avx512;
constinit const Kernels kernels_avx512 = avx512::Table<avx512::Double8>::named("avx512");

}  // namespace touchstone::native
