#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "touchstone/examples/compare_backends/names.hpp"
#include "touchstone/examples/measures/accuracy/accuracy.hpp"

namespace touchstone::comparison {

/// One backend on one pair set, answers summed up.
struct BackendResult {
  std::string name;
  std::string description;
  Capabilities capabilities;
  struct Rows {
    std::optional<Timing> single, batch, raw, cached;
    std::optional<double> allocations;
  };
  std::array<Rows, 3> rows;  ///< by QueryKind
  std::array<std::optional<Timing>, 3> frame;
  Judgement judgement;
  bool judged = false;  ///< false in a build without `exact`
  std::optional<Consistency> consistency;
  std::string failure;

  /// Whether an answer to the query was wrong or missing, as far as that was judged.
  bool is_wrong(std::size_t query) const { return judged && judgement.wrongness[query].total() > 0; }
  /// Whether every case has a right answer to the query, as far as that was judged: only then a time stands
  /// for the set.
  bool is_complete(std::size_t query) const { return !judged || judgement.wrongness[query].is_complete(); }
};

struct SetResult {
  std::string name;
  std::string description;
  std::size_t cases = 0, contacts = 0, touching = 0;
  std::size_t pairs = 0;  ///< a frame
  std::vector<BackendResult> backends;
  std::vector<std::string> ids;  ///< as PairSet's
};
std::string case_id(const SetResult& set, std::size_t index);

/// A backend's consistency over all sets that were asked; no cases: none was.
Consistency total_consistency(std::span<const SetResult> sets, const std::string& backend);

/// The speed that a verdict goes by [ns per pair]: one pair a call, or in a scene a frame a call; NaN if not
/// measured.
double verdict_speed(const SetResult& set, const BackendResult& backend, QueryKind query);

}  // namespace touchstone::comparison
