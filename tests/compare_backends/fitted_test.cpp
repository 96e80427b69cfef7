#include <gmock/gmock.h>

#include <cmath>

#include "touchstone/adapters/all/all_backends.hpp"
#include "touchstone/contact_core/native/native.hpp"
#include "touchstone/examples/compare_backends/fitted/fitted_page.hpp"
#include "touchstone/tests/fit/meshes.hpp"
#include "touchstone/tests/support/program_test.hpp"
#include "touchstone/tests/support/refusal.hpp"

namespace touchstone::comparison {
namespace {

using ::testing::HasSubstr;

FittedCover box_cover(double grown, double error) {
  const Vector3 by = Vector3::Constant(grown);
  std::vector<PlacedHexahedron> solids;
  solids.push_back({"h0",
                    Hexahedron::from_vertices(test::box_vertices(Vector3::Zero() - by, Vector3::Ones() + by)),
                    Pose()});
  return {error, HexahedronTree(std::move(solids), "cover")};
}

/// A cube of 0.2 m beside a unit cube, `gap` away along x.
ClearancePoses beside(std::initializer_list<double> gaps) {
  ClearancePoses poses{Hexahedron::from_size({0.2, 0.2, 0.2}), 1.0, {}};
  for (const double gap : gaps) {
    poses.poses.emplace_back();
    poses.poses.back().p = {1.0 + 0.1 + gap, 0.5, 0.5};
  }
  return poses;
}

/// `native`, whose clearances are off by a millimetre; or which supports none.
class Off : public Narrowphase {
 public:
  explicit Off(bool is_unsupported) : is_unsupported_(is_unsupported) {}
  std::string_view name() const noexcept override { return "off"; }
  const Capabilities& capabilities() const noexcept override { return inner_->capabilities(); }
  void build(std::span<const Hexahedron> solids) override { inner_->build(solids); }
  std::unique_ptr<Workspace> make_workspace() const override { return inner_->make_workspace(); }
  void evaluate(const NarrowphaseInput& input, const NarrowphaseOutput& output,
                Workspace& workspace) const noexcept override {
    inner_->evaluate(input, output, workspace);
    for (PairGeometry& each : output.geometry) each.separation += 1e-3;
    if (is_unsupported_)
      for (PairStatus& each : output.status) each = PairStatus::unsupported;
  }

 private:
  std::unique_ptr<Narrowphase> inner_ = make_native();
  bool is_unsupported_;
};

class Fitted : public ::testing::Test {
 protected:
  Fitted() {
    register_all_backends(registry_);
    for (const bool is_unsupported : {false, true}) {
      BackendRegistry::NarrowphaseEntry entry;
      entry.name = is_unsupported ? "unsupporting" : "off";
      entry.make = [is_unsupported] { return std::make_unique<Off>(is_unsupported); };
      registry_.add(entry);
    }
  }
  TotalErrors measure(const std::vector<FittedCover>& covers, const ClearancePoses& poses,
                      const std::vector<std::string>& backends) const {
    return measure_total_errors(covers, poses, registry_, backends, 1);
  }

  BackendRegistry registry_;
};

TEST_F(Fitted, TheTotalIsTheGeometrysAndTheBackends) {
  const std::vector<FittedCover> covers = {box_cover(0.1, 0.2), box_cover(0.0, 0.0)};
  const TotalErrors errors = measure(covers, beside({0.05, 0.3}), {"native", "off"});
  ASSERT_EQ(errors.rows.size(), 4u);
  EXPECT_EQ(errors.bracket, 0.0);  // the second cover is the mesh itself
  // Grown by 0.1 m, the cover is touched at the first pose: 0.05 m are missing there, 0.1 m at the other.
  const TotalErrorRow &coarse = errors.rows[0], &coarse_off = errors.rows[1], &fine = errors.rows[2],
                      &fine_off = errors.rows[3];
  EXPECT_NEAR(coarse.total, 0.1, 1e-12);
  EXPECT_NEAR(coarse.geometry_seen, 0.1, 1e-12);
  EXPECT_EQ(coarse.geometry, 0.2);
  EXPECT_LE(coarse.backend_error, 1e-12);
  EXPECT_NEAR(coarse_off.backend_error, 1e-3, 1e-12);
  EXPECT_NEAR(coarse_off.total, 0.1 - 1e-3, 1e-12);  // one error makes up for part of the other
  EXPECT_LE(fine.total, 1e-12);
  EXPECT_NEAR(fine_off.total, 1e-3, 1e-12);
  EXPECT_EQ(cheapest_within(errors, 1e-6), 2u);
  EXPECT_FALSE(cheapest_within({{coarse}, 0.0}, 0.01));
}

// Pairs are a part of the frame: of one run, both by the processor's time.
TEST_F(Fitted, APairsTimeIsAPartOfTheFrames) {
  const TotalErrors errors = measure_total_errors(
      std::vector<FittedCover>{box_cover(0.1, 0.2), box_cover(0.0, 0.0)}, beside({0.05, 0.1, 0.2, 0.3}),
      registry_, std::vector<std::string>{"native", "exact"}, 20);
  for (const TotalErrorRow& row : errors.rows) {
    EXPECT_GT(row.pair_ns, 0.0);
    EXPECT_LT(row.pairs * row.pair_ns, row.frame_ns) << row.backend;
  }
}

TEST_F(Fitted, WithoutAFinerCoverTheCertifiedErrorIsAdded) {
  const TotalErrors errors = measure({box_cover(0.1, 0.2)}, beside({0.3}), {"native"});
  EXPECT_NEAR(errors.bracket, 0.2, 1e-12);
  EXPECT_NEAR(errors.rows[0].total, 0.2, 1e-12);  // the mesh may be that far within
  EXPECT_EQ(errors.rows[0].geometry_seen, 0.0);
}

TEST_F(Fitted, CertificatesThatContradictEachOtherAreRefused) {
  EXPECT_THAT(refusal_of([&] {
                measure({box_cover(0.1, 0.05), box_cover(0.0, 0.0)}, beside({0.3}), {"native"});
              }),
              HasSubstr("certificates contradict each other: at pose 0"));
}

TEST_F(Fitted, WhatABackendDoesNotAnswerHasNoTotalAndNoTime) {
  const TotalErrors errors = measure({box_cover(0.0, 0.01)}, beside({0.1, 0.2}), {"unsupporting"});
  EXPECT_EQ(errors.rows[0].unanswered, 2u);
  EXPECT_EQ(errors.rows[0].frame_ns, 0.0);
  EXPECT_FALSE(cheapest_within(errors, 1.0));
  EXPECT_THAT(fitted_text({"box.stl", 12, 1.7, 0.2, 1.0, 2, errors}), HasSubstr("unanswered: 2 of 2"));
}

TEST_F(Fitted, PosesAreApartFromTheMeshWithinTheRangeAndTheSameAgain) {
  const FittedCover cover = box_cover(0.0, 1e-3);
  const PosesRequest request{0.1, 0.2, 50, 7};
  const TriangleMesh mesh = weld(test::box_mesh({0, 0, 0}, {1, 1, 1}));
  const ClearancePoses poses = make_poses(mesh, cover, request), again = make_poses(mesh, cover, request);
  ASSERT_EQ(poses.poses.size(), 50u);
  const MeshDistance solid(mesh);
  for (std::size_t i = 0; i < poses.poses.size(); ++i) {
    EXPECT_TRUE(is_same(poses.poses[i], again.poses[i]));
    // The cube's centre is outside, and at most its half diagonal and the range away.
    const double distance = solid.signed_distance(poses.poses[i].p);
    EXPECT_GT(distance, 0.05 - 1e-12);
    EXPECT_LT(distance, 0.2 + 0.05 * std::sqrt(3.0));
  }
  EXPECT_THAT(refusal_of([&] { make_poses(mesh, box_cover(1.0, 2.0), request); }), HasSubstr("only 0 of 50"));
}

class FittedProgram : public ProgramTest {
 protected:
  FittedProgram() : ProgramTest(COMPARE_BACKENDS) {
    const TriangleMesh mesh = weld(test::angle_mesh());
    std::string obj;
    for (const Vector3& v : mesh.vertices)
      obj += "v " + std::to_string(v.x()) + " " + std::to_string(v.y()) + " " + std::to_string(v.z()) + "\n";
    for (const auto& t : mesh.triangles)
      obj += "f " + std::to_string(t[0] + 1) + " " + std::to_string(t[1] + 1) + " " +
             std::to_string(t[2] + 1) + "\n";
    mesh_ = write("angle.obj", obj).string();
  }
  std::string mesh_;
};

TEST_F(FittedProgram, OneCommandCoversAMeshAndWritesThePage) {
  const std::string out = (folder_ / "report").string();
  const Outcome outcome = run("fitted " + mesh_ +
                              " --unit m --over 20% 6% --tries 1 --poses 20 --repetitions 1 "
                              "--backend native exact bullet_gjk --out " +
                              out);
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const std::string page = read(folder_ / "report/fitted.md");
  for (const char* text : {"# Cost against total error", "## angle.obj", "| native | ", "| exact | ",
                           "| bullet_gjk | ", "the cheapest", "fitted_1.svg", "20 poses"})
    EXPECT_THAT(page, HasSubstr(text));
  EXPECT_THAT(read(folder_ / "report/fitted_1.svg"), HasSubstr("total error [m]"));
  EXPECT_THAT(outcome.out, HasSubstr("angle.obj: "));
}

// Nothing but the error asked for is known of the range then: it is wide enough by itself.
TEST_F(FittedProgram, OneCoverIsEnough) {
  const std::string out = (folder_ / "report").string();
  const Outcome outcome =
      run("fitted " + mesh_ +
          " --unit m --over 6% --tries 1 --poses 20 --repetitions 1 --backend native --out " + out);
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("at 20 poses within "));
}

TEST_F(FittedProgram, ARangeThatNoPoseIsWithinIsRefusedBeforeTheFit) {
  const Outcome outcome =
      run("fitted " + mesh_ + " --unit m --over 20% 6% --range 5% --backend native --out " +
          (folder_ / "report").string());
  EXPECT_NE(outcome.code, 0);
  EXPECT_THAT(outcome.err, HasSubstr("--range: is '5%', and the finest cover's error may be 0.18 m"));
}

TEST_F(FittedProgram, AMeshThatFailsDoesNotLoseTheOthers) {
  write("flat.obj", "v 1 1 1\nv 1 1 1\nv 1 1 1\nf 1 2 3\n");
  const std::string out = (folder_ / "report").string();
  const Outcome outcome = run("fitted " + (folder_ / "flat.obj").string() + " " + mesh_ +
                              " --unit m --over 20% 6% --tries 1 --poses 20 --repetitions 1 --backend native "
                              "--out " +
                              out);
  EXPECT_EQ(outcome.code, 1) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("not measured: flat.obj: "));
  EXPECT_THAT(outcome.out, HasSubstr("page and plots: "));
  const std::string page = read(folder_ / "report/fitted.md");
  EXPECT_THAT(page, HasSubstr("Not measured: flat.obj: "));
  EXPECT_THAT(page, HasSubstr("## angle.obj"));
}

TEST_F(FittedProgram, WithoutTimesThereIsNoPlotAndNoCheapest) {
  const std::string out = (folder_ / "report").string();
  const Outcome outcome = run("fitted " + mesh_ +
                              " --unit m --over 20% 6% --tries 1 --poses 20 --repetitions 0 --backend native "
                              "--out " +
                              out);
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_FALSE(std::filesystem::exists(folder_ / "report/fitted_1.svg"));
  const std::string page = read(folder_ / "report/fitted.md");
  EXPECT_THAT(page, HasSubstr("| native | "));
  EXPECT_THAT(page, ::testing::Not(HasSubstr("fitted_1.svg")));
  EXPECT_THAT(page, ::testing::Not(HasSubstr("the cheapest")));
}

TEST_F(FittedProgram, WhatItCannotUseIsNamed) {
  EXPECT_THAT(run("fitted " + mesh_ + " --unit m --backend nobody").err, HasSubstr("nobody"));
  EXPECT_THAT(run("fitted " + mesh_).err, HasSubstr("unit"));
  EXPECT_THAT(run("fitted " + mesh_ + " " + mesh_ + " --unit m --covers c.json").err,
              HasSubstr("--covers: are of one mesh"));
}

}  // namespace
}  // namespace touchstone::comparison
