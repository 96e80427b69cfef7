#pragma once

#include <string>
#include <vector>

#include "touchstone/examples/compare_backends/run/report.hpp"
#include "touchstone/examples/program/files/report_files.hpp"

namespace touchstone::comparison {

/// Every figure of the page as a file of its own, figures/*.svg.
std::vector<ReportFile> figure_files(const Report& report);

/// The names of all that figure_files() may return for a report on these.
std::vector<std::string> figure_names(const std::vector<std::string>& sets,
                                      const std::vector<std::string>& backends,
                                      const std::vector<std::string>& scenes);

}  // namespace touchstone::comparison
