#pragma once

#include <memory>

#include "touchstone/contact_core/narrowphase/narrowphase.hpp"
#include "touchstone/contact_core/registry.hpp"

namespace touchstone {

/// The project's narrowphase: complete for every pair of convex hexahedra at finite poses; never
/// `undecided` or `unsupported`, `failed` only where a pose is not finite.
///
/// * Status: that of the hulls of the world vertices, exactly. Floating-point filters with derived bounds
///   settle nearly all pairs (box_box_overlap.hpp, parallelepiped_overlap.hpp, gjk.hpp), exact predicates the
///   rest. `separated` always comes with separation > 0 (the least double where the distance is below
///   rounding), `overlapping` with separation <= 0.
/// * Separation: within a few u (2^-53) of max(|world coordinate|, size), see distance.hpp and
///   facet_axes.hpp.
/// * (b, a) gives the same status and separation bits and the negated normal; except for identical solids in
///   identical poses, where both orders give one normal.
/// * Any scale: results of pairs beyond ordinary magnitudes are found on an exactly scaled copy.
/// * Manifolds hold a face that is bent as the one face that the user gave, where its two triangles' normals
///   agree to a cosine of 0.999 (2.56 degrees). Beyond that, which files reach on sides that are short beside
///   their rounding (8 mm in whole millimetres), each triangle is a face of its own.
/// * Rounded solids (Hexahedron::radius()): the cores' signed distance less both radii; the class near touch
///   by comparing squares in integers (rounded_predicate.hpp), manifolds as find_rounded_points() has them.
///   Pairs without a radius cost no more beside them.
/// * The pair cache keeps a separating axis; it helps overlap queries, in batches, of hexahedra that are no
///   parallelepipeds.
/// * evaluate() does not allocate; its workspace is empty.
std::unique_ptr<Narrowphase> make_native();
/// Whether make_native() made it.
bool is_native(const Narrowphase& narrowphase);

/// Adds make_native() as narrowphase `native`; register_core() does it, too.
/// @throws InputError when the name is taken.
void register_native(BackendRegistry& registry);

}  // namespace touchstone
