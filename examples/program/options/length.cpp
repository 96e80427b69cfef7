#include "touchstone/examples/program/options/length.hpp"

#include <charconv>
#include <cmath>
#include <map>

#include "touchstone/contact_core/input_error.hpp"

namespace touchstone::program {
namespace {

const std::map<std::string, double>& units() {
  static const std::map<std::string, double> all = {{"m", 1.0},   {"cm", 1e-2},   {"mm", 1e-3},
                                                    {"um", 1e-6}, {"in", 0.0254}, {"ft", 0.3048}};
  return all;
}

// The number in front; what follows it, without blanks, is `rest`.
bool parse_number(const std::string& text, double& value, std::string& rest) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc()) return false;
  rest.clear();
  for (const char* c = end; c != text.data() + text.size(); ++c)
    if (*c != ' ') rest += *c;
  return std::isfinite(value) && value > 0.0;
}

}  // namespace

Length parse_length(const std::string& text, const std::string& option) {
  Length length;
  std::string unit;
  if (parse_number(text, length.value, unit)) {
    if (unit == "%") return {length.value / 100.0, true};
    const auto found = units().find(unit);
    if (found != units().end()) return {length.value * found->second, false};
  }
  reject(option, "'" + text + "' is no length such as 2mm, 0.5cm, 0.02m, 1in or 2% of the diagonal");
}

double parse_unit(const std::string& text) {
  const auto found = units().find(text);
  if (found != units().end()) return found->second;
  double value = 0;
  std::string rest;
  if (parse_number(text, value, rest) && rest.empty()) return value;
  reject("--unit", "'" + text + "' is none of m, cm, mm, um, in, ft, and no number of metres");
}

}  // namespace touchstone::program
