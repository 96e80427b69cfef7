#pragma once

#include <fmt/format.h>

#include <cmath>
#include <string>

namespace touchstone::program {

/// Shortest digits that read back as the same double; empty for NaN.
inline std::string csv_number(double value) { return std::isnan(value) ? "" : fmt::format("{}", value); }

/// Quoted where it holds a comma, a quote or a line break (RFC 4180).
inline std::string csv_text(const std::string& text) {
  if (text.find_first_of(",\"\n\r") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

}  // namespace touchstone::program
