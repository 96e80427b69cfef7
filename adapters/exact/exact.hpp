#pragma once

#include "touchstone/contact_core/registry.hpp"

namespace touchstone {

/// Adds the narrowphase `exact`: the ground truth. The status is never `undecided` or `failed`, the
/// separation is right to the last bit, see signed_distance.hpp, of rounded solids too. It allocates in
/// evaluate() (GMP's integers): use it to judge, not in a frame loop. Manifold: corners of the clip in
/// contact_patch.hpp within the point limit, and the witness pair first where none of them is as deep.
void register_exact(BackendRegistry& registry);

}  // namespace touchstone
