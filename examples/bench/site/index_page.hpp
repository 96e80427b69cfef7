#pragma once

#include "touchstone/examples/bench/site/cell.hpp"
#include "touchstone/examples/compare_backends/run/sets/corpus.hpp"

namespace touchstone::comparison {

/// The site's first page: where our own check loses, a table a query, speed against error, every engine's
/// history by version, where everything comes from.
std::string index_page(const BenchResults& results, const Corpus& corpus);

}  // namespace touchstone::comparison
