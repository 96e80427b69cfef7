#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "touchstone/contact_core/fit/triangle_mesh.hpp"

namespace touchstone::test {

/// A convex solid: the hull of its vertices. Frame: the mesh's [m].
struct ConvexPiece {
  std::vector<Vector3> vertices;
  /// Facets, in any orientation. Empty: the judge finds them, which takes the fourth power of the vertices.
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

/// The samples of a mesh that no piece holds.
struct JudgedSamples {
  std::size_t surface = 0, inside = 0;  ///< samples
  std::size_t uncovered_surface = 0, uncovered_inside = 0;
  std::size_t dropped_lines = 0;  ///< of inside samples: met an edge, so that Bullet counts it twice or never
  Vector3 an_uncovered = Vector3::Zero();  ///< the last one found

  std::size_t samples() const { return surface + inside; }
  std::size_t uncovered() const { return uncovered_surface + uncovered_inside; }
};

/// Judges covers with Bullet (double precision), by none of the code that fits and proves them: Bullet's rays
/// say what is inside of the mesh, its geometry utilities which planes bound a piece and whether they hold a
/// point.
class CoverJudge {
 public:
  /// That of a sample, and of the planes that Bullet makes of vertices.
  static constexpr double kRounding = 0x1p-40;

  /// @param mesh validated; copied. Open shells have no inside.
  explicit CoverJudge(const TriangleMesh& mesh);
  ~CoverJudge();

  /// Half of the samples on the surface, by area, half inside, by volume; all on the surface where there is
  /// no inside. A sample is uncovered when it is more than 2^-40 of the largest coordinate outside of each
  /// piece: its own rounding, and that of the planes that Bullet makes of vertices.
  /// @param progress is called with the share that is done; may be empty.
  JudgedSamples judge(std::span<const ConvexPiece> pieces, std::size_t samples, std::uint64_t seed,
                      double tolerance = kRounding, const std::function<void(double)>& progress = {}) const;

 private:
  struct Rays;
  const TriangleMesh mesh_;
  std::unique_ptr<Rays> rays_;
};

}  // namespace touchstone::test
