#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <iomanip>
#include <limits>
#include <sstream>

#include "touchstone/adapters/scene_files/pair_file.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/tests/backend_suite/suite.hpp"

// The named hard cases. `exact` meets every one to the last bit and `native` every class and 1e-12 S; what
// the engines get wrong is on record.

namespace touchstone::suite {
namespace {

std::vector<PairCase> load_all() {
  std::vector<PairCase> all;
  for (const char* file :
       {"containment", "coplanar", "far", "hexahedra", "near_parallel", "scale", "thin", "touching"}) {
    const auto cases = load_pairs(std::string(TOUCHSTONE_HARD_CASES) + "/" + file + ".json");
    all.insert(all.end(), cases.begin(), cases.end());
  }
  return all;
}

const std::vector<PairCase>& hard_cases() {
  static const std::vector<PairCase> all = load_all();
  return all;
}

struct Posed {
  Body a, b;
  double expected;  ///< the exact signed distance, rounded to nearest
  bool contact;
};

Posed posed(const PairCase& hard) {
  const PosedPair& pair = *hard.pair;
  return {{pair.solids[0], pair.X_WS[0]},
          {pair.solids[1], pair.X_WS[1]},
          std::strtod(hard.exact->signed_distance.c_str(), nullptr),
          hard.exact->pair_class != PairClass::separated};
}

bool has(const std::string& name) {
  const std::vector<std::string> names = narrowphase_names();
  return std::find(names.begin(), names.end(), name) != names.end();
}

class HardCase : public testing::TestWithParam<std::size_t> {
 protected:
  const PairCase& hard() const { return hard_cases()[GetParam()]; }
};

TEST_P(HardCase, ExactIsRightToTheLastBit) {
  if (!has("exact")) return;
  ASSERT_TRUE(hard().pair.has_value()) << hard().invalid_reason;
  const Posed pair = posed(hard());
  const auto exact = backends().make_narrowphase("exact");
  const Answer answer = ask(*exact, pair.a, pair.b, {.kind = QueryKind::distance});
  EXPECT_EQ(answer.status, pair.contact ? PairStatus::overlapping : PairStatus::separated) << hard().why_hard;
  EXPECT_EQ(answer.geometry.separation, pair.expected) << hard().why_hard;
}

TEST_P(HardCase, NativeHasTheClassAndTheDistance) {
  ASSERT_TRUE(hard().pair.has_value()) << hard().invalid_reason;
  const Posed pair = posed(hard());
  const auto native = backends().make_narrowphase("native");
  const PairStatus expected = pair.contact ? PairStatus::overlapping : PairStatus::separated;
  EXPECT_EQ(ask(*native, pair.a, pair.b, {}).status, expected) << hard().why_hard;
  for (QueryKind kind : {QueryKind::distance, QueryKind::manifold}) {
    const Answer answer = ask(*native, pair.a, pair.b, {.kind = kind});
    EXPECT_EQ(answer.status, expected) << hard().why_hard;
    const double scale = scale_of(pair.a, pair.b);
    EXPECT_LE(std::abs(answer.geometry.separation - pair.expected), 1e-12 * scale)
        << hard().why_hard << ": " << answer.geometry.separation << " for " << pair.expected;
    EXPECT_EQ(answer.geometry.separation > 0.0, !pair.contact);
  }
}

TEST_P(HardCase, NativeSwappedHasTheSameBits) {
  const Posed pair = posed(hard());
  const auto native = backends().make_narrowphase("native");
  const Answer ab = ask(*native, pair.a, pair.b, {.kind = QueryKind::distance});
  const Answer ba = ask(*native, pair.b, pair.a, {.kind = QueryKind::distance});
  EXPECT_EQ(ab.status, ba.status);
  EXPECT_EQ(ab.geometry.separation, ba.geometry.separation);
  const bool identical = pair.a.solid.vertices() == pair.b.solid.vertices() &&
                         pair.a.X_WS.R == pair.b.X_WS.R && pair.a.X_WS.p == pair.b.X_WS.p;
  if (!identical) {
    EXPECT_EQ(ab.geometry.n_AB_W, Vector3(-ba.geometry.n_AB_W));
  }
}

std::string test_name(const testing::TestParamInfo<std::size_t>& test) {
  std::string name = hard_cases()[test.param].id;
  for (char& c : name)
    if (!std::isalnum(static_cast<unsigned char>(c))) c = '_';
  return name;
}

INSTANTIATE_TEST_SUITE_P(Named, HardCase, testing::Range<std::size_t>(0, hard_cases().size()), test_name);

// Errors of the checks that are not complete, on all cases above.
struct Record {
  std::string_view backend;
  int missed;   ///< `separated`, yet in contact
  int phantom;  ///< `overlapping`, yet apart
  int undecided;
  int failed;   ///< and unsupported, by the overlap query
  int far_off;  ///< signed distance given, off by more than 1e-6 S
  int refused;  ///< solids that build() refuses: too small or too large for the engine
};

// Measured with Bullet 3.24, ODE 0.16.2, libccd 2.1, FCL 0.7.0 and MuJoCo 2.2.2 as packaged by Debian 12, on
// x86-64.
constexpr Record kRecords[] = {
    // backend, missed, phantom, undecided, failed, far off, refused
    {"edge_face", 17, 0, 0, 0, 0, 0}, {"bullet", 5, 0, 45, 0, 3, 15},   {"bullet_gjk", 0, 0, 56, 0, 15, 15},
    {"ode", 8, 0, 0, 0, 10, 0},       {"libccd_gjk", 6, 6, 0, 6, 0, 0}, {"libccd_mpr", 23, 0, 0, 6, 25, 0},
    {"fcl", 8, 0, 0, 6, 14, 0},       {"fcl_indep", 0, 6, 0, 6, 0, 0},  {"mujoco", 3, 3, 0, 6, 32, 0},
};

void add_to(Record& measured, std::ostringstream& details, Narrowphase& narrowphase, const PairCase& hard) {
  const Posed pair = posed(hard);
  const PairStatus status = ask(narrowphase, pair.a, pair.b, {}).status;
  const bool missed = status == PairStatus::separated && pair.contact;
  const bool phantom = status == PairStatus::overlapping && !pair.contact;
  measured.missed += missed;
  measured.phantom += phantom;
  measured.undecided += status == PairStatus::undecided;
  measured.failed += status == PairStatus::failed || status == PairStatus::unsupported;
  const Answer answer = ask(narrowphase, pair.a, pair.b, {.kind = QueryKind::distance});
  const double error = std::abs(answer.geometry.separation - pair.expected);
  const bool far_off = error > 1e-6 * scale_of(pair.a, pair.b);  // false for NaN: nothing given
  measured.far_off += far_off;
  if (missed || phantom || far_off)
    details << "\n  " << hard.id << ": " << to_string(status) << ", " << answer.geometry.separation << " for "
            << pair.expected;
}

class HardCaseRecord : public testing::TestWithParam<std::string> {};

TEST_P(HardCaseRecord, IsAsMeasured) {
  const auto narrowphase = backends().make_narrowphase(GetParam());
  Record measured{GetParam(), 0, 0, 0, 0, 0, 0};
  std::ostringstream details;
  details << std::setprecision(std::numeric_limits<double>::max_digits10);
  for (const PairCase& hard : hard_cases()) {
    try {
      add_to(measured, details, *narrowphase, hard);
    } catch (const InputError& refusal) {
      ++measured.refused;
    }
  }
  const auto* record = std::find_if(std::begin(kRecords), std::end(kRecords),
                                    [&](const Record& r) { return r.backend == measured.backend; });
  const Record expected = record != std::end(kRecords) ? *record : Record{GetParam(), 0, 0, 0, 0, 0, 0};
  const auto figures = [](const Record& r) {
    return std::array{r.missed, r.phantom, r.undecided, r.failed, r.far_off, r.refused};
  };
  EXPECT_EQ(figures(measured), figures(expected))
      << "of " << hard_cases().size() << " cases:" << details.str();
}

INSTANTIATE_TEST_SUITE_P(AllBackends, HardCaseRecord, testing::ValuesIn(narrowphase_names()),
                         [](const auto& test) { return test.param; });

TEST(BadInputs, EachIsRefusedWithItsReason) {
  const auto cases = load_pairs(std::string(TOUCHSTONE_HARD_CASES) + "/bad_inputs.json");
  ASSERT_FALSE(cases.empty());
  for (const PairCase& bad : cases) {
    EXPECT_FALSE(bad.pair.has_value()) << bad.id;
    EXPECT_NE(bad.invalid_reason.find(bad.expected_error), std::string::npos)
        << bad.id << ": " << bad.invalid_reason;
  }
}

}  // namespace
}  // namespace touchstone::suite
