#pragma once

#include <cstdint>
#include <memory>

#include "touchstone/contact_core/narrowphase/raw_check.hpp"

namespace touchstone::fcl_adapter {

enum class Solver : std::uint8_t { libccd, indep };

std::unique_ptr<Narrowphase> make_narrowphase(Solver solver);
std::unique_ptr<RawCheck> make_raw_check(Solver solver);

}  // namespace touchstone::fcl_adapter
