#pragma once

#include <optional>

#include "touchstone/contact_core/motion/narrowphase_query.hpp"
#include "touchstone/contact_core/motion/sweep.hpp"
#include "touchstone/contact_core/registry.hpp"
#include "touchstone/examples/measures/paths/path_set.hpp"

namespace touchstone::measures {

/// The two solids at s.
PosedPair posed_at(const SolidPaths& paths, double s);

/// find_impact() of two solids that are built as 0 and 1.
/// @param first the first one's index in what `query` was built over.
Impact impact_of(const SolidPaths& paths, const GapRule& rule, NarrowphaseQuery& query, SolidIndex first = 0);

/// A backend's times of impact, as contact worlds find them (find_impact()): by its own separations, or, of
/// one without them, by its verdict at poses that native's separations choose. Or those of an engine's sweep.
struct PathAnswers {
  std::string backend;
  std::string sweep;                           ///< the sweep's description; empty: a backend's answers
  std::vector<std::optional<Impact>> impacts;  ///< one a path; none: it refuses a solid, or turns less far
  std::vector<double> gaps;                    ///< that motion keeps on each path [m]
  std::string why_none;                        ///< why no path was asked about; empty: all were
};

/// The gap that paths are asked with [m]: that of the tightest bundled scenes.
inline constexpr double kPathGap = 1e-9;
/// A contact world's of that gap; of a backend without separations its resolution has no part in where it
/// stops.
GapRule gap_rule(const Narrowphase& narrowphase, double scale);

PathAnswers run_paths(const BackendRegistry::NarrowphaseEntry& backend, const PairSet& set,
                      std::size_t poses);
/// Where an engine's sweep stops. The gap that it keeps is not known, so that it is held to kPathGap.
PathAnswers run_sweep(const SweepEntry& sweep, const PairSet& set, std::size_t poses);

}  // namespace touchstone::measures
