#include "touchstone/contact_core/fit/triangle_mesh.hpp"

#include <bit>
#include <limits>

#include "touchstone/contact_core/fit/stl_file.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/tests/support/refusal.hpp"

namespace touchstone {
namespace {

using testing::HasSubstr;

const std::array<std::array<std::array<int, 3>, 3>, 4> kTetrahedron = {{{{{0, 0, 0}, {0, 1, 0}, {1, 0, 0}}},
                                                                        {{{0, 0, 0}, {0, 0, 1}, {0, 1, 0}}},
                                                                        {{{0, 0, 0}, {1, 0, 0}, {0, 0, 1}}},
                                                                        {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}}};

void append(std::string& bytes, std::uint32_t word) {
  for (int i = 0; i < 4; ++i) bytes.push_back(static_cast<char>(word >> (8 * i)));
}

std::string binary_stl(int triangles, float extra = 0.0F) {
  std::string bytes = "solid" + std::string(75, ' ');  // as some writers begin their binary files
  append(bytes, static_cast<std::uint32_t>(triangles));
  for (int t = 0; t < triangles; ++t) {
    bytes += std::string(12, '\0');
    for (const auto& corner : kTetrahedron[t])
      for (const int value : corner)
        append(bytes, std::bit_cast<std::uint32_t>(static_cast<float>(value) + extra));
    bytes += std::string(2, '\0');
  }
  return bytes;
}

std::string ascii_stl() {
  std::string text = "solid part\n";
  for (const auto& triangle : kTetrahedron) {
    text += "facet normal 0 0 0\nouter loop\n";
    for (const auto& p : triangle)
      text += "vertex " + std::to_string(p[0]) + " " + std::to_string(p[1]) + " +" + std::to_string(p[2]) +
              "e0\n";
    text += "endloop\nendfacet\n";
  }
  return text + "endsolid part\n";
}

std::string error_of(const std::string& bytes, double scale = 1.0) {
  return refusal_of([&] { parse_stl(bytes, scale, "part.stl"); });
}

TEST(StlFile, BothFormsGiveTheSameScaledTriangles) {
  const TriangleMesh binary = parse_stl(binary_stl(4), 1e-3, "b"), ascii = parse_stl(ascii_stl(), 1e-3, "a");
  ASSERT_EQ(binary.triangles.size(), 4U);
  EXPECT_EQ(binary.triangles, ascii.triangles);
  for (std::size_t i = 0; i < binary.vertices.size(); ++i) EXPECT_EQ(binary.vertices[i], ascii.vertices[i]);
  EXPECT_EQ(binary.vertices[9], Vector3(1e-3, 0, 0));
}

TEST(StlFile, OnlyWholeBinaryFilesSayHowManyTrianglesTheyHave) {
  EXPECT_EQ(binary_stl_triangles(binary_stl(4)), 4U);
  EXPECT_EQ(binary_stl_triangles(binary_stl(0)), 0U);
  EXPECT_FALSE(binary_stl_triangles(binary_stl(4).substr(1)));
  EXPECT_FALSE(binary_stl_triangles(ascii_stl()));
}

TEST(StlFile, BadFilesEndInOneLineWithTheTriangle) {
  EXPECT_EQ(error_of(""), "part.stl: empty file");
  EXPECT_EQ(error_of("abc"), "part.stl: no STL file: 3 bytes");
  EXPECT_THAT(error_of(std::string(200, 'a')), HasSubstr("no STL file: text"));
  EXPECT_THAT(error_of(binary_stl(4).substr(0, 200)), HasSubstr("cut off in triangle 2"));
  EXPECT_THAT(error_of(binary_stl(4) + "x"), HasSubstr("bytes after the last triangle"));
  EXPECT_THAT(error_of(binary_stl(2, std::numeric_limits<float>::quiet_NaN())),
              HasSubstr("triangle 0: coordinate nan"));
  EXPECT_THAT(error_of(binary_stl(0)), HasSubstr("no triangle"));
  EXPECT_THAT(error_of(binary_stl(4), 0.0), HasSubstr("scale 0"));
  EXPECT_THAT(error_of("solid x\nfacet\nvertex 1 2 z\n"), HasSubstr("part.stl:3: 'z' is no number"));
  EXPECT_THAT(error_of("solid x\nfacet\nvertex 1 2 3\nendloop"),
              HasSubstr("part.stl:4: a facet of 1 corners"));
  EXPECT_THAT(error_of("solid x\nfacet\nvertex 1 2"), HasSubstr("part.stl:3: the file ends in a triangle"));
}

TEST(StlFile, AnAsciiFileCutOffBetweenFacetsIsNoPart) {
  const std::string whole = ascii_stl();
  for (const char* last : {"endsolid", "endfacet\nend"})
    EXPECT_THAT(error_of(whole.substr(0, whole.rfind(last))), HasSubstr("the file ends in a solid")) << last;
  EXPECT_THAT(error_of(whole + "solid more\n"), HasSubstr("the file ends in a solid"));
  EXPECT_EQ(error_of(whole + "solid more\nendsolid more\n"), "accepted") << "several solids are one mesh";
}

TEST(StlFile, AnyNameOfASolidPasses) {
  for (const std::string name : {"vertex 1 2 endloop", "", "facet", "solid endsolid"}) {
    std::string text = ascii_stl();
    text.replace(text.find("part"), 4, name);
    text.replace(text.rfind("part"), 4, name);
    EXPECT_EQ(error_of(text), "accepted") << name;
  }
}

TEST(StlFile, ANulIsNoBlank) {
  std::string broken = ascii_stl();
  broken.insert(broken.find("vertex 0 ") + 7, 1, '\0');
  EXPECT_THAT(error_of(broken), HasSubstr("is no number"));
}

TEST(TriangleMesh, WeldsEqualPlacesAndSeesWhatIsClosed) {
  const TriangleMesh closed = weld(parse_stl(binary_stl(4), 1.0, "t"));
  EXPECT_EQ(closed.vertices.size(), 4U);
  const MeshShells shells = find_shells(closed);
  ASSERT_EQ(shells.count(), 1U);
  EXPECT_EQ(shells.is_closed[0], 1);
  EXPECT_EQ(shells.open_edges, 0U);

  const MeshShells open = find_shells(weld(parse_stl(binary_stl(3), 1.0, "t")));
  ASSERT_EQ(open.count(), 1U);
  EXPECT_EQ(open.is_closed[0], 0);
  EXPECT_EQ(open.open_edges, 3U);
}

TEST(TriangleMesh, ShellsApartAreClosedEachForItself) {
  TriangleMesh mesh = parse_stl(binary_stl(4), 1.0, "t");
  const TriangleMesh sheet = parse_stl(binary_stl(3, 10.0F), 1.0, "t");
  for (const auto& t : sheet.triangles) mesh.triangles.push_back({t[0] + 12, t[1] + 12, t[2] + 12});
  mesh.vertices.insert(mesh.vertices.end(), sheet.vertices.begin(), sheet.vertices.end());
  const MeshShells shells = find_shells(weld(mesh));
  ASSERT_EQ(shells.count(), 2U);
  EXPECT_EQ(shells.is_closed[0], 1);
  EXPECT_EQ(shells.is_closed[1], 0);
  EXPECT_EQ(shells.shell_of_triangle.back(), 1U);
}

TEST(TriangleMesh, AnIndexThatIsNoneIsNamed) {
  TriangleMesh mesh{{Vector3(0, 0, 0), Vector3(1, 0, 0)}, {{0, 1, 2}}};
  EXPECT_THROW(validate(mesh), InputError);
}

// Squares of areas are formed: fourth powers, and their products with lengths.
TEST(TriangleMesh, ACoordinateWhosePowersOverflowIsNamed) {
  TriangleMesh mesh{{Vector3(0, 0, 0), Vector3(1, 0, 0), Vector3(0, 1e70, 0)}, {{0, 1, 2}}};
  EXPECT_NO_THROW(validate(mesh));
  mesh.vertices[2].y() = 1e71;
  EXPECT_THROW(validate(mesh), InputError);
}

}  // namespace
}  // namespace touchstone
