#include "touchstone/examples/bench/corpus/corpus_plan.hpp"

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/examples/compare_backends/run/sets/corpus.hpp"
#include "touchstone/examples/program/files/json_error.hpp"

namespace touchstone::comparison {
namespace {

PlannedSet planned(const Json& json, const std::filesystem::path& folder) {
  PlannedSet set;
  set.name = json.at("name");
  set.description = json.at("description");
  const Json& from = json.at("from");
  if (from.contains("family")) {
    set.family = from.at("family");
    set.seed = from.at("seed");
    set.count = from.at("count");
    if (from.contains("poses")) set.poses = from.at("poses");
  } else {
    for (const Json& file : from.at("files")) set.files.push_back(folder / file.get<std::string>());
  }
  set.pairs_sha256 = json.value("pairs_sha256", "");
  set.truth_sha256 = json.value("truth_sha256", "");
  set.impacts_sha256 = json.value("impacts_sha256", "");
  return set;
}

}  // namespace

CorpusPlan load_plan(const std::filesystem::path& manifest) {
  CorpusPlan plan;
  try {
    plan.manifest = Json::parse(read_file(manifest.string(), "corpus"));
    if (plan.manifest.at("schema") != kCorpusSchema)
      throw InputError("corpus: " + manifest.string() + ": schema is not " + kCorpusSchema);
    plan.name = plan.manifest.at("name");
    plan.version = plan.manifest.at("version");
    for (const Json& set : plan.manifest.at("sets"))
      plan.sets.push_back(planned(set, manifest.parent_path()));
  } catch (const nlohmann::json::exception& error) {
    throw InputError("corpus: " + manifest.string() + ": " + reason_of(error));
  }
  return plan;
}

}  // namespace touchstone::comparison
