#include "touchstone/contact_core/mechanism/configuration_check.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/contact_core/mechanism/arms/ssrms.hpp"
#include "touchstone/contact_core/native/native.hpp"
#include "touchstone/tests/mechanism/random_chain.hpp"
#include "touchstone/tests/support/counting_allocator.hpp"
#include "touchstone/tests/support/random_solid.hpp"

namespace touchstone {
namespace {

std::shared_ptr<const HexahedronTree> tree(const std::string& name, const Hexahedron& solid,
                                           const Pose& X_OS = {}) {
  return std::make_shared<const HexahedronTree>(std::vector<PlacedHexahedron>{{"solid", solid, X_OS}}, name);
}

/// The same question without boxes, trees or early ends: every pair, at once. By mechanism, base and
/// obstacles; what is carried and exempt is given as it is.
class Plain {
 public:
  explicit Plain(const ConfigurationScene& scene) : scene_(scene) {
    const Mechanism& mechanism = *scene.mechanism;
    moving_ = static_cast<std::uint32_t>(mechanism.solids().size());
    std::vector<Hexahedron> solids = mechanism.solids();
    X_WS_.resize(moving_);
    for (const Obstacle& obstacle : scene.obstacles)
      for (const PlacedHexahedron& placed : obstacle.tree->solids()) {
        solids.push_back(placed.solid);
        X_WS_.push_back(compose(obstacle.X_WO, placed.X_OS));
      }
    for (std::uint32_t a = 0; a < moving_; ++a)
      for (std::uint32_t b = a + 1; b < solids.size(); ++b)
        if (b < moving_ ? !mechanism.is_exempt(a, b) && !moves_with(a, b) : !moves_with(a, moving_))
          pairs_.push_back({a, b});
    native_->build(solids);
    status_.resize(pairs_.size());
  }

  bool is_free(std::span<const double> q) {
    const Mechanism& mechanism = *scene_.mechanism;
    std::vector<Pose> X_WL(mechanism.links().size());
    mechanism.link_poses(rigid_frame(scene_.X_WB), q, X_WL);
    for (std::uint32_t i = 0; i < moving_; ++i)
      X_WS_[i] = compose(X_WL[mechanism.link_of(i)], mechanism.placed(i).X_OS);
    native_->evaluate({pairs_, X_WS_, {.kind = QueryKind::overlap}}, {status_, {}, {}}, *workspace_);
    for (const PairStatus status : status_)
      if (status != PairStatus::separated) return false;
    return true;
  }

 private:
  /// Nothing that moves is between the links; moving_ stands for the world.
  bool moves_with(std::uint32_t a, std::uint32_t b) const {
    const Mechanism& mechanism = *scene_.mechanism;
    const auto moving_joints = [&](std::uint32_t solid) {
      std::vector<std::uint32_t> out;
      if (solid < moving_)
        for (const std::uint32_t joint : mechanism.chain(mechanism.link_of(solid)))
          if (mechanism.joints()[joint].value != Mechanism::kNone) out.push_back(joint);
      return out;
    };
    return moving_joints(a) == moving_joints(b);
  }

  const ConfigurationScene& scene_;
  std::uint32_t moving_ = 0;
  std::unique_ptr<Narrowphase> native_ = make_native();
  std::unique_ptr<Narrowphase::Workspace> workspace_ = native_->make_workspace();
  std::vector<Pose> X_WS_;
  std::vector<SolidPair> pairs_;
  std::vector<PairStatus> status_;
};

ConfigurationScene arm_among(int blocks, std::uint64_t seed) {
  ConfigurationScene scene{std::make_shared<const Mechanism>(make_ssrms())};
  Random random(seed);
  test::Draw draw(seed);
  for (int i = 0; i < blocks; ++i)
    scene.obstacles.push_back({tree("block " + std::to_string(i), random_solid(random, 1.0)), draw.pose(18)});
  return scene;
}

std::vector<double> random_values(const Mechanism& mechanism, double share, test::Draw& draw) {
  std::vector<double> q(mechanism.value_count());
  for (double& value : q) value = draw.real(-share, share) * std::numbers::pi;
  return q;
}

TEST(ConfigurationCheck, AnswersAsAllPairsDoForAnArmAmongBlocks) {
  for (const int blocks : {0, 30, 300}) {
    const ConfigurationScene scene = arm_among(blocks, 3);
    const ConfigurationCheck check(scene, make_native());
    ConfigurationCheck::Scratch scratch = check.make_scratch();
    Plain plain(scene);
    test::Draw draw(7);
    int free = 0;
    constexpr int kCount = 300;
    for (int i = 0; i < kCount; ++i) {
      const std::vector<double> q = random_values(*scene.mechanism, i % 2 ? 0.3 : 1.0, draw);
      const bool is_free = plain.is_free(q);
      ASSERT_EQ(check.is_free(q, scratch), is_free) << blocks << " blocks, configuration " << i;
      free += is_free;
    }
    EXPECT_GT(free, kCount / 20) << blocks;
    EXPECT_LT(free, kCount) << blocks;
  }
}

/// Random mechanisms among eight blocks, each asked about 40 configurations: the check answers as all pairs
/// do.
/// @param of_link draws a link's solid: of_link(random, draw). @param block draws an obstacle's:
/// block(random, i).
template <class OfLink, class Block>
void expect_answers_of_all_pairs(unsigned seed, int mechanisms, const OfLink& of_link, const Block& block) {
  Random random(seed);
  test::Draw draw(seed);
  int free = 0, asked = 0;
  for (int turn = 0; turn < mechanisms; ++turn) {
    // The scene: up to three solids a link.
    MechanismDescription description = draw.mechanism();
    for (auto& link : description.links)
      for (int i = draw.integer(0, 3); i > 0; --i)
        link.solids.push_back({std::to_string(i), of_link(random, draw), draw.pose(1.5)});
    ConfigurationScene scene{std::make_shared<const Mechanism>(description), draw.pose(2)};
    for (int i = 0; i < 8; ++i)
      scene.obstacles.push_back({tree("block " + std::to_string(i), block(random, i)), draw.pose(6)});
    // Both are asked about the same joint values.
    const ConfigurationCheck check(scene, make_native());
    ConfigurationCheck::Scratch scratch = check.make_scratch();
    Plain plain(scene);
    for (int i = 0; i < 40; ++i, ++asked) {
      const std::vector<double> q = random_values(*scene.mechanism, 1.0, draw);
      const bool is_free = plain.is_free(q);
      ASSERT_EQ(check.is_free(q, scratch), is_free) << turn << " " << i;
      free += is_free;
    }
  }
  EXPECT_GT(free, asked / 10);
  EXPECT_LT(free, asked * 9 / 10);
}

TEST(ConfigurationCheck, AnswersAsAllPairsDoForRandomMechanisms) {
  const auto of_link = [](Random& random, test::Draw& draw) {
    return random_solid(random, draw.chance(0.2) ? 1e-3 : 1.0);
  };
  expect_answers_of_all_pairs(5, 60, of_link, [](Random& random, int) { return random_solid(random, 1.0); });
}

/// Balls, capsules and padded blocks.
Hexahedron random_rounded(Random& random) {
  const double radius = random.uniform(0.05, 0.5);
  if (random.one_in(3)) return Hexahedron::sphere(radius);
  return random.one_in(2) ? Hexahedron::capsule(radius, random.uniform(0.1, 2.0))
                          : random_solid(random, 1.0).padded(radius);
}

TEST(ConfigurationCheck, AnswersAsAllPairsDoForRoundedSolids) {
  expect_answers_of_all_pairs(
      51, 40, [](Random& random, test::Draw&) { return random_rounded(random); },
      [](Random& random, int i) { return i % 2 ? random_solid(random, 1.0) : random_rounded(random); });
}

/// A bar of 2 m along x turns about z; a post stands with its near face at y = 0.5, x from 1 to 2.
ConfigurationScene bar_and_post() {
  MechanismDescription description;
  description.name = "arm";
  description.links = {
      {"base", {{"foot", Hexahedron::from_size({0.2, 0.2, 0.2}), {}}}, {}},
      {"bar", {{"bar", Hexahedron::from_size({2, 1e-3, 0.1}), {Matrix3::Identity(), {1, 0, 0}}}}, {}}};
  JointDescription joint;
  joint.name = "turn", joint.kind = JointKind::revolute, joint.parent = "base", joint.child = "bar";
  joint.axis_J = Vector3::UnitZ();
  description.joints = {joint};
  return {std::make_shared<const Mechanism>(description),
          {},
          {{tree("post", Hexahedron::from_size({1, 1, 1})), {Matrix3::Identity(), {1.5, 1.0, 0}}}}};
}

TEST(ConfigurationCheck, FindsTheAngleOfTouch) {
  const ConfigurationScene scene = bar_and_post();
  const ConfigurationCheck check(scene, make_native());
  ConfigurationCheck::Scratch scratch = check.make_scratch();
  // The bar's upper face, 0.5 mm off its axis, meets the post's edge at y = 0.5 or the bar's end, x = 2 cos,
  // passes: sin a * 2 + 5e-4 cos a = 0.5 at the bar's end corner.
  const double r = std::hypot(2.0, 5e-4), angle = std::asin(0.5 / r) - std::atan(5e-4 / 2.0);
  for (const double off : {1e-12, 1e-9, 1e-3}) {
    EXPECT_TRUE(check.is_free(std::vector{angle - off}, scratch)) << off;
    EXPECT_FALSE(check.is_free(std::vector{angle + off}, scratch)) << off;
  }
}

TEST(ConfigurationCheck, TakesNamesThatAreExempt) {
  for (const char* name : {"bar", "bar/bar"})
    for (const char* other : {"post", "post/solid"}) {
      ConfigurationScene scene = bar_and_post();
      scene.exempt = {{other, name}};
      const ConfigurationCheck check(scene, make_native());
      ConfigurationCheck::Scratch scratch = check.make_scratch();
      EXPECT_TRUE(check.is_free(std::vector{0.5}, scratch)) << name << " " << other;
    }
}

TEST(ConfigurationCheck, ChecksWhatALinkCarries) {
  ConfigurationScene scene = bar_and_post();
  scene.exempt = {{"bar", "post"}};
  // On the bar, 0.2 m before its end: reaches 0.1 m to its side.
  scene.carried = {
      {tree("load", Hexahedron::from_size({0.1, 0.2, 0.1})), "bar", {Matrix3::Identity(), {1.8, 0, 0}}}};
  const ConfigurationCheck check(scene, make_native());
  ConfigurationCheck::Scratch scratch = check.make_scratch();
  const double r = std::hypot(1.85, 0.1), angle = std::asin(0.5 / r) - std::atan(0.1 / 1.85);
  EXPECT_TRUE(check.is_free(std::vector{angle - 1e-9}, scratch));
  EXPECT_FALSE(check.is_free(std::vector{angle + 1e-9}, scratch));
  // Against the foot, which no joint moves, and which the bar itself is exempt from.
  scene.carried[0].X_LO.p = {0.1, 0, 0};
  const ConfigurationCheck close(scene, make_native());
  scratch = close.make_scratch();
  EXPECT_FALSE(close.is_free(std::vector{0.0}, scratch));
}

TEST(ConfigurationCheck, BatchesAnswerAsSingleOnes) {
  const ConfigurationScene scene = arm_among(200, 9);
  const ConfigurationCheck check(scene, make_native());
  ConfigurationCheck::Scratch one = check.make_scratch(), many = check.make_scratch();
  test::Draw draw(1);
  std::vector<double> all;
  for (int i = 0; i < 100; ++i)
    for (const double value : random_values(*scene.mechanism, 0.3, draw)) all.push_back(value);
  std::vector<std::uint8_t> out(100);
  const std::size_t free = check.are_free(all, out, many);
  std::size_t expected = 0;
  for (std::size_t i = 0; i < out.size(); ++i) {
    EXPECT_EQ(out[i] != 0, check.is_free(std::span(all).subspan(7 * i, 7), one));
    expected += out[i];
  }
  EXPECT_EQ(free, expected);
  EXPECT_GT(many.pairs_asked(), 0u);
  const std::size_t before = allocation_count();
  check.are_free(all, out, many);
  EXPECT_EQ(allocation_count(), before);
}

TEST(ConfigurationCheck, ValuesThatAreNotFiniteAreNotFree) {
  const ConfigurationScene scene = bar_and_post();
  const ConfigurationCheck check(scene, make_native());
  ConfigurationCheck::Scratch scratch = check.make_scratch();
  EXPECT_TRUE(check.is_free(std::vector{0.0}, scratch));
  for (const double value : {std::nan(""), kInfinity})
    EXPECT_FALSE(check.is_free(std::vector{value}, scratch));
}

TEST(ConfigurationCheck, RefusesWhatCannotWork) {
  const auto expect_refused = [](const auto& change) {
    ConfigurationScene scene = bar_and_post();
    change(scene);
    EXPECT_THROW(ConfigurationCheck(scene, make_native()), InputError);
  };
  expect_refused([](ConfigurationScene& scene) { scene.mechanism = nullptr; });
  expect_refused([](ConfigurationScene& scene) { scene.X_WB.p.x() = std::nan(""); });
  expect_refused([](ConfigurationScene& scene) { scene.obstacles.push_back({nullptr, {}}); });
  expect_refused([](ConfigurationScene& scene) { scene.obstacles.push_back(scene.obstacles[0]); });
  expect_refused([](ConfigurationScene& scene) { scene.obstacles[0].X_WO.R *= 2.0; });
  expect_refused([](ConfigurationScene& scene) { scene.carried = {{scene.obstacles[0].tree, "bar", {}}}; });
  expect_refused([](ConfigurationScene& scene) {
    scene.carried = {{tree("load", Hexahedron::from_size({1, 1, 1})), "hand", {}}};
  });
  expect_refused([](ConfigurationScene& scene) { scene.exempt = {{"bar", "pots"}}; });
  expect_refused([](ConfigurationScene& scene) { scene.exempt = {{"post", "post"}}; });
  EXPECT_THROW(ConfigurationCheck(bar_and_post(), nullptr), InputError);
}

}  // namespace
}  // namespace touchstone
