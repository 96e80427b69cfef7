#include "touchstone/tests/fit/table/cover_judge.hpp"

#include <gtest/gtest.h>

#include "touchstone/tests/fit/meshes.hpp"

namespace touchstone::test {
namespace {

constexpr std::size_t kSamples = 40000;

ConvexPiece box_piece(const Vector3& low, const Vector3& high) {
  const std::array<Vector3, 8> v = box_vertices(low, high);
  return {{v.begin(), v.end()}, {}};
}

TEST(CoverJudge, TwoLegsCoverAnAngle) {
  const std::vector<ConvexPiece> legs{box_piece({0, 0, 0}, {2, 0.5, 1}), box_piece({0, 0, 0}, {0.5, 2, 1})};
  const JudgedSamples judged = CoverJudge(angle_mesh()).judge(legs, kSamples, 1);
  EXPECT_EQ(judged.uncovered(), 0U);
  EXPECT_EQ(judged.surface, kSamples / 2);
  EXPECT_EQ(judged.inside, kSamples / 2);
}

// 3/7 of the volume is in one leg alone.
TEST(CoverJudge, ALegThatIsMissingIsSeenByItsShare) {
  const std::vector<ConvexPiece> leg{box_piece({0, 0, 0}, {2, 0.5, 1})};
  const JudgedSamples judged = CoverJudge(angle_mesh()).judge(leg, kSamples, 2);
  EXPECT_NEAR(static_cast<double>(judged.uncovered_inside) / static_cast<double>(judged.inside), 3.0 / 7.0,
              0.02);
  EXPECT_GT(judged.uncovered_surface, kSamples / 8);
  EXPECT_GT(judged.an_uncovered.y(), 0.5);
}

// One part in 1e10 of a face: far above rounding, far below what a picture shows.
TEST(CoverJudge, AFaceThatStandsATraceInsideIsSeen) {
  const TriangleMesh mesh = box_mesh({1, 2, 3}, {2, 4, 6});
  const CoverJudge judge(mesh);
  EXPECT_EQ(judge.judge(std::vector{box_piece({1, 2, 3}, {2, 4, 6})}, kSamples, 3).uncovered(), 0U);
  const JudgedSamples short_one =
      judge.judge(std::vector{box_piece({1, 2, 3}, {2, 4, 6 - 6e-10})}, kSamples, 3);
  EXPECT_GT(short_one.uncovered_surface, 0U);
  EXPECT_EQ(short_one.uncovered_inside, 0U);
}

TEST(CoverJudge, WhatABoreLeavesOpenIsNotInside) {
  const CoverJudge judge(tube_mesh(0.3, 0.6, 0.5, 48));
  std::vector<ConvexPiece> walls{
      box_piece({-0.6, -0.6, 0}, {-0.2, 0.6, 0.5}), box_piece({0.2, -0.6, 0}, {0.6, 0.6, 0.5}),
      box_piece({-0.6, -0.6, 0}, {0.6, -0.2, 0.5}), box_piece({-0.6, 0.2, 0}, {0.6, 0.6, 0.5})};
  EXPECT_EQ(judge.judge(walls, kSamples, 4).uncovered(), 0U);  // the middle is no one's
  walls.pop_back();
  EXPECT_GT(judge.judge(walls, kSamples, 4).uncovered(), 0U);
}

TEST(CoverJudge, FacetsOrVerticesSayTheSame) {
  const TriangleMesh mesh = box_mesh({0, 0, 0}, {1, 1, 1});
  const CoverJudge judge(mesh);
  const TriangleMesh small = box_mesh({0, 0, 0}, {1, 1, 0.75});
  const JudgedSamples facets =
      judge.judge(std::vector{ConvexPiece{small.vertices, small.triangles}}, kSamples, 5);
  const JudgedSamples vertices = judge.judge(std::vector{box_piece({0, 0, 0}, {1, 1, 0.75})}, kSamples, 5);
  EXPECT_EQ(facets.uncovered(), vertices.uncovered());
  EXPECT_NEAR(static_cast<double>(facets.uncovered_inside) / static_cast<double>(facets.inside), 0.25, 0.02);
}

TEST(CoverJudge, AnOpenShellHasOnlyASurface) {
  TriangleMesh sheet;
  append_quad(sheet, {0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0});
  const JudgedSamples judged =
      CoverJudge(sheet).judge(std::vector{box_piece({0, 0, -0.1}, {1, 0.5, 0.1})}, kSamples, 6);
  EXPECT_EQ(judged.inside, 0U);
  EXPECT_NEAR(static_cast<double>(judged.uncovered_surface), 0.5 * kSamples, 0.02 * kSamples);
}

}  // namespace
}  // namespace touchstone::test
