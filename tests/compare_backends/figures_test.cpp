#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>
#include <regex>
#include <set>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/examples/compare_backends/figures/drift_plot.hpp"
#include "touchstone/examples/compare_backends/figures/error_plots.hpp"
#include "touchstone/examples/compare_backends/figures/growth_plot.hpp"
#include "touchstone/examples/compare_backends/figures/speed_error_plot.hpp"
#include "touchstone/examples/compare_backends/figures/time_plot.hpp"
#include "touchstone/examples/compare_backends/page/html_report.hpp"
#include "touchstone/examples/compare_backends/run/comparison.hpp"
#include "touchstone/examples/compare_backends/run/drift_file.hpp"
#include "touchstone/examples/compare_backends/run/replay_command.hpp"
#include "touchstone/examples/compare_backends/run/sets/set_summary.hpp"
#include "touchstone/examples/program/options/shell_text.hpp"
#include "touchstone/examples/program/plots/svg_plot.hpp"
#include "touchstone/tests/measures/fake_backends.hpp"
#include "touchstone/tests/support/program_test.hpp"

// Figures and sections of the page, on made-up results.

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

TEST(SpeedFigures, WhatIsNotSupportedIsNotDrawnAsWrong) {
  SetResult set = one_set({blocks(150, 200, 300), {}, {}, {}, {}});
  const auto plot = [&] {
    return speed_error_plot(set, QueryKind::distance, {100, 1000, 1e-17, 1e-12}, kNames, false);
  };
  Wrongness& wrong = set.backends[0].judgement.wrongness[index_of(QueryKind::distance)];
  wrong.unsupported = 30;
  EXPECT_THAT(plot(), Not(HasSubstr("hollow")));
  EXPECT_THAT(plot(), Not(HasSubstr("wrong")));
  EXPECT_THAT(plot(), HasSubstr("some: 30"));
  wrong.missed = 2;
  EXPECT_THAT(plot(), HasSubstr("hollow"));
  EXPECT_THAT(plot(), HasSubstr("2 missed"));
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

// A wrong class of solids that touch is wrong by the least double, an answer may be anything.
TEST(ErrorFigures, WhatIsFarOffDoesNotTakeTheAxisFromTheOthers) {
  SetResult set = one_set({});
  auto& curve = set.backends[0].judgement.cost_curve[1];
  curve.fill(2e-16);
  curve.front() = 5e-324;
  curve.back() = 1e300;
  const Decades axis = error_axis_for(std::span(&set, 1), QueryKind::distance);
  EXPECT_EQ(axis.low, -20);
  EXPECT_EQ(axis.high, 1);
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

// A missing value hides nothing: the case that costs most is not the worst figure that was given.
TEST(Gallery, AMissingFigureDoesNotHideAWrongOne) {
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
  EXPECT_STREQ(result.backends[0].judgement.worst[index_of(QueryKind::manifold)].reason, kNoValue);
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
  "step_us": {{"median": 12.5, "p99_9": 20}}, "allocations": 0, "contacts": 3, "misses": []}}]}}]}})",
                     pose_error, energy_scale);
}

class DriftFile : public FolderTest {
 protected:
  Drift load(double pose_error, double energy_scale) const {
    return load_drift(write("dynamics.json", dynamics(pose_error, energy_scale)).string());
  }
  std::string plot(const Drift& drift, double worst_error) const {
    Ranking ranking{QueryKind::manifold, {{{"some", 100}, worst_error}}};
    return drift_plot(drift, {ranking}, kNames, false);
  }
};

TEST_F(DriftFile, WhatCannotBeIsRefusedOrALabelledGap) {
  EXPECT_THROW(load(-1, 1), InputError);
  const Drift drift = load(1e-9, 0);
  const std::string svg = plot(drift, 1e-6);
  EXPECT_THAT(svg, Not(HasSubstr("nan")));
  EXPECT_THAT(svg, Not(HasSubstr("inf")));
  EXPECT_THAT(missing_figures(drift.runs[0]), ElementsAre("energy made / scale"));
  EXPECT_TRUE(missing_figures(load(1e-9, 4).runs[0]).empty());
  Report report;
  report.drift = drift;
  report.backends = {{"some", "made up"}};
  EXPECT_THAT(html_report(report), HasSubstr("Not in the figure: some, push: energy made / scale"));
}

TEST_F(DriftFile, WhatIsHeldAtAnEdgeIsMarked) {
  EXPECT_THAT(plot(load(1e-9, 4), 1e-6), Not(HasSubstr("class='held'")));
  EXPECT_THAT(plot(load(1e5, 4), 1e-6), HasSubstr("class='held'"));
}

// Two scenes, and one where nothing touches.
Drift three_backends() {
  Drift drift;
  drift.scenes = {{"stack", "right", "", true}, {"bump", "right", "", true}, {"empty", "", "", false}};
  for (const DriftScene& scene : drift.scenes) {
    for (const char* name : {"never", "off", "quick", "right"}) {
      DriftRun run;
      run.scene = scene.name;
      run.backend = name;
      run.step_ns = run.backend == "quick" ? 1000 : 4000;
      run.p999_ns = 9000;
      run.allocations = run.backend == "quick" ? 70 : 0;
      run.energy_made = 1e-16;
      if (run.backend == "never") run.gap = "gives no manifolds";
      if (run.backend == "off" && run.scene == "bump") run.misses = {"ends 19 mm off"};
      if (!scene.touches) run.pose_error = 1000;  // counts for nothing
      drift.runs.push_back(run);
    }
  }
  drift.build_on = "right";
  drift.reason = "within the limits of all scenes";
  return drift;
}

TEST(DriftVerdict, CountsTheScenesThatTouch) {
  const std::vector<DriftStanding> standings = drift_standings(three_backends());
  ASSERT_EQ(standings.size(), 4u);
  EXPECT_EQ(standings[0].backend, "quick");
  EXPECT_EQ(standings[1].backend, "right");
  EXPECT_EQ(standings[1].scenes, 2u);
  EXPECT_EQ(standings[1].within, 2u);
  EXPECT_EQ(standings[1].pose_error, 0.0);
  EXPECT_NEAR(standings[1].step_ns, 4000, 1e-9);
  EXPECT_EQ(standings[2].backend, "off");
  EXPECT_EQ(standings[2].failure, "bump (ends 19 mm off)");
  EXPECT_EQ(standings[3].backend, "never");
  EXPECT_EQ(standings[3].failure, "stack (gives no manifolds)");
  EXPECT_TRUE(std::isnan(standings[3].pose_error));
}

TEST(DriftVerdict, SaysHowItGoesWithTheHeadline) {
  const Drift drift = three_backends();
  EXPECT_EQ(drift_agreement(drift, "right"), "The verdict on pairs, as the page opens, names right too.");
  EXPECT_THAT(drift_agreement(drift, "off"),
              HasSubstr("names off; with dynamics build on right instead: off is "
                        "within the limits of 1 of 2 scenes that touch; not of "
                        "bump (ends 19 mm off)."));
  EXPECT_THAT(drift_agreement(drift, "never"), HasSubstr("0 of 2 scenes"));
  EXPECT_THAT(
      drift_agreement(drift, "quick"),
      HasSubstr("quick is within all limits, at 1 000 ns a step (99.9 %: 9 000, 70 allocations) against "
                "4 000 (9 000, 0)."));
  EXPECT_THAT(drift_agreement(drift, "not_here"), HasSubstr("not_here was not run."));
  EXPECT_THAT(drift_agreement(drift, ""), HasSubstr("names no backend"));
  EXPECT_EQ(drift_agreement({}, "right"), "");
}

TEST(DriftVerdict, EveryBackendIsDrawnAndThoseThatFailAreHollow) {
  const std::vector<std::string> names = {"never", "off", "quick", "right"};
  const Ranking ranking{
      QueryKind::manifold,
      {{{"off", 1}, 1e-3}, {{"quick", 1}, 1e-9}, {{"right", 1}, 0}, {{"never", 1}, kInfinity}}};
  const std::string svg = drift_plot(three_backends(), {ranking}, names, false);
  const auto count = [&](const std::string& text) {
    std::size_t found = 0;
    for (std::size_t at = 0; (at = svg.find(text, at)) != std::string::npos; ++at) ++found;
    return found;
  };
  EXPECT_EQ(count("class='m m0 hollow'"), 3u + 1);  // once a panel, and the legend's
  EXPECT_EQ(count("class='m m1 hollow'"), 3u + 1);  // the scene that it fails
  EXPECT_EQ(count("class='m m1'"), 6u);             // the two others
  EXPECT_EQ(count("class='m m3'"), 9u + 1);
  EXPECT_EQ(count("class='m m3 hollow'"), 0u);
  EXPECT_THAT(svg, HasSubstr("never: 0 of 2"));
  EXPECT_THAT(svg, HasSubstr("right: 2 of 2"));
}

TEST(DriftVerdict, BuildOnStandsInTheOpen) {
  Report report;
  report.drift = three_backends();
  report.backends = {{"never", ""}, {"off", ""}, {"quick", ""}, {"right", ""}};
  const std::string page = html_report(report);
  const std::size_t from = page.find("Drift in dynamics");
  const std::size_t build_on = page.find("<strong>Build on ", from), fold = page.find("<details", from);
  ASSERT_NE(build_on, std::string::npos);
  EXPECT_LT(build_on, fold);
  EXPECT_LT(page.find("nothing touches: no choice to make", from), fold);
}

// ---- labels

TEST(Labels, StandAsNearAsTheirNeighboursLet) {
  EXPECT_THAT(spread({10, 100, 200}, 15, 0, 300), ElementsAre(10, 100, 200));
  EXPECT_THAT(spread({100, 100, 100}, 10, 0, 300), ElementsAre(90, 100, 110));
  EXPECT_THAT(spread({0, 0, 50}, 10, 0, 300), ElementsAre(0, 10, 50));
  EXPECT_THAT(spread({298, 300}, 10, 0, 300), ElementsAre(290, 300));
  EXPECT_TRUE(spread({}, 10, 0, 300).empty());
}

TEST(Growth, BruteForceHasAMarkOfItsOwn) {
  std::vector<std::string> thirteen;
  for (int b = 0; b < 13; ++b) thirteen.push_back(fmt::format("backend_{}", b));
  BroadphaseResult result;
  result.name = "brute_force";
  result.size.objects = 1000;
  result.size.hexahedra_each = 1;
  result.frame.median_ns = 1e6;
  const std::string svg = growth_plot(std::span(&result, 1), Growth::objects, thirteen, false);
  EXPECT_THAT(svg, HasSubstr("class='m m13'"));
  std::set<std::string> shapes;
  for (int place = 0; place < 16; ++place) {
    const std::string mark = mark_at(place, 0, 0, false);
    shapes.insert(mark.substr(mark.find('>')));
  }
  EXPECT_EQ(shapes.size(), 16u);
  const std::string style = plot_style();
  for (int place = 0; place < 16; ++place)
    EXPECT_THAT(style, HasSubstr(fmt::format(".plot .m{0}{{fill:var(--c{0})}}", place)));
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
  scene.trade.frames = frames;
  scene.trade.frames_near = frames / 2;
  scene.trade.models = 2;
  scene.trade.class_frames = differing;
  scene.trade.allowed = 1e-6;
  for (const QueryKind query : kQueryKinds) {
    TradeRow& row = scene.trade.rows.emplace_back();
    row.backend = "some";
    row.model = "4 facets";
    row.pairs = row.all_pairs = 3;
    row.query = query;
    row.frame_ns = 777;
  }
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
  const char* const bold = "<strong>some, 4 facets, 3 pairs, 777 ns a frame</strong>";
  EXPECT_THAT(page_with(a_scene(100, 3)), HasSubstr(std::string("Least that serves overlap: ") + bold));
  const std::string few = page_with(a_scene(10, 3));
  EXPECT_THAT(few, Not(HasSubstr(bold)));
  EXPECT_THAT(few, HasSubstr("No recommendation: too few frames (10"));
  EXPECT_THAT(few, HasSubstr("over 10 of 1301 frames, 5 of them"));
  EXPECT_THAT(few, HasSubstr("fewer than 26 %"));  // 1 - 0.05^(1/10)
  SceneResult single = a_scene(100, 0);
  single.trade.models = 1;
  EXPECT_THAT(page_with(single), HasSubstr(std::string("Least that serves overlap: ") + bold));
  SceneResult whole = a_scene(10, 0);
  whole.trade.all_frames = true;
  EXPECT_THAT(page_with(whole), HasSubstr(std::string("Least that serves overlap: ") + bold));
  const std::string alike = page_with(a_scene(100, 0));
  EXPECT_THAT(alike, HasSubstr("Least that served overlap in these frames"));
  EXPECT_THAT(alike, HasSubstr(std::string("Least that serves distance: ") + bold));
}

TEST(Scenes, AWrongBackendHasNoFrameTime) {
  SceneResult scene = a_scene(100, 3);
  EXPECT_THAT(page_with(scene), HasSubstr("<td>1 234</td>"));
  for (Wrongness& wrong : scene.set.backends[0].judgement.wrongness) wrong.missed = 9;
  for (TradeRow& row : scene.trade.rows) row.wrong_frames = 9, row.backend_error = 2;
  const std::string page = page_with(scene);
  EXPECT_THAT(page, Not(HasSubstr("<td>1 234</td>")));
  EXPECT_THAT(page, HasSubstr("<td>no speed: 9 missed"));
  EXPECT_THAT(page, Not(HasSubstr("<td>777</td>")));
}

}  // namespace
}  // namespace touchstone::comparison
