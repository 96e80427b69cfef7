#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <regex>
#include <set>
#include <sstream>

#include "touchstone/examples/compare_backends/results/schema_text.hpp"
#include "touchstone/examples/program/terminal/text_table.hpp"
#include "touchstone/tests/compare_backends/program_fixture.hpp"

// The files that the program writes, held against each other.

namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::StartsWith;

class ReportFiles : public touchstone::test::Program {};

// As much of dynamics_run's results.json as the page reads.
constexpr const char* kDynamics =
    R"({"program": "dynamics_run", "scenes": [{"scene": "push", "build_on": "native",
  "runs": [{"backend": "native", "stopped": null, "answers": [{"holds": true}, {"holds": false}], "deepest_m": 1.25e-9,
  "pose_error_m": 0.0, "unexplained_momentum_ns": 3.5e-15, "energy_made_j": 1e-12, "energy_scale_j": 4.0,
  "step_us": {"median": 12.5, "p99_9": 30.5}, "allocations": 2, "misses": ["final pose"]},
  {"backend": "edge_face", "not_run": "finds no manifolds"}]}]})";

#ifdef TOUCHSTONE_HAS_SCENE_FILES

// Tokens that stand for numbers: "1 234.5", "1.2e-16"; not those inside names.
std::vector<std::string> numbers_in(const std::string& text) {
  static const std::regex number(R"((^|[^\w.:])([0-9]+( [0-9]{3})*(\.[0-9]+)?(e[+-][0-9]+)?)(?![\w.]))");
  std::vector<std::string> found;
  for (std::sregex_iterator it(text.begin(), text.end(), number), end; it != end; ++it)
    found.push_back((*it)[2]);
  return found;
}

// Every way in which the page may write a number of the JSON.
void allow(const nlohmann::json& json, std::set<std::string>& allowed) {
  using namespace touchstone::comparison;
  if (json.is_structured()) {
    for (const auto& each : json) allow(each, allowed);
  } else if (json.is_string()) {
    for (const std::string& number : numbers_in(json.get<std::string>())) allowed.insert(number);
  } else if (json.is_number()) {
    const double value = std::abs(json.get<double>());
    for (const char* format : {"{:.3g}", "{:.6g}", "{:.3f}", "{:.4f}", "{}"})
      allowed.insert(fmt::format(fmt::runtime(format), value));
    allowed.insert(format_ns(value));
    allowed.insert(format_error(value));
    if (value < 1e15) allowed.insert(format_count(static_cast<std::size_t>(value)));
  }
}

// The text of every element of this name; code, which holds case ids and commands, left out.
std::vector<std::string> texts_of(const std::string& page, const std::string& tag) {
  static const std::regex code("<code>[^<]*</code>"), markup("<[^>]*>");
  std::vector<std::string> texts;
  for (std::size_t at = 0; (at = page.find("<" + tag, at)) != std::string::npos;) {
    const std::size_t begin = page.find('>', at) + 1, end = page.find("</" + tag + ">", begin);
    std::string text = page.substr(begin, end - begin);
    at = end;
    if (text.find("<code>") != std::string::npos && text.find("<details>") == std::string::npos &&
        tag == "td")
      continue;
    text = std::regex_replace(text, code, " ");
    texts.push_back(std::regex_replace(text, markup, " "));
  }
  return texts;
}

std::size_t expect_numbers(const std::string& text, const std::set<std::string>& allowed) {
  const std::vector<std::string> numbers = numbers_in(text);
  for (const std::string& number : numbers)
    EXPECT_TRUE(allowed.contains(number)) << number << " in: " << text;
  return numbers.size();
}

TEST_F(ReportFiles, EveryNumberOfATableOrAMarkOfThePageIsInTheJson) {
  const Outcome outcome =
      run("--quick --count 60 --families random touching near_parallel --max-error 1e-7 --scene " SCENES
          "/oru_insertion.yaml --dynamics " +
          write("dynamics.json", kDynamics).string() + report());
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const auto json = nlohmann::json::parse(read(folder_ / "report/results.json"));
  std::set<std::string> allowed;
  allow(json, allowed);
  const std::string page = read(folder_ / "report/report.html");
  EXPECT_LT(page.size(), 2'000'000u);
  std::size_t in_cells = 0, in_marks = 0;
  for (const std::string& text : texts_of(page, "td")) in_cells += expect_numbers(text, allowed);
  // Tooltips of marks, sentences, captions; a timeline's frames are positions in frame_outcomes.
  for (const char* tag : {"title", "strong", "figcaption"}) {
    for (const std::string& text : texts_of(page, tag))
      if (text.find(": frames ") == std::string::npos) in_marks += expect_numbers(text, allowed);
  }
  EXPECT_GT(in_cells, 1000u);
  EXPECT_GT(in_marks, 100u);
}

void collect_keys(const nlohmann::json& json, const std::string& parent, bool at_root,
                  std::set<std::string>& keys) {
  static const std::set<std::string> kNamed = {"libraries", "definitions",  "parameters",        "queries",
                                               "errors",    "pareto_front", "least_that_serves", "texts"};
  const bool names = kNamed.contains(parent) || (parent == "consistency" && at_root);
  if (json.is_object()) {
    for (const auto& [key, value] : json.items()) {
      if (!names) keys.insert(key);
      collect_keys(value, names ? "" : key, parent.empty() && !names && at_root, keys);
    }
  } else if (json.is_array()) {
    for (const auto& each : json) collect_keys(each, "", false, keys);
  }
}

TEST_F(ReportFiles, TheSchemaNamesEveryKeyAndNoOther) {
  const Outcome outcome =
      run("--quick --count 60 --backend native edge_face --families random touching near_parallel "
          "--max-error 1e-7 --scene " SCENES "/grapple_approach.yaml --dynamics " +
          write("dynamics.json", kDynamics).string() + report());
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const auto json = nlohmann::json::parse(read(folder_ / "report/results.json"));
  if (!json["measured_against_exact"]) GTEST_SKIP() << "a build without exact has fewer keys";
  std::set<std::string> keys, described;
  collect_keys(json, "", true, keys);
  for (const auto& entry : touchstone::comparison::kJsonSchema) {
    std::istringstream words{std::string(entry.keys)};
    for (std::string key; words >> key;) described.insert(key);
  }
  for (const std::string& key : keys) EXPECT_TRUE(described.contains(key)) << key << " is in no schema";
  // Runs on a corpus have its name and hash, by which the benchmark's site knows them, and paths: Bench
  // tests. A merge names the shards of other machines: Shards tests.
  for (const char* sometimes :
       {"failure",    "gap",   "gaps",  "what",  "why",     "corpus", "sha256",  "shards_elsewhere",
        "k",          "n",     "paths", "poses", "meets",   "open",   "unseen",  "path",
        "first_pose", "right", "later", "late",  "earlier", "check",  "impacts", "answered",
        "stops_at_s", "early", "sweep"})
    described.erase(sometimes);
  for (const std::string& key : described) EXPECT_TRUE(keys.contains(key)) << key << " is in no JSON";
  std::istringstream csv(read(folder_ / "report/results.csv"));
  std::string header;
  std::getline(csv, header);
  EXPECT_THAT(header, StartsWith("set,backend,query,cases,missed"));
}

TEST_F(ReportFiles, ATimelineHasAsManyMergedFramesAsWereMissed) {
  const Outcome outcome =
      run("--families none --no-broadphase --quick --scene " SCENES "/contained_solid.yaml" + report());
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const auto json = nlohmann::json::parse(read(folder_ / "report/results.json"));
  if (!json["measured_against_exact"]) GTEST_SKIP() << "no truth";
  std::size_t merged = 0;
  for (const auto& backend : json["scenes"][0]["backends"]) {
    const std::string outcomes = backend["frame_outcomes"];
    EXPECT_EQ(outcomes.size(), json["scenes"][0]["frames"].get<std::size_t>());
    const auto missed = static_cast<std::size_t>(std::count(outcomes.begin(), outcomes.end(), 'm'));
    EXPECT_EQ(missed, backend["missed_frames"].get<std::size_t>()) << backend["backend"];
    merged += missed;
  }
  EXPECT_GT(merged, 0u) << "edge_face does not see what is contained";
  EXPECT_TRUE(fs::exists(folder_ / "report/figures/scene_contained_solid.svg"));
}

TEST_F(ReportFiles, DynamicsStandOnThePageOrAreAGapThatSaysHowToGetThem) {
  const std::string small =
      "--quick --count 20 --families random --no-broadphase --backend native edge_face ";
  ASSERT_EQ(run(small + report()).code, 0);
  EXPECT_THAT(read(folder_ / "report/report.html"),
              HasSubstr("Missing: dynamics drift against contact error"));
  ASSERT_EQ(run(small + report() + "--dynamics " + write("dynamics.json", kDynamics).string()).code, 0);
  const std::string page = read(folder_ / "report/report.html");
  EXPECT_THAT(page, ::testing::Not(HasSubstr("Missing: dynamics drift")));
  EXPECT_THAT(page, HasSubstr("native, push: 3.5e-15"));  // the mark's title
  EXPECT_THAT(page, HasSubstr("finds no manifolds"));
  EXPECT_TRUE(fs::exists(folder_ / "report/figures/dynamics_drift.svg"));
  for (const char* bad : {"{}", "[", R"({"program": "training_run"})", R"({"program": "dynamics_run"})"}) {
    expect_refusal(small + report() + "--dynamics " + write("bad.json", bad).string(), {"bad.json"});
  }
}

#endif

TEST_F(ReportFiles, DecidesAgainFromAFinishedRun) {
  ASSERT_EQ(run("--quick --count 20 --families random --no-broadphase --max-error 1e-9" + report()).code, 0);
  const std::string results = (folder_ / "report/results.json").string();
  const auto json = nlohmann::json::parse(read(results));
  if (!json["measured_against_exact"]) GTEST_SKIP() << "no truth, no verdict";
  for (const auto& verdict : json["verdicts"]) {
    const Outcome said = run("decide " + results + " --max-error 1e-9 --query " +
                             verdict["choice"]["query"].get<std::string>());
    EXPECT_EQ(said.code, 0) << said.err;
    EXPECT_THAT(
        said.out,
        StartsWith("\n" + touchstone::program::wrapped(verdict["sentence"].get<std::string>()) + "\n"));
  }
  const std::string no_results = write("no.json", R"({"schema": "other"})").string();
  for (const std::string& bad : std::vector<std::string>{
           "decide", "decide " + results, "decide " + results + " --max-error -1",
           "decide " + results + " --max-error nan", "decide /no/such.json --max-error 1",
           "decide " + no_results + " --max-error 1"}) {
    expect_refusal(bad, {});
  }
}

TEST_F(ReportFiles, WhatIsNoReportIsRefusedInOurWords) {
  const std::string good = R"({"schema": "touchstone.compare_backends/1"})";
  const std::string dynamics = R"({"program": "dynamics_run", "scenes": 3})";
  for (const auto& [text, reason] : std::map<std::string, std::string>{
           {"{\"schema\": ", "is no JSON, at line 1, column "},
           {"\n\n[1, 2", "is no JSON, at line 3, column "},
           {"{}", "has no 'schema'"},
           {"[]", "holds a value of another kind than it should"},
           {R"({"schema": 3})", "holds a value of another kind than it should"},
           {good, "has no '"},
           {dynamics, "has no 'schema'"}}) {
    const std::string file = write("bad.json", text).string();
    for (const std::string& command : {"diff " + file + " " + file, "decide " + file + " --max-error 1e-6",
                                       "--quick --count 5 --dynamics " + file + report()}) {
      const Outcome refused = run(command);
      EXPECT_EQ(refused.code, 2) << command << text;
      EXPECT_THAT(refused.err, ::testing::Not(HasSubstr("json.exception"))) << command;
      EXPECT_EQ(std::count(refused.err.begin(), refused.err.end(), '\n'), 1) << refused.err;
      if (!command.starts_with("--")) {
        EXPECT_THAT(refused.err, HasSubstr(reason)) << command << text;
      }
    }
  }
}

TEST_F(ReportFiles, DiffsTwoRuns) {
  const std::string small =
      "--quick --count 20 --families random --no-broadphase --backend native edge_face ";
  ASSERT_EQ(run(small + "--output " + (folder_ / "old").string()).code, 0);
  ASSERT_EQ(run(small + "--seed 2 --output " + (folder_ / "new").string()).code, 0);
  const std::string files =
      (folder_ / "old/results.json").string() + " " + (folder_ / "new/results.json").string();
  const Outcome outcome = run("diff " + files);
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("seed differs: 1 -> 2"));
  EXPECT_THAT(outcome.out, HasSubstr("0 rows resolved"));
  for (const char* bad : {"diff", "diff /no/such.json /no/such.json"}) {
    expect_refusal(bad, {});
  }
}

}  // namespace
