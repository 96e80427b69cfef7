#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace touchstone::program {

/// Returns what is wrong with a file in our words, not in the library's: "is no JSON, at line 1, column 8",
/// "has no 'schema'".
std::string reason_of(const nlohmann::json::exception& error);

}  // namespace touchstone::program
