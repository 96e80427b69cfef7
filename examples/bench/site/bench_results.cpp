#include "touchstone/examples/bench/site/bench_results.hpp"

#include <algorithm>
#include <filesystem>
#include <set>

#include "touchstone/adapters/plugin/engine_name.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/examples/bench/site/counts.hpp"
#include "touchstone/examples/compare_backends/results/results_file.hpp"
#include "touchstone/examples/program/files/json_error.hpp"

namespace touchstone::comparison {
namespace {

Vector3 vector_of(const Json& json) {
  return {number_of(json.at(0)), number_of(json.at(1)), number_of(json.at(2))};
}

FiledAnswer answer_of(const Json& json) {
  FiledAnswer answer;
  answer.id = json.at("case");
  answer.reason = json.at("reason");
  answer.status = json.at("status");
  answer.cost = read_cost(json, "cost_m");
  answer.separation = number_of(json.at("separation_m"));
  answer.n_AB_W = vector_of(json.at("normal"));
  return answer;
}

Wrongness wrongness_of(const Json& json) {
  Wrongness wrong;
  read_counts(json, {{"cases", wrong.cases},
                     {"missed", wrong.missed},
                     {"phantom", wrong.phantom},
                     {"undecided", wrong.undecided},
                     {"failed", wrong.failed},
                     {"unsupported", wrong.unsupported},
                     {"missing_value", wrong.missing}});
  check_parts({wrong.missed, wrong.phantom, wrong.undecided, wrong.failed, wrong.missing, wrong.unsupported},
              wrong.cases, "there are more wrong and unsupported answers than 'cases'");
  return wrong;
}

std::optional<Timing> timing_of(const Json& json) {
  if (json.is_null()) return std::nullopt;
  Timing timing;
  timing.median_ns = read_time(json, "median_ns");
  timing.minimum_ns = read_time(json, "minimum_ns");
  timing.p99_ns = read_time(json, "p99_ns", true);
  read_counts(json, {{"blocks", timing.blocks}});
  return timing;
}

Cell cell_of(const Json& json) {
  Cell cell;
  cell.wrong = wrongness_of(json.at("wrong"));
  cell.single = timing_of(json.at("single"));
  if (const Json& cost = json.at("cost_over_S"); !cost.is_null()) {
    cell.cost.median = read_cost(cost, "median");
    cell.cost.p99 = read_cost(cost, "p99");
    cell.cost.worst = read_cost(cost, "worst");
    read_counts(cost, {{"cases", cell.cost.count}});
    if (cell.cost.count == 0) throw InputError("'cost_over_S' has no cases");  // null says that
    cell.worst = answer_of(json.at("worst"));
  }
  for (const Json& each : json.at("wrong_cases")) cell.wrong_cases.push_back(answer_of(each));
  return cell;
}

/// nullptr: the corpus has none of that name.
const CorpusSet* find_set(const Corpus& corpus, const std::string& name) {
  const auto found = std::find_if(corpus.sets.begin(), corpus.sets.end(),
                                  [&](const CorpusSet& set) { return set.name == name; });
  return found == corpus.sets.end() ? nullptr : &*found;
}

Entry& add_entry(const Json& results, const std::string& file, const Json& name, const Json& description,
                 BenchResults& into) {
  // A name becomes a part of file names and of links.
  if (!is_engine_name(name.get<std::string>()))
    throw InputError("engine '" + engine_text(name.get<std::string>()) + "': " + kNoEngineName);
  Entry& entry = into.entries.emplace_back();
  entry.engine = name;
  entry.description = description;
  entry.file = std::filesystem::path(file).filename().string();
  entry.machine = results.at("machine").at("cpu").get<std::string>();
  const std::string date = results.value("date", "");  // results of older versions have none
  entry.measured =
      date + (date.empty() ? "" : ", ") + "touchstone " + results.at("version").get<std::string>();
  return entry;
}

/// The entry of one of a path set's backends; a sweep, which is no backend, gets one of its own.
Entry& entry_of(const Json& results, const std::string& file, const Json& backend, std::size_t first,
                BenchResults& into) {
  for (std::size_t e = first; e < into.entries.size(); ++e)
    if (into.entries[e].engine == backend.at("backend").get<std::string>()) return into.entries[e];
  if (!backend.contains("sweep"))
    throw InputError("path_sets name the backend '" + backend.at("backend").get<std::string>() +
                     "', which `backends` lack");
  return add_entry(results, file, backend.at("backend"), backend.at("sweep"), into);
}

/// @param first of the file's entries.
void add_paths(const Json& results, const std::string& file, const Corpus& corpus, std::size_t first,
               BenchResults& into) {
  std::set<std::string> found;
  for (const Json& json : results.value("path_sets", Json::array())) {
    const FiledPathSet set = path_set_of(json);
    const CorpusSet* const of = find_set(corpus, set.name);
    if (of == nullptr) continue;
    if (set.poses != of->poses || set.paths != of->cases / of->poses)
      throw InputError("has " + std::to_string(set.paths) + " paths of " + std::to_string(set.poses) +
                       " poses of the corpus's set '" + set.name + "', which has " +
                       std::to_string(of->cases / of->poses) + " of " + std::to_string(of->poses));
    found.insert(set.name);
    if (std::none_of(into.path_sets.begin(), into.path_sets.end(),
                     [&](const FiledPathSet& known) { return known.name == set.name; }))
      into.path_sets.push_back(set);
    for (const Json& backend : json.at("backends"))
      entry_of(results, file, backend, first, into).paths[set.name] = path_cell_of(backend, set.paths);
  }
  for (const CorpusSet& set : corpus.sets)
    if (set.is_paths() && !found.contains(set.name))
      throw InputError("lacks the paths of the corpus's set '" + set.name + "'");
}

/// A file from which sets or pairs were taken would show fewer wrong answers than its engines gave.
/// @param first of the file's entries, one a backend.
void check_whole(const Corpus& corpus, std::size_t first, const BenchResults& in) {
  for (std::size_t e = first; e < in.entries.size(); ++e) {
    const Entry& entry = in.entries[e];
    for (const CorpusSet& set : corpus.sets) {
      const auto found = entry.sets.find(set.name);
      if (found == entry.sets.end())
        throw InputError("'" + entry.engine + "' lacks the corpus's set '" + set.name + "'");
      for (const Cell& cell : found->second) {
        if (cell.wrong.cases != set.cases)
          throw InputError("'" + entry.engine + "' has " + std::to_string(cell.wrong.cases) +
                           " pairs of the corpus's set '" + set.name + "', which has " +
                           std::to_string(set.cases));
        if (cell.cost.count > set.cases)
          throw InputError("'" + entry.engine + "' has costs of more pairs than the corpus's set '" +
                           set.name + "' has");
      }
    }
  }
}

void add_entries(const Json& results, const std::string& file, const Corpus& corpus, BenchResults& into) {
  const std::size_t first = into.entries.size();
  for (const Json& backend : results.at("backends")) {
    const Json& name = backend.at("name");
    for (std::size_t e = first; e < into.entries.size(); ++e)
      if (into.entries[e].engine == name.get<std::string>())
        throw InputError("has the backend '" + into.entries[e].engine + "' twice");
    add_entry(results, file, name, backend.at("description"), into);
  }
  for (const Json& set : results.at("pair_sets")) {
    const std::string name = set.at("name");
    if (find_set(corpus, name) == nullptr) continue;  // somebody's own pairs, measured in the same run
    if (std::find(into.sets.begin(), into.sets.end(), name) == into.sets.end()) into.sets.push_back(name);
    for (const Json& backend : set.at("backends")) {
      for (std::size_t e = first; e < into.entries.size(); ++e) {
        if (into.entries[e].engine != backend.at("backend").get<std::string>()) continue;
        for (const QueryKind query : kQueryKinds)
          into.entries[e].sets[name][index_of(query)] =
              cell_of(backend.at("queries").at(std::string(to_string(query))));
      }
    }
  }
  check_whole(corpus, first, into);
  add_paths(results, file, corpus, first, into);
}

}  // namespace

Wrongness Entry::wrong(QueryKind query) const {
  Wrongness total;
  for (const auto& [name, cells] : sets) total += cells[index_of(query)].wrong;
  return total;
}

double Entry::worst_over_scale(QueryKind query) const {
  double worst = kNaN;
  for (const auto& [name, cells] : sets) {
    const Quantiles& cost = cells[index_of(query)].cost;
    if (cost.count > 0 && !(worst >= cost.worst)) worst = cost.worst;
  }
  return worst;
}

std::vector<Entry> BenchResults::newest() const {
  std::vector<Entry> kept;
  for (const Entry& entry : entries) {
    const auto known = std::find_if(kept.begin(), kept.end(),
                                    [&](const Entry& other) { return other.engine == entry.engine; });
    if (known == kept.end())
      kept.push_back(entry);
    else
      *known = entry;
  }
  return kept;
}

BenchResults read_bench_results(const std::vector<std::string>& files, const Corpus& corpus) {
  BenchResults all;
  all.corpus_sha256 = corpus.sha256;
  for (const std::string& file : files) {
    const Json results = parse_results(read_file(file, "site"), "site", file);
    try {
      if (!results.contains("corpus") || results.at("corpus").at("sha256") != corpus.sha256)
        throw InputError("was not measured on this corpus (compare_backends --corpus)");
      if (results.at("partial").get<bool>())
        throw InputError(one_line(partial_note(results, "this report")).substr(0, 300));
      if (!results.at("measured_against_exact").get<bool>())
        throw InputError("has no errors: it was measured without `exact`");
      add_entries(results, file, corpus, all);
    } catch (const nlohmann::json::exception& error) {
      throw InputError("site: " + file + ": " + reason_of(error));
    } catch (const InputError& error) {
      throw InputError("site: " + file + ": " + error.what());
    }
  }
  return all;
}

SetResult set_result(const std::vector<Entry>& entries, const std::string& set) {
  SetResult result;
  result.name = set;
  for (const Entry& entry : entries) {
    const auto found = entry.sets.find(set);
    if (found == entry.sets.end()) continue;
    BackendResult& backend = result.backends.emplace_back();
    backend.name = entry.engine;
    backend.judged = true;
    for (const QueryKind query : kQueryKinds) {
      const std::size_t q = index_of(query);
      backend.judgement.wrongness[q] = found->second[q].wrong;
      backend.judgement.cost[q] = found->second[q].cost;
      backend.rows[q].single = found->second[q].single;
      result.cases = std::max(result.cases, found->second[q].wrong.cases);
    }
  }
  return result;
}

}  // namespace touchstone::comparison
