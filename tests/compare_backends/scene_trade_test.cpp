#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/mechanism/round_parts.hpp"
#include "touchstone/contact_core/scene/scene_instance.hpp"
#include "touchstone/examples/compare_backends/results/least_that_serves_page.hpp"
#include "touchstone/examples/compare_backends/run/scenes/pair_choice.hpp"
#include "touchstone/examples/compare_backends/run/scenes/scene_covers.hpp"
#include "touchstone/examples/compare_backends/run/scenes/scene_trade.hpp"
#include "touchstone/examples/measures/common/random.hpp"

// The smallest sufficient model: its reference against closed forms, its errors and its choices against brute
// force.

namespace touchstone::comparison {
namespace {

using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr double kPi = std::numbers::pi;
// The bracket's width, and what rounding of coordinates of up to 2 m adds.
constexpr double kTolerance = kBracketWidth + 4e-15;

class TradeTest : public ::testing::Test {
 protected:
  void SetUp() override {
    oracle_ = make_exact_oracle();
    if (!oracle_) GTEST_SKIP() << "no exact in this build";
  }
  ClearanceBracket clearance(const PairSet& set, std::vector<Tube> tubes) const {
    return true_clearance(set, 0, tubes, *oracle_);
  }
  std::unique_ptr<Oracle> oracle_;
};

Pose turned(const Vector3& rpy, const Vector3& p) {
  Vector6 position;
  position << p, rpy;
  return pose_from_position_vector(position);
}

// Solids 0 to n - 1 are a tube's facets, along z from 0 to 1.
struct TubeScene {
  static constexpr double kOuter = 0.208, kInner = 0.1;

  explicit TubeScene(int facets, const Pose& X_WT = {}) : X_WT_(X_WT) {
    tubes_.push_back(add_tube(facets, kOuter, kInner, X_WT));
  }

  Tube add_tube(int facets, double outer, double inner, const Pose& X_WT) {
    const Tube tube = {
        static_cast<SolidIndex>(set_.solids.size()), static_cast<std::size_t>(facets), outer, inner, 0, 1,
        polygon_error(outer, facets, false)};
    for (const PlacedHexahedron& facet : make_tube(outer, inner, 1.0, facets, false, {}, "tube").solids)
      add(facet.solid, X_WT);
    return tube;
  }
  SolidIndex add(const Hexahedron& solid, const Pose& X_WS) {
    set_.solids.push_back(solid);
    set_.poses.push_back(X_WS);
    return static_cast<SolidIndex>(set_.solids.size() - 1);
  }
  // In the tube's frame.
  TubeScene& with_box(const Vector3& size, const Pose& X_TB) {
    const SolidIndex box = add(Hexahedron::from_size(size), compose(X_WT_, X_TB));
    for (SolidIndex i = 0; i < tubes_.front().facets; ++i) set_.pairs.push_back({i, box});
    return *this;
  }

  PairSet set_;
  std::vector<Tube> tubes_;
  Pose X_WT_;
};

const Pose kAnywhere = turned({0.3, -0.7, 1.1}, {0.4, -0.2, 0.1});

TEST_F(TradeTest, ABoxInTheBoreIsAsFarAsItsFurthestCorner) {
  for (const double offset : {0.0, 0.013, 0.05}) {
    for (const Pose& X_WT : {Pose{}, kAnywhere}) {
      TubeScene scene(4, X_WT);
      scene.with_box({0.038, 0.03, 0.2}, {Matrix3::Identity(), {offset, 0.004, 0.5}});
      const ClearanceBracket got = clearance(scene.set_, scene.tubes_);
      const double expected = 0.1 - std::hypot(offset + 0.019, 0.019);
      EXPECT_NEAR(got.middle(), expected, kTolerance) << offset;
      EXPECT_LE(got.high - got.low, kBracketWidth);
    }
  }
}

TEST_F(TradeTest, OutsideAFaceAnEdgeATiltedPlateAndARimMeetTheirFormulas) {
  const double r = TubeScene::kOuter, tilt = 0.2;
  struct Case {
    Vector3 size;
    Pose X_TB;
    double expected;
  };
  const Matrix3 quarter = turned({0, 0, kPi / 4}, Vector3::Zero()).R;
  const Matrix3 leaning = turned({0, tilt, 0}, Vector3::Zero()).R;  // its face's normal is (sin t, 0, cos t)
  const Case cases[] = {
      {{0.1, 2, 0.2}, {Matrix3::Identity(), {0.3, 0.01, 0.5}}, 0.25 - r},           // face against the mantle
      {{0.2, 0.2, 0.3}, {quarter, {0.5, 0, 0.5}}, 0.5 - 0.1 * std::sqrt(2.0) - r},  // edge against the mantle
      {{0.05, 0.05, 0.05}, {Matrix3::Identity(), {0.15, 0, 1.1}}, 0.075},           // face against the end
      {{2, 2, 0.1},
       {leaning, leaning * Vector3(0, 0, -0.3)},
       0.25 - r * std::sin(tilt)},  // plate below the rim
  };
  for (const Case& each : cases) {
    TubeScene scene(5, kAnywhere);
    scene.with_box(each.size, each.X_TB);
    const ClearanceBracket got = clearance(scene.set_, scene.tubes_);
    EXPECT_NEAR(got.middle(), each.expected, kTolerance);
    EXPECT_FALSE(got.contact());
  }
}

TEST_F(TradeTest, ATubeInATubeIsApartByTheirRadiiLessTheOffset) {
  TubeScene scene(6);
  const Pose inner = {Matrix3::Identity(), {0.02 * std::cos(0.4), 0.02 * std::sin(0.4), 0.1}};
  scene.tubes_.push_back(scene.add_tube(7, 0.07, 0.03, inner));
  for (SolidIndex a = 0; a < 6; ++a)
    for (SolidIndex b = 6; b < 13; ++b) scene.set_.pairs.push_back({a, b});
  const ClearanceBracket got = clearance(scene.set_, scene.tubes_);
  const double expected = 0.1 - 0.07 - 0.02;
  EXPECT_LE(got.low, expected + 4e-15);
  EXPECT_GE(got.high, expected - 4e-15);
  EXPECT_LT(got.high - got.low, 1e-9);
}

TEST_F(TradeTest, ContactOfTheRoundPartIsToldWithinANanometre) {
  for (const double apart : {1e-9, -1e-9}) {
    TubeScene scene(8, kAnywhere);
    // Its corners at x = +-0.01 are `apart` from the bore.
    const double y = std::sqrt((0.1 - apart) * (0.1 - apart) - 0.01 * 0.01) - 0.01;
    scene.with_box({0.02, 0.02, 0.2}, {Matrix3::Identity(), {0, y, 0.5}});
    EXPECT_EQ(clearance(scene.set_, scene.tubes_).contact(), apart < 0) << apart;
  }
}

// A box's edge towards a corner of the bore's polygon: rho from the axis it is r - rho off the bore, and r -
// rho cos(pi / n) off the facets.
TEST_F(TradeTest, TheFacetsErrorFallsAsOneOverNSquaredAndIsNeverNone) {
  const double rho = 0.06, side = 0.02;
  double before = 0;
  for (const int n : {8, 16, 32, 64, 128}) {
    TubeScene scene(n);
    const Matrix3 towards = turned({0, 0, kPi / n + kPi / 4}, Vector3::Zero()).R;
    const Vector3 direction = {std::cos(kPi / n), std::sin(kPi / n), 0};
    scene.with_box({side, side, 0.2},
                   {towards, (rho - side / std::sqrt(2.0)) * direction + Vector3(0, 0, 0.5)});
    const ClearanceBracket truth = clearance(scene.set_, scene.tubes_);
    EXPECT_NEAR(truth.middle(), 0.1 - rho, kTolerance);
    const std::vector<double> facets = exact_clearance(scene.set_, *oracle_, 1);
    EXPECT_NEAR(facets[0], 0.1 - rho * std::cos(kPi / n), 1e-15);
    const TradeReference reference = {{truth}, {}, true, 0};
    const double error = geometry_error(reference, facets, scene.tubes_[0].offset, QueryKind::distance);
    EXPECT_NEAR(error, rho * (1 - std::cos(kPi / n)), 2 * kTolerance);
    EXPECT_LT(error, scene.tubes_[0].offset);
    EXPECT_GT(error, n <= 64 ? 1e-5 : 1e-6);
    EXPECT_TRUE(before == 0 || std::abs(before / error - 4) < 0.1) << n;
    before = error;
  }
}

TEST(Trade, AFrameCostsItsTrueSeparationWhereItsClassDiffers) {
  const TradeReference plain = {{{0.02, 0.02}, {0.5, 0.5}, {-0.1, -0.1}}, {}, false, 0};
  const auto error = [&](std::vector<double> model, QueryKind query) {
    return geometry_error(plain, model, {}, query);
  };
  EXPECT_EQ(error({0.02, 0.5, -0.1}, QueryKind::distance), 0);
  EXPECT_EQ(error({0.01, 0.4, -0.2}, QueryKind::overlap), 0);
  EXPECT_EQ(error({-3, 0.5, -0.1}, QueryKind::overlap), 0.02);
  EXPECT_EQ(error({-3, 0.5, -0.1}, QueryKind::manifold), 0.02);
  EXPECT_EQ(error({-3, 0.5, -0.1}, QueryKind::distance), 3.02);
  EXPECT_EQ(error({0.02, 0.5, 0.3}, QueryKind::overlap), 0.1);
  EXPECT_EQ(error({0.02, 0.25, -0.1}, QueryKind::distance), 0.25);
  EXPECT_EQ(error({0.02, 0.25, -0.1}, QueryKind::manifold), 0);
  EXPECT_DOUBLE_EQ(error({0.02, 0.5, -0.35}, QueryKind::manifold), 0.25);
}

TEST(Trade, InContactARoundPartCountsByItsFacetsOffset) {
  const TradeReference round = {{{-1, -0.01}}, {-0.03}, true, 0.002};
  const auto error = [&](double model, std::optional<double> offset, QueryKind query) {
    return geometry_error(round, std::vector<double>{model}, offset, query);
  };
  EXPECT_EQ(error(-0.5, 0.001, QueryKind::overlap), 0);
  EXPECT_EQ(error(-0.5, 0.001, QueryKind::distance), 0.001);
  EXPECT_EQ(error(-0.5, 0.001, QueryKind::manifold), 0.001);
  EXPECT_EQ(error(0.00025, 0.001, QueryKind::overlap), 0.00075);
  EXPECT_EQ(error(0.00025, 0.001, QueryKind::distance), 0.001);
  EXPECT_DOUBLE_EQ(error(-0.05, {}, QueryKind::distance),
                   0.022);  // a cover: the depth's difference and the facets'
  EXPECT_EQ(error(-0.05, {}, QueryKind::overlap), 0);
}

TEST(Trade, ABackendCostsWhatItMistakesAndNothingElse) {
  QueryAnswers answers;
  const std::vector<double> exact = {0.3, -0.2};  // two frames of one pair
  answers.status = {PairStatus::separated, PairStatus::overlapping};
  EXPECT_EQ(backend_error(answers, QueryKind::overlap, 1, exact), 0);
  answers.status = {PairStatus::separated, PairStatus::undecided};
  EXPECT_EQ(backend_error(answers, QueryKind::overlap, 1, exact), 0.2);
  answers.status = {PairStatus::overlapping, PairStatus::separated};
  EXPECT_EQ(backend_error(answers, QueryKind::overlap, 1, exact), 0.3);
  answers.status = {PairStatus::separated, PairStatus::overlapping};
  answers.geometry.resize(2);
  answers.geometry[0].separation = 0.31;
  answers.geometry[1].separation = -0.2;
  EXPECT_NEAR(backend_error(answers, QueryKind::distance, 1, exact), 0.01, 1e-16);
  answers.geometry[0].separation = std::nan("");
  EXPECT_EQ(backend_error(answers, QueryKind::distance, 1, exact), kInfinity);
  EXPECT_EQ(backend_error(answers, QueryKind::manifold, 1, exact), 0)
      << "what is apart is not asked of a manifold";
}

TEST_F(TradeTest, ThePairsThatDecideLeaveNoFrameWithoutItsLeast) {
  Random random(7);
  // Solids that fly past each other.
  PairSet set;
  constexpr std::size_t kSolids = 9, kFrames = 450;  // more than two passes
  std::vector<Pose> at;
  std::vector<Vector3> velocity;
  for (std::size_t i = 0; i < kSolids; ++i) {
    set.solids.push_back(Hexahedron::from_size({random.uniform(0.1, 1), random.uniform(0.1, 1), 0.3}));
    at.push_back(
        {random_rotation(random), {random.uniform(0, 4), random.uniform(0, 4), random.uniform(0, 4)}});
    velocity.push_back(random_direction(random) * 0.006);
    for (std::size_t j = 0; j < i; ++j)
      set.pairs.push_back({static_cast<SolidIndex>(j), static_cast<SolidIndex>(i)});
  }
  for (std::size_t f = 0; f < kFrames; ++f)
    for (std::size_t i = 0; i < kSolids; ++i) {
      set.poses.push_back(at[i]);
      at[i].p += velocity[i];
    }
  // Of all pairs those that decide, the same on any number of threads.
  const double reach = 0.01;
  const std::vector<std::size_t> chosen = pairs_that_decide(set, reach, *oracle_, 2);
  EXPECT_LT(chosen.size(), set.pairs.size());
  EXPECT_EQ(chosen, pairs_that_decide(set, reach, *oracle_, 1));
  std::vector<bool> is_chosen(set.pairs.size());
  for (const std::size_t p : chosen) is_chosen[p] = true;
  // In each frame the least of these is the least of all, and all within reach are among them.
  for (std::size_t f = 0; f < kFrames; ++f) {
    double least = kInfinity, least_of_chosen = kInfinity;
    for (std::size_t p = 0; p < set.pairs.size(); ++p) {
      const PosedPair posed = posed_pair(set, f * set.pairs.size() + p);
      const double separation = oracle_->truth(posed.a, posed.b).separation;
      least = std::min(least, separation);
      if (is_chosen[p]) least_of_chosen = std::min(least_of_chosen, separation);
      EXPECT_TRUE(is_chosen[p] || separation > reach) << "frame " << f << " pair " << p;
    }
    ASSERT_EQ(least_of_chosen, least) << "frame " << f;
  }
}

TEST(Covers, EncloseWhatHangsBelowAndEndAtTheHexahedra) {
  // A ring of eight parts and a box.
  Scene scene;
  scene.name = "made up";
  scene.frame_rate = 10;
  scene.contact_gap = 1e-9;
  scene.duration = 1;
  scene.objects.push_back(
      {HexahedronTree(make_tube(2, 1, 3, 8, false, {}, "ring").solids, "ring"), {}, {}, {}});
  scene.objects.push_back(
      {HexahedronTree({{"box", Hexahedron::from_size({1, 1, 1}), {}}}, "box"), {}, {}, {}});
  ASSERT_EQ(cover_levels(scene), 3);
  // Level by level the ring's cover gets more hexahedra; the box is its own.
  std::size_t before = 0;
  for (int level = 0; level < 3; ++level) {
    const Scene covered = with_covers(scene, level);
    const SceneInstance instance(covered);
    EXPECT_EQ(covered.objects[0].tree.solids().size(), 1u << level);
    EXPECT_EQ(covered.objects[1].tree.solids()[0].name, "box");
    EXPECT_GT(instance.solids().size(), before);
    before = instance.solids().size();
  }
  // The first level encloses the ring.
  const PlacedHexahedron& root = with_covers(scene, 0).objects[0].tree.solids()[0];
  const double corner = 2 / std::cos(kPi / 8) * std::cos(kPi / 8);  // a facet faces +-x and +-y
  EXPECT_NEAR(root.solid.half_extents().x(), corner, 1e-15);
  EXPECT_NEAR(root.solid.half_extents().z(), 1.5, 1e-15);
  EXPECT_NEAR(root.X_OS.p.z(), 1.5, 1e-15);
  scene.exempt_pairs = {{"ring/ring.0", "box"}};
  EXPECT_EQ(cover_levels(scene), 0) << "no cover has the hexahedron that the exemption names";
}

TradeRow row(const char* model, double ns, double geometry, double backend) {
  TradeRow result;
  result.backend = "native";
  result.model = model;
  result.query = QueryKind::distance;
  result.frame_ns = ns;
  result.geometry_error = geometry;
  result.backend_error = backend;
  return result;
}

TEST(Trade, TheSumOfTheErrorsDecidesWhatServes) {
  SceneTrade trade;
  trade.rows = {row("coarse", 10, 5e-3, 0), row("fine", 100, 6e-5, 6e-5), row("finer", 400, 0, 0),
                row("slow", 500, 0, 0)};
  EXPECT_EQ(cheapest_row(trade, QueryKind::distance, 1e-2)->model, "coarse");
  EXPECT_EQ(cheapest_row(trade, QueryKind::distance, 1e-4)->model, "finer") << "each error alone is allowed";
  EXPECT_EQ(cheapest_row(trade, QueryKind::distance, 2e-4)->model, "fine");
  EXPECT_EQ(cheapest_row(trade, QueryKind::overlap, 1), nullptr);
  const std::vector<TradeStep> steps = trade_steps(trade, QueryKind::distance);
  ASSERT_EQ(steps.size(), 3u);
  EXPECT_EQ(steps[0].row->model, "finer");
  EXPECT_EQ(steps[0].allowed, 1e-9);
  EXPECT_EQ(steps[1].row->model, "fine");
  EXPECT_EQ(steps[1].allowed, 1e-3);
  EXPECT_EQ(steps[2].row->model, "coarse");
}

TEST(Trade, ThePageHasEverySceneAndSelection) {
  Report report;
  report.machine.version = "1.2.3";
  EXPECT_EQ(least_that_serves_page(report), "");
  SceneResult& scene = report.scenes.emplace_back();
  scene.name = "made up";
  scene.trade.frames = 12;
  scene.trade.rows = {row("16 facets", 10, 5e-3, 0)};
  scene.trade.rows[0].pairs = scene.trade.rows[0].all_pairs = 48;
  report.selection = {{1000, 500, 321, Timing{}}};
  const std::string page = least_that_serves_page(report);
  EXPECT_THAT(page, HasSubstr("## made up"));
  EXPECT_THAT(page, HasSubstr("| distance | native, 16 facets, 48 pairs | 1.0e-02 | 10.0 | 5.0e-03 | 0 |"));
  EXPECT_THAT(page, HasSubstr("| overlap | nothing |"));
  EXPECT_THAT(page, HasSubstr("| 500 | 321 |"));
  EXPECT_THAT(page, HasSubstr("Touchstone 1.2.3"));
  EXPECT_THAT(page, ContainsRegex("; 2[0-9][0-9][0-9]-[01][0-9]-[0-3][0-9]\\.\n")) << "when it was measured";
  EXPECT_THAT(page, HasSubstr("No recommendation for distance: too few frames (12"));
}

}  // namespace
}  // namespace touchstone::comparison
