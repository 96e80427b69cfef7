#include <gtest/gtest.h>

#include <cmath>

#include "touchstone/tests/world/world_fixture.hpp"

// Slides of a body that carries a part very far out.

namespace touchstone {
namespace {

struct FarSlide {
  double went = 0.0;   // of 0.2 m along the floor
  double least = 1e9;  // separation of the near body and the floor, over the frames [m]
  int blocked = 0, steps = 0;
  bool is_finite = true;
};

/// A box presses on a floor and is commanded to go along it, 20 frames of 1 cm, with a cube latched `lever`
/// away; 0: with none.
FarSlide slide_with_lever(double lever, bool sideways) {
  const auto world = make_world();
  world->set_default_rule(rule(ContactPolicy::slide));
  const ObjectHandle floor = world->add({box_tree("floor", {6, 6, 1}), at(0, 0, -0.5), true});
  const ObjectHandle box = world->add({box_tree("box", {0.6, 0.5, 0.4}), at(-1, 0, 0.2 + 5e-10)});
  if (lever > 0.0) {
    const Pose X = sideways ? at(-1 + lever, 0, 0.2) : at(-1, 0, 2 + lever);
    world->latch(box, world->add({box_tree("part", {1, 1, 1}), X}));
  }
  FarSlide out;
  for (int frame = 0; frame < 20; ++frame) {
    const FrameReport report = world->frame(std::array{world->move_by(box, {0.01, 0, -0.01}, {0, 0, 0})});
    out.blocked += report.blocked_movers > 0;
    out.steps += static_cast<int>(report.slide_steps);
    for (const ContactEvent& event : report.events)
      if ((event.a == floor && event.b == box) || (event.a == box && event.b == floor))
        if (std::isfinite(event.geometry.separation))
          out.least = std::min(out.least, event.geometry.separation);
    const Pose& X = world->actual_pose(box);
    out.is_finite = out.is_finite && is_valid_pose(X);
  }
  out.went = world->actual_pose(box).p.x() + 1.0;
  return out;
}

// A far object does not count in the metric, and the box goes along the floor as if alone: at 1e12 m it
// used to sink into the floor by the rounding of its turns' far centre, at 1e20 m through it.
TEST(FarLever, TheBoxSlidesAsIfAlone) {
  const FarSlide alone = slide_with_lever(0.0, false);
  EXPECT_NEAR(alone.went, 0.2, kGap);
  for (const bool sideways : {true, false})
    for (const double lever : {1e5, 1e7, 1e9, 1e12, 1e15, 1e20, 1e40, 1e51, 1e61, 1e100, 1e150}) {
      const FarSlide got = slide_with_lever(lever, sideways);
      EXPECT_TRUE(got.is_finite) << lever;
      EXPECT_EQ(got.went, alone.went) << lever;
      EXPECT_EQ(got.least, alone.least) << lever;
      EXPECT_GE(got.least, 0.5 * kGap) << lever;
    }
}

// Squares of lengths overflow, and nothing is known about the far part's way.
TEST(FarLever, BeyondSquaresToo) {
  for (const bool sideways : {true, false}) {
    const FarSlide got = slide_with_lever(1e155, sideways);
    EXPECT_TRUE(got.is_finite);
    EXPECT_NEAR(got.went, 0.2, kGap);
    EXPECT_GE(got.least, 0.5 * kGap);
  }
}

// Shorter levers count: the two are one body with one centre of mass.
TEST(FarLever, ShortLeversCount) {
  for (const double lever : {1.0, 1e3}) {
    const FarSlide got = slide_with_lever(lever, true);
    EXPECT_NEAR(got.went, 0.2, 1e-4) << lever;
    EXPECT_GE(got.least, 0.5 * kGap) << lever;
  }
}

// A body whose own hexahedra are all too far from its origin advances to the contact and stays there.
TEST(FarLever, ABodyFarFromItsOriginDoesNotSlide) {
  const auto world = make_world();
  world->set_default_rule(rule(ContactPolicy::slide));
  world->add({box_tree("floor", {6, 6, 1}), at(0, 0, -0.5), true});
  const auto tree = std::make_shared<HexahedronTree>(
      std::vector<PlacedHexahedron>{{"box", Hexahedron::from_size({0.6, 0.5, 0.4}), at(-0x1p20, 0, 0)}},
      "box");
  const ObjectHandle box = world->add({tree, at(0x1p20, 0, 0.25)});
  double least = 1.0;
  for (int frame = 0; frame < 10; ++frame) {
    const FrameReport report = world->frame(std::array{world->move_by(box, {0.01, 0, -0.02}, {0, 0, 0})});
    for (const ContactEvent& event : report.events) least = std::min(least, event.geometry.separation);
    EXPECT_EQ(report.slide_steps, 0u);
  }
  EXPECT_GE(least, 0.0);
  EXPECT_LT(world->actual_pose(box).p.x() - 0x1p20, 0.03);
}

}  // namespace
}  // namespace touchstone
