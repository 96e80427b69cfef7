#pragma once

#include "touchstone/examples/bench/site/cell.hpp"
#include "touchstone/examples/compare_backends/run/sets/corpus.hpp"
#include "touchstone/examples/program/files/report_files.hpp"

namespace touchstone::comparison {

/// The names of the files that case_files() returns.
std::vector<std::string> case_names(const std::vector<Entry>& entries, const Corpus& corpus);

/// A page a set with every wrong cell's cases, drawn, beside the exact answer; and for each wrong cell a text
/// that can be filed upstream, with a pair file.
std::vector<ReportFile> case_files(const std::vector<Entry>& entries, const Corpus& corpus,
                                   const Oracle& oracle);

/// A page of the site. @param root the way from the page to the site's root, "" or "../".
std::string site_page(const std::string& title, const std::string& body, const std::string& root);

}  // namespace touchstone::comparison
