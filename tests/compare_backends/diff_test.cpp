#include "examples/compare_backends/diff.hpp"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "contact_core/input_error.hpp"
#include "examples/compare_backends/json_writer.hpp"

namespace touchstone::comparison {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

Timing times(double around, std::size_t repetitions) {
  Timing timing;
  timing.median_ns = around;
  timing.repetitions = repetitions;
  for (std::size_t r = 0; r < repetitions; ++r) timing.repetition_ns[r] = around + static_cast<double>(r % 5);
  return timing;
}

std::string results(double single, double batch, std::size_t missed, double worst,
                    std::size_t repetitions = 9) {
  Report report;
  report.has_truth = true;
  SetResult set;
  set.name = "made_up";
  set.cases = 100;
  BackendResult backend;
  backend.name = "some";
  backend.judged = true;
  backend.rows[0].single = times(single, repetitions);
  backend.rows[0].batch = times(batch, repetitions);
  for (Wrongness& wrong : backend.judgement.wrongness) wrong.cases = 100;
  backend.judgement.wrongness[0].missed = missed;
  backend.judgement.cost[1] = {worst, worst, worst, 7, 100};
  set.backends = {backend};
  report.sets = {set};
  return results_json(report);
}

TEST(Diff, NamesWrongnessFirstThenErrorsThenTimes) {
  const std::string text = diff_reports(results(100, 50, 0, 1e-16), results(200, 50, 3, 1e-4), false);
  EXPECT_THAT(text, StartsWith("  wrong answers"));
  EXPECT_THAT(text, HasSubstr("0 of 100  3 of 100"));
  EXPECT_THAT(text, HasSubstr("1.0e-16  1.0e-04  made_up:7"));
  EXPECT_THAT(text, HasSubstr("slower"));
  EXPECT_THAT(text, HasSubstr("1.980"));  // 202 over 102: medians of the repetitions
  EXPECT_THAT(text, HasSubstr("1 rows resolved, 1 unresolved (0 of these"));
  EXPECT_LT(text.find("3 of 100"), text.find("1.0e-04"));
  EXPECT_LT(text.find("1.0e-04"), text.find("slower"));
}

TEST(Diff, NoiseIsUnresolved) {
  const std::string text = diff_reports(results(100, 50, 2, 0), results(101, 50, 2, 0), true);
  EXPECT_THAT(text, HasSubstr("wrong answers: no change"));
  EXPECT_THAT(text, HasSubstr("0 rows resolved, 2 unresolved"));
  EXPECT_THAT(text, Not(HasSubstr("slower\n")));
}

TEST(Diff, FewRepetitionsAreNeverResolved) {
  const std::string text = diff_reports(results(100, 50, 0, 0, 8), results(900, 50, 0, 0, 9), true);
  EXPECT_THAT(text, HasSubstr("0 rows resolved, 2 unresolved (2 of these with fewer than 9"));
}

TEST(Diff, OtherFilesAreRefused) {
  EXPECT_THROW(diff_reports("{}", results(1, 1, 0, 0), false), InputError);
  EXPECT_THROW(diff_reports("no json", results(1, 1, 0, 0), false), InputError);
  EXPECT_THROW(diff_reports(R"({"schema": "touchstone.compare_backends/1"})", results(1, 1, 0, 0), false),
               InputError);
}

}  // namespace
}  // namespace touchstone::comparison
