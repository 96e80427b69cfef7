#pragma once

#include <optional>
#include <string_view>

#include "touchstone/tests/support/random.hpp"
#include "touchstone/tests/world/progress/progress_trial.hpp"

namespace touchstone {

/// Scenes in which movers fit closely: `pegs` in holes, in metres, a thousand times as large (a file's
/// millimetres read as metres) and a thousandth (`pegs_large`, `pegs_small`); `file_drawers`, whose shapes
/// have six digits as files have them; `two_links` of an arm against two boxes at once; `fit_bore`, an arm's
/// bore over a stem at 1e-6 m of play; `payload`, thirty hexahedra latched to an arm, into a slot.
/// @returns none: no such scene.
std::optional<ProgressTrial> make_tight_trial(std::string_view scene, double rate, double gap,
                                              Random& random);

}  // namespace touchstone
