#pragma once

#include <cstddef>

#include "touchstone/contact_core/geometry/matrix3.hpp"

/// @file
/// Contacts between bodies as convex problems take them: rows of J are a direction and the lever's product
/// with it, so that velocities, impulses and J^T G J need a third of the products of rows that are written
/// out.

namespace touchstone::physics {

/// A contact of one body or two.
struct BodyContact {
  Vector3
      directions[3];  ///< normal and tangents, as the first body's rows have them; the second's are opposed
  Vector3 levers[2];  ///< from each body's centre to where impulses act
  std::size_t first[2];  ///< of each body's rates: its centre's velocity, then its turning
  int count;             ///< of bodies; 0: not a contact of bodies alone
};

/// Three doubles as a vector.
inline Vector3 vector_at(const double* from) { return {from[0], from[1], from[2]}; }

/// The velocity of the first body against the second where they touch.
inline Vector3 relative_velocity(const BodyContact& contact, const double* V) {
  const double* const a = V + contact.first[0];
  const Vector3 v = vector_at(a) + cross(vector_at(a + 3), contact.levers[0]);
  if (contact.count < 2) return v;
  const double* const b = V + contact.first[1];
  return v - (vector_at(b) + cross(vector_at(b + 3), contact.levers[1]));
}

/// to += J^T x of the contact's three rows.
inline void add_impulse(const BodyContact& contact, const double* x, double* to) {
  const Vector3 impulse =
      (x[0] * contact.directions[0] + x[1] * contact.directions[1]) + x[2] * contact.directions[2];
  for (int side = 0; side < contact.count; ++side) {
    double* const t = to + contact.first[side];
    const Vector3 linear = side == 0 ? impulse : Vector3(-impulse),
                  turning = cross(contact.levers[side], linear);
    for (int k = 0; k < 3; ++k) t[k] += linear[k], t[k + 3] += turning[k];
  }
}

/// J^T G J of contacts that the same bodies have, summed up before it is written.
class PairStiffness {
 public:
  void clear() {
    K_.setZero();
    for (int side = 0; side < 2; ++side) turned_[side].setZero(), twice_[side].setZero();
    crossed_.setZero();
  }
  /// @param G 3 x 3, symmetric, along the contact's directions
  void add(const BodyContact& contact, const double* G) {
    const Matrix3 K = in_world(contact.directions, G);
    K_ += K;
    for (int side = 0; side < contact.count; ++side) {
      const Vector3& lever = contact.levers[side];
      Matrix3 turned;  // [l]x K
      for (int k = 0; k < 3; ++k) turned.col(k) = cross(lever, K.col(k));
      turned_[side] += turned;
      // -[a]x K [l]x, of the first body's lever a; its own is symmetric.
      for (int k = 0; k < 3; ++k) {
        const Vector3 row = turned.row(k);
        twice_[side].col(k) += cross(lever, row);
        if (side == 1) crossed_.col(k) += cross(contact.levers[0], row);
      }
    }
  }
  /// Adds a body's own block: 6 x 6, row by row.
  void write_own(int side, double* B) const { write(turned_[side], turned_[side], twice_[side], 1.0, B); }
  /// Adds the block of both. @param is_first its rows are the first body's
  void write_both(bool is_first, double* B) const {
    if (is_first)
      write(turned_[0], turned_[1], crossed_, -1.0, B);
    else
      write(turned_[1], turned_[0], crossed_.transpose(), -1.0, B);
  }

 private:
  /// K = D^T G D.
  static Matrix3 in_world(const Vector3* directions, const double* G) {
    Vector3 GD[3];
    for (int r = 0; r < 3; ++r)
      GD[r] = (G[3 * r] * directions[0] + G[3 * r + 1] * directions[1]) + G[3 * r + 2] * directions[2];
    Matrix3 K;
    for (int r = 0; r < 3; ++r)
      for (int k = r; k < 3; ++k)
        K(r, k) = K(k, r) =
            (directions[0][r] * GD[0][k] + directions[1][r] * GD[1][k]) + directions[2][r] * GD[2][k];
    return K;
  }
  /// B += sign [K, C^T; R, T]: R of the rows' body, C of the columns'.
  void write(const Matrix3& R, const Matrix3& C, const Matrix3& T, double sign, double* B) const {
    for (int r = 0; r < 3; ++r)
      for (int k = 0; k < 3; ++k) {
        B[6 * r + k] += sign * K_(r, k);
        B[6 * r + k + 3] += sign * C(k, r);
        B[6 * (r + 3) + k] += sign * R(r, k);
        B[6 * (r + 3) + k + 3] += sign * T(r, k);
      }
  }

  Matrix3 K_, turned_[2], twice_[2], crossed_;  // [l]x K; -[l]x K [l]x; -[a]x K [b]x
};

}  // namespace touchstone::physics
