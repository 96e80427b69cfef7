#include "touchstone/examples/program/files/json.hpp"

#include <cmath>
#include <filesystem>
#include <fstream>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/input_error.hpp"

namespace touchstone::program {

Json number(double value) {
  if (std::isnan(value)) return nullptr;
  if (std::isinf(value)) return value > 0 ? "inf" : "-inf";
  return value;
}

double number_of(const Json& value) {
  if (value.is_null()) return kNaN;
  if (value == "inf") return kInfinity;
  if (value == "-inf") return -kInfinity;
  return value.get<double>();
}

Json json(const Vector3& v) { return Json::array({number(v.x()), number(v.y()), number(v.z())}); }

Vector3 vector3_of(const Json& value) {
  if (!value.is_array() || value.size() != 3) throw std::runtime_error("a point has three coordinates");
  return {value[0].get<double>(), value[1].get<double>(), value[2].get<double>()};
}

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

Json json(const measures::StepTimes& times) {
  return {{"median", number(times.median_us)},
          {"p99_9", number(times.p999_us)},
          {"worst", number(times.worst_us)}};
}

std::string read_file(const std::string& path, const std::string& who) {
  std::ifstream stream(path, std::ios::binary);
  if (!stream || !std::filesystem::is_regular_file(path))
    throw InputError(who + ": " + path + " cannot be read");
  return {std::istreambuf_iterator<char>(stream), {}};
}

}  // namespace touchstone::program
