// A scene without dynamics, timed: broadphase, manifolds and a frame of the contact world. Built twice, once
// with all of touchstone::physics linked in, so that the two can be compared: what is not asked for costs
// nothing.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "touchstone/contact_core/broadphase/register_broadphases.hpp"
#include "touchstone/contact_core/native/native.hpp"
#include "touchstone/contact_core/world/contact_world.hpp"

namespace touchstone {
namespace {

constexpr int kBodies = 60;
constexpr int kFrames = 2000;

std::shared_ptr<const HexahedronTree> brick(int i) {
  const std::vector<PlacedHexahedron> solids = {{"brick", Hexahedron::from_size({0.4, 0.3, 0.2}), {}}};
  return std::make_shared<HexahedronTree>(solids, "brick " + std::to_string(i));
}

/// On a grid, each pushed to and fro against its neighbours, and stopped by them.
std::vector<double> time_frames() {
  ContactWorld world(make_native(), make_native_broadphase(), 1e-9);
  world.set_default_rule({ContactPolicy::advance});
  std::vector<ObjectHandle> objects;
  for (int i = 0; i < kBodies; ++i) {
    Pose X;
    X.p = {0.42 * (i % 8), 0.32 * static_cast<double>(i / 8), 0.0};
    objects.push_back(world.add({brick(i), X}));
  }
  std::vector<double> out;
  std::vector<MotionCommand> commands(objects.size());
  for (int frame = 0; frame < kFrames; ++frame) {
    for (std::size_t i = 0; i < objects.size(); ++i) {
      const double phase = 0.1 * frame + 0.7 * static_cast<double>(i);
      commands[i] = world.move_by(objects[i], {0.004 * std::cos(phase), 0.004 * std::sin(phase), 0.0},
                                  {0.0, 0.0, 0.002 * std::cos(phase)});
    }
    const auto start = std::chrono::steady_clock::now();
    world.frame(commands);
    out.push_back(
        std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - start).count());
  }
  return out;
}

}  // namespace
}  // namespace touchstone

int main() {
  std::vector<double> best = touchstone::time_frames();
  for (int run = 1; run < 5; ++run) {
    const std::vector<double> again = touchstone::time_frames();
    for (std::size_t i = 0; i < best.size(); ++i) best[i] = std::min(best[i], again[i]);
  }
  double sum = 0.0;
  for (const double time : best) sum += time;
#ifdef TOUCHSTONE_BENCHMARK_WITH_PHYSICS
  const char* const how = "with physics   ";
#else
  const char* const how = "without physics";
#endif
  std::printf("%s: %.2f us a frame (each frame's least of 5 runs, mean of %zu frames)\n", how,
              sum / static_cast<double>(best.size()), best.size());
}
