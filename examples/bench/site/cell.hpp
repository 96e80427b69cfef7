#pragma once

#include "touchstone/examples/bench/site/bench_results.hpp"

namespace touchstone::comparison {

/// How a cell of the site's tables reads. The rules are in examples/bench/README.md.
enum class Grade : std::uint8_t {
  right,        ///< every class right, every error below kCoarse S
  coarse,       ///< undecided answers, or a cost from kCoarse S on
  wrong,        ///< a wrong class, a failure, a missing value, or a cost from kFar S on
  not_answered  ///< nothing was answered: unsupported
};
inline constexpr double kCoarse = 1e-6, kFar = 1e-3;

/// The cost of an answer as a page shows it: 0 where that is the least above 0, by which a wrong class is
/// charged where solids touch exactly (measures/accuracy), over S or not.
double shown_cost(double cost);

Grade grade(const Cell& cell);
/// The CSS class of a grade.
const char* style_of(Grade grade);
/// "3 of 1 000 missed", "2e-16".
std::string text_of(const Cell& cell);
/// format_count() of which a line does not end within.
std::string unbroken_count(std::size_t count);
/// The answers behind a wrong cell, the dearest first; empty of others.
std::vector<FiledAnswer> faults(const Cell& cell);
/// Names an engine's cell in addresses and file names: letters, digits, _ - + and dots only.
std::string cell_name(const Entry& entry, const std::string& set, QueryKind query);

}  // namespace touchstone::comparison
