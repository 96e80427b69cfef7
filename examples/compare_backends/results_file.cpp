#include "examples/compare_backends/results_file.hpp"

#include <filesystem>
#include <fstream>
#include <limits>

#include "contact_core/input_error.hpp"
#include "examples/compare_backends/options.hpp"

namespace touchstone::comparison {
namespace {

Candidate candidate_of(const Json& json) {
  Candidate candidate;
  candidate.backend = json.at("backend");
  candidate.nanoseconds = number_of(json.at("mean_ns"));
  candidate.worst_cost = number_of(json.at("worst_cost_m"));
  candidate.worst_id = json.at("worst_case");
  candidate.worst_reason = json.at("worst_reason");
  Wrongness& wrong = candidate.wrong;
  wrong.cases = json.at("cases");
  wrong.missed = json.at("missed");
  wrong.phantom = json.at("phantom");
  wrong.undecided = json.at("undecided");
  wrong.failed = json.at("failed");
  wrong.unsupported = json.at("unsupported");
  wrong.missing = json.at("missing_value");
  return candidate;
}

}  // namespace

double number_of(const Json& value) {
  if (value.is_null()) return std::numeric_limits<double>::quiet_NaN();
  if (value == "inf") return std::numeric_limits<double>::infinity();
  return value.get<double>();
}

Json parse_results(const std::string& text, const std::string& who, const std::string& what) {
  try {
    Json results = Json::parse(text);
    if (!results.at("schema").get<std::string>().starts_with("touchstone.compare_backends/"))
      throw InputError(who + ": " + what + " is no results.json of compare_backends");
    return results;
  } catch (const nlohmann::json::exception& error) {
    throw InputError(who + ": " + what + ": " + error.what());
  }
}

std::string read_file(const std::string& path, const std::string& who) {
  std::ifstream stream(path, std::ios::binary);
  if (!stream || !std::filesystem::is_regular_file(path))
    throw InputError(who + ": " + path + " cannot be read");
  return {std::istreambuf_iterator<char>(stream), {}};
}

std::vector<Candidates> candidates_of(const Json& results, const std::string& who) {
  try {
    std::vector<Candidates> all;
    for (const Json& of_query : results.at("candidates")) {
      Candidates candidates{query_named(of_query.at("query")), {}};
      for (const Json& each : of_query.at("candidates")) candidates.candidates.push_back(candidate_of(each));
      all.push_back(std::move(candidates));
    }
    return all;
  } catch (const nlohmann::json::exception& error) {
    throw InputError(who + ": " + error.what());
  }
}

}  // namespace touchstone::comparison
