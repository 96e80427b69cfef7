#pragma once

#include <string_view>

namespace touchstone::program {

/// A text of the plots as it was when the program was built, by its name: "plot.css".
/// @throws std::out_of_range for a name that the build does not embed.
std::string_view plot_text(std::string_view name);

}  // namespace touchstone::program
