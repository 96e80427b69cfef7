#include <cstdlib>
#include <string>

#include "touchstone/adapters/plugin/plugin.hpp"
#include "touchstone/tests/backend_suite/accuracy_table.hpp"
#include "touchstone/tests/backend_suite/suite.hpp"

// The shared suite on plug-ins: TOUCHSTONE_PLUGINS=./libmine.so plugin_suite. Of one without rows below each
// family fails and prints the row that was measured.

namespace touchstone::suite {

void register_suite_backends(BackendRegistry& registry) {
  const char* const named = std::getenv("TOUCHSTONE_PLUGINS");
  std::string rest = named == nullptr ? SAMPLE_PLUGINS : named;
  while (!rest.empty()) {
    const std::size_t end = std::min(rest.find(':'), rest.size());
    register_plugin(registry, rest.substr(0, end));
    rest.erase(0, end + 1);
  }
}

std::span<const AccuracyRow> accuracy_table() {
  static constexpr AccuracyRow kTable[] = {
      // backend, family, wrong class, undecided, no answer, distance, depth
      {"native_through_c", "random", 0, 0, 0, 4e-15, 4e-15},
      {"native_through_c", "near_1e-3", 0, 0, 0, 4e-15, 4e-15},
      {"native_through_c", "near_1e-7", 0, 0, 0, 4e-15, 4e-15},
      {"native_through_c", "resting", 0, 0, 0, 4e-15, 4e-15},
      {"native_through_c", "sheared", 0, 0, 0, 4e-15, 4e-15},
      {"native_through_c", "tapered", 0, 0, 0, 4e-15, 4e-15},
      {"native_through_c", "containment", 0, 0, 0, 4e-15, 4e-15},
      {"native_through_c", "slabs_needles", 0, 0, 0, 4e-15, 4e-15},
      {"native_through_c", "far", 0, 0, 0, 4e-15, 4e-15},
      {"native_through_c", "near_parallel", 0, 0, 0, 1e-13, 1e-13},
      {"native_through_c", "touching", 0, 0, 0, 4e-15, 4e-15},
      {"native_through_c", "bent", 0, 0, 0, 4e-15, 4e-15},
      {"separating_axes_c", "random", 0, 0, 0, kUnsupported, kUnsupported},
      {"separating_axes_c", "near_1e-3", 0, 0, 0, kUnsupported, kUnsupported},
      {"separating_axes_c", "near_1e-7", 0, 100, 0, kUnsupported, kUnsupported},
      {"separating_axes_c", "resting", 0, 170, 0, kUnsupported, kUnsupported},
      {"separating_axes_c", "sheared", 0, 0, 0, kUnsupported, kUnsupported},
      {"separating_axes_c", "tapered", 0, 0, 0, kUnsupported, kUnsupported},
      {"separating_axes_c", "containment", 0, 0, 0, kUnsupported, kUnsupported},
      {"separating_axes_c", "slabs_needles", 0, 33, 0, kUnsupported, kUnsupported},
      {"separating_axes_c", "far", 0, 0, 0, kUnsupported, kUnsupported},
      {"separating_axes_c", "near_parallel", 0, 97, 0, kUnsupported, kUnsupported},
      {"separating_axes_c", "touching", 0, 200, 0, kUnsupported, kUnsupported},
      {"separating_axes_c", "bent", 0, 0, 0, kUnsupported, kUnsupported},
  };
  return kTable;
}

}  // namespace touchstone::suite
