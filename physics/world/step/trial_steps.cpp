#include "touchstone/physics/world/step/trial_steps.hpp"

#include <array>
#include <vector>

namespace touchstone::physics::stepping {
namespace {

constexpr double kSide = 0.2, kStep = 1e-3;

/// Of a cube's lower face on what is below it, this much apart.
void add_corners(const Mover& below, const Mover& cube, const Vector3& middle_W, double separation,
                 std::vector<Contact>& contacts) {
  for (const double x : {-0.5, 0.5})
    for (const double y : {-0.5, 0.5}) {
      Contact& contact = contacts.emplace_back();
      contact.a = below, contact.b = cube;
      contact.n_AB_W = {0, 0, 1};
      contact.p_A_W = middle_W + kSide * Vector3(x, y, 0);
      contact.p_B_W = contact.p_A_W + separation * contact.n_AB_W;
      contact.friction = 0.5;
      contact.key = contacts.size();
    }
}

}  // namespace

StepFailure take_trial_steps() {
  StepFailure failure = StepFailure::none;
  DynamicsWorld::Settings settings;
  settings.gravity_W = {0, 0, -9.81};
  DynamicsWorld world(settings);
  const RigidBody cube(box_inertia(1.0, {kSide, kSide, kSide}), "cube");
  const auto press = world.add_kinematic({}, {0, 0, -0.1}, Vector3::Zero());
  std::array<std::uint32_t, 2> cubes = {};
  for (std::uint32_t& body : cubes)
    body = world.add_body(cube, cube.state({}, Vector3::Zero(), Vector3::Zero()));
  // Deep in each other, less so, and at rest; with a press on them, and without; sliding and falling.
  for (const double separation : {-1e-2, -1e-3, 0.0})
    for (const bool is_pressed : {false, true}) {
      std::vector<Contact> contacts;
      for (std::size_t i = 0; i < cubes.size(); ++i) {
        Pose X_WB;
        X_WB.p = {0.01 * static_cast<double>(i), 0, (static_cast<double>(i) + 0.5) * kSide};
        world.set_state(cubes[i], cube.state(X_WB, {0.1 * static_cast<double>(i), 0.01, -0.1}, {0.1, 0, 0}));
        const Vector3 middle_W(X_WB.p.x(), 0, static_cast<double>(i) * kSide);
        add_corners(i == 0 ? Mover::ground() : Mover::of_body(cubes[0]), Mover::of_body(cubes[i]), middle_W,
                    separation, contacts);
      }
      if (is_pressed)
        add_corners(Mover::of_body(cubes[1]), Mover::of_body(press), {0, 0, 2 * kSide}, separation, contacts);
      for (int i = 0; i < 3; ++i) {
        const StepReport report = world.step(kStep, contacts);
        if (failure == StepFailure::none) failure = report.failure;
      }
    }
  return failure;
}

}  // namespace touchstone::physics::stepping
