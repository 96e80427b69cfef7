#pragma once

#include <string>
#include <vector>

namespace touchstone::program {

/// Columns as wide as their widest cell; the first left-aligned, the others right-aligned.
class TextTable {
 public:
  explicit TextTable(std::vector<std::string> header) : rows_{std::move(header)} {}
  void add(std::vector<std::string> row) { rows_.push_back(std::move(row)); }
  std::string str() const;
  const std::vector<std::vector<std::string>>& rows() const { return rows_; }

 private:
  std::vector<std::vector<std::string>> rows_;
};

/// Lines of more than `columns` go on below at a space, indented to where a line's last column begins, as for
/// lists and options; a count of thousands stays together.
std::string wrapped(const std::string& text, std::size_t columns = 120);

std::string format_ns(double nanoseconds);    ///< "41.3", "1 234"; "-" for NaN
std::string format_error(double value);       ///< "0", "> 0" below 2e-308, "1.2e-16", "inf"; "-" for NaN
std::string format_count(std::size_t count);  ///< thousands apart
std::string format_ratio(double ratio);       ///< "1.00x", "12.3x"; "-" for NaN

}  // namespace touchstone::program
