#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "touchstone/contact_core/fit/fit.hpp"

namespace touchstone::fitting {

/// Random points of a mesh's surface, by area: the same every time. Keeps a reference.
class SurfacePoints {
 public:
  explicit SurfacePoints(const TriangleMesh& mesh);
  Vector3 next();
  double uniform();  ///< [0, 1), of the same stream

 private:
  const TriangleMesh& mesh_;
  std::vector<double> area_sums_;
  std::uint64_t state_ = 0x9e3779b97f4a7c15U;
};

/// Random points of a mesh's surface, by area, and of its inside, half each where it has one, and how many of
/// them no hexahedron of the cover holds, 1e-12 of the largest coordinate allowed for a point's own rounding.
struct SampleCount {
  std::size_t asked = 0;
  std::size_t uncovered = 0;
};

/// The same points every time.
SampleCount count_uncovered(const MeshDistance& mesh, const Fit& fit, std::size_t samples);

}  // namespace touchstone::fitting
