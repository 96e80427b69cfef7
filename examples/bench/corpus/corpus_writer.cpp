#include "touchstone/examples/bench/corpus/corpus_writer.hpp"

#include "touchstone/adapters/scene_files/pair_file.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/examples/compare_backends/run/sets/corpus.hpp"
#include "touchstone/examples/compare_backends/run/sets/pair_file_run.hpp"
#include "touchstone/examples/measures/paths/path_families.hpp"
#include "touchstone/examples/program/files/sha256.hpp"

namespace touchstone::comparison {
namespace {

std::string pairs_name(const PlannedSet& set) { return set.name + ".json"; }
std::string truth_name(const PlannedSet& set) { return set.name + ".truth.json"; }
std::string impacts_name(const PlannedSet& set) { return set.name + ".impacts.json"; }

void append(PairSet& to, const PairSet& more) {
  const auto first = static_cast<SolidIndex>(to.solids.size());
  to.solids.insert(to.solids.end(), more.solids.begin(), more.solids.end());
  to.poses.insert(to.poses.end(), more.poses.begin(), more.poses.end());
  for (const SolidPair& pair : more.pairs) to.pairs.push_back({first + pair.a, first + pair.b});
  for (std::size_t i = 0; i < more.pairs.size(); ++i) to.ids.push_back(case_id(more, i));
}

PairSet pairs_of(const PlannedSet& planned) {
  PairSet set;
  if (planned.is_paths())
    append(set, make_path_family(planned.family, planned.seed, planned.count, planned.poses));
  else if (!planned.family.empty())
    append(set, make_pair_family(planned.family, planned.seed, planned.count));
  for (const std::filesystem::path& file : planned.files) append(set, load_pair_file(file.string()).set);
  set.name = planned.name;
  set.description = planned.description;
  return set;
}

void check_frozen(const PlannedSet& set, const std::string& frozen, const std::string& drawn) {
  if (!frozen.empty() && frozen != drawn)
    throw InputError("corpus: " + set.name +
                     ": this build makes other files than the manifest's hashes name; a new version is made "
                     "with --freeze");
}

}  // namespace

std::vector<std::string> corpus_names(const CorpusPlan& plan) {
  std::vector<std::string> names = {kCorpusManifest};
  for (const PlannedSet& set : plan.sets) {
    names.insert(names.end(), {pairs_name(set), truth_name(set)});
    if (set.is_paths()) names.push_back(impacts_name(set));
  }
  return names;
}

std::string pair_file_text(const PairSet& set) {
  std::vector<PairCase> cases;
  for (std::size_t i = 0; i < set.pairs.size(); ++i) {
    const auto [a, b] = set.pairs[i];
    PairCase& each = cases.emplace_back();
    each.id = case_id(set, i);
    each.pair = touchstone::PosedPair{{set.solids[a], set.solids[b]}, {set.poses[a], set.poses[b]}};
  }
  return pairs_text(cases);
}

std::vector<ReportFile> corpus_files(const CorpusPlan& plan, const Oracle& oracle, int threads, bool freeze,
                                     const std::function<void(const std::string&)>& on_set) {
  std::vector<ReportFile> files;
  Json manifest = plan.manifest;
  for (std::size_t i = 0; i < plan.sets.size(); ++i) {
    const PlannedSet& planned = plan.sets[i];
    on_set(planned.name);
    const PairSet set = pairs_of(planned);
    Json& json = manifest.at("sets").at(i);
    json["cases"] = set.pairs.size();
    // Each file, its name and its hash, under its own keys.
    const auto add = [&](const char* key, const std::string& name, const std::string& frozen,
                         std::string text) {
      const std::string hash = sha256(text);
      if (!freeze) check_frozen(planned, frozen, hash);
      json[key] = name;
      json[key + std::string("_sha256")] = hash;
      files.emplace_back(name, std::move(text));
    };
    add("pairs", pairs_name(planned), planned.pairs_sha256, pair_file_text(set));
    add("truth", truth_name(planned), planned.truth_sha256,
        truth_text(set, compute_truth(set, oracle, threads)));
    if (!planned.is_paths()) continue;
    json["poses"] = planned.poses;
    add("impacts", impacts_name(planned), planned.impacts_sha256,
        impacts_text(set, planned.poses, compute_path_truth(set, planned.poses, oracle, threads)));
  }
  files.emplace_back(kCorpusManifest, manifest.dump(1) + "\n");
  return files;
}

}  // namespace touchstone::comparison
