#include <gmock/gmock.h>
#include <ode/ode.h>

#include <cmath>
#include <cstdlib>
#include <iostream>
#include <optional>

#include "touchstone/adapters/ode/convex_data.hpp"
#include "touchstone/adapters/ode_plugin/ode_plugin.hpp"
#include "touchstone/adapters/scene_files/pair_file.hpp"
#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/tests/support/ask.hpp"
#include "touchstone/tests/support/scale_of.hpp"

// The named hard cases asked through dCollide: with ODE's own check, and with ours.

namespace touchstone {
namespace {

/// A geom, and what a dConvex points into.
class Geom {
 public:
  Geom(const Hexahedron& solid, const Pose& X_WS, bool native) : convex_(solid, ode::mean_vertex(solid)) {
    const bool by_centre = !solid.is_box() && !native;
    if (solid.is_box()) {
      const Vector3 side = 2.0 * solid.half_extents();
      id = dCreateBox(nullptr, side.x(), side.y(), side.z());
    } else if (native) {
      id = create_ode_hexahedron(nullptr, solid);
    } else {
      id = dCreateConvex(nullptr, convex_.planes.data(), 6, convex_.points.data(), 8,
                         ode::kConvexPolygons.data());
    }
    const Matrix3& R = X_WS.R;
    const Vector3 p = by_centre ? transform(X_WS, convex_.centre) : X_WS.p;
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
  ode::ConvexData convex_;
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
      // The truth of the case.
      const PosedPair& pair = *hard.pair;
      const bool contact = hard.exact->pair_class != PairClass::separated;
      const double expected = std::strtod(hard.exact->signed_distance.c_str(), nullptr);
      const double scale = scale_of(pair.solids[0], pair.X_WS[0], pair.solids[1], pair.X_WS[1]);
      ++cases;
      // The engine's check, then ours.
      for (const bool native : {false, true}) {
        std::optional<OdeBoxOverride> override;
        if (native) override.emplace();
        const Geom a(pair.solids[0], pair.X_WS[0], native), b(pair.solids[1], pair.X_WS[1], native);
        std::array<dContactGeom, 8> contacts;
        const int count = dCollide(a.id, b.id, 8, contacts.data(), sizeof(dContactGeom));
        double depth = -kInfinity;
        for (int i = 0; i < count; ++i) depth = std::max(depth, contacts[i].depth);
        const double tolerance = (native ? 1e-12 : 1e-4) * scale;  // the engine is forgiven a lot
        // Class, then depth.
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
  EXPECT_EQ(cases, 144);
  EXPECT_EQ(wrong_class[0], 13);
  EXPECT_EQ(wrong_depth[0], 10);
  dCloseODE();
}

}  // namespace
}  // namespace touchstone
