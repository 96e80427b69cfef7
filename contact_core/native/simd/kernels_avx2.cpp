#define TOUCHSTONE_ISA avx2
#include "touchstone/contact_core/native/simd/kernel_table.hpp"

namespace touchstone::native {

extern const Kernels kernels_avx2;
constinit const Kernels kernels_avx2 = avx2::Table<avx2::Double4>::named("avx2");

}  // namespace touchstone::native
