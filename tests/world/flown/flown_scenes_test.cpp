// The bundled scenes flown through the contact world, against answers derived by hand. Poses are met to 2 g,
// times to 2 g / closing speed + 1e-12 s.

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <optional>

#include "touchstone/adapters/scene_files/scene_file.hpp"
#include "touchstone/contact_core/registry.hpp"
#include "touchstone/contact_core/world/scene_world.hpp"
#include "touchstone/tests/support/degree.hpp"
#include "touchstone/tests/world/flown/bundled_scene.hpp"

namespace touchstone {
namespace {

constexpr double kGap = 1e-9;

/// A flight's result: when each object was first stopped, and when contact first began and last ended [s].
struct Flight {
  std::map<std::string, double> stopped;
  std::optional<double> began, ended;
  std::map<std::string, Pose> last;
  double deepest = 0.0;
  std::uint32_t iteration_limits = 0;
};

Flight fly(const Scene& scene) {
  BackendRegistry registry;
  register_core(registry);
  SceneWorld flown(scene, registry.make_narrowphase("native"), registry.make_broadphase("native"));
  Flight flight;
  for (std::uint64_t k = 0; k + 1 < scene.frame_count(); ++k) {
    const FrameReport report = flown.step();
    flight.iteration_limits += report.iteration_limits;
    for (const ContactEvent& event : report.events) {
      const double time = flown.time_of(event);
      for (const ObjectHandle object : {event.a, event.b})
        if (event.kind == EventKind::blocked) flight.stopped.emplace(flown.world().name_of(object), time);
      if (event.kind == EventKind::began && !flight.began) flight.began = time;
      if (event.kind == EventKind::ended) flight.ended = flown.time();
      flight.deepest = std::min(flight.deepest, event.geometry.separation);
    }
  }
  for (std::size_t i = 0; i < scene.objects.size(); ++i)
    flight.last[scene.objects[i].tree.name()] = flown.world().actual_pose(flown.object(i));
  EXPECT_EQ(flight.iteration_limits, 0u);
  return flight;
}

void expect_time(double time, double closed_form, double closing_speed) {
  EXPECT_LE(time, closed_form + 1e-12);
  EXPECT_GE(time, closed_form - 2 * kGap / closing_speed - 1e-12);
}

TEST(FlownScenes, GrappleMouthMeetsThePlate) {
  const Flight flight = fly(scene_from("grapple_approach.yaml"));
  expect_time(flight.stopped.at("lee"), 0.5 / 0.02, 0.02);
  EXPECT_NEAR(flight.last.at("lee").p.z(), 0.0, 2 * kGap);
}

TEST(FlownScenes, GrappleRimMeetsTheTaper) {
  const Flight flight = fly(scene_from("grapple_approach.yaml", {{"offset", 0.090}}));
  // The rim is at 0.010 from the axis, where the taper, from 0.019 at 0.25443 to 0.005 at 0.27343, is as
  // wide.
  const double mouth = 0.25443 + 0.019 * (0.019 - 0.010) / (0.019 - 0.005);
  EXPECT_NEAR(mouth, 0.266644, 5e-7);
  EXPECT_NEAR(flight.last.at("lee").p.z(), mouth, 3 * kGap);
  EXPECT_NEAR(flight.stopped.at("lee"), (0.5 - mouth) / 0.02, 1e-6);
  EXPECT_NEAR(flight.stopped.at("lee"), 11.667786, 5e-6);
}

TEST(FlownScenes, GrappleJustClears) {
  expect_time(fly(scene_from("grapple_approach.yaml", {{"offset", 0.081 - 3 * kGap}})).stopped.at("lee"),
              25.0, 0.02);
  EXPECT_LT(fly(scene_from("grapple_approach.yaml", {{"offset", 0.081 + 1e-6}})).stopped.at("lee"), 13.0);
}

TEST(FlownScenes, JawsStopEachForItself) {
  Flight flight = fly(scene_from("otcm_jaws.yaml"));
  expect_time(flight.stopped.at("left jaw"), 2.2, 0.005);
  expect_time(flight.stopped.at("right jaw"), 2.2, 0.005);
  flight = fly(scene_from("otcm_jaws.yaml", {{"offset", 3}}));
  expect_time(flight.stopped.at("right jaw"), 1.6, 0.005);
  expect_time(flight.stopped.at("left jaw"), 2.8, 0.005);
  EXPECT_NEAR(flight.last.at("right jaw").p.x() - flight.last.at("left jaw").p.x() - 0.020, 0.038, 4 * kGap);
}

TEST(FlownScenes, OruIsClearAt29AndMeetsTheRimAt31) {
  Flight flight = fly(scene_from("oru_insertion.yaml", {{"offset", 0.0029}}));
  expect_time(flight.stopped.at("oru"), 0.525 / 0.02, 0.02);
  flight = fly(scene_from("oru_insertion.yaml", {{"offset", 0.0031}, {"lift", 0.01}}));
  expect_time(flight.stopped.at("oru"), 0.01 / 0.02, 0.02);
}

TEST(FlownScenes, TiltedOruStopsWhereItTouches) {
  for (const auto& [degrees, depth] : {std::pair{0.5, 0.345771}, {1.0, 0.175879}, {2.0, 0.093924}}) {
    const double t = degrees * kDegree, W = 0.919, c = 0.003, lift = 0.01 + W / 2 * std::sin(t);
    const double h = (W / 2 * (1 - std::cos(t)) + c) / std::tan(t);
    EXPECT_NEAR(h, depth, 5e-7);
    const Flight flight = fly(scene_from("oru_insertion.yaml", {{"tilt", degrees}, {"lift", lift}}));
    const double lowest = flight.last.at("oru").p.z() - W / 2 * std::sin(t);
    // A tilted wall is met at an angle: the gap across it is a longer way down it.
    EXPECT_NEAR(-lowest, h, 2 * kGap / std::sin(t)) << degrees;
  }
}

TEST(FlownScenes, ElbowIsCuedInAndOut) {
  const Flight flight = fly(scene_from("elbow_into_lab.yaml"));
  // 7.11 sin a + 0.175 cos a = 1.3589
  const double a = std::asin(1.3589 / std::hypot(7.11, 0.175)) - std::atan2(0.175, 7.11);
  EXPECT_NEAR(a / kDegree, 9.605129, 5e-7);
  const double time = a / (4 * kDegree), closing = 7.11 * std::cos(a) * 4 * kDegree;
  EXPECT_NEAR(time, 2.401282, 5e-7);
  expect_time(*flight.began, time, closing);
  EXPECT_NEAR(flight.deepest, -0.290528, 5e-7);
  EXPECT_NEAR(*flight.ended, 6 - time, 0.02);  // reported at the end of its frame
}

TEST(FlownScenes, ThinPlatesAndBarDoNotTunnel) {
  expect_time(fly(scene_from("tunnelling_plates.yaml")).stopped.at("payload"), 0.005 / 0.37, 0.37);
  const double r = 16.9628, time = std::asin(0.005 / r) / (4 * kDegree);
  EXPECT_NEAR(time, 4.222164e-3, 5e-10);
  expect_time(fly(scene_from("tunnelling_bar.yaml")).stopped.at("arm"), time, 0.999 * r * 4 * kDegree);
}

TEST(FlownScenes, ContainedObjectIsContactInASolidBoxOnly) {
  BackendRegistry registry;
  register_core(registry);
  for (const bool solid : {true, false}) {
    Scene scene = scene_from(solid ? "contained_solid.yaml" : "contained_walls.yaml");
    // Nothing moves in it, so nothing would be checked: nudge the cube.
    scene.objects[1].motion.segments.push_back({0.0, 1.0, {1e-4, 0, 0}});
    SceneWorld flown(scene, registry.make_narrowphase("native"), registry.make_broadphase("native"));
    const FrameReport report = flown.step();
    ASSERT_EQ(report.events.empty(), !solid);
    if (solid) {
      EXPECT_EQ(report.events[0].kind, EventKind::penetrating_at_start);
      EXPECT_NEAR(report.events[0].geometry.separation, -0.2725, 1e-12);
    }
  }
}

}  // namespace
}  // namespace touchstone
