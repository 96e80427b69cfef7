#include "touchstone/adapters/cigi/coordinates.hpp"

#include <cmath>
#include <numbers>
#include <string>

#include "touchstone/contact_core/input_error.hpp"

namespace touchstone::cigi {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

// WGS 84 (NIMA TR8350.2): semi-major axis [m] and flattening.
constexpr double kA = 6378137.0;
constexpr double kF = 1.0 / 298.257223563;
constexpr double kB = kA * (1.0 - kF);
constexpr double kE2 = kF * (2.0 - kF);          // first eccentricity squared
constexpr double kSecondE2 = kE2 / (1.0 - kE2);  // second

double prime_vertical_radius(double sin_latitude) {
  return kA / std::sqrt(1.0 - kE2 * sin_latitude * sin_latitude);
}

double cube(double x) { return x * x * x; }

/// The origin's pose X_CN.
Pose pose_on_earth(const Geodetic& place) { return {north_east_down(place), position_on_earth(place)}; }

void put_angles(const Matrix3& R, EntityControl& packet) {
  const Vector6 position = position_vector_from_pose({R, Vector3::Zero()});
  packet.roll = static_cast<float>(position(3) / kDegree);
  packet.pitch = static_cast<float>(position(4) / kDegree);
  const double yaw = position(5) / kDegree;
  packet.yaw = static_cast<float>(yaw < 0.0 ? yaw + 360.0 : yaw);
  if (packet.yaw >= 360.0F) packet.yaw = 0.0F;
}

Matrix3 rotation_from(const EntityControl& packet) {
  Vector6 position = Vector6::Zero();
  position(3) = packet.roll * kDegree;
  position(4) = packet.pitch * kDegree;
  position(5) = packet.yaw * kDegree;
  return pose_from_position_vector(position).R;
}

void place_on(const AttachedTo& anchor, const Pose& X_WE, EntityControl& packet) {
  const Pose X_PE = compose(anchor.X_PW, X_WE);
  packet.is_attached = true;
  packet.parent = anchor.parent;
  packet.position = {X_PE.p.x(), X_PE.p.y(), X_PE.p.z()};
  put_angles(X_PE.R, packet);
}

void place_on(const OnEarth& anchor, const Pose& X_WE, EntityControl& packet) {
  const Pose X_CE = compose(pose_on_earth(anchor.origin), compose(anchor.X_NW, X_WE));
  const Geodetic place = geodetic_from(X_CE.p);
  packet.is_attached = false;
  packet.parent = 0;
  packet.position = {place.latitude, place.longitude, place.altitude};
  const Pose X_there{north_east_down(place), Vector3::Zero()};
  put_angles(compose(inverse(X_there), {X_CE.R, Vector3::Zero()}).R, packet);
}

Pose pose_on(const AttachedTo& anchor, const EntityControl& packet) {
  const Vector3 p_E_P(packet.position[0], packet.position[1], packet.position[2]);
  return compose(inverse(anchor.X_PW), {rotation_from(packet), p_E_P});
}

Pose pose_on(const OnEarth& anchor, const EntityControl& packet) {
  const Geodetic place{packet.position[0], packet.position[1], packet.position[2]};
  const Pose X_CE = compose(pose_on_earth(place), {rotation_from(packet), Vector3::Zero()});
  const Pose X_CW = compose(pose_on_earth(anchor.origin), anchor.X_NW);
  return compose(inverse(X_CW), X_CE);
}

void validate_place(const Geodetic& place) {
  if (!(std::abs(place.latitude) <= 90.0) || !(std::abs(place.longitude) <= 180.0) ||
      !std::isfinite(place.altitude)) {
    throw InputError("cigi: no place on Earth: latitude " + std::to_string(place.latitude) + ", longitude " +
                     std::to_string(place.longitude) + " deg, altitude " + std::to_string(place.altitude) +
                     " m");
  }
}

}  // namespace

Vector3 position_on_earth(const Geodetic& place) {
  const double latitude = place.latitude * kDegree, longitude = place.longitude * kDegree;
  const double radius = prime_vertical_radius(std::sin(latitude));
  const double across = (radius + place.altitude) * std::cos(latitude);
  return {across * std::cos(longitude), across * std::sin(longitude),
          (radius * (1.0 - kE2) + place.altitude) * std::sin(latitude)};
}

Geodetic geodetic_from(const Vector3& p_C) {
  const double across = std::hypot(p_C.x(), p_C.y());
  // Bowring (1976): the reduced latitude, better with each round; the third changes nothing below 1000 km.
  double sin_reduced = kA * p_C.z(), cos_reduced = kB * across;
  double sine = 0.0, cosine = 1.0;
  for (int round = 0; round < 3; ++round) {
    const double length = std::hypot(sin_reduced, cos_reduced);
    sine = p_C.z() + kSecondE2 * kB * cube(sin_reduced / length);
    cosine = across - kE2 * kA * cube(cos_reduced / length);
    sin_reduced = (1.0 - kF) * sine;
    cos_reduced = cosine;
  }
  const double length = std::hypot(sine, cosine);
  sine /= length, cosine /= length;
  // Along the normal: right at the poles and the equator alike.
  const double altitude = across * cosine + p_C.z() * sine - kA * std::sqrt(1.0 - kE2 * sine * sine);
  return {std::atan2(sine, cosine) / kDegree, std::atan2(p_C.y(), p_C.x()) / kDegree, altitude};
}

Matrix3 north_east_down(const Geodetic& place) {
  const double latitude = place.latitude * kDegree, longitude = place.longitude * kDegree;
  const double sa = std::sin(latitude), ca = std::cos(latitude);
  const double so = std::sin(longitude), co = std::cos(longitude);
  Matrix3 R_CN;
  R_CN << -sa * co, -so, -ca * co,  //
      -sa * so, co, -ca * so,       //
      ca, 0.0, -sa;
  return R_CN;
}

Pose z_up() {
  Pose X;
  X.R << 1, 0, 0, 0, -1, 0, 0, 0, -1;
  return X;
}

void validate(const Anchor& anchor) {
  if (const auto* attached = std::get_if<AttachedTo>(&anchor)) {
    validate_pose(attached->X_PW, "cigi: the world in its parent");
  } else {
    const auto& on_earth = std::get<OnEarth>(anchor);
    validate_place(on_earth.origin);
    validate_pose(on_earth.X_NW, "cigi: the world in north, east, down");
  }
}

void place(const Anchor& anchor, const Pose& X_WE, EntityControl& packet) noexcept {
  if (const auto* attached = std::get_if<AttachedTo>(&anchor)) {
    place_on(*attached, X_WE, packet);
  } else {
    place_on(*std::get_if<OnEarth>(&anchor), X_WE, packet);
  }
}

Pose pose_from(const Anchor& anchor, const EntityControl& packet) {
  return std::visit([&](const auto& where) { return pose_on(where, packet); }, anchor);
}

}  // namespace touchstone::cigi
