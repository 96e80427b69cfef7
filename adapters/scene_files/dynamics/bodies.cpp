#include "touchstone/adapters/scene_files/dynamics/parts.hpp"

#include <algorithm>

#include "touchstone/contact_core/geometry/matrix3.hpp"
#include "touchstone/contact_core/input_error.hpp"

namespace touchstone::scene_files {
namespace {

using physics::BodyInertia;
using physics::BodyKind;
using physics::DynamicScene;
using physics::SceneBody;

Vector3 read_turn(const YamlReader& reader) { return reader.vector3() * reader.source().radians_per_angle; }

BodyInertia read_rod(const YamlReader& reader, double mass) {
  const std::vector<YamlReader> ends = reader.list();
  if (ends.size() != 2) reader.fail("expected two ends, got " + std::to_string(ends.size()));
  const Vector3 from = ends[0].length3(), to = ends[1].length3(), along = to - from;
  const Matrix3 I = mass / 12.0 * (dot(along, along) * Matrix3::Identity() - outer(along, along));
  return {mass, 0.5 * (from + to), I};
}

BodyInertia read_given(const YamlReader& reader, double mass) {
  BodyInertia out{mass, Vector3::Zero(), Matrix3::Zero()};
  if (reader.has("centre")) out.centre_B = reader.at("centre").length3();
  out.inertia_B.diagonal() = reader.at("moments").vector3();
  if (!reader.has("products")) return out;
  const Vector3 products = reader.at("products").vector3();
  out.inertia_B(0, 1) = out.inertia_B(1, 0) = products.x();
  out.inertia_B(0, 2) = out.inertia_B(2, 0) = products.y();
  out.inertia_B(1, 2) = out.inertia_B(2, 1) = products.z();
  return out;
}

BodyInertia read_inertia(const YamlReader& reader, const HexahedronTree& tree) {
  const std::string name = "object " + in_quotes(tree.name());
  if (reader.has("mass") == reader.has("density")) reader.fail("expected one of mass, density");
  if (reader.has("density")) {
    if (reader.has("inertia")) reader.fail("with a density the inertia is that of the hexahedra");
    return reader.at("density").bare().located(
        [&] { return physics::inertia_of_density(tree.solids(), reader.at("density").number(), name); });
  }
  const double mass = reader.at("mass").number();
  if (!reader.has("inertia")) {
    if (mass == 0.0) return {};  // of a link: validate_body() refuses it of others
    return reader.at("mass").bare().located(
        [&] { return physics::inertia_of_mass(tree.solids(), mass, name); });
  }
  const YamlReader inertia = reader.at("inertia");
  inertia.require_keys({"centre", "moments", "products", "rod", "point"});
  if (int{inertia.has("moments")} + int{inertia.has("rod")} + int{inertia.has("point")} != 1)
    inertia.fail("expected one of moments, rod, point");
  if (!inertia.has("moments") && (inertia.has("centre") || inertia.has("products")))
    inertia.fail("centre and products go with moments");
  if (inertia.has("rod")) return read_rod(inertia.at("rod"), mass);
  if (inertia.has("point")) return {mass, inertia.at("point").length3(), Matrix3::Zero()};
  return read_given(inertia, mass);
}

BodyKind read_kind(const YamlReader& reader, bool is_link) {
  if (!reader.has("kind")) {
    if (!is_link) reader.fail("missing 'kind'");
    return BodyKind::link;
  }
  const YamlReader kind = reader.at("kind");
  if (is_link) kind.fail("a joint moves it: it has no kind");
  for (const BodyKind each : {BodyKind::fixed, BodyKind::kinematic, BodyKind::dynamic})
    if (kind.text() == to_string(each)) return each;
  kind.fail("unknown kind " + in_quotes(kind.text()) + "; known: static, kinematic, dynamic");
}

/// An object; or those of a group, as copies are.
std::vector<std::size_t> read_objects(const YamlReader& reader, const Scene& scene) {
  const std::string name = reader.text();
  std::vector<std::size_t> objects;
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    const std::vector<std::string>& groups = scene.objects[i].groups;
    if (scene.objects[i].tree.name() == name || std::find(groups.begin(), groups.end(), name) != groups.end())
      objects.push_back(i);
  }
  if (objects.empty()) reader.fail("the scene has no object " + in_quotes(name));
  return objects;
}

void read_body(const YamlReader& item, std::size_t object, DynamicScene& out,
               std::vector<std::uint8_t>& is_listed) {
  const HexahedronTree& tree = out.scene.objects[object].tree;
  const YamlReader reader = called(item, "object " + in_quotes(tree.name()));
  if (is_listed[object] != 0) reader.fail("its body occurs twice");
  is_listed[object] = 1;
  SceneBody& body = out.bodies[object];
  body.where = where(item);
  body.kind = read_kind(reader, body.kind == BodyKind::link);
  read_surface(reader, body.surface);
  const bool has_mass = body.kind == BodyKind::dynamic || body.kind == BodyKind::link;
  if (has_mass) body.inertia = read_inertia(reader, tree);
  for (const char* key : {"mass", "density", "inertia"})
    if (!has_mass && reader.has(key))
      reader.at(key).fail("is not asked of what is " + std::string(to_string(body.kind)));
  for (const char* key : {"velocity", "turn"})
    if (body.kind != BodyKind::dynamic && reader.has(key))
      reader.at(key).fail(
          "only dynamic bodies start with one; kinematic ones have a motion, links joint rates");
  if (reader.has("velocity")) body.v_W = reader.at("velocity").length3();
  if (reader.has("turn")) body.w_W = read_turn(reader.at("turn"));
  physics::validate_body(out, object);
}

void read_rule(const YamlReader& reader, physics::Combination& rule) {
  std::string known;
  for (std::size_t i = 0; i < physics::kCombinations; ++i) {
    const auto each = static_cast<physics::Combination>(i);
    known += (known.empty() ? "" : ", ") + std::string(to_string(each));
    if (reader.text() != to_string(each)) continue;
    rule = each;
    return;
  }
  reader.fail("unknown rule " + in_quotes(reader.text()) + "; known: " + known);
}

}  // namespace

void read_surface(const YamlReader& reader, physics::Surface& surface) {
  if (reader.has("friction"))
    surface.friction = read_at_least_0(reader.at("friction"), reader.at("friction").number());
  if (!reader.has("restitution")) return;
  surface.restitution = reader.at("restitution").number();
  if (!(surface.restitution >= 0.0 && surface.restitution <= 1.0))
    reader.at("restitution").fail("must be from 0 to 1");
}

void read_bodies(const YamlReader& dynamics, DynamicScene& out) {
  std::vector<std::uint8_t> is_listed(out.bodies.size(), 0);
  if (dynamics.has("bodies"))
    for (const YamlReader& item : dynamics.at("bodies").list()) {
      item.require_keys(
          {"object", "kind", "mass", "density", "inertia", "velocity", "turn", "friction", "restitution"});
      for (const std::size_t object : read_objects(called(item, "dynamics: bodies").at("object"), out.scene))
        read_body(item, object, out, is_listed);
    }
  for (std::size_t i = 0; i < out.bodies.size(); ++i)
    if (out.bodies[i].kind == BodyKind::link && is_listed[i] == 0)
      dynamics.fail("object " + in_quotes(out.scene.objects[i].tree.name()) +
                    " is a link: 'bodies' does not tell its mass");
}

void read_pairs(const YamlReader& dynamics, DynamicScene& out) {
  if (dynamics.has("combine")) {
    const YamlReader rules = dynamics.at("combine");
    rules.require_keys({"friction", "restitution"});
    if (rules.has("friction")) read_rule(rules.at("friction"), out.friction_rule);
    if (rules.has("restitution")) read_rule(rules.at("restitution"), out.restitution_rule);
  }
  // Figures of pairs: every object of one name with every one of the other.
  if (!dynamics.has("pairs")) return;
  for (const YamlReader& item : dynamics.at("pairs").list()) {
    item.require_keys({"between", "friction", "restitution"});
    if (!item.has("friction") && !item.has("restitution"))
      item.fail("expected friction, restitution or both");
    const std::vector<YamlReader> names = item.at("between").list();
    if (names.size() != 2) item.at("between").fail("expected two objects or groups");
    physics::Surface surface;
    read_surface(item, surface);
    physics::ScenePair pair;
    pair.where = where(item);
    if (item.has("friction")) pair.friction = surface.friction;
    if (item.has("restitution")) pair.restitution = surface.restitution;
    const std::size_t before = out.pairs.size();
    const std::vector<std::size_t> second = read_objects(names[1], out.scene);
    for (const std::size_t a : read_objects(names[0], out.scene))
      for (const std::size_t b : second) {
        if (a == b) continue;
        pair.a = a, pair.b = b;
        out.pairs.push_back(pair);
      }
    if (out.pairs.size() == before) item.at("between").fail("an object is no pair with itself");
  }
}

}  // namespace touchstone::scene_files
