#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/examples/compare_backends/judge/set_result.hpp"

namespace touchstone::comparison {

/// The allowed error where none is given [m].
inline constexpr double kDefaultBudget = 1e-6;

/// The question of a verdict: which pairs, what of the answers, and what is allowed.
struct Choice {
  QueryKind query = QueryKind::distance;
  // ---- the domain: which pairs
  std::vector<std::string> sets;                    ///< names of families, scenes, or "pairs"; empty: all
  bool apart = true, touching = true, deep = true;  ///< by exact class, see kDeepOverSize
  double apart_up_to = kInfinity;                   ///< [m]; of pairs that are apart
  double within = kInfinity;                        ///< [m]; largest |world coordinate| of a pair
  // ---- what is asked of an answer
  bool normals = true;  ///< of distance and manifold
  bool points = true;   ///< of distance: witness points; of manifold: contact points
  // ---- what is allowed
  double max_error = kDefaultBudget;  ///< [m]
  double share = 0;             ///< of the domain's pairs that may be beyond max_error or below min_coverage
  double min_coverage = 0;      ///< manifold: share of the true patch, on kCoverageBins
  double deadline = kInfinity;  ///< [s] a call, at the 99.9th percentile
  bool no_allocations = false;  ///< in steady state

  /// Returns the parts of an answer that are asked for, as an index into StratumCosts::asked.
  std::size_t asked() const {
    return query == QueryKind::overlap ? 0 : (normals ? kAskedNormals : 0) + (points ? kAskedPoints : 0);
  }
  bool has(const Stratum& stratum) const;
  bool has_set(const std::string& name) const;
};

/// Domains are counted in bins: a limit between two ends of bins is taken as the upper one.
double upper_end(double limit, std::span<const double> bins);

/// A pair set as verdicts see it: every backend's speed and counted costs.
struct ChoiceSet {
  std::string name;
  std::size_t cases = 0;
  struct Answers {
    double nanoseconds = kNaN;  ///< verdict_speed()
    double p999_ns = kNaN;      ///< of a call: a pair, in scenes a frame
    double allocations = kNaN;  ///< a query
    CostCurves curves;          ///< AskedCosts::worst_index counts `ids`
  };
  struct Backend {
    std::string name;
    std::array<Answers, 3> queries;  ///< by QueryKind
  };
  std::vector<Backend> backends;  ///< the judged ones
  std::vector<std::string> ids;   ///< of the dearest cases
};

/// The judged sets of a run, fit to be written down and decided from.
std::vector<ChoiceSet> choice_sets(std::span<const SetResult> sets);

/// @throws InputError naming the sets that there are, where the choice names one that is not among them.
void check_sets(const Choice& choice, const std::vector<std::string>& known);

/// @throws InputError for an unknown query.
QueryKind query_named(const std::string& name);

/// Cases of the set in the choice's domain; 0 where the set is not chosen.
std::size_t cases_in(const ChoiceSet& set, const Choice& choice);

}  // namespace touchstone::comparison
