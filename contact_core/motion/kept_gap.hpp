#pragma once

#include <algorithm>

#include "touchstone/contact_core/narrowphase/narrowphase.hpp"

namespace touchstone {

/// The least gap of motion, as a multiple of the resolution of the separations that lead it.
inline constexpr double kGapOverResolution = 4.0;

/// The gap that motion keeps [m]: what is asked for, or more where the separations are coarser.
/// @param scale as Resolution::at().
inline double kept_gap(double asked, const Resolution& resolution, double scale) {
  return std::max(asked, kGapOverResolution * resolution.at(scale));
}

}  // namespace touchstone
