#pragma once

#include <string>

namespace touchstone::program {

/// The word as a POSIX shell takes it back: as it is where every character is harmless, else in single
/// quotes.
inline std::string shell_word(const std::string& word) {
  constexpr const char* kHarmless =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_@%+=:,./-";
  if (!word.empty() && word.find_first_not_of(kHarmless) == std::string::npos) return word;
  std::string quoted = "'";
  for (const char c : word) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

}  // namespace touchstone::program
