#pragma once

#include <span>
#include <string>
#include <vector>

#include "touchstone/examples/compare_backends/judge/choice.hpp"
#include "touchstone/examples/compare_backends/judge/standing.hpp"

namespace touchstone::comparison {

/// A backend's standing in the choice's domain, over the sets that hold pairs of it.
struct Candidate : Standing {
  double p999_ns = 0;      ///< the largest over the sets; NaN where one has too few calls
  double allocations = 0;  ///< the most over the sets; NaN where they were not counted in one
  std::size_t beyond = 0;  ///< of wrong.supported(): dearer than max_error or below min_coverage
  double worst_cost = 0;   ///< [m], rounded up to two digits
  std::string worst_id, worst_reason;
  std::string missing_set;  ///< a set that it was not measured in; empty: none
  bool inside = false;

  double share() const;  ///< of the supported pairs that are beyond; 0 of none
};

struct Verdict {
  Choice choice;
  std::size_t cases = 0;              ///< that it rests on
  std::size_t all = 0;                ///< of the run
  std::string fastest;                ///< empty: none stays inside
  std::vector<Candidate> candidates;  ///< the ones inside by speed, then the others by share and cost

  bool is_empty() const { return cases == 0; }
};

/// Decides from the counts alone.
Verdict decide(std::span<const ChoiceSet> sets, const Choice& choice);

/// "fastest within 1e-06 m on every distance case (contacts only): native, 41.0 ns a pair; none of these
/// pairs is beyond it, at most 0.025 % (95 %); of 1 200 of 12 000 cases"; or that no backend stays within, or
/// that nothing is compared.
std::string sentence(const Verdict& verdict);

/// "native, 41.0 ns a pair, 0 wrong of 220 000; exact is 160 times slower, 0 wrong of 220 000; bullet 312
/// phantom" of the fastest inside and the others; empty where none is. Who was wrong has no speed here.
std::string headline(const Verdict& verdict);

/// "0 wrong of 500", or what is wrong: "3 missed, 12 undecided"; and what is unsupported.
std::string wrong_words(const Wrongness& wrong);

/// The time, in brackets where an answer was wrong or missing.
std::string speed_text(const Candidate& candidate);

/// Why a candidate is not the fastest inside: "phantom contact in near:12", "3.1 times slower".
std::string reason_out(const Verdict& verdict, const Candidate& candidate);

/// "2 500 (0.02 %)": how many pairs are beyond.
std::string beyond_text(const Candidate& candidate);
std::string format_allocations(double allocations);  ///< "0", "12.5"; "-" for NaN
std::string format_percent(double share);            ///< two digits of 100 times it, three from 99.5 on

}  // namespace touchstone::comparison
