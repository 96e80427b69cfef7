#include <fmt/format.h>
#include <pthread.h>
#include <sched.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <thread>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/contact_core/threads/processor_time.hpp"
#include "touchstone/examples/program/options/bundled_folder.hpp"
#include "touchstone/examples/program/terminal/interruption.hpp"
#include "touchstone/examples/program/terminal/program.hpp"
#include "touchstone/examples/station/flight/shown_flight.hpp"
#include "touchstone/examples/station/messages/frame_message.hpp"
#include "touchstone/examples/station/messages/recorded_flight.hpp"
#include "touchstone/examples/station/options.hpp"
#include "touchstone/examples/station/server/loop.hpp"
#include "touchstone/examples/station/server/scripted_hand.hpp"
#include "touchstone/examples/station/server/server.hpp"
#include "touchstone/examples/station/server/space_mouse.hpp"

namespace {

using namespace touchstone;
using namespace touchstone::station;
namespace fs = std::filesystem;

/// Robots as they are flown, with their meshes where a page shows them. Where names alone are asked for
/// nothing is fitted.
SceneRobots robots_of(const StationOptions& options, const SceneScales* recorded = nullptr) {
  SceneRobots robots{options.robots, {}, !options.list && options.replay.empty(), recorded};
  if (options.list)
    robots.choices.over = "box";
  else
    robots.on_account = program::print_now;
  return robots;
}

/// @throws InputError: by name neither could be chosen, nor found by a replay.
void refuse_equal_names(const std::vector<fs::path>& scripts) {
  for (auto one = scripts.begin(); one != scripts.end(); ++one)
    for (auto other = scripts.begin(); other != one; ++other)
      if (scene_name(*one) == scene_name(*other))
        throw InputError(one->string() + ": '" + other->string() + "' is a scene of the same name");
}

/// The bundled ones by name, `worksite` first; then the user's own, each instead of a bundled one of its
/// name. @param recorded hands' rates of a replay; null: a live flight's.
StationScenes load_scenes(const StationOptions& options, const fs::path& folder,
                          const SceneScales* recorded = nullptr) {
  refuse_equal_names(options.scripts);
  const auto is_given = [&](const fs::path& file) {
    return std::any_of(options.scripts.begin(), options.scripts.end(),
                       [&](const fs::path& script) { return script.stem() == file.stem(); });
  };
  std::vector<fs::path> files;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder))
    if (entry.path().extension() == ".yaml" && !is_given(entry.path())) files.push_back(entry.path());
  std::sort(files.begin(), files.end(), [](const fs::path& a, const fs::path& b) {
    const bool a_first = a.stem() == "worksite", b_first = b.stem() == "worksite";
    return a_first != b_first ? a_first : a < b;
  });
  files.insert(files.end(), options.scripts.begin(), options.scripts.end());
  StationScenes scenes;
  const SceneRobots robots = robots_of(options, recorded);
  for (const fs::path& file : files) {
    scenes.push_back(load_station_scene(file, options.rate, robots));
    for (const std::uint32_t object : scenes.back()->meshes.left_out)
      program::print_now(file.string() + ": '" + scenes.back()->setting.object_name(object) +
                         "': its mesh is too large for the page, which shows its hexahedra\n");
  }
  return scenes;
}

std::size_t scene_to_fly(const std::string& name, const StationScenes& scenes) {
  if (name.empty()) return 0;
  const std::size_t found = find_scene(scenes, name);
  if (found == scenes.size()) throw InputError("there is no scene '" + name + "': see --list");
  return found;
}

void print_end(const Session& session) {
  program::print_now(fmt::format("frames {}, hash {}\n", session.frame(), hash_text(session.hash())));
}

std::ifstream open_recording(const fs::path& file) {
  std::ifstream in(file);
  if (!in) throw InputError(file.string() + ": cannot be read");
  return in;
}

/// The verdict of `exact` on each method's frames.
void print_verdict(const Session& session, MergeJudge& judge) {
  const JudgeFigures& figures = judge.take();
  constexpr std::array<const char*, kMethods> kNames = {"no check", "figure 1", "figure 2", "ours"};
  for (const Method& method : session.flight().methods()) {
    const auto index = static_cast<std::size_t>(method.kind);
    const MergeFigures& merge = figures.methods[index];
    fmt::print("{:9}  merged {:6} of {:6} frames, worst {:10.3e} m, stopped in {:6}\n", kNames[index],
               merge.merged, merge.judged, merge.depth_worst, method.blocked_frames);
    if (merge.with_off > 0)
      fmt::print("           in {} of them something was switched off: its pairs were not judged\n",
                 merge.with_off);
  }
}

int replay_file(StationOptions options, const fs::path& folder) {
  std::ifstream head = open_recording(options.replay);
  const station::Recording header = read_header(head, options.replay.string());
  options.rate = header.rate;
  // A scene of one's own: from where it was, unless --scene names another place.
  if (options.scripts.empty() && fs::path(header.script).parent_path() != fs::absolute(folder) &&
      fs::is_regular_file(header.script))
    options.scripts.emplace_back(header.script);
  // The flight as it was recorded, over the scenes as they are now.
  const StationScenes scenes = load_scenes(options, folder, &header.rates);
  std::ifstream in = open_recording(options.replay);
  const station::Recording recording = read_recording(in, options.replay.string(), scenes);
  const std::size_t scene = scene_to_fly(recording.scene, scenes);
  if (!recording.files.empty() && recording.files != scenes[scene]->files)
    program::print_now("the files of scene '" + recording.scene +
                       "' are others than when it was recorded: " + scenes[scene]->file.string() + "\n");
  // Fly it again, judged and shown.
  Session session(scenes, scene, recording.methods, recording.dynamics);
  const std::string name = options.replay.stem().string();
  training::prepare_outputs(options.outputs, {name});
  training::FlightOutputs outputs(options.outputs, session.flight().scene().setting, name, true);
  ShownFlight shown(session, outputs.receivers());
  const auto start = std::chrono::steady_clock::now();
  MergeJudge judge(scenes);
  TimeHistogram steps;
  double before = processor_us();
  replay(recording, session, 0, [&](const Session& flown) {
    steps.add(processor_us() - before);
    judge.offer(flown);
    judge.work();
    shown.send(flown);
    if (outputs.is_in_real_time())
      std::this_thread::sleep_until(start + std::chrono::duration<double>(flown.time()));
    before = processor_us();
  });
  // Say how it went, and whether the bits are those recorded.
  print_verdict(session, judge);
  fmt::print(
      "a step, all methods, by the thread's clock: median {:.0f} us, 99.9 % {:.0f} us, worst {:.0f} us\n",
      steps.quantile_us(0.5), steps.quantile_us(0.999), steps.worst_us());
  for (const training::OutputFigures& figures : outputs.close())
    fmt::print("{}: {} of {} frames delivered {}\n", figures.receiver, figures.status.delivered,
               figures.status.offered, figures.error);
  print_end(session);
  if (recording.hash.empty()) {
    program::print_now("the recording has no end: its bits were NOT compared\n");
    return 1;
  }
  const bool is_same = recording.hash == hash_text(session.hash());
  program::print_now(is_same ? "the same bits as recorded\n"
                             : "NOT the bits recorded: " + recording.hash + "\n");
  return is_same ? 0 : 1;
}

/// Before whatever else runs here, where the system lets it: a step takes a small part of its period.
bool ask_for_real_time() {
  sched_param parameters{};
  parameters.sched_priority = 1;
  return pthread_setschedparam(pthread_self(), SCHED_RR, &parameters) == 0;
}

/// Judges and records, off the loop's path, until the loop has ended.
class Clerk {
 public:
  Clerk(MergeJudge& judge, Recorder& recorder)
      : thread_([this, &judge, &recorder] {
          while (!stop_.load(std::memory_order_relaxed)) {
            const bool wrote = recorder.work(), judged = judge.work();
            if (!wrote && !judged) std::this_thread::sleep_for(std::chrono::milliseconds(5));
          }
        }) {}
  ~Clerk() { end(); }
  void end() {
    stop_ = true;
    if (thread_.joinable()) thread_.join();
  }

 private:
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

/// Lines that a flight ends with. Outputs end in here, once.
std::string end_of(const Session& session, const Exchange& exchange, const Server& server,
                   LiveOutputs& outputs) {
  return fmt::format("frames {}, hash {}\n", session.frame(), hash_text(session.hash())) +
         figures_text(exchange.figures, server.latency()) + outputs.end();
}

/// Until its end or a signal, after which the recording has its end.
void run_loop(StationLoop& loop, const StationOptions& options, const std::atomic<bool>& stop) {
  const bool is_first = ask_for_real_time();
  program::print_now(is_first ? "" : "the loop runs at ordinary priority: a busy machine makes it late\n");
  // At least one frame of however little: 0 would be without end.
  loop.run(stop, static_cast<std::uint64_t>(std::ceil(options.seconds * options.rate)));
}

/// Of the files of a live flight.
std::string name_of(const StationOptions& options, const StationScene& scene) {
  return options.record.empty() ? scene.name : options.record.stem().string();
}

void print_address(const StationOptions& options, const Server& server) {
  const bool is_v6 = options.server.bind.find(':') != std::string::npos;
  const std::string host = is_v6 ? "[" + options.server.bind + "]" : options.server.bind;
  const std::string token = options.server.token.empty() ? "" : "?token=" + options.server.token;
  program::print_now(fmt::format("http://{}:{}/{}\n", host, server.port(), token));
}

/// The head of a live flight's recording.
station::Recording header_of(const StationOptions& options, const StationScene& scene) {
  station::Recording header;
  header.scene = scene.name;
  header.rate = options.rate;
  header.methods = options.methods;
  header.dynamics = options.dynamics;
  header.script = scene.file.string();
  header.files = scene.files;
  return header;
}

int fly(StationOptions options, const fs::path& folder) {
  const StationScenes scenes = load_scenes(options, folder);
  const std::size_t scene = scene_to_fly(options.scene, scenes);
  if (options.dynamics && !scenes[scene]->dynamics)
    throw InputError("--dynamics: the scene '" + scenes[scene]->name + "' has none (dynamics with a guard)");
  if (!options.open.empty())
    options.server.saved_flight =
        saved_flight(load_recorded_flight(options.open, options.open_scene, robots_of(options)));
  // The session; who judges, records, shows and serves it.
  Session session(scenes, scene, options.methods, options.dynamics);
  Exchange exchange(most_frame_bytes(scenes));
  MergeJudge judge(scenes);
  Recorder recorder(scenes, header_of(options, *scenes[scene]));
  options.outputs.patience = std::chrono::milliseconds(300);  // a signal ends it all within a second
  LiveOutputs outputs(options.outputs, session, name_of(options, *scenes[scene]));
  Server server(options.server, exchange, scenes, scene, options.rate, &recorder);
  if (!options.record.empty()) recorder.open(options.record);
  Clerk clerk(judge, recorder);
  StationLoop loop(session, exchange, judge, &recorder, &outputs);
  // Who may fly.
  print_address(options, server);
  const SpaceMouse mouse(server, options.space_mouse);
  program::print_now(mouse.text() + "\n");
  std::optional<ScriptedHand> hand;
  if (options.soak) hand.emplace(server, options.rate);

  std::atomic<bool> stop{false}, ended{false};
  std::string end;  // of the answer to a signal, or under hold_interrupts()
  const auto reach_end = [&] {
    if (end.empty()) end = end_of(session, exchange, server, outputs);
  };
  // A signal lets the frame end, so that the recording gets its end, and the outputs theirs.
  const program::OnInterrupt on_interrupt([&] {
    stop = true;
    while (!ended) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    reach_end();
    return end + (outputs.has_animation()
                      ? "gltf: not written for the signal; --replay of a --record writes it"
                      : "");
  });
  // Fly until the end or a signal; then close what was opened, in this order.
  run_loop(loop, options, stop);
  clerk.end();
  recorder.end(session.frame(), session.hash());
  ended = true;
  {
    const auto hold = program::hold_interrupts();
    reach_end();
  }
  program::stop_if_interrupted();  // not while held: the answer waits for that
  program::print_now(end);
  program::print_now(outputs.write_animation());
  return 0;
}

int run(int argc, char** argv) {
  const std::optional<StationOptions> options =
      parse_station_options(argc, argv, program::bundled_folder(TOUCHSTONE_EXAMPLES, "station/page"));
  if (!options) return 0;
  const fs::path folder = program::bundled_folder(TOUCHSTONE_EXAMPLES, "station/scenes");
  if (options->list) {
    for (const auto& scene : load_scenes(*options, folder))
      fmt::print("{:20}  {}\n", scene->name, scene->setting.script().name);
    return 0;
  }
  return options->replay.empty() ? fly(*options, folder) : replay_file(*options, folder);
}

}  // namespace

int main(int argc, char** argv) {
  return touchstone::program::run_program("touchstone_station", [&] { return run(argc, argv); });
}
