// Scenes that are hard for dynamics: dynamics_scenes_benchmark [PART_OF_A_NAME [ENGINES [SECONDS [STEPS]]]]
//
// Each scene with each engine (own, bullet, ode, mujoco; default: all that are built in), each with its own
// check: processor time of a step (median, 99.9 %, most), the fastest box at the end, the fastest over the
// second half, the farthest from where it started (boxes that are to stay), the most that energy rose above
// the least so far. Cut short at SECONDS of processor time an engine (default 60), which is said. STEPS: so
// many instead of the scene's own.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string_view>

#include "touchstone/tests/benchmarks/dynamics_scenes.hpp"
#include "touchstone/tests/benchmarks/processor_time.hpp"

using namespace touchstone;
using namespace touchstone::benchmarks;

namespace {

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

void run(const BoxScene& scene, BoxEngine& engine, double seconds, int asked_steps) {
  const int steps = asked_steps > 0 ? asked_steps : static_cast<int>(scene.seconds / scene.step + 0.5);
  std::vector<double> times;
  Moment now = moment_of(scene, engine);
  double least = now.energy, gained = 0.0, late_speed = 0.0, spent = 0.0;
  for (int i = 0; i < steps && spent < 1e6 * seconds; ++i) {
    const double start = processor_time();
    engine.step();
    times.push_back(processor_time() - start);
    spent += times.back();
    now = moment_of(scene, engine);
    gained = std::max(gained, now.energy - least);
    least = std::min(least, now.energy);
    if (2 * i >= steps) late_speed = std::max(late_speed, now.speed);
  }
  const bool is_cut = times.size() < static_cast<std::size_t>(steps);
  std::sort(times.begin(), times.end());
  std::printf("| %s | %s | %.1f | %.1f | %.1f | %.1e | %.1e | ", scene.name.c_str(), engine.name(),
              quantile(times, 0.5), quantile(times, 0.999), times.back(), now.speed, late_speed);
  if (scene.is_placed) std::printf("%.1e", now.drift);
  std::printf(" | %.1e | %s%s |\n", gained, engine.remarks().c_str(),
              is_cut ? (" CUT after " + std::to_string(times.size()) + " steps").c_str() : "");
  std::fflush(stdout);
}

bool has(std::string_view text, std::string_view part) { return text.find(part) != std::string_view::npos; }

}  // namespace

int main(int argc, char** argv) {
  const std::string_view part = argc > 1 ? argv[1] : "",
                         engines = argc > 2 ? argv[2] : "own,bullet,ode,mujoco";
  const double seconds = argc > 3 ? std::atof(argv[3]) : 60.0;
  const int steps = argc > 4 ? std::atoi(argv[4]) : 0;
  std::printf(
      "| scene | engine | median [us] | 99.9 %% | most | at the end [m/s] | second half | drift [m] | "
      "gained [J] | |\n|---|---|---|---|---|---|---|---|---|---|\n");
  for (const BoxScene& scene : box_scenes()) {
    if (!has(scene.name, part)) continue;
    if (has(engines, "own")) run(scene, *make_own(scene), seconds, steps);
    if (has(engines, "bullet"))
      if (const auto engine = make_bullet(scene)) run(scene, *engine, seconds, steps);
    if (has(engines, "ode"))
      if (const auto engine = make_ode(scene)) run(scene, *engine, seconds, steps);
    if (has(engines, "mujoco"))
      if (const auto engine = make_mujoco(scene)) run(scene, *engine, seconds, steps);
  }
  return 0;
}
