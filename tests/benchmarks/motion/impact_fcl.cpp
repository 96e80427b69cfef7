// FCL's continuous collision (continuousCollide), in double precision, by its two methods that take convex
// shapes: conservative advancement (CCDC_CONSERVATIVE_ADVANCEMENT) with either GJK, and CCDC_NAIVE, which
// looks at poses evenly spaced. Boxes are its boxes, other hexahedra its convex hulls.
//
// Motions are InterpMotion, origin straight and one turn, as ours are; ScrewMotion takes another way. They
// are made here with their reference point and given to continuousCollide: where it is given poses and
// CCDM_LINEAR it makes them without one, reads what the heap held there, and answers by chance. Of the
// request conservative advancement reads neither the error nor the iterations: it ends where a step is below
// 1e-4 of the motion.

#include "touchstone/tests/benchmarks/motion/impact_method.hpp"

#ifdef TOUCHSTONE_BENCHMARK_FCL
#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/geometry/shape/box.h>
#include <fcl/geometry/shape/convex.h>
#include <fcl/math/motion/interp_motion.h>
#include <fcl/narrowphase/continuous_collision.h>

#include <array>
#include <cstdio>
#include <vector>

namespace touchstone::impact {
namespace {

using Geometry = std::shared_ptr<fcl::CollisionGeometryd>;

fcl::Transform3d to_engine(const Pose& X) {
  fcl::Transform3d out = fcl::Transform3d::Identity();
  out.linear() = X.R;
  out.translation() = X.p;
  return out;
}

Geometry make_box(const Hexahedron& solid) { return std::make_shared<fcl::Boxd>(2.0 * solid.half_extents()); }

Geometry make_convex(const Hexahedron& solid) {
  auto faces = std::make_shared<std::vector<int>>();
  for (const auto& quad : Hexahedron::kFaceVertices) {
    faces->push_back(4);
    faces->insert(faces->end(), quad.begin(), quad.end());
  }
  auto vertices =
      std::make_shared<std::vector<fcl::Vector3d>>(solid.vertices().begin(), solid.vertices().end());
  return std::make_shared<fcl::Convexd>(vertices, static_cast<int>(Hexahedron::kFaceVertices.size()), faces);
}

template <typename Volume>
Geometry make_mesh(const Hexahedron& solid) {
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

struct Setting {
  const char* name;
  fcl::CCDSolverType solver;
  fcl::GJKSolverType gjk;
  std::size_t looks = 10;  ///< of CCDC_NAIVE
  fcl::CCDMotionType motion = fcl::CCDM_LINEAR;
};

std::optional<double> time_of(const fcl::ContinuousCollisionResultd& result) {
  return result.is_collide ? std::optional(result.time_of_contact) : std::nullopt;
}

fcl::ContinuousCollisionRequestd request_of(const Setting& setting) {
  return {setting.looks, 1e-6, setting.motion, setting.gjk, setting.solver};
}

/// By poses, from which FCL makes the motions.
std::optional<double> ask_by_poses(const fcl::CollisionGeometryd& a, const RigidPath& path_a,
                                   const fcl::CollisionGeometryd& b, const RigidPath& path_b,
                                   const Setting& setting) {
  fcl::ContinuousCollisionResultd result;
  fcl::continuousCollide(&a, to_engine(path_a.from()), to_engine(path_a.to()), &b, to_engine(path_b.from()),
                         to_engine(path_b.to()), request_of(setting), result);
  return time_of(result);
}

fcl::InterpMotion<double> motion_of(const RigidPath& path, const Vector3& reference_O) {
  return {path.from().R, path.from().p, path.to().R, path.to().p, reference_O};
}

/// By motions whose reference point is set.
std::optional<double> ask(const fcl::CollisionGeometryd& a, const RigidPath& path_a,
                          const fcl::CollisionGeometryd& b, const RigidPath& path_b, const Setting& setting) {
  if (setting.motion != fcl::CCDM_LINEAR) return ask_by_poses(a, path_a, b, path_b, setting);
  const fcl::InterpMotion<double> motion_a = motion_of(path_a, Vector3::Zero()),
                                  motion_b = motion_of(path_b, Vector3::Zero());
  fcl::ContinuousCollisionResultd result;
  fcl::continuousCollide(&a, &motion_a, &b, &motion_b, request_of(setting), result);
  return time_of(result);
}

class FclMethod final : public Method {
 public:
  explicit FclMethod(const Setting& setting) : setting_(setting) {}
  std::string_view name() const override { return setting_.name; }
  void set(const Motion& motion) override {
    motion_ = &motion;
    a_ = motion.a.is_box() ? make_box(motion.a) : make_convex(motion.a);
    b_ = motion.b.is_box() ? make_box(motion.b) : make_convex(motion.b);
  }
  std::optional<double> impact() override {
    return ask(*a_, motion_->path_a, *b_, motion_->path_b, setting_);
  }

 private:
  Setting setting_;
  const Motion* motion_ = nullptr;
  Geometry a_, b_;
};

constexpr Setting kIndep{"FCL, conservative advancement, GST_INDEP", fcl::CCDC_CONSERVATIVE_ADVANCEMENT,
                         fcl::GST_INDEP};
constexpr Setting kLibccd{"FCL, conservative advancement, GST_LIBCCD", fcl::CCDC_CONSERVATIVE_ADVANCEMENT,
                          fcl::GST_LIBCCD};
constexpr Setting kNaive{"FCL, CCDC_NAIVE, 10 poses (its default)", fcl::CCDC_NAIVE, fcl::GST_LIBCCD};
constexpr Setting kNaive1000{"FCL, CCDC_NAIVE, 1000 poses", fcl::CCDC_NAIVE, fcl::GST_LIBCCD, 1000};

using Ask = std::optional<double> (*)(const fcl::CollisionGeometryd&, const RigidPath&,
                                      const fcl::CollisionGeometryd&, const RigidPath&, const Setting&);

/// As ask_by_poses(), where motions about a far point were before on the heap.
std::optional<double> ask_after_others(const fcl::CollisionGeometryd& a, const RigidPath& path_a,
                                       const fcl::CollisionGeometryd& b, const RigidPath& path_b,
                                       const Setting& setting) {
  {
    const Vector3 far_point(1e20, 0, 0);
    const auto first = std::make_unique<fcl::InterpMotion<double>>(motion_of(path_a, far_point));
    const auto second = std::make_unique<fcl::InterpMotion<double>>(motion_of(path_b, far_point));
  }
  return ask_by_poses(a, path_a, b, path_b, setting);
}

/// One line of the check: how each kind of geometry answers.
void check(const char* title, const Setting& setting, const Vector3& p, Ask ask_engine) {
  const Hexahedron cube = Hexahedron::from_size({1, 1, 1});
  const RigidPath path = RigidPath::by({Matrix3::Identity(), p}, {6, 0, 0}, Vector3::Zero());
  const RigidPath rest{Pose{}};
  std::printf("| %s |", title);
  for (const auto make : {make_box, make_convex, make_mesh<fcl::RSSd>, make_mesh<fcl::OBBRSSd>}) {
    const Geometry a = make(cube), b = make(cube);
    const std::optional<double> said = ask_engine(*a, path, *b, rest, setting);
    if (said)
      std::printf(" %.6f |", *said);
    else
      std::printf(" none |");
  }
  std::printf("\n");
}

}  // namespace

std::unique_ptr<Method> make_fcl_indep() { return std::make_unique<FclMethod>(kIndep); }
std::unique_ptr<Method> make_fcl_libccd() { return std::make_unique<FclMethod>(kLibccd); }
std::unique_ptr<Method> make_fcl_naive() { return std::make_unique<FclMethod>(kNaive); }
std::unique_ptr<Method> make_fcl_naive_1000() { return std::make_unique<FclMethod>(kNaive1000); }

void print_fcl_check() {
  std::printf(
      "\n### FCL %s on a closed form\n\nA unit cube goes from x = -3 to 3 past a unit cube at the origin, "
      "at y = 0 (face on face) or 0.3: they meet at s = 1/3.\nConservative advancement but where CCDC_NAIVE "
      "is named.\n\n| | box | convex | mesh, RSS | mesh, OBBRSS |\n|---|---|---|---|---|\n",
      FCL_VERSION);
  const auto both = [](const char* face, const char* aside, const Setting& setting, Ask ask_engine = ask) {
    check(face, setting, {-3, 0, 0}, ask_engine), check(aside, setting, {-3, 0.3, 0}, ask_engine);
  };
  both("InterpMotion with a reference point, GST_INDEP, y = 0", "y = 0.3", kIndep);
  both("the same, GST_LIBCCD, y = 0", "y = 0.3", kLibccd);
  both("the same, CCDC_NAIVE, 1000 poses, y = 0", "y = 0.3", kNaive1000);
  both("poses and CCDM_LINEAR, GST_INDEP, after motions about (1e20, 0, 0) were deleted, y = 0", "y = 0.3",
       kIndep, ask_after_others);
  Setting other = kIndep;
  other.motion = fcl::CCDM_TRANS;
  both("poses and CCDM_TRANS, GST_INDEP, y = 0", "y = 0.3", other);
  other.motion = fcl::CCDM_SCREW;
  both("poses and CCDM_SCREW, GST_INDEP, y = 0", "y = 0.3", other);
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

}  // namespace touchstone::impact
#else
namespace touchstone::impact {
std::unique_ptr<Method> make_fcl_indep() { return nullptr; }
std::unique_ptr<Method> make_fcl_libccd() { return nullptr; }
std::unique_ptr<Method> make_fcl_naive() { return nullptr; }
std::unique_ptr<Method> make_fcl_naive_1000() { return nullptr; }
void print_fcl_check() {}
}  // namespace touchstone::impact
#endif
