// Contacts between bodies by their levers, beside the same rows written out.

#include "touchstone/physics/solver/body_contact.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>
#include <vector>

using namespace touchstone;
using namespace touchstone::physics;

namespace {

constexpr std::size_t kRates = 12;

struct Drawn {
  std::mt19937 random{1616};

  double number() { return 2.0 * static_cast<double>(random()) / 4294967296.0 - 1.0; }
  Vector3 vector() { return {number(), number(), number()}; }
  BodyContact contact(int count) {
    BodyContact drawn;
    drawn.directions[0] = vector() / 2.0 + Vector3(1, 0, 0);
    drawn.directions[0] = drawn.directions[0] / norm(drawn.directions[0]);
    drawn.directions[1] = cross(drawn.directions[0], Vector3(0, 0, 1));
    drawn.directions[1] = drawn.directions[1] / norm(drawn.directions[1]);
    drawn.directions[2] = cross(drawn.directions[0], drawn.directions[1]);
    for (Vector3& lever : drawn.levers) lever = vector();
    drawn.first[0] = 0, drawn.first[1] = 6;
    drawn.count = count;
    return drawn;
  }
};

/// The three rows of J over the rates of both bodies.
std::array<std::array<double, kRates>, 3> rows_of(const BodyContact& contact) {
  std::array<std::array<double, kRates>, 3> J = {};
  for (std::size_t r = 0; r < 3; ++r)
    for (int side = 0; side < contact.count; ++side) {
      const Vector3 linear = side == 0 ? contact.directions[r] : Vector3(-contact.directions[r]);
      const Vector3 turning = cross(contact.levers[side], linear);
      for (std::size_t k = 0; k < 3; ++k) {
        J[r][contact.first[side] + k] = linear[static_cast<int>(k)];
        J[r][contact.first[side] + 3 + k] = turning[static_cast<int>(k)];
      }
    }
  return J;
}

}  // namespace

TEST(BodyContact, VelocitiesAndImpulsesAreThoseOfItsRows) {
  Drawn drawn;
  for (int i = 0; i < 200; ++i) {
    const BodyContact contact = drawn.contact(1 + i % 2);
    const auto J = rows_of(contact);
    std::array<double, kRates> V, by_impulse = {};
    for (double& v : V) v = drawn.number();
    const double x[3] = {drawn.number(), drawn.number(), drawn.number()};
    const Vector3 v = relative_velocity(contact, V.data());
    add_impulse(contact, x, by_impulse.data());
    for (std::size_t r = 0; r < 3; ++r) {
      double expected = 0.0;
      for (std::size_t k = 0; k < kRates; ++k) expected += J[r][k] * V[k];
      EXPECT_NEAR(dot(contact.directions[r], v), expected, 1e-14) << i;
    }
    for (std::size_t k = 0; k < kRates; ++k)
      EXPECT_NEAR(by_impulse[k], (J[0][k] * x[0] + J[1][k] * x[1]) + J[2][k] * x[2], 1e-14) << i;
  }
}

TEST(BodyContact, StiffnessOfAPairIsThatOfItsRows) {
  Drawn drawn;
  for (int i = 0; i < 100; ++i) {
    const int bodies = 1 + i % 2;
    PairStiffness pair;
    pair.clear();
    std::vector<double> expected(kRates * kRates, 0.0);
    // Up to four contacts: their stiffness, and the same from rows.
    for (int c = 0; c < 4; ++c) {
      const BodyContact contact = drawn.contact(bodies);
      double G[9];
      for (std::size_t r = 0; r < 3; ++r)
        for (std::size_t k = 0; k <= r; ++k) G[3 * r + k] = G[3 * k + r] = drawn.number();
      pair.add(contact, G);
      const auto J = rows_of(contact);
      for (std::size_t h = 0; h < kRates; ++h)
        for (std::size_t k = 0; k < kRates; ++k)
          for (std::size_t r = 0; r < 3; ++r)
            for (std::size_t s = 0; s < 3; ++s) expected[h * kRates + k] += J[r][h] * G[3 * r + s] * J[s][k];
    }
    // Blocks of each body, and of both.
    double own[2][36] = {}, both[36] = {}, transposed[36] = {};
    for (int side = 0; side < bodies; ++side) pair.write_own(side, own[side]);
    if (bodies == 2) pair.write_both(true, both), pair.write_both(false, transposed);
    for (std::size_t h = 0; h < 6; ++h)
      for (std::size_t k = 0; k < 6; ++k) {
        EXPECT_NEAR(own[0][6 * h + k], expected[h * kRates + k], 1e-13) << i;
        EXPECT_NEAR(own[1][6 * h + k], expected[(h + 6) * kRates + k + 6], 1e-13) << i;
        EXPECT_NEAR(both[6 * h + k], expected[h * kRates + k + 6], 1e-13) << i;
        EXPECT_NEAR(transposed[6 * h + k], expected[(h + 6) * kRates + k], 1e-13) << i;
      }
  }
}
