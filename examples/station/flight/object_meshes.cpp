#include "touchstone/examples/station/flight/object_meshes.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>

#include "touchstone/adapters/mesh_files/mesh_file.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/examples/station/flight/bytes.hpp"

namespace touchstone::station {
namespace {

using nlohmann::json;

static_assert(std::endian::native == std::endian::little, "pages read little-endian");

/// Three corners a triangle, so that each is shaded flat.
void append_corners(std::string& bytes, const ObjectMesh& part) {
  for (const auto& triangle : part.mesh->triangles)
    for (const std::uint32_t corner : triangle) {
      const Vector3 p_O = transform(part.X_OM, part.mesh->vertices[corner]);
      for (int axis = 0; axis < 3; ++axis) append(bytes, static_cast<float>(p_O[axis]));
    }
}

bool is_near(const TriangleMesh& mesh) {
  return std::all_of(mesh.vertices.begin(), mesh.vertices.end(),
                     [](const Vector3& vertex) { return vertex.cwiseAbs().maxCoeff() <= kFarthestCorner; });
}

constexpr std::array<std::string_view, 4> kKeys = {"object", "mesh", "metres_per_unit", "up"};

UpAxis read_up(const std::string& text) {
  if (const std::optional<UpAxis> up = up_axis_of(text)) return *up;
  throw InputError("up: '" + text + "' is none of as-written, stated, x, y, z");
}

std::uint32_t find_object(const std::string& name, const training::Setting& setting) {
  for (std::uint32_t i = 0; i < setting.object_count(); ++i)
    if (setting.object_name(i) == name) return i;
  throw InputError("there is no object '" + name + "'");
}

/// Without a mesh where its file is not there.
ObjectMesh read_one(const json& from, const std::filesystem::path& folder, const training::Setting& setting) {
  for (const auto& [key, value] : from.items())
    if (std::find(kKeys.begin(), kKeys.end(), key) == kKeys.end())
      throw InputError("unknown field '" + key + "'");
  ObjectMesh out{find_object(from.at("object"), setting), {}, nullptr};
  MeshFileOptions options;
  if (from.contains("metres_per_unit")) options.metres_per_unit = from.at("metres_per_unit").get<double>();
  if (from.contains("up")) options.up = read_up(from.at("up"));
  const std::filesystem::path file = folder / from.at("mesh").get<std::string>();
  std::error_code error;
  if (!std::filesystem::exists(file, error)) return out;
  TriangleMesh mesh = load_mesh(file, options).mesh;
  if (!is_near(mesh)) throw InputError(file.string() + ": a vertex is further than 1e15 m from the origin");
  out.mesh = std::make_shared<const TriangleMesh>(std::move(mesh));
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
    const bool fits = out.triangles + triangles <= kMostTriangles &&
                      std::all_of(first, last, [](const ObjectMesh& part) { return is_near(*part.mesh); });
    if (!fits) {
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
  out.path = "meshes/" + hash_of(out.bytes);
  return out;
}

std::vector<ObjectMesh> read_meshes(const std::filesystem::path& file, const training::Setting& setting,
                                    const std::function<void(const std::string&)>& on_missing) {
  std::vector<ObjectMesh> meshes;
  std::error_code unknown;
  if (!std::filesystem::exists(file, unknown)) return meshes;
  // Every entry names another object; an entry without a file is reported and left out.
  std::ifstream in(file);
  std::vector<std::uint32_t> listed;
  try {
    if (!in || std::filesystem::is_directory(file, unknown)) throw InputError("cannot be read");
    const json list = json::parse(in);
    if (!list.is_array()) throw InputError("is no list");
    for (const json& each : list) {
      ObjectMesh mesh = read_one(each, file.parent_path(), setting);
      if (std::find(listed.begin(), listed.end(), mesh.object) != listed.end())
        throw InputError("'" + setting.object_name(mesh.object) + "' stands twice");
      listed.push_back(mesh.object);
      if (mesh.mesh)
        meshes.push_back(std::move(mesh));
      else if (on_missing)
        on_missing(file.string() + ": there is no file " + each.at("mesh").get<std::string>() +
                   ": the hexahedra of '" + setting.object_name(mesh.object) + "' are shown\n");
    }
  } catch (const json::exception& error) {
    throw InputError(file.string() + ": " + error.what());
  } catch (const InputError& error) {
    throw InputError(file.string() + ": " + error.what());
  }
  return meshes;
}

}  // namespace touchstone::station
