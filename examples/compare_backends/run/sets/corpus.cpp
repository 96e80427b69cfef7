#include "touchstone/examples/compare_backends/run/sets/corpus.hpp"

#include <filesystem>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/examples/compare_backends/run/sets/pair_file_run.hpp"
#include "touchstone/examples/program/files/json.hpp"
#include "touchstone/examples/program/files/json_error.hpp"
#include "touchstone/examples/program/files/sha256.hpp"

namespace touchstone::comparison {
namespace {

std::string path_in(const Corpus& corpus, const std::string& file) {
  return (std::filesystem::path(corpus.folder) / file).string();
}

std::string read(const std::string& path) { return read_file(path, "--corpus"); }

void check_hash(const std::string& path, const std::string& expected) {
  if (sha256(read(path)) != expected)
    throw InputError("--corpus: " + path + ": is not the file that the manifest names (SHA-256 " + expected +
                     ")");
}

CorpusSet set_of(const Json& json) {
  CorpusSet set;
  set.name = json.at("name");
  set.description = json.at("description");
  set.pairs = json.at("pairs");
  set.truth = json.at("truth");
  set.cases = json.at("cases");
  set.pairs_sha256 = json.at("pairs_sha256");
  set.truth_sha256 = json.at("truth_sha256");
  return set;
}

PairClass class_named(const std::string& name) {
  for (const PairClass each : {PairClass::separated, PairClass::touching, PairClass::penetrating})
    if (name == to_string(each)) return each;
  throw InputError("'" + name + "' is no class of a pair");
}

}  // namespace

Corpus load_corpus(const std::string& folder) {
  Corpus corpus;
  corpus.folder = folder;
  const std::string manifest = path_in(corpus, kCorpusManifest);
  const std::string text = read(manifest);
  try {
    const Json root = Json::parse(text);
    if (root.at("schema") != kCorpusSchema) throw InputError("schema is not " + std::string(kCorpusSchema));
    corpus.name = root.at("name");
    corpus.version = root.at("version");
    for (const Json& set : root.at("sets")) corpus.sets.push_back(set_of(set));
  } catch (const nlohmann::json::exception& error) {
    throw InputError("--corpus: " + manifest + ": " + reason_of(error));
  } catch (const InputError& error) {
    throw InputError("--corpus: " + manifest + ": " + error.what());
  }
  corpus.sha256 = sha256(text);
  for (const CorpusSet& set : corpus.sets) {
    check_hash(path_in(corpus, set.pairs), set.pairs_sha256);
    check_hash(path_in(corpus, set.truth), set.truth_sha256);
  }
  return corpus;
}

PairSet corpus_pairs(const Corpus& corpus, const CorpusSet& set) {
  const std::string path = path_in(corpus, set.pairs);
  PairFileCases file = load_pair_file(path);
  for (const PairFileCases::Case& each : file.cases)
    if (!each.invalid.empty())
      throw InputError("--corpus: " + path + ": case '" + each.id + "': " + each.invalid);
  if (file.cases.size() != set.cases)
    throw InputError("--corpus: " + path + ": has another number of cases than the manifest says");
  file.set.name = set.name;
  file.set.description = set.description;
  return std::move(file.set);
}

std::vector<PairTruth> corpus_truth(const Corpus& corpus, const CorpusSet& set) {
  const std::string path = path_in(corpus, set.truth);
  std::vector<PairTruth> truth;
  try {
    for (const Json& each : Json::parse(read(path))) {
      PairTruth& here = truth.emplace_back();
      here.pair_class = class_named(each.at(1));
      here.separation = each.at(2);
      here.n_AB_W = Vector3::Constant(kNaN);
    }
  } catch (const nlohmann::json::exception& error) {
    throw InputError("--corpus: " + path + ": " + reason_of(error));
  } catch (const InputError& error) {
    throw InputError("--corpus: " + path + ": " + error.what());
  }
  if (truth.size() != set.cases)
    throw InputError("--corpus: " + path + ": has another number of cases than the manifest says");
  return truth;
}

void check_truth(const Corpus& corpus, const CorpusSet& set, std::span<const PairTruth> truth) {
  const std::vector<PairTruth> known = corpus_truth(corpus, set);
  for (std::size_t i = 0; i < known.size(); ++i) {
    if (known[i].pair_class == truth[i].pair_class && known[i].separation == truth[i].separation) continue;
    const std::string id = case_id(corpus_pairs(corpus, set), i);
    throw InputError("--corpus: " + set.name + ": case '" + id +
                     "': the truth in the corpus is not what `exact` says here");
  }
}

std::string truth_text(const PairSet& set, std::span<const PairTruth> truth) {
  std::string text = "[";
  for (std::size_t i = 0; i < truth.size(); ++i)
    text += (i == 0 ? "\n" : ",\n") +
            one_line(Json::array({case_id(set, i), to_string(truth[i].pair_class), truth[i].separation}));
  return text + "\n]\n";
}

}  // namespace touchstone::comparison
