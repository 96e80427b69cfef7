// Motions are InterpMotion, origin straight and one turn, as ours are; ScrewMotion takes another way. They
// are made here with their reference point and given to continuousCollide: where it is given poses and
// CCDM_LINEAR it makes them without one, reads what the heap held there, and answers by chance. Of the
// request conservative advancement reads neither the error nor the iterations: it ends where a step is below
// 1e-4 of the motion.

#include "touchstone/adapters/fcl/fcl_sweep.hpp"

#include <fcl/math/motion/interp_motion.h>

#include "touchstone/adapters/fcl/shapes.hpp"
#include "touchstone/contact_core/input_error.hpp"

namespace touchstone::fcl_adapter {
namespace {

fcl::InterpMotion<double> motion_of(const RigidPath& path) {
  return {path.from().R, path.from().p, path.to().R, path.to().p, fcl::Vector3d::Zero()};
}

class FclSweep final : public Sweep {
 public:
  explicit FclSweep(const SweepSetting& setting) : setting_(setting) {}

  void set(const Hexahedron& a, const RigidPath& path_a, const Hexahedron& b,
           const RigidPath& path_b) override {
    refuse_rounded({&a, 1}, "fcl");
    refuse_rounded({&b, 1}, "fcl");
    Shape shape_a = make_shape(a), shape_b = make_shape(b);  // both, or neither
    a_ = std::move(shape_a), b_ = std::move(shape_b);
    path_a_ = &path_a, path_b_ = &path_b;
  }
  std::optional<double> impact() override { return sweep(*a_, *path_a_, *b_, *path_b_, setting_); }

 private:
  SweepSetting setting_;
  Shape a_, b_;
  const RigidPath *path_a_ = nullptr, *path_b_ = nullptr;
};

}  // namespace

fcl::ContinuousCollisionRequestd request_of(const SweepSetting& setting) {
  return {setting.looks, 1e-6, fcl::CCDM_LINEAR, setting.gjk, setting.solver};
}

std::optional<double> sweep(const fcl::CollisionGeometryd& a, const RigidPath& path_a,
                            const fcl::CollisionGeometryd& b, const RigidPath& path_b,
                            const SweepSetting& setting) {
  const fcl::InterpMotion<double> motion_a = motion_of(path_a), motion_b = motion_of(path_b);
  fcl::ContinuousCollisionResultd result;
  fcl::continuousCollide(&a, &motion_a, &b, &motion_b, request_of(setting), result);
  return result.is_collide ? std::optional(result.time_of_contact) : std::nullopt;
}

std::unique_ptr<Sweep> make_sweep(const SweepSetting& setting) { return std::make_unique<FclSweep>(setting); }

}  // namespace touchstone::fcl_adapter
