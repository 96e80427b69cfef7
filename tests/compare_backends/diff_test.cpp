#include "touchstone/examples/compare_backends/diff/diff.hpp"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/examples/compare_backends/results/json_writer.hpp"

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

Report made_up(double single, double batch, std::size_t missed, double worst, std::size_t repetitions = 9) {
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
  return report;
}

std::string results(double single, double batch, std::size_t missed, double worst,
                    std::size_t repetitions = 9) {
  return results_json(made_up(single, batch, missed, worst, repetitions));
}

std::string diff(const Report& before, const Report& after) {
  return diff_reports(results_json(before), results_json(after), false);
}

BackendResult& only_backend(Report& report) { return report.sets[0].backends[0]; }

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

TEST(Diff, WhatOneOfTheTwoCannotKnowIsNotCalledUnchanged) {
  const Report before = made_up(100, 50, 3, 1e-4);
  Report after = before;
  after.has_truth = false;
  only_backend(after).judged = false;
  const std::string text = diff(before, after);
  EXPECT_THAT(text,
              StartsWith("wrong answers: not comparable: NEW has no exact\nworst errors: not comparable"));
  EXPECT_THAT(text, Not(HasSubstr("wrong answers: no change")));
  EXPECT_THAT(text, HasSubstr("measured against exact differs: true -> false"));
  EXPECT_THAT(diff(after, before), StartsWith("wrong answers: not comparable: OLD has no exact"));
  EXPECT_THAT(diff(after, after), StartsWith("wrong answers: not comparable: neither has exact"));
}

TEST(Diff, ReadsFramesAndBroadphases) {
  // A broadphase and a scene without faults.
  Report before = made_up(100, 50, 0, 0);
  BroadphaseResult broadphase;
  broadphase.name = "sweep";
  broadphase.size = {1000, 4};
  broadphase.frames = 8;
  broadphase.missed = 0;
  broadphase.true_pairs = 777;
  broadphase.allocations = 0;
  before.broadphases = {broadphase};
  SceneResult scene;
  scene.name = "some_scene";
  scene.frames = 50;
  scene.backends.emplace_back().name = "some";
  before.scenes = {scene};
  // The same with faults.
  Report after = before;
  after.broadphases[0].missed = 5;
  after.broadphases[0].allocations = 3;
  after.scenes[0].backends[0].missed_frames = 11;
  after.scenes[0].backends[0].worst_clearance_error = 0.25;
  // The difference names each, and nothing where none is.
  const std::string text = diff(before, after);
  EXPECT_THAT(text, HasSubstr("0 of 777  5 of 777"));
  EXPECT_THAT(text, HasSubstr("0 of 50  11 of 50"));
  EXPECT_THAT(text, HasSubstr("2.5e-01"));
  EXPECT_THAT(text, HasSubstr("a frame"));
  EXPECT_THAT(text, HasSubstr("times of broadphases: not compared"));
  EXPECT_THAT(diff(before, before), HasSubstr("wrong answers: no change in 22 figures"));  // 18 + 3 + 1
}

TEST(Diff, ReadsEveryErrorConsistencyAndAllocations) {
  Report before = made_up(100, 50, 0, 1e-16);
  BackendResult& old_backend = only_backend(before);
  old_backend.judgement.errors[static_cast<std::size_t>(Measure::normal)].over_scale = {1e-9, 1e-9, 1e-9, 3,
                                                                                        9};
  old_backend.rows[0].allocations = 0;
  old_backend.consistency.emplace();
  old_backend.consistency->swapped.cases = 100;
  Report after = before;
  BackendResult& backend = only_backend(after);
  backend.judgement.errors[static_cast<std::size_t>(Measure::normal)].over_scale.worst = 0.5;
  backend.rows[0].allocations = 2;
  backend.consistency->swapped.bits = 7;
  const std::string text = diff(before, after);
  EXPECT_THAT(text, HasSubstr("normal over S  1.0e-09  5.0e-01  made_up:3"));
  EXPECT_THAT(text, HasSubstr("swapped: bits  0 of 100  7 of 100"));
  EXPECT_THAT(text, HasSubstr("a query    0  2.0e+00"));
  const std::string same = diff(before, before);
  for (const char* part : {"wrong answers", "worst errors", "consistency", "allocations"})
    EXPECT_THAT(same, HasSubstr(std::string(part) + ": no change in "));
}

TEST(Diff, ComparesTimesOnThreads) {
  Report before = made_up(100, 50, 0, 0);
  ThreadResult run;
  run.backend = "some";
  run.threads = 2;
  run.pass = times(100, 9);
  before.thread_runs = {run};
  Report after = before;
  after.thread_runs[0].pass = times(300, 9);
  const std::string text = diff(before, after);
  EXPECT_THAT(text, HasSubstr("times on threads: 1 rows resolved, 0 unresolved"));
  EXPECT_THAT(text, HasSubstr("times: 0 rows resolved, 2 unresolved"));
  EXPECT_THAT(text, HasSubstr("on 2  2.961"));  // 302 over 102
  after.thread_runs.clear();
  EXPECT_THAT(diff(before, after), HasSubstr("row gone: threads, some: all of it"));
}

TEST(Diff, RowsThatAreGoneAreNamed) {
  const Report before = made_up(100, 50, 0, 1e-16);
  Report after = before;
  only_backend(after).rows[0].batch.reset();
  only_backend(after).judgement.cost[1].count = 0;
  const std::string text = diff(before, after);
  EXPECT_THAT(text, HasSubstr("row gone: made_up, some, overlap, batch time\n"));
  EXPECT_THAT(text, HasSubstr("row gone: made_up, some, distance, cost over S\n"));
  EXPECT_THAT(diff(after, before), HasSubstr("row new: made_up, some, overlap, batch time\n"));
  after.sets[0].name = "other";
  EXPECT_THAT(diff(before, after), HasSubstr("row gone: made_up, some: all of it\n"));
  EXPECT_THAT(diff(before, after), HasSubstr("wrong answers: nothing to compare"));
}

TEST(Diff, AKeyThatIsMissingIsAnErrorThatNamesIt) {
  nlohmann::json json = nlohmann::json::parse(results(100, 50, 0, 1e-16));
  json["pair_sets"][0]["backends"][0]["queries"]["distance"]["cost_over_S"].erase("worst");
  try {
    diff_reports(results(1, 1, 0, 0), json.dump(), false);
    ADD_FAILURE() << "was read";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("worst"));
  }
}

TEST(Diff, OtherFilesAreRefused) {
  EXPECT_THROW(diff_reports("{}", results(1, 1, 0, 0), false), InputError);
  EXPECT_THROW(diff_reports("no json", results(1, 1, 0, 0), false), InputError);
  EXPECT_THROW(diff_reports(R"({"schema": "touchstone.compare_backends/1"})", results(1, 1, 0, 0), false),
               InputError);
}

}  // namespace
}  // namespace touchstone::comparison
