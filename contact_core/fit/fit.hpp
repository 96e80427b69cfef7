#pragma once

#include <array>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "touchstone/contact_core/fit/mesh_distance.hpp"
#include "touchstone/contact_core/fit/triangle_mesh.hpp"
#include "touchstone/contact_core/geometry/hexahedron_tree.hpp"

/// @file
/// Hexahedra that cover a mesh: their union holds every triangle, and the inside of every closed shell, and
/// no point of it is farther outside than asked.

namespace touchstone {

/// A part of space with an error of its own: a grapple interface on a truss, or a bore that must stay open.
struct FitRegion {
  std::string name;  ///< for errors and certificates
  Bounds box;        ///< in the mesh's frame [m]
  double over;       ///< points of the cover in `box` are at most this far from the solid [m]
};

/// Bounds on a fit's excess, and its effort.
struct FitOptions {
  double over = 0.0;               ///< no point of the cover is farther from the solid [m]; > 0
  std::vector<FitRegion> regions;  ///< each with an `over` of at most the one above
  /// Iterations that remove a few hexahedra and cover their place anew; up to 16 times as many where that is
  /// cheap, about a tenth of a second each at most. Counted, not timed: the cover is reproducible.
  int repairs = 60;
  /// Times that the search starts anew, the solid cut elsewhere; the cover of fewest hexahedra counts, of
  /// equal ones that with the least excess. Fewer where a try costs much, again by counts. >= 1
  int tries = 1;
  /// Called with a stage and how much of it is done, 0 to 1, from the calling thread, some times a second or
  /// more; what it throws ends the fit. May be empty.
  std::function<void(std::string_view stage, double share)> progress;
};

/// One hexahedron of a cover.
struct FittedHexahedron {
  std::array<Vector3, 8> vertices;  ///< Hexahedron's order; faces are flat to rounding; the mesh's frame [m]
  /// No point of it is farther from the solid [m]: a bound, above the truth by at most a thirty-second of
  /// `over` where it is the cover's largest, else by at most an eighth; of a slab of a prism it is what the
  /// prism tells, which may be more.
  double excess;
  Vector3 farthest;  ///< one that is about that far
};

/// A cover of a mesh.
struct Fit {
  std::vector<FittedHexahedron> hexahedra;
  double excess = 0.0;                ///< the largest of theirs [m]
  std::vector<double> region_excess;  ///< of the cover's points in each region [m]
  std::size_t pieces = 0;             ///< that the solid was cut into while looking
};

/// Covers a mesh by few hexahedra.
///
/// The solid is cut into small cells; candidates grow from cells in the main axes of the mesh and those of
/// its facets, as far as `over` lets them; greedily, then by taking some out and covering their place anew, a
/// few are chosen that hold all cells; each is shrunk to what it alone must hold. Faces stand 2^-45 of the
/// largest coordinate outside of what they hold, so that the cover stands exact checks. A hexahedron that
/// turns out to go too far is replaced, the point that does being out of bounds from then on. The figures of
/// excess are proven by branch and bound (see bound_excess()); coverage is by construction to rounding, and
/// for proof there is adapters/cover_proof.
///
/// @param mesh welded or not
/// @throws InputError: a bad mesh, an `over` that is not positive and finite or below 2^-20 of the largest
/// coordinate, a region whose box or `over` is invalid.
Fit fit_hexahedra(const TriangleMesh& mesh, const FitOptions& options);
/// The same of a mesh whose distances are known already.
Fit fit_hexahedra(const MeshDistance& mesh, const FitOptions& options);

/// The fewest hexahedra for a count: the least `over` whose fit has at most `count`, by bisection to a
/// twentieth of it, or to a hundredth of the diagonal. `options.over` is where to begin.
/// @throws InputError as above, or when even one diagonal of error takes more than `count`.
Fit fit_count(const TriangleMesh& mesh, std::size_t count, FitOptions options, double* over = nullptr);
/// The same of a mesh whose distances are known already.
Fit fit_count(const MeshDistance& mesh, std::size_t count, FitOptions options, double* over = nullptr);

/// The cover as an object's tree; hexahedra are named h0, h1, ...
HexahedronTree make_tree(const Fit& fit, std::string name);

}  // namespace touchstone
