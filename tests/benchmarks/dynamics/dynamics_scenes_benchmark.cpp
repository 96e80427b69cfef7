// Scenes that are hard for dynamics:
//
//     dynamics_scenes_benchmark [PARTS_OF_NAMES [ENGINES [SECONDS [STEPS [REPEATS [WORST [SEED]]]]]]]
//
// Each scene whose name has one of the parts (separated by '|'; `=NAME`: is NAME; `drawn:`, `strange:` and
// `rest:` scenes only where a part is given) with each engine (own,
// bullet, ode, mujoco; default: all that are built in; own@WORK: ours with so much work a step), each with
// its own check: processor time of a step
// (median, 99.9 %, most), the most as a multiple of Bullet's median of that scene, the share of the engine's
// steps that have contact points, the most as a multiple of Bullet's median of its own steps that have some
// (where a solid that is squeezed has been shot out, the median of all is that of an empty scene), the
// fastest box at the end, the fastest over the second half, the farthest from where it started (boxes that
// are to stay), the most that energy rose above the least so far. Cut short at SECONDS of processor time a
// run (default 60), which is said. STEPS: so many instead of the scene's own. REPEATS: a step's time is the
// least of so many runs, which leaves out what else the machine did; whether they came to the same bits is
// said. Each engine has a process of its own: one that ends it is a row of the table. Of ours the step that
// took most is described, with the time that finding its contacts took in the last run, by the wall's clock:
// what is left if nothing is solved; WORST: the same of so many steps that took most, below the table's row,
// each with the page faults of its last run. SEED: of the scenes that are drawn; no constant is to be chosen
// by seeds that a page reports.

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <functional>
#include <numeric>
#include <optional>
#include <string_view>

#include "touchstone/contact_core/threads/processor_time.hpp"
#include "touchstone/tests/benchmarks/dynamics/dynamics_scenes.hpp"

using namespace touchstone;
using namespace touchstone::benchmarks;

namespace {

constexpr unsigned kDrawnSeed = 17700;

double quantile(std::vector<double>& sorted, double share) {
  return sorted[static_cast<std::size_t>(share * static_cast<double>(sorted.size() - 1))];
}

struct Moment {
  double speed = 0.0;   ///< of the fastest box's centre or corner [m/s]
  double drift = 0.0;   ///< [m]
  double energy = 0.0;  ///< [J]
};

Moment moment_of(const BoxScene& scene, const BoxEngine& engine) {
  Moment out;
  for (std::size_t i = 0; i < scene.boxes.size(); ++i) {
    const SceneBox& box = scene.boxes[i];
    if (box.kind != SceneBox::Kind::free) continue;
    const BoxMotion motion = engine.motion(i);
    const double corner = 0.5 * norm(box.size), inertia = box.mass * box.size.x() * box.size.x() / 6.0;
    out.speed = std::max(out.speed, norm(motion.v_W) + corner * norm(motion.w_W));
    out.drift = std::max(out.drift, norm(motion.p_W - box.p_W));
    out.energy += 0.5 * (box.mass * dot(motion.v_W, motion.v_W) + inertia * dot(motion.w_W, motion.w_W)) +
                  box.mass * 9.81 * motion.p_W.z();
  }
  return out;
}

/// The outcome of a run, as its process passes it on.
struct Row {
  double median = 0.0, late = 0.0, most = 0.0;  ///< [us]
  double meeting = 0.0, meeting_median = 0.0;   ///< steps with contact points: their share; 0: none [us]
  double speed = 0.0, late_speed = 0.0;         ///< [m/s]
  double drift = 0.0, gained = 0.0;             ///< [m], [J]
  char engine[16] = "", remarks[512] = "";
};

struct Limits {
  double seconds = 60.0;
  int steps = 0, repeats = 1, worst = 0;
};

/// Of this process so far: memory that was touched for the first time.
long page_faults() {
  rusage usage;
  return getrusage(RUSAGE_SELF, &usage) == 0 ? usage.ru_minflt : 0;
}

/// Of each step: time the least of the runs, page faults those of the last one, points of the first.
struct StepCosts {
  std::vector<double> times;  ///< [us]
  std::vector<long> faults;
  std::vector<std::size_t> points;
};

void write_text(const std::string& text, char* to, std::size_t size) {
  std::strncpy(to, text.c_str(), size - 1);
}

/// One run of the scene from its start. @param costs in: of the runs before, or empty; out.
/// @param is_first else nothing but the costs is taken.
Vector3 run(const BoxScene& scene, BoxEngine& engine, const Limits& limits, StepCosts& costs, bool is_first,
            Row& row) {
  // Later runs repeat the steps of the first one.
  std::vector<double>& times = costs.times;
  const int steps = is_first
                        ? limits.steps > 0 ? limits.steps : static_cast<int>(scene.seconds / scene.step + 0.5)
                        : static_cast<int>(times.size());
  Moment now = moment_of(scene, engine);
  double least = now.energy, spent = 0.0;
  // The least time of each step over all runs counts; figures of motion are the first run's.
  for (int i = 0; i < steps && (!is_first || spent < 1e6 * limits.seconds); ++i) {
    const long faults_before = page_faults();
    const double start = processor_us();
    engine.step();
    const double time = processor_us() - start;
    const long faults = page_faults() - faults_before;
    spent += time;
    if (!is_first) {
      const auto at = static_cast<std::size_t>(i);
      times[at] = std::min(times[at], time);
      costs.faults[at] = faults;
      continue;
    }
    times.push_back(time);
    costs.faults.push_back(faults);
    costs.points.push_back(engine.points());
    now = moment_of(scene, engine);
    row.gained = std::max(row.gained, now.energy - least);
    least = std::min(least, now.energy);
    if (2 * i >= steps) row.late_speed = std::max(row.late_speed, now.speed);
  }
  // Remarks are the first run's, too.
  if (is_first) {
    row.speed = now.speed, row.drift = now.drift;
    write_text(engine.name(), row.engine, sizeof(row.engine));
    write_text(engine.remarks() + (times.size() < static_cast<std::size_t>(steps)
                                       ? " CUT after " + std::to_string(times.size()) + " steps"
                                       : ""),
               row.remarks, sizeof(row.remarks));
  }
  return engine.motion(scene.boxes.size() - 1).p_W;
}

/// To row.remarks the step that took most; the `worst` that took most are printed.
void describe_worst(const StepCosts& costs, const BoxEngine& engine, std::size_t worst, Row& row) {
  std::vector<std::size_t> order(costs.times.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const std::size_t count = std::min(std::max<std::size_t>(worst, 1), order.size());
  std::partial_sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(count), order.end(),
                    [&](std::size_t a, std::size_t b) { return costs.times[a] > costs.times[b]; });
  for (std::size_t i = 0; i < std::min(worst, count); ++i)
    std::fprintf(stderr, "%s: %.1f us at %zu, %ld page faults: %s\n", row.engine, costs.times[order[i]],
                 order[i], costs.faults[order[i]], engine.remarks_on(order[i]).c_str());
  const std::string on_most = count > 0 ? engine.remarks_on(order.front()) : "";
  if (!on_most.empty())
    write_text(std::string(row.remarks) + "; most at step " + std::to_string(order.front()) + ": " + on_most,
               row.remarks, sizeof(row.remarks));
}

/// To the row: times of all steps and of those that have contact points.
void summarise(const StepCosts& costs, Row& row) {
  std::vector<double> all = costs.times, meeting;
  for (std::size_t i = 0; i < costs.points.size(); ++i)
    if (costs.points[i] > 0) meeting.push_back(costs.times[i]);
  std::sort(all.begin(), all.end());
  std::sort(meeting.begin(), meeting.end());
  row.median = quantile(all, 0.5), row.late = quantile(all, 0.999), row.most = all.back();
  row.meeting = static_cast<double>(meeting.size()) / static_cast<double>(all.size());
  if (!meeting.empty()) row.meeting_median = quantile(meeting, 0.5);
}

using MakeEngine = std::function<std::unique_ptr<BoxEngine>(const BoxScene&)>;

/// @return nothing: the engine is not built in.
std::optional<Row> measure(const BoxScene& scene, const MakeEngine& make, const Limits& limits) {
  Row row;
  StepCosts costs;
  Vector3 last = Vector3::Zero();
  bool is_same = true;
  for (int repeat = 0; repeat < limits.repeats; ++repeat) {
    const auto engine = make(scene);
    if (!engine) return std::nullopt;
    const Vector3 p_W = run(scene, *engine, limits, costs, repeat == 0, row);
    is_same = is_same && (repeat == 0 || p_W == last);
    last = p_W;
    if (repeat + 1 == limits.repeats)
      describe_worst(costs, *engine, static_cast<std::size_t>(limits.worst), row);
  }
  summarise(costs, row);
  if (!is_same)
    write_text(std::string(row.remarks) + " (other bits when repeated)", row.remarks, sizeof(row.remarks));
  return row;
}

/// In a process of its own. @return a row whose engine is empty: not built in.
Row measure_apart(const BoxScene& scene, const char* name, const MakeEngine& make, const Limits& limits) {
  // The engine runs in a process of its own: some end it where they fail.
  int ends[2];
  if (pipe(ends) != 0) throw std::runtime_error("no pipe");
  const pid_t child = fork();
  if (child < 0) throw std::runtime_error("no process");
  if (child == 0) {
    close(ends[0]);
    if (std::freopen("/dev/null", "r", stdin) == nullptr) _exit(2);  // MuJoCo waits for a key
    Row row;
    try {
      row = measure(scene, make, limits).value_or(Row{});
    } catch (const std::exception& error) {
      write_text(name, row.engine, sizeof(row.engine));
      write_text(std::string("FAILED: ") + error.what(), row.remarks, sizeof(row.remarks));
    }
    _exit(write(ends[1], &row, sizeof(row)) == static_cast<ssize_t>(sizeof(row)) ? 0 : 2);
  }
  // The row comes whole, or the process's end says why not.
  close(ends[1]);
  Row row;
  const bool is_whole = read(ends[0], &row, sizeof(row)) == static_cast<ssize_t>(sizeof(row));
  close(ends[0]);
  int status = 0;
  waitpid(child, &status, 0);
  if (is_whole) return row;
  row = {};
  write_text(name, row.engine, sizeof(row.engine));
  write_text(WIFSIGNALED(status)
                 ? "FAILED: signal " + std::to_string(WTERMSIG(status))
                 : "FAILED: it ended the process, exit code " + std::to_string(WEXITSTATUS(status)),
             row.remarks, sizeof(row.remarks));
  return row;
}

/// @param bullet its row; nothing measured: not there
void print(const BoxScene& scene, const Row& row, const Row& bullet) {
  std::printf("| %s | %s | ", scene.name.c_str(), row.engine);
  if (row.median > 0.0) {
    std::printf("%.1f | %.1f | %.1f | ", row.median, row.late, row.most);
    if (bullet.median > 0.0) std::printf("%.1f", row.most / bullet.median);
    std::printf(" | %.0f | ", 100.0 * row.meeting);
    if (bullet.meeting_median > 0.0) std::printf("%.1f", row.most / bullet.meeting_median);
    std::printf(" | %.1e | %.1e | ", row.speed, row.late_speed);
    if (scene.is_placed) std::printf("%.1e", row.drift);
    std::printf(" | %.1e", row.gained);
  } else {
    std::printf("| | | | | | | | |");  // its process ended before it could say
  }
  std::printf(" | %s |\n", row.remarks);
  std::fflush(stdout);
}

bool has(std::string_view text, std::string_view part) { return text.find(part) != std::string_view::npos; }

bool has_any(std::string_view text, std::string_view parts) {
  for (std::size_t end = 0; end != std::string_view::npos;
       parts.remove_prefix(std::min(end + 1, parts.size()))) {
    end = parts.find('|');
    const std::string_view part = parts.substr(0, end);
    if (part.starts_with('=') ? text == part.substr(1) : has(text, part)) return true;
    if (end == std::string_view::npos) break;
  }
  return false;
}

/// Of the scenes that are measured only where they are named.
bool is_apart(std::string_view name) {
  return name.starts_with("drawn:") || name.starts_with("strange:") || name.starts_with("rest:");
}

/// Of the name of an engine; `own@WORK`: ours with so much work a step, > 0. @return empty: there is none.
MakeEngine engine_of(const std::string& name) {
  constexpr std::string_view kOwnAt = "own@";
  if (name == "own") return [](const BoxScene& scene) { return make_own(scene); };
  if (name.starts_with(kOwnAt)) {
    char* end = nullptr;
    const double work = std::strtod(&name[kOwnAt.size()], &end);
    if (*end != '\0' || !(work > 0.0)) return MakeEngine();
    return [work](const BoxScene& scene) { return make_own(scene, work); };
  }
  if (name == "bullet") return make_bullet;
  if (name == "ode") return make_ode;
  return name == "mujoco" ? MakeEngine(make_mujoco) : MakeEngine();
}

void compare(const BoxScene& scene, std::string_view engines, const Limits& limits) {
  std::vector<Row> rows;
  Row bullet;
  while (!engines.empty()) {
    const std::string name(engines.substr(0, engines.find(',')));
    engines.remove_prefix(std::min(name.size() + 1, engines.size()));
    const MakeEngine make = engine_of(name);
    if (!make) {
      std::fprintf(stderr, "dynamics_scenes_benchmark: no engine '%s'\n", name.c_str());
      std::exit(2);
    }
    const Row row = measure_apart(scene, name.c_str(), make, limits);
    if (row.engine[0] == '\0') continue;
    if (name == "bullet") bullet = row;
    rows.push_back(row);
  }
  for (const Row& row : rows) print(scene, row, bullet);
}

}  // namespace

int main(int argc, char** argv) {
  const std::string_view parts = argc > 1 ? argv[1] : "",
                         engines = argc > 2 ? argv[2] : "own,bullet,ode,mujoco";
  Limits limits;
  if (argc > 3) limits.seconds = std::atof(argv[3]);
  if (argc > 4) limits.steps = std::atoi(argv[4]);
  if (argc > 5) limits.repeats = std::max(1, std::atoi(argv[5]));
  if (argc > 6) limits.worst = std::max(0, std::atoi(argv[6]));
  const unsigned seed = argc > 7 ? static_cast<unsigned>(std::atoi(argv[7])) : kDrawnSeed;
  std::printf(
      "| scene | engine | median [us] | 99.9 %% | most | most over Bullet's median | with contacts [%%] | "
      "most over Bullet's median with contacts | at the end [m/s] | second half | drift [m] | gained [J] | "
      "|\n"
      "|---|---|---|---|---|---|---|---|---|---|---|---|---|\n");
  std::fflush(stdout);
  for (const BoxScene& scene : box_scenes(seed))
    if (has_any(scene.name, parts) && !(parts.empty() && is_apart(scene.name)))
      compare(scene, engines, limits);
  return 0;
}
