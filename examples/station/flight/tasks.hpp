#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/examples/station/flight/tips.hpp"

namespace touchstone::station {

/// A goal, judged in `ours`.
struct StationTask {
  enum class Kind : std::uint8_t {
    carry,  ///< the object is carried
    bring,  ///< the object is carried, and at the place
    place,  ///< the object is carried by nobody, and at the place
    reach,  ///< the tip's frame is at the place
    grip,   ///< every jaw of the tip is within kGripReach of the object
    joint,  ///< a joint's value is within `within` of `value`
    hold,   ///< the object, a fixture, holds the tip
    stand,  ///< and nothing else holds the arm
  } kind = Kind::reach;
  std::string name, title;
  std::uint32_t object = 0;
  std::uint32_t tip = 0;          ///< of StationScene::tips
  Vector3 p_W = Vector3::Zero();  ///< the place: where the origin is to be, within `within` [m]
  Matrix3 R_W = Matrix3::Identity();
  double most_turn = kInfinity;  ///< from R_W [rad]; infinite: any attitude
  double within = 0.0;           ///< [m, rad]
  std::uint32_t joint = 0;       ///< index of its value
  double value = 0.0;            ///< [m, rad]
  // Until it is done, since the last reset; infinite, or the most there is: none.
  double most_force = kInfinity;             ///< GuardedMethod::contact_force() [N]
  double most_time = kInfinity;              ///< [s]
  std::uint32_t most_contacts = 0xffffffff;  ///< that began
};
inline constexpr std::size_t kMostTasks = 8;
/// A jaw this near to what it shall hold touches it [m].
inline constexpr double kGripReach = 1e-3;

/// True where X_W is where the task wants it.
bool is_at(const StationTask& task, const Pose& X_W);

/// A list of {"name", "title", "kind", and of its kind: "object"; "tip" (left out: the script's own);
/// "position" [m] with "within" [m]; "rpy" with "turn" [deg], both left out: any attitude; "joint" with
/// "value" and "within" [m, deg]; hold and stand: "tip" and "object"; "limits": {"force" [N], "time" [s],
/// "contacts"}}, each limit left out: none.
/// @return empty: there is no such file. @throws InputError naming the file: what it cannot mean.
std::vector<StationTask> read_tasks(const std::filesystem::path& file, const training::Setting& setting,
                                    const std::vector<Tip>& tips);

}  // namespace touchstone::station
