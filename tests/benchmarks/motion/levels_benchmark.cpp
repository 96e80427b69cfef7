#include <time.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "touchstone/contact_core/fit/levels.hpp"
#include "touchstone/contact_core/registry.hpp"
#include "touchstone/contact_core/world/contact_world.hpp"

// The cost of a frame of a mover near another object, both of 1, 9, 100 or 900 boxes: plates of 1 m that
// stand apart by 20 m, 1 m or 10 cm while the mover goes to and fro by 5 mm a frame, or touch along an edge
// on which it slides; and a plate in a tube of 0.8 m radius, where boxes and spheres about all overlap. With
// each hexahedron looked at by itself, with what objects have of themselves (spheres), and with
// coarser_levels() of 5 and 30 cm. Least of five means over this many frames (1 000; a tenth of these where
// they touch), of this thread's processor time [us].
//
//   levels_benchmark [frames]

namespace touchstone {
namespace {

using Trees = std::vector<std::shared_ptr<const HexahedronTree>>;

double processor_us() {
  timespec t;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return 1e6 * static_cast<double>(t.tv_sec) + 1e-3 * static_cast<double>(t.tv_nsec);
}

constexpr double kThickness = 0.05;  // [m]

using Tree = std::shared_ptr<const HexahedronTree>;

/// Of `side` by `side` boxes.
Tree plate(const std::string& name, int side) {
  std::vector<PlacedHexahedron> solids;
  const double step = 1.0 / side;
  for (int i = 0; i < side; ++i)
    for (int j = 0; j < side; ++j) {
      Pose X;
      X.p = {0.0, (i + 0.5) * step - 0.5, (j + 0.5) * step - 0.5};
      solids.push_back(
          {"box " + std::to_string(solids.size()), Hexahedron::from_size({kThickness, step, step}), X});
    }
  return std::make_shared<HexahedronTree>(solids, name);
}

/// About z: as many segments, in as many layers.
Tree tube(const std::string& name, int side) {
  constexpr double kRadius = 0.8;
  std::vector<PlacedHexahedron> solids;
  const double angle = 2.0 * std::numbers::pi / side, width = 2.0 * kRadius * std::tan(0.5 * angle);
  for (int i = 0; i < side; ++i)
    for (int j = 0; j < side; ++j) {
      Pose X;
      const double c = std::cos(angle * i), s = std::sin(angle * i);
      X.R << c, -s, 0, s, c, 0, 0, 0, 1;
      X.p = {kRadius * c, kRadius * s, (j + 0.5) / side - 0.5};
      solids.push_back({"box " + std::to_string(solids.size()),
                        Hexahedron::from_size({kThickness, width, 1.0 / side}), X});
    }
  return std::make_shared<HexahedronTree>(solids, name);
}

struct Setting {
  Tree other, mover;
  Pose X_other;
  bool touches = false;
  Trees other_levels, mover_levels;
};

Trees levels_of(const HexahedronTree& tree) {
  Trees out;
  for (const CoarserLevel& level : coarser_levels(tree, std::array{0.05, 0.3})) out.push_back(level.tree);
  return out;
}

Setting beside(int side, double apart, const Trees& levels) {
  Setting out{plate("other", side), plate("mover", side), {}, apart < 1e-6, levels, levels};
  // Turned, so that an edge of the one is `apart` from a face of the other.
  const double c = 0.8, s = 0.6;
  out.X_other.R << c, -s, 0, s, c, 0, 0, 0, 1;
  out.X_other.p.x() = apart + 0.5 * kThickness + 0.5 * kThickness * c + 0.5 * s;
  return out;
}

enum class Kind : std::uint8_t { one_by_one, spheres, levels };

double frame_us(const Setting& setting, Kind kind, int frames) {
  BackendRegistry registry;
  register_core(registry);
  ContactWorld world(registry.make_narrowphase("native"), registry.make_broadphase("native"), 1e-9);
  world.set_default_rule({ContactPolicy::slide});
  const auto levels = [&](const Trees& trees) { return kind == Kind::levels ? trees : Trees{}; };
  const bool is_searched = kind != Kind::one_by_one;
  world.add({setting.other, setting.X_other, false, {}, levels(setting.other_levels), is_searched});
  const ObjectHandle mover =
      world.add({setting.mover, Pose{}, false, {}, levels(setting.mover_levels), is_searched});
  const double into = setting.touches ? 1e-3 : 0.0;  // it presses
  double best = 1e9;
  for (int run = 0; run < 5; ++run) {
    const double before = processor_us();
    for (int frame = 0; frame < frames; ++frame) {
      const double sign = frame / 20 % 2 == 0 ? 1.0 : -1.0;
      const MotionCommand command = world.move_by(mover, {into, sign * 5e-3, sign * 2e-3}, {0, 0, 0});
      world.frame({&command, 1});
    }
    best = std::min(best, (processor_us() - before) / frames);
  }
  return best;
}

void print_row(int side, const std::string& place, const Setting& setting, int frames) {
  std::printf("%-12d  %10s", side * side, place.c_str());
  for (const Kind kind : {Kind::one_by_one, Kind::spheres, Kind::levels})
    std::printf("  %10.2f", frame_us(setting, kind, setting.touches ? frames / 10 : frames));
  std::printf("   %zu, %zu and %zu, %zu hexahedra\n", setting.other_levels[0]->solids().size(),
              setting.other_levels[1]->solids().size(), setting.mover_levels[0]->solids().size(),
              setting.mover_levels[1]->solids().size());
  std::fflush(stdout);
}

void run(int frames) {
  std::printf("%-12s  %10s  %10s  %10s  %10s   %s\n", "hexahedra", "apart", "one by one", "spheres", "levels",
              "which have");
  for (const int side : {1, 3, 10, 30}) {
    const Trees levels = levels_of(*plate("plate", side));
    print_row(side, "20 m", beside(side, 20.0, levels), frames);
    print_row(side, "1 m", beside(side, 1.0, levels), frames);
    print_row(side, "10 cm", beside(side, 0.1, levels), frames);
    print_row(side, "touching", beside(side, 1e-8, levels), frames);
    if (side < 3) continue;
    const Tree around = tube("tube", side);
    print_row(side, "in a tube", {around, plate("mover", side), {}, false, levels_of(*around), levels},
              frames);
  }
}

}  // namespace
}  // namespace touchstone

int main(int argc, char** argv) {
  try {
    touchstone::run(argc > 1 ? std::atoi(argv[1]) : 1000);
    return EXIT_SUCCESS;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "levels_benchmark: %s\n", error.what());
    return 2;
  }
}
