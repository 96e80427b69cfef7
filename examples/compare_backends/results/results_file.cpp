#include "touchstone/examples/compare_backends/results/results_file.hpp"

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/examples/program/files/json_error.hpp"

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

ChoiceSet::Answers answers_of(const Json& json, QueryKind kind) {
  ChoiceSet::Answers answers;
  answers.nanoseconds = not_negative(json, "ns");
  answers.p999_ns = not_negative(json, "p999_ns");
  answers.allocations = not_negative(json, "allocations");
  answers.curves = curves_from(json.at("curves"), kind);
  return answers;
}

// The counts of another build may be of other bins.
template <std::size_t N>
void check_bins(const Json& choices, const char* key, const std::array<double, N>& known) {
  if (choices.at(key).get<std::vector<double>>() != std::vector<double>(known.begin(), known.end()))
    throw InputError(std::string("'") + key + "' are not those of this build");
}

ChoiceSet set_of(const Json& json) {
  ChoiceSet set;
  set.name = json.at("name");
  set.cases = count_of(json, "cases");
  set.ids = json.at("ids").get<std::vector<std::string>>();
  for (const Json& each : json.at("backends")) {
    ChoiceSet::Backend& backend = set.backends.emplace_back();
    backend.name = each.at("backend");
    for (const QueryKind kind : kQueryKinds)
      backend.queries[index_of(kind)] = answers_of(each.at("queries").at(std::string(to_string(kind))), kind);
  }
  return set;
}

}  // namespace

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

std::vector<ChoiceSet> choice_sets_of(const Json& results, const std::string& who) {
  try {
    const Json& choices = results.at("choices");
    check_bins(choices, "apart_bins_m", kApartBins);
    check_bins(choices, "within_bins_m", kWithinBins);
    check_bins(choices, "coverage_bins", kCoverageBins);
    std::vector<ChoiceSet> sets;
    for (const Json& set : choices.at("sets")) sets.push_back(set_of(set));
    return sets;
  } catch (const nlohmann::json::exception& error) {
    throw InputError(who + ": choices: " + reason_of(error));
  } catch (const std::exception& error) {
    throw InputError(who + ": choices: " + error.what());
  }
}

std::string partial_note(const Json& results, const std::string& what) {
  if (!results.contains("partial") || !results.at("partial").get<bool>()) return "";
  return what + " is partial: the run ended early, without " +
         joined(results.at("not_measured"), [](const Json& name) { return name.get<std::string>(); }) + "\n";
}

}  // namespace touchstone::comparison
