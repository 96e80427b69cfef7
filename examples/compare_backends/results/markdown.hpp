#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace touchstone::comparison {

/// Returns one line of a Markdown table, with its end of line.
std::string markdown_row(const std::vector<std::string>& cells);

/// Returns a table's two first lines.
/// @param text_columns how many columns, from the left, hold text and are aligned to the left; the others
/// hold figures.
std::string markdown_head(const std::vector<std::string>& cells, std::size_t text_columns);

}  // namespace touchstone::comparison
