#pragma once

#include <string>

#include "touchstone/tests/proof/posed_solids.hpp"

namespace touchstone::proof {

/// The pair as one case of a pair file (adapters/scene_files/README.md), every figure with 17 digits.
std::string pair_text(const PosedSolids& solids, const std::string& id = "pair");

}  // namespace touchstone::proof
