#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "touchstone/contact_core/registry.hpp"
#include "touchstone/contact_core/scene/motion.hpp"
#include "touchstone/contact_core/world/contact_world.hpp"

namespace touchstone {

inline constexpr double kGap = 1e-9;

inline Pose at(double x, double y, double z) {
  Pose X;
  X.p = {x, y, z};
  return X;
}

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

inline PairRule rule(ContactPolicy policy, std::optional<double> warn = {}) { return {policy, warn}; }

inline std::vector<EventKind> kinds(const FrameReport& report) {
  std::vector<EventKind> out;
  for (const ContactEvent& event : report.events) out.push_back(event.kind);
  return out;
}

}  // namespace touchstone
