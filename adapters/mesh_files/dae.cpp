#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <algorithm>
#include <assimp/Importer.hpp>
#include <assimp/ProgressHandler.hpp>

#include "touchstone/adapters/mesh_files/dae_nodes.hpp"
#include "touchstone/adapters/mesh_files/mesh_file.hpp"
#include "touchstone/adapters/mesh_files/soup.hpp"
#include "touchstone/contact_core/input_error.hpp"

namespace touchstone {
namespace mesh_files {
namespace {

/// Coordinates, the unit's factor and each node's transform are single precision: up to 2^-24 each, and few
/// nodes deep; 2^-20 holds 16 of them.
constexpr double kSinglePrecision = 0x1p-20;
constexpr int kMostLevels = 1000;

struct Transform {
  Matrix3 A = Matrix3::Identity();
  Vector3 p = Vector3::Zero();

  static Transform of(const aiMatrix4x4& m) {
    Transform out;
    out.A << m.a1, m.a2, m.a3, m.b1, m.b2, m.b3, m.c1, m.c2, m.c3;
    out.p = {m.a4, m.b4, m.c4};
    return out;
  }
  Vector3 operator*(const Vector3& v) const {
    return Vector3(A.col(0) * v.x() + A.col(1) * v.y() + A.col(2) * v.z() + p);
  }
  Transform operator*(const Transform& inner) const {
    Transform out;
    for (int i = 0; i < 3; ++i) {
      const Vector3 column = inner.A.col(i);
      out.A.col(i) = A.col(0) * column.x() + A.col(1) * column.y() + A.col(2) * column.z();
    }
    out.p = *this * inner.p;
    return out;
  }
};

class Importing final : public Assimp::ProgressHandler {
 public:
  explicit Importing(const ReadTask& task) : task_(&task) {}
  bool Update(float share) override {
    if (share >= 0.0F) task_->advance(std::min(1.0, static_cast<double>(share)));
    return true;
  }

 private:
  const ReadTask* task_;
};

struct SceneReader {
  const aiScene& scene;
  const ReadTask& task;
  Soup soup = {};

  void take_mesh(const aiMesh& mesh, const Transform& X) {
    const auto first = static_cast<std::uint32_t>(soup.vertices.size());
    for (unsigned i = 0; i < mesh.mNumVertices; ++i) {
      const aiVector3D& v = mesh.mVertices[i];
      soup.vertices.push_back(X * Vector3(v.x, v.y, v.z));
    }
    for (unsigned i = 0; i < mesh.mNumFaces; ++i) {
      const aiFace& face = mesh.mFaces[i];
      if (face.mNumIndices != 3) continue;  // points and lines
      task.require_room(soup.triangles.size());
      for (unsigned k = 0; k < 3; ++k)
        if (face.mIndices[k] >= mesh.mNumVertices)
          task.fail_triangle(soup.triangles.size(), "vertex " + std::to_string(face.mIndices[k]) + " of " +
                                                        std::to_string(mesh.mNumVertices));
      soup.triangles.push_back(
          {first + face.mIndices[0], first + face.mIndices[1], first + face.mIndices[2]});
    }
  }

  void take_node(const aiNode& node, const Transform& X_parent, int level) {
    if (level > kMostLevels) task.fail("nodes more than 1000 deep");
    const Transform X = X_parent * Transform::of(node.mTransformation);
    for (unsigned i = 0; i < node.mNumMeshes; ++i) take_mesh(*scene.mMeshes[node.mMeshes[i]], X);
    for (unsigned i = 0; i < node.mNumChildren; ++i) take_node(*node.mChildren[i], X, level + 1);
  }
};

}  // namespace

Soup read_dae(const std::filesystem::path& file, std::string_view text, bool turn_up, const ReadTask& task) {
  require_finite_nodes(text, task);
  Assimp::Importer importer;
  importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, !turn_up);
  importer.SetProgressHandler(new Importing(task));  // which the importer owns
  const aiScene* scene = nullptr;
  try {
    scene = importer.ReadFile(file.string(), aiProcess_Triangulate);
  } catch (const std::exception& error) {
    task.fail(one_line(error.what()));
  }
  if (!scene || !scene->mRootNode || scene->mNumMeshes == 0)
    task.fail(scene ? "no mesh in it" : one_line(importer.GetErrorString()));
  // The unit, in single precision, is the root's scale.
  if (Transform::of(scene->mRootNode->mTransformation).A == Matrix3::Zero())
    task.fail("its unit, <unit meter=...>, is 0 m: a length > 0 is needed");
  SceneReader reader{*scene, task};
  reader.take_node(*scene->mRootNode, {}, 0);
  reader.soup.relative_rounding = kSinglePrecision;
  reader.soup.states_unit = true;
  if (turn_up)  // assimp turns what is up to y
    for (Vector3& v : reader.soup.vertices) v = Vector3(v.x(), -v.z(), v.y());
  return std::move(reader.soup);
}

}  // namespace mesh_files

bool reads_dae() { return true; }

}  // namespace touchstone
