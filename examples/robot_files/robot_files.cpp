#include "touchstone/examples/robot_files/robot_files.hpp"

#include <CLI/CLI.hpp>
#include <cmath>
#include <memory>
#include <set>

#include "touchstone/adapters/robot_formats/robot_formats.hpp"
#include "touchstone/adapters/robots/enclosing_box.hpp"
#include "touchstone/adapters/robots/fitted_cover.hpp"
#include "touchstone/adapters/robots/simplify.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/contact_core/mechanism/arms/bundled_arms.hpp"
#include "touchstone/contact_core/native/native.hpp"
#include "touchstone/examples/program/options/length.hpp"
#include "touchstone/examples/program/terminal/progress.hpp"
#include "touchstone/examples/robot_files/kept_covers.hpp"
#ifdef TOUCHSTONE_HAS_COVER_PROOF
#include "touchstone/adapters/cover_proof/cover_proof.hpp"
#endif

namespace touchstone::robot_files {
namespace {

void prove([[maybe_unused]] const TriangleMesh& mesh, [[maybe_unused]] const Fit& fit,
           [[maybe_unused]] const std::string& name) {
#ifdef TOUCHSTONE_HAS_COVER_PROOF
  CoverClaim claim;
  claim.excess = fit.excess;
  for (const FittedHexahedron& each : fit.hexahedra) claim.hexahedra.push_back(each.vertices);
  const CoverVerdict verdict = check_cover(mesh, claim);
  if (!verdict.is_proven) throw InputError("mesh '" + name + "': its cover is not proven: " + verdict.reason);
#endif
}

CoverMesh make_covers(const RobotChoices& choices) {
  if (choices.over == "box") return enclosing_box;
  const program::Length length = program::parse_length(choices.over, "--over");
  FittedCoverOptions options;
  if (!choices.covers_folder.empty()) {
    const KeptCovers kept(choices.covers_folder);
    options.find = [kept](const TriangleMesh& mesh, const FitOptions& asked) {
      return kept.find(mesh, asked);
    };
    options.keep = [kept](const TriangleMesh& mesh, const FitOptions& asked, const Fit& fit) {
      kept.keep(mesh, asked, fit);
    };
  }
  (length.is_share ? options.over_share : options.over) = length.value;
  options.check = prove;
  options.progress = [line = std::make_shared<program::ProgressLine>(), last = std::string()](
                         const std::string& mesh, std::string_view stage, double share) mutable {
    if (mesh != last) line->step("cover " + (last = mesh));
    if (stage == "search") line->share(share);
    if (stage == "measure" && share == 1.0) line->finish(), last.clear();
  };
  return fitted_cover(options);
}

}  // namespace

void add_robot_options(CLI::App& app, RobotChoices& choices) {
  app.add_option("--robot", choices.files,
                 "Robots of others, flown instead of the bundled files: .urdf, .sdf, .xml or .mjcf");
  app.add_option("--package-path", choices.package_paths,
                 "Folders in which package:// and model:// of robots are looked for (then ROS_PACKAGE_PATH, "
                 "GAZEBO_MODEL_PATH, AMENT_PREFIX_PATH and the robot's own folders upwards)");
  app.add_option(
         "--over", choices.over,
         "Largest error, outwards, of the hexahedra that cover a robot's mesh: 5mm, 0.02m, or 5% of the "
         "mesh's diagonal; box: one box each")
      ->capture_default_str();
  app.add_option(
      "--covers", choices.covers_folder,
      "Folder that keeps covers of meshes from run to run; they are proven anew where they are used");
  app.add_flag("--any-mesh-size", choices.any_mesh_size,
               "Takes robots whose largest mesh is 30 times as large as the joints reach, or a 300th");
  app.add_option("--sphere-facets", choices.sphere_facets,
                 "Spheres and capsules of robots: 0, exact, for backends that take rounded solids (native, "
                 "exact) and our dynamics over these; else hexahedra with so many facets round, 8 or 16, for "
                 "all")
      ->capture_default_str();
  app.add_option("--srdf", choices.srdf, "SRDF file with the pairs of links that are not checked");
}

Robot load_robot_file(const std::filesystem::path& file, const RobotChoices& choices) {
  RobotOptions options;
  options.mimic = MimicJoints::free;
  options.sphere_facets = choices.sphere_facets;
  for (const std::string& path : choices.package_paths) options.package_paths.emplace_back(path);
  options.any_mesh_size = choices.any_mesh_size;
  if (!*choices.covers) *choices.covers = make_covers(choices);
  if (choices.over != "box") load_robot(file, options);  // for its units, before anything is fitted
  options.cover_mesh = *choices.covers;
  options.keep_meshes = choices.keep_meshes;
  Robot robot = load_robot(file, options);
  if (!choices.srdf.empty()) robot.mechanism.exempt_pairs = load_exempt_pairs(choices.srdf);
  const std::unique_ptr<Narrowphase> native = make_native();
  for (std::string& line : exempt_reference_overlaps(robot.mechanism, *native))
    robot.notes.push_back(file.string() + ": " + std::move(line));
  return robot;
}

std::string account_of(const Robot& robot) {
  std::string text;
  for (const ShapeReplacement& replacement : robot.replaced) text += to_string(replacement) + "\n";
  for (const std::string& note : robot.notes) text += note + "\n";
  return text;
}

std::vector<double> start_values(const Mechanism& robot) {
  std::vector<double> q{robot.reference().begin(), robot.reference().end()};
  for (const Mechanism::Joint& joint : robot.joints())
    if (joint.value != Mechanism::kNone && std::isfinite(joint.lower) && std::isfinite(joint.upper))
      q[joint.value] = 0.5 * (joint.lower + joint.upper);
  return q;
}

std::function<MechanismDescription(const std::string&, const std::filesystem::path&)> arm_models(
    const RobotChoices& choices, std::function<void(const std::string& account)> on_account) {
  const auto seen = std::make_shared<std::set<std::string>>();
  return [choices, on_account = std::move(on_account), seen](const std::string& model,
                                                             const std::filesystem::path& folder) {
    if (!is_robot_file(model)) return make_bundled_arm(model);
    const std::filesystem::path file = folder / model;
    Robot robot = load_robot_file(file, choices);
    if (on_account && seen->insert(file.string()).second) on_account(account_of(robot));
    return std::move(robot.mechanism);
  };
}

}  // namespace touchstone::robot_files
