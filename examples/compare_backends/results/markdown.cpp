#include "touchstone/examples/compare_backends/results/markdown.hpp"

namespace touchstone::comparison {

std::string markdown_row(const std::vector<std::string>& cells) {
  std::string text = "|";
  for (const std::string& cell : cells) text += " " + cell + " |";
  return text + "\n";
}

std::string markdown_head(const std::vector<std::string>& cells, std::size_t text_columns) {
  std::string text = markdown_row(cells) + "|";
  for (std::size_t i = 0; i < cells.size(); ++i) text += i < text_columns ? "---|" : "---:|";
  return text + "\n";
}

}  // namespace touchstone::comparison
