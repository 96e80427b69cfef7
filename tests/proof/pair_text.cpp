#include "touchstone/tests/proof/pair_text.hpp"

#include <array>
#include <cstdio>

namespace touchstone::proof {
namespace {

std::string figure(double value) {
  std::array<char, 40> text{};
  std::snprintf(text.data(), text.size(), "%.17g", value);
  return text.data();
}

std::string row(const Vector3& v) {
  return "[" + figure(v.x()) + ", " + figure(v.y()) + ", " + figure(v.z()) + "]";
}

std::string shape(const Hexahedron& solid) {
  if (solid.is_box()) return R"({"type": "box", "size": )" + row(solid.half_extents() * 2.0) + "}";
  std::string vertices;
  for (const Vector3& v : solid.vertices()) vertices += (vertices.empty() ? "" : ", ") + row(v);
  return R"({"type": "convex", "vertices": [)" + vertices +
         (solid.is_warped() ? R"(], "warped": "accept"})" : "]}");
}

std::string matrix(const Pose& X) {
  std::string rows;
  for (int i = 0; i < 3; ++i) {
    rows += "[";
    for (int j = 0; j < 3; ++j) rows += figure(X.R(i, j)) + ", ";
    rows += figure(X.p(i)) + "], ";
  }
  return R"({"matrix": [)" + rows + "[0, 0, 0, 1]]}";
}

}  // namespace

std::string pair_text(const PosedSolids& solids, const std::string& id) {
  return R"({"id": ")" + id + R"(", "shapes": [)" + shape(solids.a) + ", " + shape(solids.b) +
         R"(], "poses": [)" + matrix(solids.X_WA) + ", " + matrix(solids.X_WB) + "]}";
}

}  // namespace touchstone::proof
