#include "touchstone/adapters/mesh_files/mesh_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/tests/support/refusal.hpp"

namespace touchstone {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

/// A file that is gone when the test is over.
class TemporaryFile {
 public:
  TemporaryFile(const std::string& name, const std::string& bytes)
      : path_(std::filesystem::path(testing::TempDir()) /
              (std::string(testing::UnitTest::GetInstance()->current_test_info()->name()) + "." + name)) {
    std::ofstream(path_, std::ios::binary) << bytes;
  }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  ~TemporaryFile() { std::filesystem::remove(path_); }
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

MeshFileOptions metres() {
  MeshFileOptions options;
  options.metres_per_unit = 1.0;
  return options;
}

LoadedMesh load(const std::string& name, const std::string& bytes,
                const MeshFileOptions& options = metres()) {
  const TemporaryFile file(name, bytes);
  return load_mesh(file.path(), options);
}

std::string error(const std::string& name, const std::string& bytes,
                  const MeshFileOptions& options = metres()) {
  const TemporaryFile file(name, bytes);
  const std::string message = refusal_of([&] { load_mesh(file.path(), options); });
  EXPECT_THAT(message, HasSubstr(file.path().string()));
  return message;
}

void add_bytes(std::string& out, std::uint32_t bits, int count) {
  for (int i = 0; i < count; ++i) out += static_cast<char>(bits >> (8 * i) & 0xff);
}

using Triangles = std::vector<std::array<Vector3, 3>>;

std::string binary_stl(const Triangles& triangles) {
  std::string out(80, ' ');
  add_bytes(out, static_cast<std::uint32_t>(triangles.size()), 4);
  for (const auto& t : triangles) {
    out += std::string(12, '\0');
    for (const Vector3& v : t)
      for (int i = 0; i < 3; ++i) add_bytes(out, std::bit_cast<std::uint32_t>(static_cast<float>(v[i])), 4);
    add_bytes(out, 0, 2);
  }
  return out;
}

const Vector3 kO = {0, 0, 0}, kX = {1, 0, 0}, kY = {0, 1, 0}, kZ = {0, 0, 1};
const Triangles kTetrahedron = {{kO, kY, kX}, {kO, kX, kZ}, {kO, kZ, kY}, {kX, kY, kZ}};
const std::string kObj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";

std::string ply(const std::string& last_face) {
  return "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
         "element face 4\nproperty list uchar int vertex_indices\nend_header\n"
         "0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n" +
         last_face;
}

/// Vertices in double with a colour behind, a byte before each face's list, and an element that is passed by.
std::string binary_ply(bool is_big_endian) {
  std::string out = std::string("ply\nformat binary_") + (is_big_endian ? "big" : "little") +
                    "_endian 1.0\ncomment ours\nelement vertex 4\nproperty float64 x\nproperty double y\n"
                    "property double z\nproperty uchar red\nelement face 4\nproperty int8 flag\n"
                    "property list uchar uint vertex_index\nelement edge 1\nproperty int a\nend_header\n";
  const auto add = [&](std::uint64_t bits, int count) {
    for (int i = 0; i < count; ++i)
      out += static_cast<char>(bits >> (8 * (is_big_endian ? count - 1 - i : i)) & 0xff);
  };
  for (const Vector3& v : {kO, kX, kY, kZ}) {
    for (int i = 0; i < 3; ++i) add(std::bit_cast<std::uint64_t>(v[i]), 8);
    add(200, 1);
  }
  for (const std::array<unsigned, 3>& face :
       std::vector<std::array<unsigned, 3>>{{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}) {
    add(0xff, 1);
    add(3, 1);
    for (const unsigned i : face) add(i, 4);
  }
  add(7, 4);
  return out;
}

std::string dae(const std::string& asset, const std::string& third_vertex = "0 2 0") {
  return R"(<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset>)" +
         asset + R"(</asset><library_geometries><geometry id="g"><mesh><source id="p">
<float_array id="pa" count="12">0 0 0 1 0 0 )" +
         third_vertex + R"( 0 0 3</float_array><technique_common>
<accessor source="#pa" count="4" stride="3"><param name="X" type="float"/><param name="Y" type="float"/>
<param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="4"><input semantic="VERTEX" source="#v" offset="0"/><p>0 2 1 0 1 3 0 3 2 1 2 3</p></triangles>
</mesh></geometry></library_geometries><library_visual_scenes><visual_scene id="s"><node id="n">
<matrix>1 0 0 10 0 1 0 0 0 0 1 0 0 0 0 1</matrix><instance_geometry url="#g"/></node></visual_scene>
</library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>)";
}

TEST(MeshFile, EveryFormatGivesTheSameSolid) {
  const std::vector<LoadedMesh> meshes = {load("a.stl", binary_stl(kTetrahedron)), load("A.OBJ", kObj),
                                          load("a.ply", ply("3 1 2 3\n")), load("b.ply", binary_ply(false)),
                                          load("c.ply", binary_ply(true))};
  for (const LoadedMesh& loaded : meshes) {
    EXPECT_EQ(loaded.mesh.vertices.size(), 4u);
    EXPECT_EQ(loaded.mesh.triangles.size(), 4u);
    EXPECT_TRUE(loaded.report.bounds_a_solid());
    EXPECT_EQ(loaded.report.volume, 1.0 / 6.0);
    EXPECT_EQ(loaded.report.shells, 1u);
    EXPECT_EQ(loaded.report.high, Vector3(1, 1, 1));
  }
  EXPECT_EQ(meshes[0].report.vertices_welded, 8u);
  EXPECT_EQ(meshes[1].report.vertices_welded, 0u);
}

TEST(MeshFile, UnitsAreStatedOrAskedFor) {
  EXPECT_THAT(error("a.stl", binary_stl(kTetrahedron), {}), HasSubstr("states no unit of length"));
  MeshFileOptions options;
  options.metres_per_unit = 0.001;
  EXPECT_EQ(load("a.obj", kObj, options).report.high, Vector3(0.001, 0.001, 0.001));
  options.metres_per_unit = -1.0;
  EXPECT_THAT(error("a.obj", kObj, options), HasSubstr("the unit is no length"));
  if (!reads_dae()) return;
  // DAE says: millimetres count, whatever the caller has for other files.
  const LoadedMesh loaded = load("a.dae", dae(R"(<unit name="millimeter" meter="0.001"/>)"));
  EXPECT_LE(norm(loaded.report.high - Vector3(0.011, 0.002, 0.003)), loaded.report.rounding);
  EXPECT_GT(loaded.report.rounding, 0.0);
  EXPECT_LT(loaded.report.rounding, 1e-7);
  EXPECT_THAT(error("a.dae", dae(R"(<unit name="none" meter="0"/>)")),
              HasSubstr("a.dae: its unit, <unit meter=...>, is 0 m"));
}

TEST(MeshFile, TheUpAxisIsStatedOrTakenAsWritten) {
  const std::string long_y = "v 0 0 0\nv 1 0 0\nv 0 2 0\nv 0 0 3\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
  MeshFileOptions options = metres();
  options.up = UpAxis::y;
  EXPECT_EQ(load("a.obj", long_y, options).report.high, Vector3(3, 1, 2));
  options.up = UpAxis::x;
  EXPECT_EQ(load("a.obj", long_y, options).report.high, Vector3(2, 3, 1));
  EXPECT_TRUE(load("a.obj", long_y, options).report.bounds_a_solid());  // a turn, no mirror
  options.up = UpAxis::stated;
  EXPECT_THAT(error("a.obj", long_y, options), HasSubstr("states no up axis"));
  if (!reads_dae()) return;
  const std::string y_up = dae("<up_axis>Y_UP</up_axis>");
  EXPECT_LE(norm(load("a.dae", y_up).report.high - Vector3(11, 2, 3)), 1e-4);
  const LoadedMesh turned = load("a.dae", y_up, options);  // (x, y, z) becomes (x, -z, y)
  EXPECT_LE(norm(turned.report.low - Vector3(10, -3, 0)), 1e-4);
  EXPECT_LE(norm(turned.report.high - Vector3(11, 0, 2)), 1e-4);
  EXPECT_TRUE(turned.report.bounds_a_solid());
  const LoadedMesh z_up = load("a.dae", dae("<up_axis>Z_UP</up_axis>"), options);
  EXPECT_LE(norm(z_up.report.high - Vector3(11, 2, 3)), 1e-4);
}

TEST(MeshFile, AnUnexpectedSizeIsRefused) {
  MeshFileOptions options = metres();
  options.expected_size = 0.0017;  // the file is in millimetres, but metres were stated
  EXPECT_THAT(error("a.obj", kObj, options), HasSubstr("it is 1.73205 m across where about 0.0017 m"));
  options.expected_size = 1000.0;
  EXPECT_THAT(error("a.obj", kObj, options), HasSubstr("is the unit right?"));
  options.expected_size = 5.0;
  EXPECT_EQ(load("a.obj", kObj, options).report.shells, 1u);
}

TEST(MeshFile, WhatIsNotASolidIsNamedByTriangle) {
  const std::string vertices = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 0 0 -1\n";
  const MeshReport open = load("a.obj", vertices + "f 1 3 2\nf 1 2 4\nf 1 4 3\n").report;
  EXPECT_FALSE(open.is_closed());
  EXPECT_EQ(open.open_edges, 3u);
  EXPECT_EQ(open.first_open, 0u);
  EXPECT_THAT(to_string(open), HasSubstr("3 open edges, the first at triangle 0"));

  // The projective plane: each edge is between two triangles, and it has one side.
  const MeshReport one_sided =
      load("a.obj",
           "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 3 1 2\nv 1 2 5\nf 1 2 3\nf 1 3 4\n"
           "f 1 4 5\nf 1 5 6\nf 1 6 2\nf 2 3 5\nf 3 4 6\nf 4 5 2\nf 5 6 3\nf 6 2 4\n")
          .report;
  EXPECT_TRUE(one_sided.is_manifold());
  EXPECT_FALSE(one_sided.is_oriented());
  EXPECT_THAT(one_sided.triangles_turned, IsEmpty());
  EXPECT_THAT(to_string(one_sided), HasSubstr("face opposite ways"));

  const MeshReport crowded =
      load("a.obj", vertices + "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\nf 1 2 3\nf 1 5 2\nf 1 3 5\nf 2 5 3\n")
          .report;
  EXPECT_EQ(crowded.crowded_edges, 3u);
  EXPECT_TRUE(crowded.is_closed());
  EXPECT_FALSE(crowded.is_manifold());

  const MeshReport inside_out = load("a.obj", vertices + "f 1 2 3\nf 1 4 2\nf 1 3 4\nf 2 4 3\n").report;
  EXPECT_EQ(inside_out.volume, -1.0 / 6.0);
  EXPECT_FALSE(inside_out.bounds_a_solid());
  EXPECT_THAT(to_string(inside_out), HasSubstr("inside out"));
}

// Of a surface without a boundary; a sheet beside it, which faces both ways too, is left as it is.
TEST(MeshFile, TrianglesThatFaceTheOtherWayAreTurned) {
  const std::string vertices = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 5 0 0\nv 6 0 0\nv 5 1 0\nv 6 1 0\n";
  const std::string solid = "f 1 3 2\nf 1 2 4\nf 1 4 3\n", sheet = "f 5 6 7\nf 6 7 8\n";
  const LoadedMesh healed = load("a.obj", vertices + solid + "f 2 4 3\n");
  EXPECT_TRUE(healed.report.bounds_a_solid());
  EXPECT_EQ(healed.report.volume, 1.0 / 6.0);
  EXPECT_THAT(healed.report.triangles_turned, ElementsAre(3));
  EXPECT_EQ(healed.mesh.triangles[3], (std::array<std::uint32_t, 3>{2, 1, 3}));
  EXPECT_THAT(to_string(healed.report),
              HasSubstr("1 turned so that the surface faces one way, the first at triangle 3"));
  const MeshReport both = load("a.obj", vertices + sheet + "f 2 4 3\n" + solid).report;
  EXPECT_THAT(both.triangles_turned, ElementsAre(2));
  EXPECT_EQ(both.turned_edges, 1u);
  EXPECT_EQ(both.first_turned, 0u);
}

/// Faces of a block, its vertices from 1 + `first`, the first `inward` of which face in.
std::string block_faces(int first, int inward) {
  std::string text;
  for (std::array<int, 3> f : std::vector<std::array<int, 3>>{{1, 2, 4},
                                                              {1, 4, 3},
                                                              {5, 7, 8},
                                                              {5, 8, 6},
                                                              {1, 5, 6},
                                                              {1, 6, 2},
                                                              {3, 4, 8},
                                                              {3, 8, 7},
                                                              {1, 3, 7},
                                                              {1, 7, 5},
                                                              {2, 6, 8},
                                                              {2, 8, 4}}) {
    if (inward-- > 0) std::swap(f[1], f[2]);
    text += "f";
    for (const int i : f) text += " " + std::to_string(first + i);
    text += "\n";
  }
  return text;
}

std::string block_vertices(double low, double high) {
  std::string text;
  for (int i = 0; i < 8; ++i) {
    text += "v";
    for (const int bit : {4, 2, 1}) text += " " + std::to_string((i & bit) != 0 ? high : low);
    text += "\n";
  }
  return text;
}

// However many face in, and whichever comes first.
TEST(MeshFile, ALoneSurfaceIsTurnedOutwards) {
  for (const int inward : {1, 6, 7, 11}) {
    const MeshReport report = load("a.obj", block_vertices(0, 3) + block_faces(0, inward)).report;
    EXPECT_EQ(report.volume, 27.0) << inward;
    EXPECT_EQ(report.triangles_turned.size(), static_cast<std::size_t>(inward));
    EXPECT_TRUE(report.bounds_a_solid());
  }
  const MeshReport wholly = load("a.obj", block_vertices(0, 3) + block_faces(0, 12)).report;
  EXPECT_EQ(wholly.volume, -27.0);  // faces one way: as written
  EXPECT_THAT(to_string(wholly), HasSubstr("inside out"));
}

// It is a solid or a cavity as nearly all of its triangles say, and where they do not it stays as it is.
TEST(MeshFile, ASurfaceInAnotherIsNoCavityByHalfOfItsTriangles) {
  const auto report = [](int inward) {
    return load("a.obj",
                block_vertices(0, 3) + block_vertices(1, 2) + block_faces(0, 0) + block_faces(8, inward))
        .report;
  };
  EXPECT_EQ(report(12).volume, 26.0);
  EXPECT_EQ(report(11).volume, 26.0);
  EXPECT_THAT(report(11).triangles_turned, ElementsAre(23));
  EXPECT_EQ(report(1).volume, 28.0);
  EXPECT_THAT(report(1).triangles_turned, ElementsAre(12));
  for (const int inward : {4, 6, 8}) {
    EXPECT_THAT(report(inward).triangles_turned, IsEmpty()) << inward;
    EXPECT_THAT(to_string(report(inward)), HasSubstr("face opposite ways"));
  }
}

/// A closed cylinder from z = 0 to 2, its vertices from 1 + `first`, of 4 triangles a side, of which that at
/// `flipped` faces the other way.
std::string cylinder(int first, int sides, double radius, bool faces_in, int flipped) {
  std::string text;
  for (int k = 0; k < sides; ++k)
    for (const int z : {0, 2}) {
      const double angle = 2.0 * std::acos(-1.0) * k / sides;
      text += "v " + std::to_string(radius * std::cos(angle)) + " " +
              std::to_string(radius * std::sin(angle)) + " " + std::to_string(z) + "\n";
    }
  text += "v 0 0 0\nv 0 0 2\n";
  for (int k = 0; k < sides; ++k) {
    const int a = 2 * k, b = 2 * ((k + 1) % sides), low = 2 * sides, high = low + 1;
    for (std::array<int, 3> f : std::vector<std::array<int, 3>>{
             {a, b, b + 1}, {a, b + 1, a + 1}, {low, b, a}, {high, a + 1, b + 1}}) {
      if (faces_in != (flipped-- == 0)) std::swap(f[1], f[2]);
      text += "f";
      for (const int i : f) text += " " + std::to_string(1 + first + i);
      text += "\n";
    }
  }
  return text;
}

// A pipe: its bore is as long as it is, and reaches the mesh's box at both ends.
TEST(MeshFile, ABoreThatIsAsLongAsItsPipeIsNotFilled) {
  constexpr int kSides = 24, kNone = -1;
  const auto pipe = [](double inner, int flipped) {
    return load("a.obj", cylinder(0, kSides, 1.0, false, kNone) +
                             cylinder(2 * kSides + 2, kSides, inner, true, flipped))
        .report;
  };
  const MeshReport whole = pipe(0.8, kNone), turned = pipe(0.8, 40);
  EXPECT_TRUE(whole.triangles_turned.empty());
  EXPECT_THAT(turned.triangles_turned, ElementsAre(4 * kSides + 40));
  EXPECT_EQ(turned.volume, whole.volume);
  EXPECT_LT(turned.volume, 0.4 * 2.0 * 3.2);
}

// No other surface's box holds the solids of an assembly, wherever they stand: each is turned outwards.
TEST(MeshFile, ASolidAmidOthersIsTurnedOutwards) {
  const MeshReport report = load("a.obj", block_vertices(0, 1) + block_vertices(2, 3) + block_vertices(4, 5) +
                                              block_faces(0, 0) + block_faces(8, 6) + block_faces(16, 0))
                                .report;
  EXPECT_EQ(report.volume, 3.0);
  EXPECT_EQ(report.triangles_turned.size(), 6U);
}

TEST(MeshFile, TrianglesWithoutAnAreaAreLeftOutAndCounted) {
  // A point, a doubled corner, and three corners on a line whose differences round: decided exactly.
  const LoadedMesh loaded = load("a.obj", kObj +
                                              "v 0.1 0.1 0.1\nv 0.2 0.2 0.2\nv 0.4 0.4 0.4\n"
                                              "f 1 1 1\nf 1 2 2\nf 5 6 7\nf 1 5 6\n");
  EXPECT_EQ(loaded.report.triangles_read, 8u);
  EXPECT_EQ(loaded.mesh.triangles.size(), 4u);
  EXPECT_EQ(loaded.report.zero_area, 4u);
  EXPECT_EQ(loaded.report.first_zero_area, 4u);
  EXPECT_EQ(loaded.mesh.vertices.size(), 7u);  // what they span is still held by a cover
  EXPECT_TRUE(loaded.report.bounds_a_solid());
  // A sliver of 1e-300 is a triangle.
  EXPECT_EQ(load("a.obj", "v 0 0 0\nv 1 0 0\nv 0.5 1e-300 0\nf 1 2 3\n").report.zero_area, 0u);
  EXPECT_THAT(error("a.obj", "v 0 0 0\nv 1 1 1\nf 1 2 1\n"), HasSubstr("none of its triangles has an area"));
}

TEST(MeshFile, BadStlIsRefusedByTriangleOrLine) {
  const std::string whole = binary_stl(kTetrahedron);
  EXPECT_THAT(error("a.stl", whole.substr(0, whole.size() - 10)), HasSubstr("a.stl"));
  EXPECT_THAT(error("a.stl", ""), HasSubstr("a.stl"));
  Triangles bad = kTetrahedron;
  bad[2][1].y() = kNaN;
  EXPECT_THAT(error("a.stl", binary_stl(bad)), HasSubstr("triangle 2"));
  EXPECT_THAT(error("a.stl", "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 zero\n"),
              HasSubstr(":5"));
}

TEST(MeshFile, BadObjIsRefusedByLine) {
  EXPECT_THAT(error("a.obj", "v 0 0\n"), HasSubstr(":1: a number is missing"));
  EXPECT_THAT(error("a.obj", "v 0 0 0\nv 0 nan 0\n"), HasSubstr(":2: a coordinate is nan"));
  EXPECT_THAT(error("a.obj", "v 0 0 1e999\n"), HasSubstr(":1: '1e999' is no number"));
  EXPECT_THAT(error("a.obj", kObj + "f 1 2 5\n"), HasSubstr(":9: vertex 5 of a face, of 4 so far"));
  EXPECT_THAT(error("a.obj", kObj + "f 1 2 -5\n"), HasSubstr(":9: vertex -5"));
  EXPECT_THAT(error("a.obj", kObj + "f 1 2 0\n"), HasSubstr(":9: vertex 0"));
  EXPECT_THAT(error("a.obj", kObj + "f 1 2\n"), HasSubstr(":9: a face of 2 vertices"));
  EXPECT_THAT(error("a.obj", kObj + "f 1 2 x\n"), HasSubstr(":9: 'x' is no vertex"));
  EXPECT_THAT(error("a.obj", "v 0 0 0\n"), HasSubstr("no triangle"));
  EXPECT_THAT(error("a.obj", "v 1e300 0 0\nv 0 1e300 0\nv 0 0 1e300\nf 1 2 3\n"), HasSubstr("too large"));
}

TEST(MeshFile, ObjHasPolygonsMaterialsAndIndicesFromTheEnd) {
  const LoadedMesh cube =
      load("a.obj",
           "# a cube\nmtllib not_there.mtl\nvt 0 0\nvn 0 0 1\n"
           "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1 1.0\nv 1 0 1\nv 1 1 1\nv 0 1 1\nusemtl none\ns off\n"
           "f 4/1/1 3//1 2/1 1\nf 5 6 \\\n7 8\nf -8 -7 -3 -4\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n");
  EXPECT_EQ(cube.report.polygons_split, 6u);
  EXPECT_EQ(cube.report.volume, 1.0);
  EXPECT_TRUE(cube.report.bounds_a_solid());
}

TEST(MeshFile, BadPlyIsRefusedByElement) {
  EXPECT_THAT(error("a.ply", ply("3 1 2 4\n")), HasSubstr("face 3: vertex 4 of 4"));
  EXPECT_THAT(error("a.ply", ply("3 1 -2 3\n")), HasSubstr("face 3: vertex -2 of 4"));
  EXPECT_THAT(error("a.ply", ply("3 1 1e300 3\n")), HasSubstr("face 3: vertex 1e+300 of 4"));
  EXPECT_THAT(error("a.ply", ply("2 1 2\n")), HasSubstr("face 3: it has 2 corners"));
  EXPECT_THAT(error("a.ply", ply("3 1 ")), HasSubstr("face 3: the file ends: it is truncated"));
  EXPECT_THAT(error("a.ply", ply("3 1 2 3\n").replace(ply("").find("0 1 0"), 5, "0 nan 0")),
              HasSubstr(":12: a coordinate is nan, not finite"));
  const std::string binary = binary_ply(false);
  EXPECT_THAT(error("a.ply", binary.substr(0, binary.size() - 5)), HasSubstr("face 3: the file ends"));
  EXPECT_THAT(error("a.ply",
                    "ply\nformat binary_little_endian 1.0\nelement vertex 1000000\nproperty float x\n"
                    "property float y\nproperty float z\nend_header\n12345678901234567890"),
              HasSubstr("vertex 1: the file ends"));
  EXPECT_THAT(error("a.ply", "ply\nformat ascii 1.0\nelement vertex 1e99\nend_header\n"), HasSubstr(":3: "));
  EXPECT_THAT(error("a.ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n1\n"),
              HasSubstr("its vertices have no y"));
  EXPECT_THAT(error("a.ply", "ply\nformat ascii 1.0\n"), HasSubstr("the header has no end"));
  EXPECT_THAT(error("a.ply", "not a mesh"), HasSubstr("does not begin with 'ply'"));
}

TEST(MeshFile, WhatIsPassedByInAPlyNeedBeNoNumber) {
  std::string text = ply("3 1 2 3\n");
  text.insert(text.find("element face"), "property float nx\n");
  text.replace(text.find("0 0 0\n1 0 0\n0 1 0\n0 0 1\n"), 24, "0 0 0 nan\n1 0 0 inf\n0 1 0 x\n0 0 1 1\n");
  EXPECT_TRUE(load("a.ply", text).report.bounds_a_solid());
}

TEST(MeshFile, BadDaeIsRefused) {
  if (!reads_dae()) GTEST_SKIP() << "built without assimp";
  error("a.dae", "<COLLADA><unclosed>");
  error("a.dae", dae("").substr(0, 400));
  EXPECT_THAT(error("a.dae", dae("", "0 nan 0")), HasSubstr("not finite"));
}

TEST(MeshFile, NodesThatInstanceThemselvesAreRefusedByName) {
  if (!reads_dae()) GTEST_SKIP() << "built without assimp";
  const auto with = [](const std::string& nodes) {
    std::string text = dae("");
    text.insert(text.find("</visual_scene>"), nodes);
    return text;
  };
  EXPECT_THAT(error("a.dae", with(R"(<node id="a"><instance_node url="#b"/></node><node id="b"><node id="c">
<instance_node url="#a"/></node></node>)")),
              HasSubstr("instances itself"));
  EXPECT_THAT(error("a.dae", with(R"(<node name='own'><instance_node url="#own"/></node>)")),
              HasSubstr("node 'own' instances itself"));
  // Twice the same is no cycle, nor is one in a comment.
  EXPECT_EQ(load("a.dae",
                 with(R"(<node id="a"><instance_node url="#n"/><node id="b"><instance_node url="#n"/></node>
</node><!-- <node id="d"><instance_node url="#d"/></node> -->)"))
                .report.shells,
            1u);
}

TEST(MeshFile, FilesThatAreNoneAndLimitsAreNamed) {
  EXPECT_THAT(refusal_of([] { load_mesh("not_there.stl", metres()); }),
              HasSubstr("not_there.stl: there is no such file"));
  EXPECT_THAT(error("a.stl", "version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 9\n"),
              HasSubstr("a pointer of Git LFS"));
  EXPECT_THAT(refusal_of([] { load_mesh("not_there.dae", metres()); }), HasSubstr("there is no such file"));
  EXPECT_THAT(refusal_of([] { load_mesh(testing::TempDir() + "/a.step", metres()); }),
              HasSubstr("not '.step'"));
  MeshFileOptions few = metres();
  few.most_triangles = 3;
  EXPECT_THAT(error("a.stl", binary_stl(kTetrahedron), few), HasSubstr("more than 3 triangles"));
  Triangles not_read = kTetrahedron;
  not_read[0][0].x() = kNaN;
  EXPECT_THAT(error("a.stl", binary_stl(not_read), few), HasSubstr("more than 3 triangles"));
  EXPECT_THAT(error("a.obj", kObj, few), HasSubstr("more than 3 triangles"));
  few = metres();
  few.most_shells = 1;
  Triangles two = kTetrahedron;
  for (auto t : kTetrahedron) {
    for (Vector3& v : t) v.x() += 5.0;
    two.push_back(t);
  }
  EXPECT_THAT(error("a.stl", binary_stl(two), few), HasSubstr("2 shells, more than 1"));
  EXPECT_EQ(load("a.stl", binary_stl(two)).report.shells, 2u);
}

TEST(MeshFile, AMillionShellsEndInOneLine) {
  std::string soup(80, ' ');
  constexpr std::uint32_t kCount = 1'000'000;
  add_bytes(soup, kCount, 4);
  const std::string one = binary_stl({{kO, kX, kY}}).substr(84);
  soup.reserve(84 + one.size() * kCount);
  for (std::uint32_t i = 0; i < kCount; ++i) {
    std::string bytes = one;
    for (int corner = 0; corner < 3; ++corner) {  // moved along z
      std::string z;
      add_bytes(z, std::bit_cast<std::uint32_t>(static_cast<float>(i)), 4);
      bytes.replace(12 + 12 * corner + 8, 4, z);
    }
    soup += bytes;
  }
  EXPECT_THAT(error("a.stl", soup), HasSubstr("1000000 shells, more than 100000"));
}

TEST(MeshFile, ProgressEndsAtOne) {
  MeshFileOptions options = metres();
  double last = -1.0;
  options.progress = [&](double share) {
    EXPECT_GE(share, last);
    last = share;
  };
  load("a.obj", kObj, options);
  EXPECT_EQ(last, 1.0);
}

}  // namespace
}  // namespace touchstone
