#pragma once

#include <filesystem>
#include <string>

#include "touchstone/contact_core/registry.hpp"

/// @file
/// Backends in shared libraries, loaded at run time: c_interface/touchstone_plugin.h is what such a library
/// exports. It answers in this process: what crashes there ends the process (compare_backends therefore asks
/// plug-ins in a worker process; adapters/process_engine is the safe form). Its answers are checked first
/// (narrowphase/answer_check.hpp); the first broken one is reported on stderr, and all broken ones count as
/// `failed`.

namespace touchstone {

/// Loads the library and adds its narrowphase. The library stays loaded as long as the registry's entry or a
/// narrowphase of it. @param library a path; a name without a slash is looked for as the dynamic linker does.
/// Returns the backend's name.
/// @throws InputError naming the library: not loadable, no `touchstone_plugin` in it, made for another
/// TOUCHSTONE_ABI_VERSION, incomplete, its name taken.
std::string register_plugin(BackendRegistry& registry, const std::filesystem::path& library);

}  // namespace touchstone
