#include "touchstone/tests/benchmarks/motion/fcl_check.hpp"

#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/math/motion/interp_motion.h>

#include <cstdio>
#include <vector>

#include "touchstone/adapters/fcl/fcl_sweep.hpp"
#include "touchstone/adapters/fcl/shapes.hpp"

namespace touchstone::impact {
namespace {

using namespace fcl_adapter;

template <typename Volume>
Shape make_mesh(const Hexahedron& solid) {
  auto mesh = std::make_shared<fcl::BVHModel<Volume>>();
  std::vector<fcl::Triangle> triangles;
  for (const auto& quad : Hexahedron::kFaceVertices) {
    triangles.emplace_back(quad[0], quad[1], quad[2]);
    triangles.emplace_back(quad[0], quad[2], quad[3]);
  }
  mesh->beginModel();
  mesh->addSubModel(std::vector<fcl::Vector3d>(solid.vertices().begin(), solid.vertices().end()), triangles);
  mesh->endModel();
  return mesh;
}

constexpr SweepSetting kIndep{fcl::CCDC_CONSERVATIVE_ADVANCEMENT, fcl::GST_INDEP};
constexpr SweepSetting kLibccd{fcl::CCDC_CONSERVATIVE_ADVANCEMENT, fcl::GST_LIBCCD};
constexpr SweepSetting kNaive1000{fcl::CCDC_NAIVE, fcl::GST_LIBCCD, 1000};

using Ask = std::optional<double> (*)(const fcl::CollisionGeometryd&, const RigidPath&,
                                      const fcl::CollisionGeometryd&, const RigidPath&, const SweepSetting&);

/// By poses, from which FCL makes the motions.
template <fcl::CCDMotionType kMotion>
std::optional<double> ask_by_poses(const fcl::CollisionGeometryd& a, const RigidPath& path_a,
                                   const fcl::CollisionGeometryd& b, const RigidPath& path_b,
                                   const SweepSetting& setting) {
  fcl::ContinuousCollisionRequestd request = request_of(setting);
  request.ccd_motion_type = kMotion;
  fcl::ContinuousCollisionResultd result;
  fcl::continuousCollide(&a, to_engine(path_a.from()), to_engine(path_a.to()), &b, to_engine(path_b.from()),
                         to_engine(path_b.to()), request, result);
  return result.is_collide ? std::optional(result.time_of_contact) : std::nullopt;
}

/// As ask_by_poses(), where motions about a far point were before on the heap.
std::optional<double> ask_after_others(const fcl::CollisionGeometryd& a, const RigidPath& path_a,
                                       const fcl::CollisionGeometryd& b, const RigidPath& path_b,
                                       const SweepSetting& setting) {
  {
    const Vector3 far_point(1e20, 0, 0);
    const auto first = std::make_unique<fcl::InterpMotion<double>>(path_a.from().R, path_a.from().p,
                                                                   path_a.to().R, path_a.to().p, far_point);
    const auto second = std::make_unique<fcl::InterpMotion<double>>(path_b.from().R, path_b.from().p,
                                                                    path_b.to().R, path_b.to().p, far_point);
  }
  return ask_by_poses<fcl::CCDM_LINEAR>(a, path_a, b, path_b, setting);
}

/// One line of the check: how each kind of geometry answers.
void check(const char* title, const SweepSetting& setting, const Vector3& p, Ask ask_engine) {
  const Hexahedron cube = Hexahedron::from_size({1, 1, 1});
  const RigidPath path = RigidPath::by({Matrix3::Identity(), p}, {6, 0, 0}, Vector3::Zero());
  const RigidPath rest{Pose{}};
  std::printf("| %s |", title);
  for (const auto make : {make_box, make_convex, make_mesh<fcl::RSSd>, make_mesh<fcl::OBBRSSd>}) {
    const Shape a = make(cube), b = make(cube);
    const std::optional<double> said = ask_engine(*a, path, *b, rest, setting);
    if (said)
      std::printf(" %.6f |", *said);
    else
      std::printf(" none |");
  }
  std::printf("\n");
}

}  // namespace

void print_fcl_check() {
  std::printf(
      "\n### FCL %s on a closed form\n\nA unit cube goes from x = -3 to 3 past a unit cube at the origin, "
      "at y = 0 (face on face) or 0.3: they meet at s = 1/3.\nConservative advancement but where CCDC_NAIVE "
      "is named.\n\n| | box | convex | mesh, RSS | mesh, OBBRSS |\n|---|---|---|---|---|\n",
      FCL_VERSION);
  // Face on face and aside, by each kind of motion and solver.
  const auto both = [](const char* face, const char* aside, const SweepSetting& setting,
                       Ask ask_engine = sweep) {
    check(face, setting, {-3, 0, 0}, ask_engine), check(aside, setting, {-3, 0.3, 0}, ask_engine);
  };
  both("InterpMotion with a reference point, GST_INDEP, y = 0", "y = 0.3", kIndep);
  both("the same, GST_LIBCCD, y = 0", "y = 0.3", kLibccd);
  both("the same, CCDC_NAIVE, 1000 poses, y = 0", "y = 0.3", kNaive1000);
  both("poses and CCDM_LINEAR, GST_INDEP, after motions about (1e20, 0, 0) were deleted, y = 0", "y = 0.3",
       kIndep, ask_after_others);
  both("poses and CCDM_TRANS, GST_INDEP, y = 0", "y = 0.3", kIndep, ask_by_poses<fcl::CCDM_TRANS>);
  both("poses and CCDM_SCREW, GST_INDEP, y = 0", "y = 0.3", kIndep, ask_by_poses<fcl::CCDM_SCREW>);
  // Remarks on the rows.
  std::printf(
      "\nMotions that continuousCollide() makes of poses and CCDM_LINEAR have no reference point: "
      "InterpMotion(tf1, tf2) leaves it as the\nheap had it, and its answers depend on what was asked before "
      "(python-fcl's issue 11). CCDM_SCREW does not normalise the axis of a\npure translation and goes its "
      "length squared, 36 m for 6, so that it meets after 2 of 36 (FCL's issue 119). GST_LIBCCD misses where "
      "a\nstep lands on touch: the distance is 0, the normal and so the bound on the motion along it too, "
      "and "
      "a bound that is no greater than the\ndistance counts as clear to the end. Meshes are missed (FCL's "
      "issues 120, 297, 555): each step puts the vertices into the world on top\nof the step before. What "
      "follows are shapes, with InterpMotion made with its reference point.\n");
  std::fflush(stdout);
}

SweepEntry fcl_naive_1000() {
  return {"fcl_naive_1000", "FCL, CCDC_NAIVE, 1000 poses", "fcl", [] { return make_sweep(kNaive1000); }};
}

}  // namespace touchstone::impact
