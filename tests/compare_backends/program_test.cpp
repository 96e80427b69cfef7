#include <gmock/gmock.h>
#include <signal.h>

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <vector>

#include "touchstone/examples/program/terminal/text_table.hpp"
#include "touchstone/tests/compare_backends/program_fixture.hpp"

// The program as a user runs it.

namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::StartsWith;
using touchstone::test::kSmall;
using touchstone::test::Program;

TEST_F(Program, TheFiguresOnThePageAndInTheTerminalAreThoseOfTheJson) {
  const Outcome outcome = run("--count 40 --repetitions 1 --quick --output " + (folder_ / "report").string());
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const auto json = nlohmann::json::parse(read(folder_ / "report/results.json"));
  const std::string page = read(folder_ / "report/report.html");
  std::size_t times = 0;
  // Times of all sets.
  for (const auto& set : json["pair_sets"]) {
    for (const auto& backend : set["backends"]) {
      for (const char* query : {"overlap", "distance", "manifold"}) {
        for (const char* mode : {"single", "batch", "raw"}) {
          const auto& timing = backend["queries"][query][mode];
          if (timing.is_null()) continue;
          const std::string cell = touchstone::program::format_ns(timing["median_ns"].get<double>());
          EXPECT_THAT(page, HasSubstr("<td>" + cell + "</td>"));
          if (timing["median_ns"].get<double>() < 9995) {
            EXPECT_THAT(outcome.out, HasSubstr(" " + cell));
          }
          EXPECT_GT(timing["pairs_a_block"], 0);
          ++times;
        }
      }
    }
  }
  EXPECT_GT(times, 60u);
  // Wrong answers of the rankings.
  for (const auto& ranking : json["rankings"]) {
    for (const auto& standing : ranking["standings"]) {
      const std::size_t missed = standing["wrong"]["missed"].get<std::size_t>();
      if (missed == 0) continue;
      EXPECT_THAT(page, HasSubstr(touchstone::program::format_count(missed) + " missed</span>"));
    }
  }
  // The terminal's lines fit.
  std::istringstream lines(outcome.out);
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("g++ ") || line.starts_with("clang ")) continue;  // the compiler's flags
    EXPECT_LE(line.size(), 120u) << line;
  }
}

TEST_F(Program, TablesComeAsTheyAreMeasuredOnceEachWithTheShareOfTheWhole) {
  const fs::path both = folder_ / "both";
  const std::string command =
      std::string(COMPARE_BACKENDS) + " " + kSmall + report() + " >" + both.string() + " 2>&1";
  ASSERT_EQ(std::system(command.c_str()), 0);
  const std::string text = read(both);
  const std::size_t first = text.find("\nrandom: "), second = text.find("\ntouching: ");
  ASSERT_NE(first, std::string::npos) << text;
  ASSERT_NE(second, std::string::npos) << text;
  EXPECT_EQ(text.find("\nrandom: ", first + 1), std::string::npos);
  EXPECT_EQ(text.find("\ntouching: ", second + 1), std::string::npos);
  // Three parts: two families, then the threads.
  EXPECT_LT(text.find("part 1 of 3: random: exact answers"), first) << text;
  const std::size_t next = text.find("part 2 of 3, about ");
  EXPECT_GT(next, first);
  EXPECT_LT(next, second);
  EXPECT_THAT(text.substr(next), HasSubstr(" left: touching: backends"));
}

TEST_F(Program, BadInputIsOneLineExitCode2AndNoReport) {
  // Files with faults.
  const std::string broken_json = write("broken.json", "[{\"id\": ").string();
  const std::string broken_yaml = write("broken.yaml", "name: x\nobjects: [").string();
  const std::string insertion = " --scene " SCENES "/oru_insertion.yaml";
  fs::create_directory(folder_ / "other");
  const std::string other_insertion =
      write("other/oru_insertion.yaml", read(SCENES "/oru_insertion.yaml")).string();
  // Options alone, and options that the scene does not go with.
  for (const std::string& arguments :
       std::vector<std::string>{"--backend nothing",
                                "--families nothing",
                                "--max-error -1",
                                "--max-error nan",
                                "--count 0",
                                "--query depth",
                                "--bogus",
                                "--scene /no/such.yaml",
                                "--scene /dev/zero",
                                "--pairs /dev/zero",
                                "--pairs /no/such.json",
                                "--case nothing:1",
                                "--case random:x",
                                "--pairs " + broken_json,
                                "--scene " + broken_yaml,
                                "--backend native native",
                                "--families random touching random",
                                "--scene " + other_insertion + insertion.substr(8),
                                "--set offset=1",
                                "--set offset" + insertion,
                                "--set =1" + insertion,
                                "--set offset=nan" + insertion,
                                "--set no_such=1" + insertion,
                                "--set oru_insertion:no_such=1" + insertion,
                                "--set other:offset=1" + insertion}) {
    expect_refusal(arguments + report() + kSmall, {"compare_backends: "});
    EXPECT_FALSE(fs::exists(folder_ / "report")) << arguments;
  }
}

TEST_F(Program, AFolderThatCannotBeMadeIsRefusedBeforeAnythingIsMeasured) {
  // As root /proc may be written to, and yet no folder can be made there. A measurement of that many pairs
  // takes minutes.
  const Outcome outcome =
      run("--count 2000000 --no-broadphase --families random --output /proc/no_such/report");
  EXPECT_EQ(outcome.code, 2);
  EXPECT_THAT(outcome.err, HasSubstr("--output /proc/no_such/report"));
  EXPECT_THAT(outcome.err, ::testing::Not(HasSubstr("exact answers")));
}

TEST_F(Program, TheReportedCommandCanBePasted) {
  const fs::path odd = folder_ / "it's; $(touch x)";
  const Outcome outcome =
      run(std::string(kSmall) + " --output \"" + (folder_ / "it's; \\$(touch x)").string() + "\"");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const auto json = nlohmann::json::parse(read(odd / "results.json"));
  EXPECT_THAT(json["command"].get<std::string>(), HasSubstr("it'\\''s; $(touch x)'"));
}

TEST_F(Program, AFolderOfOtherThingsIsWrittenToAndNothingOfItLost) {
  write("mine.txt", "keep");
  fs::create_directories(folder_ / "thesis");
  write("thesis/chapter.txt", "keep too");
  for (int turn = 0; turn < 2; ++turn) {
    const Outcome outcome = run(std::string(kSmall) + " --output " + folder_.string());
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_EQ(read(folder_ / "mine.txt"), "keep");
    EXPECT_EQ(read(folder_ / "thesis/chapter.txt"), "keep too");
  }
}

TEST_F(Program, EveryFileThatItWritesIsLookedForBeforeTheRun) {
  const std::string insertion = " --scene " SCENES "/oru_insertion.yaml --quick";
  const std::string all = "--count 30 --repetitions 1 --families random touching";
  ASSERT_EQ(run(all + insertion + report()).code, 0);
  std::size_t looked_at = 0;
  const auto manifest = nlohmann::json::parse(read(folder_ / "report/touchstone_report.json"));
  for (const auto& file : manifest["files"]) {
    const std::string name = file["name"];
    fs::remove_all(folder_ / "other");
    fs::create_directories((folder_ / "other" / name).parent_path());
    write("other/" + name, "mine");
    // Enough pairs that a run which starts is not over in a minute.
    expect_refusal("--count 1000000 --families random touching" + insertion + " --output " +
                       (folder_ / "other").string(),
                   {"other/" + name + " is there and no earlier run wrote it"});
    if (HasFailure()) return;
    ++looked_at;
  }
  EXPECT_GT(looked_at, 30u);
}

TEST_F(Program, TheWorkingFolderIsAnOutput) {
  const std::string there = "cd " + folder_.string() + " && ";
  write("notes.md", "mine");
  const std::string command = there + COMPARE_BACKENDS + " " + kSmall + " --output . >/dev/null 2>&1";
  for (int turn = 0; turn < 2; ++turn) EXPECT_EQ(WEXITSTATUS(std::system(command.c_str())), 0);
  EXPECT_EQ(read(folder_ / "notes.md"), "mine");
  EXPECT_TRUE(fs::exists(folder_ / "report.html"));
}

TEST_F(Program, WritesAReportAndReplacesIt) {
  for (int turn = 0; turn < 2; ++turn) {
    const Outcome outcome = run(std::string(kSmall) + report() + "--max-error 1e-6");
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    const auto json = nlohmann::json::parse(read(folder_ / "report/results.json"));
    EXPECT_EQ(json["schema"], "touchstone.compare_backends/2");
    EXPECT_EQ(json["pair_sets"].size(), 2u);
    EXPECT_FALSE(json["machine"]["cpu"].get<std::string>().empty());
    EXPECT_THAT(json["machine"]["instruction_set"].get<std::string>(),
                ::testing::AnyOf("generic", "avx2", "avx512"));
    EXPECT_EQ(json["partial"], false);
    for (const char* file : {"results.csv", "report.html"})
      EXPECT_TRUE(fs::exists(folder_ / "report" / file)) << file;
    if (json["measured_against_exact"]) {
      EXPECT_TRUE(fs::exists(folder_ / "report/figures/random_distance.svg"));
      EXPECT_THAT(
          outcome.out,
          HasSubstr(touchstone::program::wrapped(json["verdicts"][0]["sentence"].get<std::string>())));
    }
    EXPECT_EQ(std::distance(fs::directory_iterator(folder_), {}), 1)
        << "something was left beside the report";
  }
}

TEST_F(Program, AnInterruptBeforeAnythingIsMeasuredLeavesNoReport) {
  const auto [outcome, seconds] =
      run_until("--count 200000 --no-broadphase" + report(), std::chrono::milliseconds(700), SIGINT);
  EXPECT_EQ(outcome.code, 130);
  EXPECT_LT(seconds, 1.0);
  EXPECT_THAT(outcome.err, HasSubstr("interrupted: no report was written, as nothing was measured yet\n"));
  EXPECT_FALSE(fs::exists(folder_ / "report"));
}

TEST_F(Program, AnInterruptAtAnyTimeIsAnsweredWithinASecondByAPartialReport) {
  const std::string run_of_minutes = "--count 400 --repetitions 1 --threads 1" + report();
  std::size_t partial = 0;
  std::vector<int> delays = {100, 350, 800, 1700, 3100, 4900, 7300};  // [ms]
  for (std::size_t i = 0; i < delays.size(); ++i) {
    const int delay = delays[i];
    // Where others keep the machine busy the first part takes longer.
    if (i + 1 == delays.size() && partial == 0 && delay < 60000) delays.push_back(2 * delay);
    const int signal = delay % 200 == 100 ? SIGINT : SIGTERM;
    const auto [outcome, seconds] = run_until(run_of_minutes, std::chrono::milliseconds(delay), signal);
    EXPECT_EQ(outcome.code, 128 + signal) << outcome.err;
    EXPECT_LT(seconds, 1.0) << "after " << delay << " ms";
    if (!fs::exists(folder_ / "report/results.json")) continue;
    ++partial;
    EXPECT_THAT(outcome.err, HasSubstr("interrupted: what was measured so far is a partial report: "));
    const auto json = nlohmann::json::parse(read(folder_ / "report/results.json"));
    EXPECT_EQ(json["partial"], true);
    EXPECT_EQ(json["not_measured"].back(), "threads");
    EXPECT_GE(json["pair_sets"].size(), 1u);
    EXPECT_THAT(read(folder_ / "report/report.html"),
                HasSubstr("This report is partial: the run ended early."));
    std::istringstream csv(read(folder_ / "report/results.csv"));
    std::string line;
    std::getline(csv, line);
    EXPECT_TRUE(line.ends_with(",partial"));
    while (std::getline(csv, line)) EXPECT_TRUE(line.ends_with(",1")) << line;
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder_))
      EXPECT_THAT(entry.path().string(), ::testing::Not(HasSubstr(".touchstone-")))
          << "a temporary file is left";
  }
  EXPECT_GT(partial, 0u);
}

TEST_F(Program, AnInterruptLeavesNeitherWorkerNorTemporaryFiles) {
  if (run("--list").out.find("bullet_single ") == std::string::npos)
    GTEST_SKIP() << "this build has no worker";
  fs::create_directory(folder_ / "tmp");
  // The worker repeats for minutes.
  const std::string command = "TMPDIR=" + (folder_ / "tmp").string() +
                              " timeout --preserve-status -s INT 4 " COMPARE_BACKENDS
                              " --count 1000 --families random --backend bullet_single --repetitions 1000" +
                              report() + ">/dev/null 2>&1";
  EXPECT_EQ(WEXITSTATUS(std::system(command.c_str())), 130);
  EXPECT_TRUE(fs::is_empty(folder_ / "tmp"));
  EXPECT_EQ(WEXITSTATUS(std::system(("pgrep -f " + (folder_ / "[t]mp").string() + " >/dev/null").c_str())),
            1);
}

TEST_F(Program, AFullDiskIsNoSuccess) {
  EXPECT_NE(
      WEXITSTATUS(std::system((std::string(COMPARE_BACKENDS) + " --list >/dev/full 2>/dev/null").c_str())),
      0);
  const std::string command =
      std::string(COMPARE_BACKENDS) + " " + kSmall + report() + ">/dev/full 2>" + (folder_ / "err").string();
  EXPECT_NE(WEXITSTATUS(std::system(command.c_str())), 0);
  EXPECT_THAT(read(folder_ / "err"), HasSubstr("compare_backends: what was printed could not be written\n"));
  EXPECT_TRUE(fs::exists(folder_ / "report/results.json"));
}

TEST_F(Program, SaysItsVersion) {
  const Outcome outcome = run("--version");
  EXPECT_EQ(outcome.code, 0);
  EXPECT_THAT(outcome.out, ::testing::MatchesRegex("compare_backends [0-9]+\\.[0-9]+\\.[0-9]+\n"));
}

TEST_F(Program, AnInstructionSetThatNobodyKnowsIsAnError) {
  const std::string ran =
      " " + std::string(COMPARE_BACKENDS) + " --list >/dev/null 2>" + (folder_ / "err").string();
  EXPECT_EQ(WEXITSTATUS(std::system(("TOUCHSTONE_ISA=avx3" + ran).c_str())), 2);
  EXPECT_THAT(read(folder_ / "err"),
              HasSubstr("TOUCHSTONE_ISA=avx3: there is no such instruction set; known: generic"));
  for (const char* known : {"", "generic", "avx2", "avx512"})
    EXPECT_EQ(WEXITSTATUS(std::system(("TOUCHSTONE_ISA=" + std::string(known) + ran).c_str())), 0) << known;
}

TEST_F(Program, ReplaysACase) {
  const Outcome outcome = run("--case near_parallel:5 --backend native");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, StartsWith("near_parallel:5 (seed 1)\n"));
  EXPECT_THAT(outcome.out, HasSubstr("exact: "));
  EXPECT_THAT(outcome.out, HasSubstr("native\n    overlap: "));
  EXPECT_EQ(outcome.out, run("--case near_parallel:5 --backend native").out);
  EXPECT_NE(outcome.out, run("--case near_parallel:5 --backend native --seed 2").out);
}

TEST_F(Program, ListsWhatItHas) {
  const Outcome outcome = run("--list");
  EXPECT_EQ(outcome.code, 0);
  for (const char* name : {"native", "edge_face", "brute_force", "near_parallel"})
    EXPECT_THAT(outcome.out, HasSubstr(name));
}

TEST_F(Program, ThePaperStandsInEveryTable) {
  const Outcome outcome =
      run("--quick --count 20 --families random --backend native edge_face --max-error 1e-6 --query overlap" +
          report());
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  for (const char* row : {"\n  edge_face ", "\n    edge_face "}) EXPECT_THAT(outcome.out, HasSubstr(row));
  const auto json = nlohmann::json::parse(read(folder_ / "report/results.json"));
  std::size_t found = 0;
  for (const auto& broadphase : json["broadphases"]) {
    if (broadphase["broadphase"] != "edge_face") continue;
    ++found;
    EXPECT_EQ(broadphase["missed"], 0);
    EXPECT_GT(broadphase["true_pairs"], 100);
    EXPECT_FALSE(broadphase["with_overlap_ms"].is_null());
    if (!broadphase["allocations_per_frame"].is_null()) {
      EXPECT_DOUBLE_EQ(broadphase["allocations_per_frame"], broadphase["candidates_per_frame"]);
    }
  }
  EXPECT_GT(found, 0u);
  EXPECT_THAT(read(folder_ / "report/report.html"),
              HasSubstr("edge_face</code> is the paper's coarse check"));
}

TEST_F(Program, DecideAndDiffSayWhatIsPartial) {
  ASSERT_EQ(run(std::string(kSmall) + report()).code, 0);
  auto json = nlohmann::json::parse(read(folder_ / "report/results.json"));
  if (!json["measured_against_exact"]) GTEST_SKIP() << "no truth, no verdict";
  const std::string whole = (folder_ / "report/results.json").string();
  json["partial"] = true;
  json["not_measured"] = {"touching", "threads"};
  const std::string part = write("part.json", json.dump()).string();
  EXPECT_THAT(run("decide " + part + " --max-error 1").out,
              StartsWith(part + " is partial: the run ended early, without touching, threads\n"));
  EXPECT_THAT(run("diff " + whole + " " + part).out,
              StartsWith("NEW is partial: the run ended early, without touching, threads\n"));
  EXPECT_THAT(run("diff " + whole + " " + whole).out, ::testing::Not(HasSubstr("partial")));
}

}  // namespace
