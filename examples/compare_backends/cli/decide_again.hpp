#pragma once

namespace touchstone::comparison {

/// compare_backends decide RESULTS.json --max-error M ...: the verdict of a finished run for other allowed
/// errors and another query, from its figures alone. @return the program's exit code.
/// @throws InputError for a command line or file that cannot be used.
int run_decide(int argc, const char* const* argv);

}  // namespace touchstone::comparison
