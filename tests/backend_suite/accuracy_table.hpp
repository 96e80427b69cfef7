#pragma once

#include <cstdint>
#include <span>
#include <string_view>

namespace touchstone::suite {

/// The errors that a backend may make on the first kPairs pairs of a family with seed kSeed. Errors are over
/// S, see examples/measures/accuracy/accuracy.hpp; kUnsupported: the backend answers `unsupported` for all
/// such pairs.
struct AccuracyRow {
  std::string_view backend;
  std::string_view family;
  int wrong_class;  ///< missed and phantom contacts, overlap query
  int undecided;    ///< overlap query
  int no_answer;    ///< failed or missing, distance query
  double distance;  ///< worst error of pairs apart
  double depth;     ///< worst error of pairs in contact
};
inline constexpr int kPairs = 200;
inline constexpr std::uint64_t kSeed = 1;
inline constexpr double kUnsupported = -1.0;
/// Family of a row about the pairs that the suite derives by hand. Its `depth` is by what share of its depth
/// an overlapping pair may be off, beyond the resolution; nothing else of it is read. No row: by none.
inline constexpr std::string_view kByHand = "by_hand";

/// Defined by the program: one row a backend and family; a measured row is printed where one is missing.
std::span<const AccuracyRow> accuracy_table();

}  // namespace touchstone::suite
