#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <random>
#include <vector>

#include "touchstone/contact_core/geometry/matrix3.hpp"
#include "touchstone/physics/bodies/inertia.hpp"
#include "touchstone/physics/solver/contact_problem.hpp"
#include "touchstone/tests/support/random_poses.hpp"

namespace touchstone::physics {

/// Velocities, inverse masses and places of free bodies; contacts between them and the ground.
struct RandomSet {
  static constexpr std::size_t kContacts = 8, kRows = 3 * kContacts;

  struct Body {
    double mass;
    Matrix3 inverse_inertia;
    Vector3 centre, v, w;
  };
  std::vector<Body> bodies;
  std::vector<double> W = std::vector<double>(kRows * kRows), b = std::vector<double>(kRows),
                      friction = std::vector<double>(kContacts);
  std::vector<double> J, Y;  // W = J Y^T

  /// One to five boxes with masses from 1e-3 to 1e3 kg, sides 0.2 to 1 m and velocities up to 1 m/s, and
  /// eight contacts of any two (or the ground): with any normal, or with that between the centres.
  RandomSet(std::mt19937_64& random, double mu, bool along_centres) {
    const std::size_t count = 1 + random() % 5;
    for (std::size_t i = 0; i < count; ++i) {
      Body body;
      body.mass = std::pow(10.0, uniform(random, -3, 3));
      const BodyInertia box = box_inertia(body.mass, random_vector(random, 0.2, 1.0));
      body.inverse_inertia = symmetric_inverse(turned(random_rotation(random), box.inertia_B));
      body.centre = random_vector(random, 1.0);
      body.v = random_vector(random, 1.0);
      body.w = random_vector(random, 1.0);
      bodies.push_back(body);
    }
    std::fill(friction.begin(), friction.end(), mu);
    J.resize(kRows * 6 * count, 0.0);
    Y = J;
    for (std::size_t c = 0; c < kContacts; ++c) add_contact(random, c, along_centres);
    const std::size_t width = 6 * count;
    for (std::size_t r = 0; r < kRows; ++r)
      for (std::size_t s = 0; s <= r; ++s) {
        double sum = 0.0;
        for (std::size_t k = 0; k < width; ++k) sum += J[r * width + k] * Y[s * width + k];
        W[r * kRows + s] = W[s * kRows + r] = sum;
      }
  }

  void add_contact(std::mt19937_64& random, std::size_t c, bool along_centres) {
    // Two movers, of which one may be the ground.
    const std::size_t count = bodies.size();
    const std::size_t first = random() % (count + 1);  // `count`: the ground
    std::size_t second = first;
    while (second == first) second = random() % (count + 1);
    const auto centre = [&](std::size_t i) {
      return i == count ? Vector3(Vector3::Zero()) : bodies[i].centre;
    };
    // A normal, a place and tangents.
    Vector3 n = along_centres ? Vector3(centre(second) - centre(first)) : random_vector(random, 1.0);
    n = n / norm(n);
    const Vector3 p = 0.5 * (centre(first) + centre(second)) + random_vector(random, 0.5);
    Vector3 t1 = cross(n, std::abs(n.x()) < 0.6 ? Vector3(1, 0, 0) : Vector3(0, 1, 0));
    t1 = t1 / norm(t1);
    const Vector3 directions[3] = {n, t1, cross(n, t1)};
    // Rows of the Jacobian, what unit impulses do, and the relative velocity.
    for (std::size_t r = 3 * c; r < 3 * c + 3; ++r)
      for (const double sign : {-1.0, 1.0}) {
        const std::size_t i = sign < 0.0 ? first : second;
        if (i == count) continue;
        const Body& body = bodies[i];
        const Vector3 linear = sign * directions[r - 3 * c], angular = cross(p - body.centre, linear);
        const Vector3 dv = linear / body.mass, dw = rotate(body.inverse_inertia, angular);
        for (int k = 0; k < 3; ++k) {
          const std::size_t at = (r * count + i) * 6 + static_cast<std::size_t>(k);
          J[at] = linear[k], J[at + 3] = angular[k];
          Y[at] = dv[k], Y[at + 3] = dw[k];
        }
        b[r] += dot(linear, body.v) + dot(angular, body.w);
      }
  }

  ContactProblem problem() const { return {kContacts, friction, {}, W, b}; }
  /// The same in parts.
  ContactProblem by_rates() const { return {kContacts, friction, {}, {}, b, 6 * bodies.size(), J, Y}; }
};

}  // namespace touchstone::physics
