#include "touchstone/examples/station/flight/hand_scales.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <numbers>

#include "touchstone/contact_core/input_error.hpp"

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

nlohmann::json rates_json(const HandScales& scales) {
  return {{"coarse", {{"translation", scales.coarse}, {"rotation", scales.coarse_turn}}},
          {"vernier", {{"translation", scales.vernier}, {"rotation", scales.vernier_turn}}},
          {"joint", scales.joint},
          {"slide", scales.slide}};
}

HandScales scales_of(const nlohmann::json& rates) {
  const auto rate = [](const nlohmann::json& value) {
    const double out = value;
    if (!(out > 0.0)) throw InputError("a rate that is not above 0");
    return out;
  };
  const nlohmann::json &coarse = rates.at("coarse"), &vernier = rates.at("vernier");
  HandScales out;
  out.coarse = rate(coarse.at("translation"));
  out.coarse_turn = rate(coarse.at("rotation"));
  out.vernier = rate(vernier.at("translation"));
  out.vernier_turn = rate(vernier.at("rotation"));
  out.joint = rate(rates.at("joint"));
  out.slide = rate(rates.at("slide"));
  return out;
}

}  // namespace touchstone::station
