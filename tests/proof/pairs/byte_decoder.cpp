#include "touchstone/tests/proof/pairs/byte_decoder.hpp"

#include <array>
#include <cmath>

#include "touchstone/contact_core/input_error.hpp"

namespace touchstone::proof {
namespace {

using Vertices = std::array<Vector3, 8>;

class Bytes {
 public:
  explicit Bytes(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

  int byte() { return at_ < bytes_.size() ? bytes_[at_++] : 0; }
  int below(int count) { return byte() % count; }
  bool one_in(int count) { return below(count) == count - 1; }

  /// In [-4, 4]: a multiple of 1/2, 1/32 or 2^-14, or 53 bits.
  double number() {
    switch (below(4)) {
      case 0:
        return (below(9) - 4) * 0.5;
      case 1:
        return (byte() - 128) * 0x1p-5;
      case 2:
        return (word(2) - 0x1p15) * 0x1p-14;
      default:
        return (word(7) - 0x1p55) * 0x1p-54;
    }
  }
  double side() {
    const double size = std::abs(number());
    return size > 0.0 ? size : 1.0;
  }
  Vector3 vector() {
    const double x = number(), y = number(), z = number();
    return {x, y, z};
  }
  Vector3 sides() {
    const double x = side(), y = side(), z = side();
    return {x, y, z};
  }

 private:
  double word(int count) {
    std::uint64_t value = 0;
    for (int i = 0; i < count; ++i) value = value << 8 | static_cast<std::uint64_t>(byte());
    return static_cast<double>(value);
  }

  std::span<const std::uint8_t> bytes_;
  std::size_t at_ = 0;
};

double power(int exponent) { return std::ldexp(1.0, exponent); }

}  // namespace

// Dekker's split. The casts to float and back would give the same, but g++ 12 leaves them out of some loops
// at
// -O3.
double in_single_precision(double x) {
  const double shifted = x * (0x1p29 + 1.0);
  return shifted - (shifted - x);
}

namespace {

// ---- solids

Vertices corners(const Vector3& half) {
  Vertices v;
  for (int i = 0; i < 8; ++i)
    v[i] = {i & 4 ? half.x() : -half.x(), i & 2 ? half.y() : -half.y(), i & 1 ? half.z() : -half.z()};
  return v;
}

Vertices parallelepiped(Bytes& bytes) {
  const Vector3 x = bytes.vector(), y = bytes.vector(), z = bytes.vector();
  Vertices v;
  for (int i = 0; i < 8; ++i) {
    v[i] = Vector3::Zero();
    if (i & 4) v[i] += x;
    if (i & 2) v[i] += y;
    if (i & 1) v[i] += z;
  }
  return v;
}

// The top shrunk in x and y, to an edge or a point where asked, and moved sideways.
Vertices frustum(Bytes& bytes) {
  Vertices v = corners(bytes.sides());
  const int collapsed = bytes.below(4);
  const double sx = collapsed & 1 ? 0.0 : bytes.side() * 0.25, sy = collapsed & 2 ? 0.0 : bytes.side() * 0.25;
  const double dx = bytes.number(), dy = bytes.number();
  for (Vector3& p : v)
    if (p.z() > 0) p = {sx * p.x() + dx, sy * p.y() + dy, p.z()};
  return v;
}

// Corners of a box moved by up to 2^-2 to 2^-53 of a side.
Vertices warped(Bytes& bytes) {
  Vertices v = corners(bytes.sides());
  const double reach = power(-4 - bytes.below(50));
  for (Vector3& p : v) p += bytes.vector() * reach;
  return v;
}

// One or more corners of a box moved onto their neighbour.
Vertices with_collapsed_edges(Bytes& bytes) {
  Vertices v = corners(bytes.sides());
  const int edges = bytes.byte();
  for (int i = 0; i < 8; ++i)
    if (edges >> i & 1) v[i] = v[i ^ (1 << bytes.below(3))];
  return v;
}

// A box on the grid of whole numbers, each coordinate of each corner moved in by one or not.
Vertices on_grid(Bytes& bytes) {
  Vertices v;
  const double far = 2.0 + bytes.below(4);
  for (int i = 0; i < 8; ++i) {
    const int moved = bytes.byte();
    for (int axis = 0; axis < 3; ++axis) {
      const double inward = moved >> axis & 1 ? 1.0 : 0.0;
      v[i][axis] = i >> (2 - axis) & 1 ? far - inward : inward;
    }
  }
  return v;
}

Vertices free_vertices(Bytes& bytes) {
  Vertices v;
  for (Vector3& p : v) p = bytes.vector();
  return v;
}

void jitter(Vertices& v, Bytes& bytes) {
  for (Vector3& p : v) {
    const int packed = bytes.byte();
    p.x() *= 1.0 + (packed % 5 - 2) * 0x1p-52;
    p.y() *= 1.0 + (packed / 5 % 5 - 2) * 0x1p-52;
    p.z() *= 1.0 + (packed / 25 % 5 - 2) * 0x1p-52;
  }
}

Vertices any_vertices(int kind, Bytes& bytes) {
  switch (kind) {
    case 0:
      return parallelepiped(bytes);
    case 1:
      return frustum(bytes);
    case 2:
      return warped(bytes);
    case 3:
      return with_collapsed_edges(bytes);
    case 4:
      return on_grid(bytes);
    default:
      return free_vertices(bytes);
  }
}

Hexahedron solid(Bytes& bytes, double scale) {
  const int kind = bytes.below(10);
  if (kind < 4) {
    Vector3 size = bytes.sides();
    if (kind == 3) {  // slab or needle
      const int axis = bytes.below(3);
      size[axis] *= power(-bytes.below(53));
      if (bytes.one_in(2)) size[(axis + 1) % 3] *= power(-bytes.below(53));
    }
    return Hexahedron::from_size(size * scale);
  }
  Vertices v = any_vertices(kind - 4, bytes);
  if (bytes.one_in(4)) jitter(v, bytes);
  if (bytes.one_in(8)) {
    const int axis = bytes.below(3);
    const double thin = power(-bytes.below(53));
    for (Vector3& p : v) p[axis] *= thin;
  }
  for (Vector3& p : v) p *= scale;
  return Hexahedron::from_vertices(v, WarpPolicy::accept);
}

// ---- poses

Matrix3 rotation(double w, const Vector3& v) {
  if (w == 0.0 && v == Vector3::Zero()) return Matrix3::Identity();
  return rotation_from_quaternion(w, v.x(), v.y(), v.z());
}

// One of the 24 turns that map the axes to axes.
Matrix3 axis_turn(int which) {
  const int first = which % 3, second = (first + 1 + which / 3 % 2) % 3, third = 3 - first - second;
  Matrix3 R = Matrix3::Zero();
  R(first, 0) = which / 6 % 2 ? -1.0 : 1.0;
  R(second, 1) = which / 12 % 2 ? -1.0 : 1.0;
  R(third, 2) = (second == (first + 1) % 3 ? 1.0 : -1.0) * R(first, 0) * R(second, 1);
  return R;
}

Matrix3 any_rotation(Bytes& bytes) {
  const int kind = bytes.below(8);
  Matrix3 R = Matrix3::Identity();
  if (kind == 0) return R;
  if (kind == 1) return axis_turn(bytes.below(24));
  if (kind == 2 || kind == 3) {
    const double angle = power(-bytes.below(60));
    R = rotation(1.0, bytes.vector() * angle);
  } else {
    const double w = bytes.number();
    R = rotation(w, bytes.vector());
  }
  if (kind == 3 || kind == 6) {  // written with single precision
    for (double& entry : R.reshaped()) entry = in_single_precision(entry);
  }
  if (kind == 7) {  // as far from orthonormal as is allowed
    for (double& entry : R.reshaped()) entry += (bytes.byte() - 128) * 0x1p-30;
  }
  return R;
}

// A vertex, or the middle of two or four vertices.
Vector3 feature_point(const Hexahedron& solid, Bytes& bytes) {
  const int kind = bytes.below(3);
  const auto& v = solid.vertices();
  if (kind == 0) return v[bytes.below(8)];
  if (kind == 1) {
    const auto& ends = Hexahedron::kEdgeVertices[bytes.below(12)];
    return v[ends[0]] * 0.5 + v[ends[1]] * 0.5;
  }
  const auto& loop = Hexahedron::kFaceVertices[bytes.below(6)];
  return (v[loop[0]] * 0.25 + v[loop[1]] * 0.25) + (v[loop[2]] * 0.25 + v[loop[3]] * 0.25);
}

// 2^-300 to 2^300.
double any_scale(Bytes& bytes) {
  const int high = bytes.byte(), low = bytes.byte();
  return power((high * 256 + low) % 601 - 300);
}

std::optional<PosedSolids> decode(Bytes& bytes) {
  // How large the solids are, and how the second is placed.
  const double scale = bytes.one_in(4) ? any_scale(bytes) : 1.0;
  const double ratio = bytes.one_in(6) ? power(bytes.below(81) - 40) : 1.0;
  const int placing = bytes.below(4);
  const int far = bytes.one_in(5) ? bytes.below(50) : -1;
  const bool twin = bytes.one_in(16);

  // Solids and rotations.
  const Hexahedron a = solid(bytes, scale);
  const Hexahedron b = twin ? a : solid(bytes, scale * ratio);
  Pose X_WA{any_rotation(bytes), bytes.vector() * scale}, X_WB;
  X_WB.R = any_rotation(bytes);
  if (bytes.one_in(2)) X_WB.R = compose(X_WA, X_WB).R;
  X_WB.p = bytes.vector() * scale;
  // Features of the two meet, or nearly do.
  if (placing > 0) {
    const Vector3 meeting = transform(X_WA, feature_point(a, bytes));
    X_WB.p = meeting - rotate(X_WB.R, feature_point(b, bytes));
    if (placing > 1) {
      const double gap = power(-bytes.below(60));
      X_WB.p += bytes.vector() * (scale * gap);
    }
  }
  // Both may be far from the origin.
  if (far >= 0) {
    const Vector3 offset = bytes.vector() * (scale * power(far));
    X_WA.p += offset, X_WB.p += offset;
  }
  if (!is_valid_pose(X_WA) || !is_valid_pose(X_WB)) return std::nullopt;
  return PosedSolids{a, b, X_WA, X_WB};
}

}  // namespace

std::optional<PosedSolids> decode_pair(std::span<const std::uint8_t> given) {
  Bytes bytes(given);
  try {
    return decode(bytes);
  } catch (const InputError&) {
    return std::nullopt;
  }
}

}  // namespace touchstone::proof
