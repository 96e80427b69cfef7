#pragma once

#include <vector>

#include "touchstone/examples/fit/fit_run.hpp"

namespace touchstone::fitting {

/// A scene to train in, and a script that flies it: NAME.scene.yaml, the cover and a block, a tenth of the
/// mesh's middle side, which comes along its shortest side from a quarter of the diagonal away against the
/// triangle that shows most of itself to it; and NAME.flight.yaml for training_run, in which the operator
/// backs off and goes aside after that; and NAME.flight.meshes.json, by which the station shows the mesh.
/// @param mesh its file, which the list names relative to `output`, the folder that all this is for; no list
/// is made of a mesh whose path is no UTF-8.
std::vector<program::ReportFile> training_files(const FitRun& run, const std::filesystem::path& mesh,
                                                const std::filesystem::path& output);

/// The block's size, and how it comes.
struct Approach {
  double side;       ///< of the cube [m]
  Vector3 from;      ///< its middle at the start, in the mesh's frame [m]
  Vector3 velocity;  ///< [m/s]
  double duration;   ///< until its middle would be in that of the mesh's box, seen along the way [s]
};
Approach approach_to(const TriangleMesh& mesh);

}  // namespace touchstone::fitting
