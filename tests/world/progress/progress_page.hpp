#pragma once

#include <span>
#include <string>

#include "touchstone/tests/world/progress/motion_progress.hpp"

namespace touchstone {

/// The figures as a page of Markdown: what was measured, with what and when, and a row for each.
/// @param command that measured them.
std::string progress_page(std::span<const ProgressFigures> figures, const std::string& command);

}  // namespace touchstone
