#include "touchstone/examples/program/terminal/date.hpp"

#include <fmt/chrono.h>

#include <ctime>

namespace touchstone::program {

std::string today() { return fmt::format("{:%Y-%m-%d}", fmt::gmtime(std::time(nullptr))); }

}  // namespace touchstone::program
