#pragma once

#include <memory>

#include "touchstone/contact_core/broadphase/broadphase.hpp"

namespace touchstone::ode {

std::unique_ptr<Broadphase> make_broadphase();

}  // namespace touchstone::ode
