#pragma once

#include <memory>
#include <string>

#include "touchstone/adapters/bullet/engine.hpp"
#include "touchstone/contact_core/broadphase/broadphase.hpp"
#include "touchstone/contact_core/motion/sweep.hpp"
#include "touchstone/contact_core/narrowphase/raw_check.hpp"

namespace touchstone::TOUCHSTONE_BULLET_NAMESPACE {

enum class Method : std::uint8_t {
  box_and_convex,  ///< the box detector for two boxes, GJK/EPA for the rest
  gjk,             ///< GJK/EPA for all
};

/// Bullet's casts. Shapes are without margins, but boxes of btGjkConvexCast: it gives up where a step lands
/// on touch, which without margins is where solids meet.
enum class SweepMethod : std::uint8_t {
  continuous,  ///< btContinuousConvexCollision
  gjk,         ///< btGjkConvexCast, without turning
  subsimplex,  ///< btSubsimplexConvexCast, without turning
};

std::unique_ptr<Narrowphase> make_narrowphase(std::string name, Method method);
std::unique_ptr<RawCheck> make_raw_check(Method method);
std::unique_ptr<Sweep> make_sweep(SweepMethod method);
std::unique_ptr<Broadphase> make_broadphase(std::string name);

}  // namespace touchstone::TOUCHSTONE_BULLET_NAMESPACE
