#pragma once

#include <memory>

#include "touchstone/contact_core/narrowphase/raw_check.hpp"

namespace touchstone::ode {

std::unique_ptr<Narrowphase> make_narrowphase();
std::unique_ptr<RawCheck> make_raw_check();

}  // namespace touchstone::ode
