#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "touchstone/contact_core/scene/scene.hpp"
#include "touchstone/examples/fit/fit_run.hpp"

// The coarsest covers that serve a scene.
//
// A cover holds the mesh, and no point of it in a zone is farther than e from the mesh. So where what moves
// comes within a margin m of the cover, and the zones hold all within m of where it goes, the mesh's
// clearance is at least the cover's and at most e larger: clearances, stops and first contacts are right to
// e, whatever the cover does elsewhere. That is checked of each row's own flight, not assumed.

namespace touchstone::fitting {

/// One mesh, and the object of the scene that it is.
struct ServedMesh {
  std::filesystem::path file;
  MeshInput input;
  std::string object;  ///< stands; its hexahedra are replaced
};

struct ServesRequest {
  Scene scene;
  std::vector<ServedMesh> meshes;  ///< of different objects
  double tolerance;                ///< of clearances, stops and first contacts [m]
  double margin;  ///< other motions that stay this near to the scene's, and clearances up to it [m]
  bool with_uniform = false;           ///< a row with the tolerance everywhere: long to fit
  std::optional<double> seconds = {};  ///< the search ends after about this, with what it has by then
};

/// @throws InputError: the scene has no such object, or it moves, or it has two meshes; nothing else moves.
void validate(const ServesRequest& request);

/// A flight of the scene with one cover a mesh.
struct ServedFlight {
  std::optional<double> first_contact;      ///< of any of the meshes [s]
  double least_clearance = 0.0;             ///< of frames, between what moves and the meshes [m]
  double frame_us = 0.0, slowest_us = 0.0;  ///< median and worst of the world's frames
  std::vector<Vector3> places;              ///< of what moves, frame by frame, in world [m]
  /// Of each mesh, in its object's frame: boxes that hold each mover from one frame to the next, one mover
  /// after the other.
  std::vector<std::vector<Bounds>> swept;
};
/// @param covers of request.meshes, in their order. @throws InputError as SceneWorld.
ServedFlight fly_scene(const ServesRequest& request, std::span<const Fit* const> covers);

/// Few boxes that together hold every box, each grown by `by`, as far as it is in `part`; none of what is
/// not. Boxes that come after each other share one where that makes little more room.
std::vector<Bounds> zones_about(std::span<const Bounds> swept, double by, const Bounds& part);

/// One cover a mesh, and whether they serve.
struct ServesRow {
  std::vector<FitRun> runs;                      ///< of the meshes
  std::size_t hexahedra = 0;                     ///< of all
  double asked_in_zones = 0.0, elsewhere = 0.0;  ///< [m]
  double in_zones = 0.0;  ///< the largest error in a zone, a bound; uniform: the whole's [m]
  bool is_uniform = false;
  ServedFlight flight;
  bool is_held = false;  ///< proven, and the flight's surroundings are in the zones: right to in_zones
  bool serves = false;   ///< and that is within the tolerance
};

struct ServesResult {
  std::vector<std::vector<Bounds>> zones;  ///< of each mesh, in its object's frame [m]
  std::vector<ServesRow> rows;             ///< in the order in which they were tried
  /// The row that serves with the fewest hexahedra; where none does, the one that is right to the least
  /// error.
  std::optional<std::size_t> best;
  bool is_cut = false;  ///< the time was up before all was tried
};

/// Fits with ever smaller errors in the zones, down to the tolerance, and then with several errors elsewhere.
/// Zones come from the flight with the covers before, with that cover's error added.
/// @param on_row called with each row as soon as there is one; may be empty.
/// @throws InputError as validate() and run_fit().
ServesResult find_coarsest(const FitRequest& fit, const ServesRequest& request,
                           comparison::ProgressLine& progress,
                           const std::function<void(const ServesRow&)>& on_row = {});

/// A line while the search goes on.
std::string row_text(const ServesRow& row);
std::string serves_text(const ServesResult& result, const ServesRequest& request);

}  // namespace touchstone::fitting
