#include "touchstone/adapters/recorder/csv_text.hpp"

#include <algorithm>
#include <charconv>

namespace touchstone::recorder {

std::string csv_field(std::string_view text) {
  if (text.find_first_of(",\"\r\n") == std::string_view::npos) return std::string(text);
  std::string field = "\"";
  for (const char c : text) {
    if (c == '"') field += '"';
    field += c;
  }
  return field + '"';
}

CsvText::CsvText(std::size_t bytes) { text_.reserve(std::max(bytes, kLongestLine)); }

void CsvText::append(std::string_view text) { text_.insert(text_.end(), text.begin(), text.end()); }

void CsvText::start_line(std::string_view record) {
  column_ = kRecord;
  append(record);
}

void CsvText::go_to(int column) {
  for (; column_ < column; ++column_) text_.push_back(',');
}

void CsvText::put(int column, std::string_view field) {
  go_to(column);
  append(field);
}

void CsvText::put(int column, std::uint64_t value) {
  std::array<char, 24> digits;
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr;
  put(column, std::string_view(digits.data(), static_cast<std::size_t>(end - digits.data())));
}

void CsvText::put(int column, double value) {
  std::array<char, 32> digits;
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr;
  put(column, std::string_view(digits.data(), static_cast<std::size_t>(end - digits.data())));
}

void CsvText::end_line() {
  go_to(kColumns - 1);
  text_.push_back('\n');
}

}  // namespace touchstone::recorder
