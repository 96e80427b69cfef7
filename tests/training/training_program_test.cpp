// training_run as a user runs it: the files that it writes, who receives its poses, and what it refuses.

#include <gmock/gmock.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <string>

#include "touchstone/tests/support/listener.hpp"
#include "touchstone/tests/training/training_run_fixture.hpp"

namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using touchstone::Listener;
using namespace touchstone::test;

TEST_F(TrainingRun, RecordsAreTheSameOfTwoRuns) {
  if (run("--list").out.find("records, CSV") == std::string::npos)
    GTEST_SKIP() << "this build has no recorder";
  std::map<std::string, std::string> first;
  for (int i = 0; i < 2; ++i) {
    const fs::path records = folder_ / ("records" + std::to_string(i));
    ASSERT_EQ(run("--scene 06_gate 03_oru_rim --record " + records.string() + " --out " +
                  (folder_ / "run").string())
                  .code,
              0);
    std::size_t files = 0;
    for (const fs::directory_entry& entry : fs::directory_iterator(records)) {
      if (entry.path().extension() != ".csv") continue;
      const std::string content = read(entry.path());
      EXPECT_GT(content.size(), 1000u);
      ++files;
      if (i == 0)
        first[entry.path().filename()] = content;
      else
        EXPECT_TRUE(first.at(entry.path().filename()) == content) << entry.path();
    }
    EXPECT_EQ(files, 8u);
  }
}

/// How many lines of a kind the record has.
std::size_t lines_of(const fs::path& record, const std::string& kind) {
  std::ifstream stream(record);
  std::size_t count = 0;
  for (std::string line; std::getline(stream, line);) count += line.starts_with(kind + ",");
  return count;
}

TEST_F(TrainingRun, RecordHoldsEveryFrameOfEveryObject) {
  if (run("--list").out.find("records, CSV") == std::string::npos)
    GTEST_SKIP() << "this build has no recorder";
  const fs::path records = folder_ / "records";
  const json script = fly("02_jaws_offset", "--record " + records.string());
  for (const char* name : {"no_check", "figure_1", "figure_2", "contact_world_native"}) {
    const fs::path record = records / ("02_jaws_offset_" + std::string(name) + ".csv");
    EXPECT_EQ(lines_of(record, "frame"), 201u) << name;
    EXPECT_EQ(lines_of(record, "pose"), 3u * 201u) << name;
    EXPECT_EQ(lines_of(record, "end"), 1u) << name;
    EXPECT_EQ(lines_of(record, "lost"), 0u) << name;
  }
  const json output = ours(script)["outputs"][0];
  EXPECT_EQ(output["receiver"], "record");
  EXPECT_EQ(output["delivered_frames"], 201);
  EXPECT_EQ(output["dropped_frames"], 0);
}

TEST_F(TrainingRun, AnimationsAreMadeFromTheRecords) {
  if (run("--list").out.find("glTF") == std::string::npos) GTEST_SKIP() << "this build has no gltf";
  const fs::path records = folder_ / "records", animations = folder_ / "animations";
  fly("06_gate", "--record " + records.string() + " --gltf " + animations.string());
  const json gltf = json::parse(read(animations / "06_gate_contact_world_native.gltf"));
  EXPECT_EQ(gltf["asset"]["version"], "2.0");
  std::set<std::string> nodes;
  for (const json& node : gltf["nodes"])
    if (node.contains("name")) nodes.insert(node["name"].get<std::string>());
  for (const char* name : {"tip", "oru", "gate"}) EXPECT_TRUE(nodes.contains(name)) << name;
  EXPECT_EQ(gltf["animations"].size(), 1u);
  EXPECT_EQ(run("--scene 5 --gltf " + animations.string()).code, 2);  // from records only
}

/// Returns the poses and events of a flight without its times.
json without_times(json method) {
  for (const char* key : {"frame_us", "frame_cpu_us", "outputs"}) method.erase(key);
  return method;
}

TEST_F(TrainingRun, MissingReceiversNeitherDelayNorLoseTheRun) {
  if (run("--list").out.find("records, CSV") == std::string::npos)
    GTEST_SKIP() << "this build has no recorder";
  if (run("--list").out.find("CIGI 3.3") == std::string::npos) GTEST_SKIP() << "this build has no CIGI";
  const json plain = fly("02_jaws_offset");
  // A disk that is full from the start, and an image generator that is not there.
  const fs::path records = folder_ / "records";
  fs::create_directories(records);
  for (const char* name : {"no_check", "figure_1", "figure_2", "contact_world_native"})
    fs::create_symlink("/dev/full", records / ("02_jaws_offset_" + std::string(name) + ".csv"));
  const std::uint16_t nobody = Listener().port();
  const auto start = std::chrono::steady_clock::now();
  const json alone =
      fly("02_jaws_offset", "--record " + records.string() + " --cigi 127.0.0.1:" + std::to_string(nobody));
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
  for (std::size_t i = 0; i < plain["methods"].size(); ++i)
    EXPECT_EQ(without_times(alone["methods"][i]), without_times(plain["methods"][i]));
  const json outputs = ours(alone)["outputs"];
  ASSERT_EQ(outputs.size(), 2u);
  EXPECT_EQ(outputs[0]["dropped_frames"], 201);
  EXPECT_GT(outputs[0]["errors"], 0);
  EXPECT_EQ(outputs[1]["offered_frames"], 201);
  EXPECT_GT(outputs[1]["errors"], 0);  // the system says that nobody listens
  // The script's 4 s in real time, four records' patience of 1 s at most, and room for a busy machine:
  // a wait of a tenth of a second a frame would take 20 s.
  EXPECT_GE(elapsed.count(), 3.9);
  EXPECT_LE(elapsed.count(), 15.0);
}

TEST_F(TrainingRun, ImageGeneratorIsSentEveryFrame) {
  if (run("--list").out.find("CIGI 3.3") == std::string::npos) GTEST_SKIP() << "this build has no CIGI";
  Listener listener;
  const json script = fly("05_plates", "--cigi 127.0.0.1:" + std::to_string(listener.port()));
  int count = 0;
  while (const auto datagram = listener.receive(0)) {
    ASSERT_GE(datagram->size(), 3u);
    EXPECT_EQ((*datagram)[0], std::byte{1});   // IG Control comes first
    EXPECT_EQ((*datagram)[1], std::byte{24});  // bytes
    EXPECT_EQ((*datagram)[2], std::byte{3});   // CIGI 3
    ++count;
  }
  EXPECT_EQ(count, 6);  // the start and five frames
  EXPECT_EQ(ours(script)["outputs"][0]["delivered_frames"], 6);
}

TEST_F(TrainingRun, TableOfResultsHasAColumnForEachName) {
  fly("05_plates", "--backend all");
  std::ifstream stream(folder_ / "run/results.csv");
  std::string line;
  std::getline(stream, line);
  const auto commas = std::count(line.begin(), line.end(), ',');
  std::size_t rows = 0;
  while (std::getline(stream, line)) {
    if (line.find('"') == std::string::npos) {
      EXPECT_EQ(std::count(line.begin(), line.end(), ','), commas) << line;
    }
    ++rows;
  }
  EXPECT_GE(rows, 4u);
}

TEST_F(TrainingRun, ScenesAreChosenByNumber) {
  const Outcome outcome = run("--scene 5 07 --out " + (folder_ / "run").string());
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  std::set<std::string> names;
  const json results = json::parse(read(folder_ / "run/results.json"));
  for (const json& script : results["scripts"]) names.insert(script["script"].get<std::string>());
  EXPECT_EQ(names,
            (std::set<std::string>{"05_bar", "05_plates", "07_contained_solid", "07_contained_walls"}));
  EXPECT_THAT(outcome.out, HasSubstr("05_plates"));
  EXPECT_TRUE(fs::exists(folder_ / "run/plots/05_plates.svg"));
}

TEST_F(TrainingRun, SaysWhatIsWrongWithItsInput) {
  const std::string out = " --out " + (folder_ / "run").string();
  const auto expect = [&](const std::string& arguments, const std::string& reason) {
    expect_refusal(arguments + out, {reason});
    EXPECT_FALSE(fs::exists(folder_ / "run"));
  };
  expect("--scene 11", "no script flies it");
  expect("--scene 5 --backend magic", "magic");
  expect("--rate 5", "not within 10 and 1000 Hz");
  expect("--rate", "--rate");
  expect("--scene 5 --cigi localhost", "no HOST:PORT");
  expect("--scene 5 --cigi localhost:99999", "no HOST:PORT");
  expect("--scene 5 --record /dev/null/x", "--record /dev/null/x: ");
  const fs::path bad = write("bad.yaml", "name: x\nscene: {file: nowhere.yaml}\nhands: []\n");
  expect("--scene " + bad.string(), bad.string() + ":2: ");
  const std::string scenes = TOUCHSTONE_SCENES;
  const fs::path arm = write("arm.yaml", "name: x\nscene: {file: " + scenes +
                                             "/tunnelling_plates.yaml}\nhands:\n  - arm: {model: ssrms, "
                                             "link: tip, joints: [1, 2], pose: {}}\n"
                                             "    rates: [{time: 0}]\n");
  expect("--scene " + arm.string(), "2 joint values for 7 joints");
  expect("--scene " + scenes + "/../station/scenes/walk_off.yaml",
         "an arm that walks is flown by the station");
}

TEST_F(TrainingRun, NothingOfAnybodyElsesIsReplaced) {
  expect_files_of_others_are_kept("--scene 05_plates --out ",
                                  {"results.json", "results.csv", "plots/05_plates.svg"});
}

TEST_F(TrainingRun, ARecordReplacesNoFileThatIsNotOfAnEarlierRun) {
  if (run("--list").out.find("records, CSV") == std::string::npos)
    GTEST_SKIP() << "this build has no recorder";
  const std::string arguments =
      "--scene 05_plates --record " + (folder_ / "records").string() + " --out " + (folder_ / "run").string();
  for (int turn = 0; turn < 2; ++turn) EXPECT_EQ(run(arguments).code, 0);
  write("records/05_plates_no_check.csv", "mine");
  expect_refusal(arguments, {"05_plates_no_check.csv has changed since an earlier run wrote it"});
  EXPECT_EQ(read(folder_ / "records/05_plates_no_check.csv"), "mine");
}

TEST_F(TrainingRun, AnInterruptLeavesAPartialReportOfWhatIsFlown) {
  const fs::path report = folder_ / "run";
  std::size_t partial = 0;
  for (const int delay : {300, 1100, 2300}) {
    const auto [outcome, seconds] =
        run_until("--backend all --out " + report.string(), std::chrono::milliseconds(delay), SIGINT);
    EXPECT_EQ(outcome.code, 130) << outcome.err;
    EXPECT_LT(seconds, 1.0);
    if (!fs::exists(report / "results.json")) continue;
    ++partial;
    const json results = json::parse(read(report / "results.json"));
    EXPECT_EQ(results["partial"], true);
    EXPECT_EQ(results["not_measured"].back(), "10_figure_1_unloaded");
    EXPECT_GE(results["scripts"].size(), 1u);
  }
  EXPECT_GT(partial, 0u);
}

TEST_F(TrainingRun, AScriptOfMoreFramesThanThereIsRoomForIsRefusedByFile) {
  const std::string scenes = TOUCHSTONE_SCENES;
  const fs::path script = write(
      "long.yaml", "name: x\nscene: {file: " + scenes +
                       "/tunnelling_plates.yaml}\nduration: 1.0e+9\nhands:\n  - object: payload\n    rates: "
                       "[{time: 0}]\n");
  expect_refusal("--scene 5 " + script.string() + " --out " + (folder_ / "run").string(),
                 {script.string() + ": ", "shorten the duration"});
  EXPECT_FALSE(fs::exists(folder_ / "run"));
}

TEST_F(TrainingRun, HelpsAndLists) {
  EXPECT_THAT(run("--help").out, HasSubstr("--rate"));
  const Outcome list = run("--list");
  EXPECT_EQ(list.code, 0);
  EXPECT_THAT(list.out, HasSubstr("10_figure_1_unloaded"));
  EXPECT_THAT(list.out, HasSubstr("native"));
  for (const char* option : {"--record", "--gltf", "--cigi"}) EXPECT_THAT(list.out, HasSubstr(option));
}

}  // namespace
