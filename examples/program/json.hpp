#pragma once

#include <nlohmann/json.hpp>

#include "touchstone/contact_core/geometry/pose.hpp"
#include "touchstone/examples/measures/quantiles.hpp"
#include "touchstone/examples/program/machine.hpp"

// What every results.json says alike.

namespace touchstone::comparison {

using Json = nlohmann::ordered_json;

Json number(double value);    ///< NaN: null; infinite: "inf" or "-inf"
Json json(const Vector3& v);  ///< [x, y, z], each as number()
Json json(const Pose& X);     ///< {"p_m", "R_rows"}
Json json(const Machine& machine);
Json json(const StepTimes& times);

}  // namespace touchstone::comparison
