#pragma once

#include <optional>
#include <string>
#include <vector>

#include "touchstone/examples/compare_backends/names.hpp"
#include "touchstone/examples/measures/runs/backend_run.hpp"

namespace touchstone::comparison {

/// The cases of a file that users bring.
struct PairFileCases {
  std::string file;
  struct Case {
    std::string id;
    std::string invalid;    ///< the reason; empty: a case of `set`
    std::size_t index = 0;  ///< in `set`
  };
  std::vector<Case> cases;  ///< in the file's order
  PairSet set;              ///< the valid ones
  /// The answers of the engine in which the cases were captured, as a backend `captured`; overlap and
  /// manifold. Cases without an answer are `unsupported`. Empty where no case has one.
  std::optional<BackendAnswers> captured;
};

/// @throws InputError for an unreadable file, one without a valid case, or in a build without the scene_files
/// adapter.
PairFileCases load_pair_file(const std::string& file);

/// Every backend's answer to every case.
struct PairFileResult {
  PairFileCases cases;
  std::vector<PairTruth> truth;  ///< empty without `exact`
  std::vector<BackendAnswers> answers;
};

}  // namespace touchstone::comparison
