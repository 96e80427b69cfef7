#include "touchstone/tests/backend_suite/suite.hpp"

#include "separating_axes.hpp"
#include "touchstone/tests/backend_suite/accuracy_table.hpp"

// The two things that the installed suite asks of a program: which backends, and what each may get wrong.

namespace touchstone::suite {

void register_suite_backends(BackendRegistry& registry) { register_separating_axes(registry); }

std::span<const AccuracyRow> accuracy_table() {
  static constexpr AccuracyRow kTable[] = {
      // backend, family, wrong class, undecided, no answer, distance, depth
      {"separating_axes", "random", 0, 0, 0, kUnsupported, kUnsupported},
      {"separating_axes", "near_1e-3", 0, 0, 0, kUnsupported, kUnsupported},
      {"separating_axes", "near_1e-7", 0, 91, 0, kUnsupported, kUnsupported},
      {"separating_axes", "resting", 0, 170, 0, kUnsupported, kUnsupported},
      {"separating_axes", "sheared", 0, 0, 0, kUnsupported, kUnsupported},
      {"separating_axes", "tapered", 0, 0, 0, kUnsupported, kUnsupported},
      {"separating_axes", "containment", 0, 0, 0, kUnsupported, kUnsupported},
      {"separating_axes", "slabs_needles", 0, 30, 0, kUnsupported, kUnsupported},
      {"separating_axes", "far", 0, 0, 0, kUnsupported, kUnsupported},
      {"separating_axes", "near_parallel", 0, 97, 0, kUnsupported, kUnsupported},
      {"separating_axes", "touching", 0, 200, 0, kUnsupported, kUnsupported},
      {"separating_axes", "bent", 0, 0, 0, kUnsupported, kUnsupported},
  };
  return kTable;
}

}  // namespace touchstone::suite
