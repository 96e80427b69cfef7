#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "touchstone/contact_core/registry.hpp"
#include "touchstone/examples/compare_backends/fitted/fitted_covers.hpp"
#include "touchstone/examples/compare_backends/names.hpp"
#include "touchstone/examples/measures/truth/oracle.hpp"

// The error of a cover and a backend together.
//
// A cover of error e holds the mesh and is within e of it: where its exact clearance is d, the mesh's is in
// [d, d + e]. All covers together bracket the mesh's clearance at a pose: from the largest d to the least
// d + e. A backend's clearance on a cover is judged by the end of that bracket that is farther from it.

namespace touchstone::comparison {

/// One cover asked of one backend.
struct TotalErrorRow {
  std::string backend;
  std::size_t hexahedra = 0;
  double geometry = 0.0;       ///< certified [m]
  double geometry_seen = 0.0;  ///< at the poses, at least [m]
  double backend_error = 0.0;  ///< the worst against `exact` on the same hexahedra [m]
  double total = 0.0;          ///< the worst against the mesh's clearance, an upper bound [m]
  std::size_t unanswered = 0;  ///< poses with a pair that counts failed or unsupported; without an error
  std::size_t undecided = 0;   ///< poses with a pair that is closer than the backend's resolution
  double pairs = 0.0;          ///< a frame, on average
  double pair_ns = 0.0;        ///< of the narrowphase, in the run of frame_ns
  /// Broadphase and narrowphase, of this thread's processor; the least of several runs. 0: not timed, as
  /// where poses are unanswered.
  double frame_ns = 0.0;
  std::string refused;  ///< why the backend takes no such hexahedra; empty: it does
};

struct TotalErrors {
  std::vector<TotalErrorRow> rows;  ///< by cover, the coarsest first, then as backends are registered
  double bracket = 0.0;             ///< widest of the mesh's clearance at a pose [m]
};

/// @param repetitions runs over all poses that are timed; 0: none is.
/// @throws InputError: no backend `exact`; one of `backends` is unknown; certificates that contradict each
/// other.
TotalErrors measure_total_errors(std::span<const FittedCover> covers, const ClearancePoses& poses,
                                 const BackendRegistry& registry, std::span<const std::string> backends,
                                 int repetitions, const Progress& progress = {});

/// The cheapest of the timed rows whose total is at most `allowed`, or none.
std::optional<std::size_t> cheapest_within(const TotalErrors& errors, double allowed);

}  // namespace touchstone::comparison
