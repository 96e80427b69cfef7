#pragma once

#include <BulletCollision/CollisionShapes/btCollisionShape.h>

#include <optional>

#include "touchstone/adapters/bullet/engine.hpp"
#include "touchstone/contact_core/native/engine/solid_store.hpp"

// Bullet's shapes in our terms.

namespace touchstone::TOUCHSTONE_BULLET_NAMESPACE {

/// Empty for a shape that is neither a box nor a hull of 8 points.
std::optional<native::SolidContent> content_of(const btCollisionShape& shape);

/// Whether the shape still is what `content` was made from.
bool is_content_of(const native::SolidContent& content, const btCollisionShape& shape);

/// Margin that grows the solid on all sides [m]: 0 for boxes, whose half-extents hold it.
/// @pre a shape with a content
double outer_margin(const btCollisionShape& shape);

}  // namespace touchstone::TOUCHSTONE_BULLET_NAMESPACE
