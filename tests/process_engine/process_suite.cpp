#include <algorithm>
#include <cstdlib>
#include <sstream>
#include <string>

#include "touchstone/adapters/process_engine/process_engine.hpp"
#include "touchstone/tests/backend_suite/accuracy_table.hpp"
#include "touchstone/tests/backend_suite/suite.hpp"

// The shared suite on engines that are processes: TOUCHSTONE_ENGINES="python3 mine.py" process_suite. Of one
// without rows below each family fails and prints the row that was measured.

namespace touchstone::suite {

void register_suite_backends(BackendRegistry& registry) {
  const char* const named = std::getenv("TOUCHSTONE_ENGINES");
  std::istringstream commands(named == nullptr ? SAMPLE_ENGINE : named);
  for (std::string command; std::getline(commands, command, ';');) {
    std::istringstream words(command);
    ProcessEngineOptions options;
    for (std::string word; words >> word;) options.command.push_back(word);
    register_process_engine(registry, options);
  }
}

std::span<const AccuracyRow> accuracy_table() {
  static constexpr AccuracyRow kTable[] = {
      // backend, family, wrong class, undecided, no answer, distance, depth
      {"engine_c", "random", 0, 0, 0, 4e-15, 4e-15},
      {"engine_c", "near_1e-3", 0, 0, 0, 4e-15, 4e-15},
      {"engine_c", "near_1e-7", 0, 0, 0, 4e-15, 4e-15},
      {"engine_c", "resting", 0, 0, 0, 4e-15, 4e-15},
      {"engine_c", "sheared", 0, 0, 0, 4e-15, 4e-15},
      {"engine_c", "tapered", 0, 0, 0, 4e-15, 4e-15},
      {"engine_c", "containment", 0, 0, 0, 4e-15, 4e-15},
      {"engine_c", "slabs_needles", 0, 0, 0, 4e-15, 4e-15},
      {"engine_c", "far", 0, 0, 0, 4e-15, 4e-15},
      {"engine_c", "near_parallel", 0, 0, 0, 1e-13, 1e-13},
      {"engine_c", "touching", 0, 0, 0, 4e-15, 4e-15},
      {"engine_c", "bent", 0, 0, 0, 4e-15, 4e-15},
  };
  return kTable;
}

}  // namespace touchstone::suite
