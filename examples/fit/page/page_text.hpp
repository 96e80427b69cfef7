#pragma once

#include <string_view>

namespace touchstone::fitting {

/// A file of this folder as it was when the program was built, by its name, "page.css".
/// @throws std::out_of_range for a name that the build does not embed.
std::string_view fit_page_text(std::string_view name);

}  // namespace touchstone::fitting
