#include "touchstone/examples/program/terminal/text_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace touchstone::program {
namespace {

// Columns are counted in code points: cells may hold UTF-8.
std::size_t width(const std::string& text) {
  return static_cast<std::size_t>(std::count_if(
      text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xc0) != 0x80; }));
}

// A list's text begins by here.
constexpr std::size_t kTextBegins = 40;

bool is_digit(char c) { return c >= '0' && c <= '9'; }

// Where what does not fit on the line goes on.
std::size_t hanging_indent(const std::string& line) {
  const std::size_t gap = line.rfind("  ", kTextBegins);
  const std::size_t text = line.find_first_not_of(' ');
  if (gap != std::string::npos && gap > text) return gap + 2;
  return text < 8 ? text + 2 : text;
}

std::string wrapped_line(std::string line, std::size_t columns) {
  std::string text;
  for (const std::size_t indent = hanging_indent(line); width(line) > columns;) {
    std::size_t cut = line.rfind(' ', columns);
    while (cut != std::string::npos && cut > indent && is_digit(line[cut - 1]) && is_digit(line[cut + 1]))
      cut = line.rfind(' ', cut - 1);
    if (cut == std::string::npos || cut <= indent) break;
    text += line.substr(0, cut) + "\n";
    line = std::string(indent, ' ') + line.substr(cut + 1);
  }
  return text + line;
}

}  // namespace

std::string wrapped(const std::string& text, std::size_t columns) {
  std::string all;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    all += wrapped_line(text.substr(begin, end - begin), columns);
    if (end < text.size()) all += '\n';
    begin = end + 1;
  }
  return all;
}

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
  // Of a wrong class where solids touch exactly: no length, but not right.
  if (value > 0.0 && value < std::numeric_limits<double>::min()) return "> 0";
  return fmt::format("{:.1e}", value);
}

std::string format_ratio(double ratio) {
  if (!std::isfinite(ratio)) return "-";
  if (ratio < 9.95) return fmt::format("{:.2f}x", ratio);
  return fmt::format("{:.0f}x", ratio);
}

}  // namespace touchstone::program
