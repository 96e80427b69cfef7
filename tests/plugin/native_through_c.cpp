#include <cstdio>

#include "touchstone/adapters/c_interface/touchstone.h"
#include "touchstone/adapters/c_interface/touchstone_plugin.h"

// `native` asked through touchstone.h, offered through touchstone_plugin.h: must pass the suite as itself.

namespace {

touchstone_narrowphase* of(const void* self) {
  return const_cast<touchstone_narrowphase*>(static_cast<const touchstone_narrowphase*>(self));
}

void* create() {
  touchstone_narrowphase* made = nullptr;
  touchstone_create("native", &made);
  return made;
}
void destroy(void* self) { touchstone_destroy(of(self)); }
int build(void* self, const double* corners, size_t solids, char* error, size_t error_size) {
  const touchstone_code code = touchstone_build(of(self), corners, solids);
  if (code != TOUCHSTONE_OK) std::snprintf(error, error_size, "%s", touchstone_error());
  return code;
}
void* create_workspace(const void* self) {
  touchstone_workspace* made = nullptr;
  touchstone_create_workspace(of(self), &made);
  return made;
}
void destroy_workspace(void* workspace) {
  touchstone_destroy_workspace(static_cast<touchstone_workspace*>(workspace));
}
void evaluate(const void* self, void* workspace, const touchstone_input* input,
              const touchstone_output* output) {
  touchstone_evaluate(of(self), static_cast<touchstone_workspace*>(workspace), input, output);
}

}  // namespace

const touchstone_backend touchstone_plugin = {TOUCHSTONE_ABI_VERSION,
                                              sizeof(touchstone_backend),
                                              "native_through_c",
                                              "native, through the C interface and back",
                                              {1, 1, 1, 1, 1, 1, {0, 0}, 64, 0, 0.0, 0x1p-48, 0.0},
                                              create,
                                              destroy,
                                              build,
                                              create_workspace,
                                              destroy_workspace,
                                              evaluate};
