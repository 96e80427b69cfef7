#include "touchstone/adapters/scene_files/scene_file.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <set>

#include "touchstone/adapters/scene_files/facets.hpp"
#include "touchstone/adapters/scene_files/scene_head.hpp"
#include "touchstone/contact_core/geometry/quaternion.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/contact_core/scene/scene_instance.hpp"
#include "touchstone/contact_core/world/contact_world.hpp"

namespace touchstone {
namespace {

using scene_files::in_quotes;
using scene_files::read_positive;
using scene_files::YamlReader;
using scene_files::YamlSource;

Matrix3 read_rotation(const YamlReader& reader) {
  if (reader.has("quaternion_wxyz")) {
    const YamlReader quaternion = reader.at("quaternion_wxyz");
    const std::vector<double> q = quaternion.numbers(4);
    return reader.located(
        [&] { return rotation_from_quaternion(q[0], q[1], q[2], q[3], "quaternion_wxyz"); });
  }
  Vector6 position = Vector6::Zero();
  if (reader.has("rpy")) position.tail<3>() = reader.at("rpy").vector3() * reader.source().radians_per_angle;
  return pose_from_position_vector(position).R;
}

Pose read_matrix(const YamlReader& reader) {
  const std::vector<YamlReader> rows = reader.list();
  if (rows.size() != 4) reader.fail("expected 4 rows, got " + std::to_string(rows.size()));
  Matrix4 X;
  for (int row = 0; row < 4; ++row) {
    const std::vector<double> values = rows[row].numbers(4);
    for (int column = 0; column < 4; ++column) X(row, column) = values[column];
  }
  X.topRightCorner<3, 1>() /= reader.source().lengths_per_metre;
  return reader.located([&] { return pose_from_matrix(X, "pose"); });
}

Pose read_pose(const YamlReader& reader) {
  reader.require_keys({"position", "rpy", "quaternion_wxyz", "matrix"});
  const int rotations =
      int{reader.has("rpy")} + int{reader.has("quaternion_wxyz")} + int{reader.has("matrix")};
  if (rotations > 1 || (reader.has("matrix") && reader.has("position")))
    reader.fail("give position with rpy or quaternion_wxyz, or matrix alone");
  if (reader.has("matrix")) return read_matrix(reader.at("matrix"));
  Pose X;
  if (reader.has("position")) X.p = reader.at("position").length3();
  X.R = read_rotation(reader);
  return X;
}

WarpPolicy read_warp(const YamlReader& choice) {
  if (choice.text() == "refuse") return WarpPolicy::refuse;
  if (choice.text() == "within_tolerance") return WarpPolicy::within_tolerance;
  if (choice.text() == "accept") return WarpPolicy::accept;
  choice.fail("unknown choice " + in_quotes(choice.text()) + "; known: refuse, within_tolerance, accept");
}

Hexahedron read_vertices(const YamlReader& reader, const std::string& name) {
  reader.require_keys({"vertices", "warped"});
  std::vector<Vector3> vertices;
  for (const YamlReader& vertex : reader.at("vertices").list()) vertices.push_back(vertex.length3());
  const WarpPolicy warp =
      reader.has("warped") ? read_warp(reader.at("warped")) : WarpPolicy::within_tolerance;
  return Hexahedron::from_vertices(vertices, warp, "hexahedron " + in_quotes(name));
}

std::pair<double, double> read_half_widths(const YamlReader& reader) {
  if (!reader.node().IsSequence()) return {reader.length(), reader.length()};
  const std::vector<double> v = reader.numbers(2);
  return {v[0] / reader.source().lengths_per_metre, v[1] / reader.source().lengths_per_metre};
}

PlacedHexahedron read_frustum(const YamlReader& reader, const Pose& X_OS, const std::string& name) {
  reader.require_keys({"bottom", "top", "height"});
  const auto [bottom_x, bottom_y] = read_half_widths(reader.at("bottom"));
  const auto [top_x, top_y] = read_half_widths(reader.at("top"));
  return scene_files::make_frustum({bottom_x, bottom_y, top_x, top_y, reader.at("height").length()}, X_OS,
                                   name);
}

scene_files::RingSize read_ring(const YamlReader& reader) {
  reader.require_keys({"outer_radius", "inner_radius", "height", "facets", "radius"});
  const YamlReader radius = reader.at("radius");
  const std::string convention = radius.text();
  if (convention != "inscribed" && convention != "circumscribed")
    radius.fail("unknown convention " + in_quotes(convention) + "; known: inscribed, circumscribed");
  return {reader.at("outer_radius").length(), reader.at("inner_radius").length(),
          reader.at("height").length(), reader.at("facets").integer(), convention == "inscribed"};
}

scene_files::WallsSize read_walls(const YamlReader& reader) {
  reader.require_keys({"inner_size", "thickness", "open"});
  scene_files::WallsSize size{reader.at("inner_size").length3(), reader.at("thickness").length(), {}};
  if (!reader.has("open")) return size;
  const std::array<std::string, 6> sides = {"-x", "+x", "-y", "+y", "-z", "+z"};
  for (const YamlReader& item : reader.at("open").list()) {
    const auto side = std::find(sides.begin(), sides.end(), item.text());
    if (side == sides.end())
      item.fail("unknown side " + in_quotes(item.text()) + "; known: -x, +x, -y, +y, -z, +z");
    size.open.push_back(static_cast<int>(side - sides.begin()));
  }
  return size;
}

// The parts that one object's `hexahedra` list is read into.
struct ObjectParts {
  std::string object;
  std::vector<PlacedHexahedron> solids;
  std::vector<FacetFigure> facet_figures;
};

/// Spheres, capsules, boxes with a radius all round.
Hexahedron read_rounded(const YamlReader& shape, const std::string& kind, const std::string& name) {
  const std::string label = "hexahedron " + in_quotes(name);
  if (kind == "sphere") {
    shape.require_keys({"radius"});
    return Hexahedron::sphere(shape.at("radius").length(), label);
  }
  if (kind == "capsule") {
    shape.require_keys({"radius", "length"});
    return Hexahedron::capsule(shape.at("radius").length(), shape.at("length").length(), label);
  }
  shape.require_keys({"core_size", "radius"});
  return Hexahedron::rounded_box(shape.at("core_size").length3(), shape.at("radius").length(), label);
}

void add_ring(const YamlReader& reader, const Pose& X_OS, const std::string& name, ObjectParts& parts) {
  RoundPart ring = scene_files::make_ring(read_ring(reader), X_OS, name);
  for (PlacedHexahedron& facet : ring.solids) parts.solids.push_back(std::move(facet));
  for (FacetFigure& figure : ring.figures) {
    figure.object = parts.object;
    parts.facet_figures.push_back(std::move(figure));
  }
}

void add_solids(const YamlReader& part, const std::string& kind, const std::string& name,
                ObjectParts& parts) {
  const YamlReader named = part.within("hexahedron " + in_quotes(name));
  const Pose X_OS = part.has("pose") ? read_pose(named.at("pose")) : Pose{};
  const YamlReader shape = named.at(kind);
  if (kind == "box") {
    shape.require_keys({"size"});
    parts.solids.push_back(
        {name, Hexahedron::from_size(shape.at("size").length3(), "hexahedron " + in_quotes(name)), X_OS});
  } else if (kind == "hexahedron") {
    parts.solids.push_back({name, read_vertices(shape, name), X_OS});
  } else if (kind == "frustum") {
    parts.solids.push_back(read_frustum(shape, X_OS, name));
  } else if (kind == "ring") {
    add_ring(shape, X_OS, name, parts);
  } else if (kind == "sphere" || kind == "capsule" || kind == "rounded_box") {
    parts.solids.push_back({name, read_rounded(shape, kind, name), X_OS});
  } else {
    for (PlacedHexahedron& wall : scene_files::make_walls(read_walls(shape), X_OS, name))
      parts.solids.push_back(std::move(wall));
  }
}

void read_part(const YamlReader& part, std::set<std::string>& names, ObjectParts& parts) {
  constexpr std::array<const char*, 8> kKinds = {"box",   "hexahedron", "frustum", "ring",
                                                 "walls", "sphere",     "capsule", "rounded_box"};
  part.require_keys(
      {"name", "pose", "box", "hexahedron", "frustum", "ring", "walls", "sphere", "capsule", "rounded_box"});
  const std::string name = part.at("name").text();
  const YamlReader named = part.within("hexahedron " + in_quotes(name));
  if (name.empty()) part.fail("a hexahedron's name is empty");
  std::vector<std::string> kinds;
  for (const char* kind : kKinds)
    if (part.has(kind)) kinds.emplace_back(kind);
  if (kinds.size() != 1)
    named.fail(
        "needs exactly one of box, hexahedron, frustum, ring, walls, sphere, capsule, rounded_box; has " +
        std::to_string(kinds.size()));
  const std::size_t first = parts.solids.size();
  try {
    add_solids(part, kinds[0], name, parts);
  } catch (const InputError& error) {
    // Located errors start with the file; the core's own start with the hexahedron and get this part's line.
    if (std::string_view(error.what()).substr(0, part.source().file.size() + 1) == part.source().file + ":")
      throw;
    part.fail(error.what());
  }
  for (std::size_t i = first; i < parts.solids.size(); ++i)
    if (!names.insert(parts.solids[i].name).second) named.fail("the name occurs twice in the object");
}

MotionSegment read_segment(const YamlReader& reader, double scene_duration) {
  reader.require_keys({"start", "duration", "velocity", "rotation"});
  MotionSegment segment;
  if (reader.has("start")) segment.start = reader.at("start").number();
  segment.duration = reader.has("duration") ? reader.at("duration").number() : scene_duration - segment.start;
  if (reader.has("velocity")) segment.velocity_W = reader.at("velocity").length3();
  if (!reader.has("rotation")) return segment;
  const YamlReader rotation = reader.at("rotation");
  rotation.require_keys({"axis", "rate", "pivot"});
  const Vector3 axis = rotation.at("axis").vector3();
  if (norm(axis) == 0.0) rotation.at("axis").fail("the axis is zero");
  segment.axis_W = axis / norm(axis);
  segment.rate = rotation.at("rate").angle();
  if (rotation.has("pivot")) segment.pivot_W = rotation.at("pivot").length3();
  return segment;
}

Motion read_motion(const YamlReader& reader, double scene_duration, const std::string& object) {
  reader.require_keys({"segments", "keys"});
  Motion motion;
  if (reader.has("segments"))
    for (const YamlReader& item : reader.at("segments").list())
      motion.segments.push_back(read_segment(item, scene_duration));
  if (reader.has("keys")) {
    for (const YamlReader& item : reader.at("keys").list()) {
      item.require_keys({"time", "pose"});
      motion.keys.push_back({item.at("time").number(), read_pose(item.at("pose"))});
    }
  }
  reader.bare().located([&] { validate_motion(motion, "object " + in_quotes(object)); });
  return motion;
}

/// Each a list of hexahedra, whose parts are read as the object's own.
std::vector<std::shared_ptr<const HexahedronTree>> read_levels(const YamlReader& reader,
                                                               const HexahedronTree& tree) {
  std::vector<std::shared_ptr<const HexahedronTree>> levels;
  for (const YamlReader& level : reader.list()) {
    ObjectParts parts{tree.name(), {}, {}};
    std::set<std::string> names;
    for (const YamlReader& part : level.list()) read_part(part, names, parts);
    if (parts.solids.empty()) level.fail("no hexahedron");
    levels.push_back(std::make_shared<HexahedronTree>(std::move(parts.solids), tree.name()));
  }
  reader.bare().located([&] { validate_levels(tree, levels); });
  return levels;
}

SceneObject read_object(const YamlReader& item, double scene_duration, std::set<std::string>& names,
                        Scene& scene) {
  const std::string name = item.has("name") ? item.at("name").text() : "";
  const YamlReader reader = name.empty() ? item : item.within("object " + in_quotes(name));
  reader.require_keys({"name", "pose", "groups", "hexahedra", "motion", "copies", "static", "levels"});
  if (name.empty()) reader.fail("object without a name");
  if (!names.insert(name).second) reader.fail("the name occurs twice");
  ObjectParts parts{name, {}, {}};
  std::set<std::string> part_names;
  const YamlReader hexahedra(reader.at("hexahedra").node(), reader.source(),
                             "object " + in_quotes(name) + ": ");
  for (const YamlReader& part : hexahedra.list()) read_part(part, part_names, parts);
  if (parts.solids.empty()) hexahedra.fail("no hexahedron");
  SceneObject object{HexahedronTree(std::move(parts.solids), name), {}, {}, {}};
  if (reader.has("pose")) object.X_WO = read_pose(reader.at("pose"));
  if (reader.has("motion")) object.motion = read_motion(reader.at("motion"), scene_duration, name);
  if (reader.has("groups"))
    for (const YamlReader& group : reader.at("groups").list()) object.groups.push_back(group.text());
  if (reader.has("static")) object.is_static = scene_files::read_choice(reader.at("static"));
  if (reader.has("levels")) object.levels = read_levels(reader.at("levels"), object.tree);
  for (FacetFigure& figure : parts.facet_figures) scene.facet_figures.push_back(std::move(figure));
  return object;
}

/// A number from -1 to 1, the same everywhere (SplitMix64, Steele and others 2014).
double draw(std::uint64_t& state) {
  state += 0x9e3779b97f4a7c15;
  std::uint64_t z = state;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9;
  z = (z ^ (z >> 27)) * 0x94d049bb133111eb;
  z ^= z >> 31;
  return 2.0 * (static_cast<double>(z >> 11) * 0x1p-53) - 1.0;
}

struct Copies {
  std::array<int, 3> count;
  Vector3 spacing, layer_shift;  // a layer further along z is shifted by that
  int layer_less;                // copies along x that it has less
  bool is_turned;                // by up to 1 rad about each axis
  std::uint64_t seed;
};

constexpr int kMostCopies = 100000;

Copies read_copies(const YamlReader& reader) {
  reader.require_keys({"count", "spacing", "layer_less", "layer_shift", "turned"});
  Copies copies{{1, 1, 1}, reader.at("spacing").length3(), Vector3::Zero(), 0, reader.has("turned"), 0};
  const std::vector<double> count = reader.at("count").numbers(3);
  double all = 1.0;
  for (std::size_t i = 0; i < 3; ++i) {
    if (!(count[i] >= 1.0) || count[i] != std::floor(count[i]))
      reader.at("count").fail("must be whole and >= 1");
    all *= count[i];
    if (all > kMostCopies) reader.at("count").fail("more than 100 000 copies");
    copies.count[i] = static_cast<int>(count[i]);
  }
  if (reader.has("layer_less")) copies.layer_less = reader.at("layer_less").integer();
  if (copies.layer_less < 0) reader.at("layer_less").fail("must be >= 0");
  if (reader.has("layer_shift")) copies.layer_shift = reader.at("layer_shift").length3();
  if (reader.has("turned")) copies.seed = static_cast<std::uint64_t>(reader.at("turned").integer());
  return copies;
}

/// `box` becomes `box 0`, `box 1` ... in a group `box`, along x first, then y, then z.
void add_copies(const YamlReader& reader, const SceneObject& object, std::set<std::string>& names,
                Scene& scene) {
  Copies copies = read_copies(reader);
  if (!object.motion.at_rest()) reader.fail("what has a motion has no copies");
  // Cell by cell; upper layers have fewer cells along x.
  int number = 0;
  for (int z = 0; z < copies.count[2]; ++z)
    for (int y = 0; y < copies.count[1]; ++y)
      for (int x = 0; x < copies.count[0] - z * copies.layer_less; ++x) {
        // A copy has its own name and its original's groups.
        const std::string name = object.tree.name() + " " + std::to_string(number++);
        if (!names.insert(name).second) reader.fail("the name " + in_quotes(name) + " occurs twice");
        SceneObject copy{HexahedronTree(object.tree.solids(), name),
                         object.X_WO,
                         object.motion,
                         object.groups,
                         object.is_static,
                         object.levels};
        copy.groups.push_back(object.tree.name());
        // It is placed in its cell, and turned at random where that is asked for.
        const Vector3 cell(x, y, z);
        copy.X_WO.p += copies.spacing.cwiseProduct(cell) + z * copies.layer_shift;
        if (copies.is_turned) {
          const double a = draw(copies.seed), b = draw(copies.seed), c = draw(copies.seed);
          copy.X_WO.R = rotation_matrix(quaternion_of_turn({a, b, c})) * copy.X_WO.R;
        }
        scene.objects.push_back(std::move(copy));
      }
}

Scene read_scene(const YamlReader& root, YamlSource& source, const SceneParameters& parameters) {
  // Keys of dynamics are read by programs that have any (dynamics_file.hpp).
  root.require_keys({"name", "description", "units", "parameters", "frame_rate", "contact_gap", "policy",
                     "passive", "duration", "objects", "rules", "exempt", "latches", "dynamics"});
  // Units and parameters come first: what follows is read by them.
  Scene scene;
  scene.units = scene_files::read_units(root, source);
  scene_files::read_parameters(root, parameters, source);
  scene.parameters = source.parameters;
  // Figures of the whole scene.
  scene.name = root.at("name").text();
  if (root.has("description")) scene.description = root.at("description").text();
  scene.frame_rate = read_positive(root.at("frame_rate"), root.at("frame_rate").number());
  scene.contact_gap = read_positive(root.at("contact_gap"), root.at("contact_gap").length());
  scene.duration = read_positive(root.at("duration"), root.at("duration").number());
  scene.policy = scene_files::read_policy(root.at("policy"));
  if (root.has("passive")) scene.passive = scene_files::read_passive(root.at("passive"));
  // Objects, each perhaps with copies.
  std::set<std::string> names;
  const YamlReader objects(root.at("objects").node(), source);
  for (const YamlReader& item : objects.list()) {
    SceneObject object = read_object(item, scene.duration, names, scene);
    if (item.has("copies"))
      add_copies(item.at("copies"), object, names, scene);
    else
      scene.objects.push_back(std::move(object));
  }
  // Rules, exemptions and latches name objects, so they come after them.
  if (root.has("rules")) scene.rules = scene_files::read_rules(root.at("rules"), scene);
  if (root.has("exempt")) scene.exempt_pairs = scene_files::read_exempt_pairs(root.at("exempt"), scene);
  if (root.has("latches")) scene_files::read_latches(root.at("latches"), scene);
  return scene;
}

}  // namespace

Scene load_scene(const std::filesystem::path& path, const SceneParameters& parameters) {
  YamlSource source;
  source.file = path.string();
  const YAML::Node document = scene_files::parse_yaml(path);
  const YamlReader root(document, source);
  Scene scene = read_scene(root, source, parameters);
  try {
    validate(scene);
  } catch (const InputError& error) {
    throw InputError(source.file + ": " + error.what());
  }
  return scene;
}

}  // namespace touchstone
