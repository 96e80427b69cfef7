#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "touchstone/contact_core/fit/mesh_distance.hpp"
#include "touchstone/contact_core/fit/parts/prism.hpp"
#include "touchstone/contact_core/fit/space/allowed_space.hpp"

// Private to contact_core/fit.

namespace touchstone::fit {

/// The prisms of a mesh that are thick beside what is asked of them, `over` or less where they touch one of
/// the boxes: other hexahedra that go as far hardly hold parts of several. A shell that steps along an axis,
/// as a shaft, a pin on a plate or a cone on a rod, is one of each step, some of them thick. None is near a
/// shell that is inside out, as that may be its cavity.
std::vector<Prism> find_prisms(const MeshDistance& mesh, double over, std::span<const LimitBox> boxes = {});

/// The mesh without these triangles; nothing where none is left.
std::optional<MeshDistance> without(const MeshDistance& mesh, const std::vector<std::uint8_t>& is_out);

}  // namespace touchstone::fit
