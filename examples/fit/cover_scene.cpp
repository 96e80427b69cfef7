#include "touchstone/examples/fit/cover_scene.hpp"
#include "touchstone/examples/program/files/json.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

namespace touchstone::fitting {
namespace {

// YAML reads JSON's strings. What is no UTF-8 is replaced.
std::string quote(const std::string& text) { return program::one_line(nlohmann::json(text)); }

/// @param indent of the list.
std::string hexahedron_text(const std::string& name, const std::array<Vector3, 8>& vertices,
                            const std::string& indent) {
  std::string text = fmt::format("{0}- name: {1}\n{0}  hexahedron:\n{0}    vertices:\n", indent, name);
  for (const Vector3& p : vertices)
    text += fmt::format("{}      - [{}, {}, {}]\n", indent, p.x(), p.y(), p.z());
  return text;
}

}  // namespace

std::string scene_text(const Fit& fit, const std::string& name, const std::string& description,
                       double duration, std::span<const CoarserLevel> levels) {
  const std::string quoted = quote(name);
  std::string text = fmt::format(
      "name: {}\ndescription: {}\nunits: {{length: m}}\nframe_rate: 50\ncontact_gap: 1.0e-6\npolicy: "
      "advance\n"
      "duration: {}\nobjects:\n  - name: {}\n    static: true\n    hexahedra:\n",
      quoted, quote(description), duration, quoted);
  for (std::size_t i = 0; i < fit.hexahedra.size(); ++i)
    text += hexahedron_text(fmt::format("h{}", i), fit.hexahedra[i].vertices, "      ");
  if (!levels.empty()) text += "    levels:\n";
  for (const CoarserLevel& level : levels) {
    text += fmt::format("      -  # no point is farther outside than {:.6g} m\n", level.excess);
    for (const PlacedHexahedron& placed : level.tree->solids())
      text += hexahedron_text(placed.name, placed.solid.vertices(), "        ");
  }
  return text;
}

}  // namespace touchstone::fitting
