#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>

#include "touchstone/contact_core/geometry/hexahedron_tree.hpp"

namespace touchstone::station {

/// Appends an object's solids to the `solids` of a `scene` message (protocol.md).
void append_solids(const HexahedronTree& tree, std::uint32_t object, nlohmann::json& out);

}  // namespace touchstone::station
