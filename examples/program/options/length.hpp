#pragma once

#include <string>

namespace touchstone::program {

/// A length as the command line has it: metres, or a share of a part's diagonal.
struct Length {
  double value = 0.0;  ///< [m], or a share: 0.02 for 2%
  bool is_share = false;

  double metres(double diagonal) const { return is_share ? value * diagonal : value; }
};

/// Reads "2mm", "0.9 mm", "1.5cm", "0.02m", "1in" or "2%"; `option` stands in errors.
/// @throws InputError for anything else, and for what is not positive and finite.
Length parse_length(const std::string& text, const std::string& option);

/// Metres a unit: "m", "cm", "mm", "in", "ft", or a number of metres. @throws InputError for anything else.
double parse_unit(const std::string& text);

}  // namespace touchstone::program
