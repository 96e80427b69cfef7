#pragma once

#include <string>
#include <vector>

#include "examples/compare_backends/accuracy.hpp"

namespace touchstone::comparison {

/// One backend on one pair set, answers summed up.
struct BackendResult {
  std::string name;
  std::string description;
  Capabilities capabilities;
  struct Rows {
    std::optional<Timing> single, batch, raw;
    std::optional<double> allocations;
  };
  std::array<Rows, 3> rows;  ///< by QueryKind
  std::array<std::optional<Timing>, 3> frame;
  Judgement judgement;
  bool judged = false;  ///< false in a build without `exact`
  std::string failure;
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

/// The speed that a verdict goes by [ns per pair]: one pair a call, or in a scene a frame a call; NaN if not
/// measured.
double verdict_speed(const SetResult& set, const BackendResult& backend, QueryKind query);

/// How a backend stands over all sets for one query.
struct Candidate {
  std::string backend;
  /// Mean over the sets of the median per pair: one pair a call, in scenes a frame a call; NaN if not
  /// measured in all.
  double nanoseconds = 0;
  double worst_cost = 0;  ///< [m]
  std::string worst_id;
  std::string worst_reason;
  bool inside = false;  ///< worst_cost <= max_error, and the speed was measured
};

struct Verdict {
  QueryKind query = QueryKind::distance;
  double max_error = 0;               ///< [m]
  std::string fastest;                ///< empty: none stays inside
  std::vector<Candidate> candidates;  ///< the ones inside by speed, then the others by cost
};

Verdict decide(std::span<const SetResult> sets, QueryKind query, double max_error);

/// How a backend did over all sets, in one query.
struct Standing {
  std::string backend;
  /// Mean over the sets of the median per pair, one pair a call; NaN if not measured in all.
  double nanoseconds = 0;
  double worst_error = 0;  ///< largest cost over S; +inf for a missing figure
  Wrongness wrongness;     ///< summed over the sets
};

/// The backends without a wrong or missing answer by speed, then the others by how many they gave.
struct Ranking {
  QueryKind query = QueryKind::distance;
  std::vector<Standing> standings;
};
Ranking rank(std::span<const SetResult> sets, QueryKind query);

/// The backends without a wrong or missing answer that no other such beats in both worst error and median
/// time, from the most exact to the fastest.
std::vector<std::string> pareto_front(const SetResult& set, QueryKind query);

/// "fastest inside 1e-06 m for distance: native, 41 ns" or that none is.
std::string sentence(const Verdict& verdict);

}  // namespace touchstone::comparison
