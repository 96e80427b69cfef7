#pragma once

#include "touchstone/contact_core/registry.hpp"

namespace touchstone::comparison {

/// compare_backends fitted MESH... --unit mm --over 8% 4% 2%: covers the meshes within each error, or proves
/// covers that are there (--covers), asks every backend for clearances around contact, and writes
/// fitted.md and a plot a mesh. @return the program's exit code.
/// @throws InputError for a command line or file that cannot be used.
int run_fitted(int argc, const char* const* argv, const BackendRegistry& registry);

}  // namespace touchstone::comparison
