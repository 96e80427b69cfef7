#pragma once

#include <cstdint>
#include <memory>

#include "contact_core/narrowphase/narrowphase.hpp"

namespace touchstone::libccd {

enum class Method : std::uint8_t { gjk, mpr };

std::unique_ptr<Narrowphase> make_narrowphase(Method method);
std::unique_ptr<RawCheck> make_raw_check(Method method);

}  // namespace touchstone::libccd
