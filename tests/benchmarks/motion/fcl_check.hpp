#pragma once

#include "touchstone/contact_core/motion/sweep.hpp"

namespace touchstone::impact {

/// Prints how every setting of FCL's continuous collision answers about two cubes of which one goes past the
/// other.
void print_fcl_check();
/// CCDC_NAIVE with a hundred times as many poses as by default.
SweepEntry fcl_naive_1000();

}  // namespace touchstone::impact
