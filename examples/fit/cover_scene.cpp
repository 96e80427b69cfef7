#include "touchstone/examples/fit/cover_scene.hpp"
#include "touchstone/examples/program/files/json.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

namespace touchstone::fitting {
namespace {

// YAML reads JSON's strings. What is no UTF-8 is replaced.
std::string quote(const std::string& text) { return comparison::one_line(nlohmann::json(text)); }

}  // namespace

std::string scene_text(const Fit& fit, const std::string& name, const std::string& description,
                       double duration) {
  const std::string quoted = quote(name);
  std::string text = fmt::format(
      "name: {}\ndescription: {}\nunits: {{length: m}}\nframe_rate: 50\ncontact_gap: 1.0e-6\npolicy: "
      "advance\n"
      "duration: {}\nobjects:\n  - name: {}\n    static: true\n    hexahedra:\n",
      quoted, quote(description), duration, quoted);
  for (std::size_t i = 0; i < fit.hexahedra.size(); ++i) {
    text += fmt::format("      - name: h{}\n        hexahedron:\n          vertices:\n", i);
    for (const Vector3& p : fit.hexahedra[i].vertices)
      text += fmt::format("            - [{}, {}, {}]\n", p.x(), p.y(), p.z());
  }
  return text;
}

}  // namespace touchstone::fitting
