#include "touchstone/examples/compare_backends/judge/choice.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "touchstone/adapters/all/all_backends.hpp"
#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/examples/compare_backends/judge/upper_bound.hpp"
#include "touchstone/examples/compare_backends/judge/verdict.hpp"
#include "touchstone/examples/compare_backends/results/json_writer.hpp"
#include "touchstone/examples/compare_backends/results/results_file.hpp"
#include "touchstone/examples/compare_backends/run/comparison.hpp"
#include "touchstone/examples/compare_backends/run/sets/set_summary.hpp"
#include "touchstone/examples/measures/pairs/pair_families.hpp"
#include "touchstone/tests/compare_backends/random_choices.hpp"

namespace touchstone::comparison {
namespace {

using ::testing::HasSubstr;

// ---- grids

TEST(CostCodes, AreTwoDigitDecimalsRoundedUp) {
  EXPECT_EQ(cost_of_code(0), 0.0);
  EXPECT_EQ(cost_of_code(1), 1e-18);
  EXPECT_EQ(cost_of_code(kLastCode), kInfinity);
  for (const double decimal : {1e-9, 1e-6, 1.3e-4, 9.9e-3, 1e-2, 7.0, 99.0, 1e3})
    EXPECT_EQ(cost_of_code(code_of_cost(decimal)), decimal);
  EXPECT_EQ(code_of_cost(0.0), 0u);
  EXPECT_EQ(code_of_cost(5e-324), 1u) << "a wrong class is never free";
  EXPECT_EQ(cost_of_code(code_of_cost(1.0000001e-6)), 1.1e-6);
  EXPECT_EQ(code_of_cost(1e300), kLastCode);
  Random random(1);
  for (int i = 0; i < 10000; ++i) {
    const double cost = random.binary_scale(-55, 30);
    const std::uint32_t code = code_of_cost(cost);
    ASSERT_GE(cost_of_code(code), cost);
    ASSERT_LT(cost_of_code(code - 1), cost);
  }
}

TEST(CostCodes, StrataGoByTheExactClassAndTheBinsEndsBelongToThem) {
  EXPECT_EQ(stratum_of(0.0, true, 1.0, 5.0), (Stratum{Band::touching, 0, 1}));
  EXPECT_EQ(stratum_of(-0.01, true, 1.0, 10.0), (Stratum{Band::touching, 0, 1}));
  EXPECT_EQ(stratum_of(-0.0101, true, 1.0, 10.1), (Stratum{Band::deep, 0, 2}));
  EXPECT_EQ(stratum_of(1e-6, false, 1.0, 1.0), (Stratum{Band::apart, 0, 0}));
  EXPECT_EQ(stratum_of(1.1e-6, false, 1.0, 1e9), (Stratum{Band::apart, 1, kWithinBins.size()}));
  EXPECT_EQ(coverage_bin(1.0), kCoverageBins.size() - 1);
  EXPECT_EQ(coverage_bin(0.5), 2u);
  EXPECT_EQ(coverage_bin(0.49), 1u);
  EXPECT_EQ(coverage_bin(0.0), 0u);
}

TEST(CostCurves, TextBringsThemBack) {
  Random random(5);
  for (const ChoiceSet& set : made_up_choice_sets(random)) {
    for (const ChoiceSet::Backend& backend : set.backends) {
      for (const QueryKind kind : kQueryKinds) {
        const CostCurves& curves = backend.queries[index_of(kind)].curves;
        EXPECT_EQ(curves_from(text_of(curves, kind), kind), curves);
      }
    }
  }
  for (const char* bad : {"!", "A", "D", "g", "AAAAAAAAAAAAAAAAAA"})
    EXPECT_THROW(curves_from(bad, QueryKind::overlap), InputError) << bad;
}

// ---- against brute force over the answers themselves

// A run whose cases are all kept.
class RealRun : public ::testing::Test {
 protected:
  struct Kept {
    PairSet set;
    std::vector<PairTruth> truth;
    std::vector<BackendAnswers> answers;
    std::vector<std::vector<CaseErrors>> errors;  // by backend
    std::vector<PosedPair> posed;
  };

  static void SetUpTestSuite() {
    oracle_ = make_exact_oracle();
    if (oracle_ == nullptr) return;
    Backends backends;
    register_all_backends(backends.registry);
#ifdef BULLET_SINGLE_WORKER
    backends.workers.push_back(describe_worker(BULLET_SINGLE_WORKER));
#endif
    // Answers and errors of all backends on a few families, each pair kept for counting.
    std::vector<SetResult> results;
    for (const char* family :
         {"random", "near_1e-3", "near_1e-7", "resting", "tapered", "slabs_needles", "far"}) {
      Kept& kept = kept_.emplace_back();
      kept.set = make_pair_family(family, 1, 150);
      kept.truth = compute_truth(kept.set, *oracle_, 2);
      MeasureOptions measure;
      measure.perturb = false;
      measure.repetitions = 1;
      measure.slow_seconds = measure.tail_seconds = 1e-3;
      kept.answers = answer_set({}, backends, kept.set, measure);
      results.push_back(sum_up(kept.set, kept.truth, oracle_.get(), kept.answers, 2));
      for (std::size_t i = 0; i < kept.set.cases(); ++i) kept.posed.push_back(posed_pair(kept.set, i));
      for (const BackendAnswers& answers : kept.answers) {
        auto& errors = kept.errors.emplace_back();
        for (std::size_t i = 0; i < kept.set.cases(); ++i)
          errors.push_back(case_errors(kept.posed[i], kept.truth[i], *oracle_, answers, i));
      }
    }
    // Sets of choices as results.json has them.
    Report report;
    report.has_truth = true;
    report.choices = choice_sets(results);
    sets_ = choice_sets_of(Json::parse(results_json(report)), "test");
  }
  void SetUp() override {
    if (oracle_ == nullptr) GTEST_SKIP() << "without `exact` nothing is judged";
  }

  static bool is_asked(const Choice& choice, const PairTruth& truth, const PosedPair& posed) {
    if (posed.scale > choice.within) return false;
    if (truth.separation > 0) return choice.apart && truth.separation <= choice.apart_up_to;
    return -truth.separation <= 0.01 * posed.size ? choice.touching : choice.deep;
  }

  struct Count {
    std::size_t cases = 0, beyond = 0, unsupported = 0;
    double worst = 0;
  };
  // Case by case, without bins.
  static Count counted(const Choice& choice, const std::string& backend) {
    Count count;
    const std::size_t q = index_of(choice.query);
    for (const Kept& kept : kept_) {
      if (!choice.has_set(kept.set.name)) continue;
      for (std::size_t b = 0; b < kept.answers.size(); ++b) {
        if (kept.answers[b].name != backend) continue;
        for (std::size_t i = 0; i < kept.truth.size(); ++i) {
          if (!is_asked(choice, kept.truth[i], kept.posed[i])) continue;
          ++count.cases;
          if (kept.answers[b].queries[q].status[i] == PairStatus::unsupported) {
            ++count.unsupported;
            continue;
          }
          const CaseErrors& errors = kept.errors[b][i];
          const double cost = errors.charges[q][choice.asked()].cost;
          const bool covers = choice.query != QueryKind::manifold || errors.coverage >= choice.min_coverage;
          count.beyond += cost > choice.max_error || !covers;
          count.worst = std::max(count.worst, cost);
        }
      }
    }
    return count;
  }

  static std::set<std::string> inside(const Choice& choice) {
    std::set<std::string> names;
    for (const Candidate& candidate : decide(sets_, choice).candidates)
      if (candidate.inside) names.insert(candidate.backend);
    return names;
  }

  static std::unique_ptr<Oracle> oracle_;
  static std::vector<Kept> kept_;
  static std::vector<ChoiceSet> sets_;
};
std::unique_ptr<Oracle> RealRun::oracle_;
std::vector<RealRun::Kept> RealRun::kept_;
std::vector<ChoiceSet> RealRun::sets_;

void expect_counted(const Candidate& candidate, const Choice& choice, std::size_t cases, std::size_t beyond,
                    std::size_t unsupported, double worst) {
  const std::string what = candidate.backend + as_json(choice).dump();
  EXPECT_EQ(candidate.wrong.cases, cases) << what;
  EXPECT_EQ(candidate.wrong.unsupported, unsupported) << what;
  EXPECT_EQ(candidate.beyond, beyond) << what;
  EXPECT_EQ(candidate.worst_cost, cost_of_code(code_of_cost(worst))) << what;
  const bool within = unsupported == 0 &&
                      static_cast<double>(beyond) <= choice.share * static_cast<double>(cases) &&
                      std::isfinite(candidate.nanoseconds);
  EXPECT_EQ(candidate.inside, within) << what;
}

TEST_F(RealRun, VerdictsAtFourBudgetsAreThoseOfTheCasesThemselves) {
  for (const QueryKind query : kQueryKinds) {
    for (const double budget : {1e-9, 1e-6, 1e-3, 1e-2}) {
      for (const double share : {0.0, 1e-2}) {
        Choice choice;
        choice.query = query;
        choice.max_error = budget;
        choice.share = share;
        for (const Candidate& candidate : decide(sets_, choice).candidates) {
          const Count count = counted(choice, candidate.backend);
          expect_counted(candidate, choice, count.cases, count.beyond, count.unsupported, count.worst);
        }
      }
    }
  }
}

TEST_F(RealRun, ThreeHundredChoicesOnTheGridAreThoseOfTheCasesThemselves) {
  Random random(300);
  std::size_t compared = 0;
  for (int i = 0; i < 300; ++i) {
    Choice choice = random_choice(random, sets_);
    choice.apart_up_to = upper_end(choice.apart_up_to, kApartBins);
    choice.within = upper_end(choice.within, kWithinBins);
    choice.max_error = cost_of_code(std::min(code_of_cost(choice.max_error), kLastCode - 1));
    choice.min_coverage = upper_end(choice.min_coverage, kCoverageBins);
    choice.deadline = kInfinity;
    choice.no_allocations = false;
    for (const Candidate& candidate : decide(sets_, choice).candidates) {
      const Count count = counted(choice, candidate.backend);
      expect_counted(candidate, choice, count.cases, count.beyond, count.unsupported, count.worst);
      compared += count.cases > 0;
    }
  }
  EXPECT_GT(compared, 1000u);
}

// Off the grids nothing dearer passes than was asked for.
TEST_F(RealRun, OffTheGridVerdictsErrToTheSafeSide) {
  Random random(301);
  for (int i = 0; i < 100; ++i) {
    Choice choice = random_choice(random, sets_);
    choice.apart_up_to = choice.within = kInfinity;
    choice.max_error = random.binary_scale(-40, 0);
    for (const Candidate& candidate : decide(sets_, choice).candidates)
      EXPECT_GE(candidate.beyond, counted(choice, candidate.backend).beyond) << candidate.backend;
  }
}

// Ordinary contacts, asked whether and how deep: one in fifty may be beyond. (With normals and points GJK's
// are a metre off in a few of a hundred tapered pairs, whatever the budget, and single precision comes in at
// none.)
TEST_F(RealRun, EveryBudgetHasItsOwnBackendsOverOrdinaryFamilies) {
#ifdef BULLET_SINGLE_WORKER
  // For each budget the backends inside it, each counted pair by pair.
  for (const QueryKind query : {QueryKind::distance, QueryKind::manifold}) {
    std::vector<std::set<std::string>> by_budget;
    for (const double budget : {1e-9, 1e-6, 1e-3, 1e-2}) {
      Choice choice;
      choice.query = query;
      choice.sets = {"random", "near_1e-3", "resting", "tapered"};
      choice.apart = choice.normals = choice.points = false;
      choice.max_error = budget;
      choice.share = 0.02;
      by_budget.push_back(inside(choice));
      for (const Candidate& candidate : decide(sets_, choice).candidates) {
        const Count count = counted(choice, candidate.backend);
        expect_counted(candidate, choice, count.cases, count.beyond, count.unsupported, count.worst);
      }
    }
    // A larger budget has all of a smaller one's backends, and more.
    for (std::size_t i = 1; i < by_budget.size(); ++i) {
      EXPECT_GT(by_budget[i].size(), by_budget[i - 1].size()) << to_string(query) << i;
      EXPECT_TRUE(std::includes(by_budget[i].begin(), by_budget[i].end(), by_budget[i - 1].begin(),
                                by_budget[i - 1].end()));
    }
  }
#else
  GTEST_SKIP() << "a build without single-precision Bullet has fewer to choose from";
#endif
}

// Contacts near touching, with normals and points: one in twenty may be beyond.
TEST_F(RealRun, AtFourBudgetsOtherBackendsAreInsideForDistanceAndManifold) {
  const std::vector<std::string> names = all_backend_names();
  for (const char* needed : {"bullet", "bullet_gjk", "mujoco"}) {
    if (std::find(names.begin(), names.end(), needed) == names.end())
      GTEST_SKIP() << "a build without " << needed << " has fewer to choose from";
  }
  for (const QueryKind query : {QueryKind::distance, QueryKind::manifold}) {
    std::vector<std::set<std::string>> by_budget;
    for (const double budget : {1e-9, 1e-6, 1e-3, 1e-2}) {
      Choice choice;
      choice.query = query;
      choice.sets = {"near_1e-7", "near_1e-3"};
      choice.apart = false;
      choice.max_error = budget;
      choice.share = 0.05;
      by_budget.push_back(inside(choice));
    }
    for (std::size_t i = 1; i < by_budget.size(); ++i) {
      EXPECT_GT(by_budget[i].size(), by_budget[i - 1].size()) << to_string(query) << i;
      EXPECT_TRUE(std::includes(by_budget[i].begin(), by_budget[i].end(), by_budget[i - 1].begin(),
                                by_budget[i - 1].end()));
    }
  }
}

// ---- choices on made-up results

class MadeUp : public ::testing::Test {
 protected:
  // One set, 1 000 contacts 1 mm deep and 1 000 pairs 0.5 m apart, of unit cubes.
  static ChoiceSet::Answers answers(double ns, double cost_in_contact, bool answers_apart,
                                    std::size_t beyond = 1000) {
    ChoiceSet::Answers made;
    made.nanoseconds = ns;
    made.p999_ns = 10 * ns;
    made.allocations = 0;
    CurveBuilder builder(QueryKind::distance);
    for (std::size_t i = 0; i < 2000; ++i) {
      CurveCase each;
      each.contact = i < 1000;
      each.stratum = stratum_of(each.contact ? -1e-3 : 0.5, each.contact, 1.7, 3.0);
      each.status = each.contact    ? PairStatus::overlapping
                    : answers_apart ? PairStatus::separated
                                    : PairStatus::unsupported;
      each.index = 0;
      each.costs.fill({i < beyond ? cost_in_contact : 0.0, "depth", false});
      builder.add(each);
    }
    made.curves = builder.take();
    return made;
  }
  void add(const char* name, const ChoiceSet::Answers& of) {
    sets_[0].backends.push_back({name, {of, of, of}});
  }
  Candidate of(const char* name, const Choice& choice) const {
    for (const Candidate& candidate : decide(sets_, choice).candidates)
      if (candidate.backend == name) return candidate;
    throw std::runtime_error(name);
  }
  MadeUp() {
    sets_[0].name = "made_up";
    sets_[0].cases = 2000;
    sets_[0].ids = {"made_up:0"};
    choice_.max_error = 1e-4;
  }

  std::vector<ChoiceSet> sets_ = std::vector<ChoiceSet>(1);
  Choice choice_;
};

TEST_F(MadeUp, AnEngineOfContactsIsComparedOnContacts) {
  add("engine", answers(10, 5e-5, false));
  add("all", answers(100, 0, true));
  Verdict verdict = decide(sets_, choice_);
  EXPECT_EQ(verdict.fastest, "all");
  EXPECT_EQ(reason_out(verdict, verdict.candidates[1]), "1 000 of 2 000 unsupported");
  choice_.apart = false;
  verdict = decide(sets_, choice_);
  EXPECT_EQ(verdict.fastest, "engine");
  EXPECT_EQ(verdict.cases, 1000u);
  EXPECT_THAT(
      sentence(verdict),
      HasSubstr("fastest within 0.0001 m on every distance case (contacts only): engine, 10.0 ns a pair"));
  EXPECT_THAT(sentence(verdict), HasSubstr("of 1 000 of 2 000 cases"));
  EXPECT_EQ(of("engine", choice_).wrong.total(), 0u);
}

TEST_F(MadeUp, AShareMayBeBeyond) {
  add("fast", answers(10, 1e-3, true, 2));
  add("slow", answers(100, 0, true));
  EXPECT_EQ(decide(sets_, choice_).fastest, "slow");
  choice_.share = 1e-3;  // 2 of 2 000: at the limit is inside
  const Verdict verdict = decide(sets_, choice_);
  EXPECT_EQ(verdict.fastest, "fast");
  EXPECT_EQ(
      sentence(verdict),
      fmt::format("fastest within 0.0001 m on all but 0.1 % of distance cases: fast, 10.0 ns a pair; 0.1 % "
                  "of these pairs are beyond it, at most {:.2g} % (95 %); of 2 000 of 2 000 cases",
                  100 * upper_bound_95(2, 2000)));
  choice_.share = 0.9e-3;
  EXPECT_EQ(decide(sets_, choice_).fastest, "slow");
  EXPECT_THAT(reason_out(decide(sets_, choice_), of("fast", choice_)), HasSubstr("depth in made_up:0"));
}

TEST_F(MadeUp, DeadlinesAndAllocationsTakeOut) {
  add("fast", answers(10, 0, true));
  add("slow", answers(100, 0, true));
  add("unknown", answers(1000, 0, true));
  for (auto& query : sets_[0].backends[0].queries) query.allocations = 2;
  for (auto& query : sets_[0].backends[2].queries) query.p999_ns = query.allocations = std::nan("");
  choice_.deadline = 1e-7;
  Verdict verdict = decide(sets_, choice_);
  EXPECT_EQ(verdict.fastest, "fast");
  EXPECT_EQ(reason_out(verdict, of("slow", choice_)), "a call takes 1 000 ns at 99.9 %");
  EXPECT_EQ(reason_out(verdict, of("unknown", choice_)), "too few calls for 99.9 %");
  choice_.deadline = kInfinity;
  choice_.no_allocations = true;
  verdict = decide(sets_, choice_);
  EXPECT_EQ(verdict.fastest, "slow");
  EXPECT_EQ(reason_out(verdict, of("fast", choice_)), "2 allocations a query");
  EXPECT_EQ(reason_out(verdict, of("unknown", choice_)), "allocations not counted");
}

TEST_F(MadeUp, NothingLeftIsSaidAndABackendMustBeInEverySet) {
  add("one", answers(10, 0, true));
  choice_.deep = true;
  choice_.apart = choice_.touching = false;  // 1 mm of 1.7 m is touching
  const Verdict verdict = decide(sets_, choice_);
  EXPECT_TRUE(verdict.is_empty());
  EXPECT_EQ(sentence(verdict), "nothing is compared: none of 2 000 cases is in what was chosen (deep only)");
  sets_.push_back(sets_[0]);
  sets_[1].name = "more";
  sets_[1].backends[0].name = "other";
  const Choice all;
  EXPECT_EQ(decide(sets_, all).fastest, "");
  EXPECT_EQ(reason_out(decide(sets_, all), of("one", all)), "not measured in more");
  Choice chosen;
  chosen.sets = {"more"};
  EXPECT_EQ(decide(sets_, chosen).fastest, "other");
}

TEST(Percent, HasTwoDigitsAndNoPowerAtTheTop) {
  EXPECT_EQ(format_percent(0.00012345), "0.012");
  EXPECT_EQ(format_percent(0.994), "99");
  EXPECT_EQ(format_percent(0.996), "99.6");
  EXPECT_EQ(format_percent(1), "100");
}

TEST_F(MadeUp, AMissingTimeIsNeverInside) {
  add("untimed", answers(std::nan(""), 0, true));
  const Verdict verdict = decide(sets_, choice_);
  EXPECT_EQ(verdict.fastest, "");
  EXPECT_EQ(reason_out(verdict, verdict.candidates[0]), "not timed in every set");
}

}  // namespace
}  // namespace touchstone::comparison
