#include "touchstone/examples/station/flight/object_meshes.hpp"

#include <algorithm>
#include <bit>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>

#include "touchstone/adapters/mesh_files/mesh_file.hpp"
#include "touchstone/contact_core/input_error.hpp"

namespace touchstone::station {
namespace {

using nlohmann::json;

static_assert(std::endian::native == std::endian::little, "pages read little-endian");

template <class T>
void append(std::string& bytes, T value) {
  std::array<char, sizeof(T)> raw;
  std::memcpy(raw.data(), &value, sizeof(T));
  bytes.append(raw.data(), raw.size());
}

/// Three corners a triangle, so that each is shaded flat.
void append_corners(std::string& bytes, const ObjectMesh& part) {
  for (const auto& triangle : part.mesh->triangles)
    for (const std::uint32_t corner : triangle) {
      const Vector3 p_O = transform(part.X_OM, part.mesh->vertices[corner]);
      for (int axis = 0; axis < 3; ++axis) append(bytes, static_cast<float>(p_O[axis]));
    }
}

UpAxis read_up(const std::string& text) {
  if (const std::optional<UpAxis> up = up_axis_of(text)) return *up;
  throw InputError("up: '" + text + "' is none of as-written, stated, x, y, z");
}

ObjectMesh read_one(const json& from, const std::filesystem::path& folder, const training::Setting& setting) {
  const std::string name = from.at("object");
  ObjectMesh out{0, {}, nullptr};
  while (out.object < setting.object_count() && setting.object_name(out.object) != name) ++out.object;
  if (out.object == setting.object_count()) throw InputError("there is no object '" + name + "'");
  MeshFileOptions options;
  if (from.contains("metres_per_unit")) options.metres_per_unit = from.at("metres_per_unit").get<double>();
  if (from.contains("up")) options.up = read_up(from.at("up"));
  const std::filesystem::path mesh = folder / from.at("mesh").get<std::string>();
  out.mesh = std::make_shared<const TriangleMesh>(load_mesh(mesh, options).mesh);
  return out;
}

}  // namespace

ObjectMeshes place_meshes(const std::vector<ObjectMesh>& meshes) {
  ObjectMeshes out;
  std::vector<ObjectMesh> sorted = meshes;
  std::stable_sort(sorted.begin(), sorted.end(),
                   [](const ObjectMesh& a, const ObjectMesh& b) { return a.object < b.object; });
  std::string surfaces;
  for (auto first = sorted.begin(); first != sorted.end();) {
    const std::uint32_t object = first->object;
    const auto last =
        std::find_if(first, sorted.end(), [&](const ObjectMesh& part) { return part.object != object; });
    // An object's meshes are shown together or not at all.
    std::size_t triangles = 0;
    for (auto part = first; part != last; ++part) triangles += part->mesh->triangles.size();
    if (out.triangles + triangles > kMostTriangles) {
      out.left_out.push_back(object);
    } else {
      out.objects.push_back(object);
      out.triangles += triangles;
      append(surfaces, object);
      append(surfaces, static_cast<std::uint32_t>(triangles));
      for (auto part = first; part != last; ++part) append_corners(surfaces, *part);
    }
    first = last;
  }
  if (out.objects.empty()) return out;
  out.bytes = "TSM1";
  append(out.bytes, static_cast<std::uint32_t>(out.objects.size()));
  out.bytes += surfaces;
  return out;
}

std::vector<ObjectMesh> read_meshes(const std::filesystem::path& file, const training::Setting& setting) {
  std::vector<ObjectMesh> meshes;
  std::ifstream in(file);
  if (!in) return meshes;
  try {
    for (const json& mesh : json::parse(in)) meshes.push_back(read_one(mesh, file.parent_path(), setting));
  } catch (const json::exception& error) {
    throw InputError(file.string() + ": " + error.what());
  } catch (const InputError& error) {
    throw InputError(file.string() + ": " + error.what());
  }
  return meshes;
}

}  // namespace touchstone::station
