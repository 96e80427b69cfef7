#include "touchstone/examples/program/json.hpp"

#include <cmath>

namespace touchstone::comparison {

Json number(double value) {
  if (std::isnan(value)) return nullptr;
  if (std::isinf(value)) return value > 0 ? "inf" : "-inf";
  return value;
}

Json json(const Vector3& v) { return Json::array({number(v.x()), number(v.y()), number(v.z())}); }

Json json(const Pose& X) {
  return {{"p_m", json(X.p)},
          {"R_rows",
           Json::array({json(Vector3(X.R.row(0))), json(Vector3(X.R.row(1))), json(Vector3(X.R.row(2)))})}};
}

Json json(const Machine& machine) {
  return {{"cpu", machine.cpu},
          {"instruction_set", machine.instruction_set},
          {"system", machine.system},
          {"compiler", machine.compiler},
          {"build_type", machine.build_type},
          {"flags", machine.flags},
          {"version", machine.version}};
}

Json json(const StepTimes& times) {
  return {{"median", number(times.median_us)},
          {"p99_9", number(times.p999_us)},
          {"worst", number(times.worst_us)}};
}

}  // namespace touchstone::comparison
