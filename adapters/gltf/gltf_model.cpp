#include "touchstone/adapters/gltf/gltf_model.hpp"

#include "touchstone/adapters/gltf/gltf_buffer.hpp"
#include "touchstone/contact_core/input_error.hpp"

namespace touchstone {
namespace {

using gltf::Buffer;
using nlohmann::ordered_json;

void require_whole(const GltfPart& part) {
  const auto fail = [&](const std::string& reason) {
    throw InputError("gltf: part '" + part.name + "': " + reason);
  };
  if (part.triangles.empty()) fail("no triangle");
  for (const auto& t : part.triangles)
    for (const std::uint32_t i : t)
      if (i >= part.vertices.size()) fail("a triangle names vertex " + std::to_string(i));
  if (part.colours.size() != 1 && part.colours.size() != part.vertices.size())
    fail("neither one colour nor one a vertex");
}

std::vector<float> positions_of(const GltfPart& part) {
  std::vector<float> out;
  for (const Vector3& v : part.vertices)
    for (int i = 0; i < 3; ++i) out.push_back(static_cast<float>(v(i)));
  return out;
}

ordered_json primitive(const GltfPart& part, Buffer& buffer, std::size_t material) {
  ordered_json attributes;
  attributes["POSITION"] = buffer.add(positions_of(part), "VEC3", Buffer::Target::vertices);
  if (part.colours.size() > 1) {
    std::vector<float> colours;
    for (const auto& c : part.colours) colours.insert(colours.end(), {c[0], c[1], c[2], part.opacity});
    attributes["COLOR_0"] = buffer.add(colours, "VEC4", Buffer::Target::vertices);
  }
  std::vector<std::uint32_t> indices;
  for (const auto& t : part.triangles) indices.insert(indices.end(), t.begin(), t.end());
  return {{"attributes", attributes}, {"indices", buffer.add(indices)}, {"material", material}};
}

ordered_json material(const GltfPart& part) {
  const std::array<float, 3> colour =
      part.colours.size() == 1 ? part.colours[0] : std::array<float, 3>{1.0F, 1.0F, 1.0F};
  const float opacity = part.colours.size() == 1 ? part.opacity : 1.0F;  // else it is the vertices'
  ordered_json out = {{"name", part.name},
                      {"pbrMetallicRoughness",
                       {{"baseColorFactor", ordered_json::array({colour[0], colour[1], colour[2], opacity})},
                        {"metallicFactor", 0.0},
                        {"roughnessFactor", 0.9}}}};
  if (part.opacity < 1.0F) out["alphaMode"] = "BLEND", out["doubleSided"] = true;
  return out;
}

}  // namespace

std::string gltf_model(std::span<const GltfPart> parts, const GltfOptions& options) {
  Buffer buffer;
  ordered_json document;
  document["asset"] = {{"version", "2.0"}, {"generator", "Touchstone"}};
  ordered_json nodes = ordered_json::array(), meshes = ordered_json::array(),
               materials = ordered_json::array(), children = ordered_json::array();
  // A mesh, a material and a node a part.
  for (const GltfPart& part : parts) {
    require_whole(part);
    const std::size_t index = meshes.size();
    ordered_json mesh;
    mesh["name"] = part.name;
    mesh["primitives"] = ordered_json::array({primitive(part, buffer, index)});
    meshes.push_back(std::move(mesh));
    materials.push_back(material(part));
    nodes.push_back({{"name", part.name}, {"mesh", index}});
    children.push_back(index);
  }
  // All hang on one node, which turns z up to glTF's y up.
  ordered_json root = {{"name", "world"}, {"children", children}};
  if (options.is_z_up)
    root["rotation"] = ordered_json::array({-0.7071067811865476, 0.0, 0.0, 0.7071067811865476});
  nodes.push_back(root);
  document["scene"] = 0;
  ordered_json scene;
  scene["nodes"] = ordered_json::array({nodes.size() - 1});
  document["scenes"] = ordered_json::array({scene});
  document["nodes"] = nodes;
  document["meshes"] = meshes;
  document["materials"] = materials;
  buffer.write(document);
  return document.dump(-1, ' ', false, ordered_json::error_handler_t::replace);
}

}  // namespace touchstone
