#pragma once

#include <string>

#include "touchstone/examples/compare_backends/names.hpp"
#include "touchstone/examples/program/files/json.hpp"

namespace touchstone::comparison {

/// The tables of a finished run as a Markdown page: time and wrong answers of every backend by family and
/// query, worst errors, broadphases. A figure that the run did not measure is "-".
/// @param results as parse_results() gives it.
/// @throws InputError where a figure that every run has is missing.
std::string tables_page(const Json& results);

/// compare_backends tables RESULTS.json: prints the page. @return the program's exit code.
/// @throws InputError for a command line or file that cannot be used.
int run_tables(int argc, const char* const* argv);

}  // namespace touchstone::comparison
