#pragma once

#include "contact_core/registry.hpp"

namespace touchstone {

/// Adds the narrowphase `exact`: the ground truth. The status is never `undecided` or `failed`, the
/// separation is right to the last bit, see signed_distance.hpp. It allocates in evaluate() (GMP's integers):
/// use it to judge, not in a frame loop. Manifold: see contact_patch.hpp; a patch without area gives the
/// witness pair alone.
void register_exact(BackendRegistry& registry);

}  // namespace touchstone
