#pragma once

#include "touchstone/examples/bench/corpus/corpus_plan.hpp"
#include "touchstone/examples/measures/truth/oracle.hpp"
#include "touchstone/examples/program/files/report_files.hpp"

namespace touchstone::comparison {

/// The names of the files that corpus_files() returns.
std::vector<std::string> corpus_names(const CorpusPlan& plan);

/// The corpus: pairs and truth of every set, and its manifest with their hashes.
/// @param freeze take what is drawn, whatever hashes the plan has: for a new version.
/// @throws InputError naming a set whose files are not those that the plan's hashes name.
std::vector<ReportFile> corpus_files(const CorpusPlan& plan, const Oracle& oracle, int threads, bool freeze,
                                     const std::function<void(const std::string&)>& on_set);

/// Pairs of a set as cases of a pair file.
std::string pair_file_text(const PairSet& set);

}  // namespace touchstone::comparison
