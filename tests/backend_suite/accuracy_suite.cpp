#include <cmath>
#include <iomanip>
#include <map>
#include <sstream>

#include "touchstone/examples/measures/accuracy/accuracy.hpp"
#include "touchstone/examples/measures/pairs/pair_families.hpp"
#include "touchstone/tests/backend_suite/accuracy_table.hpp"
#include "touchstone/tests/backend_suite/suite.hpp"

// The table of error bounds, per backend and family, held against the exact backend.

namespace touchstone::suite {
namespace {

using namespace touchstone::measures;

struct Family {
  PairSet set;
  std::vector<PairTruth> truth;
};

const Oracle& oracle() {
  static const std::unique_ptr<Oracle> exact = make_exact_oracle();
  return *exact;
}

const Family& family(const std::string& name) {
  static std::map<std::string, Family> made;
  Family& found = made[name];
  if (found.truth.empty()) {
    found.set = make_pair_family(name, kSeed, kPairs);
    found.truth = compute_truth(found.set, oracle(), 1);
  }
  return found;
}

AccuracyRow measured_row(const std::string& backend, const std::string& family_name) {
  const Family& pairs = family(family_name);
  const BackendRegistry::NarrowphaseEntry* entry = &backends().narrowphase(backend);
  MeasureOptions options;
  options.time_pairs = false;
  options.perturb = false;
  const std::vector<BackendAnswers> answers = run_backends({&entry, 1}, pairs.set, options);
  const Judgement judgement = judge(pairs.set, pairs.truth, oracle(), answers.at(0), 1);
  const Wrongness& overlap = judgement.wrongness[index_of(QueryKind::overlap)];
  const Wrongness& distance = judgement.wrongness[index_of(QueryKind::distance)];
  const auto worst = [&](Measure measure, bool supported) {
    const Quantiles& errors = judgement.errors[static_cast<std::size_t>(measure)].over_scale;
    return errors.count > 0 ? errors.worst : supported ? 0.0 : kUnsupported;
  };
  const Capabilities& can = answers[0].capabilities;
  return {entry->name,
          pairs.set.name,
          static_cast<int>(overlap.missed + overlap.phantom),
          static_cast<int>(overlap.undecided),
          static_cast<int>(distance.failed + distance.missing),
          worst(Measure::distance, can.distance),
          worst(Measure::depth, can.penetration)};
}

std::string printed(const AccuracyRow& row) {
  std::ostringstream text;
  text << std::scientific << std::setprecision(1) << "{\"" << row.backend << "\", \"" << row.family << "\", "
       << row.wrong_class << ", " << row.undecided << ", " << row.no_answer;
  for (const double error : {row.distance, row.depth}) {
    if (error == kUnsupported)
      text << ", kUnsupported";
    else
      text << ", " << error;
  }
  text << "},";
  return text.str();
}

class AccuracyTable : public testing::TestWithParam<std::string> {};

TEST_P(AccuracyTable, HoldsForEveryFamily) {
  for (const PairFamily& each : pair_families()) {
    const AccuracyRow row = measured_row(GetParam(), std::string(each.name));
    SCOPED_TRACE("measured " + printed(row));
    const auto table = accuracy_table();
    const auto found = std::find_if(table.begin(), table.end(), [&](const AccuracyRow& bound) {
      return bound.backend == row.backend && bound.family == row.family;
    });
    if (found == table.end()) {
      ADD_FAILURE() << "no row";
      continue;
    }
    EXPECT_LE(row.wrong_class, found->wrong_class);
    EXPECT_LE(row.undecided, found->undecided);
    EXPECT_LE(row.no_answer, found->no_answer);
    EXPECT_LE(row.distance, found->distance);
    EXPECT_LE(row.depth, found->depth);
    if (found->distance == kUnsupported) {
      EXPECT_EQ(row.distance, kUnsupported);
    }
  }
}

GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(AccuracyTable);  // a program may have none
INSTANTIATE_TEST_SUITE_P(AllBackends, AccuracyTable, testing::ValuesIn(narrowphase_names()),
                         [](const auto& test) { return test.param; });

}  // namespace

void link_accuracy_suite() {}

}  // namespace touchstone::suite
