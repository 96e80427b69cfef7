#pragma once

#include <cstdint>
#include <memory>

#include "touchstone/contact_core/narrowphase/raw_check.hpp"

namespace touchstone::libccd {

enum class Method : std::uint8_t { gjk, mpr };

inline constexpr unsigned long kIterations = 100;

std::unique_ptr<Narrowphase> make_narrowphase(Method method, unsigned long iterations = kIterations);
std::unique_ptr<RawCheck> make_raw_check(Method method);

}  // namespace touchstone::libccd
