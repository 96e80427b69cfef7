#pragma once

#include <string>

#include "touchstone/examples/compare_backends/page/html.hpp"

// The page, section by section. Each is markup that needs neither script nor request, and is empty where the
// run has nothing for it, or says in a labelled gap what is missing.

namespace touchstone::comparison {

std::string choose_section(const Page& page);   ///< the controls of the choice
std::string verdict_section(const Page& page);  ///< with the controls' data
/// The backend that the verdict names as the page opens; empty: none.
std::string opening_backend(const Report& report);
std::string backends_section(const Page& page);     ///< the compared backends: marks and names
std::string ranking_section(const Page& page);      ///< every query's backends by speed
std::string speed_section(const Page& page);        ///< speed against error
std::string wrongness_section(const Page& page);    ///< backends by families, with upper bounds
std::string errors_section(const Page& page);       ///< distributions, errors, patch coverage
std::string times_section(const Page& page);        ///< single, cached, batch, raw; allocations
std::string scaling_section(const Page& page);      ///< objects, hexahedra, threads
std::string gallery_section(const Page& page);      ///< the worst cases as wireframes
std::string scenes_section(const Page& page);       ///< the effect of errors on scenes
std::string drift_section(const Page& page);        ///< the effect of contact errors in dynamics
std::string consistency_section(const Page& page);  ///< the same pair by other queries and calls
std::string families_section(const Page& page);     ///< every figure of every set
std::string pair_file_section(const Page& page);
std::string method_section(const Page& page);  ///< machine, definitions, limits, schema

}  // namespace touchstone::comparison
