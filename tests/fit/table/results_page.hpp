#pragma once

#include <optional>
#include <string>
#include <vector>

#include "touchstone/tests/fit/table/cover_judge.hpp"

namespace touchstone::test {

/// One mesh within one error.
struct FitRow {
  std::string mesh;
  double asked = 0.0;  ///< share of the diagonal
  std::size_t triangles = 0, hexahedra = 0;
  double error = 0.0;                             ///< share of the diagonal, proven
  double fit_seconds = 0.0, proof_seconds = 0.0;  ///< of the processor
  std::string refused;                            ///< why there is no proven cover; empty: there is one
  JudgedSamples judged;
};

/// Of the largest coordinate: decompositions miss most of a surface by a trace.
inline constexpr double kFar = 1e-3;

/// One mesh by one decomposer, and by us within the same error.
struct PeerRow {
  std::string mesh, method;
  std::string failure;  ///< empty: there are hulls
  std::size_t hulls = 0, triangles = 0;
  double excess = 0.0;  ///< share of the diagonal
  double seconds = 0.0;
  JudgedSamples judged;
  JudgedSamples judged_far;              ///< uncovered by more than kFar
  std::optional<std::size_t> hexahedra;  ///< ours at its excess; none: not asked, or none was found
};

struct FitTable {
  std::string command;             ///< that writes the page
  std::size_t samples = 0;         ///< asked of each mesh
  std::vector<std::string> peers;  ///< "V-HACD by vhacdx 0.0.10", or why it is missing
  std::vector<FitRow> rows;
  std::vector<PeerRow> peer_rows;
};

/// The target of a cover: seconds of one core for fit and proof.
inline constexpr double kAskedSeconds = 30.0;

/// A line of progress each.
std::string row_text(const FitRow& row);
std::string row_text(const PeerRow& row);

/// Markdown: a table an error, the misses by name, then the decomposers.
std::string results_page(const FitTable& table);

/// Rows without a proven cover or with an uncovered sample.
std::size_t count_uncovered(const FitTable& table);

}  // namespace touchstone::test
