#include "touchstone/examples/fit/serves.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>

#include "touchstone/adapters/scene_files/scene_file.hpp"
#include "touchstone/examples/fit/cover_scene.hpp"
#include "touchstone/examples/fit/training_scene.hpp"
#include "touchstone/tests/fit/meshes.hpp"
#include "touchstone/tests/support/program_test.hpp"
#include "touchstone/tests/support/refusal.hpp"

namespace touchstone::fitting {
namespace {

using testing::HasSubstr;

/// An angle stands; a cube of 0.2 m comes from x = 3 m at 0.5 m/s against the end of its leg at x = 2 m.
class Serves : public FolderTest {
 protected:
  Serves() {
    std::string obj;
    const TriangleMesh mesh = weld(test::angle_mesh());
    for (const Vector3& v : mesh.vertices)
      obj += "v " + std::to_string(v.x()) + " " + std::to_string(v.y()) + " " + std::to_string(v.z()) + "\n";
    for (const auto& t : mesh.triangles)
      obj += "f " + std::to_string(t[0] + 1) + " " + std::to_string(t[1] + 1) + " " +
             std::to_string(t[2] + 1) + "\n";
    mesh_ = write("angle.obj", obj);
    fit_.input.metres_per_unit = 1.0;
    fit_.repairs = 1;
    progress_ = std::make_unique<comparison::ProgressLine>();
  }
  ServesRequest request(const std::string& motion, const std::string& name = "angle") const {
    const std::filesystem::path file =
        write("scene.yaml",
              "name: s\nframe_rate: 50\ncontact_gap: 1.0e-6\npolicy: advance\nduration: 3\nobjects:\n"
              "  - name: " +
                  name +
                  "\n    static: true\n    hexahedra: [{name: a, box: {size: [1, 1, 1]}}]\n"
                  "  - name: cube\n    pose: {position: [3, 0.25, 0.5]}\n"
                  "    hexahedra: [{name: c, box: {size: [0.2, 0.2, 0.2]}}]\n" +
                  motion);
    return {load_scene(file), {{mesh_, fit_.input, "angle"}}, 0.04, 0.05};
  }
  static constexpr const char* kComes = "    motion: {segments: [{velocity: [-0.5, 0, 0]}]}\n";
  std::string error_of(const ServesRequest& request) {
    return refusal_of([&] { find_coarsest(fit_, request, *progress_); });
  }

  std::filesystem::path mesh_;
  FitRequest fit_;
  std::unique_ptr<comparison::ProgressLine> progress_;
};

TEST_F(Serves, TheFirstContactIsTheMeshsToTheErrorInTheZone) {
  const ServesRequest asked = request(kComes);
  const ServesResult result = find_coarsest(fit_, asked, *progress_);
  ASSERT_TRUE(result.best);
  for (const ServesRow& row : result.rows) {
    ASSERT_TRUE(row.flight.first_contact);
    if (!row.is_held) continue;
    const double closed_form = (3.0 - 0.1 - 2.0) / 0.5;
    EXPECT_LE(*row.flight.first_contact, closed_form + 1e-9);
    EXPECT_GE(*row.flight.first_contact, closed_form - (row.in_zones + 1e-6) / 0.5);
  }
  const ServesRow& coarsest = result.rows[*result.best];
  EXPECT_TRUE(coarsest.serves);
  EXPECT_LE(coarsest.in_zones, 0.04);
  EXPECT_TRUE(coarsest.runs[0].verdict.is_proven);
  EXPECT_GT(coarsest.runs[0].fit.excess, 0.04);  // elsewhere it is coarser: that is what it gains
  EXPECT_THAT(serves_text(result, asked), HasSubstr("coarsest that serves: "));
}

TEST_F(Serves, ACoverThatIsTooCoarseWhereItIsMetStopsTooSoon) {
  Fit coarse;
  coarse.hexahedra.push_back({test::box_vertices({-0.1, -0.1, -0.1}, {2.3, 2.1, 1.1}), 1.5, {2, 2, 0.5}});
  const std::array<const Fit*, 1> covers = {&coarse};
  const ServedFlight flight = fly_scene(request(kComes), covers);
  EXPECT_NEAR(*flight.first_contact, (3.0 - 0.1 - 2.3) / 0.5, 1e-5);
  Bounds swept;
  for (const Bounds& each : flight.swept[0]) swept.add(each.low), swept.add(each.high);
  EXPECT_LE(swept.low.x(), 2.3 + 1e-5);
  EXPECT_GE(swept.high.x(), 3.1);
}

// The mover goes up a steep plate, over it and down behind it, all in one frame: the swept boxes hold its
// whole path, not only the ends.
TEST_F(Serves, AFrameThatGoesAroundACornerIsSweptAlongIt) {
  ServesRequest asked = request("    motion: {segments: [{velocity: [10, 0, 0]}]}\n");
  asked.scene.frame_rate = 1.0;
  asked.scene.duration = 1.0;
  asked.scene.policy = ContactPolicy::slide;
  asked.scene.objects[1].X_WO.p = {-0.4, 0, 0.5};
  // A plate of 4.5 m at 60 degrees, and a wall beyond its upper end.
  Fit cover;
  const Vector3 along(0.5, std::sqrt(0.75), 0), across(std::sqrt(0.75), -0.5, 0);
  std::array<Vector3, 8> plate = test::box_vertices({0, -1, 0}, {0.05, 3.5, 1});
  for (Vector3& p : plate) p = p.x() * across + p.y() * along + Vector3(0, 0, p.z());
  cover.hexahedra.push_back({plate, 1.0, {0, 0, 0}});
  cover.hexahedra.push_back({test::box_vertices({3, -2, 0}, {3.1, 6, 1}), 1.0, {0, 0, 0}});
  const std::array<const Fit*, 1> covers = {&cover};
  const ServedFlight flight = fly_scene(asked, covers);
  ASSERT_EQ(flight.places.size(), 2U);
  EXPECT_NEAR(flight.places.back().x(), 2.9, 0.01);  // at the wall
  EXPECT_LT(flight.places.back().y(), 0.5);          // and down again
  ASSERT_EQ(flight.swept[0].size(), 1U);
  EXPECT_GT(flight.swept[0][0].high.y(), 3.5 * along.y());  // over the plate's end
}

TEST_F(Serves, TheScenesOwnRuleOfThePairStays) {
  Fit coarse;
  coarse.hexahedra.push_back({test::box_vertices({-0.1, -0.1, -0.1}, {2.3, 2.1, 1.1}), 1.5, {2, 2, 0.5}});
  const std::array<const Fit*, 1> covers = {&coarse};
  ServesRequest asked = request(kComes);
  asked.scene.rules.push_back({"cube", "angle", ContactPolicy::cue});
  const ServedFlight flight = fly_scene(asked, covers);
  EXPECT_NEAR(flight.places.back().x(), 1.5, 1e-9);  // it goes on, through the cover
  // A scene that warns farther than the margin still does.
  asked = request("    motion: {segments: [{velocity: [-0.1, 0, 0]}]}\n");
  asked.scene.rules.push_back({"angle", "cube", {}, 1.0});
  EXPECT_NEAR(fly_scene(asked, covers).least_clearance, 3.0 - 0.3 - 0.1 - 2.3, 1e-9);
}

// As touchstone_fit --levels writes them: they hold the scene's hexahedra, not another cover's.
TEST_F(Serves, TheLevelsOfTheScenesObjectGoWithItsHexahedra) {
  FitRequest fit = fit_;
  fit.over = {0.06, true};
  fit.levels = {{0.2, true}};
  const FitRun run = run_fit(mesh_, fit, *progress_);
  const std::filesystem::path file =
      write("angle.yaml", scene_text(run.fit, "angle", "levels", 3.0, run.levels) +
                              "  - name: cube\n    pose: {position: [3, 0.25, 0.5]}\n"
                              "    hexahedra: [{name: c, box: {size: [0.2, 0.2, 0.2]}}]\n" +
                              kComes);
  const ServesRequest asked{load_scene(file), {{mesh_, fit_.input, "angle"}}, 0.04, 0.05};
  ASSERT_EQ(asked.scene.objects[0].levels.size(), 1U);
  Fit coarse;
  coarse.hexahedra.push_back({test::box_vertices({-9, -9, -9}, {2.3, 9, 9}), 15.0, {0, 0, 0}});
  const std::array<const Fit*, 1> covers = {&coarse};
  EXPECT_NEAR(*fly_scene(asked, covers).first_contact, (3.0 - 0.1 - 2.3) / 0.5, 1e-5);
}

// Too coarse a cover for a zone of its own still has bores that stay open: their error is not the zones'.
TEST_F(Serves, BoresThatStayOpenAreNoZones) {
  std::string obj;
  const TriangleMesh mesh = weld(test::tube_mesh(0.5, 1.0, 1.0, 32));
  for (const Vector3& v : mesh.vertices) obj += fmt::format("v {} {} {}\n", v.x(), v.y(), v.z());
  for (const auto& t : mesh.triangles) obj += fmt::format("f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1);
  const std::filesystem::path tube = write("angle.obj", obj);
  ServesRequest asked = request(kComes);
  asked.meshes = {{tube, fit_.input, "angle"}};
  asked.tolerance = 0.06;  // 16 times as much is more than a quarter of the diagonal: no zone is asked for
  FitRequest fit = fit_;
  fit.keep_open = comparison::Length{0.05, false};
  std::size_t without_zones = 0;
  const auto look = [&](const ServesRow& row) {
    EXPECT_GE(row.runs[0].fit.region_excess.size(), 1U);  // the bore's
    if (row.asked_in_zones < 0.25 * row.runs[0].diagonal) return;
    ++without_zones;
    EXPECT_EQ(row.in_zones, row.runs[0].fit.excess);
    EXPECT_EQ(row.serves, row.is_held && row.runs[0].fit.excess <= asked.tolerance);
  };
  const ServesResult result = find_coarsest(fit, asked, *progress_, look);
  EXPECT_GE(without_zones, 2U);
  ASSERT_TRUE(result.best);
}

// One angle is met at its end, the other is passed 0.3 m above its top: each has its own zones.
TEST_F(Serves, SeveralMeshesAreFittedEachWithItsOwnZones) {
  ServesRequest asked = request(std::string(kComes) +
                                "  - name: other\n    static: true\n    pose: {position: [-1, -6, 0]}\n"
                                "    hexahedra: [{name: a, box: {size: [1, 1, 1]}}]\n"
                                "  - name: plate\n    pose: {position: [3, -5, 1.35]}\n"
                                "    hexahedra: [{name: p, box: {size: [0.1, 0.1, 0.1]}}]\n"
                                "    motion: {segments: [{velocity: [-2, 0, 0]}]}\n");
  asked.meshes.push_back({mesh_, fit_.input, "other"});
  asked.margin = 0.4;
  const ServesResult result = find_coarsest(fit_, asked, *progress_);
  ASSERT_TRUE(result.best);
  const ServesRow& best = result.rows[*result.best];
  EXPECT_TRUE(best.serves);
  ASSERT_EQ(best.runs.size(), 2U);
  ASSERT_EQ(result.zones.size(), 2U);
  EXPECT_NEAR(*best.flight.first_contact, (3.0 - 0.1 - 2.0) / 0.5, 0.05 / 0.5);
  // 'other' is passed on its z side only: its lower half is in no zone.
  ASSERT_FALSE(result.zones[1].empty());
  for (const Bounds& zone : result.zones[1]) EXPECT_GT(zone.low.z(), 0.5);
  EXPECT_THAT(serves_text(result, asked), HasSubstr("zone in 'other': "));
}

TEST_F(Serves, ASearchEndsInTimeWithTheBestSoFar) {
  ServesRequest asked = request(kComes);
  asked.seconds = 0.0;
  const ServesResult none = find_coarsest(fit_, asked, *progress_);
  EXPECT_TRUE(none.is_cut);
  EXPECT_FALSE(none.best);
  EXPECT_THAT(serves_text(none, asked), HasSubstr("the time was up"));

  // Cut after the first row: what is there is said, with the error that it is right to.
  asked.seconds = 1e9;
  std::size_t rows = 0;
  const ServesResult some = find_coarsest(fit_, asked, *progress_, [&](const ServesRow&) {
    if (++rows == 1) asked.seconds = 0.0;
  });
  EXPECT_TRUE(some.is_cut);
  EXPECT_EQ(some.rows.size(), 1U);
  ASSERT_TRUE(some.best);
  EXPECT_FALSE(some.rows[*some.best].serves);
  EXPECT_THAT(serves_text(some, asked), HasSubstr("the best so far is right to "));
}

TEST(Zones, FollowTheWayAndLeaveOutWhatIsBesideThePart) {
  // Along x, then along y: two boxes, not the square about both.
  std::vector<Bounds> swept;
  for (int i = 0; i <= 100; ++i) swept.push_back({Vector3(0.1 * i, 0, 0), Vector3(0.1 * i + 0.1, 0.1, 0.1)});
  for (int i = 0; i <= 100; ++i)
    swept.push_back({Vector3(10, 0.1 * i, 0), Vector3(10.1, 0.1 * i + 0.1, 0.1)});
  const Bounds all{Vector3::Constant(-100), Vector3::Constant(100)};
  const std::vector<Bounds> zones = zones_about(swept, 0.05, all);
  ASSERT_EQ(zones.size(), 2U);
  for (const Bounds& each : swept)
    EXPECT_TRUE(std::any_of(zones.begin(), zones.end(), [&](const Bounds& zone) {
      return (zone.low - each.low).maxCoeff() <= -0.049 && (each.high - zone.high).maxCoeff() <= -0.049;
    }));
  // A part that only the second one comes near, and one that none does.
  const std::vector<Bounds> near = zones_about(swept, 0.05, {Vector3(9, 5, 0), Vector3(11, 6, 1)});
  ASSERT_EQ(near.size(), 1U);
  EXPECT_EQ(near[0].low.y(), 5.0);
  EXPECT_TRUE(zones_about(swept, 0.05, {Vector3(0, 0, 5), Vector3(1, 1, 6)}).empty());
}

TEST_F(Serves, WhatHasNoAnswerIsRefused) {
  EXPECT_THAT(error_of(request("")), HasSubstr("nothing moves in scene 's'"));
  EXPECT_THAT(error_of(request(kComes, "lab")), HasSubstr("has no object 'angle'"));
  ServesRequest twice = request(kComes);
  twice.meshes.push_back(twice.meshes[0]);
  EXPECT_THAT(error_of(twice), HasSubstr("object 'angle' has two meshes"));
}

TEST_F(Serves, TheTrainingSceneOfAMeshIsFlownToItsSurface) {
  FitRequest fit = fit_;
  fit.over = {0.1, true};
  fit.training = true;
  const FitRun run = run_fit(mesh_, fit, *progress_);
  for (const auto& [name, text] : cover_files(run)) write(name, text);
  const Approach approach = approach_to(run.mesh);
  const ServesRequest asked{
      load_scene(folder_ / "angle.scene.yaml"), {{mesh_, fit_.input, "angle"}}, 0.1, 0.1};
  const std::array<const Fit*, 1> covers = {&run.fit};
  const ServedFlight flight = fly_scene(asked, covers);
  EXPECT_EQ(approach.velocity.x(), 0.0);  // along z, the shortest side, on to the top at z = 1 m
  const double closed_form = (approach.from.z() - 0.5 * approach.side - 1.0) / -approach.velocity.z();
  ASSERT_TRUE(flight.first_contact);
  EXPECT_LE(*flight.first_contact, closed_form + 1e-9);
  EXPECT_GE(*flight.first_contact, closed_form - (run.fit.excess + 1e-6) / -approach.velocity.z());
}

}  // namespace
}  // namespace touchstone::fitting
