#include "touchstone/examples/fit/fit_page.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "touchstone/tests/fit/meshes.hpp"
#include "touchstone/tests/support/page_in_browser.hpp"

namespace touchstone::fitting {
namespace {

using nlohmann::json;
using testing::HasSubstr;
using testing::IsEmpty;

/// An angle in one hexahedron less than it needs: its inner corner is the worst place.
FitRun coarse_run() {
  FitRun run;
  run.name = "angle";
  run.certificate.mesh_file = "<angle>.stl";
  run.mesh = test::angle_mesh();
  run.triangles = run.mesh.triangles.size();
  run.diagonal = 3.0;
  run.over = 1.6;
  run.verdict.is_proven = true;
  FittedHexahedron box{test::box_vertices({0, 0, 0}, {2, 2, 1}), 1.5, {2, 2, 0.5}};
  run.fit.hexahedra.push_back(box);
  run.fit.excess = box.excess;
  return run;
}

std::string page() {
  const FitRun run = coarse_run();
  const MeshDistance solid(weld(run.mesh));
  return fit_page(run, solid, excess_surface(solid, run.fit),
                  {{2.4, 2.0, 1}, {1.6, 1.5, 3}, {0.1, 0.09, 12}});
}

TEST(FitPage, TheExcessIsThatOfTheFacesPoints) {
  const FitRun run = coarse_run();
  const MeshDistance solid(weld(run.mesh));
  const ExcessSurface surface = excess_surface(solid, run.fit);
  double most = 0.0;
  for (std::size_t i = 0; i < surface.points.size(); ++i) {
    const Vector3& p = surface.points[i];
    // Outside of both legs the nearer one's inner face counts.
    const double expected = std::max(0.0, std::min(p.x(), p.y()) - 0.5);
    EXPECT_NEAR(surface.excess[i], std::abs(expected), 1e-9) << p.transpose();
    most = std::max(most, surface.excess[i]);
  }
  EXPECT_NEAR(most, 1.5, 1e-9);
  double area = 0.0;
  for (const auto& t : surface.triangles)
    area += 0.5 * norm(cross(surface.points[t[1]] - surface.points[t[0]],
                             surface.points[t[2]] - surface.points[t[0]]));
  EXPECT_NEAR(area, 16.0, 1e-9);
}

TEST(FitPage, TheModelHoldsMeshCoverAndWorstPlaces) {
  const FitRun run = coarse_run();
  const MeshDistance solid(weld(run.mesh));
  const json model = json::parse(fit_gltf(run, solid, excess_surface(solid, run.fit)));
  ASSERT_EQ(model["meshes"].size(), 3U);
  EXPECT_EQ(model["meshes"][1]["name"], "cover");
  for (const json& mesh : model["meshes"]) {
    const json& primitive = mesh["primitives"][0];
    const json& positions = model["accessors"][primitive["attributes"]["POSITION"].get<std::size_t>()];
    EXPECT_EQ(positions["type"], "VEC3");
    EXPECT_LT(primitive["material"].get<std::size_t>(), model["materials"].size());
  }
  const std::size_t colours = model["meshes"][1]["primitives"][0]["attributes"]["COLOR_0"];
  EXPECT_EQ(model["accessors"][colours]["type"], "VEC4");
  EXPECT_EQ(model["scenes"][0]["nodes"][0], 3);
  EXPECT_EQ(model["nodes"][3]["children"].size(), 3U);
}

TEST(FitPage, NamesOfFilesAreText) { EXPECT_THAT(page(), HasSubstr("<h1>Cover of &lt;angle&gt;.stl</h1>")); }

class FitPageInBrowser : public PageInBrowser {};

// `alike`: of every second pixel, what shows the cover where both are shown, as it holds the mesh.
constexpr const char* kLook = R"(
  const image = () => { const c = document.getElementById('view'); return c.getContext('2d').getImageData(0, 0, c.width, c.height); };
  const pixels = () => { const d = image().data;
    let n = 0, sum = 0; for (let i = 0; i < d.length; i += 4) if (d[i + 3]) { ++n; sum += d[i] + 3 * d[i + 1] + 7 * d[i + 2] + i % 97; }
    return [n, sum]; };
  const both = pixels(), first = image();
  document.querySelector('[value=cover]').click(); const cover = pixels(), alone = image();
  let like = 0, all = 0;
  for (let i = 0; i < alone.data.length; i += 4) {
    if (!alone.data[i + 3] || (i / 4 % alone.width + Math.floor(i / 4 / alone.width)) & 1) continue;
    ++all; like += [0, 1, 2].every(k => alone.data[i + k] === first.data[i + k]); }
  document.querySelector('[data-turn=left]').click(); const turned = pixels();
  found = { both, cover, turned, wide: document.documentElement.scrollWidth, dots: document.querySelectorAll('svg .m').length,
    rows: document.querySelectorAll('table')[0].rows.length, alike: like / all,
    error: document.querySelectorAll('td')[1].getBoundingClientRect().right };)";

TEST_F(FitPageInBrowser, ShowsTheCoverTurnsItAndAsksForNothing) {
  for (const int width : {1440, 500}) {
    const json seen = look(page(), kLook, width);
    EXPECT_THAT(seen["faults"], IsEmpty()) << seen;
    EXPECT_THAT(seen["requests"], IsEmpty()) << seen;
    const json& found = seen["found"];
    EXPECT_GT(found["both"][0], 5000);
    EXPECT_NE(found["both"], found["cover"]);
    EXPECT_NE(found["cover"], found["turned"]);
    EXPECT_GT(found["alike"], 0.99);
    EXPECT_LE(found["wide"], width);
    EXPECT_LE(found["error"], width - 20);  // without scrolling the table
    EXPECT_EQ(found["dots"], 3);
    EXPECT_EQ(found["rows"], 2);
  }
}

}  // namespace
}  // namespace touchstone::fitting
