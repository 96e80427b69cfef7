#include "touchstone/examples/station/flight/hand_scales.hpp"

#include <algorithm>
#include <numbers>

namespace touchstone::station {

HandScales hand_scales_of(double reach) {
  constexpr double kSeconds = 8.0;  // for a sweep of the reach, or half a turn: as an operator jogs a robot
  const HandScales ssrms;
  HandScales out;
  out.coarse = std::min(ssrms.coarse, reach / kSeconds);
  out.coarse_turn = std::max(ssrms.coarse_turn, std::numbers::pi * out.coarse / reach);
  out.vernier = out.coarse * (ssrms.vernier / ssrms.coarse);
  out.vernier_turn = out.coarse_turn * (ssrms.vernier_turn / ssrms.coarse_turn);
  out.joint = out.coarse_turn;
  out.slide = out.coarse;
  return out;
}

}  // namespace touchstone::station
