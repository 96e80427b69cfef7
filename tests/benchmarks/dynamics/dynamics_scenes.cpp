#include "touchstone/tests/benchmarks/dynamics/dynamics_scenes.hpp"

#include <random>

namespace touchstone::benchmarks {
namespace {

using Kind = SceneBox::Kind;

constexpr double kSide = 0.2, kDisplayStep = 1.0 / 240.0;

SceneBox cube(const Vector3& p_W, double side = kSide) {
  SceneBox box;
  box.p_W = p_W;
  box.size = {side, side, side};
  return box;
}

SceneBox slab(const Vector3& size, const Vector3& p_W) {
  SceneBox box;
  box.kind = Kind::fixed;
  box.size = size, box.p_W = p_W;
  return box;
}

SceneBox driven(const Vector3& size, const Vector3& p_W, const Vector3& v_W) {
  SceneBox box = slab(size, p_W);
  box.kind = Kind::driven;
  box.v_W = v_W;
  return box;
}

BoxScene on_ground(std::string name, double step, double seconds) {
  BoxScene scene;
  scene.name = std::move(name);
  scene.step = step, scene.seconds = seconds;
  scene.boxes.push_back(slab({60, 60, 1}, {0, 0, -0.5}));
  return scene;
}

/// Free of the ground: what holds the cube are the jaws alone.
BoxScene jaws() {
  BoxScene scene = on_ground("jaws squeeze a cube", 1e-3, 1.0);
  scene.boxes.push_back(driven({kSide, kSide, kSide}, {-0.201, 0, 1}, {0.05, 0, 0}));
  scene.boxes.push_back(driven({kSide, kSide, kSide}, {0.201, 0, 1}, {-0.05, 0, 0}));
  scene.boxes.push_back(cube({0, 0, 1}));
  return scene;
}

BoxScene pusher() {
  BoxScene scene = on_ground("pusher against a wall", 1e-3, 1.0);
  scene.boxes.push_back(slab({0.2, 1, 1}, {0.25, 0, 0.5}));
  scene.boxes.push_back(driven({kSide, kSide, kSide}, {-0.21, 0, 0.1}, {0.1, 0, 0}));
  scene.boxes.push_back(cube({0, 0, 0.1}));
  return scene;
}

BoxScene deep_pair() {
  BoxScene scene = on_ground("two cubes 19 cm deep", 1e-3, 1.0);
  scene.boxes.push_back(cube({0, 0, 0.1}));
  scene.boxes.push_back(cube({0.01, 0, 0.1}));
  return scene;
}

void add_bin(BoxScene& scene, double room, double height) {
  for (const double side : {-1.0, 1.0}) {
    scene.boxes.push_back(slab({0.2, room + 0.4, height}, {side * (0.5 * room + 0.1), 0, 0.5 * height}));
    scene.boxes.push_back(slab({room + 0.4, 0.2, height}, {0, side * (0.5 * room + 0.1), 0.5 * height}));
  }
}

/// Turned anyhow, `across` by `across` a layer.
void add_loose(BoxScene& scene, int count, int across, unsigned seed = 7) {
  std::mt19937 random(seed);
  const auto draw = [&] { return 2.0 * static_cast<double>(random()) / 4294967296.0 - 1.0; };
  for (int i = 0; i < count; ++i) {
    const int x = i % across, y = i / across % across, z = i / (across * across);
    const double middle = 0.5 * (across - 1);
    SceneBox box = cube({0.36 * (x - middle), 0.36 * (y - middle), 0.3 + 0.36 * z});
    box.turn_W = {draw(), draw(), draw()};
    scene.boxes.push_back(box);
  }
}

constexpr unsigned kDraws = 16, kPileDraws = 6;

/// Which way they tumble, and so when they rest, depends on the last bit: one draw proves little.
BoxScene bin(unsigned draw = 0) {
  BoxScene scene = on_ground("4 boxes dropped in a bin", 1e-3, 3.0);
  if (draw > 0) scene.name += ", draw " + std::to_string(draw);
  add_bin(scene, 0.5, 2.0);
  add_loose(scene, 4, 1, draw > 0 ? draw : 7);
  return scene;
}

BoxScene pile(int count, int across, double seconds, unsigned draw = 0) {
  BoxScene scene = on_ground("pile of " + std::to_string(count), kDisplayStep, seconds);
  if (draw > 0) scene.name += ", draw " + std::to_string(draw);
  add_bin(scene, 0.36 * across + 0.2, 4.0);
  add_loose(scene, count, across, draw > 0 ? 100 + draw : 7);
  return scene;
}

BoxScene stack(int count, double step) {
  BoxScene scene =
      on_ground("stack of " + std::to_string(count) + (step == kDisplayStep ? " at 240 Hz" : ""), step, 10.0);
  for (int i = 0; i < count; ++i) scene.boxes.push_back(cube({0, 0, kSide * (0.5 + i)}));
  scene.is_placed = true;
  return scene;
}

BoxScene pyramid(int rows, double step) {
  BoxScene scene =
      on_ground("pyramid of " + std::to_string(rows) + " rows" + (step == kDisplayStep ? " at 240 Hz" : ""),
                step, 10.0);
  for (int row = 0; row < rows; ++row)
    for (int i = 0; i < rows - row; ++i)
      scene.boxes.push_back(cube({kSide * 1.05 * (i - 0.5 * (rows - row - 1)), 0, kSide * (0.5 + row)}));
  scene.is_placed = true;
  return scene;
}

/// @param name before its number of cubes. @param shift of every second row, by sides
BoxScene wall(const std::string& name, int rows, int columns, double shift, double step) {
  BoxScene scene = on_ground(
      name + std::to_string(rows * columns) + (step == kDisplayStep ? " at 240 Hz" : ""), step, 10.0);
  for (int row = 0; row < rows; ++row)
    for (int i = 0; i < columns; ++i)
      scene.boxes.push_back(cube({kSide * (i + (row % 2 == 1 ? shift : 0.0)), 0, kSide * (0.5 + row)}));
  scene.is_placed = true;
  return scene;
}

/// Bricks on gaps: each second row has one less, on the joints of the row below.
BoxScene brick_wall(int rows, int columns, double step) {
  BoxScene scene = on_ground("", step, 10.0);
  for (int row = 0; row < rows; ++row)
    for (int i = 0; i < columns - row % 2; ++i)
      scene.boxes.push_back(cube({kSide * (i + 0.5 * (row % 2)), 0, kSide * (0.5 + row)}));
  scene.name =
      "brick wall of " + std::to_string(scene.boxes.size() - 1) + (step == kDisplayStep ? " at 240 Hz" : "");
  scene.is_placed = true;
  return scene;
}

/// A thousand cubes apart, at rest or sliding.
BoxScene field(bool slides, bool sleeps) {
  BoxScene scene = on_ground(slides   ? "1 000 sliding apart"
                             : sleeps ? "1 000 asleep"
                                      : "1 000 at rest",
                             1.0 / 60.0, slides ? 1.0 : 5.0);
  for (int i = 0; i < 1000; ++i) {
    SceneBox box = cube({0.8 * (i % 32) - 12.8, 0.8 * (i / 32) - 12.8, 0.5 * kSide});
    if (slides) box.v_W = {0.5 + 0.002 * i, 0.3, 0};
    scene.boxes.push_back(box);
  }
  scene.sleeps = sleeps;
  scene.is_placed = !slides;
  return scene;
}

BoxScene spawned_deep() {
  BoxScene scene = on_ground("cubes spawned 1 to 10 cm deep", 1e-3, 3.0);
  for (int i = 0; i < 10; ++i) scene.boxes.push_back(cube({0.5 * i - 2.5, 0, 0.5 * kSide - 0.01 * (i + 1)}));
  return scene;
}

BoxScene in_one_spot() {
  BoxScene scene = on_ground("12 cubes in one spot", 1e-3, 3.0);
  for (int i = 0; i < 12; ++i) {
    SceneBox box = cube({1e-3 * (i % 3), 1e-3 * (i / 3 % 2), 0.5 + 1e-3 * (i / 6)});
    box.turn_W = {0, 0, 0.01 * i};
    scene.boxes.push_back(box);
  }
  return scene;
}

BoxScene sleeping_pile() {
  BoxScene scene = pile(100, 5, 8.0);
  scene.name += ", may sleep";
  scene.sleeps = true;
  return scene;
}

// Scenes of other sizes, places and seeds than those that are reported: constants are chosen on these.

BoxScene other_squeeze(bool has_wall) {
  BoxScene scene = on_ground(has_wall ? "other: pusher" : "other: jaws", 1e-3, 1.5);
  const double side = 0.35, z = has_wall ? 0.5 * side : 1.0;
  if (has_wall)
    scene.boxes.push_back(slab({0.2, 2, 2}, {0.5 * side + 0.1 + 0.07, 0, 1}));
  else
    scene.boxes.push_back(driven({side, side, side}, {side + 0.003, -0.05, z + 0.02}, {-0.12, 0, 0}));
  scene.boxes.push_back(driven({side, side, side}, {-side - 0.002, 0.03, z}, {has_wall ? 0.25 : 0.12, 0, 0}));
  scene.boxes.push_back(cube({0, 0, z}, side));
  return scene;
}

BoxScene other_deep() {
  BoxScene scene = on_ground("other: three cubes deep", 1e-3, 1.5);
  for (int i = 0; i < 3; ++i) scene.boxes.push_back(cube({0.08 * i, 0.05 * (i % 2), 0.15 + 0.02 * i}, 0.3));
  return scene;
}

BoxScene other_loose(int count, int across, double room, unsigned seed, double step, double seconds) {
  BoxScene scene = on_ground("other: " + std::to_string(count) + " loose", step, seconds);
  add_bin(scene, room, 4.0);
  add_loose(scene, count, across, seed);
  return scene;
}

BoxScene other_stack(int count, double side, double step) {
  BoxScene scene = on_ground(
      "other: stack of " + std::to_string(count) + (step == kDisplayStep ? " at 240 Hz" : ""), step, 4.0);
  for (int i = 0; i < count; ++i)
    scene.boxes.push_back(cube({0.1 * side * (i % 3 - 1), 0.05 * side * (i % 2), side * (0.5 + i)}, side));
  scene.is_placed = true;
  return scene;
}

BoxScene other_pyramid(int rows, double side, double step) {
  BoxScene scene = on_ground(
      "other: pyramid of " + std::to_string(rows) + " rows" + (step == kDisplayStep ? " at 240 Hz" : ""),
      step, 4.0);
  for (int row = 0; row < rows; ++row)
    for (int i = 0; i < rows - row; ++i)
      scene.boxes.push_back(cube({side * 1.1 * (i - 0.5 * (rows - row - 1)), 0, side * (0.5 + row)}, side));
  scene.is_placed = true;
  return scene;
}

BoxScene other_spot() {
  BoxScene scene = on_ground("other: 7 cubes in one spot", 1e-3, 3.0);
  for (int i = 0; i < 7; ++i) {
    SceneBox box = cube({4e-3 * (i % 2), 3e-3 * (i / 2 % 2), 0.4 + 5e-3 * (i / 4)}, 0.3);
    box.turn_W = {0.02 * i, -0.01 * i, 0.03 * i};
    scene.boxes.push_back(box);
  }
  return scene;
}

// Scenes that are drawn, for reports: sizes, places, speeds, frictions and masses of which nothing was
// chosen.

constexpr unsigned kDrawnScenes = 8;

class Draw {
 public:
  explicit Draw(unsigned seed) : random_(seed) {}
  double operator()(double low, double high) {
    return low + (high - low) * static_cast<double>(random_()) / 4294967296.0;
  }
  int whole(int low, int high) {
    return low + static_cast<int>(random_() % static_cast<unsigned>(high - low + 1));
  }

 private:
  std::mt19937 random_;
};

BoxScene drawn_scene(const char* what, unsigned number, double seconds, Draw& draw) {
  BoxScene scene = on_ground("drawn: " + std::string(what) + " " + std::to_string(number),
                             draw(0, 1) < 0.7 ? 1e-3 : 1.0 / 240, seconds);
  scene.friction = draw(0.1, 1.0);
  return scene;
}

BoxScene drawn_squeeze(bool has_wall, unsigned seed, unsigned number) {
  Draw draw(seed + 100 * (has_wall ? 1 : 0) + number);
  BoxScene scene = drawn_scene(has_wall ? "pusher" : "jaws", number, 2.0, draw);
  const double side = draw(0.08, 0.5), speed = draw(0.02, 0.3), gap = draw(1e-4, 3e-3), aside = 0.3 * side;
  const double z = has_wall ? 0.5 * side : 2.0;
  if (has_wall)
    scene.boxes.push_back(slab({0.2, 3, 3}, {0.5 * side + 0.1 + draw(0.001, 0.2), 0, 1.5}));
  else
    scene.boxes.push_back(driven({side, side, side},
                                 {side + gap, draw(-aside, aside), z + draw(-aside, aside)}, {-speed, 0, 0}));
  scene.boxes.push_back(driven({side, side, side},
                               {-side - gap, draw(-aside, aside), has_wall ? z : z + draw(-aside, aside)},
                               {speed, 0, 0}));
  scene.boxes.push_back(cube({0, 0, z}, side));
  scene.boxes.back().mass = draw(0.5, 20.0);
  return scene;
}

BoxScene drawn_overlap(bool is_spot, unsigned seed, unsigned number) {
  Draw draw(seed + (is_spot ? 300 : 200) + number);
  BoxScene scene = drawn_scene(is_spot ? "spot" : "deep", number, 3.0, draw);
  const double side = draw(0.1, 0.4), spread = is_spot ? 0.1 * side : 0.6 * side;
  const int count = is_spot ? draw.whole(5, 14) : draw.whole(2, 3);
  for (int i = 0; i < count; ++i) {
    SceneBox box = cube(
        {draw(-spread, spread), draw(-spread, spread), (is_spot ? 1.0 : 0.5) * side + draw(0.0, 0.1) * side},
        side);
    if (is_spot || number % 2 == 1) box.turn_W = {draw(-0.1, 0.1), draw(-0.1, 0.1), draw(-0.3, 0.3)};
    scene.boxes.push_back(box);
  }
  return scene;
}

BoxScene drawn_bin(unsigned seed, unsigned number) {
  Draw draw(seed + 400 + number);
  BoxScene scene = drawn_scene("bin", number, 3.0, draw);
  const int count = draw.whole(3, 9);
  add_bin(scene, draw(0.42, 0.7), 4.0);
  add_loose(scene, count, 1, seed + 500 + number);
  return scene;
}

void add_drawn(std::vector<BoxScene>& all, unsigned seed) {
  for (unsigned i = 1; i <= kDrawnScenes; ++i) all.push_back(drawn_squeeze(false, seed, i));
  for (unsigned i = 1; i <= kDrawnScenes; ++i) all.push_back(drawn_squeeze(true, seed, i));
  for (unsigned i = 1; i <= kDrawnScenes; ++i) all.push_back(drawn_overlap(false, seed, i));
  for (unsigned i = 1; i <= kDrawnScenes; ++i) all.push_back(drawn_overlap(true, seed, i));
  for (unsigned i = 1; i <= kDrawnScenes; ++i) all.push_back(drawn_bin(seed, i));
}

BoxScene strange_scene(const char* what, unsigned number, double seconds, Draw& draw) {
  BoxScene scene = drawn_scene(what, number, seconds, draw);
  scene.name = "strange: " + std::string(what) + " " + std::to_string(number);
  return scene;
}

/// Jaws of which one turns while it squeezes.
BoxScene turning_jaws(unsigned seed, unsigned number) {
  Draw draw(seed + number);
  BoxScene scene = strange_scene("jaw that turns", number, 2.0, draw);
  const double side = draw(0.1, 0.4), speed = draw(0.02, 0.1), aside = 0.2 * side, z = 2.0;
  for (const double sign : {-1.0, 1.0}) {
    scene.boxes.push_back(driven({side, side, side},
                                 {sign * (side + 1e-3), draw(-aside, aside), z + draw(-aside, aside)},
                                 {-sign * speed, 0, 0}));
    if (sign > 0.0) scene.boxes.back().w_W = {draw(-0.3, 0.3), draw(-0.3, 0.3), draw(-0.3, 0.3)};
  }
  scene.boxes.push_back(cube({0, 0, z}, side));
  scene.boxes.back().mass = draw(0.5, 20.0);
  return scene;
}

/// A gripper of four fingers that closes on a cube and lifts it.
BoxScene four_fingers(unsigned seed, unsigned number) {
  Draw draw(seed + 100 + number);
  BoxScene scene = strange_scene("four fingers", number, 2.0, draw);
  const double side = draw(0.1, 0.4), closing = draw(1e-3, 5e-3), lift = draw(0.0, 0.2);
  for (int i = 0; i < 4; ++i) {
    const double sign = i % 2 == 0 ? -1.0 : 1.0, at = sign * (0.75 * side + 1e-4);
    const double aside = draw(-0.2, 0.2) * side;
    const Vector3 p = i < 2 ? Vector3(at, aside, 0.6 * side) : Vector3(aside, at, 0.6 * side);
    const Vector3 v = i < 2 ? Vector3(-sign * closing, 0, lift) : Vector3(0, -sign * closing, lift);
    scene.boxes.push_back(driven({0.5 * side, 0.5 * side, side}, p, v));
  }
  scene.boxes.push_back(cube({0, 0, 0.5 * side}, side));
  scene.boxes.back().mass = draw(0.5, 20.0);
  return scene;
}

/// A wedge, which is a slab that leans, driven under a stack that a wall holds.
BoxScene wedge(unsigned seed, unsigned number) {
  Draw draw(seed + 200 + number);
  BoxScene scene = strange_scene("wedge", number, 2.0, draw);
  const double side = draw(0.1, 0.4), slope = draw(0.02, 0.3), speed = draw(0.02, 0.2), length = 6.0 * side;
  const int count = draw.whole(1, 4);
  scene.boxes.push_back(slab({0.2, 4, 8.0 * side}, {0.5 * side + 0.1, 0, 4.0 * side}));
  // The upper edge of its front end lies on the ground, before the stack.
  const double s = slope - slope * slope * slope / 6.0, c = 1.0 - 0.5 * slope * slope;
  const Vector3 edge = {0.5 * length * c + 0.05 * side * s, 0, 0.05 * side * c - 0.5 * length * s};
  scene.boxes.push_back(driven({length, 2.0 * side, 0.1 * side},
                               {-0.52 * side - edge.x(), 0, 1e-3 * side - edge.z()}, {speed, 0, 0}));
  scene.boxes.back().turn_W = {0, slope, 0};
  for (int i = 0; i < count; ++i) scene.boxes.push_back(cube({0, 0, side * (0.5 + i)}, side));
  return scene;
}

/// A cube of a gram between two of a kilogram that kilonewtons press together, on the ground.
BoxScene strong_jaws(unsigned seed, unsigned number) {
  Draw draw(seed + 300 + number);
  BoxScene scene = strange_scene("gram in strong jaws", number, 1.0, draw);
  const double side = draw(0.05, 0.2), force = draw(500.0, 2000.0);
  for (const double sign : {-1.0, 1.0}) {
    scene.boxes.push_back(cube({sign * (side + 1e-4), 0, 0.5 * side}, side));
    scene.boxes.back().force_W = {-sign * force, 0, 0};
  }
  scene.boxes.push_back(cube({0, 0, 0.5 * side}, side));
  scene.boxes.back().mass = 1e-3;
  return scene;
}

void add_strange(std::vector<BoxScene>& all, unsigned seed) {
  constexpr unsigned kStrangeScenes = 4;
  for (const auto make : {turning_jaws, four_fingers, wedge, strong_jaws})
    for (unsigned i = 1; i <= kStrangeScenes; ++i) all.push_back(make(seed + 1000, i));
}

/// What is to stay where it stands, of every size that is asked for.
void add_resting(std::vector<BoxScene>& all) {
  const std::size_t first = all.size();
  for (const double step : {1e-3, kDisplayStep}) {
    for (const int count : {2, 3, 5, 8, 10, 16, 17, 20, 30, 40, 50}) all.push_back(stack(count, step));
    for (int rows = 4; rows <= 10; ++rows) all.push_back(pyramid(rows, step));
    for (const int side : {4, 5, 6, 7, 8}) all.push_back(wall("wall of ", side, side, 0.25, step));
    for (const double shift : {0.0, 0.4})
      all.push_back(wall("wall, shifted by " + std::to_string(static_cast<int>(100 * shift)) + " %, of ", 8,
                         8, shift, step));
    for (const int rows : {4, 8}) all.push_back(brick_wall(rows, rows, step));
  }
  for (std::size_t i = first; i < all.size(); ++i) all[i].name = "rest: " + all[i].name;
}

void add_others(std::vector<BoxScene>& all) {
  all.push_back(other_squeeze(false));
  all.push_back(other_squeeze(true));
  all.push_back(other_deep());
  all.push_back(other_loose(6, 1, 0.6, 11, 1e-3, 3.0));
  all.push_back(other_loose(60, 4, 1.9, 13, kDisplayStep, 8.0));
  for (const double step : {1e-3, kDisplayStep}) {
    all.push_back(other_stack(13, 0.3, step));
    all.push_back(other_stack(27, 0.15, step));
    all.push_back(other_stack(38, 0.25, step));
    all.push_back(other_pyramid(7, 0.3, step));
    all.push_back(other_pyramid(12, 0.15, step));
    all.push_back(wall("other: wall of ", 5, 8, 0.25, step));
    all.push_back(wall("other: wall of ", 7, 7, 0.5, step));
    all.push_back(wall("other: wall of ", 9, 9, 0.25, step));
    all.push_back(wall("other: wall of ", 12, 6, 0.4, step));
  }
  all.push_back(other_spot());
}

}  // namespace

std::vector<BoxScene> box_scenes(unsigned drawn_seed) {
  std::vector<BoxScene> all{jaws(), pusher(), deep_pair(), bin()};
  for (unsigned draw = 1; draw <= kDraws; ++draw) all.push_back(bin(draw));
  for (const double step : {1e-3, kDisplayStep})
    for (const int count : {2, 5, 10, 16, 17, 20, 50}) all.push_back(stack(count, step));
  for (const double step : {1e-3, kDisplayStep})
    for (const int rows : {5, 10}) all.push_back(pyramid(rows, step));
  for (const double step : {1e-3, kDisplayStep}) all.push_back(wall("wall of ", 8, 8, 0.25, step));
  all.push_back(pile(100, 5, 8.0));
  for (unsigned draw = 1; draw <= kPileDraws; ++draw) all.push_back(pile(100, 5, 8.0, draw));
  all.push_back(sleeping_pile());
  all.push_back(pile(300, 7, 6.0));
  all.push_back(pile(1000, 10, 3.0));
  all.push_back(field(true, false));
  all.push_back(field(false, false));
  all.push_back(field(false, true));
  all.push_back(spawned_deep());
  all.push_back(in_one_spot());
  add_others(all);
  add_drawn(all, drawn_seed);
  add_strange(all, drawn_seed);
  add_resting(all);
  return all;
}

}  // namespace touchstone::benchmarks
