#pragma once

#include <memory>

#include "touchstone/contact_core/registry.hpp"

namespace touchstone {

/// The paper's coarse check (`Polyhedron_in_range`), as a broadphase `edge_face`: every two objects, from the
/// roots of their trees down. Two nodes are in range when their spheres' centres are closer than the sum of
/// their radii, strictly; of two leaves in range, the pair goes into a linked list. Radii are taken about
/// frames: a hexahedron's sphere is centred on its own frame's origin, an inner node's on the object's, and
/// reaches the farthest vertex below. Here the list is sorted in the end, and the margin added to the sum:
/// the interface asks for both.
///
/// It keeps that build's limits. Pairs whose spheres touch exactly, or within the rounding of their centres
/// (some roundings of the largest coordinate), are missed, so "never a pair within the margin" holds only
/// beyond that. Example: two equal boxes that touch corner to corner are missed. Each update() allocates
/// one list node for every pair in range and frees those of the last; without memory the process ends. Every
/// update looks at all pairs of objects, even of static ones, on one thread. It takes poses only:
/// update_paths() returns false.
std::unique_ptr<Broadphase> make_edge_face_broadphase();

/// Registers it as `edge_face`, the name of the narrowphase that the paper uses with it.
void register_edge_face_broadphase(BackendRegistry& registry);

}  // namespace touchstone
