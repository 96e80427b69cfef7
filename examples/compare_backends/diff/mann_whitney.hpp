#pragma once

#include <span>
#include <vector>

namespace touchstone::comparison {

/// The two-sided p of Mann and Whitney's test that neither sample tends to the larger values: exact, by
/// counting all assignments of the ranks, ties by their mean rank. Cost grows as (sizes)^4; 1 for an empty
/// sample.
double mann_whitney_p(std::span<const double> x, std::span<const double> y);

/// Which of many tests hold when at most `rate` of those named may be chance (Benjamini and Hochberg, 1995).
std::vector<bool> resolved(std::span<const double> p_values, double rate);

}  // namespace touchstone::comparison
