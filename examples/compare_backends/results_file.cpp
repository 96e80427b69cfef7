#include "touchstone/examples/compare_backends/results_file.hpp"

#include <filesystem>
#include <fstream>
#include <limits>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/examples/compare_backends/options.hpp"
#include "touchstone/examples/program/json_error.hpp"

namespace touchstone::comparison {
namespace {

double not_negative(const Json& json, const char* key) {
  const double value = number_of(json.at(key));
  if (value < 0) throw InputError(std::string("'") + key + "' is negative");
  return value;
}

std::size_t count_of(const Json& json, const char* key) {
  if (!json.at(key).is_number_unsigned()) throw InputError(std::string("'") + key + "' is no count");
  return json.at(key);
}

Candidate candidate_of(const Json& json) {
  Candidate candidate;
  candidate.backend = json.at("backend");
  candidate.nanoseconds = not_negative(json, "mean_ns");
  candidate.worst_cost = not_negative(json, "worst_cost_m");
  candidate.worst_id = json.at("worst_case");
  candidate.worst_reason = json.at("worst_reason");
  Wrongness& wrong = candidate.wrong;
  wrong.cases = count_of(json, "cases");
  wrong.missed = count_of(json, "missed");
  wrong.phantom = count_of(json, "phantom");
  wrong.undecided = count_of(json, "undecided");
  wrong.failed = count_of(json, "failed");
  wrong.unsupported = count_of(json, "unsupported");
  wrong.missing = count_of(json, "missing_value");
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
    throw InputError(who + ": " + what + ": " + reason_of(error));
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
    throw InputError(who + ": candidates: " + reason_of(error));
  } catch (const std::exception& error) {
    throw InputError(who + ": candidates: " + error.what());
  }
}

}  // namespace touchstone::comparison
