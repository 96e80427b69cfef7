#pragma once

#include <span>
#include <string>
#include <vector>

#include "touchstone/contact_core/motion/sweep.hpp"
#include "touchstone/contact_core/registry.hpp"

namespace touchstone {

/// An adapter of narrowphases and broadphases that a build may lack.
struct BackendSource {
  const char* narrowphases;               ///< their names
  void (*register_in)(BackendRegistry&);  ///< null: not in this build
  const char* missing;                    ///< why, where it is not
};

/// All that one process can hold, in the order of registration: the single-precision Bullet cannot stand
/// beside the double one and is left out.
std::span<const BackendSource> backend_sources();

/// Registers ours and every source's of this build.
void register_all_backends(BackendRegistry& registry);

/// The engines' own sweeps in this build.
std::vector<SweepEntry> all_sweeps();

/// The narrowphases' names, in the order of registration.
std::vector<std::string> all_backend_names();
/// True where this build has such a narrowphase.
bool has_backend(std::string_view narrowphase);

}  // namespace touchstone
