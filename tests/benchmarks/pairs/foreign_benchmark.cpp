// The cost of asking from outside, in processor time (others may share the cores): a batch through the C
// interface over the same in C++, and pairs through the binary protocol to an engine that answers nothing.
//   foreign_benchmark ENGINE_C        (tests/process_engine/engine_c of the build folder)

#include <sys/resource.h>

#include <algorithm>
#include <cstdio>
#include <ctime>
#include <exception>
#include <vector>

#include "touchstone/adapters/c_interface/corners.hpp"
#include "touchstone/adapters/c_interface/layout.hpp"
#include "touchstone/adapters/process_engine/process_engine.hpp"
#include "touchstone/contact_core/native/native.hpp"
#include "touchstone/contact_core/threads/processor_time.hpp"
#include "touchstone/examples/measures/pairs/pair_families.hpp"

namespace {

using namespace touchstone;

double wall_seconds() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// Of this process and of those that it waited for.
double all_seconds(int who) {
  rusage usage{};
  getrusage(who, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

void compare_c_interface(std::size_t pairs, QueryKind kind) {
  // The same solids in both.
  const auto set = measures::make_pair_family("random", 1, pairs);
  const auto native = make_native();
  native->build(set.solids);
  const auto workspace = native->make_workspace();
  touchstone_narrowphase* over_c = nullptr;
  touchstone_workspace* scratch = nullptr;
  touchstone_create("native", &over_c);
  touchstone_build(over_c, c_interface::corners_of(set.solids).data(), set.solids.size());
  touchstone_create_workspace(over_c, &scratch);

  // The same input and output.
  std::vector<PairStatus> status(pairs);
  std::vector<PairGeometry> geometry(pairs);
  const NarrowphaseInput input{set.pairs, set.poses, {.kind = kind}, {}};
  const NarrowphaseOutput output{status, geometry, {}};
  const touchstone_input asked = c_interface::c_input(input);
  const touchstone_output slots = c_interface::c_output(output);
  const auto calls = std::max<std::size_t>(1, 100000 / pairs);
  // Time of both, in turn.
  std::vector<double> cpp, c, extra;
  for (int repeat = 0; repeat < 25; ++repeat) {  // in turn: a slower machine slows both
    const double begin = 1e-6 * processor_us();
    for (std::size_t call = 0; call < calls; ++call) native->evaluate(input, output, *workspace);
    const double middle = 1e-6 * processor_us();
    for (std::size_t call = 0; call < calls; ++call) touchstone_evaluate(over_c, scratch, &asked, &slots);
    const double end = 1e-6 * processor_us();
    const double each = 1e9 / static_cast<double>(calls * pairs);
    cpp.push_back((middle - begin) * each);
    c.push_back((end - middle) * each);
    extra.push_back(c.back() - cpp.back());
  }
  // Medians, and the least times.
  for (std::vector<double>* row : {&cpp, &c, &extra}) std::sort(row->begin(), row->end());
  std::printf("%s, %zu pairs a call: C++ %.2f, C %.2f ns a pair; C over C++ median %.2f, least times %.2f\n",
              std::string(to_string(kind)).c_str(), pairs, cpp[12], c[12], extra[12], c[0] - cpp[0]);
  touchstone_destroy_workspace(scratch);
  touchstone_destroy(over_c);
}

void measure_process(const char* engine) {
  constexpr std::size_t kPairs = 20000;
  constexpr int kCalls = 200;
  const auto set = measures::make_pair_family("random", 1, kPairs);
  BackendRegistry registry;
  register_process_engine(registry, {.command = {engine, "nothing"}});
  auto narrowphase = registry.make_narrowphase("engine_c");
  narrowphase->build(set.solids);
  std::vector<PairStatus> status(kPairs);
  const NarrowphaseInput input{set.pairs, set.poses, {}, {}};
  const double before = all_seconds(RUSAGE_SELF) + all_seconds(RUSAGE_CHILDREN);
  auto workspace = narrowphase->make_workspace();
  narrowphase->evaluate(input, {status, {}, {}}, *workspace);
  const double begin = wall_seconds();
  for (int call = 0; call < kCalls; ++call) narrowphase->evaluate(input, {status, {}, {}}, *workspace);
  const double wall = wall_seconds() - begin;
  workspace.reset();
  narrowphase.reset();  // waits for the engine, whose time then counts
  const double cpu = all_seconds(RUSAGE_SELF) + all_seconds(RUSAGE_CHILDREN) - before;
  const double asked = static_cast<double>(kPairs) * kCalls;
  std::printf("process, binary: %.2f million pairs a second; %.2f by processor time of both sides (%s)\n",
              1e-6 * asked / wall, 1e-6 * asked / cpu,
              status[0] == PairStatus::unsupported ? "answered" : "not answered");
}

}  // namespace

int main(int argc, char** argv) try {
  for (const std::size_t pairs : {1024u, 16384u})
    for (const QueryKind kind : {QueryKind::overlap, QueryKind::distance}) compare_c_interface(pairs, kind);
  if (argc > 1) measure_process(argv[1]);
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "foreign_benchmark: %s\n", error.what());
  return 1;
}
