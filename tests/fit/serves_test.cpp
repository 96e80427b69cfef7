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
#include "touchstone/examples/fit/least_cover.hpp"
#include "touchstone/examples/fit/training_scene.hpp"
#include "touchstone/tests/fit/meshes.hpp"
#include "touchstone/tests/support/program_test.hpp"
#include "touchstone/tests/support/refusal.hpp"

namespace touchstone::fitting {
namespace {

using testing::HasSubstr;

std::string obj_text(const TriangleMesh& mesh) {
  std::string text;
  for (const Vector3& v : mesh.vertices) text += fmt::format("v {} {} {}\n", v.x(), v.y(), v.z());
  for (const auto& t : mesh.triangles) text += fmt::format("f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1);
  return text;
}

/// An angle stands; a cube of 0.2 m comes from x = 3 m at 0.5 m/s against the end of its leg at x = 2 m.
class Serves : public FolderTest {
 protected:
  Serves() {
    mesh_ = write("angle.obj", obj_text(weld(test::angle_mesh())));
    fit_.input.metres_per_unit = 1.0;
    fit_.repairs = 1;
    progress_ = std::make_unique<program::ProgressLine>();
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
  std::unique_ptr<program::ProgressLine> progress_;
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
  ASSERT_EQ(flight.seen[0].size(), 1U);
  EXPECT_EQ(flight.seen[0][0].X_TO.front().p.x(), 3.0);
  EXPECT_NEAR(flight.seen[0][0].X_TO.back().p.x(), 2.3 + 0.1, 1e-5);
  EXPECT_LE(flight.frame_us, flight.frame_999_us);
  EXPECT_LE(flight.frame_999_us, flight.slowest_us);
}

// The mover goes up a steep plate, over it and down behind it, all in one frame: the mesh sees the way, not
// only its ends.
TEST_F(Serves, AFrameThatGoesAroundACornerIsSeenAlongIt) {
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
  double highest = -1e300;
  for (const Pose& X_TO : flight.seen[0][0].X_TO) highest = std::max(highest, X_TO.p.y());
  EXPECT_GT(highest, 3.5 * along.y());  // over the plate's end
}

/// A box that nothing meets.
Fit cover_aside() {
  Fit cover;
  cover.hexahedra.push_back({test::box_vertices({-0.1, -0.1, -0.1}, {1.0, 1.0, 1.0}), 1.0, {0, 0, 0}});
  return cover;
}

/// Turns by 0.3 rad about a pivot 10 m off, which goes so that the end of the turn is where it began.
Motion pivoted(const Vector3& p_W) {
  const double lever = 10.0, turn = 0.3;
  MotionSegment segment;
  segment.duration = 1.0;
  segment.rate = turn;
  segment.pivot_W = p_W - Vector3(lever, 0, 0);
  segment.velocity_W = Vector3(lever * (1.0 - std::cos(turn)), -lever * std::sin(turn), 0);
  return {{segment}, {}};
}

/// From the first pose of a frame to the last: how far the farthest corner is from where it is at both, at
/// most. @param X_TO at s.
template <class At>
double strayed(const SeenObject& seen, const At& X_TO) {
  double most = 0.0;
  for (const Bounds& part : seen.parts_O)
    for (const Vector3& q : test::box_vertices(part.low, part.high))
      for (int k = 0; k <= 1000; ++k) {
        const Vector3 at = transform(X_TO(k / 1000.0), q);
        most =
            std::max(most, std::min(norm(at - transform(X_TO(0.0), q)), norm(at - transform(X_TO(1.0), q))));
      }
  return most;
}

// Both ends are in one place, the way between is an arc.
TEST_F(Serves, WhatTurnsAboutAPivotIsSeenOnItsArc) {
  const Fit cover = cover_aside();
  const std::array<const Fit*, 1> covers = {&cover};
  ServesRequest asked = request(kComes);
  asked.scene.frame_rate = asked.scene.duration = 1.0;
  for (const bool is_mesh : {false, true}) {
    const Pose mesh = asked.scene.objects[0].X_WO, cube = asked.scene.objects[1].X_WO;
    const Motion motion = pivoted(is_mesh ? mesh.p : cube.p);
    asked.scene.objects[0].motion = is_mesh ? motion : Motion{};
    asked.scene.objects[1].motion = is_mesh ? Motion{} : motion;
    asked.scene.objects[0].is_static = !is_mesh;
    const SeenObject seen = fly_scene(asked, covers).seen[0][0];
    const double truth = strayed(seen, [&](double s) {
      const Pose moved = pose_at(motion, is_mesh ? mesh : cube, s);
      return is_mesh ? compose(inverse(moved), cube) : compose(inverse(mesh), moved);
    });
    ASSERT_EQ(seen.X_TO.size(), 2U) << is_mesh;
    EXPECT_GT(truth, 0.1) << is_mesh;
    EXPECT_GE(seen.strays[1], truth) << is_mesh;
    EXPECT_LE(seen.strays[1], (is_mesh ? 6.0 : 1.5) * truth) << is_mesh;
  }
}

// A wall stops the cube half-way, 1 m on; the mesh goes 1 m in the whole frame: both end as they began.
TEST_F(Serves, WhereOneIsStoppedTheOtherIsSeenToGoOn) {
  ServesRequest asked = request(
      "    motion: {segments: [{velocity: [2, 0, 0]}]}\n"
      "  - name: wall\n    static: true\n    pose: {position: [4.6, 0.25, 0.5]}\n"
      "    hexahedra: [{name: w, box: {size: [1, 1, 1]}}]\n");
  asked.scene.frame_rate = asked.scene.duration = 1.0;
  asked.scene.objects[0].is_static = false;
  asked.scene.objects[0].motion = asked.scene.objects[1].motion;
  asked.scene.objects[0].motion.segments[0].velocity_W = Vector3(1, 0, 0);
  const Fit cover = cover_aside();
  const std::array<const Fit*, 1> covers = {&cover};
  const SeenObject seen = fly_scene(asked, covers).seen[0][0];
  ASSERT_EQ(seen.X_TO.size(), 3U);
  EXPECT_NEAR(seen.X_TO[1].p.x() - seen.X_TO[0].p.x(), 0.5, 1e-5);
  EXPECT_NEAR(seen.X_TO[2].p.x() - seen.X_TO[0].p.x(), 0.0, 1e-5);
  for (const std::size_t i : {1U, 2U}) EXPECT_NEAR(seen.strays[i], 0.25, 1e-5);
}

/// A box up to `high` that stands where the angle does.
ServedFlight flight_over(const ServesRequest& asked, const Vector3& high) {
  Fit cover;
  cover.hexahedra.push_back({test::box_vertices({-0.1, -0.1, -0.1}, high), 1.0, {0, 0, 0}});
  const std::array<const Fit*, 1> covers = {&cover};
  return fly_scene(asked, covers);
}

// The command goes 0.2 m into the angle, up by 1 m, and out again: the cube is released where the command
// passes it, and then goes up in one frame. 30 mm of the cover are three frames.
TEST_F(Serves, AStopIsComparedWhereItIsAndNotWhereItEnds) {
  const ServesRequest asked = request(
      "    motion:\n      segments:\n        - {duration: 2, velocity: [-0.5, 0, 0]}\n"
      "        - {start: 2, duration: 0.2, velocity: [0, 0, 5]}\n"
      "        - {start: 2.2, duration: 0.8, velocity: [0.5, 0, 0]}\n");
  const FlightDifference apart =
      difference(flight_over(asked, {2.19, 2, 9}), flight_over(asked, {2.16, 2, 9}));
  ASSERT_TRUE(apart.are_alike);
  EXPECT_NEAR(apart.stops, 0.03, 1e-5);
  EXPECT_NEAR(apart.begins, 0.03 / 0.5, 1e-4);
  EXPECT_NEAR(apart.ends, 0.06, 0.021);
  EXPECT_NEAR(apart.frames, std::hypot(1.0, 0.03), 0.02);
}

// The cube passes 15 mm above one cover, and is stopped by one that is 30 mm higher: both are right to 40 mm.
TEST_F(Serves, WhereCoversThatServeStopElsewhereThatIsSaid) {
  ServesRequest asked = request(kComes);
  asked.scene.objects[1].X_WO.p.z() = 1.115;
  ServesResult result;
  for (const double z : {1.0, 1.0, 1.03}) {
    ServesRow row;
    row.serves = row.is_right = row.is_held = true;
    row.flight = flight_over(asked, {2.0, 2.0, z});
    result.rows.push_back(row);
  }
  result.best = 0;
  EXPECT_FALSE(difference(result.rows[0].flight, result.rows[2].flight).are_alike);
  EXPECT_THAT(serves_text(result, asked),
              HasSubstr("STOPS ARE NOT SURE: of 2 more that serve, 1 have other contacts"));
  result.rows.pop_back();
  EXPECT_THAT(serves_text(result, asked), HasSubstr("of 1 more that serve, contacts are the same"));
  // Stops that are further apart than the tolerance are reported, too.
  asked.scene.objects[1].X_WO.p.z() = 0.5;
  result.rows[0].flight = flight_over(asked, {2.0, 2.0, 1.0});
  result.rows[1].flight = flight_over(asked, {2.05, 2.0, 1.0});
  EXPECT_THAT(serves_text(result, asked), HasSubstr("0 have other contacts, and stops of the rest are up to "
                                                    "50 mm apart"));
}

// The cube meets a round post at a slant, 10 mm within its side: covers that are right to 40 mm may stop it
// much earlier than the post does. These do not serve, and others are looked for.
TEST_F(Serves, ACoverThatStopsThingsTooFarFromTheMeshDoesNotServe) {
  ServesRequest asked = request(kComes);
  asked.meshes[0].file = write("post.obj", obj_text(weld(test::cone_mesh(1.0, 1.0, 1.0, 24))));
  asked.scene.objects[1].X_WO.p = Vector3(1.3, 0.99 + 0.1, 0.5);
  asked.tolerance = 0.04;
  fit_.tries = 1;
  const ServesResult result = find_coarsest(fit_, asked, *progress_);
  ASSERT_TRUE(result.best);
  const ServesRow& best = result.rows[*result.best];
  EXPECT_TRUE(best.serves);
  EXPECT_EQ(best.flight.contacts.size(), 1U);
  ASSERT_TRUE(best.from_meshes);
  EXPECT_LE(best.from_meshes->stops, asked.tolerance);
  EXPECT_TRUE(std::any_of(result.rows.begin(), result.rows.end(), [](const ServesRow& row) {
    return row.in_zones <= 0.04 && row.is_held && row.flight.first_contact;
  }));
  EXPECT_THAT(serves_text(result, asked), HasSubstr("but stop things elsewhere: they do not serve"));
}

// Of the post, all covers but the first are refused, and that of one error everywhere: it stops the cube too
// far from the post, but is right.
TEST_F(Serves, ACoverThatIsRightComesBeforeOneThatIsNot) {
  ServesRequest asked = request(kComes);
  asked.meshes[0].file = write("post.obj", obj_text(weld(test::cone_mesh(1.0, 1.0, 1.0, 24))));
  asked.scene.objects[1].X_WO.p = Vector3(1.3, 0.99 + 0.1, 0.5);
  asked.with_uniform = true;
  fit_.tries = 1;
  int left = 0;
  fit_.on_progress = [&] {
    if (left > 0) --left, reject("fit", "too many cells");
  };
  // Four rows, each also with ever smaller errors elsewhere.
  const ServesResult result =
      find_coarsest(fit_, asked, *progress_, [&](const ServesRow& row) { left = row.is_uniform ? 0 : 12; });
  EXPECT_EQ(result.left_out.size(), 4U);
  ASSERT_EQ(result.rows.size(), 2U);
  EXPECT_TRUE(result.rows[1].is_uniform && result.rows[1].is_right);
  EXPECT_FALSE(result.rows[1].serves);
  EXPECT_EQ(result.best, 1U);
  EXPECT_THAT(serves_text(result, asked), HasSubstr("coarsest that is right to the tolerance: "));
}

// However many plates of the mesh, or hexahedra of a cover, are met at once, it is one contact.
TEST_F(Serves, TheMeshsOwnFlightStopsWhereItsTrianglesAre) {
  const ServesRequest asked = request(kComes);
  const std::array<MeshDistance, 1> meshes = {MeshDistance(weld(test::angle_mesh()))};
  const std::optional<ServedFlight> own = fly_meshes(asked, meshes);
  ASSERT_TRUE(own);
  EXPECT_EQ(own->contacts.size(), 1U);
  ASSERT_EQ(own->stops.size(), 1U);
  EXPECT_NEAR(own->stops[0].p_WB.x(), 2.1, 1e-5);
  Fit cut;
  for (const double y : {0.0, 0.3})
    cut.hexahedra.push_back({test::box_vertices({0, y, 0}, {2, y + 0.3, 1}), 0.1, {0, 0, 0}});
  const std::array<const Fit*, 1> covers = {&cut};
  const FlightDifference apart = difference(*own, fly_scene(asked, covers));
  EXPECT_TRUE(apart.are_alike);
  EXPECT_LT(apart.stops, 1e-6);
}

// Within a shell the cube meets no triangle, whether it begins there or passes through: every cover tells of
// a contact that the triangles do not, so that their flight says nothing.
TEST_F(Serves, TrianglesThatSomethingIsInsideOfAreNotFlown) {
  const std::array<MeshDistance, 1> meshes = {MeshDistance(weld(test::angle_mesh()))};
  ServesRequest asked = request(kComes);
  EXPECT_TRUE(fly_meshes(asked, meshes));
  asked.scene.objects[1].X_WO.p = Vector3(1.5, 0.25, 0.5);
  EXPECT_FALSE(fly_meshes(asked, meshes));
  asked = request(kComes);
  asked.scene.rules.push_back({"cube", "angle", ContactPolicy::cue});
  EXPECT_FALSE(fly_meshes(asked, meshes));
  EXPECT_FALSE(find_coarsest(fit_, asked, *progress_).has_meshes);
}

// A long wall stops the cube, which slides along it into the cover, where contact is only cued: a way that
// has no times of its own.
TEST_F(Serves, WhatASlideMeetsIsToldAtTheFramesEnd) {
  ServesRequest asked = request(
      "    motion: {segments: [{velocity: [-2, -3, 0]}]}\n"
      "  - name: wall\n    static: true\n    pose: {position: [2, 0, 0.5]}\n"
      "    hexahedra: [{name: w, box: {size: [1, 20, 1]}}]\n");
  asked.scene.frame_rate = asked.scene.duration = 1.0;
  asked.scene.policy = ContactPolicy::slide;
  asked.scene.rules.push_back({"cube", "angle", ContactPolicy::cue});
  Fit cover;
  cover.hexahedra.push_back({test::box_vertices({2.6, -9, 0}, {9, -1, 1}), 1.0, {0, 0, 0}});
  const std::array<const Fit*, 1> covers = {&cover};
  const ServedFlight flight = fly_scene(asked, covers);
  ASSERT_EQ(flight.contacts.size(), 1U);
  EXPECT_EQ(flight.contacts[0].time, 1.0);
  EXPECT_NEAR(flight.contacts[0].p_WB.x(), 2.6, 1e-5);
  EXPECT_NEAR(flight.contacts[0].p_WB.y(), -0.9, 1e-5);
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
  const std::filesystem::path tube = write("angle.obj", obj_text(weld(test::tube_mesh(0.5, 1.0, 1.0, 32))));
  ServesRequest asked = request(kComes);
  asked.meshes = {{tube, fit_.input, "angle"}};
  asked.tolerance = 0.06;  // 16 times as much is more than a quarter of the diagonal: no zone is asked for
  FitRequest fit = fit_;
  fit.keep_open = program::Length{0.05, false};
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
  ASSERT_EQ(best.zones.size(), 2U);
  EXPECT_NEAR(*best.flight.first_contact, (3.0 - 0.1 - 2.0) / 0.5, 0.05 / 0.5);
  // 'other' is passed on its z side only: its lower half is in no zone.
  ASSERT_FALSE(best.zones[1].empty());
  for (const Bounds& zone : best.zones[1]) EXPECT_GT(zone.low.z(), 0.4);
  EXPECT_THAT(serves_text(result, asked), HasSubstr("zone in 'other': "));
}

TEST_F(Serves, ASearchEndsInTimeWithTheBestSoFar) {
  ServesRequest asked = request(kComes);
  asked.seconds = 0.0;
  const ServesResult none = find_coarsest(fit_, asked, *progress_);
  EXPECT_TRUE(none.is_cut);
  EXPECT_FALSE(none.best);
  EXPECT_THAT(serves_text(none, asked), HasSubstr("the time was up"));

  // Cut after the first row: that row is reported, with the error that it is right to.
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

// The angle itself comes, 0.5 m/s along x, with the end of its leg against a block from x = 2.9 m on.
TEST_F(Serves, AMeshThatMovesIsFittedWhereItComesNearOthers) {
  ServesRequest asked = request("    motion: {segments: [{velocity: [-0.5, 0, 0]}]}\n");
  std::swap(asked.scene.objects[0].motion, asked.scene.objects[1].motion);
  asked.scene.objects[0].motion.segments[0].velocity_W = Vector3(0.5, 0, 0);
  asked.scene.objects[0].is_static = false;
  const ServesResult result = find_coarsest(fit_, asked, *progress_);
  ASSERT_TRUE(result.best);
  const ServesRow& best = result.rows[*result.best];
  EXPECT_TRUE(best.serves);
  const double closed_form = (3.0 - 0.1 - 2.0) / 0.5;
  EXPECT_LE(*best.flight.first_contact, closed_form + 1e-9);
  EXPECT_GE(*best.flight.first_contact, closed_form - (best.in_zones + 1e-6) / 0.5);
  EXPECT_GT(best.runs[0].fit.excess, 0.04);
  // The block comes near the leg's end alone.
  ASSERT_FALSE(best.zones[0].empty());
  for (const Bounds& zone : best.zones[0]) EXPECT_GT(zone.low.x(), 1.0);
}

// Both may be too large where they meet: each gets half of the tolerance, and the sum is reported.
TEST_F(Serves, OfTwoMeshesThatMeetTheErrorsAddUp) {
  ServesRequest asked = request("    motion: {segments: [{velocity: [-0.5, 0, 0]}]}\n");
  asked.scene.objects[1].X_WO.p = Vector3(3, 0, 0);
  asked.meshes.push_back({mesh_, fit_.input, "cube"});
  EXPECT_TRUE(may_meet_each_other(asked));
  const ServesResult result = find_coarsest(fit_, asked, *progress_);
  ASSERT_TRUE(result.best);
  const ServesRow& best = result.rows[*result.best];
  EXPECT_TRUE(best.serves);
  EXPECT_TRUE(std::any_of(result.rows.begin(), result.rows.end(),
                          [&](const ServesRow& row) { return row.asked_in_zones == 0.5 * asked.tolerance; }));
  double sum = 0.0;
  for (const FitRun& run : best.runs)
    sum += run.fit.region_excess.empty()
               ? run.fit.excess
               : *std::max_element(run.fit.region_excess.begin(), run.fit.region_excess.end());
  EXPECT_NEAR(best.in_zones, sum, 1e-12);
  const double closed_form = (3.0 - 2.0) / 0.5;
  EXPECT_LE(*best.flight.first_contact, closed_form + 1e-9);
  EXPECT_GE(*best.flight.first_contact, closed_form - (best.in_zones + 1e-6) / 0.5);
}

// Gaps of 1.4 tolerances: one of the two meshes may fill them, where the other one's cover has no error.
TEST_F(Serves, WhatAnyCoversNeedLetsOneOfTwoMeshesHaveAllOfTheTolerance) {
  TriangleMesh comb = test::box_mesh({0, 0, 0}, {3, 0.2, 1});
  test::append(comb, test::box_mesh({0, 0.1, 0}, {0.3, 1.4, 1}));
  for (int tooth = 0; tooth < 5; ++tooth)
    test::append(comb, test::box_mesh({1.2 + 0.324 * tooth, 0.1, 0}, {1.3 + 0.324 * tooth, 1.2, 1}));
  ServesRequest asked = request("    motion: {segments: [{velocity: [0, -0.5, 0]}]}\n");
  asked.scene.objects[1].X_WO.p = Vector3(1.2, 2, 0.4);
  asked.meshes = {
      {write("comb.obj", obj_text(comb)), fit_.input, "angle"},
      {write("bar.obj", obj_text(test::box_mesh({0, 0, 0}, {1.4, 0.1, 0.2}))), fit_.input, "cube"}};
  asked.tolerance = 0.16;
  asked.margin = 0.1;
  asked.seconds = 1e9;
  // The first that serves is enough: of a search that is cut the bound is known, too.
  const ServesResult result = find_coarsest(fit_, asked, *progress_, [&](const ServesRow& row) {
    if (row.serves) asked.seconds = 0.0;
  });
  EXPECT_TRUE(result.is_cut);
  ASSERT_TRUE(result.best);
  const ServesRow& best = result.rows[*result.best];
  ASSERT_TRUE(best.serves);
  ASSERT_FALSE(best.zones.empty());
  EXPECT_GT(best.in_zones, 0.5 * asked.tolerance);
  EXPECT_GE(result.least, 2U);
  EXPECT_LE(result.least, best.hexahedra);
  // With half of it for each there would be one hexahedron a tooth.
  EXPECT_GT(least_hexahedra(MeshDistance(weld(comb)), best.zones[0], 0.5 * asked.tolerance), best.hexahedra);
}

TEST_F(Serves, TheUniformCoverStandsBesideTheFittedOne) {
  ServesRequest asked = request(kComes);
  asked.tolerance = 0.1;
  asked.with_uniform = true;
  const ServesResult result = find_coarsest(fit_, asked, *progress_);
  const ServesRow& uniform = result.rows.back();
  ASSERT_TRUE(result.best);
  EXPECT_TRUE(uniform.is_uniform);
  EXPECT_LE(uniform.runs[0].fit.excess, asked.tolerance);
  EXPECT_EQ(uniform.flight.contacts.size(), result.rows[*result.best].flight.contacts.size());
  EXPECT_THAT(comparison_text(result, asked), HasSubstr("uniform error"));
  EXPECT_GE(result.least, 1U);
  EXPECT_LE(result.least, result.rows[*result.best].hexahedra);
  asked.with_uniform = false;
  EXPECT_EQ(comparison_text(find_coarsest(fit_, asked, *progress_), asked), "");
}

// From the first row that serves on no cover is found: that row stands, and the others are named.
TEST_F(Serves, RowsThatHaveNoCoverLeaveThoseThatServe) {
  ServesRequest asked = request(kComes);
  asked.tolerance = 4e-3;
  asked.with_uniform = true;
  bool is_refused = false;
  fit_.on_progress = [&] {
    if (is_refused) reject("fit", "too many cells");
  };
  const ServesResult result =
      find_coarsest(fit_, asked, *progress_, [&](const ServesRow& row) { is_refused = row.serves; });
  ASSERT_TRUE(result.best);
  EXPECT_EQ(*result.best, result.rows.size() - 1);
  EXPECT_TRUE(result.rows.back().serves);
  const std::string text = serves_text(result, asked);
  EXPECT_THAT(text, HasSubstr("left out: 4 mm in the zones, 1024 mm elsewhere: fit: too many cells\n"));
  EXPECT_THAT(text, HasSubstr("left out: 4 mm everywhere: fit: too many cells\n"));
  EXPECT_THAT(text, HasSubstr("coarsest that serves: "));
  EXPECT_THAT(error_of(asked), HasSubstr("too many cells"));  // none at all
}

// The error elsewhere grows while that takes fewer; finer ones are tried only where no larger one is better.
TEST_F(Serves, ElsewhereGrowsAsLongAsThereAreFewer) {
  ServesRequest asked = request(kComes);
  asked.tolerance = 4e-3;
  std::vector<double> tried;
  std::vector<std::size_t> counts;
  const auto look = [&](const ServesRow& row) {
    if (row.asked_in_zones > asked.tolerance) return;
    tried.push_back(row.elsewhere / asked.tolerance);
    counts.push_back(row.hexahedra);
  };
  const ServesResult result = find_coarsest(fit_, asked, *progress_, look);
  ASSERT_TRUE(result.best);
  const auto larger = std::find_if(tried.begin(), tried.end(), [](double times) { return times > 100.0; });
  ASSERT_NE(larger, tried.end());
  EXPECT_NEAR(*larger, 256.0, 1e-9);
  const auto at = static_cast<std::size_t>(larger - tried.begin());
  ASSERT_GE(at, 1U);
  if (counts[at] < counts[at - 1]) {
    EXPECT_NEAR(tried.back(), 1024.0, 1e-9);
    return;
  }
  ASSERT_GT(tried.size(), at + 1);
  EXPECT_NEAR(tried[at + 1], 16.0, 1e-9);
  EXPECT_EQ(tried.size() > at + 2, counts[at + 1] < counts[at - 1]);  // then 4 times
}

/// A cube of 0.1 m that moves along some paths, without turning, seen every 0.1 m.
SeenObject cube_along(std::span<const Vector3> corners) {
  SeenObject cube;
  cube.parts_O.push_back({Vector3::Constant(-0.05), Vector3::Constant(0.05)});
  for (std::size_t i = 1; i < corners.size(); ++i) {
    const double length = norm(corners[i] - corners[i - 1]);
    for (double at = 0.0; at < length; at += 0.1) {
      cube.X_TO.push_back(
          {Matrix3::Identity(), corners[i - 1] + at / length * (corners[i] - corners[i - 1])});
      cube.strays.push_back(cube.X_TO.size() == 1 ? 0.0 : 0.05);
    }
  }
  return cube;
}

TEST(Zones, FollowTheWayAndLeaveOutWhatIsBesideIt) {
  // Over a plate, along x, then along y: two boxes, not the square about both.
  const Bounds plate{Vector3(0, 0, -0.1), Vector3(10, 10, 0)};
  const MeshDistance mesh(weld(test::box_mesh(plate.low, plate.high)));
  const std::array<Vector3, 3> way = {{{0.5, 0.5, 0.1}, {9.5, 0.5, 0.1}, {9.5, 9.5, 0.1}}};
  const SeenObject cube = cube_along(way);
  NearCells near(mesh, 0.1);
  near.add(cube, 0.1);
  const std::vector<Bounds> zones = near.boxes();
  ASSERT_EQ(zones.size(), 2U);
  const std::array<Bounds, 1> boxes = {plate};
  EXPECT_TRUE(are_held(boxes, cube, 0.1, zones));
  for (std::size_t i = 0; i < 2; ++i)
    EXPECT_FALSE(are_held(boxes, cube, 0.1, std::span(zones).subspan(i, 1)));
  EXPECT_FALSE(are_held(boxes, cube, 1.0, zones));
  // Two halves of a zone hold what it holds.
  std::vector<Bounds> halves = zones;
  halves.push_back(zones[0]);
  halves[0].high.x() = halves[2].low.x() = 0.5 * (zones[0].low.x() + zones[0].high.x());
  EXPECT_TRUE(are_held(boxes, cube, 0.1, halves));
  // A way above the plate that is too far counts nowhere, and one beside it neither.
  NearCells none(mesh, 0.1);
  const std::array<Vector3, 2> above = {{{0.5, 0.5, 0.5}, {9.5, 0.5, 0.5}}},
                               beside = {{{-1, -1, 0}, {-1, 9, 0}}};
  for (const std::span<const Vector3> each :
       {std::span<const Vector3>(above), std::span<const Vector3>(beside)})
    none.add(cube_along(each), 0.1);
  EXPECT_TRUE(none.boxes().empty());
}

// Seen from a mesh that turns, what stands goes around: between two poses, too.
TEST(Zones, WhatIsBetweenTwoPosesIsLookedAt) {
  const Bounds plate{Vector3(0, 0, -0.1), Vector3(10, 10, 0)};
  SeenObject cube;
  cube.parts_O.push_back({Vector3::Constant(-0.05), Vector3::Constant(0.05)});
  cube.X_TO = {{Matrix3::Identity(), Vector3(1, 5, 0)}, {Matrix3::Identity(), Vector3(9, 5, 0)}};
  cube.strays = {0.0, 4.0};
  const std::array<Bounds, 1> boxes = {plate};
  const std::array<Bounds, 2> ends = {
      {{Vector3(0, 4, -1), Vector3(2, 6, 1)}, {Vector3(8, 4, -1), Vector3(10, 6, 1)}}};
  EXPECT_FALSE(are_held(boxes, cube, 0.1, ends));
  const MeshDistance mesh(weld(test::box_mesh(plate.low, plate.high)));
  NearCells near(mesh, 0.1);
  near.add(cube, 0.1);
  EXPECT_TRUE(are_held(boxes, cube, 0.1, near.boxes()));
}

TEST(LeastCover, CountsWhatNoTwoOfCanBeInOneConvexPart) {
  // Seven teeth, 0.5 m apart, on a bar.
  TriangleMesh comb = test::box_mesh({0, 0, 0}, {6.5, 1, 0.5});
  for (int i = 0; i < 7; ++i) test::append(comb, test::box_mesh({1.0 * i, 0, 0.5}, {1.0 * i + 0.5, 1, 2}));
  const MeshDistance mesh(weld(comb));
  const std::vector<Bounds> all = {{{-1, -1, -1}, {8, 2, 3}}};
  EXPECT_EQ(least_hexahedra(mesh, all, 0.01), 8U);  // the teeth, and the bar between two of them
  EXPECT_EQ(least_hexahedra(mesh, all, 0.26), 1U);  // no point between teeth is farther than half their gap
  // Two teeth are in the zone: they and the bar, and what is on either side, each of which one box may hold.
  EXPECT_EQ(least_hexahedra(mesh, std::vector<Bounds>{{{2.9, -1, 0.6}, {4.6, 2, 3}}}, 0.01), 5U);
  EXPECT_EQ(least_hexahedra(MeshDistance(weld(test::box_mesh({0, 0, 0}, {1, 1, 1}))), all, 1e-9), 1U);
}

TEST_F(Serves, WhatHasNoAnswerIsRefused) {
  EXPECT_THAT(error_of(request("")), HasSubstr("nothing moves in scene 's'"));
  EXPECT_THAT(error_of(request(kComes, "lab")), HasSubstr("has no object 'angle'"));
  ServesRequest twice = request(kComes);
  twice.meshes.push_back(twice.meshes[0]);
  EXPECT_THAT(error_of(twice), HasSubstr("object 'angle' has two meshes"));
  ServesRequest exempt = request(kComes);
  exempt.scene.exempt_pairs.push_back({"cube", "angle"});
  EXPECT_THAT(error_of(exempt), HasSubstr("nothing can meet object 'angle'"));
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
