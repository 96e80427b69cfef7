#pragma once

#include <string>

#include "touchstone/contact_core/registry.hpp"

namespace touchstone {

/// Prints the table of what is asked of contact checks beside what `native` takes, in Markdown: pairs by
/// family, query and calls beside the fastest right peer of this build, then worlds. A row's verdict is
/// `met`, or `missed` with its reason.
/// @param program this program's name, for a shell: it starts itself for the rows of a narrower instruction
/// set, and for worlds, whose memory is a process's.
/// @param part `two_lanes` or `worlds`: that part alone; empty: all.
void print_goals(const BackendRegistry& registry, const std::string& program, const std::string& part);

}  // namespace touchstone
