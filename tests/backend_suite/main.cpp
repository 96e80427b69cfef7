#include <gmock/gmock.h>

#include "touchstone/tests/backend_suite/suite.hpp"

// Tests register themselves when their object file is linked: naming one function of each brings them out of
// the library.

int main(int argc, char** argv) {
  testing::InitGoogleMock(&argc, argv);
  touchstone::suite::link_narrowphase_suite();
  touchstone::suite::link_bad_pose_suite();
  touchstone::suite::link_manifold_suite();
  touchstone::suite::link_broadphase_suite();
#ifdef TOUCHSTONE_HAS_EXACT
  touchstone::suite::link_accuracy_suite();
#endif
  return RUN_ALL_TESTS();
}
