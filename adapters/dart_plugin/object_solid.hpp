#pragma once

#include <dart/collision/CollisionObject.hpp>

#include "touchstone/contact_core/geometry/pose.hpp"
#include "touchstone/contact_core/native/engine/solid_store.hpp"

// DART's objects in our terms.

namespace touchstone::dart_plugin {

/// Of all detectors of the process.
const native::SolidStore& solid_store();

/// Null for a shape that is not ours to check. Held until 1024 other shapes were asked for on this thread.
const native::SolidHandle* solid_of(const dart::collision::CollisionObject& object);

Pose pose_of(const dart::collision::CollisionObject& object);

}  // namespace touchstone::dart_plugin
