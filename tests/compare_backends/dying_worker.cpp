#include <cstdlib>

#include "touchstone/examples/compare_backends/run/workers/worker.hpp"
#include "touchstone/tests/measures/fake_backends.hpp"

// Offers the fakes; dies in `failing`'s place when it is asked for "dying".
int main(int argc, char** argv) {
  using namespace touchstone;
  return comparison::worker_main(argc, argv, [](BackendRegistry& registry) {
    comparison::testing::register_fakes(registry);
    registry.add(BackendRegistry::NarrowphaseEntry{
        "dying", "ends its process", []() -> std::unique_ptr<Narrowphase> { std::abort(); }, {}});
  });
}
