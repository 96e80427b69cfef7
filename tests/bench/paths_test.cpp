#include <gmock/gmock.h>

#include <cstdint>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <regex>
#include <stdexcept>
#include <string>
#include <tuple>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/geometry/quaternion.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/examples/bench/site/cell.hpp"
#include "touchstone/examples/bench/site/path_pages.hpp"
#include "touchstone/examples/compare_backends/judge/path_result.hpp"
#include "touchstone/tests/support/program_test.hpp"

// Motion along paths in the reference benchmark: what an answer costs, and a corpus that has paths.

namespace touchstone {
namespace {

using Json = nlohmann::json;
using testing::HasSubstr;
using namespace comparison;

// ---- judged

constexpr std::size_t kPoses = 9;

/// A cube of 1 m at rest in the origin and another that goes straight on, past or into it.
class Judged : public testing::Test {
 protected:
  void SetUp() override {
    oracle = make_exact_oracle();
    ASSERT_NE(oracle, nullptr);
    take(0.2);
  }
  /// @param aside of the moving cube's middle along y [m].
  void take(double aside) {
    set = {};
    set.name = "own";
    const Hexahedron cube = Hexahedron::from_size({1, 1, 1});
    const auto at = [](double x, double y) { return Pose{Matrix3::Identity(), {x, y, 0.1}}; };
    append_path(set, "own:0", {cube, cube},
                {RigidPath(Pose{}), RigidPath::between(at(3, aside), at(-3, aside))}, kPoses);
    poses = compute_truth(set, *oracle, 1);
    truth = compute_path_truth(set, kPoses, *oracle, 1);
  }
  PathBackendResult judge(const std::optional<Impact>& impact,
                          const std::vector<PairStatus>& overlap = {}) const {
    PathAnswers answers;
    answers.backend = "mine";
    answers.impacts = {impact};
    answers.gaps = {1e-9};
    return judge_paths(set, kPoses, truth, poses, answers, overlap, *oracle);
  }
  static Impact stop(ImpactStatus status, double lo) {
    Impact impact;
    impact.status = status;
    impact.lo = lo;
    return impact;
  }

  std::unique_ptr<Oracle> oracle;
  PairSet set;
  std::vector<PairTruth> poses;
  std::vector<PathTruth> truth;
};

TEST_F(Judged, AStopBeforeTheContactCostsWhatIsStillFree) {
  const PathBackendResult near = judge(stop(ImpactStatus::blocked, 1.0 / 3 - 1e-10));
  EXPECT_EQ(near.wrong() + near.open, 0u);
  EXPECT_NEAR(near.worst.cost, 6e-10, 1e-12);
  const PathBackendResult early = judge(stop(ImpactStatus::blocked, 0.2));
  EXPECT_EQ(early.early, 1u);
  EXPECT_EQ(early.wrong(), 1u);
  ASSERT_EQ(early.faults.size(), 1u);
  EXPECT_EQ(early.faults[0].reason, "early");
  EXPECT_NEAR(early.worst.cost, 0.8, 1e-12);
  EXPECT_NEAR(early.worst.cost_over_scale, 0.8 / paths_of(set, kPoses, 0).scale, 1e-12);
}

TEST_F(Judged, WhatGoesIntoTheContactCostsItsDepth) {
  const PathBackendResult late = judge(stop(ImpactStatus::blocked, 0.4));  // 0.4 m in each other along x
  EXPECT_EQ(late.late, 1u);
  EXPECT_NEAR(late.worst.cost, 0.4, 1e-12);
  const PathBackendResult missed = judge(stop(ImpactStatus::clear, 1.0));  // at s = 0.5 0.8 m deep along y
  EXPECT_EQ(missed.missed, 1u);
  EXPECT_NEAR(missed.worst.cost, 0.8, 1e-12);
  ASSERT_EQ(missed.faults.size(), 1u);
  EXPECT_EQ(missed.faults[0].reason, "missed");
  EXPECT_EQ(missed.faults[0].id, "own:0");
}

TEST_F(Judged, AStopOnAClearPathIsPhantomUnlessTheTwoAreWithinTheGap) {
  take(1.2);
  ASSERT_EQ(truth[0].path_class, PathClass::clear);
  EXPECT_EQ(judge(stop(ImpactStatus::clear, 1.0)).wrong(), 0u);
  const PathBackendResult phantom = judge(stop(ImpactStatus::blocked, 0.5));
  EXPECT_EQ(phantom.phantom, 1u);
  EXPECT_NEAR(phantom.worst.cost, 0.2, 1e-12);
  take(1 + 0x1p-31);
  ASSERT_EQ(truth[0].path_class, PathClass::clear);
  EXPECT_EQ(judge(stop(ImpactStatus::blocked, 0.5)).phantom, 0u);
}

TEST_F(Judged, AStopIsEarlyFromAThousandthOfTheScaleOn) {
  const double scale = paths_of(set, kPoses, 0).scale;
  const auto stop_off = [&](double off) { return stop(ImpactStatus::blocked, truth[0].lo - off / 6); };
  EXPECT_EQ(judge(stop_off(1.01 * kEarlyFrom * scale)).early, 1u);
  EXPECT_EQ(judge(stop_off(0.99 * kEarlyFrom * scale)).wrong(), 0u);
  // On a clear path it is phantom, and counted once.
  take(1.2);
  const PathBackendResult phantom = judge(stop(ImpactStatus::blocked, 0.0));
  EXPECT_EQ(phantom.phantom, 1u);
  EXPECT_EQ(phantom.wrong(), 1u);
}

TEST_F(Judged, WhatIsNotAnsweredIsOpenFailedOrNotTaken) {
  EXPECT_EQ(judge(stop(ImpactStatus::iteration_limit, 0.2)).open, 1u);
  EXPECT_EQ(judge(stop(ImpactStatus::failed, 0.0)).failed, 1u);
  const PathBackendResult refused = judge(std::nullopt);
  EXPECT_EQ(refused.unsupported, 1u);
  EXPECT_EQ(refused.answered, 0u);
  EXPECT_EQ(judge(stop(ImpactStatus::iteration_limit, 0.5)).late, 1u);  // stopped early, but too late
}

TEST_F(Judged, APathOnWhichNoPoseIsAnsweredIsNotTaken) {
  std::vector<PairStatus> said(kPoses, PairStatus::unsupported);
  const Impact early = stop(ImpactStatus::blocked, 0.0);
  EXPECT_EQ(judge(early, said).unsupported, 1u);
  EXPECT_EQ(judge(early, said).wrong(), 0u);
  said[4] = PairStatus::overlapping;
  EXPECT_EQ(judge(early, said).unsupported, 0u);
  EXPECT_EQ(judge(early, said).early, 1u);
}

TEST_F(Judged, TheFirstPoseInContactIsCounted) {
  const PathSetResult begun = begin_paths(set, kPoses, truth, poses);
  EXPECT_EQ(begun.meets, 1u);
  EXPECT_EQ(begun.unseen, 0u);
  const auto said = [&](std::size_t first, PairStatus status) {
    std::vector<PairStatus> overlap(kPoses, PairStatus::separated);
    if (first < kPoses) overlap[first] = status;
    return judge(stop(ImpactStatus::blocked, 0.3), overlap);
  };
  EXPECT_EQ(said(3, PairStatus::overlapping).pose_right, 1u);  // x = 0.75
  EXPECT_EQ(said(2, PairStatus::overlapping).pose_earlier, 1u);
  EXPECT_EQ(said(4, PairStatus::overlapping).pose_later, 1u);
  EXPECT_EQ(said(kPoses, PairStatus::overlapping).pose_later, 1u);
  EXPECT_EQ(said(3, PairStatus::undecided).pose_open, 1u);
}

TEST_F(Judged, AContactBetweenTwoPosesIsUnseen) {
  const Hexahedron sheet = Hexahedron::from_size({0.01, 1, 1});
  set = {};
  append_path(set, "thin:0", {sheet, sheet},
              {RigidPath(Pose{}),
               RigidPath::between({Matrix3::Identity(), {1, 0, 0}}, {Matrix3::Identity(), {-2, 0, 0}})},
              kPoses);
  poses = compute_truth(set, *oracle, 1);
  truth = compute_path_truth(set, kPoses, *oracle, 1);
  EXPECT_EQ(begin_paths(set, kPoses, truth, poses).unseen, 1u);
}

// ---- engines' own sweeps

/// Gives the answers that it was made with.
class ToldSweep final : public Sweep {
 public:
  ToldSweep(std::optional<double> said, double most_turn, bool throws)
      : said_(said), most_turn_(most_turn), throws_(throws) {}
  double most_turn() const noexcept override { return most_turn_; }
  void set(const Hexahedron& a, const RigidPath&, const Hexahedron&, const RigidPath&) override {
    if (!a.is_box()) throw InputError("boxes alone");
  }
  std::optional<double> impact() override {
    if (throws_) throw std::runtime_error("gave up");
    return said_;
  }

 private:
  std::optional<double> said_;
  double most_turn_;
  bool throws_;
};

class Swept : public Judged {
 protected:
  PathBackendResult sweep(std::optional<double> said, double most_turn = kInfinity,
                          bool throws = false) const {
    const SweepEntry entry{"mine_cast", "Mine 1.0: a cast", "mine",
                           [=] { return std::make_unique<ToldSweep>(said, most_turn, throws); }};
    return judge_paths(set, kPoses, truth, poses, run_sweep(entry, set, kPoses), {}, *oracle);
  }
  /// As take(), and the moving one turns.
  void take_turning(const Hexahedron& solid) {
    set = {};
    const Pose from{Matrix3::Identity(), {3, 0.2, 0.1}},
        to{rotation_matrix(quaternion_of_turn({0, 0, 0.3})), {-3, 0.2, 0.1}};
    append_path(set, "own:0", {solid, solid}, {RigidPath(Pose{}), RigidPath::between(from, to)}, kPoses);
    poses = compute_truth(set, *oracle, 1);
    truth = compute_path_truth(set, kPoses, *oracle, 1);
  }
};

TEST_F(Swept, ItsStopIsJudgedUnderANameOfItsOwn) {
  const PathBackendResult right = sweep(1.0 / 3 - 1e-10);
  EXPECT_EQ(right.name, "mine_cast");
  EXPECT_EQ(right.sweep, "Mine 1.0: a cast");
  EXPECT_EQ(right.check, "swept");
  EXPECT_EQ(right.answered, 1u);
  EXPECT_EQ(right.wrong() + right.open, 0u);
  EXPECT_EQ(sweep(0.2).early, 1u);
  EXPECT_EQ(sweep(0.4).late, 1u);
  EXPECT_EQ(sweep(std::nullopt).missed, 1u);
  take(1.2);
  EXPECT_EQ(sweep(0.5).phantom, 1u);
  EXPECT_EQ(sweep(std::nullopt).wrong(), 0u);
}

TEST_F(Swept, NoNumberAndAnExceptionAreFailures) {
  EXPECT_EQ(sweep(kNaN).failed, 1u);
  EXPECT_EQ(sweep(0.2, kInfinity, true).failed, 1u);
}

TEST_F(Swept, PathsThatTurnFurtherThanItFollowsAreNotTaken) {
  EXPECT_EQ(sweep(0.3, 0.0).answered, 1u);
  take_turning(Hexahedron::from_size({1, 1, 1}));  // by 0.3 rad
  EXPECT_EQ(sweep(0.3).answered, 1u);
  EXPECT_EQ(sweep(0.3, 0.31).answered, 1u);
  EXPECT_EQ(sweep(0.3, 0.29).answered, 0u);
  EXPECT_EQ(sweep(0.3, 0.29).unsupported, 1u);
  EXPECT_EQ(sweep(0.3, 0.0).unsupported, 1u);
}

TEST_F(Swept, ASolidThatItRefusesIsNotTaken) {
  std::array<Vector3, 8> vertices = Hexahedron::from_size({1, 1, 1}).vertices();
  for (Vector3& vertex : vertices) vertex.x() += 0.25 * vertex.z();
  take_turning(Hexahedron::from_vertices(vertices));
  EXPECT_EQ(sweep(0.3).unsupported, 1u);
}

// ---- the site's table

TEST(CellText, AMissedTouchCostsNothing) {
  const auto text = [](std::size_t missed, double worst) {
    Cell cell;
    cell.wrong.cases = 30;
    cell.wrong.missed = missed;
    cell.cost.worst = worst;
    return text_of(cell);
  };
  EXPECT_EQ(text(3, 5e-324), "3 missed of 30; 0 S");
  EXPECT_EQ(text(3, 0.0), "3 missed of 30; 0 S");  // over a large S
  EXPECT_EQ(text(3, 2e-16), "3 missed of 30; 2e-16 S");
  // No line ends within a count.
  EXPECT_EQ(text(1000, 2e-16), "1\u00a0000 missed of 30; 2e-16 S");
  EXPECT_EQ(unbroken_count(1'234'567), "1\u00a0234\u00a0567");
  EXPECT_EQ(text(0, 0.0), "exact");
  EXPECT_EQ(text(0, 2e-16), "2e-16 S");
}

TEST(PathSection, EveryEarlyStopIsCounted) {
  BenchResults results;
  results.path_sets = {{"thin", 12, 5, 4, 0, 0}};
  const auto row = [&](const std::string& early, double cost_over_scale) {
    Entry entry;
    entry.engine = "mine";
    PathCell& cell = entry.paths["thin"] = path_cell_of(
        Json::parse(
            R"({"backend": "mine", "check": "proven", "impacts": {"answered": 12, "missed": 0, "late": 0, "phantom": 0,)" +
            early + R"("open": 0, "failed": 0, "unsupported": 0},
        "worst": {"path": "paths_thin:3", "reason": "", "stops_at_s": 0, "cost_m": 0.5, "cost_over_S": )" +
            std::to_string(cost_over_scale) + R"(}, "wrong_cases": []})"),
        12);
    EXPECT_EQ(grade(cell) == Grade::wrong, cell.early > 0);
    return path_section(results, {entry});
  };
  EXPECT_THAT(row(R"("early": 3,)", 0.25), HasSubstr(">mine</span></th><td>3</td>"));
  EXPECT_THAT(row(R"("early": 3,)", 0.25), HasSubstr("3 early of 12; 2e-01 S"));
  // Files of before: of each set the dearest answer is known.
  EXPECT_THAT(row("", kFar), HasSubstr(">mine</span></th><td>1</td>"));
  EXPECT_THAT(row("", 0.99 * kFar), HasSubstr(">mine</span></th><td>0</td>"));
}

// ---- a corpus with paths

constexpr const char* kPlan =
    R"({"schema": "touchstone.corpus/1", "name": "small", "version": "0.1", "sets": [
  {"name": "thin", "description": "sheets", "from": {"family": "paths_thin", "seed": 7, "count": 12, "poses": 5}}]})";

class PathCorpus : public ProgramTest {
 protected:
  PathCorpus() : ProgramTest("") {
    write("plan.json", kPlan);
    const Outcome made =
        run(std::string(BENCH) + " corpus " + at("corpus") + " --freeze --manifest " + at("plan.json"));
    EXPECT_EQ(made.code, 0) << made.err;
  }
  std::string at(const std::string& name) const { return (folder_ / name).string(); }
  Outcome compare(const std::string& arguments) const {
    return run(std::string(COMPARE_BACKENDS) + " --no-broadphase --repetitions 1 --corpus " + at("corpus") +
               " " + arguments);
  }
};

TEST_F(PathCorpus, ItIsTheSameEachTimeAndFrozen) {
  std::filesystem::copy_file(folder_ / "corpus" / "corpus.json", folder_ / "frozen.json");
  const Outcome again =
      run(std::string(BENCH) + " corpus " + at("again") + " --manifest " + at("frozen.json"));
  ASSERT_EQ(again.code, 0) << again.err;
  EXPECT_EQ(read(folder_ / "again" / "thin.impacts.json"), read(folder_ / "corpus" / "thin.impacts.json"));
  const Json impacts = Json::parse(read(folder_ / "again" / "thin.impacts.json"));
  ASSERT_EQ(impacts.size(), 12u);
  EXPECT_EQ(impacts[3][0], "paths_thin:3");
  EXPECT_EQ(Json::parse(read(folder_ / "again" / "thin.json")).size(), 60u);
  Json manifest = Json::parse(read(folder_ / "frozen.json"));
  manifest["sets"][0]["impacts_sha256"] = std::string(64, '0');
  write("other.json", manifest.dump());
  EXPECT_THAT(run(std::string(BENCH) + " corpus " + at("other") + " --manifest " + at("other.json")).err,
              HasSubstr("corpus: thin: this build makes other files"));
}

TEST_F(PathCorpus, AWrongTimeOfImpactIsFound) {
  Json impacts = Json::parse(read(folder_ / "corpus" / "thin.impacts.json"));
  std::size_t met = 0;
  while (met < impacts.size() && impacts[met][1] != "meets") ++met;
  ASSERT_LT(met, impacts.size());
  impacts[met][3] = 0.99;
  write("corpus/thin.impacts.json", impacts.dump());
  EXPECT_THAT(compare("--backend native --output " + at("report")).err,
              HasSubstr("is not the file that the manifest names"));
  Json manifest = Json::parse(read(folder_ / "corpus" / "corpus.json"));
  manifest["sets"][0]["impacts_sha256"] =
      run("sha256sum " + at("corpus/thin.impacts.json")).out.substr(0, 64);
  write("corpus/corpus.json", manifest.dump());
  const std::string id = impacts[met][0];
  EXPECT_THAT(compare("--backend native --output " + at("report")).err,
              HasSubstr("path '" + id + "': the time of impact in the corpus is not what `exact` says"));
}

TEST_F(PathCorpus, EnginesAreJudgedAndShownWithTheirCases) {
  const Outcome asked = compare("--backend native edge_face --output " + at("report"));
  ASSERT_EQ(asked.code, 0) << asked.err;
  const Json results = Json::parse(read(folder_ / "report" / "results.json"));
  const Json& thin = results.at("path_sets").at(0);
  EXPECT_EQ(thin.at("paths"), 12);
  EXPECT_GT(thin.at("meets"), 2);
  const Json& native = thin.at("backends").at(0);
  EXPECT_EQ(native.at("check"), "proven");
  EXPECT_EQ(native.at("impacts").at("answered"), 12);
  for (const char* kind : {"missed", "late", "phantom", "failed"})
    EXPECT_EQ(native.at("impacts").at(kind), 0) << kind;
  EXPECT_EQ(native.at("first_pose").at("right"), 12);
  EXPECT_EQ(thin.at("backends").at(1).at("check"), "sampled");

  // No sweep was asked: Bullet and FCL were not.
  EXPECT_EQ(thin.at("backends").size(), 2u);

  // An engine that goes through everything, as the site has it.
  Json wrong = results;
  Json& cell = wrong.at("path_sets").at(0).at("backends").at(0);
  const std::string met = [&] {
    for (const Json& impact : Json::parse(read(folder_ / "corpus" / "thin.impacts.json")))
      if (impact[1] == "meets") return impact[0].get<std::string>();
    return std::string();
  }();
  cell["check"] = "<script>";
  cell["impacts"]["missed"] = 1;
  cell["wrong_cases"] = {
      {{"path", met}, {"reason", "missed"}, {"stops_at_s", 1.0}, {"cost_m", 0.25}, {"cost_over_S", 0.1}}};
  write("results.json", wrong.dump());
  const Outcome made = run(std::string(BENCH) + " site " + at("site") + " " + at("results.json") +
                           " --corpus " + at("corpus"));
  ASSERT_EQ(made.code, 0) << made.err;
  const std::string index = read(folder_ / "site" / "index.html");
  EXPECT_THAT(index, HasSubstr("<section id='paths'>"));
  EXPECT_THAT(index, HasSubstr("<td>&lt;script&gt;</td>"));
  EXPECT_THAT(index, HasSubstr("href='cases/thin.html#thin_native_path'>1 missed of 12; "));
  const std::string page = read(folder_ / "site" / "cases" / "thin.html");
  EXPECT_THAT(page, HasSubstr("<section id='thin_native_path'>"));
  EXPECT_THAT(page, HasSubstr("clear to the end (missed)"));
  EXPECT_THAT(read(folder_ / "site" / "reproductions" / "thin_native_path.md"),
              HasSubstr(met + ": meets at s in ["));
  // The pair file has the contact: it is one again.
  const Outcome once =
      run(std::string(COMPARE_BACKENDS) + " --pairs " + at("site/reproductions/thin_native_path.json") +
          " --backend native --case '" + met + "@contact'");
  ASSERT_EQ(once.code, 0) << once.err;
  EXPECT_THAT(once.out, HasSubstr("overlap: overlapping"));

  // Without its paths, the file is no longer whole.
  wrong.at("path_sets").clear();
  write("results.json", wrong.dump());
  expect_refusal(
      std::string(BENCH) + " site " + at("site") + " " + at("results.json") + " --corpus " + at("corpus"),
      {"results.json: lacks the paths of the corpus's set 'thin'"});
}

TEST_F(PathCorpus, FiguresThatAreNoneAreRefused) {
  ASSERT_EQ(compare("--backend native --output " + at("report")).code, 0);
  const Json whole = Json::parse(read(folder_ / "report" / "results.json"));
  const std::string set = "/path_sets/0", backend = set + "/backends/0", impacts = backend + "/impacts";
  constexpr std::uint64_t kHalf = std::uint64_t{1} << 63;  // two of them are 0
  const Json unseen = {{"path", "paths_thin:0"},
                       {"reason", "late"},
                       {"stops_at_s", 0.5},
                       {"cost_m", "-inf"},
                       {"cost_over_S", 0.1}};
  const std::tuple<std::string, Json, const char*> changes[] = {
      {impacts, {{"missed", kHalf}, {"late", kHalf}}, "more wrong and open impacts than 'answered'"},
      {impacts, {{"early", -1}}, "'early' is no count"},
      {impacts, {{"unsupported", 1}}, "'impacts' counts more than there are paths"},
      {impacts, {{"answered", kHalf}, {"unsupported", kHalf}}, "'impacts' counts more than there are paths"},
      {backend + "/first_pose", {{"later", kHalf}, {"open", kHalf}}, "'first_pose' counts more"},
      {backend + "/worst", {{"cost_over_S", nullptr}}, "'cost_over_S' is no cost"},
      {backend + "/worst", {{"cost_m", -1}}, "'cost_m' is no cost"},
      {backend, {{"wrong_cases", {unseen}}}, "'cost_m' is no cost"},
      {set, {{"paths", 13}}, "has 13 paths of 5 poses of the corpus's set 'thin', which has 12 of 5"},
      {set, {{"poses", 4}}, "has 12 paths of 4 poses"},
      {set, {{"open", 12}}, "more paths meet or are open"},
      {set, {{"unseen", 12}}, "more are 'unseen' than meet"}};
  for (const auto& [place, values, refusal] : changes) {
    Json changed = whole;
    changed.at(Json::json_pointer(place)).update(values);
    write("results.json", changed.dump());
    expect_refusal(
        std::string(BENCH) + " site " + at("site") + " " + at("results.json") + " --corpus " + at("corpus"),
        {"results.json: ", refusal});
  }
  EXPECT_FALSE(std::filesystem::exists(folder_ / "site"));
}

#ifdef HAS_BULLET
TEST_F(PathCorpus, SweepsAreAskedBesideTheirBackendAndStandInTheTable) {
  const Outcome asked = compare("--backend bullet --output " + at("report"));
  ASSERT_EQ(asked.code, 0) << asked.err;
  const Json results = Json::parse(read(folder_ / "report" / "results.json"));
  const Json& backends = results.at("path_sets").at(0).at("backends");
  std::map<std::string, Json> sweeps;
  for (const Json& each : backends)
    if (each.contains("sweep")) sweeps[each.at("backend")] = each;
  ASSERT_EQ(sweeps.size(), 3u);
  const Json& continuous = sweeps.at("bullet_continuous");
  EXPECT_EQ(continuous.at("check"), "swept");
  EXPECT_FALSE(continuous.contains("first_pose"));
  EXPECT_GT(continuous.at("impacts").at("answered"), 0);
  // Half of these paths turn, by more than 45 degrees.
  const Json& subsimplex = sweeps.at("bullet_subsimplex_cast").at("impacts");
  EXPECT_GT(subsimplex.at("answered"), 0);
  EXPECT_GT(subsimplex.at("unsupported"), 0);
  const Outcome made = run(std::string(BENCH) + " site " + at("site") + " " + at("report/results.json") +
                           " --corpus " + at("corpus"));
  ASSERT_EQ(made.code, 0) << made.err;
  const std::string index = read(folder_ / "site" / "index.html");
  EXPECT_THAT(index, HasSubstr(">bullet_continuous</span></th>"));
  const std::size_t history = index.find("<section id='history'>");
  EXPECT_EQ(index.find("bullet_continuous", history), std::string::npos);  // it has no answers to queries

  // Each reproduction is wrong again, and as the site says.
  const std::regex red("href='cases/thin.html#thin_(bullet[a-z_]*)_path'"),
      said("\\n    (paths_thin:[0-9]*): ([^\\n]* \\([a-z]*\\))\\n");
  int asked_again = 0;
  for (auto at_link = std::sregex_iterator(index.begin(), index.end(), red);
       at_link != std::sregex_iterator(); ++at_link, ++asked_again) {
    const std::string engine = (*at_link)[1], file = at("site/reproductions/thin_" + engine + "_path");
    const std::string text = read(file + ".md");
    std::smatch answer;
    ASSERT_TRUE(std::regex_search(text, answer, said)) << text;
    const Outcome again = run(std::string(COMPARE_BACKENDS) + " --pairs " + file +
                              ".json --backend bullet --case " + answer[1].str());
    ASSERT_EQ(again.code, 0) << again.err;
    EXPECT_THAT(again.out, HasSubstr("\n" + engine + "\n    swept: " + answer[2].str() + ", costs "));
  }
  EXPECT_GE(asked_again, 1);
}
#endif

}  // namespace
}  // namespace touchstone
