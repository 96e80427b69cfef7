#pragma once

#include <string>

#include "touchstone/tests/proof/pairs/posed_solids.hpp"

namespace touchstone::proof {

/// With 17 digits, which are read back as the same double.
std::string all_digits(double value);

/// The pair as one case of a pair file (adapters/scene_files/README.md), every figure with 17 digits.
std::string pair_text(const PosedSolids& solids, const std::string& id = "pair");

}  // namespace touchstone::proof
