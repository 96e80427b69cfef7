#include "touchstone/adapters/bullet_plugin/parting_face.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace touchstone::TOUCHSTONE_BULLET_NAMESPACE {
namespace {

/// Of the sum of all lengths that a gap is made from. Some thirty operations round, each by at most half an
/// epsilon of that sum, in Bullet's precision where its matrices and in double where ours go on; within it is
/// all at which a contact may begin (HexahedronAlgorithm::touching).
constexpr double kRounding =
    std::max(0x1p-45, 8.0 * static_cast<double>(std::numeric_limits<btScalar>::epsilon()));

/// A box in doubles: columns of its matrix, half its sides.
struct Block {
  Vector3 axes[3];
  Vector3 p;
  double half[3];

  Block(const btTransform& X, const btVector3& sides) : p(from_engine(X.getOrigin())) {
    for (int k = 0; k < 3; ++k) {
      axes[k] = from_engine(X.getBasis().getColumn(k));
      half[k] = static_cast<double>(sides[k]);
    }
  }
  /// Of its projection on n.
  double reach(const Vector3& n) const {
    return half[0] * std::abs(dot(n, axes[0])) + half[1] * std::abs(dot(n, axes[1])) +
           half[2] * std::abs(dot(n, axes[2]));
  }
  double scale() const {
    return std::abs(p[0]) + std::abs(p[1]) + std::abs(p[2]) + half[0] + half[1] + half[2];
  }
  bool is_valid() const {
    bool good = dot(cross(axes[0], axes[1]), axes[2]) > 0.0;
    for (int i = 0; i < 3; ++i) {
      good = good && half[i] > 0.0;
      good = good && std::abs(dot(axes[i], axes[i]) - 1.0) <= kRotationTolerance;
      good = good && std::abs(dot(axes[i], axes[(i + 1) % 3])) <= kRotationTolerance;
    }
    return good;
  }
};

}  // namespace

bool PartingFace::parts(const btTransform& X_WA, const btVector3& half_a, const btTransform& X_WB,
                        const btVector3& half_b) {
  const Block a(X_WA, half_a), b(X_WB, half_b);
  const Vector3 offset = b.p - a.p;
  const double rounding = kRounding * (a.scale() + b.scale());
  const auto is_parted_by = [&](std::uint8_t face) {
    const Vector3& n = face < 3 ? a.axes[face] : b.axes[face - 3];
    return std::abs(dot(n, offset)) - (a.reach(n) + b.reach(n)) > rounding;
  };
  bool found = is_parted_by(last_);
  for (std::uint8_t face = 0; face < 6 && !found; ++face)
    if (is_parted_by(face)) last_ = face, found = true;
  return found && a.is_valid() && b.is_valid();
}

}  // namespace touchstone::TOUCHSTONE_BULLET_NAMESPACE
