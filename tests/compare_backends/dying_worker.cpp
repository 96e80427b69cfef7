#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <thread>

#include "touchstone/examples/compare_backends/run/workers/worker.hpp"
#include "touchstone/tests/measures/fake_backends.hpp"

using namespace touchstone;

namespace {

/// Answers `separated` after a while.
class Late final : public measures::testing::PairByPair {
 public:
  Late(std::string name, std::chrono::milliseconds a_call)
      : PairByPair(std::move(name), Capabilities{}), a_call_(a_call) {}

 private:
  void answer(const NarrowphaseInput&, std::size_t i, const NarrowphaseOutput& output) const override {
    if (i == 0) std::this_thread::sleep_for(a_call_);
    output.status[i] = PairStatus::separated;
  }

  std::chrono::milliseconds a_call_;
};

}  // namespace

// Offers the fakes, with --start-late 1.2 s later; dies when it is asked for "dying", and answers "hanging"
// in an hour, "slow" in 0.1 s a call; "rude" prints and leaves a child that never ends.
int main(int argc, char** argv) {
  if (argc > 1 && std::string(argv[1]) == "--start-late") {
    std::this_thread::sleep_for(std::chrono::milliseconds(1200));
    --argc, ++argv;
  }
  return comparison::worker_main(argc, argv, [](BackendRegistry& registry) {
    measures::testing::register_fakes(registry);
    const auto add = [&](std::string name, std::function<std::unique_ptr<Narrowphase>()> make) {
      registry.add(BackendRegistry::NarrowphaseEntry{std::move(name), "of these tests", std::move(make), {}});
    };
    add("dying", []() -> std::unique_ptr<Narrowphase> { std::abort(); });
    add("hanging", [] { return std::make_unique<Late>("hanging", std::chrono::hours(1)); });
    add("rude", [] {
      std::puts("a line of the engine's");
      std::fflush(stdout);
      if (fork() == 0)
        for (;;) pause();
      return std::make_unique<Late>("rude", std::chrono::milliseconds(0));
    });
    add("slow", [] { return std::make_unique<Late>("slow", std::chrono::milliseconds(100)); });
  });
}
