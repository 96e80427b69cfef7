#pragma once

#include "touchstone/contact_core/registry.hpp"

/// A narrowphase of one's own, as a user of the installed package writes it: `separating_axes`.
///
/// Overlap only, by the 12 face normals and up to 144 cross products of edges as candidate axes, in doubles.
/// A gap beyond rounding on one of them proves a pair apart; one that overlaps on all of them by more than
/// what the axes left out could change is in contact; what lies between is `undecided`.
void register_separating_axes(touchstone::BackendRegistry& registry);
