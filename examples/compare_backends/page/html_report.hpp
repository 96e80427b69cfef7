#pragma once

#include <string>

#include "touchstone/examples/compare_backends/run/report.hpp"

namespace touchstone::comparison {

/// One self-contained page: no request; readable without its script, which re-ranks the
/// verdict for another allowed error; light, dark and print.
std::string html_report(const Report& report);

}  // namespace touchstone::comparison
