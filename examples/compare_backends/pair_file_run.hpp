#pragma once

#include <optional>
#include <string>
#include <vector>

#include "touchstone/examples/measures/backend_run.hpp"

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
  /// What an engine answered when the cases were captured in it, as a backend `captured`; overlap and
  /// manifold. Cases without an answer are `unsupported`. Empty where no case has one.
  std::optional<BackendAnswers> captured;
};

/// @throws InputError for an unreadable file, one without a valid case, or in a build without the scene_files
/// adapter.
PairFileCases load_pair_file(const std::string& file);

/// What every backend answered to every case.
struct PairFileResult {
  PairFileCases cases;
  std::vector<PairTruth> truth;  ///< empty without `exact`
  std::vector<BackendAnswers> answers;
};

/// One answer a case and backend; `status` is that of the distance query, or of the overlap query where a
/// backend has no distance. Invalid cases have status `invalid` and the reason.
std::string answers_json(const PairFileResult& result);
std::string answers_csv(const PairFileResult& result);

}  // namespace touchstone::comparison
