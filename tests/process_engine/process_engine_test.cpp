#include "touchstone/adapters/process_engine/process_engine.hpp"

#include <gmock/gmock.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <thread>

#include "touchstone/adapters/process_engine/child_process.hpp"
#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/contact_core/native/native.hpp"
#include "touchstone/examples/measures/pairs/pair_families.hpp"
#include "touchstone/tests/support/ask.hpp"

namespace touchstone {
namespace {

using std::chrono::milliseconds;
using testing::Contains;
using testing::Each;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

/// An engine's narrowphase, and the messages about it.
struct Engine {
  std::vector<std::string> told;
  BackendRegistry registry;
  std::string name;

  explicit Engine(std::vector<std::string> command, milliseconds limit = milliseconds(5000)) {
    name = register_process_engine(
        registry, {.command = std::move(command),
                   .time_limit = limit,
                   .on_failure = [this](std::string_view what) { told.emplace_back(what); }});
  }
  Answers ask(std::span<const Hexahedron> solids, std::span<const SolidPair> pairs,
              std::span<const Pose> poses, const Query& query) {
    const auto narrowphase = registry.make_narrowphase(name);
    narrowphase->build(solids);
    return touchstone::ask(*narrowphase, pairs, poses, query);
  }
};

/// 60 pairs (0, b), b from 1.
struct Row {
  std::vector<Hexahedron> solids{61, Hexahedron::from_size({1, 1, 1})};
  std::vector<Pose> poses{61};
  std::vector<SolidPair> pairs;
  Row() {
    for (SolidIndex b = 1; b < solids.size(); ++b) pairs.push_back({0, b});
  }
};

// Pair 30 is (0, 31), the one that the bad engine goes wrong on.
void expect_only_pair_30_failed(Engine& bad, const Row& row, const char* reason,
                                const Query& query = {.kind = QueryKind::distance}) {
  const Answers answers = bad.ask(row.solids, row.pairs, row.poses, query);
  for (std::size_t i = 0; i < row.pairs.size(); ++i) {
    EXPECT_EQ(answers.status[i], i == 30 ? PairStatus::failed : PairStatus::separated) << i;
    if (i == 30) {
      EXPECT_TRUE(std::isnan(answers.geometry[i].separation));
    } else {
      EXPECT_EQ(answers.geometry[i].separation, 1.0);
    }
  }
  ASSERT_FALSE(bad.told.empty());
  EXPECT_THAT(bad.told, Contains(HasSubstr(reason)));
  EXPECT_THAT(bad.told.back(), HasSubstr("on pair 30"));
}
void expect_only_pair_30_failed(const char* how, const char* reason,
                                milliseconds limit = milliseconds(5000)) {
  SCOPED_TRACE(how);
  Engine bad({BAD_ENGINE, how}, limit);
  expect_only_pair_30_failed(bad, Row(), reason);
}
void expect_only_pair_30_failed_in_json(const char* how, const char* reason,
                                        const Query& query = {.kind = QueryKind::distance},
                                        std::size_t pairs = 60) {
  SCOPED_TRACE(how);
  Engine bad({BAD_ENGINE, how, "json"});
  Row row;
  row.pairs.resize(pairs);
  expect_only_pair_30_failed(bad, row, reason, query);
}

TEST(ProcessEngine, ACrashIsFailedOnItsPair) {
  expect_only_pair_30_failed("crash", "engine bad: failed, signal 11 on pair 30");
  expect_only_pair_30_failed("exit", "engine bad: failed, exit code 7 on pair 30");
}
TEST(ProcessEngine, AHangIsFailedOnItsPair) {
  expect_only_pair_30_failed("hang", "failed, no answer within 0.5 s on pair 30", milliseconds(500));
}
TEST(ProcessEngine, AClosedOutputIsFailedOnItsPair) {
  expect_only_pair_30_failed("close", "failed, it closed its input or output on pair 30");
}
TEST(ProcessEngine, WhatItStartedThatHoldsItsPipesIsNoAnswer) {
  expect_only_pair_30_failed("orphan", "failed, no answer within 0.3 s after exit code 7 on pair 30",
                             milliseconds(300));
}
TEST(ProcessEngine, AStoppedOneIsFailedOnItsPair) {
  expect_only_pair_30_failed("stop", "failed, no answer within 0.3 s on pair 30", milliseconds(300));
}
TEST(ProcessEngine, WhatBreaksTheProtocolIsFailedOnItsPair) {
  expect_only_pair_30_failed("order", "failed, its answers are in another order than the pairs on pair 30");
  expect_only_pair_30_failed("batch", "failed, its reply is to another question on pair 30");
  expect_only_pair_30_failed("short", "exit code 0 on pair 30");
}
TEST(ProcessEngine, WhatIsNoAnswerIsFailedOnItsPair) {
  expect_only_pair_30_failed("nan", "its separation is not finite, on pair 30");
  expect_only_pair_30_failed("infinity", "its separation is not finite, on pair 30");
  expect_only_pair_30_failed("status", "its status is none, or was not written, on pair 30");
}

TEST(ProcessEngine, LinesThatBreakTheProtocolAreFailedOnTheirPair) {
  expect_only_pair_30_failed_in_json("order", "its answers are in another order than the pairs on pair 30");
  expect_only_pair_30_failed_in_json("short", "exit code 0 on pair 30");
  expect_only_pair_30_failed_in_json("deep", "its line is no JSON object on pair 30");
  expect_only_pair_30_failed_in_json("long", "its line does not end on pair 30");
  for (const char* figure : {"comma", "literal", "beyond"})
    expect_only_pair_30_failed_in_json(figure, "its line is no JSON object on pair 30");
}
TEST(ProcessEngine, LinesMayEndAsOnOtherSystems) {
  for (const char* how : {"crlf", "bom"}) {
    Engine engine({BAD_ENGINE, how, "json"});
    const Row row;
    EXPECT_THAT(engine.ask(row.solids, row.pairs, row.poses, {.kind = QueryKind::distance}).status,
                Each(PairStatus::separated));
    EXPECT_THAT(engine.told, IsEmpty());
  }
}
// Pair 30 is the last of them: what is written too much follows the reply.
TEST(ProcessEngine, AReplyThatHoldsMoreThanWasAskedIsNotBelieved) {
  expect_only_pair_30_failed_in_json("extra", "it writes more than was asked on pair 30",
                                     {.kind = QueryKind::distance}, 31);
}
TEST(ProcessEngine, NumbersThatAreNoWholeOnesAreFailedOnTheirPair) {
  const char* reason = "its line lacks a field or has one of another type on pair 30";
  expect_only_pair_30_failed_in_json("fraction", reason);
  expect_only_pair_30_failed_in_json("feature", reason, {.kind = QueryKind::manifold, .max_points = 4});
}

TEST(ProcessEngine, AFloodIsNotBelievedAndEnds) {
  Engine bad({BAD_ENGINE, "flood"});
  const Row row;
  const auto narrowphase = bad.registry.make_narrowphase(bad.name);
  narrowphase->build(row.solids);
  const auto workspace = narrowphase->make_workspace();
  Answers answers;  // the flood may come after the first reply was read
  for (int time = 0; time < 2; ++time)
    evaluate(*narrowphase, row.pairs, row.poses, {.kind = QueryKind::distance}, *workspace, answers);
  EXPECT_GT(std::count(answers.status.begin(), answers.status.end(), PairStatus::failed), 20);
  ASSERT_FALSE(bad.told.empty());
  EXPECT_THAT(bad.told, Contains(testing::AnyOf(HasSubstr("it writes more than was asked"),
                                                HasSubstr("its reply is to another question"))));
  EXPECT_THAT(bad.told.back(), HasSubstr("given up after 16 restarts"));
}

// Eight failures: four workspaces' worth of two.
TEST(ProcessEngine, OneThatNeverAnswersIsGivenUpInAllWorkspaces) {
  std::vector<std::string> told;
  BackendRegistry registry;
  const std::string name = register_process_engine(
      registry, {.command = {BAD_ENGINE, "crash"},
                 .time_limit = milliseconds(5000),
                 .max_restarts = 1,
                 .on_failure = [&](std::string_view what) { told.emplace_back(what); }});
  const auto narrowphase = registry.make_narrowphase(name);
  const Row row;
  narrowphase->build(row.solids);
  const std::vector<SolidPair> bad(60, SolidPair{0, 31}), good(60, SolidPair{0, 1});
  const auto first_status = [&](const std::vector<SolidPair>& pairs) {
    return ask(*narrowphase, pairs, row.poses, {.kind = QueryKind::distance}).status[0];  // a workspace each
  };
  // An engine that answers now and then is asked again; a process that it has from a workspace before is no
  // restart, nor is the one after it.
  for (int i = 0; i < 6; ++i) {
    told.clear();
    EXPECT_EQ(first_status(bad), PairStatus::failed);
    if (i > 0) {
      EXPECT_THAT(told.front(), HasSubstr("in a process that had served before"));
      told.erase(told.begin());
    }
    EXPECT_THAT(told, ElementsAre(HasSubstr("within pairs 0 to"), HasSubstr("on pair 0"),
                                  HasSubstr("given up after 1 restarts")));
    EXPECT_EQ(first_status(good), PairStatus::separated);
  }
  auto of_before = narrowphase->make_workspace();
  Answers answers;
  const auto answers_still = [&] {
    evaluate(*narrowphase, good, row.poses, {.kind = QueryKind::distance}, *of_before, answers);
    return answers.status[0] == PairStatus::separated;
  };
  EXPECT_TRUE(answers_still());
  for (int i = 0; i < 4; ++i) EXPECT_EQ(first_status(bad), PairStatus::failed);
  told.clear();
  EXPECT_EQ(first_status(good), PairStatus::failed);
  EXPECT_THAT(told, ElementsAre(HasSubstr("given up after 8 failures in a row without an answer, in all "
                                          "workspaces; 60 pairs here")));
  // For good, though a process that runs goes on.
  EXPECT_TRUE(answers_still());
  EXPECT_EQ(first_status(good), PairStatus::failed);
  of_before.reset();
  EXPECT_EQ(first_status(good), PairStatus::failed);
}

TEST(ProcessEngine, OneThatCrashesIsAskedNoMoreAtATime) {
  Engine bad({BAD_ENGINE, "crash"});
  const Row row;
  std::vector<SolidPair> pairs(60, SolidPair{0, 1});
  pairs[3] = pairs[19] = {0, 31};
  bad.ask(row.solids, pairs, row.poses, {.kind = QueryKind::distance});
  EXPECT_THAT(bad.told, ElementsAre(HasSubstr("within pairs 0 to 15"), HasSubstr("on pair 3"),
                                    HasSubstr("within pairs 16 to 31"), HasSubstr("on pair 19")));
}

// Its naps of 0.1 s end the half second that it has beyond what is free. Where the machine stalls once, that
// question times out and is asked again.
TEST(ProcessEngine, OneThatSleepsInEveryQuestionIsGivenUp) {
  std::vector<std::string> told;
  BackendRegistry registry;
  const std::string name = register_process_engine(
      registry, {.command = {BAD_ENGINE, "nap"},
                 .time_limit = milliseconds(500),
                 .limits_in_all = 1,
                 .on_failure = [&](std::string_view what) { told.emplace_back(what); }});
  const auto narrowphase = registry.make_narrowphase(name);
  const Row row;
  narrowphase->build(row.solids);
  PairStatus last = PairStatus::separated;
  int asked = 0;
  const std::vector<SolidPair> pairs(2, SolidPair{0, 1});
  while (last == PairStatus::separated && asked < 20) {
    last = ask(*narrowphase, pairs, row.poses, {.kind = QueryKind::distance}).status[0];
    ++asked;
  }
  EXPECT_EQ(last, PairStatus::failed);
  EXPECT_GT(asked, 1);
  ASSERT_FALSE(told.empty());
  EXPECT_THAT(told.back(), HasSubstr("given up after 0.5 s in its questions; 2 pairs here"));
}

// A question has 78 ms of these limits free, and 13 ms a pair, so that a nap of 0.1 s counts nothing. A
// machine that stalls for longer than the first question has free is tried again.
TEST(ProcessEngine, OneThatIsAskedManyPairsAtATimeMayTakeTimeForEach) {
  const Row row;
  const std::vector<SolidPair> pairs(240, SolidPair{0, 1});
  bool all_separated = false;
  for (int time = 0; time < 3 && !all_separated; ++time) {
    BackendRegistry registry;
    const std::string name = register_process_engine(
        registry, {.command = {BAD_ENGINE, "nap"}, .time_limit = milliseconds(1300), .limits_in_all = 0});
    const auto narrowphase = registry.make_narrowphase(name);
    narrowphase->build(row.solids);
    const Answers answers = ask(*narrowphase, pairs, row.poses, {.kind = QueryKind::distance});
    all_separated = std::ranges::count(answers.status, PairStatus::separated) == std::ssize(pairs);
  }
  EXPECT_TRUE(all_separated);
}

// 60 pairs of 0.01 s each are no answer for 0.6 s where they are asked together.
TEST(ProcessEngine, OneThatIsSlowIsAskedFewPairsAtATime) {
  Engine slow({BAD_ENGINE, "slow_pairs"}, milliseconds(500));
  const Row row;
  const Answers answers = slow.ask(row.solids, row.pairs, row.poses, {.kind = QueryKind::distance});
  EXPECT_THAT(answers.status, Each(PairStatus::separated));
  EXPECT_THAT(slow.told, IsEmpty());
}

// A million bytes wait in the pipe; the rest is taken 3 840 bytes every 30 ms.
TEST(ProcessEngine, OneThatTakesItsSolidsBySipsIsEnded) {
  std::vector<std::string> told;
  BackendRegistry registry;
  const std::string name = register_process_engine(
      registry, {.command = {BAD_ENGINE, "sips"},
                 .time_limit = milliseconds(400),
                 .max_restarts = 0,
                 .limits_of_a_question = 1,
                 .on_failure = [&](std::string_view what) { told.emplace_back(what); }});
  const auto narrowphase = registry.make_narrowphase(name);
  const std::vector<Hexahedron> solids(8000, Hexahedron::from_size({1, 1, 1}));
  const std::vector<Pose> poses(solids.size());
  narrowphase->build(solids);
  const std::vector<SolidPair> pairs{{0, 1}};
  EXPECT_THAT(ask(*narrowphase, pairs, poses, {.kind = QueryKind::distance}).status,
              ElementsAre(PairStatus::failed));
  ASSERT_FALSE(told.empty());
  // The second where the machine stalls.
  EXPECT_THAT(told.front(), testing::AnyOf(HasSubstr("failed, not done within 0.8 s on taking solids"),
                                           HasSubstr("failed, no move within 0.4 s on taking solids")));
}

// All are started before the first answers, which is twice as often as may be in vain.
TEST(ProcessEngine, StartsThatAreUnderWayAreNotInVain) {
  std::vector<std::string> told;
  BackendRegistry registry;
  const std::string name = register_process_engine(
      registry, {.command = {BAD_ENGINE, "slow"},
                 .time_limit = milliseconds(20000),
                 .max_restarts = 0,
                 .on_failure = [&](std::string_view what) { told.emplace_back(what); }});
  const auto narrowphase = registry.make_narrowphase(name);
  const Row row;
  narrowphase->build(row.solids);
  std::vector<Answers> answers(8);
  {
    std::vector<std::jthread> threads;
    for (Answers& each : answers)
      threads.emplace_back([&] {
        each = ask(*narrowphase, row.pairs, row.poses, {.kind = QueryKind::distance});  // a workspace each
      });
  }
  for (const Answers& each : answers) EXPECT_THAT(each.status, Each(PairStatus::separated));
  EXPECT_THAT(told, IsEmpty());
}

std::string refusal(std::vector<std::string> command, milliseconds limit = milliseconds(5000)) {
  BackendRegistry registry;
  try {
    register_process_engine(registry, {.command = std::move(command), .time_limit = limit});
  } catch (const InputError& error) {
    EXPECT_TRUE(registry.narrowphases().empty());
    return error.what();
  }
  return "";
}

TEST(ProcessEngine, WhatIsNoEngineIsRefusedByName) {
  EXPECT_THAT(refusal({}), HasSubstr("names no program"));
  EXPECT_THAT(refusal({"/no/such/program"}), HasSubstr("/no/such/program: cannot be started: No such file"));
  EXPECT_THAT(refusal({"true"}), HasSubstr("no greeting: exit code 0"));
  EXPECT_THAT(refusal({"echo", "hello"}), HasSubstr("no JSON object"));
  EXPECT_THAT(refusal({"echo", "{}"}), HasSubstr("lacks touchstone, name or format"));
  EXPECT_THAT(refusal({BAD_ENGINE, "version"}), HasSubstr("speaks version 2, this is 1"));
  EXPECT_THAT(refusal({BAD_ENGINE, "silent"}, milliseconds(100)), HasSubstr("no answer within 0.5 s"));
  EXPECT_THAT(refusal({BAD_ENGINE, "chatter"}), HasSubstr("first line does not end"));
  EXPECT_THAT(refusal({BAD_ENGINE, "utf16"}),
              testing::AnyOf(HasSubstr("no JSON object"), HasSubstr("more than its greeting")));
  EXPECT_THAT(refusal({BAD_ENGINE, "resolution"}), HasSubstr("its resolution is negative or no figure"));
  for (const char* fields : {R"("touchstone": 1.5)", R"("touchstone": 1, "scalar_bits": 1e300)"})
    EXPECT_THAT(refusal({"echo", R"({"name": "a", "format": "json", )" + std::string(fields) + "}"}),
                HasSubstr("has a field of another type"));
}

// It becomes the name of files, and a word on terminals.
TEST(ProcessEngine, ANameIsAPlainWord) {
  const auto named = [](const std::string& name, const char* format) {
    return refusal({"echo", R"({"touchstone": 1, "format": ")" + std::string(format) + R"(", "name": ")" +
                                name + "\"}"});
  };
  for (const char* format : {"json", "binary"}) {
    EXPECT_EQ(named("a.B-9_+", format), "");
    EXPECT_EQ(named(std::string(64, 'a'), format), "");
    for (const std::string name : {"", "../../a", "a/b", ".a", "a b", "a\\u001b[31m", "a\\u0000", "\u00e4"})
      EXPECT_THAT(named(name, format), HasSubstr("its name is not up to 64 letters, digits and _ - + ."))
          << name;
    EXPECT_THAT(named(std::string(65, 'a'), format), HasSubstr("its name is not up to 64"));
  }
}

// A program that reads no more but lives: writing to it raises the signal.
TEST(ProcessEngine, NoSignalOfABrokenPipeIsLeft) {
  sigset_t pipe, before, pending;
  sigemptyset(&pipe);
  sigaddset(&pipe, SIGPIPE);
  ASSERT_EQ(pthread_sigmask(SIG_BLOCK, &pipe, &before), 0);
  for (const bool was_pending : {false, true}) {
    process_engine::ChildProcess child({"sh", "-c", "exec 0<&-; exec sleep 60"});
    if (was_pending) raise(SIGPIPE);
    auto turn = process_engine::ChildProcess::Turn::wrote_or_read;
    for (std::string reply; turn == process_engine::ChildProcess::Turn::wrote_or_read;) {
      std::string_view request = "a";
      turn = child.exchange(request, reply, 1, milliseconds(5000));
    }
    EXPECT_EQ(turn, process_engine::ChildProcess::Turn::ended);
    sigpending(&pending);
    EXPECT_EQ(sigismember(&pending, SIGPIPE), was_pending ? 1 : 0);
  }
  const timespec at_once{0, 0};
  sigtimedwait(&pipe, nullptr, &at_once);
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
}

/// Waits for the end of a process, for 5 s at most.
bool has_ended(const std::string& process) {
  std::string letter;
  for (int i = 0; i < 1000; ++i) {
    std::ifstream file("/proc/" + process + "/stat");  // "123 (sleep) S ..."
    std::string number, name;
    letter.clear();
    file >> number >> name >> letter;
    if (letter.empty() || letter == "Z") return true;
    std::this_thread::sleep_for(milliseconds(5));
  }
  return false;
}

// What a program started in its group ends with it, and the system ends both before us where memory ends.
TEST(ProcessEngine, WhatItStartedEndsWithIt) {
  // The child's next line.
  const auto read_line = [](process_engine::ChildProcess& child, std::string_view request) {
    std::string reply;
    while (reply.find('\n') == std::string::npos && child.exchange(request, reply, 1, milliseconds(5000)) ==
                                                        process_engine::ChildProcess::Turn::wrote_or_read)
      continue;
    return reply;
  };
  // The child starts one of its own, and ends with its scope.
  std::string started;
  {
    process_engine::ChildProcess child(
        {"sh", "-c", "sleep 60 & echo $!; read line; cat /proc/self/oom_score_adj; exec sleep 60"});
    started = read_line(child, "");
    EXPECT_EQ(read_line(child, "go on\n"), "1000\n");
  }
  // So does what it started.
  ASSERT_GT(started.size(), 1u);
  EXPECT_TRUE(has_ended(started.substr(0, started.size() - 1)));
}

// A start and a large set's solids cost more than its pairs: the next workspace takes the process that is
// there, but not one that has ended.
TEST(ProcessEngine, WorkspacesInTurnShareAProcess) {
  const std::string starts = testing::TempDir() + "process_engine_starts_" + std::to_string(getpid());
  Engine engine({"sh", "-c", "echo $$ >>" + starts + "; exec " ENGINE_C});
  const auto narrowphase = engine.registry.make_narrowphase("engine_c");
  const Row row;
  narrowphase->build(row.solids);
  const auto lines = [&] {
    std::ifstream file(starts);
    return std::vector<std::string>(std::istream_iterator<std::string>(file), {});
  };
  const auto asked_again = [&] {
    const Answers answers = touchstone::ask(*narrowphase, row.pairs, row.poses, {});
    EXPECT_THAT(answers.status, Each(PairStatus::overlapping));
    return lines().size();
  };
  // The registration's, then one for all.
  EXPECT_EQ(asked_again(), 2u);
  EXPECT_EQ(asked_again(), 2u);
  narrowphase->build(std::span(row.solids).first(31));
  narrowphase->build(row.solids);
  EXPECT_EQ(asked_again(), 2u);
  // It ends while nobody asks.
  const std::string last = lines().back();
  kill(std::stoi(last), SIGKILL);
  ASSERT_TRUE(has_ended(last));
  EXPECT_EQ(asked_again(), 3u);
  EXPECT_THAT(engine.told, IsEmpty());
  std::filesystem::remove(starts);
}

// Whatever an earlier workspace did to the process, no pair of the next one pays for it.
TEST(ProcessEngine, AProcessThatTiresFailsNoPairOfTheNextWorkspace) {
  Engine tired({BAD_ENGINE, "tires"});
  const auto narrowphase = tired.registry.make_narrowphase(tired.name);
  const Row row;
  narrowphase->build(row.solids);
  for (int workspace = 0; workspace < 3; ++workspace) {
    const Answers answers = touchstone::ask(*narrowphase, std::span(row.pairs).first(1), row.poses,
                                            {.kind = QueryKind::distance});
    EXPECT_EQ(answers.status[0], PairStatus::separated) << workspace;
  }
  EXPECT_THAT(tired.told, ElementsAre(HasSubstr("in a process that had served before"),
                                      HasSubstr("in a process that had served before")));
}

// It ends as it takes the solids of the next workspace. The one started in its place has served nobody.
TEST(ProcessEngine, WhatReplacesAProcessThatServedHasNotServed) {
  Engine once({BAD_ENGINE, "once"});
  const auto narrowphase = once.registry.make_narrowphase(once.name);
  const std::vector<Hexahedron> more_than_a_pipe_holds(10000, Hexahedron::from_size({1, 1, 1}));
  const std::vector<Pose> poses(more_than_a_pipe_holds.size());
  const auto status_of = [&](const SolidPair& pair) {
    narrowphase->build(more_than_a_pipe_holds);
    return touchstone::ask(*narrowphase, {&pair, 1}, poses, {.kind = QueryKind::distance}).status[0];
  };
  EXPECT_EQ(status_of({0, 1}), PairStatus::separated);
  EXPECT_EQ(status_of({0, 31}), PairStatus::failed);
  EXPECT_THAT(once.told, ElementsAre(HasSubstr("on taking solids"), HasSubstr("on pair 0")));
}

TEST(ProcessEngine, PosesThatAreNotFiniteAreNotSent) {
  Engine bad({BAD_ENGINE, ""});
  Row row;
  row.poses[5].p.x() = kNaN;
  const Answers answers = bad.ask(row.solids, row.pairs, row.poses, {.kind = QueryKind::distance});
  EXPECT_EQ(answers.status[4], PairStatus::failed);
  EXPECT_EQ(std::count(answers.status.begin(), answers.status.end(), PairStatus::separated), 59);
  EXPECT_THAT(bad.told, IsEmpty());
}

// More pairs than one question takes, built anew while the process lives.
TEST(ProcessEngine, SameBitsAsInThisProcess) {
  Engine engine({ENGINE_C});
  const auto over_there = engine.registry.make_narrowphase("engine_c");
  const auto workspace = over_there->make_workspace();
  const auto here = make_native();
  for (const std::size_t count : {5000u, 300u}) {
    const auto set = measures::make_pair_family("random", 4, count);
    over_there->build(set.solids);
    here->build(set.solids);
    Answers got;
    const Query query{.kind = QueryKind::manifold, .max_points = 4};
    evaluate(*over_there, set.pairs, set.poses, query, *workspace, got);
    const Answers expected = ask(*here, set.pairs, set.poses, query);
    ASSERT_EQ(got.status, expected.status);
    for (std::size_t i = 0; i < count; ++i) {
      ASSERT_EQ(got.geometry[i].separation, expected.geometry[i].separation);
      ASSERT_EQ(got.geometry[i].point_count, expected.geometry[i].point_count);
      for (std::size_t k = 4 * i; k < 4 * i + static_cast<std::size_t>(got.geometry[i].point_count); ++k)
        ASSERT_EQ(got.points[k].p_B_W, expected.points[k].p_B_W);
    }
  }
  EXPECT_THAT(engine.told, IsEmpty());
}

#ifdef HAS_NUMPY
// Both formats give the same answers, and no wrong ones.
TEST(ProcessEngine, EnginesInPython) {
  Engine numpy({PYTHON, std::string(EXAMPLES) + "/spheres.py"}),
      lines({PYTHON, std::string(EXAMPLES) + "/spheres_lines.py"});
  auto set = measures::make_pair_family("random", 5, 700);
  for (Pose& X_WS : set.poses) X_WS.p *= 2.0;  // so that some spheres are apart
  const Answers by_numpy = numpy.ask(set.solids, set.pairs, set.poses, {});
  const Answers by_lines = lines.ask(set.solids, set.pairs, set.poses, {});
  EXPECT_EQ(by_numpy.status, by_lines.status);
  EXPECT_THAT(numpy.told, IsEmpty());
  EXPECT_THAT(lines.told, IsEmpty());
  const auto native = make_native();
  native->build(set.solids);
  const Answers right = ask(*native, set.pairs, set.poses, {});
  int apart = 0;
  for (std::size_t i = 0; i < set.pairs.size(); ++i) {
    if (by_numpy.status[i] != PairStatus::separated) continue;
    ++apart;
    EXPECT_EQ(right.status[i], PairStatus::separated) << i;
  }
  EXPECT_GT(apart, 0);
}
#endif

}  // namespace
}  // namespace touchstone
