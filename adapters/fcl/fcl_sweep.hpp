#pragma once

#include <fcl/narrowphase/continuous_collision.h>

#include "touchstone/contact_core/motion/sweep.hpp"

namespace touchstone::fcl_adapter {

struct SweepSetting {
  fcl::CCDSolverType solver;
  fcl::GJKSolverType gjk;
  std::size_t looks = 10;  ///< poses that CCDC_NAIVE looks at; 10 is FCL's default
};

fcl::ContinuousCollisionRequestd request_of(const SweepSetting& setting);

/// continuousCollide() of motions that are made here with their reference point.
std::optional<double> sweep(const fcl::CollisionGeometryd& a, const RigidPath& path_a,
                            const fcl::CollisionGeometryd& b, const RigidPath& path_b,
                            const SweepSetting& setting);

std::unique_ptr<Sweep> make_sweep(const SweepSetting& setting);

}  // namespace touchstone::fcl_adapter
