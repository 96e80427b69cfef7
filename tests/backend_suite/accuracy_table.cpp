#include "tests/backend_suite/accuracy_table.hpp"

#include <array>

namespace touchstone::suite {

std::span<const AccuracyRow> accuracy_table() {
  static constexpr std::array<AccuracyRow, 0> kTable = {};
  return kTable;
}

}  // namespace touchstone::suite
