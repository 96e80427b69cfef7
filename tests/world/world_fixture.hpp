#pragma once

#include <memory>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "touchstone/contact_core/geometry/matrix3.hpp"
#include "touchstone/contact_core/registry.hpp"
#include "touchstone/contact_core/scene/motion.hpp"
#include "touchstone/contact_core/world/contact_world.hpp"
#include "touchstone/tests/support/at.hpp"

namespace touchstone {

inline constexpr double kGap = 1e-9;

inline std::shared_ptr<const HexahedronTree> box_tree(const std::string& name, const Vector3& size) {
  return std::make_shared<HexahedronTree>(
      std::vector<PlacedHexahedron>{{"box", Hexahedron::from_size(size), Pose{}}}, name);
}

/// Hands hold nothing: closed forms of slides are by the bodies' masses.
inline std::unique_ptr<ContactWorld> make_world(std::string_view broadphase = "native") {
  BackendRegistry registry;
  register_core(registry);
  auto world = std::make_unique<ContactWorld>(registry.make_narrowphase("native"),
                                              registry.make_broadphase(broadphase), kGap);
  world->set_default_hand(std::nullopt);
  return world;
}

/// A static slope of 30 deg about y, through the origin. @returns the pose on it of a cube of 0.2 m, 1 um
/// above; the third column of its rotation is the slope's normal.
inline Pose add_slope(ContactWorld& world) {
  Pose X_slope;
  X_slope.R = rotation_about(Vector3::UnitY(), std::numbers::pi / 6);
  const Vector3 n = X_slope.R.col(2);
  X_slope.p = -0.5 * n;
  world.add({box_tree("slope", {6, 6, 1}), X_slope, true});
  return {X_slope.R, (0.1 + 1e-6) * n};
}

inline PairRule rule(ContactPolicy policy, std::optional<double> warn = {}) { return {policy, warn}; }

inline std::vector<EventKind> kinds(const FrameReport& report) {
  std::vector<EventKind> out;
  for (const ContactEvent& event : report.events) out.push_back(event.kind);
  return out;
}

}  // namespace touchstone
