#include <cstdio>
#include <memory>

#include "touchstone/contact_core/broadphase/register_broadphases.hpp"
#include "touchstone/contact_core/native/native.hpp"
#include "touchstone/contact_core/world/contact_world.hpp"

using namespace touchstone;

int main() {
  ContactWorld world(make_native(), make_native_broadphase());  // keeps a gap of 1e-7 m
  const auto box = [](const char* name, const Vector3& size) {
    return std::make_shared<const HexahedronTree>(
        std::vector<PlacedHexahedron>{{"hull", Hexahedron::from_size(size), Pose{}}}, name);
  };
  const ObjectHandle tool = world.add({box("tool", {0.2, 0.2, 0.2}), Pose{}});
  const ObjectHandle wall = world.add({box("wall", {0.01, 2, 2}), {Matrix3::Identity(), {0.5, 0, 0}}, true});
  world.set_default_rule({ContactPolicy::advance});

  // One frame at 10 Hz, 10 m/s: both ends of the way are clear of the wall, the way is not.
  const MotionCommand command = world.move_by(tool, {1.0, 0, 0}, Vector3::Zero());
  const FrameReport report = world.frame({&command, 1});
  for (const ContactEvent& event : report.events)
    std::printf("%s: %s and %s at %.3f of the frame, %.1e m apart\n", to_string(event.kind).data(),
                world.name_of(event.a).data(), world.name_of(event.b).data(), event.s,
                event.geometry.separation);
  std::printf("shown at x = %.9f m; the wall begins at 0.495 m\n", world.actual_pose(tool).p.x());
  return world.is_alive(wall) ? 0 : 1;
}
