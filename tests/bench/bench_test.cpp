#include <gmock/gmock.h>

#include <nlohmann/json.hpp>
#include <regex>
#include <string>

#include "touchstone/tests/support/program_test.hpp"

// The corpus and the site of the reference benchmark, as a user runs them.

namespace touchstone {
namespace {

using Json = nlohmann::json;
using testing::HasSubstr;
using testing::Not;

constexpr const char* kPlan =
    R"({"schema": "touchstone.corpus/1", "name": "small", "version": "0.1", "sets": [
  {"name": "containment", "description": "boxes in boxes", "from": {"family": "containment", "seed": 7, "count": 30}},
  {"name": "touching", "description": "flush <boxes>", "from": {"family": "touching", "seed": 7, "count": 30}},
  {"name": "own", "description": "of a file", "from": {"files": ["own.json"]}}]})";

constexpr const char* kOwn = R"([{"id": "a pair", "shapes": [{"type": "box", "size": [1, 1, 1]},
  {"type": "box", "size": [1, 1, 1]}], "poses": ["identity", {"position": [1.5, 0, 0], "quaternion_wxyz": [1, 0, 0, 0]}]}])";

class Bench : public ProgramTest {
 protected:
  Bench() : ProgramTest("") {
    write("own.json", kOwn);
    write("plan.json", kPlan);
  }

  std::string at(const std::string& name) const { return (folder_ / name).string(); }
  static std::string bench_command(const std::string& arguments) { return BENCH " " + arguments; }
  static std::string compare_command(const std::string& arguments) {
    return COMPARE_BACKENDS " --no-broadphase --repetitions 1 " + arguments;
  }
  Outcome bench(const std::string& arguments) const { return run(bench_command(arguments)); }
  Outcome compare(const std::string& arguments) const { return run(compare_command(arguments)); }
  void make_corpus() const {
    const Outcome made = bench("corpus " + at("corpus") + " --freeze --manifest " + at("plan.json"));
    ASSERT_EQ(made.code, 0) << made.err;
  }
  void measure(const std::string& backends, const std::string& name) const {
    const Outcome asked =
        compare("--corpus " + at("corpus") + " --backend " + backends + " --output " + at(name));
    ASSERT_EQ(asked.code, 0) << asked.err;
    std::filesystem::copy_file(folder_ / name / "results.json", folder_ / (name + ".json"));
  }
  void replace_in(const std::string& file, const std::string& from, const std::string& to) const {
    std::string text = read(folder_ / file);
    ASSERT_NE(text.find(from), std::string::npos) << text;
    write(file, text.replace(text.find(from), from.size(), to));
  }
};

// ---- the corpus

TEST_F(Bench, ACorpusIsTheSameEachTimeAndFrozen) {
  make_corpus();
  std::filesystem::copy_file(folder_ / "corpus" / "corpus.json", folder_ / "frozen.json");
  const Outcome again = bench("corpus " + at("again") + " --manifest " + at("frozen.json"));
  ASSERT_EQ(again.code, 0) << again.err;
  for (const char* name : {"corpus.json", "containment.json", "touching.truth.json", "own.truth.json"})
    EXPECT_EQ(read(folder_ / "again" / name), read(folder_ / "corpus" / name)) << name;
  EXPECT_THAT(read(folder_ / "corpus" / "own.truth.json"), HasSubstr(R"(["a pair","separated",0.5])"));

  replace_in("frozen.json", R"("seed": 7)", R"("seed": 8)");
  const Outcome other = bench("corpus " + at("other") + " --manifest " + at("frozen.json"));
  EXPECT_EQ(other.code, 2);
  EXPECT_THAT(other.err, HasSubstr("corpus: containment: this build makes other files"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "other" / "corpus.json"));
}

TEST_F(Bench, AChangedFileIsNamedBeforeAnythingIsMeasured) {
  make_corpus();
  replace_in("corpus/containment.json", "containment:0", "containment:O");
  expect_refusal(compare_command("--corpus " + at("corpus") + " --backend native --output " + at("report")),
                 {"containment.json: is not the file that the manifest names"});
}

TEST_F(Bench, AWrongTruthIsFound) {
  make_corpus();
  Json manifest = Json::parse(read(folder_ / "corpus" / "corpus.json"));
  write("corpus/own.truth.json", "[\n[\"a pair\",\"separated\",0.5000000000000001]\n]\n");
  // Its hash is made to fit, so that only `exact` can tell.
  const Outcome sum = run("sha256sum " + at("corpus/own.truth.json"));
  ASSERT_EQ(sum.code, 0);
  manifest["sets"][2]["truth_sha256"] = sum.out.substr(0, 64);
  write("corpus/corpus.json", manifest.dump());
  const Outcome asked = compare("--corpus " + at("corpus") + " --backend native --output " + at("report"));
  EXPECT_EQ(asked.code, 2);
  EXPECT_THAT(asked.err, HasSubstr("own: case 'a pair': the truth in the corpus is not what `exact` says"));
}

TEST_F(Bench, WhatIsNoCorpusIsRefused) {
  EXPECT_THAT(compare("--corpus " + at("nowhere")).err, HasSubstr("corpus.json"));
  make_corpus();
  EXPECT_THAT(compare("--corpus " + at("corpus") + " --families random").err,
              HasSubstr("brings its own sets"));
  write("corpus/corpus.json", "{}");
  EXPECT_THAT(compare("--corpus " + at("corpus")).err, HasSubstr("corpus.json: has no 'schema'"));
}

TEST(BundledCorpus, AVersionKeepsTheSetsOfTheOneBefore) {
  const auto sets = [](const char* name) {
    std::ifstream stream(std::string(MANIFESTS "/") + name);
    return Json::parse(stream).at("sets");
  };
  const Json first = sets("touchstone-bench-1.0.json"), second = sets("touchstone-bench-1.1.json"),
             third = sets("touchstone-bench-1.2.json");
  ASSERT_EQ(second.size(), first.size() + 2);
  for (std::size_t i = 0; i < first.size(); ++i) EXPECT_EQ(second[i], first[i]);
  ASSERT_EQ(third.size(), second.size() + 4);
  for (std::size_t i = 0; i < second.size(); ++i) EXPECT_EQ(third[i], second[i]);
}

// ---- captured pairs

#ifdef CAPTURE_PAIRS
TEST_F(Bench, PairsOfRunsAreCapturedTheSameEachTime) {
  const std::string runs = " --most 20 --scene " EXAMPLES "/scenes/elbow_into_lab.yaml --script " EXAMPLES
                           "/training_run/scripts/03_oru_tilted.yaml --dynamics " EXAMPLES
                           "/dynamics_run/scenes/sliding_stop.yaml";
  const Outcome made = run(CAPTURE_PAIRS " " + at("captured.json") + runs);
  ASSERT_EQ(made.code, 0) << made.err;
  const std::string text = read(folder_ / "captured.json");
  const Json pairs = Json::parse(text);
  EXPECT_EQ(pairs.size(), 60u);
  for (const char* stem : {"elbow_into_lab:pair-", "03_oru_tilted:pair-", "sliding_stop:pair-"})
    EXPECT_THAT(text, HasSubstr(stem));
  EXPECT_THAT(text, Not(HasSubstr("captured\"")));  // no engine's answers

  EXPECT_THAT(run(CAPTURE_PAIRS " " + at("captured.json") + runs).err, HasSubstr("captured.json: is there"));
  std::filesystem::rename(folder_ / "captured.json", folder_ / "first.json");
  ASSERT_EQ(run(CAPTURE_PAIRS " " + at("captured.json") + runs).code, 0);
  EXPECT_EQ(read(folder_ / "captured.json"), text);
  // A file that is no scene is named, and nothing is written.
  expect_refusal(CAPTURE_PAIRS " " + at("none.json") + " --most 5 --scene " + at("plan.json"), {"plan.json"});
  EXPECT_FALSE(std::filesystem::exists(folder_ / "none.json"));
}

TEST_F(Bench, WhatCannotBeCapturedIsNamedBeforeTheRuns) {
  // Neither scene is there: a run would report that first.
  expect_refusal(CAPTURE_PAIRS " " + at("pairs.json") + " --most 5 --scene a/one.yaml --dynamics b/one.yaml",
                 {"b/one.yaml: has the name of a/one.yaml"});
  expect_refusal(CAPTURE_PAIRS " " + at("no/pairs.json") + " --most 5 --scene a/one.yaml",
                 {"no/pairs.json: there is no folder"});
}
#endif

// ---- the site

TEST_F(Bench, EveryRedCellOpensItsCaseAndAReproduction) {
  // A site of results with wrong answers among them.
  make_corpus();
  measure("native edge_face", "ours");
  const Outcome made = bench("site " + at("site") + " " + at("ours.json") + " --corpus " + at("corpus"));
  ASSERT_EQ(made.code, 0) << made.err;
  // Each red cell's link leads to its case, with a picture and a way to see it again.
  const std::string index = read(folder_ / "site" / "index.html");
  const std::regex link("href='(cases/[^'#]*)#([^']*)'");
  int links = 0;
  for (auto at = std::sregex_iterator(index.begin(), index.end(), link); at != std::sregex_iterator(); ++at) {
    ++links;
    const std::string page = read(folder_ / "site" / (*at)[1].str());
    EXPECT_THAT(page, HasSubstr("<section id='" + (*at)[2].str() + "'>"));
    EXPECT_THAT(page, HasSubstr("<svg"));
    const std::string text = read(folder_ / "site" / "reproductions" / ((*at)[2].str() + ".md"));
    EXPECT_THAT(text, HasSubstr("The exact answer"));
    EXPECT_THAT(text, HasSubstr("penetrating, signed distance -"));
  }
  EXPECT_GE(links, 1);  // edge_face misses what is contained
  // The history says when, and by which version of ours.
  const Json ours = Json::parse(read(folder_ / "ours.json"));
  EXPECT_THAT(index.substr(index.find("<section id='history'>")),
              HasSubstr("<td>" + ours.at("date").get<std::string>() + ", touchstone " +
                        ours.at("version").get<std::string>() + "</td>"));
  // Names are escaped, raw results are copied, and pages ask nothing of other hosts.
  EXPECT_THAT(index, HasSubstr("href='cases/containment.html#containment_edge_face_overlap'"));
  EXPECT_THAT(index, HasSubstr("flush &lt;boxes&gt;"));
  EXPECT_EQ(read(folder_ / "site" / "raw" / "ours.json"), read(folder_ / "ours.json"));
  for (const char* request : {"http://", "https://", "src="}) {
    std::string page = index;
    for (std::size_t w; (w = page.find("http://www.w3.org/")) != std::string::npos;) page.erase(w, 18);
    EXPECT_THAT(page, Not(HasSubstr(request)));
  }
}

// As of solids that touch exactly.
void let_wrong_classes_cost_the_least(Json& json) {
  if (!json.is_structured()) return;
  for (auto& [key, value] : json.items()) {
    if (key == "cost_m") value = 5e-324;
    let_wrong_classes_cost_the_least(value);
  }
}

TEST_F(Bench, ACostOfAMissedTouchIsShownAsNone) {
  make_corpus();
  measure("native edge_face", "ours");
  Json results = Json::parse(read(folder_ / "ours.json"));
  let_wrong_classes_cost_the_least(results);
  write("ours.json", results.dump());
  ASSERT_EQ(bench("site " + at("site") + " " + at("ours.json") + " --corpus " + at("corpus")).code, 0);
  const std::string page = read(folder_ / "site/cases/containment.html");
  EXPECT_THAT(page, HasSubstr(", 0 m (0 S)<br>"));
  EXPECT_THAT(page, Not(HasSubstr("e-32")));
  const std::string text = read(folder_ / "site/reproductions/containment_edge_face_overlap.md");
  EXPECT_THAT(text, HasSubstr("is wrong by 0 m, 0 of the larger"));
}

TEST_F(Bench, AReproductionIsWrongAgain) {
  make_corpus();
  measure("native edge_face", "ours");
  ASSERT_EQ(bench("site " + at("site") + " " + at("ours.json") + " --corpus " + at("corpus")).code, 0);
  const std::string pair = at("site/reproductions/containment_edge_face_overlap.json");
  const std::string id = Json::parse(read(pair)).at(0).at("id");
  const Outcome asked = compare("--pairs " + pair + " --backend edge_face native --case '" + id + "'");
  ASSERT_EQ(asked.code, 0) << asked.err;
  EXPECT_THAT(asked.out, HasSubstr("exact: penetrating"));
  EXPECT_THAT(asked.out, HasSubstr("edge_face\n    overlap: separated"));
}

TEST_F(Bench, FilesMergeAndALaterOneOfAnEngineReplacesAnEarlierOne) {
  make_corpus();
  measure("native", "first");
  measure("edge_face", "second");
  std::filesystem::copy_file(folder_ / "second.json", folder_ / "third.json");
  replace_in("third.json", "\"name\": \"edge_face\",\n   \"description\": \"",
             "\"name\": \"edge_face\",\n   \"description\": \"2nd ");
  const std::string corpus = " --corpus " + at("corpus");
  ASSERT_EQ(bench("site " + at("site") + " " + at("first.json") + " " + at("second.json") + " " +
                  at("third.json") + corpus)
                .code,
            0);
  const std::string index = read(folder_ / "site" / "index.html");
  EXPECT_THAT(index, HasSubstr("title='2nd "));
  for (const char* raw : {"raw/first.json", "raw/second.json", "raw/third.json"})
    EXPECT_THAT(index, HasSubstr(raw));
  EXPECT_THAT(bench("site " + at("twice") + " " + at("first.json") + " " + at("first.json") + corpus).err,
              HasSubstr("another results file has that name"));
}

TEST_F(Bench, CorpusAndSiteDoNotTakeEachOthersFolders) {
  make_corpus();
  measure("native", "ours");
  expect_refusal(bench_command("site " + at("corpus") + " " + at("ours.json") + " --corpus " + at("corpus")),
                 {"holds a corpus; name another folder"});
  EXPECT_TRUE(std::filesystem::exists(folder_ / "corpus" / "containment.json"));
  ASSERT_EQ(bench("site " + at("site") + " " + at("ours.json") + " --corpus " + at("corpus")).code, 0);
  expect_refusal(bench_command("corpus " + at("site") + " --freeze --manifest " + at("plan.json")),
                 {"holds a site; name another folder"});
  EXPECT_TRUE(std::filesystem::exists(folder_ / "site" / "raw" / "ours.json"));
}

TEST_F(Bench, NamesOfEnginesDoNotLeadOutOfTheSite) {
  make_corpus();
  measure("edge_face", "ours");
  const std::string whole = read(folder_ / "ours.json");
  // A zero byte would end a file's name early.
  for (const std::string name : {"/../../../victim", "\\u0000", "a\\nb", "<script>alert(1)</script>", ""}) {
    std::string text = whole;
    for (std::size_t w = 0; (w = text.find("\"edge_face\"", w)) != std::string::npos; w += name.size())
      text.replace(w, 11, '"' + name + '"');
    write("ours.json", text);
    expect_refusal(bench_command("site " + at("site") + " " + at("ours.json") + " --corpus " + at("corpus")),
                   {"ours.json: engine '", "its name is not up to 64 letters"});
    EXPECT_FALSE(std::filesystem::exists(folder_ / "site"));
  }
}

TEST_F(Bench, FiguresThatAreNoneAreRefused) {
  make_corpus();
  measure("native", "ours");
  const Json whole = Json::parse(read(folder_ / "ours.json"));
  const std::string query = "/pair_sets/0/backends/0/queries/distance";
  const std::tuple<std::string, Json, const char*> changes[] = {
      {query + "/single/median_ns", -1, "'median_ns' is no time"},
      {query + "/single/p99_ns", "inf", "'p99_ns' is no time"},
      {query + "/cost_over_S/worst", nullptr, "'worst' is no cost"},
      {query + "/cost_over_S/worst", -1, "'worst' is no cost"},
      {query + "/cost_over_S/cases", 0, "'cost_over_S' has no cases"},
      {query + "/cost_over_S/cases", 31, "has costs of more pairs than the corpus's set 'containment' has"},
      {query + "/cost_over_S/cases", -1, "'cases' is no count"},
      {query + "/single/blocks", -1, "'blocks' is no count"},
      {query + "/wrong/missed", -1, "'missed' is no count"},
      {query + "/wrong/failed", std::uint64_t{1} << 63, "more wrong and unsupported answers than 'cases'"},
      {"/backends/1", whole.at("backends").at(0), "has the backend 'native' twice"}};
  for (const auto& [place, value, refusal] : changes) {
    Json changed = whole;
    if (const Json::json_pointer where(place); place == "/backends/1")
      changed.at("backends").push_back(value);
    else
      changed.at(where) = value;
    write("ours.json", changed.dump());
    expect_refusal(bench_command("site " + at("site") + " " + at("ours.json") + " --corpus " + at("corpus")),
                   {"ours.json: ", refusal});
  }
  EXPECT_FALSE(std::filesystem::exists(folder_ / "site"));
}

TEST_F(Bench, ResultsWithoutSomeOfTheCorpusAreRefused) {
  make_corpus();
  measure("native", "ours");
  const std::string site =
      bench_command("site " + at("site") + " " + at("ours.json") + " --corpus " + at("corpus"));
  const Json whole = Json::parse(read(folder_ / "ours.json"));

  Json cut = whole;
  cut.at("pair_sets").erase(1);
  write("ours.json", cut.dump());
  expect_refusal(site, {"ours.json: 'native' lacks the corpus's set 'touching'"});

  cut = whole;
  cut.at("pair_sets").at(1).at("backends").clear();
  write("ours.json", cut.dump());
  expect_refusal(site, {"ours.json: 'native' lacks the corpus's set 'touching'"});

  cut = whole;
  cut.at("pair_sets").at(1).at("backends").at(0).at("queries").at("distance").at("wrong").at("cases") = 29;
  write("ours.json", cut.dump());
  expect_refusal(site, {"ours.json: 'native' has 29 pairs of the corpus's set 'touching', which has 30"});
  EXPECT_FALSE(std::filesystem::exists(folder_ / "site"));
}

TEST_F(Bench, ResultsOfAnotherCorpusAreRefused) {
  make_corpus();
  measure("native", "ours");
  replace_in("corpus/corpus.json", "\"0.1\"", "\"0.2\"");
  expect_refusal(bench_command("site " + at("site") + " " + at("ours.json") + " --corpus " + at("corpus")),
                 {"ours.json: was not measured on this corpus"});
  EXPECT_FALSE(std::filesystem::exists(folder_ / "site" / "index.html"));
}

}  // namespace
}  // namespace touchstone
