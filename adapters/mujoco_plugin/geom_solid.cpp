#include "touchstone/adapters/mujoco_plugin/geom_solid.hpp"

#include <algorithm>
#include <array>
#include <numeric>

#include "touchstone/contact_core/native/engine/solid_memory.hpp"

namespace touchstone::mujoco_plugin {
namespace {

using native::SolidContent;

/// This thread's for the store: native's stay, of others those of the last one.
native::SolidMemory& memory_of(const std::shared_ptr<native::SolidStore>& store) {
  thread_local native::SolidMemory natives(solid_store());
  if (store->is_native() && store == solid_store()) return natives;
  struct Other {
    std::shared_ptr<native::SolidStore> store;
    std::optional<native::SolidMemory> memory;
  };
  thread_local Other other;
  if (other.store != store) {
    other.memory.emplace(store);
    other.store = store;
  }
  return *other.memory;
}

/// All of the mesh where it has eight vertices, else those of its hull; in the mesh's order.
bool mesh_content(const mjModel& model, int mesh, SolidContent& content) {
  const float* const vertices = model.mesh_vert + 3 * static_cast<std::ptrdiff_t>(model.mesh_vertadr[mesh]);
  std::array<int, Hexahedron::kVertices> used;
  if (model.mesh_vertnum[mesh] == Hexahedron::kVertices) {
    std::iota(used.begin(), used.end(), 0);
  } else {
    // The hull's graph: numvert, numface, vert_edgeadr[numvert], vert_globalid[numvert], ...
    const int address = model.mesh_graphadr[mesh];
    if (address < 0) return false;
    const int* const graph = model.mesh_graph + address;
    if (graph[0] != Hexahedron::kVertices) return false;
    std::copy_n(graph + 2 + Hexahedron::kVertices, Hexahedron::kVertices, used.begin());
    std::sort(used.begin(), used.end());
  }
  for (int i = 0; i < Hexahedron::kVertices; ++i)
    for (int k = 0; k < 3; ++k) content.points[i][k] = static_cast<double>(vertices[3 * used[i] + k]);
  return true;
}

}  // namespace

std::shared_ptr<native::SolidStore> solid_store() {
  static const auto store = std::make_shared<native::SolidStore>();
  return store;
}

std::optional<native::SolidHandle> solid_of(const std::shared_ptr<native::SolidStore>& store,
                                            const mjModel& model, int geom) {
  native::SolidMemory& memory = memory_of(store);
  if (model.geom_type[geom] == mjGEOM_BOX) {
    const mjtNum* const half = model.geom_size + 3 * static_cast<std::ptrdiff_t>(geom);
    return memory.find_box({2.0 * half[0], 2.0 * half[1], 2.0 * half[2]});
  }
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
