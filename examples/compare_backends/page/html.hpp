#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/examples/compare_backends/run/report.hpp"

namespace touchstone::comparison {

/// The input of every section of the page.
struct Page {
  const Report& report;
  std::vector<std::string> names;  ///< the backends, in the order of their marks

  explicit Page(const Report& of);
  /// A backend's mark and name, as markup.
  std::string named(const std::string& backend) const;
};

/// A table; the first cell of a row is markup (a mark and a name), the others are text.
class HtmlTable {
 public:
  explicit HtmlTable(const std::vector<std::string>& header, const char* style = "");
  void add(const std::vector<std::string>& row, const char* style = "");
  /// All cells are markup.
  void add_markup(const std::vector<std::string>& row);
  std::string str() const { return html_ + "</tbody></table></div>\n"; }

 private:
  std::string html_;
};

/// The template with each {{name}} replaced; what is put in is not looked through again.
/// @throws std::out_of_range for a name without a value.
std::string filled(std::string_view text, const std::map<std::string_view, std::string>& values);

/// Under a figure or table: where its numbers stand in results.json, and its SVG, which may be empty.
std::string source_note(const std::string& json_path, const std::string& svg = "");

/// "the averages of blocks of 128 pairs, not of single queries": what the percentiles of times are of.
std::string blocks_text(const Report& report);

/// "3 missed", "12 undecided", each in a span.
std::string wrong_lines(const Wrongness& wrong, const char* between);

}  // namespace touchstone::comparison
