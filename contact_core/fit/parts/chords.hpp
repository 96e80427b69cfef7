#pragma once

#include <numbers>
#include <vector>

// Private to contact_core/fit.

namespace touchstone::fit {

constexpr double kTurn = 2.0 * std::numbers::pi;  ///< a whole one [rad]

/// A chord of a circle of radius 1 that has corners at equal turns, the first at turn 0: a polygon.
struct Chord {
  double begin, end;  ///< turns at which it leaves the polygon and comes back [rad]
  double out;         ///< across it, outwards [rad]
  double height;      ///< from the centre
  double depth;       ///< how far the polygon is beyond it at most
};
/// @pre begin < end < begin + half a turn
Chord chord_between(int facets, double begin, double end);

/// How deep chords may be within a ring's two walls, which have the same facets: a hexahedron that has one
/// face along a chord of the inner wall has the other along that of the outer wall, outside.
struct ChordLimits {
  double inner, outer;  ///< in shares of each wall's radius

  bool allow(const Chord& chord) const;
};

/// Chords, each from where the one before ends, that go all around: as few as were found, by going as far as
/// each may from several turns on, and about equally deep.
std::vector<Chord> fewest_chords(int facets, const ChordLimits& limits);

}  // namespace touchstone::fit
