#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "touchstone/contact_core/scene/scene.hpp"
#include "touchstone/examples/fit/fit_run.hpp"
#include "touchstone/examples/fit/zones.hpp"

// The coarsest covers that serve a scene.
//
// A cover holds the mesh, and no point of it in a zone is farther than e from the mesh. So where others come
// within a margin m of the cover, and the zones hold all of the cover that is within m of them, the mesh's
// clearance is at least the cover's and at most e larger: clearances are right to e, and what a cover stops
// is within e of the mesh, whatever the cover does elsewhere. Between two meshes it is the sum of both
// errors. That is checked of each row's own flight, not assumed.
//
// It bounds clearances, not paths: what meets the mesh at a slant is stopped earlier on its way by more than
// e, what passes closely may be stopped, and a stop that ends a frame later leaves the flights far apart for
// that frame. So the scene is flown with the meshes' triangles, too, and covers that stop things elsewhere do
// not serve, see fly_meshes().

namespace touchstone::fitting {

/// One mesh, and the object of the scene that it is.
struct ServedMesh {
  std::filesystem::path file;
  MeshInput input;
  std::string object;  ///< stands or moves; its hexahedra are replaced
};

struct ServesRequest {
  Scene scene;
  std::vector<ServedMesh> meshes;  ///< of different objects
  double tolerance;                ///< of clearances, also of those where something is stopped [m]
  double margin;  ///< other motions that stay this near to the scene's, and clearances up to it [m]
  bool with_uniform = false;           ///< a row with the tolerance everywhere: long to fit
  std::optional<double> seconds = {};  ///< the search ends after about this, with what it has by then
};

/// @throws InputError: the scene has no such object, or it has two meshes; nothing moves, or nothing can meet
/// a mesh.
void validate(const ServesRequest& request);

/// Whether two meshes of the request may meet: each is then fitted to half of the tolerance.
bool may_meet_each_other(const ServesRequest& request);

/// Contact of a mesh with another object, or a stop by it, as the world reported it. However many of their
/// solids touch, it is one contact; one that ends and begins anew in a frame goes on.
struct ToldContact {
  std::size_t a, b;  ///< objects of the scene, a < b
  bool began;        ///< else it ended, or is a stop
  double time;       ///< [s]
  /// Origins of both at that time, in world [m].
  Vector3 p_WA = Vector3::Zero(), p_WB = Vector3::Zero();
};

/// A flight of the scene with one cover a mesh.
struct ServedFlight {
  std::optional<double> first_contact;  ///< of any of the meshes [s]
  std::uint64_t pairs = 0;       ///< of hexahedra looked at, of all frames: what a cover costs, by count
  double least_clearance = 0.0;  ///< of frames, between meshes and others [m]
  /// Of the world's frames, by the thread's clock, each the least of several flights [us].
  double frame_us = 0.0, frame_999_us = 0.0, slowest_us = 0.0;
  std::vector<Vector3> places;        ///< of what moves, frame by frame, in world [m]
  std::vector<ToldContact> contacts;  ///< with meshes, frame by frame
  /// Where something was stopped that was not in the frame before, but in pairs that slide; in that order.
  std::vector<ToldContact> stops;
  std::vector<std::vector<SeenObject>> seen;  ///< from each mesh: what may meet it
};
/// @param covers of request.meshes, in their order. @throws InputError as SceneWorld.
ServedFlight fly_scene(const ServesRequest& request, std::span<const Fit* const> covers);

/// By how much two flights of one scene differ, at most.
struct FlightDifference {
  /// The same contacts begin and end, and the same pairs stop, in the same order; else no begins, ends,
  /// stops.
  bool are_alike = false;
  double begins = 0.0, ends = 0.0;  ///< times at which contacts do so [s]
  double stops = 0.0;  ///< where the origins of both objects are as a contact begins, or they stop [m]
  /// Where the origins of what moves are at the same time, after any frame [m]. What is released goes on to
  /// its commanded pose within the frame: released a frame apart, two flights are as far apart as that is.
  double frames = 0.0;
};
FlightDifference difference(const ServedFlight& some, const ServedFlight& other);

/// The flight of the meshes themselves: each triangle is a plate below it, 2^-10 of the tolerance thick. It
/// has no times. @return nothing where a mesh makes no such plates, see surface_tree(), or a hexahedron of
/// something else is wholly inside a mesh once, where it meets none of them. @throws InputError as
/// SceneWorld.
std::optional<ServedFlight> fly_meshes(const ServesRequest& request, std::span<const MeshDistance> meshes);

/// One cover a mesh, and whether they serve.
struct ServesRow {
  std::vector<FitRun> runs;                ///< of the meshes
  std::vector<std::vector<Bounds>> zones;  ///< of each mesh, in its object's frame; none: no row before [m]
  std::size_t hexahedra = 0;               ///< of all
  double asked_in_zones = 0.0, elsewhere = 0.0;  ///< of a mesh [m]
  /// The largest error in zones, a bound: of a mesh, or of two that may meet together; uniform: the whole's
  /// [m].
  double in_zones = 0.0;
  bool is_uniform = false;
  ServedFlight flight;
  /// From the flight of the meshes themselves; nothing where there is none.
  std::optional<FlightDifference> from_meshes = {};
  bool is_held = false;   ///< proven, and the flight's surroundings are in the zones: right to in_zones
  bool is_right = false;  ///< and that is within the tolerance: so are clearances
  bool serves = false;    ///< and so is each stop, as far as the meshes' own flight is known
};

struct ServesResult {
  std::vector<ServesRow> rows;  ///< in the order in which they were tried
  /// The row that serves and asks for the fewest pairs in its flight, of such with the fewest hexahedra;
  /// where none does, the right one whose stops are nearest to the meshes', or the one that is right to the
  /// least error. That of one error everywhere only where no other is as good.
  std::optional<std::size_t> best;
  bool has_meshes = false;  ///< rows stand beside the flight of the meshes themselves
  /// Where the best one is right: no covers that are within the tolerance in its zones have fewer hexahedra
  /// (a bound from below, see least_hexahedra()). Covers with other zones may. 0: not known.
  std::size_t least = 0;
  bool is_cut = false;                     ///< the time was up before all was tried
  std::vector<std::string> left_out = {};  ///< rows but the first that were refused, and why
};

/// Fits with ever smaller errors in the zones, down to the tolerance and, where something is then stopped
/// elsewhere than by the meshes, further; and then with several errors elsewhere. Zones come from the flight
/// with the covers before, with those covers' errors added.
/// @param on_row called with each row as soon as there is one; may be empty.
/// @throws InputError as validate(); as run_fit() and fly_scene() for the first row. Others are left out.
ServesResult find_coarsest(const FitRequest& fit, const ServesRequest& request,
                           program::ProgressLine& progress,
                           const std::function<void(const ServesRow&)>& on_row = {});

/// A line while the search goes on.
std::string row_text(const ServesRow& row);
/// All rows, the best one's zones, and whether what else serves stops where it does.
std::string serves_text(const ServesResult& result, const ServesRequest& request);
/// The best row beside the uniform one; empty without both.
std::string comparison_text(const ServesResult& result, const ServesRequest& request);

}  // namespace touchstone::fitting
