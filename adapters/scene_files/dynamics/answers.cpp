#include "touchstone/adapters/scene_files/dynamics/parts.hpp"

#include "touchstone/contact_core/geometry/constants.hpp"

namespace touchstone::scene_files {
namespace {

using physics::BodyKind;
using physics::DynamicScene;
using physics::SceneAnswer;

SceneAnswer::Figure read_figure(const YamlReader& reader) {
  std::string known;
  for (auto i = SceneAnswer::Figure::position; i <= SceneAnswer::Figure::stopped;
       i = static_cast<SceneAnswer::Figure>(static_cast<int>(i) + 1)) {
    if (reader.text() == to_string(i)) return i;
    known += (known.empty() ? "" : ", ") + std::string(to_string(i));
  }
  reader.fail("unknown figure " + in_quotes(reader.text()) + "; known: " + known);
}

/// SI figures for one of the file's.
double unit_of_figure(const SceneAnswer& answer, const DynamicScene& scene, const YamlSource& source) {
  using Figure = SceneAnswer::Figure;
  const double length = 1.0 / source.lengths_per_metre, angle = source.radians_per_angle;
  if (answer.figure == Figure::position || answer.figure == Figure::velocity) return length;
  if (answer.figure == Figure::angular_velocity) return angle;
  if (answer.figure == Figure::value || answer.figure == Figure::rate)
    return kind_of(scene, answer.joint) == JointKind::revolute ? angle : length;
  return 1.0;
}

}  // namespace

SceneAnswer read_answer(const YamlReader& item, const DynamicScene& scene) {
  item.require_keys({"of", "figure", "time", "value", "tolerance"});
  SceneAnswer answer;
  answer.where = where(item);
  // The figure decides whether an object or a joint is named.
  answer.figure = read_figure(item.at("figure"));
  if (answer.is_vector()) answer.object = read_object(item.at("of"), scene.scene);
  if (answer.is_of_joint()) answer.joint = read_joint_name(item.at("of"), scene);
  // Only dynamic bodies have velocities to be judged.
  const bool is_dynamic = answer.is_vector() && scene.bodies[answer.object].kind == BodyKind::dynamic;
  if ((answer.figure == SceneAnswer::Figure::velocity ||
       answer.figure == SceneAnswer::Figure::angular_velocity) &&
      !is_dynamic)
    item.at("of").fail("is not dynamic: it has no such figure");
  // Figures are those at the end, unless a time is given.
  const bool is_a_time =
      answer.figure == SceneAnswer::Figure::moved || answer.figure == SceneAnswer::Figure::stopped;
  answer.time = scene.scene.duration;
  if (item.has("time")) {
    if (is_a_time) item.at("time").fail("the figure is a time itself");
    answer.time = item.at("time").number();
    if (!(answer.time > 0.0 && answer.time <= scene.scene.duration))
      item.at("time").fail("is not within the scene's duration");
  }
  // Value and tolerance are in the file's units.
  const double unit = unit_of_figure(answer, scene, item.source());
  if (answer.is_vector())
    answer.value = unit * item.at("value").vector3();
  else
    answer.value.x() = unit * item.at("value").number();
  answer.tolerance = unit * read_positive(item.at("tolerance"), item.at("tolerance").number());
  return answer;
}

void read_conserved(const YamlReader& reader, DynamicScene& out) {
  for (const YamlReader& item : reader.list()) {
    const std::string& what = item.text();
    if (what == "momentum") {
      out.conserved.linear = true;
    } else if (what == "angular_momentum") {
      out.conserved.angular = {true, true, true};
    } else if (what == "energy") {
      out.conserved.energy = true;
    } else if (what.starts_with("angular_momentum_") && what.size() == 18 && what[17] >= 'x' &&
               what[17] <= 'z') {
      out.conserved.angular[static_cast<std::size_t>(what[17] - 'x')] = true;
    } else {
      item.fail("unknown " + in_quotes(what) +
                "; known: momentum, angular_momentum, angular_momentum_x, _y, _z, energy");
    }
  }
}

void read_accept(const YamlReader& reader, DynamicScene& out) {
  reader.require_keys({"depth", "position", "angle", "energy_made", "drift", "rest"});
  const auto read = [&](const char* key, double unit, double& value) {
    if (!reader.has(key)) return;
    const bool is_any = reader.at(key).node().IsScalar() && reader.at(key).node().Scalar() == "any";
    value = is_any ? kInfinity : unit * read_at_least_0(reader.at(key), reader.at(key).number());
  };
  const double length = 1.0 / reader.source().lengths_per_metre;
  read("depth", length, out.accept.depth);
  read("position", length, out.accept.position);
  read("angle", reader.source().radians_per_angle, out.accept.angle);
  read("energy_made", 1.0, out.accept.energy_made);
  read("drift", 1.0, out.accept.drift);
  read("rest", length, out.accept.rest);
}

}  // namespace touchstone::scene_files
