#include "touchstone/adapters/scene_files/pair_capture.hpp"

#include <gtest/gtest.h>

#include <filesystem>

namespace touchstone {
namespace {

/// Two boxes, B over A by `gap`.
void tell(PairCapture& capture, double gap, double turn = 0.0) {
  const Hexahedron a = Hexahedron::from_size({1, 1, 1}), b = Hexahedron::from_size({1, 2, 3});
  Pose X_WB;
  X_WB.R = rotation_from_quaternion(1, 0, 0, turn);
  X_WB.p = {0.1, 0.2, 2.0 + gap};
  const Vector3 p_A(0.1, 0.2, 0.5), n(0, 0, 1);
  const ContactPoint points[2] = {{p_A, p_A + 0.5 * gap * n, 0.5 * gap, 3}, {p_A, p_A + gap * n, gap, 7}};
  const bool contact = gap <= 0;
  capture.observe({{&a, &b},
                   {Pose{}, X_WB},
                   contact ? PairStatus::overlapping : PairStatus::separated,
                   {gap, n, p_A, p_A + gap * n, 2},
                   points,
                   "a test"});
}

TEST(PairCapture, WritesWhatIsReadBackBitForBit) {
  PairCapture capture(10);
  tell(capture, -0.1, 0.3);
  tell(capture, 0.25);
  const auto file = std::filesystem::path(::testing::TempDir()) / "captured_pairs.json";
  capture.save(file);
  const std::vector<PairCase> cases = load_pairs(file);
  ASSERT_EQ(cases.size(), 2u);
  ASSERT_TRUE(cases[0].pair) << cases[0].invalid_reason;
  EXPECT_EQ(cases[0].id, "pair-1");
  EXPECT_EQ(cases[0].pair->X_WS[1].R, rotation_from_quaternion(1, 0, 0, 0.3));
  EXPECT_EQ(cases[0].pair->solids[1].half_extents(), Vector3(0.5, 1, 1.5));
  ASSERT_TRUE(cases[0].captured);
  EXPECT_EQ(cases[0].captured->by, "a test");
  EXPECT_TRUE(cases[0].captured->contact);
  EXPECT_EQ(cases[0].captured->separation, -0.1);
  EXPECT_EQ(cases[0].captured->n_AB_W, Vector3(0, 0, 1));
  ASSERT_EQ(cases[0].captured->points.size(), 2u);
  EXPECT_EQ(cases[0].captured->points[0].separation, -0.1);  // the deepest first
  EXPECT_EQ(cases[0].captured->points[1].p_B_W, Vector3(0.1, 0.2, 0.5 - 0.05));
  ASSERT_TRUE(cases[1].captured);
  EXPECT_FALSE(cases[1].captured->contact);
}

TEST(PairCapture, KeepsAFairSampleInTheOrderOfTheRun) {
  PairCapture capture(100);
  for (int i = 1; i <= 5000; ++i) tell(capture, i <= 2500 ? -0.1 : 0.1);
  EXPECT_EQ(capture.observed(), 5000u);
  const std::vector<PairCase> cases = capture.cases();
  ASSERT_EQ(cases.size(), 100u);
  int contacts = 0;
  std::size_t before = 0;
  for (const PairCase& each : cases) {
    contacts += each.captured->contact ? 1 : 0;
    const std::size_t number = std::stoul(each.id.substr(5));
    EXPECT_GT(number, before);
    before = number;
  }
  EXPECT_NEAR(contacts, 50, 20);  // four standard deviations
}

}  // namespace
}  // namespace touchstone
