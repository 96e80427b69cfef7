#include "touchstone/contact_core/mechanism/resolved_rate.hpp"

#include <gmock/gmock.h>

#include <array>
#include <cmath>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/contact_core/mechanism/arms/ssrms.hpp"
#include "touchstone/contact_core/motion/path.hpp"
#include "touchstone/tests/mechanism/random_chain.hpp"
#include "touchstone/tests/support/counting_allocator.hpp"
#include "touchstone/tests/support/degree.hpp"

namespace touchstone {
namespace {

struct Posed {
  Mechanism arm;
  std::vector<double> q;
  std::vector<Pose> X;

  Posed(Mechanism mechanism, std::vector<double> values) : arm(std::move(mechanism)), q(std::move(values)) {
    X.resize(arm.links().size());
    place();
  }
  void place() { arm.link_poses({}, q, X); }
};

Posed bent_arm(const char* base = "base_lee") {
  std::vector<double> q = {10, 25, -70, 110, -35, 20, 15};
  for (double& value : q) value *= kDegree;
  return {Mechanism(make_ssrms()).with_base(base), q};
}

/// Central differences of forward kinematics: error of order h^2 times a third derivative (a few reaches),
/// and the rounding of a pose over h.
Twist differences(Posed& posed, std::uint32_t link, const Vector3& p_L, std::uint32_t value) {
  constexpr double h = 0x1p-17;
  const double q = posed.q[value];
  posed.q[value] = q + h, posed.place();
  const Pose after = posed.X[link];
  posed.q[value] = q - h, posed.place();
  const Pose before = posed.X[link];
  posed.q[value] = q, posed.place();
  const double rate = 0.5 / h;
  return {rate * (transform(after, p_L) - transform(before, p_L)),
          rate * RigidPath::between(before, after).at(0, 0.0).angular_velocity_W};
}

void expect_column_is_derivative(Posed& posed, std::uint32_t link, double reach) {
  ResolvedRate control(posed.arm, link);
  const Vector3 p_L(0.3, -0.2, 0.1);
  const double error = reach * 0x1p-34 + reach * 0x1p-50 / 0x1p-17;  // h^2, and rounding over h
  for (std::uint32_t value = 0; value < posed.arm.value_count(); ++value) {
    const Twist expected = differences(posed, link, p_L, value);
    const Twist column = control.column(posed.X, transform(posed.X[link], p_L), value);
    EXPECT_LE(norm(column.v - expected.v), error) << posed.arm.name() << " value " << value;
    EXPECT_LE(norm(column.w - expected.w), error) << posed.arm.name() << " value " << value;
  }
}

TEST(ResolvedRate, JacobianIsTheDerivativeOfForwardKinematics) {
  for (const char* base : {"base_lee", "tip"}) {
    Posed posed = bent_arm(base);
    const char* end = std::string_view(base) == "tip" ? "base_lee" : "tip";
    expect_column_is_derivative(posed, posed.arm.find_link(end), 20);
    expect_column_is_derivative(posed, posed.arm.find_link("lower_boom"), 20);
  }
}

TEST(ResolvedRate, JacobianOfRandomTreesOfBothKindsOfJoints) {
  test::Draw draw(11);
  int checked = 0;
  for (int i = 0; i < 200; ++i) {
    const Mechanism mechanism(draw.mechanism());
    std::vector<double> q(mechanism.value_count());
    for (double& value : q) value = draw.real(-2, 2);
    Posed posed(mechanism.with_base(std::to_string(draw.integer(0, 1))), q);
    for (std::uint32_t link = 0; link < posed.arm.links().size(); ++link) {
      bool moves = false;
      for (const std::uint32_t joint : posed.arm.chain(link))
        moves |= posed.arm.joints()[joint].value != Mechanism::kNone;
      if (!moves) continue;
      expect_column_is_derivative(posed, link, 60);
      ++checked;
    }
  }
  EXPECT_GT(checked, 500);
}

TEST(ResolvedRate, GivesWhatIsAskedWithTheLeastRates) {
  Posed posed = bent_arm();
  ResolvedRate control(posed.arm, posed.arm.find_link("tip"));
  const Vector3 p = posed.X[posed.arm.find_link("tip")].p;
  const Twist wanted{{0.02, -0.01, 0.015}, {0.001, 0.002, -0.001}};
  std::vector<double> rates(7), null(7);
  const ResolvedRate::Outcome outcome = control.solve(posed.X, p, wanted, rates);
  EXPECT_EQ(outcome.lambda, 0.0);
  EXPECT_EQ(outcome.scale, 1.0);
  EXPECT_LE(norm(outcome.error.v), 1e-12);
  EXPECT_LE(norm(outcome.error.w), 1e-12);
  // A motion of the elbow that leaves the hand alone: the last joint's rate as if it were asked for, made
  // good by the others. The least rates have no part of it.
  constexpr double kSmall = 1e-3;  // within the joints' limits
  const Twist last = kSmall * control.column(posed.X, p, 6);
  std::vector<double> made_good(7);
  control.solve(posed.X, p, last, made_good);
  for (std::size_t i = 0; i < 7; ++i) null[i] = (i == 6 ? kSmall : 0.0) - made_good[i];
  double along = 0.0, length = 0.0;
  for (std::size_t i = 0; i < 7; ++i) along += null[i] * rates[i], length += null[i] * null[i];
  ASSERT_GT(length, 1e-10);
  EXPECT_NEAR(along / std::sqrt(length), 0.0, 1e-12);
}

TEST(ResolvedRate, ScalesAllRatesWhenOneIsAtItsLimit) {
  Posed posed = bent_arm();
  const std::uint32_t tip = posed.arm.find_link("tip");
  ResolvedRate control(posed.arm, tip);
  std::vector<double> slow(7), fast(7);
  control.solve(posed.X, posed.X[tip].p, {{0.001, 0, 0}, {0, 0, 0}}, slow);
  const ResolvedRate::Outcome outcome = control.solve(posed.X, posed.X[tip].p, {{5, 0, 0}, {0, 0, 0}}, fast);
  EXPECT_LT(outcome.scale, 1.0);
  double largest = 0.0;
  for (std::size_t i = 0; i < 7; ++i) {
    largest = std::max(largest, std::abs(fast[i]));
    EXPECT_NEAR(fast[i], slow[i] * 5000 * outcome.scale, 1e-12);
  }
  EXPECT_NEAR(largest, 4 * kDegree, 1e-15);
  EXPECT_NEAR(outcome.error.v.x(), -5 * (1 - outcome.scale), 1e-9);
}

TEST(ResolvedRate, IsDampedAtASingularityAndBounded) {
  // Straight, the arm cannot pull its hand in; near it, it would need rates without bound.
  const ResolvedRateSettings settings;
  for (const double bend : {0.0, 1e-9, 1e-6, 1e-3}) {
    Posed posed(Mechanism(make_ssrms()), {0, 0, 0, bend, 0, 0, 0});
    const std::uint32_t tip = posed.arm.find_link("tip");
    ResolvedRate control(posed.arm, tip, settings);
    std::vector<double> rates(7);
    const Twist wanted{{-1e-3, 0, 0}, {0, 0, 0}};
    const ResolvedRate::Outcome outcome = control.solve(posed.X, posed.X[tip].p, wanted, rates);
    EXPECT_GT(outcome.lambda, 0.0) << bend;
    EXPECT_LE(outcome.lambda, settings.damping);
    // |J^T (J J^T + lambda^2)^-1| <= 1 / (2 lambda).
    double square = 0.0;
    for (const double rate : rates) square += rate * rate;
    EXPECT_LE(std::sqrt(square), 1e-3 / (2 * outcome.lambda) * (1 + 1e-9)) << bend;
  }
}

// Two joints of a plane, 2 and 1 m from the point: J^T J is [5 3; 3 2], whose inverse has the trace 7.
TEST(ResolvedRate, RegularityIsWhatDampingGoesBy) {
  MechanismDescription two{"two", {{"base"}, {"first"}, {"second"}}, {}};
  two.joints = {{"a", JointKind::revolute, "base", "first"},
                {"b", JointKind::revolute, "first", "second", {Matrix3::Identity(), {1, 0, 0}}}};
  Posed plane(Mechanism(two), {0, 0});
  ResolvedRate of_two(plane.arm, 2);
  EXPECT_NEAR(of_two.regularity(plane.X, {2, 0, 0}), std::sqrt(1.0 / 7.0), 1e-15);
  // Of seven joints, on both sides of where damping sets in.
  for (const double bend : {0.0, 0.005, 0.02, 0.1, 0.5}) {
    Posed posed(Mechanism(make_ssrms()), {0.2, 0.3, bend, -2 * bend, bend, 0.3, 0.2});
    const std::uint32_t tip = posed.arm.find_link("tip");
    ResolvedRate control(posed.arm, tip);
    std::vector<double> rates(7);
    const Vector3 p_W = posed.X[tip].p;
    const double lambda = control.solve(posed.X, p_W, {{1e-3, 0, 0}, {0, 0, 0}}, rates).lambda;
    const double share = control.regularity(posed.X, p_W) / ResolvedRateSettings{}.damped_below;
    EXPECT_EQ(lambda > 0.0, share < 1.0) << bend;
    EXPECT_NEAR(lambda, ResolvedRateSettings{}.damping * std::sqrt(std::max(0.0, 1 - share * share)), 1e-12);
  }
}

TEST(ResolvedRate, DoesNotAllocate) {
  Posed posed = bent_arm();
  const std::uint32_t tip = posed.arm.find_link("tip");
  ResolvedRate control(posed.arm, tip);
  std::vector<double> rates(7);
  const std::size_t before = allocation_count();
  control.solve(posed.X, posed.X[tip].p, {{0.02, 0, 0}, {0, 0, 0}}, rates);
  EXPECT_EQ(allocation_count(), before);
}

TEST(ResolvedRate, RefusesWhatCannotWork) {
  const Mechanism arm(make_ssrms());
  EXPECT_THROW(ResolvedRate(arm, arm.find_link("base_lee")), InputError);
  EXPECT_THROW(ResolvedRate(arm, arm.find_link("tip"), {.damping = 0.0}), InputError);
  EXPECT_THROW(ResolvedRate(arm, arm.find_link("tip"), {.length = std::nan("")}), InputError);
}

// Seven joints, one of them held: the other six still serve the command, where they can.
TEST(ResolvedRate, HeldJointsStayAndTheOthersServe) {
  Posed posed = bent_arm();
  const std::uint32_t tip = posed.arm.find_link("tip");
  const Twist wanted{{0.01, -0.02, 0.005}, {0.002, 0.001, -0.003}};
  std::vector<double> rates(7, -1.0);
  int served = 0;
  for (std::uint32_t held = 0; held < 7; ++held) {
    ResolvedRate control(posed.arm, tip, {}, std::array{held});
    const ResolvedRate::Outcome outcome = control.solve(posed.X, posed.X[tip].p, wanted, rates);
    EXPECT_EQ(rates[held], 0.0);
    const bool is_served = outcome.lambda == 0.0 && outcome.scale == 1.0;
    EXPECT_TRUE(!is_served || norm(outcome.error.v) + norm(outcome.error.w) <= 1e-12) << held;
    served += is_served;
  }
  EXPECT_GT(served, 3);
  const std::array<std::uint32_t, 7> all = {0, 1, 2, 3, 4, 5, 6};
  EXPECT_THROW(ResolvedRate(posed.arm, tip, {}, all), InputError);
}

}  // namespace
}  // namespace touchstone
