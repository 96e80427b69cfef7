#include "touchstone/examples/training_run/cli/run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/examples/training_run/flight/fly.hpp"
#include "touchstone/examples/training_run/setting/robot_script.hpp"

namespace touchstone::training {
namespace {

/// Of the plots: before and after what is first blocked or shown merged [s].
constexpr double kPlotBefore = 0.15, kPlotAfter = 0.35;
constexpr std::size_t kMostPlotPoints = 500;

/// Of a flight, whose log is kept whole: some 100 bytes a pose.
constexpr double kMostFrames = 1e6, kMostPoses = 2e7;

constexpr std::string_view kContactWorld = "contact world", kFirstBuild = "figure 2";

std::string flight_name(const std::string& script, std::string_view method, std::string_view backend) {
  std::string name = fmt::format("{}_{}", script, method);
  if (method == kContactWorld) name += fmt::format("_{}", backend);
  std::replace(name.begin(), name.end(), ' ', '_');
  return name;
}

Script read_script(const std::filesystem::path& file, const Options& options,
                   const std::function<void(const std::string&)>& on_account) {
  if (!is_robot_file(file)) return load_script(file, robot_files::arm_models(options.robots, on_account));
  const Robot robot = robot_files::load_robot_file(file, options.robots);
  if (on_account) on_account(robot_files::account_of(robot));
  return robot_script(robot.mechanism);
}

class Runner {
 public:
  Runner(ScriptResult& result, const OutputOptions& outputs, program::ProgressLine& progress,
         const OnMethod& on_method)
      : result_(result),
        setting_(*result.setting),
        outputs_(outputs),
        judge_(setting_),
        progress_(progress),
        on_method_(on_method) {}

  /// Flies and judges; the log is kept for plots if asked. @param is_shown on the image generator.
  void run(Method& method, const Resolution& resolution, bool keep, bool is_shown) {
    const std::string what = fmt::format("{}: {}, {}", result_.file, method.name(), method.backend());
    const auto share = [&](double done) { progress_.share(done); };
    // Outputs see each frame while the method flies.
    progress_.step(what + ": flying");
    FlightOutputs outputs(outputs_, setting_, flight_name(result_.file, method.name(), method.backend()),
                          is_shown);
    for (FrameOutput* receiver : outputs.receivers()) method.attach(*receiver);
    FlightLog log = fly(setting_, method, outputs.is_in_real_time(), share);
    // Without all events the flight cannot be judged.
    if (log.lost_events > 0)
      throw InputError(fmt::format("{}: {} events found no room in the log", what, log.lost_events));
    // Judging comes after the flight, so that it slows no frame.
    progress_.step(what + ": judging");
    MethodResult out;
    out.method = method.name();
    out.backend = method.backend();
    out.check = method.check();
    out.verdict = judge_.judge(log, resolution, share);
    out.times = measures::step_times(log.frame_us);
    out.cpu_times = measures::step_times(log.frame_cpu_us);
    out.allocations = log.allocations;
    out.queries = log.queries;
    out.iteration_limits = log.iteration_limits;
    out.hands = log.hand_figures;
    out.outputs = outputs.close();
    result_.methods.push_back(std::move(out));
    if (on_method_) on_method_(result_);
    // Some logs are kept for figures that need all methods.
    if (keep) kept_.emplace_back(result_.methods.size() - 1, std::move(log));
  }

  /// Where contact is only cued, all methods show the same.
  void plot() {
    if (setting_.scene().policy == ContactPolicy::cue) return;
    const std::optional<double> centre = first_contact();
    if (!centre) return;
    const double rate = setting_.scene().frame_rate;
    const auto frame_at = [&](double time) {
      return std::min(setting_.frame_count(),
                      static_cast<std::size_t>(std::max(0.0, std::round(time * rate))));
    };
    const std::size_t first = frame_at(*centre - kPlotBefore);
    const std::size_t last =
        std::min(frame_at(*centre + std::max(kPlotAfter, 4.0 / rate)), first + kMostPlotPoints);
    for (const auto& [index, log] : kept_)
      result_.methods[index].separations = judge_.separations(log, first, last);
  }

 private:
  std::optional<double> first_contact() const {
    for (auto method = result_.methods.rbegin(); method != result_.methods.rend(); ++method) {
      if (!method->verdict.stops.empty()) return method->verdict.stops[0].time;
      if (!method->verdict.cues.empty()) return method->verdict.cues[0].time;
    }
    return std::nullopt;
  }

  ScriptResult& result_;
  const Setting& setting_;
  const OutputOptions& outputs_;
  Judge judge_;
  program::ProgressLine& progress_;
  const OnMethod& on_method_;
  std::vector<std::pair<std::size_t, FlightLog>> kept_;
};

}  // namespace

std::vector<std::string> flight_names(const std::string& script, const std::vector<std::string>& backends) {
  std::vector<std::string> names;
  for (const std::string_view method :
       {std::string_view("no check"), std::string_view("figure 1"), kFirstBuild})
    names.push_back(flight_name(script, method, ""));
  for (const std::string& backend : backends) names.push_back(flight_name(script, kContactWorld, backend));
  return names;
}

std::shared_ptr<const Setting> load_setting(const std::filesystem::path& file, const Options& options,
                                            const std::function<void(const std::string&)>& on_account) {
  Script script = read_script(file, options, on_account);
  for (const OperatorAction& action : script.actions)
    if (action.kind == OperatorAction::Kind::hold)
      throw InputError(file.string() +
                       ": an arm that walks is flown by the station (examples/run --station)");
  const double frames =
      script.scene.duration * (options.frame_rate > 0.0 ? options.frame_rate : script.scene.frame_rate);
  const auto objects = static_cast<double>(script.scene.objects.size());
  if (!(frames <= kMostFrames) || !(frames * objects <= kMostPoses))
    throw InputError(
        fmt::format("{}: {:.3g} frames of {} objects are more than a flight has room for ({:.0e} frames, "
                    "{:.0e} poses); shorten the duration",
                    file.string(), frames, objects, kMostFrames, kMostPoses));
  return std::make_shared<const Setting>(std::move(script), options.frame_rate);
}

ScriptResult run_script(const std::filesystem::path& file, const Options& options,
                        const BackendRegistry& registry, const std::vector<std::string>& backends,
                        program::ProgressLine& progress, const OnMethod& on_method) {
  ScriptResult result;
  result.file = file.stem().string();
  result.setting = load_setting(file, options);
  Runner runner(result, options.outputs, progress, on_method);
  // Methods without a narrowphase of choice.
  runner.run(*make_unchecked_method(*result.setting), {}, true, false);
  runner.run(*make_late_report_method(*result.setting), {}, true, false);
  const auto not_flown = [&](std::string_view by, std::string_view over, const InputError& error) {
    MethodResult refused;
    refused.method = by;
    refused.backend = over;
    refused.not_flown = error.what();
    result.methods.push_back(std::move(refused));
  };
  std::unique_ptr<Method> first_build;
  try {
    first_build = make_first_build_method(*result.setting);
  } catch (const InputError& error) {
    not_flown(kFirstBuild, "edge_face", error);
  }
  if (first_build) runner.run(*first_build, {}, true, false);
  // The contact world over each narrowphase.
  bool is_first = true;
  for (const std::string& backend : backends) {
    std::unique_ptr<Narrowphase> narrowphase = registry.make_narrowphase(backend);
    std::unique_ptr<Method> method;
    const Narrowphase& asked =
        *narrowphase;  // its resolution is known once it is built, and the method owns it
    try {
      method = make_contact_world_method(*result.setting, std::move(narrowphase),
                                         registry.make_broadphase("native"));
    } catch (const InputError& error) {
      not_flown(kContactWorld, backend, error);
      continue;
    }
    // A sampled world takes native's separations: the backend's resolution of depths does not matter there.
    const bool is_proven = method->check() == MotionCheck::proven;
    runner.run(*method, is_proven ? asked.capabilities().resolution : Resolution{}, is_first, is_first);
    is_first = false;
  }
  runner.plot();
  return result;
}

}  // namespace touchstone::training
