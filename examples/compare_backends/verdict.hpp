#pragma once

#include <span>
#include <string>
#include <vector>

#include "touchstone/examples/compare_backends/set_result.hpp"

namespace touchstone::comparison {

/// How a backend stands over all sets for one query.
struct Candidate {
  std::string backend;
  /// Mean over the sets of the median per pair: one pair a call, in scenes a frame a call; NaN if not
  /// measured in all.
  double nanoseconds = 0;
  double worst_cost = 0;  ///< [m]; CaseErrors::cost
  std::string worst_id;
  std::string worst_reason;
  bool inside = false;  ///< worst_cost <= max_error, and the speed was measured
  Wrongness wrong;      ///< summed over the sets
};

/// Every backend's standing for one query before an error is allowed, in the order of the sets' backends;
/// `inside` is not set yet.
struct Candidates {
  QueryKind query = QueryKind::distance;
  std::vector<Candidate> candidates;
};
std::vector<Candidate> candidates(std::span<const SetResult> sets, QueryKind query);

struct Verdict {
  QueryKind query = QueryKind::distance;
  double max_error = 0;               ///< [m]
  std::string fastest;                ///< empty: none stays inside
  std::vector<Candidate> candidates;  ///< the ones inside by speed, then the others by cost
};

Verdict decide(std::vector<Candidate> candidates, QueryKind query, double max_error);
Verdict decide(std::span<const SetResult> sets, QueryKind query, double max_error);

/// "fastest within 1e-06 m on every distance case: native, 41 ns a pair", with what it got wrong within that,
/// or that no backend stays within.
std::string sentence(const Verdict& verdict);

/// "native, 41 ns a pair, 0 wrong of 220 000; exact is 160 times slower, 0 wrong of 220 000; bullet 312
/// phantom" of the fastest inside and the others. Who was wrong has no speed here.
std::string headline(const Verdict& verdict);

/// "0 wrong of 500", or what is wrong: "3 missed, 12 undecided".
std::string wrong_words(const Wrongness& wrong);

/// The time, in brackets where an answer was wrong or missing.
std::string speed_text(const Candidate& candidate);

/// Why a candidate is not the fastest inside: "phantom contact costs 0.0012 m in near:12", "3.1 times
/// slower".
std::string reason_out(const Verdict& verdict, const Candidate& candidate);

}  // namespace touchstone::comparison
