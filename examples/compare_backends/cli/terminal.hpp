#pragma once

#include <string>

#include "touchstone/examples/compare_backends/run/report.hpp"

namespace touchstone::comparison {

/// The part of a report that is printed already.
struct Shown {
  bool head = false, pair_file = false, broadphases = false, selection = false;
  std::size_t sets = 0, scenes = 0;
};

/// The tables that a report has beyond those, for a terminal of 120 columns; they are shown then.
std::string new_tables(const Report& report, Shown& shown);

/// The tables that are not shown yet, and their summary.
std::string terminal_report(const Report& report, Shown shown = {});

/// The verdict and its ranking.
std::string verdict_text(const Verdict& verdict);

}  // namespace touchstone::comparison
