#include "touchstone/tests/proof/pairs/pair_text.hpp"

#include <array>
#include <cstdio>

#include "touchstone/contact_core/input_error.hpp"

namespace touchstone::proof {
namespace {

std::string row(const Vector3& v) {
  return "[" + all_digits(v.x()) + ", " + all_digits(v.y()) + ", " + all_digits(v.z()) + "]";
}

std::string shape(const Hexahedron& solid) {
  if (solid.is_box()) return R"({"type": "box", "size": )" + row(solid.half_extents() * 2.0) + "}";
  return R"({"type": "convex", "vertices": [)" + joined(solid.vertices(), row) +
         (solid.is_warped() ? R"(], "warped": "accept"})" : "]}");
}

std::string matrix(const Pose& X) {
  std::string rows;
  for (int i = 0; i < 3; ++i) {
    rows += "[";
    for (int j = 0; j < 3; ++j) rows += all_digits(X.R(i, j)) + ", ";
    rows += all_digits(X.p(i)) + "], ";
  }
  return R"({"matrix": [)" + rows + "[0, 0, 0, 1]]}";
}

}  // namespace

std::string all_digits(double value) {
  std::array<char, 40> text{};
  std::snprintf(text.data(), text.size(), "%.17g", value);
  return text.data();
}

std::string pair_text(const PosedSolids& solids, const std::string& id) {
  return R"({"id": ")" + id + R"(", "shapes": [)" + shape(solids.a) + ", " + shape(solids.b) +
         R"(], "poses": [)" + matrix(solids.X_WA) + ", " + matrix(solids.X_WB) + "]}";
}

}  // namespace touchstone::proof
