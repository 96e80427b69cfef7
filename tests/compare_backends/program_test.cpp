#include <fcntl.h>
#include <gmock/gmock.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>

extern char** environ;

// The program as a user runs it.

namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::StartsWith;

class Program : public ::testing::Test {
 protected:
  Program() {
    std::string name = (fs::temp_directory_path() / "compare_test.XXXXXX").string();
    folder_ = mkdtemp(name.data());
  }
  ~Program() override { fs::remove_all(folder_); }

  struct Outcome {
    int code;
    std::string out, err;
  };
  Outcome run(const std::string& arguments) const {
    const fs::path out = folder_ / "out", err = folder_ / "err";
    const std::string command =
        std::string(COMPARE_BACKENDS) + " " + arguments + " >" + out.string() + " 2>" + err.string();
    const int status = std::system(command.c_str());
    Outcome outcome{WEXITSTATUS(status), read(out), read(err)};
    fs::remove(out);
    fs::remove(err);
    return outcome;
  }
  static std::string read(const fs::path& path) {
    std::ifstream stream(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
  }
  fs::path write(const std::string& name, const std::string& content) const {
    std::ofstream(folder_ / name) << content;
    return folder_ / name;
  }
  std::string report() const { return " --output " + (folder_ / "report").string() + " "; }

  fs::path folder_;
};

constexpr const char* kSmall = "--count 30 --repetitions 1 --no-broadphase --families random touching";

TEST_F(Program, BadInputIsOneLineExitCode2AndNoReport) {
  const std::string broken_json = write("broken.json", "[{\"id\": ").string();
  const std::string broken_yaml = write("broken.yaml", "name: x\nobjects: [").string();
  for (const std::string& arguments : std::vector<std::string>{
           "--backend nothing", "--families nothing", "--max-error -1", "--max-error nan", "--count 0",
           "--query depth", "--bogus", "--scene /no/such.yaml", "--pairs /no/such.json", "--case nothing:1",
           "--case random:x", "--pairs " + broken_json, "--scene " + broken_yaml,
           "--backend native native"}) {
    const Outcome outcome = run(arguments + report() + kSmall);
    EXPECT_EQ(outcome.code, 2) << arguments;
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1)
        << arguments << ": " << outcome.err;
    EXPECT_THAT(outcome.err, StartsWith("compare_backends: ")) << arguments;
    EXPECT_FALSE(fs::exists(folder_ / "report")) << arguments;
  }
}

TEST_F(Program, AFolderOfOtherThingsIsNotReplaced) {
  write("mine.txt", "keep");
  const Outcome outcome = run(std::string(kSmall) + " --output " + folder_.string());
  EXPECT_EQ(outcome.code, 2);
  EXPECT_EQ(read(folder_ / "mine.txt"), "keep");
}

TEST_F(Program, WritesAReportAndReplacesIt) {
  for (int turn = 0; turn < 2; ++turn) {
    const Outcome outcome = run(std::string(kSmall) + report() + "--max-error 1e-6");
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    const auto json = nlohmann::json::parse(read(folder_ / "report/results.json"));
    EXPECT_EQ(json["schema"], "touchstone.compare_backends/1");
    EXPECT_EQ(json["pair_sets"].size(), 2u);
    EXPECT_FALSE(json["machine"]["cpu"].get<std::string>().empty());
    for (const char* file : {"results.csv", "report.html"})
      EXPECT_TRUE(fs::exists(folder_ / "report" / file)) << file;
    if (json["measured_against_exact"]) {
      EXPECT_TRUE(fs::exists(folder_ / "report/figures/random_distance.svg"));
      EXPECT_THAT(outcome.out, HasSubstr(json["verdicts"][1]["sentence"].get<std::string>()));
    }
    EXPECT_EQ(std::distance(fs::directory_iterator(folder_), {}), 1)
        << "something was left beside the report";
  }
}

TEST_F(Program, AnInterruptLeavesNoReport) {
  const std::string output = (folder_ / "report").string();
  std::string arguments[] = {COMPARE_BACKENDS, "--count", "200000", "--no-broadphase", "--output", output};
  std::vector<char*> argv;
  for (std::string& argument : arguments) argv.push_back(argument.data());
  argv.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
  pid_t process = 0;
  ASSERT_EQ(posix_spawn(&process, COMPARE_BACKENDS, &actions, nullptr, argv.data(), environ), 0);
  posix_spawn_file_actions_destroy(&actions);
  std::this_thread::sleep_for(std::chrono::milliseconds(700));
  kill(process, SIGINT);
  int status = 0;
  waitpid(process, &status, 0);
  EXPECT_EQ(WEXITSTATUS(status), 130);
  EXPECT_TRUE(fs::is_empty(folder_));
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

#ifdef TOUCHSTONE_HAS_SCENE_FILES

constexpr const char* kPairs = R"([
{"id": "apart, by 1", "shapes": [{"type": "box", "size": [1,1,1]}, {"type": "box", "size": [1,1,1]}],
 "poses": [{"position": [0,0,0], "quaternion_wxyz": [1,0,0,0]}, {"position": [2,0,0], "quaternion_wxyz": [1,0,0,0]}]},
{"id": "flat", "shapes": [{"type": "box", "size": [1,1,0]}, {"type": "box", "size": [1,1,1]}],
 "poses": [{"position": [0,0,0], "quaternion_wxyz": [1,0,0,0]}, {"position": [2,0,0], "quaternion_wxyz": [1,0,0,0]}]}
])";

TEST_F(Program, AnswersTheUsersPairs) {
  const std::string file = write("cases.json", kPairs).string();
  const Outcome outcome = run("--families none --no-broadphase --repetitions 1 --pairs " + file + report());
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const auto json = nlohmann::json::parse(read(folder_ / "report/answers.json"));
  ASSERT_EQ(json["cases"].size(), 2u);
  EXPECT_EQ(json["cases"][0]["id"], "apart, by 1");
  EXPECT_EQ(json["cases"][0]["answers"][0]["backend"], "native");
  EXPECT_EQ(json["cases"][0]["answers"][0]["status"], "separated");
  EXPECT_EQ(json["cases"][0]["answers"][0]["separation"], 1.0);
  EXPECT_EQ(json["cases"][0]["answers"][0]["normal"], nlohmann::json({1.0, 0.0, 0.0}));
  EXPECT_EQ(json["cases"][1]["status"], "invalid");
  EXPECT_NE(json["cases"][1]["reason"], "");
  EXPECT_THAT(read(folder_ / "report/answers.csv"), HasSubstr("\"apart, by 1\",native,separated,,1"));
  EXPECT_THAT(run("--case 'apart, by 1' --pairs " + file).out, HasSubstr("native\n    overlap: separated"));
  EXPECT_EQ(run("--case flat --pairs " + file).code, 2);
}

TEST_F(Program, StepsASceneWithAnyBackend) {
  for (const std::string backend : {"native", "edge_face"}) {
    const Outcome outcome = run("--families none --no-broadphase --repetitions 1 --backend " + backend +
                                " --scene " SCENES "/elbow_into_lab.yaml" + report());
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    const auto json = nlohmann::json::parse(read(folder_ / "report/results.json"));
    const auto& scene = json["scenes"][0];
    EXPECT_EQ(scene["backends"][0]["backend"], backend);
    // Closed form: contact at 2.401282 s; the next frame at 50 Hz is at 2.42 s.
    EXPECT_NEAR(scene["backends"][0]["first_contact_s"].get<double>(), 2.42, 1e-9);
    if (json["measured_against_exact"]) {
      EXPECT_NEAR(scene["exact_first_contact_s"].get<double>(), 2.42, 1e-9);
      EXPECT_EQ(scene["backends"][0]["missed_frames"], 0);
    }
  }
}

#endif

}  // namespace
