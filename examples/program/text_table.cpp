#include "touchstone/examples/program/text_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace touchstone::comparison {
namespace {

// Columns are counted in code points: cells may hold UTF-8.
std::size_t width(const std::string& text) {
  return static_cast<std::size_t>(std::count_if(
      text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xc0) != 0x80; }));
}

}  // namespace

std::string TextTable::str() const {
  std::vector<std::size_t> widths;
  for (const auto& row : rows_) {
    widths.resize(std::max(widths.size(), row.size()), 0);
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], width(row[i]));
  }
  std::string text;
  for (std::size_t r = 0; r < rows_.size(); ++r) {
    std::string line;
    for (std::size_t i = 0; i < rows_[r].size(); ++i) {
      const std::string padding(widths[i] - width(rows_[r][i]), ' ');
      line.append(2, ' ');
      if (i > 0) line += padding;
      line += rows_[r][i];
      if (i == 0) line += padding;
    }
    line.erase(line.find_last_not_of(' ') + 1);
    text += line + "\n";
  }
  return text;
}

std::string format_count(std::size_t count) {
  std::string digits = std::to_string(count);
  for (std::ptrdiff_t i = static_cast<std::ptrdiff_t>(digits.size()) - 3; i > 0; i -= 3) {
    digits.insert(static_cast<std::size_t>(i), 1, ' ');
  }
  return digits;
}

std::string format_ns(double nanoseconds) {
  if (std::isnan(nanoseconds)) return "-";
  if (nanoseconds < 99.95) return fmt::format("{:.1f}", nanoseconds);
  return format_count(static_cast<std::size_t>(std::llround(nanoseconds)));
}

std::string format_error(double value) {
  if (std::isnan(value)) return "-";
  if (value == 0.0) return "0";
  return fmt::format("{:.1e}", value);
}

std::string format_ratio(double ratio) {
  if (!std::isfinite(ratio)) return "-";
  if (ratio < 9.95) return fmt::format("{:.2f}x", ratio);
  return fmt::format("{:.0f}x", ratio);
}

}  // namespace touchstone::comparison
