#define TOUCHSTONE_ISA generic
#include "touchstone/contact_core/native/simd/kernel_table.hpp"

namespace touchstone::native {

extern const Kernels kernels_generic;
constinit const Kernels kernels_generic = generic::Table<generic::Double2>::named("generic");

}  // namespace touchstone::native
