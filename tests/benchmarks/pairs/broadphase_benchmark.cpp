#include <benchmark/benchmark.h>
#include <time.h>

#include <array>
#include <cmath>
#include <random>

#include "touchstone/adapters/all/all_backends.hpp"
#include "touchstone/contact_core/broadphase/first_contact.hpp"
#include "touchstone/contact_core/registry.hpp"
#include "touchstone/contact_core/threads/thread_team.hpp"

// One frame of a broadphase: update(), with every object moved unless a row says else, then all of
// find_pairs(). Counters hold the least time of a frame and of its parts [ms].

namespace touchstone {
namespace {

struct Mix {
  double spacing = 1.7;     // [m]; 1.7 gives a box about five candidate partners
  double decades = 0.0;     // sizes are scaled by 10^0 down to 10^-decades
  double stationary = 0.0;  // share of objects that never move
  bool flagged = false;     // they are built as static
  int solids = 1;           // an object, side by side
  int threads = 1;
  bool swept = false;          // paths from each frame's poses to the next's
  bool first_contact = false;  // the lowest contact only, by the native narrowphase
  bool moved_pairs = false;    // those of what moved only
  bool overlap = false;        // and whether they overlap, by the native narrowphase
};

// Boxes with sides of 0.5 to 1.5 m.
struct MovingBoxes {
  std::vector<HexahedronTree> trees;
  std::vector<const HexahedronTree*> pointers;
  std::vector<Pose> poses;
  std::vector<Vector3> velocities;  // one an object, like moved
  std::vector<std::uint32_t> moved;
  std::vector<std::uint8_t> is_static;
  int solids;
  int frame = 0;

  MovingBoxes(int count, const Mix& mix) {
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> side(0.5, 1.5);
    std::uniform_real_distribution<double> place(-0.5, 0.5);
    std::normal_distribution<double> normal;
    const double extent = mix.spacing * std::cbrt(count);
    for (int i = 0; i < count; ++i) {
      const double scale = std::pow(10.0, -mix.decades * (place(random) + 0.5));
      const double x = scale * side(random), y = scale * side(random), z = scale * side(random);
      std::vector<PlacedHexahedron> placed;
      for (int part = 0; part < mix.solids; ++part)
        placed.push_back({"", Hexahedron::from_size({x, y, z}), {Matrix3::Identity(), {part * x, 0, 0}}});
      trees.emplace_back(std::move(placed));
      Pose X;
      X.R = rotation_from_quaternion(normal(random), normal(random), normal(random), normal(random));
      X.p = extent * Vector3(place(random), place(random), place(random));
      poses.resize(poses.size() + mix.solids);
      find_global_positions(trees.back(), X, std::span(poses).last(mix.solids));
      const bool moves = place(random) + 0.5 >= mix.stationary;
      if (moves) moved.push_back(static_cast<std::uint32_t>(i));
      if (mix.flagged) is_static.push_back(moves ? 0 : 1);
      velocities.push_back(0.02 * Vector3(place(random), place(random), place(random)));
    }
    solids = mix.solids;
    for (const HexahedronTree& tree : trees) pointers.push_back(&tree);
  }

  // To and fro, so that the density stays however many frames are run.
  void step() {
    const double sign = frame++ / 16 % 2 == 0 ? 1.0 : -1.0;
    for (std::uint32_t object : moved)
      for (int part = 0; part < solids; ++part) poses[object * solids + part].p += sign * velocities[object];
  }
};

// This thread's, so that other work on the machine counts little; of several threads, the wall's.
double seconds(const Mix& mix) {
  timespec t;
  clock_gettime(mix.threads > 1 ? CLOCK_MONOTONIC : CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

// The caller's side of a frame.
struct Frame {
  MovingBoxes boxes;
  Mix mix;
  ThreadTeam team;
  std::unique_ptr<Broadphase> broadphase;
  std::unique_ptr<Narrowphase> narrowphase;
  std::unique_ptr<Narrowphase::Workspace> workspace;
  std::vector<Pose> before;
  std::array<SolidPair, 4096> block;
  std::array<PairStatus, 4096> status;
  std::size_t pairs = 0;
  std::vector<SolidPair> moved_pairs;

  Frame(const std::string& name, int count, const Mix& wanted)
      : boxes(count, wanted), mix(wanted), team(static_cast<std::size_t>(wanted.threads)) {
    BackendRegistry registry;
    register_all_backends(registry);
    broadphase = registry.make_broadphase(name);
    broadphase->build({boxes.pointers, 0.0, boxes.is_static, mix.threads > 1 ? &team : nullptr});
    narrowphase = registry.make_narrowphase("native");
    if (!mix.first_contact && !mix.overlap) return;
    std::vector<Hexahedron> solids;
    for (const HexahedronTree& tree : boxes.trees)
      for (const PlacedHexahedron& placed : tree.solids()) solids.push_back(placed.solid);
    narrowphase->build(solids);
    workspace = narrowphase->make_workspace();
  }

  void step() {
    if (mix.swept) before = boxes.poses;
    boxes.step();
  }

  void update() {
    if (mix.swept)
      broadphase->update_paths({before, boxes.poses}, boxes.moved);
    else
      broadphase->update(boxes.poses, boxes.moved);
  }

  void find() {
    pairs = 0;
    if (mix.first_contact)
      pairs = find_first_contact(*broadphase, *narrowphase, boxes.poses, *workspace, block, status) ? 1 : 0;
    else if (mix.moved_pairs)
      find_moved();
    else
      for (PairCursor cursor; !cursor.done;) {
        const std::size_t count = broadphase->find_pairs(cursor, block);
        check(std::span(block).first(count));
        pairs += count;
      }
  }

  void find_moved() {
    moved_pairs.clear();
    broadphase->find_moved_pairs(moved_pairs);
    for (std::size_t first = 0; first < moved_pairs.size(); first += block.size())
      check(std::span(moved_pairs).subspan(first, std::min(block.size(), moved_pairs.size() - first)));
    pairs = moved_pairs.size();
  }

  void check(std::span<const SolidPair> some) {
    if (!mix.overlap) return;
    Query query;
    query.kind = QueryKind::overlap;
    narrowphase->evaluate({some, boxes.poses, query}, {status, {}, {}}, *workspace);
  }
};

void run_frames(benchmark::State& state, const std::string& name, const Mix& mix) {
  Frame frame(name, static_cast<int>(state.range(0)), mix);
  double least = INFINITY, least_update = INFINITY, least_find = INFINITY;
  frame.step(), frame.update(), frame.find();  // the first frame sets up and is not counted
  while (state.KeepRunning()) {
    frame.step();
    const double start = seconds(mix);
    frame.update();
    const double middle = seconds(mix);
    frame.find();
    const double end = seconds(mix);
    least = std::min(least, end - start);
    least_update = std::min(least_update, middle - start);
    least_find = std::min(least_find, end - middle);
    benchmark::DoNotOptimize(frame.pairs);
  }
  state.counters["min_ms"] = 1e3 * least;
  state.counters["update_min_ms"] = 1e3 * least_update;
  state.counters["find_min_ms"] = 1e3 * least_find;
  state.counters["partners"] =
      2.0 * static_cast<double>(frame.pairs) / static_cast<double>(frame.boxes.poses.size());
}

void register_run(const std::string& name, const std::string& backend, const Mix& mix, std::int64_t count) {
  benchmark::RegisterBenchmark(name.c_str(),
                               [backend, mix](benchmark::State& state) { run_frames(state, backend, mix); })
      ->Arg(count)
      ->Unit(benchmark::kMillisecond);
}

// Features of `native` alone, and how their cost grows: rows to plot.
void register_native_runs() {
  for (std::int64_t count : {1000, 2000, 5000, 10000, 20000, 50000, 100000, 200000, 500000, 1000000})
    register_run("growth/objects", "native", {}, count);
  for (int solids : {1, 2, 4, 8, 16, 32, 64})  // as far apart as the objects are long
    register_run("growth/solids/" + std::to_string(solids), "native",
                 {.spacing = 1.7 * std::cbrt(solids), .solids = solids}, 2000);
  for (std::int64_t count : {1000, 10000, 100000}) {
    for (double still : {0.0, 0.9, 0.99, 0.999}) {
      const std::string share = std::to_string(still).substr(0, 5);
      register_run("still/" + share, "native", {.stationary = still}, count);
      register_run("static/" + share, "native", {.stationary = still, .flagged = true}, count);
      register_run("overlap/" + share, "native", {.stationary = still, .overlap = true}, count);
      register_run("moved_overlap/" + share, "native",
                   {.stationary = still, .moved_pairs = true, .overlap = true}, count);
    }
    for (int threads : {1, 2})
      for (double spacing : {1.1, 1.7, 3.4})
        register_run(
            "threads/" + std::to_string(threads) + "/spacing_" + std::to_string(spacing).substr(0, 3),
            "native", {.spacing = spacing, .threads = threads}, count);
    register_run("swept", "native", {.swept = true}, count);
    for (double spacing : {1.7, 3.4, 20.0, 200.0})
      for (bool first_contact : {false, true})
        register_run((first_contact ? "first_contact/" : "full_list/") + std::to_string(spacing).substr(0, 5),
                     "native", {.spacing = spacing, .first_contact = first_contact}, count);
    for (double spacing : {1.1, 0.9, 0.8, 0.7, 0.6, 0.5})
      register_run("crowded/" + std::to_string(spacing).substr(0, 3), "native", {.spacing = spacing}, count);
  }
}

void register_runs(const std::string& backend, std::int64_t largest) {
  register_run(backend + "/heap", backend, {.spacing = 0.02}, 4000);  // all overlap all
  const std::pair<const char*, Mix> mixes[] = {{"even", {}},
                                               {"sparse", {.spacing = 3.4}},
                                               {"dense", {.spacing = 1.1}},
                                               {"two_decades", {.spacing = 1.1, .decades = 2.0}},
                                               {"nine_tenths_static", {.stationary = 0.9}},
                                               {"four_solids", {.spacing = 3.4, .solids = 4}}};
  for (const auto& [label, mix] : mixes)
    for (std::int64_t count = 1000; count <= largest; count *= 10)
      register_run(backend + "/" + label, backend, mix, count);
}

}  // namespace
}  // namespace touchstone

int main(int argc, char** argv) {
  touchstone::register_runs("native", 1000000);
  touchstone::register_native_runs();
  for (const auto& [engine, largest] : {std::pair{"bullet", 1000000}, {"ode", 100000}})
    if (touchstone::has_backend(engine)) touchstone::register_runs(engine, largest);
  touchstone::register_runs("brute_force", 1000);
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  benchmark::RunSpecifiedBenchmarks();
}
