#include "touchstone/examples/measures/accuracy/accuracy.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/examples/compare_backends/cli/terminal.hpp"
#include "touchstone/examples/compare_backends/figures/speed_error_plot.hpp"
#include "touchstone/examples/compare_backends/figures/time_plot.hpp"
#include "touchstone/examples/compare_backends/judge/pareto_front.hpp"
#include "touchstone/examples/compare_backends/page/html_report.hpp"
#include "touchstone/examples/compare_backends/results/json_writer.hpp"
#include "touchstone/examples/compare_backends/run/comparison.hpp"
#include "touchstone/examples/compare_backends/run/sets/set_summary.hpp"
#include "touchstone/examples/measures/common/allocations.hpp"
#include "touchstone/examples/program/plots/svg_plot.hpp"
#include "touchstone/examples/program/terminal/text_table.hpp"
#include "touchstone/tests/measures/fake_backends.hpp"

namespace touchstone::comparison {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

// 3 apart, 2 penetrating, 1 touching.
const std::vector<double> kGaps = {0.5, 0.25, 0.125, -0.25, -0.5, 0.0};

class Judged : public ::testing::Test {
 protected:
  Judged() : set_(testing::cubes(kGaps)) {
    testing::register_fakes(backends_.registry);
    MeasureOptions measure;
    measure.repetitions = 2;
    truth_ = compute_truth(set_, oracle_, 2);
    result_ = sum_up(set_, truth_, &oracle_, answer_set({}, backends_, set_, measure), 2);
  }

  const Judgement& of(const std::string& name) const {
    for (const BackendResult& backend : result_.backends) {
      if (backend.name == name) return backend.judgement;
    }
    throw std::runtime_error("no " + name);
  }
  Wrongness wrong(const std::string& name, QueryKind kind = QueryKind::distance) const {
    return of(name).wrongness[index_of(kind)];
  }
  const Quantiles& error(const std::string& name, Measure measure) const {
    return of(name).errors[static_cast<std::size_t>(measure)].over_size;
  }

  Backends backends_;
  testing::CubeOracle oracle_;
  PairSet set_;
  std::vector<PairTruth> truth_;
  SetResult result_;
  const double size_ = std::sqrt(3.0);
};

TEST_F(Judged, CountsClassesPerQuery) {
  EXPECT_EQ(result_.contacts, 3u);
  EXPECT_EQ(result_.touching, 1u);
  for (const QueryKind kind : kQueryKinds) {
    EXPECT_EQ(wrong("right", kind).total(), 0u);
    EXPECT_EQ(wrong("missing_contacts", kind).missed, 3u);
    EXPECT_EQ(wrong("missing_contacts", kind).total(), 3u);
    EXPECT_EQ(wrong("seeing_phantoms", kind).phantom, 3u);
    EXPECT_EQ(wrong("seeing_phantoms", kind).total(), 3u);
    EXPECT_EQ(wrong("unsupported", kind).unsupported, 6u);
    EXPECT_EQ(wrong("unsupported", kind).total(), 0u) << "not asked for, not wrong";
    EXPECT_FALSE(wrong("unsupported", kind).is_complete());
    EXPECT_EQ(wrong("failing", kind).failed, 6u);
    EXPECT_EQ(wrong("undecided", kind).undecided, 6u);
  }
  EXPECT_EQ(wrong("not_a_number", QueryKind::overlap).total(), 0u);
  EXPECT_EQ(wrong("not_a_number", QueryKind::distance).missing, 6u);
  EXPECT_EQ(wrong("not_a_number", QueryKind::manifold).missing, 3u)
      << "a pair that is apart needs no manifold";
}

TEST_F(Judged, ErrorsAreWhatTheFakesDo) {
  EXPECT_EQ(error("right", Measure::distance).worst, 0.0);
  EXPECT_EQ(error("right", Measure::depth).worst, 0.0);
  EXPECT_EQ(error("right", Measure::distance).count, 3u);
  EXPECT_EQ(error("right", Measure::depth).count, 3u);
  EXPECT_EQ(error("right", Measure::normal).worst, 0.0);
  EXPECT_EQ(error("right", Measure::witness).worst, 0.0);
  EXPECT_EQ(error("right", Measure::deepest).worst, 0.0);
  EXPECT_EQ(error("right", Measure::patch_coverage).worst, 0.0);
  EXPECT_NEAR(error("off_by_1e-3", Measure::distance).worst, 1e-3 / size_, 1e-15);
  EXPECT_NEAR(error("off_by_1e-3", Measure::depth).worst, 1e-3 / size_, 1e-15);
  EXPECT_NEAR(error("off_by_1e-3", Measure::deepest).worst, 1e-3 / size_, 1e-15);
  EXPECT_NEAR(error("off_by_1e-3", Measure::witness).worst, 1e-3 / size_, 1e-15);
  EXPECT_EQ(error("off_by_1e-3", Measure::normal).worst, 0.0);
  EXPECT_EQ(error("not_a_number", Measure::distance).count, 0u);
}

TEST_F(Judged, CostsFollowTheRules) {
  const auto worst = [&](const char* name, QueryKind kind) { return of(name).worst[index_of(kind)]; };
  const double anywhere = 2 * size_;  // twice the size of the larger cube
  EXPECT_EQ(worst("right", QueryKind::distance).cost, 0.0);
  EXPECT_EQ(worst("missing_contacts", QueryKind::overlap).cost, 0.5);
  EXPECT_EQ(worst("missing_contacts", QueryKind::overlap).index, 4u);
  EXPECT_STREQ(worst("missing_contacts", QueryKind::overlap).reason, "missed contact");
  EXPECT_EQ(worst("seeing_phantoms", QueryKind::distance).cost, 0.5);
  EXPECT_EQ(worst("seeing_phantoms", QueryKind::distance).index, 0u);
  EXPECT_EQ(worst("undecided", QueryKind::distance).cost, 0.5) << "its figures are right";
  EXPECT_EQ(worst("failing", QueryKind::overlap).cost, 0.5) << "what it leaves unknown";
  EXPECT_DOUBLE_EQ(worst("failing", QueryKind::distance).cost, 0.5 + anywhere);
  EXPECT_DOUBLE_EQ(worst("failing", QueryKind::manifold).cost, 0.5 + anywhere);
  EXPECT_EQ(worst("failing", QueryKind::manifold).index, 4u) << "a pair that is apart needs no points";
  EXPECT_NEAR(worst("off_by_1e-3", QueryKind::distance).cost, 1e-3, 1e-15);
  EXPECT_EQ(worst("off_by_1e-3", QueryKind::overlap).cost, 0.0);
  EXPECT_DOUBLE_EQ(worst("not_a_number", QueryKind::distance).cost, 0.5 + anywhere);
  EXPECT_EQ(of("unsupported").cost[index_of(QueryKind::distance)].count, 0u) << "no cost at all";
}

// The same answers, asked for less.
TEST_F(Judged, WhatIsNotAskedForCostsNothing) {
  // One pair, 0.25 m apart, and the cost of its distance by each kind of question.
  Options options;
  options.backends = {"right"};
  MeasureOptions measure;
  measure.time_pairs = measure.perturb = false;
  const PairSet one = testing::cubes({0.25});
  const std::vector<PairTruth> truth = compute_truth(one, oracle_, 1);
  auto answers = answer_set(options, backends_, one, measure);
  PairGeometry& geometry = answers[0].queries[index_of(QueryKind::distance)].geometry[0];
  const auto costs = [&] {
    const CaseErrors errors = case_errors(posed_pair(one, 0), truth[0], oracle_, answers[0], 0);
    std::array<double, kAskedKinds> each;
    for (std::size_t a = 0; a < kAskedKinds; ++a)
      each[a] = errors.charges[index_of(QueryKind::distance)][a].cost;
    return each;
  };
  // Missing witness points cost those who ask for points.
  geometry.p_A_W.x() = kNaN;
  const double missing = 0.25 + 2 * size_;
  EXPECT_THAT(costs(), ::testing::ElementsAre(0.0, 0.0, missing, missing));
  // A wrong normal costs those who ask for normals or points.
  geometry = {0.25, Vector3::UnitY(), {0.5, 0, 0}, {0.75, 0, 0}, 0};  // B is 1 m behind A along y
  EXPECT_THAT(costs(), ::testing::ElementsAre(0.0, 1.25, ::testing::Gt(0.25), 1.25));
  // A wrong separation costs all; no more than the true one where the answer is undecided.
  geometry = {0.5, Vector3::UnitX(), {0.5, 0, 0}, {1.0, 0, 0}, 0};
  EXPECT_EQ(costs()[0], 0.25);
  answers[0].queries[index_of(QueryKind::distance)].status[0] = PairStatus::undecided;
  geometry.separation = 0.25 + 1.0;
  EXPECT_EQ(costs()[0], 1.0) << "dearer than |d|";
}

// Far out a point can be held to an ulp of its coordinates only: errors up to two of these are none.
TEST(HeldByDoubles, ErrorsOfTwoUlpsOfTheCoordinatesCostNothing) {
  testing::CubeOracle oracle;
  const double far = 0x1p20, ulp = 0x1p-32;  // about 1e6 m
  EXPECT_EQ(held_by_doubles(far), 2 * ulp);
  // A pair far from the origin, whose separation is off by two units in the last place of its coordinates.
  PairSet set = testing::cubes({0.25});
  for (Pose& X : set.poses) X.p.y() += far;
  const std::vector<PairTruth> truth = {{PairClass::separated, 0.25, Vector3::UnitX(), true}};
  BackendAnswers answers;
  answers.name = "some";
  for (QueryAnswers& query : answers.queries) {
    query.status.assign(1, PairStatus::separated);
    query.geometry.assign(1,
                          PairGeometry{0.25 + 2 * ulp, Vector3::UnitX(), {0.5, far, 0}, {0.75, far, 0}, 0});
    query.points.assign(kMaxManifoldPoints, {});
  }
  const auto value_cost = [&] {
    return case_errors(posed_pair(set, 0), truth[0], oracle, answers, 0)
        .charges[index_of(QueryKind::distance)][0]
        .cost;
  };
  // That is free; three units cost all three.
  EXPECT_EQ(value_cost(), 0.0);
  answers.queries[index_of(QueryKind::distance)].geometry[0].separation = 0.25 + 3 * ulp;
  EXPECT_EQ(value_cost(), 3 * ulp);
  answers.queries[index_of(QueryKind::distance)].status[0] = PairStatus::overlapping;
  EXPECT_EQ(value_cost(), 0.25) << "a wrong class is not excused";
}

TEST_F(Judged, TheFakesAllocateNothingAndAreTimed) {
  for (const BackendResult& backend : result_.backends) {
    if (backend.name == "unsupported") continue;
    ASSERT_TRUE(backend.rows[0].single);
    EXPECT_GT(backend.rows[0].single->median_ns, 0.0);
    EXPECT_LE(backend.rows[0].single->minimum_ns, backend.rows[0].single->median_ns);
    EXPECT_LE(backend.rows[0].single->median_ns, backend.rows[0].single->p99_ns);
    if (thread_allocations()) {
      EXPECT_EQ(backend.rows[0].allocations, 0.0);
    }
  }
}

// ---- made-up results

SetResult made_up(double fast_cost, double slow_cost) {
  SetResult set;
  set.name = "made_up";
  set.cases = 10;
  const auto add = [&](const char* name, double ns, double cost) {
    BackendResult backend;
    backend.name = name;
    backend.judged = true;
    for (std::size_t q = 0; q < 3; ++q) {
      backend.rows[q].single = Timing{ns, ns, ns, 1};
      backend.judgement.worst[q] = {cost, 7, "depth"};
      backend.judgement.cost[q] = {cost, cost, cost, 7, 10};
    }
    set.backends.push_back(backend);
  };
  add("fast", 10, fast_cost);
  add("slow", 100, slow_cost);
  return set;
}

TEST(SpeedErrorPlot, EveryWrongBackendStandsOnTheRail) {
  SetResult set;
  set.name = "made_up";
  std::vector<std::string> names;
  for (int i = 0; i < 16; ++i) {
    BackendResult backend;
    backend.name = names.emplace_back("backend_" + std::to_string(i));
    backend.judged = true;
    for (Wrongness& wrong : backend.judgement.wrongness) wrong.missed = 1;
    set.backends.push_back(backend);
  }
  const std::string plot = speed_error_plot(set, QueryKind::overlap, axes_for(std::vector{set}), names, true);
  const std::regex label("class='label' x='[0-9.]+' y='([0-9.]+)'>(backend_[0-9]+)");
  std::set<std::string> shown;
  for (std::sregex_iterator at(plot.begin(), plot.end(), label), end; at != end; ++at) {
    EXPECT_LT(std::stod((*at)[1]), 325.0) << (*at)[2] << ": the picture is 330 high";
    shown.insert((*at)[2]);
  }
  EXPECT_EQ(shown.size(), names.size());
}

TEST(Ranking, OrdersTheRightOnesBySpeedAndGivesTheWrongOnesNoPlace) {
  std::vector<SetResult> sets = {made_up(1e-3, 1e-9), made_up(1e-2, 1e-9)};
  Ranking ranking = rank(sets, QueryKind::distance);
  ASSERT_EQ(ranking.standings.size(), 2u);
  EXPECT_EQ(ranking.standings[0].backend, "fast");
  EXPECT_EQ(ranking.standings[0].nanoseconds, 10.0);
  EXPECT_EQ(ranking.standings[0].worst_error, 1e-2);
  sets[1].backends[0].judgement.wrongness[index_of(QueryKind::distance)].missed = 1;
  ranking = rank(sets, QueryKind::distance);
  EXPECT_EQ(ranking.standings[0].backend, "slow");
  EXPECT_EQ(ranking.standings[1].wrong.missed, 1u);
}

TEST(ParetoFront, HoldsWhatNoneBeatsInBoth) {
  using ::testing::ElementsAre;
  EXPECT_THAT(pareto_front(made_up(1e-3, 1e-9), QueryKind::distance), ElementsAre("slow", "fast"));
  EXPECT_THAT(pareto_front(made_up(1e-9, 1e-3), QueryKind::distance), ElementsAre("fast"));
  EXPECT_THAT(pareto_front(made_up(1e-9, 1e-9), QueryKind::distance), ElementsAre("fast"));
  SetResult set = made_up(1e-3, 1e-9);
  set.backends[0].judgement.wrongness[index_of(QueryKind::distance)].undecided = 1;
  EXPECT_THAT(pareto_front(set, QueryKind::distance), ElementsAre("slow"));
}

// A cube on its edge upon another: one line touches, the clip of the faces nearest to n is as wide as the
// cube.
TEST_F(Judged, AnEdgeOnAFaceIsNoAreaError) {
  const PairSet tilted = [] {
    PairSet set = testing::cubes({-0.01});
    set.poses[1].R = rotation_from_quaternion(1.0, 0.0, 0.0, 0.3);
    return set;
  }();
  const std::vector<PairTruth> truth = {{PairClass::penetrating, -0.01, Vector3::UnitX(), true}};
  Options options;
  options.backends = {"right"};
  MeasureOptions measure;
  measure.time_pairs = false;
  const auto answers = answer_set(options, backends_, tilted, measure);
  const SetResult result = sum_up(tilted, truth, &oracle_, answers, 1);
  const auto errors = result.backends[0].judgement.errors;
  EXPECT_EQ(errors[static_cast<std::size_t>(Measure::patch_coverage)].over_scale.count, 0u);
  EXPECT_EQ(errors[static_cast<std::size_t>(Measure::stability)].over_scale.count, 0u);
  EXPECT_EQ(errors[static_cast<std::size_t>(Measure::tilted_coverage)].over_scale.count, 1u);
  EXPECT_EQ(error("right", Measure::tilted_coverage).count, 0u);
  EXPECT_EQ(error("right", Measure::patch_coverage).count, 3u);
}

// Points that hold half of a face, as an engine's may where the face is bent.
TEST_F(Judged, PointsOnHalfOfAFaceAreOffByHalfOfThePatch) {
  const PairSet cubes = testing::cubes({-0.01});
  const std::vector<PairTruth> truth = {{PairClass::penetrating, -0.01, Vector3::UnitX(), true}};
  Options options;
  options.backends = {"right"};
  MeasureOptions measure;
  measure.time_pairs = measure.perturb = false;
  auto answers = answer_set(options, backends_, cubes, measure);
  for (ContactPoint& point : answers[0].queries[index_of(QueryKind::manifold)].points)
    point.p_A_W.y() = std::min(point.p_A_W.y(), 0.0), point.p_B_W.y() = point.p_A_W.y();
  Report report;
  report.has_truth = true;
  report.sets = {sum_up(cubes, truth, &oracle_, answers, 1)};
  const Judgement& judgement = report.sets[0].backends[0].judgement;
  const Quantiles& coverage = judgement.errors[static_cast<std::size_t>(Measure::patch_coverage)].over_scale;
  ASSERT_EQ(coverage.count, 1u);
  EXPECT_DOUBLE_EQ(coverage.worst, 0.5);
  report.backends = {{"right", "a fake"}};
  EXPECT_THAT(html_report(report), HasSubstr("Patch coverage"));
  EXPECT_THAT(terminal_report(report), HasSubstr("patch"));
  const auto json = nlohmann::json::parse(results_json(report));
  EXPECT_EQ(json["pair_sets"][0]["backends"][0]["errors"]["patch_coverage"]["ratio"]["worst"], 0.5);
  EXPECT_THAT(results_csv(report), HasSubstr("patch_coverage"));
}

// ---- what is written

TEST_F(Judged, TableCsvAndJsonShowTheSameNumbers) {
  Report report;
  report.has_truth = true;
  report.sets = {result_};
  for (const BackendResult& backend : result_.backends)
    report.backends.emplace_back(backend.name, backend.description);
  const auto json = nlohmann::json::parse(results_json(report));
  const std::string table = terminal_report(report), html = html_report(report), csv = results_csv(report);
  ASSERT_EQ(json["pair_sets"][0]["backends"].size(), 8u);
  for (const auto& backend : json["pair_sets"][0]["backends"]) {
    const auto& single = backend["queries"]["overlap"]["single"];
    if (single.is_null()) continue;
    const double ns = single["median_ns"];
    EXPECT_THAT(table, HasSubstr(format_ns(ns)));
    EXPECT_THAT(html, HasSubstr("<td>" + format_ns(ns) + "</td>"));
    EXPECT_THAT(csv, HasSubstr("," + fmt::format("{}", ns) + ","));
  }
  const auto& phantom = json["pair_sets"][0]["backends"][2];
  EXPECT_EQ(phantom["backend"], "seeing_phantoms");
  EXPECT_EQ(phantom["queries"]["distance"]["wrong"]["phantom"], 3);
  EXPECT_EQ(phantom["queries"]["distance"]["worst"]["case"], "cubes:0");
  EXPECT_EQ(json["pair_sets"][0]["backends"][5]["queries"]["distance"]["wrong"]["unsupported"], 6);
}

TEST_F(Judged, ThePageMakesNoRequest) {
  Report report;
  report.has_truth = true;
  report.sets = {result_};
  for (const BackendResult& backend : result_.backends)
    report.backends.emplace_back(backend.name, backend.description);
  std::string html = html_report(report);
  for (std::size_t at; (at = html.find("http://www.w3.org/2000/svg")) != std::string::npos;)
    html.erase(at, 26);
  for (const char* outside : {"http:", "https:", "url(", "@import", "<link", "src=", "<script src"}) {
    EXPECT_THAT(html, Not(HasSubstr(outside)));
  }
}

TEST_F(Judged, AWrongBackendGetsNoSpeedMark) {
  const std::vector<std::string> names = {"right", "missing_contacts"};
  SetResult wrong_only = result_;
  std::erase_if(wrong_only.backends, [](const BackendResult& b) { return b.name != "missing_contacts"; });
  const std::string plot = speed_error_plot(wrong_only, QueryKind::overlap, {}, names, true);
  EXPECT_THAT(plot, HasSubstr("hollow"));
  EXPECT_THAT(plot, HasSubstr("3 missed"));
  EXPECT_THAT(plot, Not(HasSubstr("class='whisker")));
  EXPECT_THAT(plot, Not(HasSubstr("ns a pair")));
  SetResult right_only = result_;
  std::erase_if(right_only.backends, [](const BackendResult& b) { return b.name != "right"; });
  EXPECT_THAT(speed_error_plot(right_only, QueryKind::overlap, {}, names, true), HasSubstr("ns a pair"));
}

TEST_F(Judged, AWrongBackendGetsNoTimeMarkEither) {
  const std::vector<std::string> names = {"right", "missing_contacts"};
  SetResult wrong_only = result_;
  std::erase_if(wrong_only.backends, [](const BackendResult& b) { return b.name != "missing_contacts"; });
  const std::string plot = time_plot(wrong_only, QueryKind::overlap, {}, names, true);
  EXPECT_THAT(plot, HasSubstr("hollow"));
  EXPECT_THAT(plot, HasSubstr("3 of 6 wrong"));
  EXPECT_THAT(plot, Not(HasSubstr("class='whisker")));
  SetResult right_only = result_;
  std::erase_if(right_only.backends, [](const BackendResult& b) { return b.name != "right"; });
  EXPECT_THAT(time_plot(right_only, QueryKind::overlap, {}, names, true), HasSubstr("class='whisker"));
}

TEST_F(Judged, KeepsTheDearestWrongCasesAndTheDistribution) {
  const auto& missed = of("missing_contacts").wrong_cases[index_of(QueryKind::overlap)];
  ASSERT_EQ(missed.size(), 3u);
  EXPECT_EQ(missed[0].index, 4u);  // 0.5 deep
  EXPECT_EQ(missed[1].index, 3u);  // 0.25 deep
  EXPECT_EQ(missed[2].index, 5u);  // touching
  EXPECT_TRUE(of("right").wrong_cases[0].empty());
  const Curve& curve = of("off_by_1e-3").cost_curve[index_of(QueryKind::distance)];
  EXPECT_EQ(curve.back(), of("off_by_1e-3").cost[index_of(QueryKind::distance)].worst);
  EXPECT_TRUE(std::is_sorted(curve.begin(), curve.end()));
  const auto& errors = of("off_by_1e-3").signed_errors;
  ASSERT_EQ(errors.size(), 6u);
  for (const SignedError& each : errors)
    EXPECT_NEAR(each.error * posed_pair(set_, each.index).scale, 1e-3, 1e-15);
  EXPECT_TRUE(of("not_a_number").signed_errors.empty());
}

TEST(Backends, UnknownAndRepeatedNamesAreRefused) {
  Backends backends;
  testing::register_fakes(backends.registry);
  Options options;
  options.backends = {"right", "wrong_name"};
  EXPECT_THROW(chosen_backends(options, backends), InputError);
  options.backends = {"right", "right"};
  EXPECT_THROW(chosen_backends(options, backends), InputError);
}

}  // namespace
}  // namespace touchstone::comparison
