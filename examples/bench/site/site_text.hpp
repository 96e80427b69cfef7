#pragma once

#include <string_view>

namespace touchstone::comparison {

/// A file of examples/bench/site by its name.
std::string_view site_text(std::string_view name);

}  // namespace touchstone::comparison
