#include "touchstone/adapters/dart_plugin/object_solid.hpp"

#include <algorithm>
#include <array>
#include <dart/dynamics/BoxShape.hpp>
#include <dart/dynamics/MeshShape.hpp>

#include "touchstone/contact_core/native/engine/solid_memory.hpp"

namespace touchstone::dart_plugin {
namespace {

using native::SolidContent;

std::shared_ptr<native::SolidStore> shared_store() {
  static const auto store = std::make_shared<native::SolidStore>();
  return store;
}

SolidContent box_content(const dart::dynamics::BoxShape& box) {
  SolidContent content;
  content.is_box = true;
  for (int k = 0; k < 3; ++k) content.points[0][k] = box.getSize()[k];
  return content;
}

/// The mesh's vertices that differ (loaders repeat one for each facet), scaled. False: not eight.
bool mesh_content(const dart::dynamics::MeshShape& shape, SolidContent& content) {
  const aiScene* const scene = shape.getMesh();
  if (scene == nullptr) return false;
  std::size_t count = 0;
  for (unsigned m = 0; m < scene->mNumMeshes; ++m) {
    const aiMesh& mesh = *scene->mMeshes[m];
    for (unsigned v = 0; v < mesh.mNumVertices; ++v) {
      const aiVector3D& p = mesh.mVertices[v];
      const Eigen::Vector3d& scale = shape.getScale();
      const std::array<double, 3> point = {scale.x() * p.x, scale.y() * p.y, scale.z() * p.z};
      const auto end = content.points.begin() + count;
      if (std::find(content.points.begin(), end, point) != end) continue;
      if (count == content.points.size()) return false;
      content.points[count++] = point;
    }
  }
  return count == content.points.size();
}

}  // namespace

const native::SolidStore& solid_store() { return *shared_store(); }

const native::SolidHandle* solid_of(const dart::collision::CollisionObject& object) {
  thread_local native::SolidMemory memory(shared_store());
  const dart::dynamics::ConstShapePtr shape = object.getShape();
  if (shape->is<dart::dynamics::BoxShape>())
    return memory.find(box_content(static_cast<const dart::dynamics::BoxShape&>(*shape)));
  SolidContent content;
  if (!shape->is<dart::dynamics::MeshShape>() ||
      !mesh_content(static_cast<const dart::dynamics::MeshShape&>(*shape), content))
    return nullptr;
  return memory.find(content);
}

Pose pose_of(const dart::collision::CollisionObject& object) {
  const Eigen::Isometry3d& X_WO = object.getTransform();
  Pose X;
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) X.R(i, k) = X_WO(i, k);
  X.p = {X_WO(0, 3), X_WO(1, 3), X_WO(2, 3)};
  return X;
}

}  // namespace touchstone::dart_plugin
