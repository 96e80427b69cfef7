// The program as a user runs it.

#include <gmock/gmock.h>

#include "touchstone/tests/support/program_test.hpp"

namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

class EngineCheck : public touchstone::ProgramTest {
 protected:
  EngineCheck() : ProgramTest(ENGINE_CHECK) {}
};

TEST_F(EngineCheck, AnInterruptLeavesALogThatSaysItIsPartial) {
  const std::filesystem::path log = folder_ / "log";
  for (const int signal : {SIGINT, SIGTERM}) {
    const auto [outcome, seconds] =
        run_until("1000 --log " + log.string(), std::chrono::milliseconds(500), signal);
    EXPECT_EQ(outcome.code, 128 + signal) << outcome.err;
    EXPECT_LT(seconds, 1.0);
    EXPECT_THAT(read(log), StartsWith("partial: interrupted"));
    EXPECT_THAT(outcome.err, HasSubstr("engine_check: interrupted: "));
    EXPECT_THAT(outcome.err, HasSubstr(log.string()));
    std::filesystem::remove(log);
  }
}

TEST_F(EngineCheck, AnInterruptWritesNoLogThatNobodyAskedFor) {
  const auto [outcome, seconds] = run_until("1000", std::chrono::milliseconds(500), SIGINT);
  EXPECT_EQ(outcome.code, 130);
  EXPECT_THAT(outcome.err, HasSubstr("the others were not measured"));
  EXPECT_THAT(outcome.err, Not(HasSubstr("so far:")));
}

}  // namespace
