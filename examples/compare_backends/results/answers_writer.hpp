#pragma once

#include <string>

#include "touchstone/examples/compare_backends/run/sets/pair_file_run.hpp"

namespace touchstone::comparison {

/// One answer a case and backend; `status` is that of the distance query, or of the overlap query where a
/// backend has no distance. Invalid cases have status `invalid` and the reason.
std::string answers_json(const PairFileResult& result);
std::string answers_csv(const PairFileResult& result);

}  // namespace touchstone::comparison
