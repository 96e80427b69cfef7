#pragma once

#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>

namespace touchstone::station {

/// Rates of the hands at full deflection. Unless stated otherwise, public figures of the SSRMS's tip,
/// unloaded and in assembly, for arms of its kind.
struct HandScales {
  double coarse = 0.37, vernier = 0.02;                ///< [m/s]
  double coarse_turn = 0.0698, vernier_turn = 0.0105;  ///< [rad/s]
  double joint = 0.0698, slide = 0.0698;               ///< joint mode: [rad/s]; prismatic joints [m/s]

  bool operator==(const HandScales&) const = default;
};

/// By scenes' names. Scenes that it lacks are flown by HandScales{}.
using SceneScales = std::map<std::string, HandScales>;

/// Those of a robot of others: coarse is its reach in 8 s, but no more than the SSRMS's 0.37 m/s, which a
/// reach of 3 m has. Turns are coarse over reach times pi: half a turn in 8 s up to 3 m, slower beyond, but
/// no slower than the SSRMS's, from 17 m on. Vernier is the same part of coarse as the SSRMS's; joint mode
/// has coarse's. The robot's own joints may be slower, and then limit both.
/// @param reach of the arm from its base, above 0 [m]: see reach_of().
HandScales hand_scales_of(double reach);

/// `rates` of protocol.md.
nlohmann::json rates_json(const HandScales& scales);
/// Reads what rates_json() wrote, to the same bits. @throws InputError: no positive number; or as
/// nlohmann::json does.
HandScales scales_of(const nlohmann::json& rates);

}  // namespace touchstone::station
