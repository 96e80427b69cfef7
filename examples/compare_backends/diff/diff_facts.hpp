#pragma once

#include <array>
#include <compare>
#include <map>
#include <string>
#include <vector>

#include "touchstone/examples/compare_backends/names.hpp"
#include "touchstone/examples/program/files/json.hpp"

namespace touchstone::comparison {

/// Identifies one figure of a results.json.
struct FactKey {
  std::string where;  ///< set, scene or swarm
  std::string query;  ///< may be empty
  std::string backend;
  std::string what;  ///< "missed", "depth over S", "single"
  auto operator<=>(const FactKey&) const = default;
};

/// A figure that either is the same in two runs or has changed.
struct Fact {
  Json value;
  std::string text;  ///< the value as a reader sees it
  std::string note;  ///< the case it comes from; may be empty
};

enum class FactPart { wrong, error, consistency, allocations };
inline constexpr std::size_t kFactParts = 4;

/// Everything of one results.json that diff compares; what was not measured has no entry.
struct ReportFacts {
  bool exact = false;  ///< without, there is neither wrongness nor error
  std::array<std::map<FactKey, Fact>, kFactParts> parts;
  std::map<FactKey, std::vector<double>> times;         ///< the medians of the repetitions [ns]
  std::map<FactKey, std::vector<double>> thread_times;  ///< of whole passes over a set [ns a pair]
};

/// @throws nlohmann::json::exception where a key is missing that every such file has.
ReportFacts facts_of(const Json& results);

}  // namespace touchstone::comparison
