#include "touchstone/examples/compare_backends/run/sets/corpus.hpp"

#include <filesystem>
#include <functional>

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
  if (!json.contains("impacts")) return set;
  set.poses = json.at("poses");
  set.impacts = json.at("impacts");
  set.impacts_sha256 = json.at("impacts_sha256");
  if (set.poses < 2 || set.cases % set.poses != 0)
    throw InputError(set.name + ": 'poses' do not divide its cases into paths");
  return set;
}

PairClass class_named(const std::string& name) {
  for (const PairClass each : {PairClass::separated, PairClass::touching, PairClass::penetrating})
    if (name == to_string(each)) return each;
  throw InputError("'" + name + "' is no class of a pair");
}

PathClass path_class_named(const std::string& name) {
  for (const PathClass each : {PathClass::clear, PathClass::meets, PathClass::open})
    if (name == to_string(each)) return each;
  throw InputError("'" + name + "' is no class of a path");
}

/// The entries of a list in the corpus, each made by `make`.
/// @throws InputError naming the file: of another format, another number of entries.
template <class Entry, class Make>
std::vector<Entry> entries_of(const std::string& path, std::size_t count, const char* of, const Make& make) {
  std::vector<Entry> entries;
  try {
    for (const Json& each : Json::parse(read(path))) entries.push_back(make(each));
  } catch (const nlohmann::json::exception& error) {
    throw InputError("--corpus: " + path + ": " + reason_of(error));
  } catch (const InputError& error) {
    throw InputError("--corpus: " + path + ": " + error.what());
  }
  if (entries.size() != count)
    throw InputError("--corpus: " + path + ": has another number of " + of + " than the manifest says");
  return entries;
}

template <class Entry>
std::string list_text(std::span<const Entry> entries, const std::function<Json(std::size_t)>& line) {
  std::string text = "[";
  for (std::size_t i = 0; i < entries.size(); ++i) text += (i == 0 ? "\n" : ",\n") + one_line(line(i));
  return text + "\n]\n";
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
    if (set.is_paths()) check_hash(path_in(corpus, set.impacts), set.impacts_sha256);
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
  return entries_of<PairTruth>(path_in(corpus, set.truth), set.cases, "cases", [](const Json& json) {
    PairTruth here;
    here.pair_class = class_named(json.at(1));
    here.separation = json.at(2);
    here.n_AB_W = Vector3::Constant(kNaN);
    return here;
  });
}

std::vector<PathTruth> corpus_impacts(const Corpus& corpus, const CorpusSet& set) {
  return entries_of<PathTruth>(path_in(corpus, set.impacts), set.cases / set.poses, "paths",
                               [](const Json& json) {
                                 return PathTruth{path_class_named(json.at(1)), json.at(2), json.at(3)};
                               });
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

void check_impacts(const Corpus& corpus, const CorpusSet& set, const PairSet& pairs,
                   std::span<const PathTruth> truth) {
  const std::vector<PathTruth> known = corpus_impacts(corpus, set);
  for (std::size_t i = 0; i < known.size(); ++i)
    if (known[i] != truth[i])
      throw InputError("--corpus: " + set.name + ": path '" + paths_of(pairs, set.poses, i).id +
                       "': the time of impact in the corpus is not what `exact` says here");
}

std::string truth_text(const PairSet& set, std::span<const PairTruth> truth) {
  return list_text(truth, [&](std::size_t i) {
    return Json::array({case_id(set, i), to_string(truth[i].pair_class), truth[i].separation});
  });
}

std::string impacts_text(const PairSet& set, std::size_t poses, std::span<const PathTruth> truth) {
  return list_text(truth, [&](std::size_t i) {
    return Json::array(
        {paths_of(set, poses, i).id, to_string(truth[i].path_class), truth[i].lo, truth[i].hi});
  });
}

}  // namespace touchstone::comparison
