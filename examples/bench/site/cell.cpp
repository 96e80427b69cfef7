#include "touchstone/examples/bench/site/cell.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "touchstone/examples/program/terminal/text_table.hpp"

namespace touchstone::comparison {
namespace {

std::size_t hard_faults(const Wrongness& wrong) { return wrong.total() - wrong.undecided; }

}  // namespace

double shown_cost(double cost) { return std::abs(cost) < std::numeric_limits<double>::min() ? 0.0 : cost; }

Grade grade(const Cell& cell) {
  if (cell.wrong.supported() == 0) return Grade::not_answered;
  if (hard_faults(cell.wrong) > 0 || cell.cost.worst >= kFar) return Grade::wrong;
  return cell.wrong.undecided > 0 || cell.cost.worst >= kCoarse ? Grade::coarse : Grade::right;
}

const char* style_of(Grade grade) {
  switch (grade) {
    case Grade::right:
      return "right-cell";
    case Grade::coarse:
      return "coarse-cell";
    case Grade::wrong:
      return "wrong-cell";
    case Grade::not_answered:
      break;
  }
  return "no-cell";
}

std::string unbroken_count(std::size_t count) {
  std::string digits = format_count(count);
  for (std::size_t at = 0; (at = digits.find(' ', at)) != std::string::npos;) digits.replace(at, 1, "\u00a0");
  return digits;
}

std::string text_of(const Cell& cell) {
  if (cell.wrong.supported() == 0) return "-";
  std::string text;
  for (const auto& [count, name] : cell.wrong.kinds())
    if (count > 0) text += fmt::format("{}{} {}", text.empty() ? "" : ", ", unbroken_count(count), name);
  if (!text.empty()) text += fmt::format(" of {}; ", unbroken_count(cell.wrong.supported()));
  const double worst = shown_cost(cell.cost.worst);
  text += worst != 0 ? fmt::format("{:.0e} S", worst) : text.empty() ? "exact" : "0 S";
  if (cell.wrong.unsupported > 0)
    text += fmt::format(", {} not taken", unbroken_count(cell.wrong.unsupported));
  return text;
}

std::vector<FiledAnswer> faults(const Cell& cell) {
  if (grade(cell) != Grade::wrong) return {};
  std::vector<FiledAnswer> all;
  for (const FiledAnswer& each : cell.wrong_cases)
    if (each.status != "undecided") all.push_back(each);
  if (all.empty()) all = cell.wrong_cases;  // the undecided ones cost more than those that were wrong
  if (cell.cost.worst >= kFar && (all.empty() || all.front().id != cell.worst.id))
    all.insert(all.begin(), cell.worst);
  return all;
}

std::string cell_name(const Entry& entry, const std::string& set, QueryKind query) {
  return fmt::format("{}_{}_{}", set, entry.engine, to_string(query));
}

}  // namespace touchstone::comparison
