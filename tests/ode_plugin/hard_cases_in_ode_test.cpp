#include <gmock/gmock.h>
#include <ode/ode.h>

#include <cmath>
#include <cstdlib>
#include <iostream>
#include <optional>

#include "adapters/ode_plugin/ode_plugin.hpp"
#include "adapters/scene_files/pair_file.hpp"
#include "tests/support/ask.hpp"
#include "tests/support/scale_of.hpp"

// The named hard cases asked through dCollide: with ODE's own check, and with ours.

namespace touchstone {
namespace {

constexpr std::array<unsigned int, 30> kPolygons = [] {
  std::array<unsigned int, 30> polygons{};
  std::size_t next = 0;
  for (const auto& face : Hexahedron::kFaceVertices) {
    polygons[next++] = 4;
    for (const std::uint8_t vertex : face) polygons[next++] = vertex;
  }
  return polygons;
}();

/// A geom, and what a dConvex points into. ODE wants a convex about an inner point.
class Geom {
 public:
  Geom(const Hexahedron& solid, const Pose& X_WS, bool native) {
    Vector3 centre = Vector3::Zero();
    if (solid.is_box()) {
      const Vector3 side = 2.0 * solid.half_extents();
      id = dCreateBox(nullptr, side.x(), side.y(), side.z());
    } else if (native) {
      id = create_ode_hexahedron(nullptr, solid);
    } else {
      for (const Vector3& v : solid.vertices()) centre += v / 8.0;
      for (int f = 0; f < 6; ++f) {
        for (int k = 0; k < 3; ++k) planes_[4 * f + k] = solid.face_plane(f).normal[k];
        planes_[4 * f + 3] = -solid.face_plane(f).signed_distance(centre);
      }
      for (int i = 0; i < 8; ++i)
        for (int k = 0; k < 3; ++k) points_[3 * i + k] = solid.vertices()[i][k] - centre[k];
      id = dCreateConvex(nullptr, planes_.data(), 6, points_.data(), 8, kPolygons.data());
    }
    const Matrix3& R = X_WS.R;
    const Vector3 p = solid.is_box() || native ? X_WS.p : transform(X_WS, centre);
    const dMatrix3 rows = {R(0, 0), R(0, 1), R(0, 2), 0,       R(1, 0), R(1, 1),
                           R(1, 2), 0,       R(2, 0), R(2, 1), R(2, 2), 0};
    dGeomSetPosition(id, p.x(), p.y(), p.z());
    dGeomSetRotation(id, rows);
  }
  ~Geom() { dGeomDestroy(id); }
  Geom(const Geom&) = delete;
  Geom& operator=(const Geom&) = delete;

  dGeomID id;

 private:
  std::array<dReal, 24> planes_{}, points_{};
};

enum class Verdict { right, wrong_class, wrong_depth };

TEST(OdePluginHardCases, AreRightWithOurCheckWhereTheEnginesIsWrong) {
  dInitODE2(0);
  dAllocateODEDataForThread(dAllocateMaskAll);
  int cases = 0, wrong_class[2] = {}, wrong_depth[2] = {};
  std::vector<std::string> ours_wrong;
  for (const char* file :
       {"containment", "coplanar", "far", "hexahedra", "near_parallel", "scale", "thin", "touching"}) {
    for (const PairCase& hard : load_pairs(std::string(TOUCHSTONE_HARD_CASES) + "/" + file + ".json")) {
      const PosedPair& pair = *hard.pair;
      const bool contact = hard.exact->pair_class != PairClass::separated;
      const double expected = std::strtod(hard.exact->signed_distance.c_str(), nullptr);
      const double scale = scale_of(pair.solids[0], pair.X_WS[0], pair.solids[1], pair.X_WS[1]);
      ++cases;
      for (const bool native : {false, true}) {
        std::optional<OdeBoxOverride> override;
        if (native) override.emplace();
        const Geom a(pair.solids[0], pair.X_WS[0], native), b(pair.solids[1], pair.X_WS[1], native);
        std::array<dContactGeom, 8> contacts;
        const int count = dCollide(a.id, b.id, 8, contacts.data(), sizeof(dContactGeom));
        double depth = -std::numeric_limits<double>::infinity();
        for (int i = 0; i < count; ++i) depth = std::max(depth, contacts[i].depth);
        const double tolerance = (native ? 1e-12 : 1e-4) * scale;  // the engine is forgiven a lot
        Verdict verdict = Verdict::right;
        if ((count > 0) != contact)
          verdict = Verdict::wrong_class;
        else if (contact && !(std::abs(-depth - expected) <= tolerance))
          verdict = Verdict::wrong_depth;
        wrong_class[native] += verdict == Verdict::wrong_class;
        wrong_depth[native] += verdict == Verdict::wrong_depth;
        if (native && verdict != Verdict::right) ours_wrong.push_back(hard.id);
      }
    }
  }
  std::cout << cases << " cases: engine's own " << wrong_class[0] << " of the wrong class, " << wrong_depth[0]
            << " of wrong depth; ours " << wrong_class[1] << ", " << wrong_depth[1] << "\n";
  EXPECT_THAT(ours_wrong, testing::IsEmpty());
  EXPECT_GT(wrong_class[0] + wrong_depth[0], 0);
  dCloseODE();
}

}  // namespace
}  // namespace touchstone
