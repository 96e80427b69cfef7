#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "touchstone/contact_core/fit/parts/chords.hpp"
#include "touchstone/contact_core/fit/round_parts.hpp"
#include "touchstone/contact_core/fit/space/allowed_space.hpp"
#include "touchstone/contact_core/fit/space/six_planes.hpp"

// Private to contact_core/fit.

namespace touchstone::fit {

/// The room about a bore, divided by half planes from its axis: as many as chords within what is allowed
/// there take to go around.
struct Sectors {
  RoundPart bore;
  int count;
  std::uint32_t part;  ///< the bore's index among round parts
  double outer;  ///< radius of the widest round part about the same axis, the bore's if there is none [m]
  /// Of the closed shell that is a ring between the two and nothing else, thick beside what is asked of it:
  /// then each sector keeps to what is allowed. None: there is no such shell.
  std::vector<std::uint32_t> shell = {};
  /// Of a shell's sectors that are not equally wide: their inner wall's, `count` of them.
  std::vector<Chord> chords = {};

  /// Turn from the bore's start at which sector i begins and i - 1 ends [rad].
  double begin(int i) const;
  /// The half plane where sector i begins and i - 1 ends; positive on the side of sector i.
  Plane border(int i) const;
  /// Where the outer face of a sector looks, unit.
  Vector3 out(int i) const;
  /// Whether the box comes near the bore's wall, or is between it and `outer`.
  bool touches(const Vector3& low, const Vector3& high) const;
  /// Whether it is a ring about the bore, thick beside `over`: a hexahedron a sector then is all of its
  /// cover.
  bool is_ring(double over) const;
  bool has_shell() const { return !shell.empty(); }
  /// The shell's triangles.
  std::vector<Polygon> surface(const TriangleMesh& mesh) const;
  /// What of the polygons is in sector i.
  std::vector<Polygon> part_of(const std::vector<Polygon>& polygons, int i) const;
  /// The hexahedron of sector i about points of it.
  SixPlanes about(int i, std::span<const Vector3> points) const;
};

/// Times an error: what is thicker in every direction gains nothing of hexahedra that go beyond it.
constexpr double kThick = 8.0;

/// Of each bore; those that would take fewer than 6 or more than `most` have none, but for rings of closed
/// shells of their own, which fewer may go around.
/// @param no_rings bores whose shells are cut by boxes even so, by their indices among `parts`
std::vector<Sectors> sectors_about_bores(const MeshDistance& mesh, std::span<const RoundPart> parts,
                                         const AllowedSpace& allowed,
                                         std::span<const std::uint32_t> no_rings = {}, int most = 72);

}  // namespace touchstone::fit
