#pragma once

#include <string>

namespace touchstone::program {

/// Today in UTC, "2026-11-27".
std::string today();

}  // namespace touchstone::program
