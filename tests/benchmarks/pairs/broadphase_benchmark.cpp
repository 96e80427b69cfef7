#include <benchmark/benchmark.h>

#include <cmath>

#include "touchstone/adapters/all/all_backends.hpp"
#include "touchstone/tests/benchmarks/pairs/broadphase_frame.hpp"

// Frames of a broadphase (broadphase_frame.hpp), every object moved unless a row names another share.
// Counters hold the least time of a frame and of its parts [ms].

namespace touchstone {
namespace {

void run_frames(benchmark::State& state, const std::string& name, const Mix& mix) {
  BroadphaseFrame frame(name, static_cast<int>(state.range(0)), mix);
  double least = INFINITY, least_update = INFINITY, least_find = INFINITY;
  frame.step(), frame.update(), frame.find();  // the first frame sets up and is not counted
  while (state.KeepRunning()) {
    frame.step();
    const double start = frame_seconds(mix);
    frame.update();
    const double middle = frame_seconds(mix);
    frame.find();
    const double end = frame_seconds(mix);
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
  // How time grows with objects, and with solids of an object.
  for (std::int64_t count : {1000, 2000, 5000, 10000, 20000, 50000, 100000, 200000, 500000, 1000000})
    register_run("growth/objects", "native", {}, count);
  for (int solids : {1, 2, 4, 8, 16, 32, 64})  // as far apart as the objects are long
    register_run("growth/solids/" + std::to_string(solids), "native",
                 {.spacing = 1.7 * std::cbrt(solids), .solids = solids}, 2000);
  for (std::int64_t count : {1000, 10000, 100000}) {
    // Most objects stand still, flagged or not; with overlap.
    for (double still : {0.0, 0.9, 0.99, 0.999}) {
      const std::string share = std::to_string(still).substr(0, 5);
      register_run("still/" + share, "native", {.stationary = still}, count);
      register_run("static/" + share, "native", {.stationary = still, .flagged = true}, count);
      register_run("overlap/" + share, "native", {.stationary = still, .overlap = true}, count);
      register_run("moved_overlap/" + share, "native",
                   {.stationary = still, .moved_pairs = true, .overlap = true}, count);
    }
    // Threads, paths, first contacts and crowds.
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
