// swept_cases FILE [NARROWPHASE ...]: the swept cases of a JSON file of published cases ("kind": "ccd", with
// "motion" and "oracle_toi") over each narrowphase (native). Exit code 1 where native or exact violates one.

#include <cstdlib>
#include <fstream>
#include <iomanip>
#include <iostream>
#include <nlohmann/json.hpp>
#include <vector>

#include "swept_cases.hpp"
#include "touchstone/adapters/all/all_backends.hpp"
#include "touchstone/contact_core/input_error.hpp"

namespace touchstone {
namespace {

using nlohmann::json;

Vector3 vector_of(const json& v) { return {v[0].get<double>(), v[1].get<double>(), v[2].get<double>()}; }

Hexahedron solid_of(const json& shape) {
  if (shape["type"] == "box") return Hexahedron::from_size(vector_of(shape["size"]));
  std::vector<Vector3> vertices;
  for (const json& v : shape["vertices"]) vertices.push_back(vector_of(v));
  return Hexahedron::from_vertices(vertices);
}

Pose pose_of(const json& pose) {
  Pose X;
  if (pose.contains("matrix")) {
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) X.R(i, j) = pose["matrix"][i][j].get<double>();
      X.p[i] = pose["matrix"][i][3].get<double>();
    }
    return X;
  }
  const json& q = pose["quaternion_wxyz"];
  X.R = rotation_from_quaternion(q[0].get<double>(), q[1].get<double>(), q[2].get<double>(),
                                 q[3].get<double>());
  X.p = vector_of(pose["position"]);
  return X;
}

SweptCase swept_of(const json& entry) {
  const json& motion = entry["motion"];
  // Time of impact, and how long the motion takes.
  const bool turns = motion.contains("angvel_1");
  const json& toi = entry["oracle_toi"];
  SweptCase out{entry["id"], {solid_of(entry["shapes"][0]), solid_of(entry["shapes"][1])},
                {},          {RigidPath(), RigidPath()},
                0.0,         0.0};
  out.exact_time = toi.is_null() ? SweptCase::kNever : std::stod(toi.get<std::string>());
  const bool has_end = motion.contains("t_max") && !motion["t_max"].is_null();
  out.duration = has_end                               ? motion["t_max"].get<double>()
                 : out.exact_time == SweptCase::kNever ? 3.0
                                                       : std::max(3.0, 2.0 * out.exact_time);
  if (turns) out.error = 1e-13 * out.duration + 1e-12;  // as stated beside it
  // Paths about the centre of a solid that turns.
  const std::array<Vector3, 2> velocity{vector_of(motion[turns ? "linvel_1" : "velocity_1"]),
                                        vector_of(motion["velocity_2"])};
  for (int i = 0; i < 2; ++i) {
    Pose X_WO = pose_of(entry["poses"][i]);
    Vector3 turn = Vector3::Zero();
    if (turns && i == 0) {
      const Vector3 centre = vector_of(motion["local_center_1"]);
      X_WO.p = transform(X_WO, centre);
      out.X_OS[0].p = -centre;
      turn = out.duration * vector_of(motion["angvel_1"]);
    }
    out.paths[i] = RigidPath::by(X_WO, out.duration * velocity[i], turn);
  }
  return out;
}

bool run(const json& entries, const std::string& name) {
  BackendRegistry registry;
  register_all_backends(registry);
  bool holds = true;
  std::cout << name << '\n';
  for (const json& entry : entries) {
    std::cout << "  " << std::left << std::setw(26) << entry["id"].get<std::string>() << std::right;
    try {
      const SweptCase swept = swept_of(entry);
      const auto narrowphase = registry.make_narrowphase(name);
      narrowphase->build(swept.solids);
      const SweptAnswer a = answer(swept, *narrowphase);
      std::cout << (a.is_sampled ? "sampled" : "proven ") << "  exact " << std::setprecision(12)
                << std::setw(17) << swept.exact_time << "  lo " << std::setw(17) << a.lo << "  separation "
                << std::setprecision(3) << std::setw(9) << a.separation << " = " << std::setw(9)
                << a.separation / a.gap << " g  " << std::setw(3) << a.queries << " queries  " << a.remark
                << (a.violation.empty() ? "" : "  VIOLATION: " + a.violation) << '\n';
      holds = holds && a.violation.empty();
    } catch (const InputError& error) {
      std::cout << "no pair of hexahedra: " << error.what() << '\n';
    }
  }
  return holds;
}

}  // namespace
}  // namespace touchstone

int main(int argc, char** argv) {
  try {
    if (argc < 2) throw touchstone::InputError("which file?");
    std::ifstream file(argv[1]);
    const nlohmann::json entries = nlohmann::json::parse(file);
    std::vector<std::string> names(argv + 2, argv + argc);
    if (names.empty()) names = {"native"};
    bool holds = true;
    for (const std::string& name : names) {
      const bool own = touchstone::run(entries, name);
      holds = holds && (own || (name != "native" && name != "exact"));
    }
    return holds ? EXIT_SUCCESS : EXIT_FAILURE;
  } catch (const std::exception& error) {
    std::cerr << "swept_cases: " << error.what() << '\n';
    return 2;
  }
}
