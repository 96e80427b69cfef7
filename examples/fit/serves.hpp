#pragma once

#include <optional>
#include <string>
#include <vector>

#include "touchstone/contact_core/scene/scene.hpp"
#include "touchstone/examples/fit/fit_run.hpp"

// The coarsest cover that serves a scene.
//
// A cover holds the mesh, and no point of it in a zone is farther than e from the mesh. So where what moves
// comes within a margin m of the cover, and the zone holds all within m of where it goes, the mesh's
// clearance is at least the cover's and at most e larger: clearances, stops and first contacts are right to
// e, whatever the cover does elsewhere. That is checked of each row's own flight, not assumed.

namespace touchstone::fitting {

struct ServesRequest {
  Scene scene;         ///< with an object of the mesh's name, which stands; its hexahedra are replaced
  std::string object;  ///< that object's name
  double tolerance;    ///< of clearances, stops and first contacts [m]
  double margin;       ///< other motions that stay this near to the scene's, and clearances up to it [m]
  bool with_uniform;   ///< a row with the tolerance everywhere: long to fit
};

/// A flight of the scene with one cover.
struct ServedFlight {
  std::optional<double> first_contact;      ///< [s]
  double least_clearance = 0.0;             ///< of frames, between what moves and the object [m]
  double frame_us = 0.0, slowest_us = 0.0;  ///< median and worst of the world's frames
  Bounds swept;                             ///< of what moves, in the object's frame; between frames too
};
/// @throws InputError as SceneWorld.
ServedFlight fly_scene(const ServesRequest& request, const Fit& fit);

/// One cover, and whether it serves.
struct ServesRow {
  FitRun run;
  double elsewhere = 0.0;  ///< asked outside of the zone [m]
  double in_zone = 0.0;    ///< the error in it, a bound; uniform: the whole's [m]
  ServedFlight flight;
  bool serves = false;  ///< in_zone within the tolerance, proven, and the flight's surroundings in the zone
};

/// The box in the object's frame within which the error counts.
struct ServesResult {
  Bounds zone;
  std::vector<ServesRow> rows;          ///< coarsest elsewhere first
  std::optional<std::size_t> coarsest;  ///< the row that serves with the fewest hexahedra
};

/// Fits with the tolerance in the zone and up to 64 times as much elsewhere. The zone comes from a flight
/// with one coarse cover, and grows where a finer one gets farther.
/// @throws InputError: the scene has no such object, or it moves; nothing else moves; as run_fit().
ServesResult find_coarsest(const std::filesystem::path& mesh, const FitRequest& fit,
                           const ServesRequest& request, comparison::ProgressLine& progress);

std::string serves_text(const ServesResult& result, const ServesRequest& request);

}  // namespace touchstone::fitting
