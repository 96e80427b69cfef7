#include "touchstone/adapters/mujoco_plugin/geom_solid.hpp"

#include <algorithm>
#include <array>

#include "touchstone/contact_core/native/engine/solid_memory.hpp"

namespace touchstone::mujoco_plugin {
namespace {

using native::SolidMemory;

/// This thread's for the store: native's stay, of others those of the last one.
SolidMemory& memory_of(const std::shared_ptr<native::SolidStore>& store) {
  thread_local SolidMemory natives(solid_store());
  if (store->is_native() && store == solid_store()) return natives;
  struct Other {
    std::shared_ptr<native::SolidStore> store;
    std::optional<SolidMemory> memory;
  };
  thread_local Other other;
  if (other.store != store) {
    other.memory.emplace(store);
    other.store = store;
  }
  return *other.memory;
}

/// The vertices of the mesh's hull, in the mesh's order, where there are eight.
bool hull_corners(const mjModel& model, int mesh, const float* vertices, SolidMemory::Corners& corners) {
  // The hull's graph: numvert, numface, vert_edgeadr[numvert], vert_globalid[numvert], ...
  const int address = model.mesh_graphadr[mesh];
  if (address < 0) return false;
  const int* const graph = model.mesh_graph + address;
  if (graph[0] != Hexahedron::kVertices) return false;
  std::array<int, Hexahedron::kVertices> used;
  std::copy_n(graph + 2 + Hexahedron::kVertices, Hexahedron::kVertices, used.begin());
  std::sort(used.begin(), used.end());
  for (std::size_t i = 0; i < used.size(); ++i)
    std::copy_n(vertices + 3 * used[i], 3, corners.data() + 3 * i);
  return true;
}

}  // namespace

const std::shared_ptr<native::SolidStore>& solid_store() {
  static const auto store = std::make_shared<native::SolidStore>();
  return store;
}

const native::SolidHandle* solid_of(const std::shared_ptr<native::SolidStore>& store, const mjModel& model,
                                    int geom) {
  SolidMemory& memory = memory_of(store);
  if (model.geom_type[geom] == mjGEOM_BOX) {
    const mjtNum* const half = model.geom_size + 3 * static_cast<std::ptrdiff_t>(geom);
    const double sides[3] = {2.0 * half[0], 2.0 * half[1], 2.0 * half[2]};
    return memory.find_box(sides);
  }
  // All of the mesh where it has eight vertices.
  const int mesh = model.geom_dataid[geom];
  const float* const vertices = model.mesh_vert + 3 * static_cast<std::ptrdiff_t>(model.mesh_vertadr[mesh]);
  if (model.mesh_vertnum[mesh] == Hexahedron::kVertices) return memory.find_hull(vertices);
  SolidMemory::Corners corners;
  return hull_corners(model, mesh, vertices, corners) ? memory.find_hull(corners.data()) : nullptr;
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
