#pragma once

#include "touchstone/contact_core/scene/scene.hpp"

namespace touchstone::comparison {

/// The most hexahedra between an object's root and one of its hexahedra, over the objects: levels of covers
/// that differ from the scene; 0 where every object is one hexahedron. Also 0 where an exemption names a
/// hexahedron, which covers no longer have.
int cover_levels(const Scene& scene);

/// The scene with every object's tree cut `level` below its root: what hangs below a node becomes one box
/// along the object's axes that encloses it, to rounding; a node of one hexahedron stays that. Covers never
/// come later into contact than what they enclose. @pre 0 <= level < cover_levels(scene)
Scene with_covers(const Scene& scene, int level);

}  // namespace touchstone::comparison
