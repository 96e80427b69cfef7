#pragma once

namespace touchstone::station {

/// Rates of the hands at full deflection. Unless said otherwise public figures of the SSRMS's tip, unloaded
/// and in assembly, for arms of its kind.
struct HandScales {
  double coarse = 0.37, vernier = 0.02;                ///< [m/s]
  double coarse_turn = 0.0698, vernier_turn = 0.0105;  ///< [rad/s]
  double joint = 0.0698, slide = 0.0698;               ///< joint mode: [rad/s]; prismatic joints [m/s]
};

/// Those of a robot of others: its reach in 8 s and half a turn in 8 s, but no faster than the SSRMS's tip,
/// and turns in proportion; vernier is the same part of coarse as the SSRMS's. A robot of 3 m or more has its
/// metres a second, one of its reach its turns too. The robot's own joints may be slower, and then limit
/// both.
/// @param reach of the arm from its base, above 0 [m].
HandScales hand_scales_of(double reach);

}  // namespace touchstone::station
