#include <cstdio>

#include "touchstone/contact_core/broadphase/register_broadphases.hpp"
#include "touchstone/contact_core/native/native.hpp"
#include "touchstone/physics/contacts/narrowphase_contacts.hpp"

using namespace touchstone;
using namespace touchstone::physics;

int main() {
  DynamicsWorld world({.gravity_W = {0, 0, -9.81}});
  const HexahedronTree box({{"hull", Hexahedron::from_size({1, 1, 1}), Pose{}}}, "box");  // [m]
  const HexahedronTree floor({{"slab", Hexahedron::from_size({20, 20, 1}), Pose{}}}, "floor");
  const RigidBody body(box_inertia(2.0, {1, 1, 1}), "box");  // [kg]
  // At 2 m/s along x.
  const auto thrown = world.add_body(body, body.state(Pose{}, {2, 0, 0}, Vector3::Zero()));

  // Any backend that has manifolds; points up to a millimetre apart.
  NarrowphaseContacts contacts(make_native_broadphase(), make_native(), 1e-3);
  contacts.add(Mover::of_body(thrown), box, {.friction = 0.5});
  contacts.add(Mover::ground(), floor, {.friction = 0.5}, {Matrix3::Identity(), {0, 0, -1}});  // 0.5 m below
  contacts.build();

  StepReport report;
  for (int i = 0; i < 100 && report.failure == StepFailure::none; ++i)
    report = world.step(0.01, contacts.find(world, 0.01));
  std::printf("%s after %.6f m at %.1g m/s; v^2 / (2 mu g) = %.6f m\n", to_string(report.failure).data(),
              world.pose(thrown).p.x(), norm(world.velocity(thrown)), 2.0 * 2.0 / (2 * 0.5 * 9.81));
}
