#include "touchstone/examples/fit/serves.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "touchstone/adapters/scene_files/scene_file.hpp"
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
    return {load_scene(file), "angle", 0.04, 0.05, false};
  }
  static constexpr const char* kComes = "    motion: {segments: [{velocity: [-0.5, 0, 0]}]}\n";
  std::string error_of(const ServesRequest& request) {
    return refusal_of([&] { find_coarsest(mesh_, fit_, request, *progress_); });
  }

  std::filesystem::path mesh_;
  FitRequest fit_;
  std::unique_ptr<comparison::ProgressLine> progress_;
};

TEST_F(Serves, TheFirstContactIsTheMeshsToTheErrorInTheZone) {
  const ServesRequest asked = request(kComes);
  const ServesResult result = find_coarsest(mesh_, fit_, asked, *progress_);
  ASSERT_TRUE(result.coarsest);
  for (const ServesRow& row : result.rows) {
    EXPECT_LE(row.in_zone, 0.04);
    ASSERT_TRUE(row.flight.first_contact);
    const double closed_form = (3.0 - 0.1 - 2.0) / 0.5;
    EXPECT_LE(*row.flight.first_contact, closed_form + 1e-9);
    EXPECT_GE(*row.flight.first_contact, closed_form - (row.in_zone + 1e-6) / 0.5);
  }
  const ServesRow& coarsest = result.rows[*result.coarsest];
  EXPECT_TRUE(coarsest.run.verdict.is_proven);
  EXPECT_GT(coarsest.run.fit.excess, 0.04);  // elsewhere it is coarser: that is what it gains
  EXPECT_THAT(serves_text(result, asked), HasSubstr("coarsest that serves: "));
}

TEST_F(Serves, ACoverThatIsTooCoarseWhereItIsMetStopsTooSoon) {
  Fit coarse;
  coarse.hexahedra.push_back({test::box_vertices({-0.1, -0.1, -0.1}, {2.3, 2.1, 1.1}), 1.5, {2, 2, 0.5}});
  const ServedFlight flight = fly_scene(request(kComes), coarse);
  EXPECT_NEAR(*flight.first_contact, (3.0 - 0.1 - 2.3) / 0.5, 1e-5);
  EXPECT_LE(flight.swept.low.x(), 2.3 + 1e-5);
  EXPECT_GE(flight.swept.high.x(), 3.1);
}

TEST_F(Serves, WhatHasNoAnswerIsRefused) {
  EXPECT_THAT(error_of(request("")), HasSubstr("nothing moves in scene 's'"));
  EXPECT_THAT(error_of(request(kComes, "lab")), HasSubstr("has no object 'angle'"));
}

TEST_F(Serves, TheTrainingSceneOfAMeshIsFlownToItsSurface) {
  FitRequest fit = fit_;
  fit.over = {0.1, true};
  fit.training = true;
  const FitRun run = run_fit(mesh_, fit, *progress_);
  for (const auto& [name, text] : cover_files(run)) write(name, text);
  const Approach approach = approach_to(run.mesh);
  const ServesRequest asked{load_scene(folder_ / "angle.scene.yaml"), "angle", 0.1, 0.1, false};
  const ServedFlight flight = fly_scene(asked, run.fit);
  EXPECT_EQ(approach.velocity.x(), 0.0);  // along z, the shortest side, on to the top at z = 1 m
  const double closed_form = (approach.from.z() - 0.5 * approach.side - 1.0) / -approach.velocity.z();
  ASSERT_TRUE(flight.first_contact);
  EXPECT_LE(*flight.first_contact, closed_form + 1e-9);
  EXPECT_GE(*flight.first_contact, closed_form - (run.fit.excess + 1e-6) / -approach.velocity.z());
}

}  // namespace
}  // namespace touchstone::fitting
