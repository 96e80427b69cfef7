#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <regex>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/examples/compare_backends/comparison.hpp"
#include "touchstone/examples/compare_backends/dynamics_drift.hpp"
#include "touchstone/examples/compare_backends/error_plots.hpp"
#include "touchstone/examples/compare_backends/growth_plot.hpp"
#include "touchstone/examples/compare_backends/html_report.hpp"
#include "touchstone/examples/compare_backends/replay_command.hpp"
#include "touchstone/examples/compare_backends/speed_error_plot.hpp"
#include "touchstone/examples/compare_backends/time_plot.hpp"
#include "touchstone/examples/program/shell_text.hpp"
#include "touchstone/tests/measures/fake_backends.hpp"
#include "touchstone/tests/support/program_test.hpp"

// What the figures and sections of the page say of made-up results.

namespace touchstone::comparison {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

Timing blocks(double least, double median, double p99, std::size_t count = 1000) {
  Timing timing;
  timing.minimum_ns = least;
  timing.lower_quartile_ns = timing.upper_quartile_ns = timing.median_ns = median;
  timing.p99_ns = p99;
  timing.blocks = count;
  timing.block = 128;
  return timing;
}

SetResult one_set(const BackendResult::Rows& rows) {
  SetResult set;
  set.name = "made_up";
  set.cases = 100;
  BackendResult backend;
  backend.name = "some";
  backend.judged = true;
  for (Wrongness& wrong : backend.judgement.wrongness) wrong.cases = 100;
  for (Quantiles& cost : backend.judgement.cost) cost = {1e-16, 1e-15, 1e-14, 7, 100};
  backend.rows.fill(rows);
  set.backends = {backend};
  return set;
}

const std::vector<std::string> kNames = {"some"};

// ---- times

TEST(TimeFigures, FastRowsStandWhereTheirTimesAre) {
  const SetResult set =
      one_set({blocks(150, 200, 300), blocks(30, 33, 40), blocks(4, 5, 6), blocks(32, 36, 40), {}});
  const Decades axis = time_axis_for(std::span(&set, 1));
  EXPECT_EQ(axis.low, 0);   // 4 ns
  EXPECT_EQ(axis.high, 3);  // 300 ns
  const std::string plot = time_plot(set, QueryKind::overlap, axis, kNames, false);
  EXPECT_THAT(plot, Not(HasSubstr("class='held'")));
  // The marks of 33 (square, batch) and 36 ns (diamond, cached): log10 apart by 0.038 of 3 decades.
  std::smatch square, diamond;
  ASSERT_TRUE(std::regex_search(plot, square, std::regex("<rect x='([0-9.]+)' y='[0-9.]+' width='7.2'")));
  ASSERT_TRUE(std::regex_search(plot, diamond, std::regex("<path d='M([0-9.]+) [0-9.]+l4.4 4.4l-4.4")));
  EXPECT_NEAR((std::stod(diamond[1]) - (std::stod(square[1]) + 3.6)) / (520.0 - 148 - 24),
              std::log10(36.0 / 33.0) / 3, 1e-3);
}

TEST(TimeFigures, WhatIsHeldAtAnEdgeIsMarked) {
  const SetResult set = one_set({blocks(150, 200, 300), blocks(30, 33, 40), {}, {}, {}});
  EXPECT_THAT(time_plot(set, QueryKind::overlap, {2, 3}, kNames, false), HasSubstr("class='held'"));
  EXPECT_THAT(time_plot(set, QueryKind::overlap, {1, 2}, kNames, false), HasSubstr("class='held'"));
  EXPECT_THAT(time_plot(set, QueryKind::overlap, {1, 3}, kNames, false), Not(HasSubstr("class='held'")));
}

TEST(TimeFigures, FewBlocksHaveNo99Percent) {
  const SetResult many = one_set({blocks(150, 200, 900), {}, {}, {}, {}});
  const SetResult few = one_set({blocks(150, 200, 900, 99), {}, {}, {}, {}});
  EXPECT_THAT(time_plot(many, QueryKind::overlap, {1, 3}, kNames, false), HasSubstr("99% 900"));
  EXPECT_THAT(time_plot(few, QueryKind::overlap, {1, 3}, kNames, false), HasSubstr("99% -"));
  EXPECT_EQ(time_axis_for(std::span(&few, 1)).high, 3);
  const PlotAxes axes{100, 1000, 1e-17, 1e-12};
  EXPECT_THAT(speed_error_plot(many, QueryKind::overlap, axes, kNames, false), HasSubstr("(99% 900)"));
  EXPECT_THAT(speed_error_plot(few, QueryKind::overlap, axes, kNames, false), HasSubstr("(99% -)"));
}

TEST(SpeedFigures, WhatIsHeldAtAnEdgeIsMarked) {
  const SetResult set = one_set({blocks(150, 200, 300), {}, {}, {}, {}});
  const auto plot = [&](const PlotAxes& axes) {
    return speed_error_plot(set, QueryKind::distance, axes, kNames, false);
  };
  EXPECT_THAT(plot({100, 1000, 1e-17, 1e-12}), Not(HasSubstr("class='held'")));
  EXPECT_THAT(plot({100, 1000, 1e-13, 1e-12}), HasSubstr("class='held'"));
  EXPECT_THAT(plot({1000, 10000, 1e-17, 1e-12}), HasSubstr("class='held'"));
}

TEST(ErrorFigures, TheAxisHoldsTheWrongBackendsToo) {
  SetResult set = one_set({});
  Judgement& judgement = set.backends[0].judgement;
  judgement.wrongness[1].phantom = 3;
  judgement.cost_curve[1].fill(2e-19);
  judgement.cost_curve[1].back() = 0.7;
  const Decades axis = error_axis_for(std::span(&set, 1), QueryKind::distance);
  EXPECT_EQ(axis.low, -19);
  EXPECT_EQ(axis.high, 0);
}

// ---- growth

TEST(Growth, TwoPointsAndWrongBackendsHaveNoSlope) {
  std::vector<ThreadResult> runs;
  for (const auto& [name, counts, wrong] : {std::tuple{"two", 2, 0}, {"three", 3, 0}, {"wrong", 3, 5}}) {
    for (int i = 0; i < counts; ++i) {
      ThreadResult run;
      run.backend = name;
      run.threads = 1 << i;
      run.wrong = static_cast<std::size_t>(wrong);
      run.pass = blocks(100 >> i, 100 >> i, 100 >> i, 9);
      runs.push_back(run);
    }
  }
  const std::vector<FittedSlope> slopes = fitted_slopes({}, runs);
  ASSERT_EQ(slopes.size(), 2u);
  EXPECT_EQ(slopes[0].name, "two");
  EXPECT_TRUE(std::isnan(slopes[0].slope));
  EXPECT_EQ(slopes[1].name, "three");
  EXPECT_NEAR(slopes[1].slope, -1, 1e-12);
  const std::string plot = thread_plot(runs, {"two", "three", "wrong"}, false);
  EXPECT_THAT(plot, HasSubstr(">two</text>"));
  EXPECT_THAT(plot, HasSubstr("three, slope -1.00"));
}

TEST(Scaling, BackendsOfAnotherProcessAreALabelledGap) {
  Report report;
  report.backends = {{"some", "made up"}};
  report.thread_gaps = {{"bullet_single", "runs in a process of its own"}};
  EXPECT_THAT(html_report(report), HasSubstr("Missing: threads of"));
  EXPECT_THAT(html_report(report), HasSubstr("runs in a process of its own"));
}

// ---- commands

TEST(Commands, AShellTakesEveryWordBack) {
  for (const std::string word :
       {"random:7", "it's; $(touch x)", "", "a b", "'", "''", "\\", "~/x", "a\nb", "*"}) {
    const std::string command = "printf %s " + shell_word(word);
    FILE* pipe = popen(command.c_str(), "r");
    ASSERT_NE(pipe, nullptr);
    std::string back;
    for (int c; (c = fgetc(pipe)) != EOF;) back += static_cast<char>(c);
    pclose(pipe);
    EXPECT_EQ(back, word) << command;
  }
  EXPECT_EQ(shell_word("random:7"), "random:7");
}

TEST(Commands, NameEverythingThatTheCaseComesFrom) {
  Report report;
  report.options.seed = 7;
  EXPECT_EQ(replay_command(report, "random", "random:3"), "examples/run --case random:3 --seed 7");
  report.pair_file.emplace().cases.file = "my pairs.json";
  report.pair_file->cases.set.name = "pairs";
  EXPECT_EQ(replay_command(report, "pairs", "it's; $(touch x)"),
            "examples/run --case 'it'\\''s; $(touch x)' --pairs 'my pairs.json'");
  EXPECT_EQ(replay_command(report, "pairs", "-1"), "examples/run --case=-1 --pairs 'my pairs.json'");
  SceneResult scene;
  scene.name = "gate";
  scene.file = "scenes/gate.yaml";
  scene.parameters = {{"offset", 0.09}, {"rate", 8}};
  report.scenes = {scene};
  EXPECT_EQ(replay_command(report, "gate", "gate:5:1"),
            "examples/run --case gate:5:1 --scene scenes/gate.yaml --set offset=0.09 rate=8");
}

TEST(Commands, TheMatrixOfWrongAnswersReplaysTheSeedsPair) {
  Report report;
  report.has_truth = true;
  report.options.seed = 7;
  report.backends = {{"some", "made up"}};
  report.sets = {one_set({})};
  report.sets[0].backends[0].judgement.wrongness[1].missed = 1;
  report.sets[0].backends[0].judgement.wrong_cases[1] = {{0.5, 42, "missed contact"}};
  EXPECT_THAT(html_report(report), HasSubstr("<code>examples/run --case made_up:42 --seed 7</code>"));
}

// ---- the gallery

using testing::CubeOracle;
using testing::cubes;
using testing::register_fakes;

TEST(Gallery, TakesEveryQuerysWorstOverSAndNotWhatClaimsNothing) {
  // S is the largest coordinate: 1 for all of them but the last.
  const PairSet set = cubes({-0.25, -0.5, 0.25, 0.125});
  BackendRegistry registry;
  register_fakes(registry);
  std::vector<const BackendRegistry::NarrowphaseEntry*> all;
  for (const auto& entry : registry.narrowphases()) all.push_back(&entry);
  MeasureOptions measure;
  measure.time_pairs = measure.perturb = false;
  const auto answers = run_backends(all, set, measure);
  const CubeOracle oracle;
  const auto truth = compute_truth(set, oracle, 1);
  std::vector<GalleryCase> gallery;
  collect_cases(set, truth, answers, sum_up(set, truth, &oracle, answers, 1), gallery);
  std::map<std::string, const GalleryCase*> of;
  for (const GalleryCase& each : gallery) of[each.backend] = &each;
  ASSERT_TRUE(of.contains("missing_contacts"));
  EXPECT_EQ(of["missing_contacts"]->reason, "missed contact");
  EXPECT_DOUBLE_EQ(of["missing_contacts"]->cost, 0.5);
  EXPECT_EQ(of["missing_contacts"]->set, set.name);
  ASSERT_TRUE(of.contains("seeing_phantoms"));
  EXPECT_EQ(of["seeing_phantoms"]->reason, "phantom contact");
  EXPECT_TRUE(of.contains("off_by_1e-3"));
  for (const char* silent : {"right", "unsupported", "failing", "undecided"})
    EXPECT_FALSE(of.contains(silent)) << silent;
}

// A missing value hides nothing: the case that costs infinity is not the worst figure that was given.
TEST(Gallery, AnInfiniteCostDoesNotHideAWrongFigure) {
  const PairSet set = cubes({-0.25, -0.5});
  std::vector<BackendAnswers> answers(1);
  answers[0].name = "some";
  for (QueryAnswers& query : answers[0].queries) {
    query.status.assign(2, PairStatus::overlapping);
    query.geometry.assign(2, PairGeometry{-0.25, Vector3::UnitX(), {}, {}, 0});
    query.points.assign(2 * kMaxManifoldPoints, {});
  }
  const CubeOracle oracle;
  const auto truth = compute_truth(set, oracle, 1);
  const SetResult result = sum_up(set, truth, &oracle, answers, 1);
  EXPECT_TRUE(std::isinf(result.backends[0].judgement.cost[index_of(QueryKind::manifold)].worst));
  std::vector<GalleryCase> gallery;
  collect_cases(set, truth, answers, result, gallery);
  ASSERT_EQ(gallery.size(), 1u);
  EXPECT_GE(gallery[0].cost, 0.25);
}

// ---- dynamics

std::string dynamics(double pose_error, double energy_scale) {
  return fmt::format(R"({{"program": "dynamics_run", "scenes": [{{"scene": "push", "build_on": "some",
  "runs": [{{"backend": "some", "stopped": null, "answers": [], "deepest_m": 0,
  "pose_error_m": {}, "unexplained_momentum_ns": 0, "energy_made_j": 1e-12, "energy_scale_j": {},
  "step_us": {{"median": 12.5}}}}]}}]}})",
                     pose_error, energy_scale);
}

class Drift : public FolderTest {
 protected:
  std::vector<DriftRun> load(double pose_error, double energy_scale) const {
    return load_drift(write("dynamics.json", dynamics(pose_error, energy_scale)).string());
  }
  std::string plot(const std::vector<DriftRun>& runs, double worst_error) const {
    Ranking ranking{QueryKind::manifold, {{"some", 100, worst_error, {}}}};
    return drift_plot(runs, {ranking}, kNames, false);
  }
};

TEST_F(Drift, WhatCannotBeIsRefusedOrALabelledGap) {
  EXPECT_THROW(load(-1, 1), InputError);
  const std::vector<DriftRun> runs = load(1e-9, 0);
  const std::string svg = plot(runs, 1e-6);
  EXPECT_THAT(svg, Not(HasSubstr("nan")));
  EXPECT_THAT(svg, Not(HasSubstr("inf")));
  EXPECT_THAT(missing_figures(runs[0]), ElementsAre("energy made / scale"));
  EXPECT_TRUE(missing_figures(load(1e-9, 4)[0]).empty());
  Report report;
  report.drift = runs;
  report.backends = {{"some", "made up"}};
  EXPECT_THAT(html_report(report), HasSubstr("Not in the figure: some, push: energy made / scale"));
}

TEST_F(Drift, WhatIsHeldAtAnEdgeIsMarked) {
  EXPECT_THAT(plot(load(1e-9, 4), 1e-6), Not(HasSubstr("class='held'")));
  EXPECT_THAT(plot(load(1e5, 4), 1e-6), HasSubstr("class='held'"));
}

// ---- scenes

SceneResult a_scene(std::size_t frames, std::size_t differing) {
  SceneResult scene;
  scene.name = "grapple";
  scene.frames = scene.all_frames = 1301;
  scene.pairs = 3;
  scene.parameters = {{"facets", 16}};
  scene.set = one_set({});
  scene.set.backends[0].frame.fill(blocks(1000, 1234, 1500));
  scene.backends.emplace_back().name = "some";
  scene.finest_facets = 64;
  scene.facet_frames = frames;
  scene.facet_frames_near = frames / 2;
  scene.facet_class_frames = differing;
  scene.facet_budget = 1e-6;
  for (const QueryKind query : kQueryKinds)
    scene.facet_rows.push_back({"some", 4, query, 3, 777, 0, false, true});
  return scene;
}

std::string page_with(const SceneResult& scene) {
  Report report;
  report.has_truth = true;
  report.backends = {{"some", "made up"}};
  report.scenes = {scene};
  return html_report(report);
}

TEST(Scenes, RecommendsOnlyOnFramesThatBearIt) {
  const char* const bold = "<strong>some with 4 facets, 777 ns a frame</strong>";
  EXPECT_THAT(page_with(a_scene(100, 3)), HasSubstr(std::string("Least that serves overlap: ") + bold));
  const std::string few = page_with(a_scene(10, 3));
  EXPECT_THAT(few, Not(HasSubstr(bold)));
  EXPECT_THAT(few, HasSubstr("No recommendation: too few frames (10"));
  EXPECT_THAT(few, HasSubstr("over 10 of 1301 frames, 5 of them"));
  EXPECT_THAT(few, HasSubstr("fewer than 26 %"));  // 1 - 0.05^(1/10)
  const std::string alike = page_with(a_scene(100, 0));
  EXPECT_THAT(alike, HasSubstr("Least that served overlap in these frames"));
  EXPECT_THAT(alike, HasSubstr(std::string("Least that serves distance: ") + bold));
}

TEST(Scenes, AWrongBackendHasNoFrameTime) {
  SceneResult scene = a_scene(100, 3);
  EXPECT_THAT(page_with(scene), HasSubstr("<td>1 234</td>"));
  for (Wrongness& wrong : scene.set.backends[0].judgement.wrongness) wrong.missed = 9;
  for (FacetRow& row : scene.facet_rows) row.wrong = true, row.serves = false;
  const std::string page = page_with(scene);
  EXPECT_THAT(page, Not(HasSubstr("<td>1 234</td>")));
  EXPECT_THAT(page, HasSubstr("<td>no speed: 9 missed"));
  EXPECT_THAT(page, Not(HasSubstr("<td>777</td>")));
}

}  // namespace
}  // namespace touchstone::comparison
