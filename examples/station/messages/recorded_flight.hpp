#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "touchstone/contact_core/geometry/hexahedron_tree.hpp"
#include "touchstone/contact_core/output/recording.hpp"
#include "touchstone/examples/station/flight/scene_robot.hpp"

namespace touchstone::station {

/// A run that another program recorded, and the solids of its objects.
struct RecordedFlight {
  std::string name;
  touchstone::Recording recording;
  std::vector<HexahedronTree> trees;  ///< of the recording's objects, in their order
};

/// Reads a record (adapters/recorder: of training_run with a bundled arm, the station, any user) or a series
/// of dynamics_run, which has positions, attitudes and no events.
/// @param scene the script, robot's or scene file that was run, for the objects' solids.
/// @throws InputError naming the file: it is neither, holds nothing that can be shown, or the scene lacks an
/// object or a solid that it names.
RecordedFlight load_recorded_flight(const std::filesystem::path& record, const std::filesystem::path& scene,
                                    const SceneRobots& robots = {});

/// The flight as a file that the page saves and opens (page/timeline.js). @throws InputError: of more than
/// 1 GiB.
std::string saved_flight(const RecordedFlight& flight);

}  // namespace touchstone::station
