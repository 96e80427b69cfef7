#pragma once

#include <cmath>
#include <cstddef>
#include <initializer_list>
#include <string>
#include <utility>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/examples/compare_backends/names.hpp"
#include "touchstone/examples/program/files/json.hpp"

// Figures of results files, which anybody may have written. All throw InputError, without the file's name,
// for what is none, and nlohmann::json::exception where one is missing.

namespace touchstone::comparison {

/// Reads counts by their names.
inline void read_counts(const Json& json, std::initializer_list<std::pair<const char*, std::size_t&>> into) {
  for (const auto& [name, count] : into) {
    if (!json.at(name).is_number_unsigned()) throw InputError(std::string("'") + name + "' is no count");
    json.at(name).get_to(count);
  }
}

/// Refuses counts that are parts of a whole and add up to more. Not by
/// their sum: that of hostile counts goes round. @param complaint says which
inline void check_parts(std::initializer_list<std::size_t> parts, std::size_t whole, const char* complaint) {
  std::size_t left = whole;
  for (const std::size_t part : parts) {
    if (part > left) throw InputError(complaint);
    left -= part;
  }
}

/// Reads a time: finite and above 0. @param may_lack NaN is one, too: there were too few.
inline double read_time(const Json& json, const char* name, bool may_lack = false) {
  const double time = number_of(json.at(name));
  if (may_lack && std::isnan(time)) return time;
  if (!(time > 0) || std::isinf(time)) throw InputError(std::string("'") + name + "' is no time");
  return time;
}

/// Reads what answers cost: at least 0, perhaps infinite.
inline double read_cost(const Json& json, const char* name) {
  const double cost = number_of(json.at(name));
  if (!(cost >= 0)) throw InputError(std::string("'") + name + "' is no cost");
  return cost;
}

}  // namespace touchstone::comparison
