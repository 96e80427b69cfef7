#pragma once

#include <array>
#include <map>
#include <string>
#include <vector>

#include "touchstone/examples/bench/site/path_cell.hpp"
#include "touchstone/examples/compare_backends/judge/set_result.hpp"
#include "touchstone/examples/compare_backends/run/sets/corpus.hpp"
#include "touchstone/examples/program/files/json.hpp"

namespace touchstone::comparison {

/// One answer that a results file names: the case and the engine's answer.
struct FiledAnswer {
  std::string id, reason, status;
  double cost = 0;           ///< [m]
  double separation = kNaN;  ///< NaN: none
  Vector3 n_AB_W = Vector3::Constant(kNaN);
};

/// One engine's answers to one query about one set.
struct Cell {
  Wrongness wrong;
  Quantiles cost;  ///< over S
  std::optional<Timing> single;
  std::vector<FiledAnswer> wrong_cases;  ///< the dearest first, at most kKeptWrongCases
  FiledAnswer worst;
};

/// One engine of one results file.
struct Entry {
  std::string engine, description;  ///< the description carries the version
  std::string file, machine;
  std::string measured;  ///< "2026-11-28, touchstone 0.2.0": when, and by which version of ours
  std::map<std::string, std::array<Cell, 3>> sets;  ///< by set and QueryKind
  std::map<std::string, PathCell> paths;            ///< by set of paths

  /// Over all sets.
  Wrongness wrong(QueryKind query) const;
  double worst_over_scale(QueryKind query) const;
};

/// Any number of results files of one corpus.
struct BenchResults {
  std::string corpus_sha256;
  std::vector<std::string> sets;        ///< in the corpus's order
  std::vector<FiledPathSet> path_sets;  ///< in the corpus's order
  std::vector<Entry> entries;           ///< as the files come, and in these
  /// Of each engine the last entry: a later file replaces an earlier one.
  std::vector<Entry> newest() const;
};

/// @throws InputError naming the file: unreadable, of another corpus, partial (said to be, or without some
/// of the corpus's sets or pairs) or without truth.
BenchResults read_bench_results(const std::vector<std::string>& files, const Corpus& corpus);

/// The entries' figures of one set as the plots take them.
SetResult set_result(const std::vector<Entry>& entries, const std::string& set);

}  // namespace touchstone::comparison
