#pragma once

#include <cstddef>

#include "touchstone/contact_core/fit/fit.hpp"

namespace touchstone::fitting {

/// Random points of a mesh's surface, by area, and of its inside, half each where it has one, and how many of
/// them no hexahedron of the cover holds, 1e-12 of the largest coordinate allowed for a point's own rounding.
struct SampleCount {
  std::size_t asked = 0;
  std::size_t uncovered = 0;
};

/// The same points every time.
SampleCount count_uncovered(const MeshDistance& mesh, const Fit& fit, std::size_t samples);

}  // namespace touchstone::fitting
