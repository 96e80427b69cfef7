#include "adapters/mujoco_plugin/geom_solid.hpp"

#include "contact_core/native/solid_memory.hpp"

namespace touchstone::mujoco_plugin {
namespace {

using native::SolidContent;

std::shared_ptr<native::SolidStore> shared_store() {
  static const auto store = std::make_shared<native::SolidStore>();
  return store;
}

SolidContent box_content(const mjModel& model, int geom) {
  SolidContent content;
  content.is_box = true;
  for (int k = 0; k < 3; ++k) content.points[0][k] = 2.0 * model.geom_size[3 * geom + k];
  return content;
}

/// The hull's vertices: of the mesh's graph where it has one, all of the mesh otherwise, as MuJoCo's own
/// check takes them.
bool mesh_content(const mjModel& model, int mesh, SolidContent& content) {
  const float* const vertices = model.mesh_vert + 3 * static_cast<std::ptrdiff_t>(model.mesh_vertadr[mesh]);
  const int address = model.mesh_graphadr[mesh];
  // numvert, numface, vert_edgeadr[numvert], vert_globalid[numvert], ...
  const int* const graph = address < 0 ? nullptr : model.mesh_graph + address;
  const int count = graph != nullptr ? graph[0] : model.mesh_vertnum[mesh];
  if (count != Hexahedron::kVertices) return false;
  for (int i = 0; i < count; ++i) {
    const std::ptrdiff_t vertex = graph != nullptr ? graph[2 + count + i] : i;
    for (int k = 0; k < 3; ++k) content.points[i][k] = static_cast<double>(vertices[3 * vertex + k]);
  }
  return true;
}

}  // namespace

const native::SolidStore& solid_store() { return *shared_store(); }

std::optional<native::SolidHandle> solid_of(const mjModel& model, int geom) {
  thread_local native::SolidMemory memory(shared_store());
  if (model.geom_type[geom] == mjGEOM_BOX) return memory.find(box_content(model, geom));
  SolidContent content;
  if (!mesh_content(model, model.geom_dataid[geom], content)) return std::nullopt;
  return memory.find(content);
}

Pose pose_of(const mjData& data, int geom) {
  const mjtNum* const p = data.geom_xpos + 3 * static_cast<std::ptrdiff_t>(geom);
  const mjtNum* const R = data.geom_xmat + 9 * static_cast<std::ptrdiff_t>(geom);
  Pose X;
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) X.R(i, k) = R[3 * i + k];
  X.p = {p[0], p[1], p[2]};
  return X;
}

}  // namespace touchstone::mujoco_plugin
