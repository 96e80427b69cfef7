#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "touchstone/contact_core/fit/mesh_distance.hpp"
#include "touchstone/tests/fit/table/cover_judge.hpp"

namespace touchstone::test {

/// How approximate convex decompositions of others are run: a Python that may have them.
struct DecomposerSetting {
  std::string python = "python3";
  double longest = 300.0;  ///< for a mesh; then it is given up [s]
};

/// Whether a Python has a method, and it gives a cube back as one hull.
struct FoundDecomposer {
  std::string version;
  std::string missing;  ///< why it is left out; empty: it is there
};

/// @param method "coacd" or "vhacd"
FoundDecomposer find_decomposer(const DecomposerSetting& setting, const std::string& method);

/// A decomposer's result on a mesh.
struct Decomposition {
  std::vector<ConvexPiece> hulls;
  double seconds = 0.0;  ///< of the processor
  std::string failure;   ///< why there are no hulls, in its own words, short
};

/// With the method's own defaults, on one thread. @param folder for files between the two processes
Decomposition decompose(const DecomposerSetting& setting, const std::string& method, const TriangleMesh& mesh,
                        const std::filesystem::path& folder);

std::size_t count_triangles(const std::vector<ConvexPiece>& hulls);

/// No point of the hulls is farther from the solid of the mesh [m]: an upper bound, to `resolution` [m].
double bound_hulls_excess(const MeshDistance& mesh, const std::vector<ConvexPiece>& hulls, double resolution);

}  // namespace touchstone::test
