#pragma once

#include <memory>
#include <string>

#include "touchstone/adapters/bullet/engine.hpp"
#include "touchstone/contact_core/broadphase/broadphase.hpp"
#include "touchstone/contact_core/narrowphase/raw_check.hpp"

namespace touchstone::TOUCHSTONE_BULLET_NAMESPACE {

enum class Method : std::uint8_t {
  box_and_convex,  ///< the box detector for two boxes, GJK/EPA for the rest
  gjk,             ///< GJK/EPA for all
};

std::unique_ptr<Narrowphase> make_narrowphase(std::string name, Method method);
std::unique_ptr<RawCheck> make_raw_check(Method method);
std::unique_ptr<Broadphase> make_broadphase(std::string name);

}  // namespace touchstone::TOUCHSTONE_BULLET_NAMESPACE
