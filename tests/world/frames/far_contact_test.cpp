#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "touchstone/tests/world/world_fixture.hpp"

// The contact distance grows with the distance from the origin, of carried objects with their carrier's:
// twice 1.4e-14 of it ends one. Pairs are looked for that far, however little the world's own gap is.

namespace touchstone {
namespace {

/// The gap of unit cubes about `distance` from the origin: GapRule over native's resolution.
double gap_at(double distance) { return 4.0 * 32 * 0x1p-53 * distance; }

bool names(const FrameReport& report, EventKind kind) {
  return std::any_of(report.events.begin(), report.events.end(),
                     [&](const ContactEvent& event) { return event.kind == kind; });
}

class FarContact : public testing::TestWithParam<std::string> {};

/// Two cubes corner to corner, where their bounding spheres are as near as they are: one stands, the other
/// comes within the gap by just less than broadphases are given in advance (an eighth of a radius), and
/// rests.
/// @param carrier where the moving one's carrier is, along x from it; 0: it has none.
void expect_contact(ContactWorld& world, double distance, double carrier) {
  world.set_default_rule(rule(ContactPolicy::advance));
  Pose X = at(distance, 0, 0);
  world.add({box_tree("neighbour", {1, 1, 1}), X, true});
  const double radius = 0.5 * std::sqrt(3.0), gap = gap_at(distance + carrier);
  const double way = 0.125 * radius - 0.02 * gap;
  const Vector3 diagonal = Vector3::Constant(1.0 / std::sqrt(3.0));
  X.p += (2.0 * radius + 0.85 * gap + way) * diagonal;
  ObjectHandle mover = world.add({box_tree("box", {1, 1, 1}), X});
  if (carrier > 0.0) {
    X.p.x() += carrier;
    const ObjectHandle box = mover;
    mover = world.add({box_tree("carrier", {1, 1, 1}), X});
    world.latch(mover, box);
  }
  world.frame({});
  const FrameReport met = world.frame(std::array{world.move_by(mover, -way * diagonal, {0, 0, 0})});
  EXPECT_TRUE(names(met, EventKind::began));
  for (int frame = 0; frame < 3; ++frame) EXPECT_TRUE(names(world.frame({}), EventKind::persists)) << frame;
}

TEST_P(FarContact, BeginsAndPersistsWhatRestsBesideAStaticNeighbour) {
  for (const double distance : {0x1p33, 0x1p37, 0x1p40}) {
    SCOPED_TRACE(distance);
    expect_contact(*make_world(GetParam()), distance, 0.0);
  }
}

TEST_P(FarContact, BeginsAndPersistsWhatAFarCarrierBroughtThere) {
  for (const double distance : {0x1p33, 0x1p37}) {
    SCOPED_TRACE(distance);
    expect_contact(*make_world(GetParam()), 0.0, distance);
  }
}

INSTANTIATE_TEST_SUITE_P(Broadphases, FarContact, testing::Values("native", "brute_force"),
                         [](const auto& of) { return of.param; });

}  // namespace
}  // namespace touchstone
