#include "touchstone/contact_core/mechanism/arms/link_parts.hpp"

#include <cmath>

namespace touchstone {
namespace {

/// Axes whose x is along the direction; y lies as near to the link's y or z axis as it can.
Matrix3 axes_along(const Vector3& direction) {
  const bool is_along_y = std::abs(direction.y()) > 0.9 * norm(direction);
  const Vector3 aside = is_along_y ? Vector3::UnitZ() : Vector3::UnitY();
  const Vector3 x = direction / norm(direction);
  Vector3 y = aside - dot(aside, x) * x;
  y /= norm(y);
  Matrix3 R;
  R.col(0) = x;
  R.col(1) = y;
  R.col(2) = cross(x, y);
  return R;
}

}  // namespace

MassProperties solid_box_mass(double mass, const Vector3& centre_L, const Vector3& size) {
  MassProperties out{mass, centre_L, Matrix3::Zero(), centre_L};
  const Vector3 squares = size.cwiseProduct(size);
  out.inertia_L(0, 0) = mass / 12.0 * (squares.y() + squares.z());
  out.inertia_L(1, 1) = mass / 12.0 * (squares.z() + squares.x());
  out.inertia_L(2, 2) = mass / 12.0 * (squares.x() + squares.y());
  return out;
}

PlacedHexahedron make_bar(const Vector3& from_L, const Vector3& to_L, double width, double beyond,
                          const std::string& name) {
  const Vector3 offset_L = to_L - from_L;
  Pose X;
  X.R = axes_along(offset_L);
  X.p = 0.5 * (from_L + to_L);
  return {name, Hexahedron::from_size({norm(offset_L) + 2.0 * beyond, width, width}), rigid_frame(X)};
}

MassProperties bar_mass(double mass, const Vector3& from_L, const Vector3& to_L, double width) {
  const Vector3 offset_L = to_L - from_L, centre_L = 0.5 * (from_L + to_L);
  const double along = mass / 12.0 * 2.0 * width * width;
  const double across = mass / 12.0 * (dot(offset_L, offset_L) + width * width);
  const Vector3 x = offset_L / norm(offset_L);
  Matrix3 inertia;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      inertia(i, j) = (along - across) * (x[i] * x[j]) + (i == j ? across : 0.0);  // symmetric to the bit
  return {mass, centre_L, inertia, centre_L};
}

}  // namespace touchstone
