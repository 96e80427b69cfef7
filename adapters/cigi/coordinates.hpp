#pragma once

#include <cstdint>
#include <variant>

#include "touchstone/adapters/cigi/packets.hpp"
#include "touchstone/contact_core/geometry/pose.hpp"

/// @file
/// From the world W to what an image generator takes. Frames: E an entity (x forward, y right, z down), P its
/// parent entity, N north, east, down at the origin on Earth, C Earth's centre (WGS 84, x through 0 N 0 E, z
/// through the north pole).

namespace touchstone::cigi {

/// On the WGS 84 ellipsoid.
struct Geodetic {
  double latitude = 0.0;   ///< [-90, 90] deg
  double longitude = 0.0;  ///< [-180, 180] deg
  double altitude = 0.0;   ///< above the ellipsoid [m]
};

/// p_C of a place [m].
Vector3 position_on_earth(const Geodetic& place);
/// For altitudes from -10 km to 1000 km to 5 nm in the position that it stands for, as tested; at the poles
/// the longitude is what is left of x and y.
Geodetic geodetic_from(const Vector3& p_C);
/// R_CN: columns north, east, down.
Matrix3 north_east_down(const Geodetic& place);

/// A scene on or in another entity (such as a station) that somebody else places. Suits scenes of metres:
/// positions are sent as they are, in metres and doubles.
struct AttachedTo {
  std::uint16_t parent = 0;
  Pose X_PW;  ///< the world in the parent's axes; z_up() where the world's z is up
};

/// A scene that stands on Earth.
struct OnEarth {
  Geodetic origin;
  Pose X_NW;  ///< the world in north, east, down at `origin`; z_up() where its x is north, its y west, z up
};

/// The place of the world for the image generator.
using Anchor = std::variant<AttachedTo, OnEarth>;

/// Half a turn about x: from axes with z up to axes with z down.
Pose z_up();

/// @throws InputError: an invalid pose, a latitude or longitude out of its range, not finite.
void validate(const Anchor& anchor);

/// Fills in attachment, parent, position and angles for an entity at X_WE.
///
/// Error: angles are floats in degrees, each rounded by half an ulp: of roll 7.6e-6 deg at most, of pitch
/// 3.8e-6, of yaw 1.5e-5; together less than 5e-7 rad, or half a micrometre per metre from the entity's
/// origin. Positions: attached, what double rounding of X_PW * X_WE leaves; on Earth see geodetic_from().
void place(const Anchor& anchor, const Pose& X_WE, EntityControl& packet) noexcept;

/// The inverse, as an image generator reads it.
Pose pose_from(const Anchor& anchor, const EntityControl& packet);

}  // namespace touchstone::cigi
