#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>
#include <vector>

#include "touchstone/examples/program/terminal/text_table.hpp"
#include "touchstone/tests/compare_backends/program_fixture.hpp"

// The program on a user's pairs and scenes.

namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::StartsWith;
using touchstone::test::kSmall;
using touchstone::test::Program;

constexpr const char* kPairs = R"([
{"id": "apart, by 1", "shapes": [{"type": "box", "size": [1,1,1]}, {"type": "box", "size": [1,1,1]}],
 "poses": [{"position": [0,0,0], "quaternion_wxyz": [1,0,0,0]}, {"position": [2,0,0], "quaternion_wxyz": [1,0,0,0]}]},
{"id": "flat", "shapes": [{"type": "box", "size": [1,1,0]}, {"type": "box", "size": [1,1,1]}],
 "poses": [{"position": [0,0,0], "quaternion_wxyz": [1,0,0,0]}, {"position": [2,0,0], "quaternion_wxyz": [1,0,0,0]}]}
])";

// "Contacts only, 0.1 mm, one in a thousand may be off: what is fastest for this file of pairs?"
TEST_F(Program, OneCommandChoosesForTheContactsOfAFileOfPairs) {
  // Four of the six pairs are in contact.
  std::string cases;
  for (int i = 0; i < 6; ++i) {
    cases += fmt::format(
        R"({}{{"id": "k{}", "shapes": [{{"type": "box", "size": [1,1,1]}}, {{"type": "box", "size": [1,1,1]}}],
  "poses": ["identity", {{"position": [0.1, 0.2, {}], "quaternion_wxyz": [1,0,0,0]}}]}})",
        i == 0 ? "" : ",", i, i < 4 ? 0.999 : 1.5);
  }
  const std::string file = write("mine.json", "[" + cases + "]").string();
  const std::string asked = " --contacts-only --max-error 1e-4 --share 1e-3";
  const Outcome outcome = run("--quick --pairs " + file + asked + report());
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const auto json = nlohmann::json::parse(read(folder_ / "report/results.json"));
  if (!json["measured_against_exact"]) GTEST_SKIP() << "no truth, no verdict";
  const auto& verdict = json["verdicts"][0];
  // The verdict counts contacts alone, and says so.
  EXPECT_FALSE(verdict["fastest"].is_null()) << verdict;
  EXPECT_EQ(verdict["cases"], 4);
  EXPECT_EQ(verdict["of_cases"], 6);
  const auto sentence = verdict["sentence"].get<std::string>();
  EXPECT_THAT(outcome.out, HasSubstr(touchstone::program::wrapped(sentence)));
  EXPECT_THAT(sentence, HasSubstr("(contacts only)"));
  EXPECT_THAT(sentence, HasSubstr("of 4 of 6 cases"));
  for (const auto& candidate : verdict["candidates"]) EXPECT_EQ(candidate["cases"], 4);

  // Classes, sets and limits of which nothing is left are errors.
  const std::string results = (folder_ / "report/results.json").string();
  const Outcome empty = run("decide " + results + " --max-error 1 --classes deep");
  EXPECT_EQ(empty.code, 2);
  EXPECT_EQ(empty.err, "compare_backends: decide: " + results +
                           ": nothing is compared: none of 6 cases is in what was chosen (deep only)\n");
  const Outcome nothing = run("--quick --pairs " + file + " --max-error 1 --classes deep" + report());
  EXPECT_EQ(nothing.code, 2);
  EXPECT_THAT(nothing.err,
              HasSubstr("nothing is compared: none of 6 cases is in what was chosen (deep only)\n"));
  EXPECT_THAT(run("decide " + results + " --max-error 1 --of random").err,
              HasSubstr("--of: no set 'random'; there are pairs\n"));
  for (const char* bad : {"--share 1", "--share -1", "--share nan", "--within 0", "--apart-up-to -1",
                          "--deadline 0", "--min-coverage 0.5", "--query manifold --min-coverage 0.9999",
                          "--classes far", "--contacts-only --classes apart"}) {
    expect_refusal("decide " + results + " --max-error 1 " + bad, {});
  }
}

TEST_F(Program, AnswersTheUsersPairs) {
  const std::string file = write("cases.json", kPairs).string();
  const Outcome outcome = run("--repetitions 1 --max-error 1e-6 --pairs " + file + report());
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

TEST_F(Program, CasesOfOnesOwnDecideAlone) {
  const std::string file = write("cases.json", kPairs).string();
  const auto sets_of = [&](const std::string& options) {
    const Outcome outcome = run("--quick --repetitions 1 --max-error 1e-6 " + options + report());
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    const auto json = nlohmann::json::parse(read(folder_ / "report/results.json"));
    EXPECT_EQ(json["broadphases"].size(), 0u);
    std::vector<std::string> names;
    for (const auto& set : json["pair_sets"]) names.push_back(set["name"]);
    for (const auto& scene : json["scenes"]) names.push_back(scene["name"]);
    return names;
  };
  EXPECT_THAT(sets_of("--pairs " + file), testing::ElementsAre("pairs"));
  EXPECT_THAT(sets_of("--scene " SCENES "/contained_solid.yaml"), testing::ElementsAre("contained_solid"));
  EXPECT_THAT(sets_of("--families random --count 30 --no-broadphase --pairs " + file),
              testing::UnorderedElementsAre("random", "pairs"));
}

TEST_F(Program, NothingComparedIsAnError) {
  const std::string flat = R"([{"id": "flat", "shapes": [{"type": "box", "size": [1,1,0]},
 {"type": "box", "size": [1,1,1]}], "poses": [{"position": [0,0,0], "quaternion_wxyz": [1,0,0,0]},
 {"position": [2,0,0], "quaternion_wxyz": [1,0,0,0]}]}])";
  expect_refusal("--pairs " + write("flat.json", flat).string() + report(),
                 {"flat.json: none of its 1 cases is a pair of solids"});
  EXPECT_THAT(run("--pairs " + write("empty.json", "[]").string() + report()).err, HasSubstr("empty.json"));
  expect_refusal("--capture " + write("cases.json", kPairs).string() + report(),
                 {"no case has an engine's answer"});
}

// A scene of one object `thing` and one `other`; what stands in `objects` decides.
std::string scene(const std::string& thing, const std::string& other = "other") {
  return "name: x\nunits: {length: m, angle: deg}\nframe_rate: 50\ncontact_gap: 1.0e-9\npolicy: cue\n"
         "duration: 1\nobjects:\n  - name: thing\n    " +
         thing + "\n  - name: " + other +
         "\n    pose: {position: [3, 0, 0]}\n    hexahedra:\n      - {name: body, box: {size: [1, 1, 1]}}\n";
}

TEST_F(Program, ASceneOfMoreFramesThanThereIsRoomForIsRefusedByFile) {
  const std::string box = "hexahedra:\n      - {name: body, box: {size: [1, 1, 1]}}";
  for (const char* duration : {"1.0e+9", "1.0e+5", "1.0e+13"}) {
    std::string content = scene(box);
    content.replace(content.find("duration: 1"), 11, std::string("duration: ") + duration);
    const std::string file = write("long.yaml", content).string();
    expect_refusal("--scene " + file + report() + kSmall, {file, "duration"});
  }
}

TEST_F(Program, ABadSceneIsRefusedByFileLineAndObject) {
  // Each content, the line of its fault, and the name in it that the message has.
  const std::string box = "hexahedra:\n      - {name: body, box: {size: [1, 1, 1]}}";
  const struct {
    const char* what;
    std::string content;
    int line;
    const char* named;
  } cases[] = {
      {"a side that is not finite", scene("hexahedra:\n      - {name: body, box: {size: [1, .nan, 1]}}"), 10,
       "thing"},
      {"a side that is infinite", scene("hexahedra:\n      - {name: body, box: {size: [1, .inf, 1]}}"), 10,
       "thing"},
      {"a flat box", scene("hexahedra:\n      - {name: body, box: {size: [1, 0, 1]}}"), 10, "thing"},
      {"a pose that is not finite", scene("pose: {position: [0, .nan, 0]}\n    " + box), 9, "thing"},
      {"a matrix that is no rotation",
       scene("pose: {matrix: [[1, 0, 0, 0], [0, 2, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]}\n    " + box), 9,
       "thing"},
      {"a reflection",
       scene("pose: {matrix: [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, -1, 0], [0, 0, 0, 1]]}\n    " + box), 9,
       "thing"},
      {"an object's name twice", scene(box, "thing"), 11, "thing"},
      {"a hexahedron's name twice", scene(box + "\n      - {name: body, box: {size: [1, 1, 1]}}"), 11,
       "body"},
      {"an unknown key", scene("colour: red\n    " + box), 9, "colour"},
  };
  // No report begins.
  for (const auto& each : cases) {
    const std::string file = write("scene.yaml", each.content).string();
    expect_refusal("--scene " + file + report() + kSmall,
                   {file + ":" + std::to_string(each.line) + ":", each.named});
    EXPECT_FALSE(fs::exists(folder_ / "report")) << each.what;
  }
}

TEST_F(Program, BadCasesOfAPairFileAreInvalidAndTheRunGoesOn) {
  // One good pair, and three whose numbers are no shape, rotation or direction.
  const std::string box = R"({"type": "box", "size": [1, 1, 1]})";
  const auto pair = [&](const std::string& id, const std::string& shape, const std::string& pose) {
    return "{\"id\": \"" + id + "\", \"shapes\": [" + shape + ", " + box + "], \"poses\": [" + pose +
           R"(, {"position": [2, 0, 0], "quaternion_wxyz": [1, 0, 0, 0]}]})";
  };
  const std::string here = R"({"position": [0, 0, 0], "quaternion_wxyz": [1, 0, 0, 0]})";
  const std::string stretched = R"({"matrix": [[1,0,0,0],[0,2,0,0],[0,0,1,0],[0,0,0,1]]})";
  const std::string cases =
      pair("good", box, here) + "," + pair("no rotation", box, stretched) + "," +
      pair("too large", R"({"type": "box", "size": [1, 1e999, 1]})", here) + "," +
      pair("no direction", box, R"({"position": [0,0,0], "quaternion_wxyz": [0,0,0,0]})");
  // The run goes on, and says of each bad one why it is none.
  const std::string file = write("cases.json", "[" + cases + "]").string();
  const Outcome outcome = run("--families none --no-broadphase --repetitions 1 --pairs " + file + report());
  if (outcome.code == 0) {
    const auto json = nlohmann::json::parse(read(folder_ / "report/answers.json"));
    ASSERT_EQ(json["cases"].size(), 4u);
    EXPECT_NE(json["cases"][0].value("status", ""), "invalid");
    for (int i = 1; i < 4; ++i) {
      EXPECT_EQ(json["cases"][i]["status"], "invalid") << json["cases"][i]["id"];
      EXPECT_NE(json["cases"][i]["reason"], "") << json["cases"][i]["id"];
    }
  } else {
    ADD_FAILURE() << outcome.err;
  }
  // Two pairs of one name are an error of the file.
  const std::string twice =
      write("twice.json", "[" + pair("a", box, here) + "," + pair("a", box, here) + "]").string();
  fs::remove_all(folder_ / "report");
  expect_refusal("--families none --no-broadphase --pairs " + twice + report(), {"twice.json"});
  EXPECT_FALSE(fs::exists(folder_ / "report"));
}

TEST_F(Program, SwappingTheBackendOfASceneIsOneWord) {
  const std::string list = run("--list").out;
  for (const std::string backend : {"native", "edge_face", "bullet", "ode"}) {
    if (list.find("\n  " + backend + " ") == std::string::npos) continue;  // not in this build
    if (list.find(backend + "  ") == std::string::npos || list.find(backend + ", ") != std::string::npos)
      continue;
    const Outcome outcome =
        run("--families none --no-broadphase --repetitions 1 --scene " SCENES "/elbow_into_lab.yaml" +
            report() + "--backend " + backend);
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    const auto json = nlohmann::json::parse(read(folder_ / "report/results.json"));
    const auto& scene = json["scenes"][0];
    ASSERT_EQ(scene["backends"].size(), 1u);
    EXPECT_EQ(scene["backends"][0]["backend"], backend);
    // Closed form: contact at 2.401282 s; the next frame at 50 Hz is at 2.42 s. Bullet is unsure of one
    // frame.
    EXPECT_NEAR(scene["backends"][0]["first_contact_s"].get<double>(), 2.42,
                backend == "bullet" ? 0.021 : 1e-9);
    if (json["measured_against_exact"]) {
      EXPECT_THAT(outcome.out, HasSubstr("the least that serves"));
      EXPECT_NEAR(scene["exact_first_contact_s"].get<double>(), 2.42, 1e-9);
      EXPECT_EQ(scene["backends"][0]["missed_frames"], 0);
    }
  }
}

TEST_F(Program, AFolderWhoseNameIsNoUtf8GetsItsReport) {
  const fs::path folder = folder_ / "caf\xE9";
  const Outcome outcome =
      run("--families random --count 20 --repetitions 1 --quick --no-broadphase --backend native --output '" +
          folder.string() + "'");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const auto json = nlohmann::json::parse(read(folder / "results.json"));
  EXPECT_THAT(json.dump(), HasSubstr("caf\xEF\xBF\xBD"));  // U+FFFD
}

TEST_F(Program, SetsASceneParameter) {
  const Outcome outcome = run("--families none --no-broadphase --quick --backend native --scene " SCENES
                              "/oru_insertion.yaml " SCENES
                              "/elbow_into_lab.yaml --set oru_insertion:offset=0.5 "
                              "rate=8" +
                              report());
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const auto json = nlohmann::json::parse(read(folder_ / "report/results.json"));
  EXPECT_EQ(json["scenes"][0]["parameters"]["offset"], 0.5);
  EXPECT_EQ(json["scenes"][1]["parameters"]["rate"], 8.0);
}

TEST_F(Program, EveryCommandOfTheGalleryReplaysItsCase) {
  const Outcome outcome = run("--count 40 --quick --no-broadphase --seed 7 --families random --scene " SCENES
                              "/contained_solid.yaml" +
                              report());
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const auto json = nlohmann::json::parse(read(folder_ / "report/results.json"));
  if (!json["measured_against_exact"]) GTEST_SKIP() << "no truth";
  bool of_a_scene = false;
  for (const auto& each : json["gallery"]) {
    const std::string command = each["replay"], program = "examples/run ";
    ASSERT_THAT(command, StartsWith(program));
    const Outcome replayed = run(command.substr(program.size()));
    EXPECT_EQ(replayed.code, 0) << command << replayed.err;
    EXPECT_THAT(replayed.out, StartsWith(each["case"].get<std::string>() + " (seed "));
    EXPECT_THAT(replayed.out,
                HasSubstr(fmt::format("separation {}", each["exact"]["separation_m"].get<double>())));
    of_a_scene |= each["set"] == "contained_solid";
  }
  EXPECT_TRUE(of_a_scene) << "edge_face does not see what is contained";
}

// Judged by the true bore, no number of facets serves by being the last: the 64 are off by more than 1e-5 m.
TEST_F(Program, TheLeastThatServesIsTheCheapestRowOfAll) {
  const Outcome outcome =
      run("--families none --no-broadphase --quick --backend native edge_face --scene " SCENES
          "/grapple_approach.yaml --set offset=0.09 --max-error 1e-5" +
          report());
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const auto json = nlohmann::json::parse(read(folder_ / "report/results.json"));
  if (!json["measured_against_exact"]) GTEST_SKIP() << "no truth";
  // The frames and the reference.
  const auto& trade = json["scenes"][0]["trade"];
  EXPECT_EQ(trade["frames_near_contact"], 5);
  EXPECT_LE(trade["frames"].get<int>(), 10);
  EXPECT_GT(trade["frames_that_differ_in_class"].get<int>(), 0);
  EXPECT_TRUE(trade["round"].get<bool>());
  EXPECT_LT(trade["reference_width_m"].get<double>(), 1.1e-12);
  // The least that serves is the cheapest row within the error, for each query and step.
  const auto cheapest = [&](const std::string& query, double allowed) {
    int best = -1;
    for (int i = 0; i < static_cast<int>(trade["rows"].size()); ++i) {
      const auto& row = trade["rows"][i];
      if (row["query"] != query || row["error_m"] == "inf" || row["error_m"].get<double>() > allowed)
        continue;
      if (best < 0 || row["frame_ns"].get<double>() < trade["rows"][best]["frame_ns"].get<double>()) best = i;
    }
    return best;
  };
  for (const auto& [query, least] : trade["least_that_serves"].items()) {
    EXPECT_EQ(least.is_null() ? -1 : least["row"].get<int>(), cheapest(query, 1e-5)) << query;
    if (least.is_null()) continue;
    EXPECT_THAT(least["thin"].get<std::string>(), HasSubstr("too few frames")) << query;
  }
  EXPECT_TRUE(trade["least_that_serves"]["distance"].is_null());
  for (const auto& step : trade["steps"])
    EXPECT_EQ(step["row"].get<int>(), cheapest(step["query"], step["allowed_m"].get<double>()));
  // Facets bound the error of geometry, and what it serves.
  std::size_t of_64 = 0, selected = 0;
  for (const auto& row : trade["rows"]) {
    selected += row["selected"].get<bool>();
    if (row["model"] != "64 facets" || row["query"] != "distance" || row["backend"] != "native") continue;
    ++of_64;
    EXPECT_GT(row["geometry_error_m"].get<double>(), 1e-5);
    EXPECT_LE(row["geometry_error_m"].get<double>(),
              0.208 * (1 / std::cos(std::numbers::pi / 64) - 1) + 1e-15);
    EXPECT_FALSE(row["serves"].get<bool>());
  }
  EXPECT_EQ(of_64, 2u) << "all pairs, and those needed";
  EXPECT_GT(selected, 0u);
  EXPECT_THAT(read(folder_ / "report/report.html"), HasSubstr("No recommendation: too few frames"));
  EXPECT_THAT(read(folder_ / "report/least_that_serves.md"), HasSubstr("the true round part"));
}

TEST_F(Program, EveryBundledSceneHasItsLeastThatServes) {
  std::string scenes;
  std::size_t count = 0;
  for (const auto& entry : fs::directory_iterator(SCENES)) {
    if (entry.path().extension() != ".yaml") continue;
    scenes += " " + entry.path().string();
    ++count;
  }
  const Outcome outcome = run(
      "--families none --no-broadphase --quick --repetitions 1 --backend native --scene" + scenes + report());
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const auto json = nlohmann::json::parse(read(folder_ / "report/results.json"));
  if (!json["measured_against_exact"]) GTEST_SKIP() << "no truth";
  ASSERT_EQ(json["scenes"].size(), count);
  const std::string page = read(folder_ / "report/least_that_serves.md");
  for (const auto& scene : json["scenes"]) {
    const auto& trade = scene["trade"];
    EXPECT_THAT(page, HasSubstr("\n## " + scene["name"].get<std::string>() + "\n"));
    EXPECT_FALSE(trade["least_that_serves"]["overlap"].is_null()) << scene["name"];
    for (const auto& row : trade["rows"]) {
      // The scene as written is compared with itself. One with round parts has facets in its place.
      if (row["model"] == "as written") {
        EXPECT_EQ(row["geometry_error_m"], 0.0) << scene["name"];
      }
      // A solid box where six walls were: the cube 257.5 mm off the nearest, less half its side, is in
      // contact.
      if (scene["name"] == "contained_walls" && row["model"] == "cover, level 0" &&
          row["query"] == "overlap") {
        EXPECT_NEAR(row["geometry_error_m"].get<double>(), 0.2475, 1e-12);
      }
    }
  }
}

}  // namespace
