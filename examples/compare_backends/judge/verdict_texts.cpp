#include "touchstone/examples/compare_backends/judge/verdict_texts.hpp"

#include <algorithm>
#include <stdexcept>

namespace touchstone::comparison {
namespace {

const std::string& value_of(TextValues values, std::string_view name) {
  for (const auto& [key, value] : values) {
    if (key == name) return value;
  }
  throw std::logic_error("a verdict's text has no value for '" + std::string(name) + "'");
}

}  // namespace

std::string fill(std::string_view name, TextValues values) {
  const auto found = std::find_if(std::begin(kVerdictTexts), std::end(kVerdictTexts),
                                  [&](const VerdictText& each) { return each.name == name; });
  if (found == std::end(kVerdictTexts)) throw std::logic_error("no text '" + std::string(name) + "'");
  std::string filled;
  std::string_view rest = found->text;
  for (std::size_t open; (open = rest.find('{')) != std::string_view::npos;) {
    const std::size_t close = rest.find('}', open);
    filled += rest.substr(0, open);
    filled += value_of(values, rest.substr(open + 1, close - open - 1));
    rest.remove_prefix(close + 1);
  }
  return filled += rest;
}

}  // namespace touchstone::comparison
