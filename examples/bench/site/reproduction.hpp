#pragma once

#include "touchstone/examples/bench/site/cell.hpp"
#include "touchstone/examples/measures/pairs/pair_set.hpp"
#include "touchstone/examples/measures/truth/oracle.hpp"

namespace touchstone::comparison {

/// The set with the one case `index` alone.
PairSet one_case(const PairSet& set, std::size_t index);

/// A solid and where it is, and the place alone, as indented lines.
std::string solid_text(const Hexahedron& solid, const Pose& X_WS);
std::string pose_text(const Pose& X_WS);

/// A reproduction to file at an engine's tracker: shapes, poses, world vertices, the exact answer, the
/// engine's, how to ask again (Markdown).
/// @param set of one case. @param file the pair file that holds it, by its name.
std::string reproduction_text(const Entry& entry, QueryKind query, const FiledAnswer& answer,
                              const PairSet& set, const PairTruth& truth, const std::string& file);

}  // namespace touchstone::comparison
