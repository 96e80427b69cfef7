#include "touchstone/adapters/bullet/bullet_single.hpp"
#include "touchstone/examples/compare_backends/run/workers/worker.hpp"

int main(int argc, char** argv) {
  return touchstone::comparison::worker_main(argc, argv, touchstone::register_bullet_single);
}
