#include <array>
#include <cstdint>
#include <filesystem>
#include <fstream>

#ifdef TOUCHSTONE_HAS_SCENE_FILES
#include "touchstone/adapters/scene_files/scene_file.hpp"
#endif
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/examples/fit/cover_scene.hpp"
#include "touchstone/examples/fit/fit_run.hpp"
#include "touchstone/examples/fit/mesh_input.hpp"
#include "touchstone/examples/fit/samples.hpp"
#include "touchstone/tests/fit/meshes.hpp"
#include "touchstone/tests/support/program_test.hpp"
#include "touchstone/tests/support/refusal.hpp"

namespace touchstone::fitting {
namespace {

using testing::HasSubstr;

TEST(FitProgram, ReadsLengthsUnitsAndRegions) {
  EXPECT_DOUBLE_EQ(parse_length("2mm", "--over").metres(10.0), 2e-3);
  EXPECT_DOUBLE_EQ(parse_length("0.9 mm", "--over").metres(10.0), 9e-4);
  EXPECT_DOUBLE_EQ(parse_length("2%", "--over").metres(10.0), 0.2);
  EXPECT_DOUBLE_EQ(parse_unit("in"), 0.0254);
  EXPECT_DOUBLE_EQ(parse_unit("0.1"), 0.1);
  for (const char* bad : {"", "2", "mm", "-2mm", "nanmm", "2 furlongs", "0%"})
    EXPECT_THAT(refusal_of([&] { parse_length(bad, "--over"); }), HasSubstr("--over: '")) << bad;
  EXPECT_THAT(refusal_of([] { parse_unit("inch?"); }), HasSubstr("--unit: 'inch?'"));
  const RegionRequest region = parse_region("port=0.9mm:1,2,3:-1,5,3.5");
  EXPECT_EQ(region.name, "port");
  EXPECT_EQ(region.low, Vector3(-1, 2, 3));
  EXPECT_EQ(region.high, Vector3(1, 5, 3.5));
  for (const char* bad : {"port", "port=1mm", "port=1mm:1,2,3", "=1mm:1,2,3:1,2,3", "port=1mm:1,2:1,2,3"})
    EXPECT_THAT(refusal_of([&] { parse_region(bad); }), HasSubstr("--region: '")) << bad;
}

std::vector<std::array<Vector3, 8>> vertices_of(const HexahedronTree& tree) {
  std::vector<std::array<Vector3, 8>> all;
  for (const PlacedHexahedron& each : tree.solids()) {
    all.push_back(each.solid.vertices());
    for (Vector3& v : all.back()) v = transform(each.X_OS, v);
  }
  return all;
}

class FittedFile : public testing::Test {
 protected:
  FittedFile() {
    std::filesystem::create_directories(folder_);
    std::ofstream file(path_);
    file << "solid angle\n";
    const TriangleMesh mesh = test::angle_mesh();
    for (const auto& t : mesh.triangles) {
      file << "facet normal 0 0 0\nouter loop\n";
      for (const std::uint32_t i : t)
        file << "vertex " << mesh.vertices[i].x() << " " << mesh.vertices[i].y() << " "
             << mesh.vertices[i].z() << "\n";
      file << "endloop\nendfacet\n";
    }
    file << "endsolid\n";
  }
  ~FittedFile() override { std::filesystem::remove_all(folder_); }

  FitRun run() {
    FitRequest request;
    request.over = {0.06, true};
    request.input.metres_per_unit = 1e-3;
    request.repairs = 2;
    request.samples = 20000;
    program::ProgressLine progress;
    return run_fit(path_, request, progress);
  }

  // Of this test: others may run beside it.
  std::filesystem::path folder_ =
      std::filesystem::path(testing::TempDir()) /
      (std::string("touchstone_fit_") + testing::UnitTest::GetInstance()->current_test_info()->name());
  std::filesystem::path path_ = folder_ / "fitted_angle.stl";
};

TEST_F(FittedFile, IsCoveredProvenAndReadBackToTheSameBits) {
  const FitRun done = run();
  EXPECT_EQ(done.fit.hexahedra.size(), 2U);
  EXPECT_TRUE(done.verdict.is_proven) << done.verdict.reason;
  EXPECT_EQ(done.uncovered, 0U);
  EXPECT_GE(done.samples, 20000U);
  const std::filesystem::path written = folder_ / "angle.certificate.json";
  std::ofstream(written) << certificate_text(done.certificate);
  const Certificate read = read_certificate(written);
  EXPECT_EQ(read.claim.hexahedra, done.certificate.claim.hexahedra);
  EXPECT_EQ(read.claim.excess, done.certificate.claim.excess);
  EXPECT_TRUE(check_certificate(read, path_).is_proven);

  std::ofstream(path_, std::ios::app) << "\n";  // another file
  EXPECT_THAT(check_certificate(read, path_).reason, HasSubstr("is of another file"));
  std::ofstream(written) << "{\"format\": \"touchstone cover certificate 1\"}";
  EXPECT_THAT(refusal_of([&] { read_certificate(written); }), HasSubstr("no certificate"));
}

TEST_F(FittedFile, SamplesFindAMissingHexahedron) {
  FitRun done = run();
  done.fit.hexahedra.pop_back();
  const MeshDistance solid(weld(test::angle_mesh()));
  FitRun scaled = done;
  for (FittedHexahedron& each : scaled.fit.hexahedra)
    for (Vector3& p : each.vertices) p *= 1e3;
  EXPECT_GT(count_uncovered(solid, scaled.fit, 20000).uncovered, 1000U);
}

TEST_F(FittedFile, WithoutSizeOrMissingIsNamedOnce) {
  {
    std::ofstream file(path_);
    file << "solid x\nfacet\nouter loop\nvertex 1 1 1\nvertex 1 1 1\nvertex 1 1 "
            "1\nendloop\nendfacet\nendsolid x\n";
  }
  EXPECT_EQ(refusal_of([&] { run(); }), path_.string() + ": none of its triangles has an area");
  std::filesystem::remove(path_);
  EXPECT_EQ(refusal_of([&] { run(); }), path_.string() + ": there is no such file");
}

class FitProgramRun : public ProgramTest {
 protected:
  FitProgramRun() : ProgramTest(TOUCHSTONE_FIT) {
    std::ofstream file(folder_ / "part.stl");
    file << "solid one\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n"
            "endloop\nendfacet\nendsolid\n";
  }
  std::string part() const { return (folder_ / "part.stl").string(); }
};

TEST_F(FitProgramRun, OptionsThatWouldBeIgnoredAreRefused) {
  // Each slip, and what names it.
  const std::pair<const char*, const char*> slips[] = {
      {"--unit mm --over 2mm --count -1", "--count"},
      {"--unit mm --over 2mm --count 0", "--count"},
      {"--unit mm --over 2mm --samples -5", "--samples"},
      {"--unit mm --over 2mm --tolerance 1mm", "--tolerance requires --serves"},
      {"--unit mm --over 2mm --uniform", "--uniform requires --serves"},
      {"--unit mm --over 2mm --keep-open 3mm", "--keep-open: is '3mm', more than --over"},
      {"--unit mm --unit in --over 2mm", "--unit: 'in' comes after another"},
      {"--unit part=mm --unit part=in --over 2mm", "--unit: 'part=in' comes after another"},
      {"--unit mm --over 2mm --levels 2mm,20mm", "--levels: the first is 0.002 m, which is not more than"},
      {"--unit mm --over 20% --levels 0.1mm", "--levels: the first is 0.0001 m"},
      {"--unit mm --serves s.yaml --tolerance 1mm --over 2mm", "--over excludes --serves"},
      {"--unit mm --serves s.yaml --tolerance 1mm --levels 2mm", "--levels excludes --serves"},
      {"--unit mm --serves s.yaml --tolerance 1mm --samples 9", "--samples excludes --serves"},
      {"--unit mm --serves s.yaml --tolerance 1mm --training", "--training excludes --serves"},
      {"--unit mm --serves s.yaml --tolerance 1mm --page", "--serves excludes --page"},
      {"--check part.certificate --over 2mm", "--over excludes --check"},
  };
  // Nothing is written.
  for (const auto& [arguments, error] : slips) {
    const Outcome outcome = run(part() + " --output " + (folder_ / "fit").string() + " " + arguments);
    EXPECT_NE(outcome.code, 0) << arguments;
    EXPECT_THAT(outcome.err, HasSubstr(error)) << arguments;
    EXPECT_FALSE(std::filesystem::exists(folder_ / "fit")) << arguments;
  }
}

#ifdef TOUCHSTONE_HAS_SCENE_FILES
// Both would become one scene: reported before the search, which may take long.
TEST_F(FitProgramRun, ASceneIsServedByOneMeshAnObject) {
  const std::string scene =
      write("s.yaml",
            "name: s\nframe_rate: 50\ncontact_gap: 1.0e-6\npolicy: advance\nduration: 1\nobjects:\n"
            "  - name: part\n    static: true\n    hexahedra: [{name: a, box: {size: [1, 1, 1]}}]\n"
            "  - name: cube\n    pose: {position: [3, 0, 0]}\n"
            "    hexahedra: [{name: c, box: {size: [1, 1, 1]}}]\n"
            "    motion: {segments: [{velocity: [-0.5, 0, 0]}]}\n")
          .string();
  write("part.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  const Outcome outcome = run(folder_.string() + " --unit m --serves " + scene +
                              " --tolerance 10mm --output " + (folder_ / "fit").string());
  EXPECT_NE(outcome.code, 0);
  EXPECT_THAT(outcome.err, HasSubstr("would both become part.yaml"));
  EXPECT_EQ(outcome.out, "");  // nothing was fitted
}
#endif

TEST(FitProgram, NamesThatAreNoUtf8AreReplaced) {
  EXPECT_EQ(cover_name("d/part.one.stl"), "part.one");
  const std::string name = cover_name("p\xff.stl");
  EXPECT_EQ(name, "p\xef\xbf\xbd");
  Certificate certificate;
  certificate.mesh_file = "p\xff.stl";
  EXPECT_THAT(certificate_text(certificate), HasSubstr(name + ".stl"));
  EXPECT_THAT(scene_text({}, "p\xff", "\xff"), HasSubstr("\"" + name + "\""));
}

TEST(FitProgram, MeshesWithOneNameAreRejectedUpFront) {
  EXPECT_EQ(refusal_of([] { check_names({"d/a.stl", "d/b.stl"}); }), "accepted");
  EXPECT_THAT(refusal_of([] {
                check_names({"d/a.STL", "d/a.stl"});
              }),
              HasSubstr("a.STL and a.stl would both become a.yaml"));
}

TEST(FitProgram, ACheckSaysWhatIsClaimed) {
  Certificate certificate;
  certificate.scale = 1e-3;
  certificate.claim.excess = 0.25;
  certificate.claim.regions.push_back({"port", {0, 0, 0}, {1, 2, 3}, 0.125});
  EXPECT_THAT(claims_text(certificate), HasSubstr("error at most 0.25 m"));
  EXPECT_THAT(claims_text(certificate), HasSubstr("a unit of the file is 0.001 m"));
  EXPECT_THAT(claims_text(certificate), HasSubstr("'port', (0, 0, 0) to (1, 2, 3) m: error at most 0.125 m"));
}

TEST_F(FittedFile, AnEarlierFitIntoTheSameFolderStays) {
  const std::filesystem::path output = folder_ / "out";
  const std::vector<program::ReportFile> first{{"a.yaml", "a"}, {"fit.csv", "1"}};
  const std::vector<program::ReportFile> second{{"b.yaml", "b"}, {"fit.csv", "2"}};
  for (const auto& files : {first, second, first})
    EXPECT_EQ(program::place_report(output, files, true, true), output);
  EXPECT_TRUE(std::filesystem::exists(output / "a.yaml"));
  EXPECT_TRUE(std::filesystem::exists(output / "b.yaml"));
  program::place_report(output, first, true);  // as other reports do: all of them are still known
  EXPECT_FALSE(std::filesystem::exists(output / "b.yaml"));
}

TEST_F(FittedFile, LevelsAreProvenAndWritten) {
  FitRequest request;
  request.over = {0.06, true};
  request.levels = {{0.2, true}, {1.0, true}};
  request.input.metres_per_unit = 1e-3;
  request.repairs = 2;
  program::ProgressLine progress;
  const FitRun done = run_fit(path_, request, progress);
  EXPECT_TRUE(done.verdict.is_proven) << done.verdict.reason;
  ASSERT_EQ(done.levels.size(), 2U);
  EXPECT_EQ(done.levels[1].tree->solids().size(), 1U);
  EXPECT_LE(done.levels[1].excess, done.diagonal);
  std::vector<std::string> names;
  for (const auto& [name, text] : cover_files(done)) {
    names.push_back(name);
    std::ofstream(folder_ / name) << text;
  }
  for (const std::string& extension : cover_extensions(request))
    EXPECT_THAT(names, testing::Contains("fitted_angle" + extension));
  for (const Certificate& certificate : done.level_certificates)
    EXPECT_TRUE(check_certificate(certificate, path_).is_proven);
#ifdef TOUCHSTONE_HAS_SCENE_FILES
  // Read back, scene and levels have the same bits.
  const Scene scene = load_scene(folder_ / "fitted_angle.yaml");
  ASSERT_EQ(scene.objects.size(), 1U);
  ASSERT_EQ(scene.objects[0].levels.size(), 2U);
  for (std::size_t level = 0; level < 2; ++level)
    EXPECT_EQ(vertices_of(*scene.objects[0].levels[level]), vertices_of(*done.levels[level].tree));
  EXPECT_EQ(vertices_of(scene.objects[0].tree), vertices_of(make_tree(done.fit, "fitted_angle")));
#endif
  // A level with a tight vertex moved inward is none.
  Certificate moved = done.level_certificates[1];
  Vector3 centre = Vector3::Zero();
  for (const Vector3& p : moved.claim.hexahedra[0]) centre += 0.125 * p;
  for (Vector3& p : moved.claim.hexahedra[0]) p += 1e-6 * (centre - p);
  EXPECT_FALSE(check_certificate(moved, path_).is_proven);
  EXPECT_THAT(refusal_of([&] {
                request.levels = {{0.2, true}, {0.2, true}};
                run_fit(path_, request, progress);
              }),
              HasSubstr("levels: error"));
}

TEST_F(FittedFile, TablesHaveALineAMesh) {
  const std::vector<FitRun> runs{run()};
  EXPECT_THAT(table_text(runs), HasSubstr("fitted_angle"));
  EXPECT_THAT(table_text(runs), HasSubstr("proven"));
  EXPECT_THAT(table_csv(runs), HasSubstr("\nfitted_angle,20,1,1,0,"));
  EXPECT_THAT(scene_text(runs[0].fit, "angle", "d"), HasSubstr("      - name: h1\n"));
}

std::string facet(const Vector3& a, const Vector3& b, const Vector3& c) {
  std::string text = "facet normal 0 0 0\nouter loop\n";
  for (const Vector3& p : {a, b, c})
    text += "vertex " + figure(p.x()) + " " + figure(p.y()) + " " + figure(p.z()) + "\n";
  return text + "endloop\nendfacet\n";
}

std::string facets(const TriangleMesh& mesh) {
  std::string text;
  for (const auto& t : mesh.triangles)
    text += facet(mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]);
  return text;
}

/// A block of 2 x 1 x 3 of the file's units, standing along y.
class OtherFormats : public FolderTest {
 protected:
  std::string obj() const {
    std::string text;
    for (int i = 0; i < 8; ++i)
      text += "v " + std::to_string((i & 4) != 0 ? 2 : 0) + " " + std::to_string((i & 2) != 0 ? 1 : 0) + " " +
              std::to_string((i & 1) != 0 ? 3 : 0) + "\n";
    return text + "f 1 2 4 3\nf 5 7 8 6\nf 1 5 6 2\nf 3 4 8 7\nf 1 3 7 5\nf 2 6 8 4\n";
  }
  FitRun fit(const std::filesystem::path& file, const MeshInput& input) const {
    FitRequest request;
    request.over = {0.05, true};
    request.input = input;
    request.repairs = 1;
    program::ProgressLine progress;
    return run_fit(file, request, progress);
  }
};

TEST_F(OtherFormats, AnObjIsFittedInItsUnitAndProvenAnew) {
  const std::filesystem::path file = write("block.OBJ", obj());
  const FitRun run = fit(file, {0.001});
  EXPECT_TRUE(run.verdict.is_proven) << run.verdict.reason;
  EXPECT_EQ(run.fit.hexahedra.size(), 1U);
  EXPECT_NEAR(run.diagonal, 1e-3 * std::sqrt(14.0), 1e-15);
  const std::filesystem::path certificate = write("certificate.json", certificate_text(run.certificate));
  EXPECT_TRUE(check_certificate(read_certificate(certificate), file).is_proven);
}

TEST_F(OtherFormats, TheAxisThatPointsUpIsStatedAndKept) {
  const std::filesystem::path file = write("block.obj", obj());
  const FitRun run = fit(file, {1.0, UpAxis::y});
  double low = 1e9, high = -1e9;
  for (const Vector3& v : run.mesh.vertices) low = std::min(low, v.z()), high = std::max(high, v.z());
  EXPECT_EQ(high - low, 1.0);  // the file's y
  const std::filesystem::path certificate = write("certificate.json", certificate_text(run.certificate));
  EXPECT_EQ(read_certificate(certificate).up, UpAxis::y);
  EXPECT_TRUE(check_certificate(read_certificate(certificate), file).is_proven);
}

// A fan without an area hangs on the block's edge: with it the shell is open, and would be covered as a
// sheet.
TEST_F(OtherFormats, TrianglesWithoutAnAreaLeaveNoSolidOpen) {
  const std::string solid = facets(test::box_mesh({0, 0, 0}, {2, 1, 3}));
  std::string fan;
  for (int i = 1; i < 4; ++i) fan += facet({0, 0, 3}, {0.5 * i, 0, 3}, {0.5 * i + 0.25, 0, 3});
  const FitRun run = fit(write("block.stl", "solid a\n" + solid + fan + "endsolid a\n"), {1.0});
  EXPECT_EQ(run.open_edges, 0U);
  EXPECT_EQ(run.fit.hexahedra.size(), 1U);
  EXPECT_THAT(run.note, HasSubstr("3 without an area left out, the first at triangle 12"));
  EXPECT_THAT(refusal_of([&] { fit(write("fan.stl", "solid a\n" + fan + "endsolid a\n"), {1.0}); }),
              HasSubstr("fan.stl: none of its triangles has an area"));
}

// A triangle that faces inwards would make a sheet of the shell, hollow inside.
TEST_F(OtherFormats, ATurnedTriangleLeavesTheSolidWhole) {
  TriangleMesh block = test::box_mesh({0, 0, 0}, {2, 1, 3});
  std::swap(block.triangles[5][1], block.triangles[5][2]);
  const std::filesystem::path file = write("block.stl", "solid a\n" + facets(block) + "endsolid a\n");
  const FitRun run = fit(file, {1.0});
  EXPECT_EQ(run.closed_shells, 1U);
  EXPECT_EQ(run.fit.hexahedra.size(), 1U);
  EXPECT_THAT(run.note, HasSubstr("1 turned so that the surface faces one way, the first at triangle 5"));
  const std::filesystem::path certificate = write("certificate.json", certificate_text(run.certificate));
  EXPECT_TRUE(check_certificate(read_certificate(certificate), file).is_proven);
  EXPECT_THAT(
      refusal_of([&] { fit(write("lfs.stl", "version https://git-lfs.github.com/spec/v1\n"), {1.0}); }),
      HasSubstr("lfs.stl: is a pointer of Git LFS"));
}

// Beside one with a seam that only a triangle without an area closes: each counts as a solid.
TEST_F(OtherFormats, ATurnedTriangleOpensNoOtherSolid) {
  TriangleMesh turned = test::box_mesh({8, 0, 0}, {10, 1, 3});
  std::swap(turned.triangles[5][1], turned.triangles[5][2]);
  // The long edge of one triangle is met by two short ones of its neighbour, which is cut in two.
  TriangleMesh seamed = test::box_mesh({0, 0, 0}, {2, 1, 3});
  const auto [a, b, c] = seamed.triangles[0];
  const auto middle = static_cast<std::uint32_t>(seamed.vertices.size());
  seamed.vertices.push_back(0.5 * (seamed.vertices[a] + seamed.vertices[b]));
  seamed.triangles[0] = {a, middle, c};
  seamed.triangles.push_back({middle, b, c});
  seamed.triangles.push_back({a, b, middle});  // without an area
  const FitRun run =
      fit(write("two.stl", "solid a\n" + facets(seamed) + facets(turned) + "endsolid a\n"), {1.0});
  EXPECT_EQ(run.open_edges, 0U);
  EXPECT_EQ(run.closed_shells, 2U);
  EXPECT_EQ(run.fit.hexahedra.size(), 2U);
  EXPECT_THAT(run.note, HasSubstr("1 turned so that the surface faces one way, the first at triangle 19"));
}

// Half of whose triangles face in: it is no cavity, and costs nothing.
TEST_F(OtherFormats, ATurnedHalfOfAnInnerSolidMakesNoCavity) {
  TriangleMesh inner = test::box_mesh({1, 1, 1}, {2, 2, 2});
  for (std::size_t t = 0; t < 6; ++t) std::swap(inner.triangles[t][1], inner.triangles[t][2]);
  const std::string outer = facets(test::box_mesh({0, 0, 0}, {3, 3, 3}));
  const FitRun run = fit(write("nested.stl", "solid a\n" + outer + facets(inner) + "endsolid a\n"), {1.0});
  EXPECT_EQ(run.fit.hexahedra.size(), 1U);
  EXPECT_THAT(run.note, HasSubstr("face opposite ways"));
}

// Meshes that are refused for so many shells are taken as sheets where they are STL.
TEST_F(OtherFormats, AnStlFileHasAnyNumberOfShells) {
  constexpr std::uint32_t kTriangles = 100'001;
  std::string bytes(80, '\0');
  const auto put = [&](const auto& value) {
    bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
  };
  put(kTriangles);
  for (std::uint32_t i = 0; i < kTriangles; ++i) {
    const float x = 2.0F * static_cast<float>(i);
    put(std::array<float, 12>{0, 0, 0, x, 0, 0, x + 1.0F, 0, 0, x, 1, 0});
    put(std::uint16_t{0});
  }
  const ReadMesh read = read_mesh(write("sheets.stl", bytes), {1.0});
  EXPECT_EQ(read.mesh.triangles.size(), kTriangles);
  EXPECT_THAT(read.note, HasSubstr("100001 triangles, 100001 shells"));
}

TEST_F(OtherFormats, UnitsAreAskedForAndWrongOnesRefused) {
  const std::filesystem::path file = write("block.obj", obj());
  EXPECT_THAT(refusal_of([&] { fit(file, {}); }),
              HasSubstr("--unit: is missing: block.obj does not say its unit"));
  EXPECT_THAT(refusal_of([&] { fit(file, {1.0, UpAxis::as_written, 0.004}); }), HasSubstr("block.obj: "));
  EXPECT_THAT(refusal_of([&] { fit(file, {1.0, UpAxis::stated}); }), HasSubstr("block.obj: "));
  EXPECT_THAT(refusal_of([&] { fit(write("block.step", "x"), {1.0}); }),
              HasSubstr("a mesh is read from .stl, .obj, .ply or .dae"));
  EXPECT_THAT(refusal_of([] { parse_up("up"); }), HasSubstr("--up: 'up' is none of"));
}

}  // namespace
}  // namespace touchstone::fitting
