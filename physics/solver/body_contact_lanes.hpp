#pragma once

#include "touchstone/physics/solver/body_contact.hpp"
#include "touchstone/physics/solver/four.hpp"

// Velocities, impulses and stiffness of contacts between bodies: four at once.

namespace touchstone::physics {

/// Along each contact's normal and tangents.
struct ContactLanes {
  Four n, t1, t2;
};

TOUCHSTONE_INLINE ContactLanes lanes_at(const double* from) {
  return {four_at(from), four_at(from + 4), four_at(from + 8)};
}
TOUCHSTONE_INLINE void put(const ContactLanes& x, double* to) {
  put(x.n, to), put(x.t1, to + 4), put(x.t2, to + 8);
}

/// The velocities of the first body against the second where they touch. @param V rates
TOUCHSTONE_INLINE FourVectors relative_velocities(const BodyContacts& contacts, const double* V) {
  const double* const a = V + contacts.first[0];
  const FourVectors v = vector_in_all(a) + cross(vector_in_all(a + 3), vectors_at(contacts.levers[0]));
  if (contacts.count < 2) return v;
  const double* const b = V + contacts.first[1];
  return v - (vector_in_all(b) + cross(vector_in_all(b + 3), vectors_at(contacts.levers[1])));
}

/// Of vectors, along the contacts' directions.
TOUCHSTONE_INLINE ContactLanes along_directions(const BodyContacts& contacts, const FourVectors& v) {
  return {dot(vectors_at(contacts.directions[0]), v), dot(vectors_at(contacts.directions[1]), v),
          dot(vectors_at(contacts.directions[2]), v)};
}

TOUCHSTONE_INLINE void add_sums(const FourVectors& v, double sign, double* to) {
  to[0] += sign * sum_of(v.x), to[1] += sign * sum_of(v.y), to[2] += sign * sum_of(v.z);
}

/// to += sign J^T x of the contacts' rows.
TOUCHSTONE_INLINE void add_impulses(const BodyContacts& contacts, const ContactLanes& x, double sign,
                                    double* to) {
  const FourVectors impulse =
      (x.n * vectors_at(contacts.directions[0]) + x.t1 * vectors_at(contacts.directions[1])) +
      x.t2 * vectors_at(contacts.directions[2]);
  for (int side = 0; side < contacts.count; ++side, sign = -sign) {
    double* const t = to + contacts.first[side];
    add_sums(impulse, sign, t);
    add_sums(cross(vectors_at(contacts.levers[side]), impulse), sign, t + 3);
  }
}

/// reach: by rate, at least the largest of J's entries.
TOUCHSTONE_INLINE void raise_reach(const BodyContacts& contacts, double* reach) {
  for (int side = 0; side < contacts.count; ++side) {
    double* const of = reach + contacts.first[side];
    for (const auto& direction : contacts.directions) {
      const FourVectors d = vectors_at(direction), turn = cross(vectors_at(contacts.levers[side]), d);
      const Four entries[6] = {d.x, d.y, d.z, turn.x, turn.y, turn.z};
      for (int k = 0; k < 6; ++k) of[k] = std::max(of[k], largest_of(magnitude(entries[k])));
    }
  }
}

/// Of four symmetric 3 x 3 matrices, by lane: the lower triangles, row by row.
struct SymmetricLanes {
  Four of[6];

  /// Entry (r, k), in either triangle.
  const Four& operator()(int r, int k) const {
    return r >= k ? of[r * (r + 1) / 2 + k] : of[k * (k + 1) / 2 + r];
  }
};
inline constexpr std::size_t kStiffnessLanes = 6 * BodyContacts::kLanes;  // doubles of SymmetricLanes

TOUCHSTONE_INLINE SymmetricLanes symmetric_at(const double* from) {
  SymmetricLanes out;
  for (int i = 0; i < 6; ++i) out.of[i] = four_at(from + 4 * i);
  return out;
}

TOUCHSTONE_INLINE void put(const SymmetricLanes& G, double* to) {
  for (int i = 0; i < 6; ++i) put(G.of[i], to + 4 * i);
}

/// J^T G J of contacts that the same bodies have, summed up before it is written.
class PairStiffness {
 public:
  bool is_empty() const { return is_empty_; }
  /// @param G along the contacts' directions
  void add(const BodyContacts& contacts, const SymmetricLanes& G) {
    // The first ones begin the sums: clearing all of them costs as much as adding.
    const auto sum = [is_first = is_empty_](const FourVectors& v, FourVectors& to) {
      to = is_first ? v : to + v;
    };
    is_empty_ = false;
    FourVectors K[3];  // rows, in the world: symmetric
    turn(contacts, G, K);
    for (int r = 0; r < 3; ++r) sum(K[r], K_[r]);
    for (int side = 0; side < contacts.count; ++side) {
      const FourVectors lever = vectors_at(contacts.levers[side]);
      // Columns of [l]x K; then those of -[l]x K [l]x, which its rows give.
      FourVectors turned[3];
      for (int k = 0; k < 3; ++k) turned[k] = cross(lever, K[k]), sum(turned[k], turned_[side][k]);
      const FourVectors rows[3] = {{turned[0].x, turned[1].x, turned[2].x},
                                   {turned[0].y, turned[1].y, turned[2].y},
                                   {turned[0].z, turned[1].z, turned[2].z}};
      for (int k = 0; k < 3; ++k) sum(cross(lever, rows[k]), twice_[side][k]);
      if (side == 0) continue;
      const FourVectors other = vectors_at(contacts.levers[0]);
      for (int k = 0; k < 3; ++k) sum(cross(other, rows[k]), crossed_[k]);
    }
  }
  /// Adds the lower triangle of a body's own block: 6 x 6, row by row.
  void write_own(int side, double* B) const {
    for (int k = 0; k < 3; ++k) {
      const double K[3] = {sum_of(K_[k].x), sum_of(K_[k].y), sum_of(K_[k].z)};
      const FourVectors &R = turned_[side][k], &T = twice_[side][k];
      const double turned[3] = {sum_of(R.x), sum_of(R.y), sum_of(R.z)},
                   twice[3] = {sum_of(T.x), sum_of(T.y), sum_of(T.z)};
      for (int r = 0; r < 3; ++r) {
        if (r >= k) B[6 * r + k] += K[r], B[6 * (r + 3) + k + 3] += twice[r];
        B[6 * (r + 3) + k] += turned[r];
      }
    }
  }
  /// Adds the block of both. @param is_first its rows are the first body's
  void write_both(bool is_first, double* B) const {
    const int of_rows = is_first ? 0 : 1;
    for (int k = 0; k < 3; ++k) {
      const FourVectors &R = turned_[of_rows][k], &C = turned_[1 - of_rows][k], &X = crossed_[k];
      const double K[3] = {sum_of(K_[k].x), sum_of(K_[k].y), sum_of(K_[k].z)};
      const double of_row[3] = {sum_of(R.x), sum_of(R.y), sum_of(R.z)},
                   of_column[3] = {sum_of(C.x), sum_of(C.y), sum_of(C.z)};
      const double crossed[3] = {sum_of(X.x), sum_of(X.y), sum_of(X.z)};
      for (int r = 0; r < 3; ++r) {
        B[6 * r + k] -= K[r];
        B[6 * (r + 3) + k] -= of_row[r];
        B[6 * k + r + 3] -= of_column[r];
        if (is_first)
          B[6 * (r + 3) + k + 3] -= crossed[r];
        else
          B[6 * (k + 3) + r + 3] -= crossed[r];
      }
    }
  }

 private:
  /// K = D^T G D, row by row.
  TOUCHSTONE_INLINE static void turn(const BodyContacts& contacts, const SymmetricLanes& G, FourVectors* K) {
    const FourVectors D[3] = {vectors_at(contacts.directions[0]), vectors_at(contacts.directions[1]),
                              vectors_at(contacts.directions[2])};
    FourVectors GD[3];
    for (int r = 0; r < 3; ++r) GD[r] = (G(r, 0) * D[0] + G(r, 1) * D[1]) + G(r, 2) * D[2];
    const Four xy = (D[0].x * GD[0].y + D[1].x * GD[1].y) + D[2].x * GD[2].y;
    const Four xz = (D[0].x * GD[0].z + D[1].x * GD[1].z) + D[2].x * GD[2].z;
    const Four yz = (D[0].y * GD[0].z + D[1].y * GD[1].z) + D[2].y * GD[2].z;
    K[0] = {(D[0].x * GD[0].x + D[1].x * GD[1].x) + D[2].x * GD[2].x, xy, xz};
    K[1] = {xy, (D[0].y * GD[0].y + D[1].y * GD[1].y) + D[2].y * GD[2].y, yz};
    K[2] = {xz, yz, (D[0].z * GD[0].z + D[1].z * GD[1].z) + D[2].z * GD[2].z};
  }

  bool is_empty_ = true;
  FourVectors K_[3], turned_[2][3], twice_[2][3], crossed_[3];  // columns
};

}  // namespace touchstone::physics
