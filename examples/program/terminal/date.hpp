#pragma once

#include <string>

namespace touchstone::comparison {

/// Today in UTC, "2026-11-27".
std::string today();

}  // namespace touchstone::comparison
