#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "world_fixture.hpp"

// Slides of a body that carries a part very far out.

namespace touchstone {
namespace {

struct FarSlide {
  double went = 0.0;    // of 0.2 m along the floor
  double least = 1e9;   // separation of the near body and the floor, over the frames [m]
  int blocked = 0, steps = 0;
  bool is_finite = true;
};

/// A box presses on a floor and is told to go along it, 20 frames of 1 cm, with a cube latched `lever` away.
FarSlide slide_with_lever(double lever, bool sideways) {
  const auto world = make_world();
  world->set_default_rule(rule(ContactPolicy::slide));
  const ObjectHandle floor = world->add({box_tree("floor", {6, 6, 1}), at(0, 0, -0.5), true});
  const ObjectHandle box = world->add({box_tree("box", {0.6, 0.5, 0.4}), at(-1, 0, 0.2 + 5e-10)});
  const ObjectHandle part =
      world->add({box_tree("part", {1, 1, 1}), sideways ? at(-1 + lever, 0, 0.2) : at(-1, 0, 2 + lever)});
  world->latch(box, part);
  FarSlide out;
  for (int frame = 0; frame < 20; ++frame) {
    const FrameReport report = world->frame(std::array{world->move_by(box, {0.01, 0, -0.01}, {0, 0, 0})});
    out.blocked += report.blocked_movers > 0;
    out.steps += static_cast<int>(report.slide_steps);
    for (const ContactEvent& event : report.events)
      if ((event.a == floor && event.b == box) || (event.a == box && event.b == floor))
        if (std::isfinite(event.geometry.separation)) out.least = std::min(out.least, event.geometry.separation);
    const Pose& X = world->actual_pose(box);
    out.is_finite = out.is_finite && is_valid_pose(X);
  }
  out.went = world->actual_pose(box).p.x() + 1.0;
  return out;
}

TEST(FarLever, Measures) {
  for (const bool sideways : {true, false})
    for (const double lever : {1e0, 1e3, 1e5, 1e6, 1e7, 1e8, 1e9, 1e12, 1e15, 1e20, 1e40, 1e51, 1e61, 1e100, 1e150, 1e155}) {
      const FarSlide got = slide_with_lever(lever, sideways);
      std::printf("%s lever %.0e: went %.9g, least %.4g g, blocked %d, steps %d, %s\n", sideways ? "side" : "up",
                  lever, got.went, got.least / kGap, got.blocked, got.steps, got.is_finite ? "finite" : "NOT FINITE");
    }
}

}  // namespace
}  // namespace touchstone
