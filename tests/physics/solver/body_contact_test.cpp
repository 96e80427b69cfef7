// Contacts between bodies by their levers, four side by side, beside the same rows written out.

#include "touchstone/physics/solver/body_contact_lanes.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>
#include <vector>

using namespace touchstone;
using namespace touchstone::physics;

namespace {

constexpr std::size_t kRates = 12, kLanes = BodyContacts::kLanes;

struct Drawn {
  std::mt19937 random{1616};

  double number() { return 2.0 * static_cast<double>(random()) / 4294967296.0 - 1.0; }
  Vector3 vector() { return {number(), number(), number()}; }
  /// The last lane may be empty.
  BodyContacts contacts(int bodies, std::size_t lanes) {
    BodyContacts drawn;
    drawn.first[1] = 6;
    drawn.count = bodies;
    drawn.contacts = lanes;
    for (std::size_t lane = 0; lane < lanes; ++lane) {
      Vector3 directions[3] = {vector() / 2.0 + Vector3(1, 0, 0)};
      directions[0] = directions[0] / norm(directions[0]);
      directions[1] = cross(directions[0], Vector3(0, 0, 1));
      directions[1] = directions[1] / norm(directions[1]);
      directions[2] = cross(directions[0], directions[1]);
      for (std::size_t k = 0; k < 3; ++k) {
        for (std::size_t d = 0; d < 3; ++d) drawn.directions[d][k][lane] = directions[d][static_cast<int>(k)];
        for (auto& lever : drawn.levers) lever[k][lane] = number();
      }
    }
    return drawn;
  }
};

Vector3 vector_of(const double (&of)[3][kLanes], std::size_t lane) {
  return {of[0][lane], of[1][lane], of[2][lane]};
}

/// The three rows of a lane's J over the rates of both bodies.
std::array<std::array<double, kRates>, 3> rows_of(const BodyContacts& contacts, std::size_t lane) {
  std::array<std::array<double, kRates>, 3> J = {};
  for (std::size_t r = 0; r < 3; ++r)
    for (int side = 0; side < contacts.count; ++side) {
      const Vector3 linear = (side == 0 ? 1.0 : -1.0) * vector_of(contacts.directions[r], lane);
      const Vector3 turning = cross(vector_of(contacts.levers[side], lane), linear);
      for (std::size_t k = 0; k < 3; ++k) {
        J[r][contacts.first[side] + k] = linear[static_cast<int>(k)];
        J[r][contacts.first[side] + 3 + k] = turning[static_cast<int>(k)];
      }
    }
  return J;
}

}  // namespace

TEST(BodyContact, VelocitiesAndImpulsesAreThoseOfItsRows) {
  Drawn drawn;
  for (int i = 0; i < 200; ++i) {
    const BodyContacts contacts = drawn.contacts(1 + i % 2, 1 + static_cast<std::size_t>(i) % kLanes);
    // Velocities, impulses and reach of all lanes at once.
    std::array<double, kRates> V, by_impulse = {}, expected_impulse = {}, reach = {};
    for (double& v : V) v = drawn.number();
    std::array<double, BodyContacts::kRows> x = {}, u = {};
    for (double& impulse : x) impulse = drawn.number();
    put(along_directions(contacts, relative_velocities(contacts, V.data())), u.data());
    add_impulses(contacts, lanes_at(x.data()), -1.0, by_impulse.data());
    raise_reach(contacts, reach.data());
    // The same from each contact's rows.
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      const auto J = rows_of(contacts, lane);
      for (std::size_t r = 0; r < 3; ++r) {
        double expected = 0.0;
        for (std::size_t k = 0; k < kRates; ++k) {
          expected += J[r][k] * V[k];
          expected_impulse[k] -= J[r][k] * x[kLanes * r + lane];
          EXPECT_LE(std::abs(J[r][k]), reach[k]) << i;
        }
        EXPECT_NEAR(u[kLanes * r + lane], expected, 1e-14) << i;
      }
    }
    for (std::size_t k = 0; k < kRates; ++k) EXPECT_NEAR(by_impulse[k], expected_impulse[k], 1e-14) << i;
  }
}

TEST(BodyContact, StiffnessOfAPairIsThatOfItsRows) {
  Drawn drawn;
  for (int i = 0; i < 100; ++i) {
    const int bodies = 1 + i % 2;
    PairStiffness pair;
    std::vector<double> expected(kRates * kRates, 0.0);
    // Four contacts, then two: their stiffness, and the same from rows.
    for (const std::size_t lanes : {kLanes, std::size_t{2}}) {
      const BodyContacts contacts = drawn.contacts(bodies, lanes);
      double G[kStiffnessLanes];
      for (double& entry : G) entry = drawn.number();
      const SymmetricLanes by_lane = symmetric_at(G);
      pair.add(contacts, by_lane);
      for (std::size_t lane = 0; lane < kLanes; ++lane) {
        const auto J = rows_of(contacts, lane);
        for (std::size_t h = 0; h < kRates; ++h)
          for (std::size_t k = 0; k < kRates; ++k)
            for (std::size_t r = 0; r < 3; ++r)
              for (std::size_t s = 0; s < 3; ++s) {
                double entry[kLanes];
                put(by_lane(static_cast<int>(r), static_cast<int>(s)), entry);
                expected[h * kRates + k] += J[r][h] * entry[lane] * J[s][k];
              }
      }
    }
    // Blocks of each body, and of both.
    double own[2][36] = {}, both[36] = {}, transposed[36] = {};
    for (int side = 0; side < bodies; ++side) pair.write_own(side, own[side]);
    if (bodies == 2) pair.write_both(true, both), pair.write_both(false, transposed);
    for (std::size_t h = 0; h < 6; ++h)
      for (std::size_t k = 0; k < 6; ++k) {
        EXPECT_NEAR(both[6 * h + k], expected[h * kRates + k + 6], 1e-13) << i;
        EXPECT_NEAR(transposed[6 * h + k], expected[(h + 6) * kRates + k], 1e-13) << i;
        if (k > h) continue;  // the lower triangle
        EXPECT_NEAR(own[0][6 * h + k], expected[h * kRates + k], 1e-13) << i;
        EXPECT_NEAR(own[1][6 * h + k], expected[(h + 6) * kRates + k + 6], 1e-13) << i;
      }
  }
}
