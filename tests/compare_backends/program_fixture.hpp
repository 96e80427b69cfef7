#pragma once

#include <string>

#include "touchstone/tests/support/program_test.hpp"

namespace touchstone::test {

/// compare_backends as a user runs it, with its report in the test's folder.
class Program : public ProgramTest {
 protected:
  Program() : ProgramTest(COMPARE_BACKENDS) {}

  std::string report() const { return " --output " + (folder_ / "report").string() + " "; }
};

/// A run of a second.
inline constexpr const char* kSmall = "--count 30 --repetitions 1 --no-broadphase --families random touching";

}  // namespace touchstone::test
