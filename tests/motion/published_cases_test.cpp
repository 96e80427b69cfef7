#include <gtest/gtest.h>

#include <array>
#include <string>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/motion/impact.hpp"
#include "touchstone/contact_core/motion/narrowphase_query.hpp"
#include "touchstone/contact_core/native/native.hpp"
#include "touchstone/tests/support/at.hpp"

// Times of impact that engines got wrong: cases from the trackers and tests of ncollide, parry and Jolt, and
// from this project, with the exact first time at which the closed solids meet (translations: a rational,
// from the vertices; the turning one: bisection on the exact verdict).

namespace touchstone {
namespace {

constexpr double kNever = kInfinity;

struct Case {
  std::string name;
  Vector3 size_a, size_b;  // boxes, full sides [m]
  Vector3 p_A, p_B;
  Vector3 velocity_a, velocity_b;  // [m/s]
  double duration;                 // [s]
  double exact_time;               // [s]
  double least_separation;         // exact, on the whole path; where it never meets [m]
};

const Vector3 kZero = Vector3::Zero();

std::array<Case, 14> cases() {
  const Vector3 one(1, 1, 1), two(2, 2, 2);
  const double p = 1.100000023841858;
  // Sizes, places and velocities, duration, time of impact, and least separation.
  return {{
      {"still", one, one, {0, p, 0}, kZero, kZero, kZero, 1, kNever, p - 1},
      {"leaving", one, one, {0, p, 0}, kZero, {0, 1, 0}, kZero, 1, kNever, p - 1},
      {"approaching", one, one, {0, p, 0}, kZero, {0, -1, 0}, kZero, 1, 838861.0 / 8388608.0, 0},
      {"head on", two, two, kZero, {5, 0, 0}, kZero, {-2, 0, 0}, 3, 1.5, 0},
      {"thin wall",
       {0x1p-10, 64, 64},
       {0x1p-10, 0x1p-10, 0x1p-10},
       kZero,
       {-512, 0, 0},
       kZero,
       {1024, 0, 0},
       1,
       524287.0 / 1048576.0,
       0},
      {"slide touching", two, two, kZero, {-5, 2, 0}, kZero, {4, 0, 0}, 2.5, 0.75, 0},
      {"slide at 2^-20", two, two, kZero, {-5, 2 + 0x1p-20, 0}, kZero, {4, 0, 0}, 2.5, kNever, 0x1p-20},
      {"slide at 2^-40", two, two, kZero, {-5, 2 + 0x1p-40, 0}, kZero, {4, 0, 0}, 2.5, kNever, 0x1p-40},
      {"slide at 2^-51", two, two, kZero, {-5, 2 + 0x1p-51, 0}, kZero, {4, 0, 0}, 2.5, kNever, 0x1p-51},
      {"corner graze", two, two, kZero, {-6, -2, 0}, kZero, {4, 4, 0}, 2, 1, 0},
      {"touching, parting", two, two, kZero, {2, 0, 0}, kZero, {1, 0, 0}, 1, 0, 0},
      {"touching, pressing", two, two, kZero, {2, 0, 0}, kZero, {-1, 0, 0}, 1, 0, 0},
      {"overlapping, parting", two, two, kZero, {1, 0, 0}, kZero, {1, 0, 0}, 2, 0, 0},
      {"far out", two, two, {1e6, 1e6, 1e6}, {1000005, 1e6, 1e6}, kZero, {-2, 0, 0}, 3, 1.5, 0},
  }};
}

/// The contact gap of the case: 1e-9 m, or four times native's resolution.
double gap_at(const Case& c) {
  const double scale = std::max(c.p_A.cwiseAbs().maxCoeff(), c.p_B.cwiseAbs().maxCoeff()) + 64;
  return std::max(1e-9, 4 * make_native()->capabilities().resolution.at(scale));
}

TEST(PublishedImpacts, NeverLateAndWithinTheGap) {
  for (const Case& c : cases()) {
    SCOPED_TRACE(c.name);
    const std::array solids{Hexahedron::from_size(c.size_a), Hexahedron::from_size(c.size_b)};
    const auto native = make_native();
    native->build(solids);
    NarrowphaseQuery query(*native, 2);
    const RigidPath a = RigidPath::by(at(c.p_A), c.duration * c.velocity_a, kZero);
    const RigidPath b = RigidPath::by(at(c.p_B), c.duration * c.velocity_b, kZero);
    const double gap = gap_at(c);
    const Impact impact = find_impact({&solids[0], {}, &a}, {&solids[1], {}, &b}, {gap}, query);
    ASSERT_NE(impact.status, ImpactStatus::iteration_limit);
    const double lo = impact.lo * c.duration;
    if (impact.start_separation <= gap) {
      // At rest against each other: parting is free, pressing is not, wherever the closed solids are said to
      // meet.
      EXPECT_EQ(impact.status == ImpactStatus::clear, c.name != "touching, pressing");
    } else if (c.exact_time == kNever) {
      if (impact.status != ImpactStatus::clear) {
        EXPECT_LE(c.least_separation, gap) << "a stop at " << lo;
      }
    } else {
      EXPECT_EQ(impact.status, ImpactStatus::blocked);
      EXPECT_LE(lo, c.exact_time);
      EXPECT_GE(lo, c.exact_time - 2 * gap / norm(c.velocity_b - c.velocity_a) - 1e-12);
      EXPECT_LE(impact.geometry.separation, gap);
      EXPECT_GE(impact.geometry.separation, 0.5 * gap);
    }
  }
}

// parry's issue 317: a turning and flying box, for which a time of impact was missed.
TEST(PublishedImpacts, TurningAboutAnInnerPoint) {
  const std::array solids{Hexahedron::from_size({470, 210, 220}), Hexahedron::from_size({1300, 660, 550})};
  const auto native = make_native();
  native->build(solids);
  NarrowphaseQuery query(*native, 2);
  Pose X_WA, X_WB;
  X_WA.p = {6458.79052734375, -209.1331024169922, 1014.521240234375};
  X_WA.R = rotation_from_quaternion(-0.5420439839363098, 5.335995436267824e-20, 9.459897271567554e-20,
                                    -0.8403501510620117);
  X_WB.p = {6079.49169921875, -849.310791015625, 853.8756103515625};
  X_WB.R = rotation_from_quaternion(0.9999960660934448, 0.0025247749872505665, -0.0002621043531689793,
                                    -0.0012064485345035791);
  const Vector3 centre_A(99.9708480834961, -2.288818359375e-05, -35.0);
  // The body's origin is the centre it turns about.
  Pose X_WC = X_WA, X_CA;
  X_WC.p = transform(X_WA, centre_A);
  X_CA.p = -centre_A;
  const RigidPath a =
      RigidPath::by(X_WC, {588.25830078125, -553.0633544921875, 471.546875}, {0, 0, -1.7708230018615723});
  const RigidPath b(X_WB);
  const double gap = 4 * native->capabilities().resolution.at(1e4);
  const Impact impact =
      find_impact({&solids[0], X_CA, &a}, {&solids[1], {}, &b}, {std::max(gap, 1e-9)}, query);
  EXPECT_EQ(impact.status, ImpactStatus::blocked);
  EXPECT_LE(impact.lo, 0.09393355860449024);
  EXPECT_NEAR(impact.lo, 0.09393355860449024, 1e-9);
}

}  // namespace
}  // namespace touchstone
