#include "touchstone/examples/station/options.hpp"

#include <CLI/CLI.hpp>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/examples/program/terminal/program.hpp"

namespace touchstone::station {
namespace {

void refuse_with_replay(const CLI::App& app) {
  for (const char* option : {"--rate", "--methods", "--dynamics", "--record", "--seconds", "--port", "--bind",
                             "--token", "--udp", "--page", "--open", "--soak", "--space-mouse"})
    if (app.count(option) > 0)
      throw InputError(std::string(option) + " is not of a --replay: the recording says how it was flown");
}

void add_flight_options(CLI::App& app, StationOptions& out, std::vector<unsigned>& methods) {
  app.add_option("--scene", out.scene,
                 "scene to begin with: a bundled one's name, a script (YAML), or a robot's file");
  out.robots.sphere_facets = 8;  // of the four methods, ours alone takes rounded solids
  robot_files::add_robot_options(app, out.robots);
  app.add_option("--rate", out.rate, "frames a second")
      ->check(CLI::Range(kLowestFrameRate, kHighestFrameRate))
      ->capture_default_str();
  app.add_option("--methods", methods, "0 no check, 1 Figure 1, 2 Figure 2; 3, ours, always runs")
      ->check(CLI::Range(0U, 3U));
  app.add_flag("--dynamics", out.dynamics,
               "begin with forces, where the scene's file has dynamics with a guard");
  app.add_option("--record", out.record, "file for every input, with its frame");
  app.add_option("--replay", out.replay, "fly a recording without a clock or page, and print its hash");
  CLI::Option* const open = app.add_option(
      "--open", out.open, "a record (training_run, --poses) or series (dynamics_run) that the page opens");
  app.add_option("--of", out.open_scene, "with --open: the script or scene file that was run")->needs(open);
  app.add_option("--poses", out.outputs.records,
                 "folder for a record of all poses and events of ours (CSV), live or of a --replay");
  app.add_option("--gltf", out.outputs.animations,
                 "with --poses: folder for an animation, written at the end");
  app.add_option("--cigi", out.outputs.cigi,
                 "HOST:PORT of an image generator, live or of a --replay in real time");
}

void add_server_options(CLI::App& app, StationOptions& out) {
  app.add_option("--seconds", out.seconds, "end after so long")->check(CLI::NonNegativeNumber);
  app.add_flag("--soak", out.soak, "a scripted hand flies, for the figures of a long flight; with --seconds");
  app.add_option("--space-mouse", out.space_mouse, "socket of spacenav's daemon, instead of the usual one");
  app.add_option("--port", out.server.port, "of the page; 0: any")->capture_default_str();
  app.add_option("--bind", out.server.bind, "address; beyond loopback a token is asked for")
      ->capture_default_str();
  app.add_option("--token", out.server.token, "instead of a random one");
  app.add_option("--udp", out.server.udp_port, "port for datagrams of hands");
  app.add_option("--page", out.server.page, "folder of the page's files")->check(CLI::ExistingDirectory);
  app.add_flag("--list", out.list, "scenes");
}

/// Beyond loopback nobody is let in without a token.
void settle_token(StationOptions& out) {
  const bool has_token = !out.server.token.empty();
  if (has_token && out.server.token.size() < 8) throw InputError("a token of fewer than 8 characters");
  if (!has_token && out.server.bind != "127.0.0.1" && out.server.bind != "::1")
    out.server.token = make_token();
}

/// The user's scenes join the bundled ones, and are flown first.
void settle_scenes(StationOptions& out) {
  if (std::filesystem::path(out.scene).extension() == ".yaml" || is_robot_file(out.scene))
    out.scripts.emplace_back(std::exchange(out.scene, ""));
  out.scripts.insert(out.scripts.end(), out.robots.files.begin(), out.robots.files.end());
  if (out.scene.empty() && !out.scripts.empty()) out.scene = scene_name(out.scripts.front());
}

}  // namespace

std::optional<StationOptions> parse_station_options(int argc, const char* const* argv,
                                                    const std::filesystem::path& page) {
  StationOptions out;
  out.server.page = page;
  out.outputs.records_option = "--poses";
  CLI::App app(
      "The training station: flies an arm from a page in a browser on this machine, with and without contact "
      "detection.",
      "touchstone_station");
  std::vector<unsigned> methods;
  add_flight_options(app, out, methods);
  add_server_options(app, out);
  if (!program::parse_command_line(app, argc, argv)) return std::nullopt;
  settle_token(out);
  if (!out.open.empty() && out.open_scene.empty())
    throw InputError("--open needs --of SCENE: records have no solids");
  if (!methods.empty()) {
    out.methods = 0;
    for (const unsigned method : methods) out.methods |= 1U << method;
  }
  if (!out.replay.empty()) refuse_with_replay(app);
  settle_scenes(out);
  return out;
}

}  // namespace touchstone::station
