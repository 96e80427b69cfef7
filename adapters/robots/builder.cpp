#include "touchstone/adapters/robots/builder.hpp"

#include <cmath>

#include "touchstone/adapters/robots/enclosing_box.hpp"
#include "touchstone/adapters/robots/mesh_path.hpp"
#include "touchstone/adapters/robots/shapes.hpp"
#include "touchstone/contact_core/fit/mesh_distance.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/contact_core/mechanism/round_parts.hpp"

namespace touchstone {
namespace {

/// Runs `action`; what it throws gets the place in front.
template <class Action>
auto at(const ShapePlace& place, const Action& action) {
  try {
    return action();
  } catch (const InputError& error) {
    const std::string what = error.what();
    throw InputError(what.starts_with(place.label) ? what : place.label + ": " + what);
  }
}

double size_of(const TriangleMesh& mesh) {
  Bounds bounds;
  for (const auto& t : mesh.triangles)
    for (const std::uint32_t i : t) bounds.add(mesh.vertices[i]);
  return mesh.triangles.empty() ? 0.0 : bounds.diagonal();
}

Pose with_rounded_frame(const Pose& X_LS, const Pose& X_SH) { return rigid_frame(compose(X_LS, X_SH)); }

}  // namespace

std::size_t RobotBuilder::add_link(const std::string& name) {
  robot_->mechanism.links.push_back({name, {}, {}});
  return robot_->mechanism.links.size() - 1;
}

std::string RobotBuilder::unique_name(std::size_t link, const std::string& wanted) {
  std::set<std::string>& taken = names_[link];
  std::string name = wanted;
  for (int i = 2; !taken.insert(name).second; ++i) name = wanted + "." + std::to_string(i);
  return name;
}

void RobotBuilder::add_box(const ShapePlace& place, const Vector3& size) {
  at(place, [&] {
    robot_->mechanism.links[place.link].solids.push_back(
        {unique_name(place.link, place.name), Hexahedron::from_size(size, place.label), place.X_LS});
  });
}

template <class Make>
void RobotBuilder::add_round(const ShapePlace& place, const char* shape, const Make& make) {
  at(place, [&] {
    const std::string name = unique_name(place.link, place.name);
    RoundPart part = make(name);
    for (PlacedHexahedron& slice : part.solids) slice.name = unique_name(place.link, slice.name);
    robot_->replaced.push_back({robot_->mechanism.links[place.link].name, name, shape, "", 0,
                                part.solids.size(), part.figures[0].error});
    append(std::move(part), place.link, robot_->mechanism);
  });
}

void RobotBuilder::add_cylinder(const ShapePlace& place, double radius, double length) {
  add_round(place, "cylinder", [&](const std::string& name) {
    Pose X_LS = place.X_LS;
    X_LS.p = transform(X_LS, {0.0, 0.0, -0.5 * length});
    return make_cylinder(radius, length, options_->cylinder_facets, options_->cylinder_inscribed, X_LS, name);
  });
}

void RobotBuilder::add_rounded(const ShapePlace& place, const char* shape, const Hexahedron& solid) {
  const std::string name = unique_name(place.link, place.name);
  LinkDescription& link = robot_->mechanism.links[place.link];
  link.solids.push_back({name, solid, place.X_LS});
  robot_->replaced.push_back({link.name, name, shape, "", 0, 1, 0.0});
}

void RobotBuilder::add_sphere(const ShapePlace& place, double radius) {
  if (options_->sphere_facets == 0)
    return at(place, [&] { add_rounded(place, "sphere", Hexahedron::sphere(radius, place.label)); });
  add_round(place, "sphere", [&](const std::string& name) {
    return make_sphere(radius, options_->sphere_facets, place.X_LS, name);
  });
}

void RobotBuilder::add_capsule(const ShapePlace& place, double radius, double length) {
  if (options_->sphere_facets == 0)
    return at(place,
              [&] { add_rounded(place, "capsule", Hexahedron::capsule(radius, length, place.label)); });
  add_round(place, "capsule", [&](const std::string& name) {
    return make_capsule(radius, length, options_->sphere_facets, place.X_LS, name);
  });
}

void RobotBuilder::add_ellipsoid(const ShapePlace& place, const Vector3& half_axes) {
  add_round(place, "ellipsoid", [&](const std::string& name) {
    return make_ellipsoid(half_axes, options_->ellipsoid_facets, place.X_LS, name);
  });
}

RobotBuilder::Loaded RobotBuilder::made_of(TriangleMesh mesh, const std::string& name) const {
  Loaded out{options_->cover_mesh ? options_->cover_mesh(mesh, name) : enclosing_box(mesh, name),
             mesh.triangles.size(), size_of(mesh), nullptr};
  if (options_->keep_meshes) out.mesh = std::make_shared<const TriangleMesh>(std::move(mesh));
  return out;
}

RobotBuilder::Loaded RobotBuilder::load(const std::filesystem::path& file, const Vector3& scale) {
  const auto key = std::make_tuple(file.string(), scale.x(), scale.y(), scale.z());
  if (const auto found = loaded_.find(key); found != loaded_.end()) return found->second;
  MeshFileOptions options;
  options.metres_per_unit = 1.0;  // URDF's and SDF's unit; another one is in the scale
  LoadedMesh loaded = load_mesh(file, options);
  for (Vector3& v : loaded.mesh.vertices) {
    v = v.cwiseProduct(scale);
    if (!is_finite(v)) throw InputError(file.string() + ": its scaled coordinates are not finite");
  }
  if (scale.x() * scale.y() * scale.z() < 0.0)  // mirrored: what was outside is inside
    for (auto& t : loaded.mesh.triangles) std::swap(t[1], t[2]);
  if (!loaded.report.bounds_a_solid() || !loaded.report.triangles_turned.empty())
    robot_->notes.push_back(file.string() + ": " + to_string(loaded.report));
  return loaded_.emplace(key, made_of(std::move(loaded.mesh), file.filename().string())).first->second;
}

void RobotBuilder::add_cover(const ShapePlace& place, const Loaded& loaded, const std::string& file) {
  const std::string name = unique_name(place.link, place.name);
  LinkDescription& link = robot_->mechanism.links[place.link];
  std::size_t index = 0;
  std::vector<std::string> names;
  for (const PlacedHexahedron& part : loaded.cover.solids) {
    const std::string part_name = loaded.cover.solids.size() == 1
                                      ? name
                                      : unique_name(place.link, name + "." + std::to_string(index++));
    link.solids.push_back({part_name, part.solid, with_rounded_frame(place.X_LS, part.X_OS)});
    names.push_back(part_name);
  }
  robot_->replaced.push_back({link.name, name, "mesh", file, loaded.triangles, loaded.cover.solids.size(),
                              loaded.cover.error, loaded.size});
  if (loaded.mesh) robot_->meshes.push_back({link.name, place.X_LS, loaded.mesh, std::move(names)});
}

void RobotBuilder::add_mesh_file(const ShapePlace& place, const std::string& uri, const Vector3& scale) {
  at(place, [&] {
    for (int i = 0; i < 3; ++i)
      if (!(std::isfinite(scale[i]) && scale[i] != 0.0))
        throw InputError("mesh '" + uri + "': a scale of " + figure(scale[i]));
    const std::filesystem::path file = mesh_path(uri, source_, options_->package_paths);
    add_cover(place, load(file, scale), file.string());
  });
}

void RobotBuilder::add_mesh(const ShapePlace& place, TriangleMesh mesh, const std::string& file) {
  at(place, [&] { add_cover(place, made_of(std::move(mesh), file), file); });
}

std::string to_string(const ShapeReplacement& r) {
  std::string out = r.link + "/" + r.name + ": " + r.shape;
  if (!r.file.empty()) out += " " + r.file + ", " + std::to_string(r.triangles) + " triangles";
  if (r.shape != "mesh" && r.hexahedra == 1 && r.error == 0.0) return out + ", is one rounded solid, exactly";
  return out + ", is " + std::to_string(r.hexahedra) + (r.hexahedra == 1 ? " hexahedron" : " hexahedra") +
         ", off by up to " + figure(r.error) + " m";
}

}  // namespace touchstone
