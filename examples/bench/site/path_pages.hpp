#pragma once

#include "touchstone/examples/bench/site/cell.hpp"
#include "touchstone/examples/compare_backends/run/sets/corpus.hpp"
#include "touchstone/examples/program/files/report_files.hpp"

// The site's parts about motion along paths.

namespace touchstone::comparison {

Grade grade(const PathCell& cell);
std::string text_of(const PathCell& cell);
/// The answers behind a wrong cell, the dearest first; empty of others.
std::vector<FiledPath> faults(const PathCell& cell);
std::string path_cell_name(const Entry& entry, const std::string& set);

/// The first page's section; empty where no file has paths.
std::string path_section(const BenchResults& results, const std::vector<Entry>& newest);

/// A wrong cell on its set's page. Its reproduction goes to the files.
std::string path_faults(const Entry& entry, const Corpus& corpus, const CorpusSet& set, const PairSet& pairs,
                        const Oracle& oracle, std::vector<ReportFile>& files);

}  // namespace touchstone::comparison
