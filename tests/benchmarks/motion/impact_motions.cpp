#include "touchstone/tests/benchmarks/motion/impact_motions.hpp"

#include "touchstone/contact_core/geometry/matrix3.hpp"
#include "touchstone/tests/support/random_poses.hpp"
#include "touchstone/tests/support/random_solid.hpp"

namespace touchstone::impact {
namespace {

using Random64 = std::mt19937_64;

Hexahedron random_box(Random64& random) { return Hexahedron::from_size(random_vector(random, 0.1, 0.7)); }

Hexahedron random_hexahedron(Random64& random) {
  Random own(random());
  return random_solid(own, 1.0);
}

/// A from `from` to beyond B, which turns about its own centre: some pass it by.
Motion aimed(Random64& random, Hexahedron a, Hexahedron b, double turn) {
  const Pose X_WB = random_pose(random, Vector3::Zero(), 0.2);
  const Pose X_WA = random_pose(random, Vector3(-2, 0, 0), 0.3);
  const Vector3 way = Vector3(4, 0, 0) + random_vector(random, 0.7);
  const Vector3 turn_a = random_vector(random, turn), turn_b = random_vector(random, turn);
  return {std::move(a), std::move(b), RigidPath::by(X_WA, way, turn_a),
          RigidPath::by(X_WB, random_vector(random, 0.2), turn_b)};
}

Motion translated(Random64& random) {
  Hexahedron a = random_box(random), b = random_box(random);
  return aimed(random, std::move(a), std::move(b), 0.0);
}

Motion boxes(Random64& random) {
  Hexahedron a = random_box(random), b = random_box(random);
  return aimed(random, std::move(a), std::move(b), 0.8);
}

Motion hexahedra(Random64& random) {
  Hexahedron a = random_hexahedron(random), b = random_hexahedron(random);
  return aimed(random, std::move(a), std::move(b), 0.8);
}

/// 2 mm thick, 20 to 100 m a frame: what poses at a frame's ends never see.
Motion plates(Random64& random) {
  const Hexahedron plate = Hexahedron::from_size({0.002, 1.0, 1.0});
  const Pose X_WB{random_rotation(random), Vector3::Zero()};
  const Pose X_WA{random_rotation(random), Vector3(-10, 0, 0) + random_vector(random, 0.5)};
  const double speed = uniform(random, 20.0, 100.0);
  return {plate, plate, RigidPath::by(X_WA, Vector3(speed, 0, 0), random_vector(random, 0.1)),
          RigidPath(X_WB)};
}

/// Along a floor, 1e-6 to 1e-3 m above it: nothing meets.
Motion flush(Random64& random) {
  const Vector3 size = random_vector(random, 0.1, 0.7);
  const double height = 1e-6 * std::pow(10.0, uniform(random, 0.0, 3.0));
  const double turn = uniform(random, -1.0, 1.0);
  const Pose X_WA{rotation_about(Vector3::UnitZ(), uniform(random, -3.0, 3.0)),
                  {-1, 0, 0.5 * size.z() + height}};
  return {Hexahedron::from_size(size), Hexahedron::from_size({6, 6, 0.5}),
          RigidPath::by(X_WA, {uniform(random, 0.5, 2.0), 0, 0}, {0, 0, turn}),
          RigidPath(Pose{Matrix3::Identity(), {0, 0, -0.25}})};
}

/// A bar of 2 m, 0.02 m thick, turns about its middle by up to 3 rad, past or onto a small box.
Motion bars(Random64& random) {
  const Pose X_WA{random_rotation(random), Vector3::Zero()};
  const Vector3 axis = rotate(X_WA.R, Vector3(0, 0, uniform(random, 1.0, 3.0)));
  const double angle = uniform(random, -3.0, 3.0), lever = uniform(random, 0.2, 1.1);
  const Vector3 p_A(lever * std::cos(angle), lever * std::sin(angle), uniform(random, -0.06, 0.06));
  const Pose X_WB{random_rotation(random), rotate(X_WA.R, p_A)};
  return {Hexahedron::from_size({2.0, 0.02, 0.02}), Hexahedron::from_size({0.05, 0.05, 0.05}),
          RigidPath::by(X_WA, Vector3::Zero(), axis), RigidPath(X_WB)};
}

}  // namespace

std::vector<Family> families() {
  return {{"boxes, no turning", translated}, {"boxes", boxes},        {"hexahedra", hexahedra},
          {"thin plates, fast", plates},     {"flush slides", flush}, {"turning bars", bars}};
}

}  // namespace touchstone::impact
