#pragma once

#include <initializer_list>
#include <utility>

#include "touchstone/examples/compare_backends/names.hpp"
#include "touchstone/examples/program/files/json.hpp"

namespace touchstone::comparison {

/// Reads counts by their names. @throws nlohmann::json::exception where one is missing or none.
inline void read_counts(const Json& json, std::initializer_list<std::pair<const char*, std::size_t&>> into) {
  for (const auto& [name, count] : into) json.at(name).get_to(count);
}

}  // namespace touchstone::comparison
