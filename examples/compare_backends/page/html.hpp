#pragma once

#include <string>
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
  std::string str() const { return html_ + "</tbody></table></div>\n"; }

 private:
  std::string html_;
};

/// Under a figure or table: where its numbers stand in results.json, and its SVG, which may be empty.
std::string source_note(const std::string& json_path, const std::string& svg = "");

/// "the averages of blocks of 128 pairs, not of single queries": what the percentiles of times are of.
std::string blocks_text(const Report& report);

inline double median(const std::optional<Timing>& timing) { return timing ? timing->median_ns : kNaN; }

/// "3 missed", "12 undecided", each in a span.
std::string wrong_lines(const Wrongness& wrong, const char* between);

}  // namespace touchstone::comparison
