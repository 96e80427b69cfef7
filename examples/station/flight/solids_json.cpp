#include "touchstone/examples/station/flight/solids_json.hpp"

#include <nlohmann/json.hpp>

namespace touchstone::station {

void append_solids(const HexahedronTree& tree, std::uint32_t object, nlohmann::json& out) {
  for (const PlacedHexahedron& placed : tree.solids()) {
    nlohmann::json vertices = nlohmann::json::array();
    for (const Vector3& vertex : placed.solid.vertices()) {
      const Vector3 p_O = transform(placed.X_OS, vertex);
      for (int k = 0; k < 3; ++k) vertices.push_back(p_O[k]);
    }
    out.push_back({{"object", object}, {"name", placed.name}, {"vertices", vertices}});
  }
}

}  // namespace touchstone::station
