#include "touchstone/examples/compare_backends/run/workers/worker.hpp"

#include <gtest/gtest.h>
#include <poll.h>
#include <sched.h>
#include <sys/mount.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "touchstone/examples/compare_backends/run/comparison.hpp"
#include "touchstone/examples/compare_backends/run/sets/set_summary.hpp"
#include "touchstone/examples/compare_backends/run/workers/job_io.hpp"
#include "touchstone/examples/compare_backends/run/workers/signs_of_life.hpp"
#include "touchstone/examples/measures/pairs/pair_families.hpp"
#include "touchstone/tests/measures/fake_backends.hpp"

namespace touchstone::comparison {
namespace {

MeasureOptions quick() {
  MeasureOptions options;
  options.repetitions = 1;
  return options;
}

TEST(Worker, AnswersAsInThisProcess) {
  const Worker worker = describe_worker(TEST_WORKER);
  ASSERT_EQ(worker.failure, "");
  ASSERT_TRUE(worker.offers("right"));
  const PairSet set = testing::cubes({0.5, -0.25, 0.0, 1e-300});
  const std::vector<std::string> names = {"right", "off_by_1e-3"};
  const auto there = run_in_worker(worker, names, set, quick());
  Backends backends;
  testing::register_fakes(backends.registry);
  Options options;
  options.backends = names;
  const auto here = answer_set(options, backends, set, quick());
  ASSERT_EQ(there.size(), 2u);
  for (std::size_t b = 0; b < 2; ++b) {
    EXPECT_EQ(there[b].name, names[b]);
    EXPECT_TRUE(there[b].queries[0].single);
    for (std::size_t q = 0; q < 3; ++q) {
      EXPECT_EQ(there[b].queries[q].status, here[b].queries[q].status);
      for (std::size_t i = 0; i < here[b].queries[q].geometry.size(); ++i) {
        EXPECT_EQ(there[b].queries[q].geometry[i].separation, here[b].queries[q].geometry[i].separation);
      }
    }
  }
}

TEST(Worker, ADeadOneIsFailedAndTheRestGoesOn) {
  Backends backends;
  testing::register_fakes(backends.registry);
  Worker worker = describe_worker(TEST_WORKER);
  worker.backends = {{"dying", "ends its process"}};
  backends.workers.push_back(worker);
  Options options;
  options.backends = {"right", "dying"};
  const PairSet set = testing::cubes({0.5, -0.25});
  const auto answers = answer_set(options, backends, set, quick());
  ASSERT_EQ(answers.size(), 2u);
  EXPECT_EQ(answers[0].failure, "");
  EXPECT_EQ(answers[1].name, "dying");
  EXPECT_NE(answers[1].failure.find("died"), std::string::npos) << answers[1].failure;
  const testing::CubeOracle oracle;
  const SetResult result = sum_up(set, compute_truth(set, oracle, 1), &oracle, answers, 1);
  EXPECT_EQ(result.backends[1].judgement.wrongness[1].failed, 2u);
}

TEST(Worker, AHangingOneIsEndedAndFailed) {
  Worker worker = describe_worker(TEST_WORKER);
  worker.backends = {{"hanging", "never returns"}};
  worker.time_limit = std::chrono::milliseconds(300);
  const std::vector<std::string> names = {"hanging"};
  const auto answers = run_in_worker(worker, names, testing::cubes({0.5, -0.25}), quick());
  ASSERT_EQ(answers.size(), 1u);
  EXPECT_NE(answers[0].failure.find("gave no answer within 0.3 s"), std::string::npos) << answers[0].failure;
  EXPECT_EQ(answers[0].queries[0].status, std::vector<PairStatus>(2, PairStatus::failed));
}

TEST(Worker, AHangingOneIsNotAskedAgain) {
  Worker worker = describe_worker(TEST_WORKER);
  worker.time_limit = std::chrono::milliseconds(300);
  const Worker copy = worker;
  const PairSet set = testing::cubes({0.5, -0.25});
  const std::vector<std::string> hanging = {"hanging"}, right = {"right"};
  EXPECT_EQ(run_in_worker(worker, right, set, quick()).at(0).failure, "");
  EXPECT_NE(run_in_worker(worker, hanging, set, quick()).at(0).failure, "");
  const auto later = run_in_worker(copy, right, set, quick());
  ASSERT_EQ(later.size(), 1u);
  EXPECT_EQ(later[0].name, "right");
  EXPECT_NE(later[0].failure.find("within 0.3 s in an earlier set; it is not asked again"), std::string::npos)
      << later[0].failure;
  EXPECT_EQ(later[0].queries[2].status, std::vector<PairStatus>(2, PairStatus::failed));
}

// A pipe's other end is closed where nobody has it any more.
TEST(Worker, WhatItsEnginePrintsAndStartsIsNotOurs) {
  const Worker worker = describe_worker(TEST_WORKER);
  const std::vector<std::string> names = {"rude"};
  int ends[2] = {-1, -1};
  ASSERT_EQ(pipe(ends), 0);
  ::testing::internal::CaptureStdout();
  const auto answers = run_in_worker(worker, names, testing::cubes({0.5}), quick());
  EXPECT_EQ(::testing::internal::GetCapturedStdout(), "");
  close(ends[1]);
  pollfd end{ends[0], POLLIN, 0};
  EXPECT_EQ(poll(&end, 1, 5000), 1);
  close(ends[0]);
  EXPECT_EQ(answers.at(0).failure, "");
}

// Its libraries are loaded, and its job is read, before the first sign.
TEST(Worker, AStartOfSeveralLimitsIsNoHang) {
  Worker worker = describe_worker(TEST_WORKER, {"--start-late"}, std::chrono::milliseconds(600));
  ASSERT_EQ(worker.failure, "");
  const std::vector<std::string> names = {"right"};
  const auto answers = run_in_worker(worker, names, testing::cubes({0.5, -0.25}), quick());
  EXPECT_EQ(answers.at(0).failure, "");
}

TEST(Worker, AnEngineThatTakesLongInAllIsNotAHangingOne) {
  Worker worker = describe_worker(TEST_WORKER);
  worker.backends = {{"slow", "a tenth of a second a call"}};
  worker.time_limit = std::chrono::milliseconds(1000);
  MeasureOptions options = quick();
  options.time_pairs = options.perturb = false;
  const std::vector<std::string> names = {"slow"};
  PairSet set = testing::cubes(std::vector<double>(256 * 5, 0.5));  // 5 calls a query: 1.5 s
  const auto answers = run_in_worker(worker, names, set, options);
  ASSERT_EQ(answers.size(), 1u);
  EXPECT_EQ(answers[0].failure, "");
}

/// A file's count, and whoever waits for it by a clock of the test's own.
struct Waiting {
  std::filesystem::path file =
      std::filesystem::path(::testing::TempDir()) /
      (std::string(::testing::UnitTest::GetInstance()->current_test_info()->name()) + ".life");
  SignsOfLife signs{file};
  Patience::Clock::time_point now{};
  Patience patience{signs, std::chrono::milliseconds(300), now};
  ~Waiting() { std::filesystem::remove(file); }

  bool is_over_after(int polls, std::chrono::milliseconds apart) {
    bool is_over = false;
    for (int i = 0; i < polls && !is_over; ++i) is_over = patience.is_over(now += apart);
    return is_over;
  }
};

// As after Ctrl-Z and fg an hour later.
TEST(Patience, WhileThisProcessIsStoppedNobodyWaits) {
  Waiting waiting;
  waiting.signs.give();
  EXPECT_FALSE(waiting.is_over_after(20, std::chrono::milliseconds(5)));
  EXPECT_FALSE(waiting.is_over_after(1, std::chrono::hours(1)));
  EXPECT_FALSE(waiting.is_over_after(20, std::chrono::milliseconds(5)));
  EXPECT_TRUE(waiting.is_over_after(20, std::chrono::milliseconds(5)));
}

TEST(Patience, AStartMayTakeFiveLimits) {
  Waiting waiting;
  EXPECT_EQ(waiting.patience.limit(), std::chrono::milliseconds(1500));
  EXPECT_FALSE(waiting.is_over_after(300, std::chrono::milliseconds(5)));
  waiting.signs.give();
  EXPECT_FALSE(waiting.is_over_after(61, std::chrono::milliseconds(5)));
  EXPECT_EQ(waiting.patience.limit(), std::chrono::milliseconds(300));
  EXPECT_TRUE(waiting.is_over_after(1, std::chrono::milliseconds(5)));
}

// Signs come, but slowly: 30 limits in all, and a thousandth of one a sign.
TEST(Patience, WhoSleepsInEveryCallIsEnded) {
  Waiting waiting;
  int calls = 0;
  for (bool is_over = false; !is_over && calls < 100; ++calls) {
    waiting.signs.give();
    is_over = waiting.is_over_after(50, std::chrono::milliseconds(5));
  }
  EXPECT_TRUE(waiting.patience.is_too_long());
  EXPECT_EQ(calls, 37);  // of 0.25 s: 9.25 s > 9.0111 s
}

TEST(Patience, EachSignStartsItAnew) {
  Waiting waiting;
  for (int sign = 0; sign < 10; ++sign) {
    waiting.signs.give();
    EXPECT_FALSE(waiting.is_over_after(59, std::chrono::milliseconds(5)));
  }
}

enum MadeOn : int { said_why = 0, made_it = 1, no_disk = 2 };

// A disk of one page, which is full; in a process of its own, whose mounts nobody else sees.
MadeOn make_on_a_full_disk(const std::filesystem::path& folder) {
  if (unshare(CLONE_NEWNS) != 0 || mount(nullptr, "/", nullptr, MS_REC | MS_PRIVATE, nullptr) != 0 ||
      mount("none", folder.c_str(), "tmpfs", 0, "size=4k") != 0)
    return no_disk;
  std::ofstream(folder / "full") << std::string(5000, 'x') << std::flush;
  try {
    SignsOfLife(folder / "life").give();
    return made_it;
  } catch (const std::runtime_error& error) {
    return std::strstr(error.what(), "No space left") == nullptr ? made_it : said_why;
  }
}

TEST(SignsOfLife, ACopyThatAnEnginesCallForkedEndsWhereItReturns) {
  Waiting waiting;
  SignsOfLife& signs = waiting.signs;
  const pid_t copy = fork();
  if (copy == 0) {
    signs.give();
    _exit(7);
  }
  int status = -1;
  ASSERT_EQ(waitpid(copy, &status, 0), copy);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << status;
  EXPECT_EQ(signs.count(), 0u);
  signs.give();
  EXPECT_EQ(signs.count(), 1u);
}

TEST(SignsOfLife, AFullDiskIsAnErrorAndNoSignal) {
  const std::filesystem::path folder = std::filesystem::path(::testing::TempDir()) / "signs_on_a_full_disk";
  std::filesystem::create_directories(folder);
  const pid_t process = fork();
  if (process == 0) _exit(make_on_a_full_disk(folder));
  int status = 0;
  ASSERT_EQ(waitpid(process, &status, 0), process);
  std::filesystem::remove(folder);
  ASSERT_TRUE(WIFEXITED(status)) << strsignal(WTERMSIG(status));
  if (WEXITSTATUS(status) == no_disk) GTEST_SKIP() << "nothing can be mounted here";
  EXPECT_EQ(WEXITSTATUS(status), said_why);
}

TEST(Worker, AProgramThatIsNotThereSaysSo) { EXPECT_NE(describe_worker("/no/such/program").failure, ""); }
TEST(Worker, OneThatEndsBeforeItNamesABackendSaysSo) {
  EXPECT_EQ(describe_worker("/bin/true").failure, "true named no backends");
}

TEST(Job, CarriesEveryBitOfTheSolids) {
  for (const PairFamily& family : pair_families()) {
    const PairSet set = make_pair_family(family.name, 3, 20);
    const Job copy = decode_job(encode_job({{"x"}, {}, set}));
    ASSERT_EQ(copy.set.cases(), set.cases());
    for (std::size_t i = 0; i < set.cases(); ++i) {
      const PosedPair before = posed_pair(set, i), after = posed_pair(copy.set, i);
      for (int v = 0; v < 8; ++v) {
        EXPECT_EQ(before.a.vertex(v), after.a.vertex(v)) << case_id(set, i);
        EXPECT_EQ(before.b.vertex(v), after.b.vertex(v)) << case_id(set, i);
      }
      EXPECT_EQ(set.solids[2 * i].is_box(), copy.set.solids[2 * i].is_box());
    }
  }
}

TEST(Job, CarriesWhatWasAnsweredLater) {
  std::vector<BackendAnswers> answers(1);
  measures::LaterAnswer later{7, PairStatus::overlapping, {-0.5, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}, 1}, {}};
  later.points.push_back({{1, 2, 3}, {4, 5, 6}, -0.25, 7});
  answers[0].queries[2].later.push_back(later);
  const std::vector<BackendAnswers> copy = decode_answers(encode_answers(answers));
  ASSERT_EQ(copy[0].queries[2].later.size(), 1u);
  const measures::LaterAnswer& got = copy[0].queries[2].later[0];
  EXPECT_EQ(got.index, 7u);
  EXPECT_EQ(got.status, PairStatus::overlapping);
  EXPECT_EQ(got.geometry.p_B_W, later.geometry.p_B_W);
  EXPECT_EQ(got.geometry.point_count, 1);
  ASSERT_EQ(got.points.size(), 1u);
  EXPECT_EQ(got.points[0].separation, -0.25);
}

TEST(Job, TruncatedAnswersAreRefused) {
  const std::string bytes = encode_answers(std::vector<BackendAnswers>(1));
  EXPECT_THROW(decode_answers(bytes.substr(0, bytes.size() - 4)), std::runtime_error);
}

}  // namespace
}  // namespace touchstone::comparison
