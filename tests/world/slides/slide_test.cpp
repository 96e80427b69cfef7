#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iostream>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/motion/mass_metric.hpp"
#include "touchstone/contact_core/native/native.hpp"
#include "touchstone/tests/support/degree.hpp"
#include "touchstone/tests/world/world_fixture.hpp"

namespace touchstone {
namespace {

PairRule slide_rule(bool translation_only = false) {
  PairRule out = rule(ContactPolicy::slide);
  out.translation_only = translation_only;
  return out;
}

/// Sub-steps over the frames of a run, where there are any.
struct Steps {
  std::vector<std::uint32_t> counts;
  std::uint64_t queries = 0;
  std::uint32_t limits = 0;
  void add(const FrameReport& report) {
    if (report.slide_steps > 0) counts.push_back(report.slide_steps);
    queries = std::max(queries, report.queries);
    limits += report.iteration_limits;
  }
  std::uint32_t median() {
    if (counts.empty()) counts.push_back(0);
    std::sort(counts.begin(), counts.end());
    return counts[counts.size() / 2];
  }
  std::uint32_t worst() { return *std::max_element(counts.begin(), counts.end()); }
  void print(const char* name) {
    std::cout << name << ": sub-steps a frame, median " << median() << ", worst " << worst() << " of "
              << counts.size() << " frames that slid; queries, worst " << queries << "\n";
    EXPECT_EQ(limits, 0u) << name;
  }
};

// Scene 3: an ORU, W x H x L, over a slot of width W + 2c; z up, the slot's floor at 0.525 below its mouth
// (z = 0). Tilted by t about its length (y), the middle of its bottom edge over the slot's middle.
struct Insertion {
  static constexpr double kWidth = 0.919, kLength = 1.050, kHeight = 0.6, kClearance = 0.003, kDepth = 0.525;
  std::unique_ptr<ContactWorld> world = make_world();
  ObjectHandle oru;

  Insertion(double tilt, const PairRule& pair_rule, double lateral = 0.0) {
    world->set_default_rule(pair_rule);
    const double inner = kWidth / 2 + kClearance;
    std::vector<PlacedHexahedron> slot;
    slot.push_back({"left", Hexahedron::from_size({0.2, 4, 0.8}), at(-inner - 0.1, 0, -0.4)});
    slot.push_back({"right", Hexahedron::from_size({0.2, 4, 0.8}), at(inner + 0.1, 0, -0.4)});
    slot.push_back({"floor", Hexahedron::from_size({2, 4, 0.2}), at(0, 0, -kDepth - 0.1)});
    world->add({std::make_shared<HexahedronTree>(slot, "slot"), Pose{}, true});
    Pose X = at(0, 0, 0);
    X.R = rotation_about(Vector3::UnitY(), tilt);
    // The bottom's middle at (lateral, 0, z), its lowest corner 10 mm above the mouth.
    const Vector3 bottom = rotate(X.R, {0, 0, -kHeight / 2});
    X.p = Vector3(lateral, 0, 0.01 + kWidth / 2 * std::abs(std::sin(tilt))) - bottom;
    oru = world->add({box_tree("oru", {kWidth, kLength, kHeight}), X});
  }
  FrameReport down(double step) {
    return world->frame(std::array{world->move_by(oru, {0, 0, -step}, {0, 0, 0})});
  }
  /// Depth of the corner of the bottom that is nearest to a wall.
  double depth_at_wall() const {
    double depth = 0.0, furthest = 0.0;
    for (const double side : {-0.5, 0.5}) {
      const Vector3 p = transform(world->actual_pose(oru), {side * kWidth, 0.5 * kLength, -0.5 * kHeight});
      if (std::abs(p.x()) > furthest) furthest = std::abs(p.x()), depth = -p.z();
    }
    return depth;
  }
  /// Insertion depth of the lowest corner.
  double depth() const {
    WorldVertices v;
    world_vertices(Hexahedron::from_size({kWidth, kLength, kHeight}), world->actual_pose(oru), v);
    return -*std::min_element(v.z.begin(), v.z.end());
  }
  double tilt() const { return std::asin(world->actual_pose(oru).R(0, 2)); }
};

TEST(Slide, TranslationOnlyInsertionWedges) {
  for (const double degrees : {1.0, 2.0}) {
    const double t = degrees * kDegree;
    Insertion scene(t, slide_rule(true));
    Steps steps;
    for (int i = 0; i < 260; ++i) steps.add(scene.down(0.002));
    const double closed_form =
        ((Insertion::kWidth + 2 * Insertion::kClearance) * std::cos(t) - Insertion::kWidth) / std::sin(t);
    EXPECT_NEAR(scene.depth_at_wall(), closed_form, 2 * kGap / std::sin(t)) << degrees;
    EXPECT_NEAR(closed_form, degrees == 1.0 ? 0.3357 : 0.1558, 5e-5);
    EXPECT_NEAR(scene.tilt(), t, 1e-12);
    std::cout << "wedged at " << scene.depth_at_wall() << " m, off by " << scene.depth_at_wall() - closed_form
              << "\n";
    steps.print("wedging");
  }
}

TEST(Slide, InsertionAlignsAndBottoms) {
  for (const double degrees : {0.5, 1.0, 2.0}) {
    Insertion scene(degrees * kDegree, slide_rule());
    Steps steps;
    int frame = 0;
    for (; frame < 600 && scene.depth() < Insertion::kDepth - 1e-6; ++frame) steps.add(scene.down(0.002));
    std::cout << degrees << " deg: bottomed after " << frame << " frames, tilt " << scene.tilt() / kDegree
              << " deg\n";
    for (int i = 0; i < 200; ++i) steps.add(scene.down(0.002));
    EXPECT_NEAR(scene.depth(), Insertion::kDepth, 2 * kGap) << degrees;
    std::cout << "depth off by " << scene.depth() - Insertion::kDepth << ", tilt " << scene.tilt() / kDegree
              << " deg\n";
    EXPECT_NEAR(scene.tilt(), 0.0, 1e-3 * kDegree);
    steps.print("aligning");
  }
}

// A box pressed on 20 abutting hexahedra and drawn over them for 1 m takes the same path as over one slab.
TEST(Slide, SeamsDoNotShow) {
  std::array<std::vector<Vector3>, 2> paths;
  for (const int solids : {1, 20}) {
    const auto world = make_world();
    world->set_default_rule(slide_rule());
    std::vector<PlacedHexahedron> floor;
    const double length = 2.0 / solids;
    for (int i = 0; i < solids; ++i)
      floor.push_back({"part " + std::to_string(i), Hexahedron::from_size({length, 1, 0.1}),
                       at(-0.5 + length * (i + 0.5), 0, -0.05)});
    world->add({std::make_shared<HexahedronTree>(floor, "floor"), Pose{}, true});
    const ObjectHandle box = world->add({box_tree("box", {0.3, 0.2, 0.1}), at(0, 0, 0.06)});
    Steps steps;
    for (int i = 0; i < 100; ++i) {
      steps.add(world->frame(std::array{world->move_by(box, {0.01, 0.0005, -0.012}, {0, 0, 0})}));
      paths[solids != 1].push_back(world->actual_pose(box).p);
    }
    steps.print(solids == 1 ? "slab" : "seams");
  }
  double furthest = 0;
  for (int i = 0; i < 100; ++i) furthest = std::max(furthest, norm(paths[0][i] - paths[1][i]));
  EXPECT_LE(furthest, 2 * kGap);
  EXPECT_NEAR(paths[1].back().x(), 1.0, 1e-9);
  std::cout << "seams show by " << furthest << " m\n";
}

struct CornerRoom {
  std::unique_ptr<ContactWorld> world = make_world();
  ObjectHandle box;

  CornerRoom() {
    world->set_default_rule(slide_rule());
    world->add({box_tree("floor", {6, 6, 1}), at(0, 0, -0.5), true});
    world->add({box_tree("east", {1, 6, 4}), at(2.5, 0, 2), true});
    world->add({box_tree("north", {6, 1, 4}), at(0, 2.5, 2), true});
    box = world->add({box_tree("box", {0.6, 0.5, 0.4}), at(0.3, -0.2, 1)});
  }
};

TEST(Slide, IntoACornerOfTwoWallsAndTheFloor) {
  CornerRoom room;
  Steps steps;
  for (int i = 0; i < 200; ++i)
    steps.add(room.world->frame(std::array{room.world->move_by(room.box, {0.03, 0.02, -0.01}, {0, 0, 0})}));
  const Vector3 p = room.world->actual_pose(room.box).p;
  EXPECT_NEAR(p.x(), 2 - 0.3, 2 * kGap);
  EXPECT_NEAR(p.y(), 2 - 0.25, 2 * kGap);
  EXPECT_NEAR(p.z(), 0.2, 2 * kGap);
  steps.print("corner");
}

TEST(Slide, TiltedIntoTheCornerAligns) {
  CornerRoom room;
  room.world->frame(std::array{room.world->move_by(room.box, {0, 0, 0}, {0.2, -0.3, 0.4})});
  Steps steps;
  for (int i = 0; i < 500; ++i)
    steps.add(room.world->frame(std::array{room.world->move_by(room.box, {0.03, 0.02, -0.025}, {0, 0, 0})}));
  const Pose X = room.world->actual_pose(room.box);
  std::cout << "corner: off by " << 2 - 0.3 - X.p.x() << " " << 2 - 0.25 - X.p.y() << " " << X.p.z() - 0.2
            << ", turned by " << (X.R - Matrix3::Identity()).cwiseAbs().maxCoeff() << "\n";
  EXPECT_NEAR(X.p.x(), 2 - 0.3, 2 * kGap);
  EXPECT_NEAR(X.p.y(), 2 - 0.25, 2 * kGap);
  EXPECT_NEAR(X.p.z(), 0.2, 2 * kGap);
  steps.print("tilted into the corner");
}

// A box that just fits between two walls: pressed and turned against both it goes on along them.
TEST(Slide, InASlot) {
  const auto world = make_world();
  world->set_default_rule(slide_rule());
  world->add({box_tree("left", {4, 0.1, 1}), at(0, 0.25 + 0.05 + 1e-6, 0), true});
  world->add({box_tree("right", {4, 0.1, 1}), at(0, -0.25 - 0.05 - 1e-6, 0), true});
  const ObjectHandle box = world->add({box_tree("box", {0.8, 0.5, 0.3}), at(-1.2, 0, 0)});
  Steps steps;
  for (int i = 0; i < 100; ++i)
    steps.add(world->frame(std::array{world->move_by(box, {0.02, 0.01, 0.001}, {0, 0, 0.01})}));
  EXPECT_NEAR(world->actual_pose(box).p.x(), -1.2 + 2.0, 1e-3);
  EXPECT_NEAR(world->actual_pose(box).p.z(), 0.1, 1e-6);
  std::cout << "slot: x off by " << world->actual_pose(box).p.x() - 0.8 << "\n";
  steps.print("slot");
}

// Between two walls that leave no more than gaps: room for nothing but to go along.
TEST(Slide, InASlotOfTwoGaps) {
  for (const double each : {0.55, 0.7, 0.9, 1.2}) {
    const auto world = make_world();
    world->set_default_rule(slide_rule());
    world->add({box_tree("left", {4, 0.125, 1}), at(0, 0.25 + 0.0625 + each * kGap, 0), true});
    world->add({box_tree("right", {4, 0.125, 1}), at(0, -0.25 - 0.0625 - each * kGap, 0), true});
    const ObjectHandle box = world->add({box_tree("box", {0.5, 0.5, 0.25}), at(-1, 0, 0)});
    Steps steps;
    for (int i = 0; i < 100; ++i)
      steps.add(world->frame(std::array{world->move_by(box, {0.02, 0.01, 0.001}, {0.003, 0.002, 0.01})}));
    const Pose X = world->actual_pose(box);
    EXPECT_NEAR(X.p.x(), 1.0, 1e-6) << each;
    EXPECT_NEAR(X.p.z(), 0.1, 1e-6) << each;
    EXPECT_LE(std::abs(X.p.y()), (each - 0.5) * kGap + 1e-15);
    EXPECT_GT(std::asin(X.R(0, 2)), 0.15) << "the turn about the walls' normal is free";
    steps.print("slot of gaps");
  }
}

// A row of boxes pressed together and on the floor, all commanded to go: the one in front holds the others,
// none pushes another.
TEST(Slide, MoversDoNotPushEachOther) {
  const auto world = make_world();
  world->set_default_rule(slide_rule());
  world->add({box_tree("floor", {20, 20, 1}), at(0, 0, -0.5), true});
  const ObjectHandle slow = world->add({box_tree("slow", {1, 1, 1}), at(1.2, 0, 0.6)});
  const ObjectHandle fast = world->add({box_tree("fast", {1, 1, 1}), at(0, 0, 0.6)});
  for (int i = 0; i < 50; ++i) {
    const Pose before = world->actual_pose(slow);
    world->frame(std::array{world->move_by(fast, {0.05, 0, -0.02}, {0, 0, 0}),
                            world->move_by(slow, {0.01, 0.002, -0.02}, {0, 0, 0})});
    ASSERT_NEAR(world->actual_pose(slow).p.x() - before.p.x(), 0.01, 1e-9) << i;
  }
  EXPECT_NEAR(world->actual_pose(fast).p.x(), world->actual_pose(slow).p.x() - 1, 1e-3);
}

// A carried object slides for its carrier: the metric is that of the two together.
TEST(Slide, LatchedObjectSlidesForItsCarrier) {
  CornerRoom room;
  const ObjectHandle arm = room.world->add({box_tree("arm", {0.1, 0.1, 1}), at(0.3, -0.2, 1.8)});
  room.world->latch(arm, room.box);
  for (int i = 0; i < 150; ++i)
    room.world->frame(std::array{room.world->move_by(arm, {0.03, 0.02, -0.02}, {0, 0, 0})});
  const Vector3 p = room.world->actual_pose(room.box).p;
  EXPECT_NEAR(p.x(), 2 - 0.3, 2 * kGap);
  EXPECT_NEAR(p.y(), 2 - 0.25, 2 * kGap);
  EXPECT_NEAR(p.z(), 0.2, 2 * kGap);
}

// A pair that only advances ends a slide, one that holds keeps its sub-step from being executed.
TEST(Slide, OtherPoliciesEndIt) {
  for (const ContactPolicy policy : {ContactPolicy::advance, ContactPolicy::hold, ContactPolicy::cue}) {
    CornerRoom room;
    room.world->set_pair_rule(room.box, room.world->find("east"), rule(policy));
    // Down on the floor, then against the wall in one step.
    room.world->frame(std::array{room.world->move_by(room.box, {0, 0, -1}, {0, 0, 0})});
    room.world->frame(std::array{room.world->move_by(room.box, {2.5, 0.5, -0.1}, {0, 0, 0})});
    const Vector3 p = room.world->actual_pose(room.box).p;
    if (policy == ContactPolicy::advance) {
      EXPECT_NEAR(p.x(), 2 - 0.3, 2 * kGap);
      EXPECT_NEAR(p.y(), -0.2 + 0.5 * 1.4 / 2.5, 1e-8);
    } else {
      EXPECT_NEAR(p.x(), policy == ContactPolicy::hold ? 0.3 : 2.8, 1e-8);
    }
    EXPECT_NEAR(p.z(), 0.2, 2 * kGap);
  }
}

TEST(Slide, ReportsWhatStopsItAndWhatItComesTo) {
  CornerRoom room;
  room.world->frame(std::array{room.world->move_by(room.box, {0, 0, -1}, {0, 0, 0})});
  const FrameReport report =
      room.world->frame(std::array{room.world->move_by(room.box, {2.5, 0.1, -0.1}, {0, 0, 0})});
  std::vector<std::string> seen;
  for (const ContactEvent& event : report.events)
    seen.push_back(std::string(to_string(event.kind)) + " " + std::string(room.world->name_of(event.a)));
  EXPECT_THAT(
      seen, ::testing::UnorderedElementsAre("blocked floor", "persists floor", "blocked east", "began east"));
  EXPECT_EQ(report.blocked_movers, 1u);
}

// A box lying on the floor, turned about a horizontal axis: it rolls over its edge, pivoting as it goes.
TEST(Slide, RollsOnItsEdge) {
  for (const double turn : {1e-3, 1e-2}) {
    const auto world = make_world();
    world->set_default_rule(slide_rule());
    world->add({box_tree("floor", {20, 6, 1}), at(0, 0, -0.5), true});
    const ObjectHandle box = world->add({box_tree("box", {0.6, 0.5, 0.4}), at(0, 0, 0.2 + kGap)});
    Steps steps;
    const int frames = static_cast<int>(3.0 / turn);
    for (int i = 0; i < frames; ++i)
      steps.add(world->frame(std::array{world->move_by(box, {0, 0, -0.05 * turn}, {0, turn, 0})}));
    const Matrix3& R = world->actual_pose(box).R;
    EXPECT_GT(std::atan2(R(0, 2), R(0, 0)), 1.0);
    std::cout << "turned " << std::atan2(R(0, 2), R(0, 0)) << " of " << frames * turn << " rad\n";
    steps.print("rolling");
  }
}

// A box whose flat face rests on another's edge, tilting over it: the plane of contact is the mover's own.
TEST(Slide, TiltsOverAnEdge) {
  for (const double turn : {1e-3, 1e-2}) {
    const auto world = make_world();
    world->set_default_rule(slide_rule());
    world->add({box_tree("post", {0.2, 3, 1}), at(0, 0, -0.5), true});
    const ObjectHandle box = world->add({box_tree("bar", {2, 0.2, 0.1}), at(0.1, 0, 0.05 + kGap)});
    Steps steps;
    const int frames = static_cast<int>(0.5 / turn);
    for (int i = 0; i < frames; ++i)
      steps.add(world->frame(std::array{world->move_by(box, {0, 0, -0.001}, {0, turn, 0})}));
    const Matrix3& R = world->actual_pose(box).R;
    std::cout << "tilted " << std::atan2(R(0, 2), R(0, 0)) << " of " << frames * turn << " rad\n";
    EXPECT_GT(std::atan2(R(0, 2), R(0, 0)), 0.4);
    steps.print("tilting");
  }
}

TEST(Slide, PressingAndSlidingForLongKeepsTheGap) {
  // A box in a corner of three walls.
  CornerRoom room;
  BackendRegistry registry;
  const auto native = make_native();
  const std::array solids{Hexahedron::from_size({6, 6, 1}), Hexahedron::from_size({1, 6, 4}),
                          Hexahedron::from_size({6, 1, 4}), Hexahedron::from_size({0.6, 0.5, 0.4})};
  native->build(solids);
  const auto workspace = native->make_workspace();
  double least = 1.0;
  int in_contact = 0;
  Steps steps;
  // It is pressed into the corner and along it.
  for (int i = 0; i < 10000; ++i) {
    const double a = 0.01 * i;
    const Vector3 along(0.01 * std::cos(a), 0.013 * std::sin(1.3 * a), -0.004 - 0.003 * std::sin(0.7 * a));
    const Vector3 turn(0.002 * std::sin(0.3 * a), 0.003 * std::cos(0.2 * a), 0.005 * std::sin(0.1 * a));
    steps.add(room.world->frame(std::array{room.world->move_by(room.box, along, turn)}));
    // Its distance to each wall.
    const std::array poses{at(0, 0, -0.5), at(2.5, 0, 2), at(0, 2.5, 2), room.world->actual_pose(room.box)};
    for (SolidIndex k = 0; k < 3; ++k) {
      const SolidPair pair{k, 3};
      PairStatus status{};
      PairGeometry geometry{};
      native->evaluate({{&pair, 1}, poses, {QueryKind::distance}}, {{&status, 1}, {&geometry, 1}, {}},
                       *workspace);
      least = std::min(least, geometry.separation);
      in_contact += geometry.separation <= kGap;
    }
  }
  EXPECT_GE(least, 0.5 * kGap - 1e-14);
  EXPECT_GT(in_contact, 5000);
  std::cout << "least separation " << least / kGap << " g, " << in_contact << " contacts\n";
  steps.print("pressing");
}

// The distance to the goal, on samples of every executed part.
TEST(Slide, DistanceToTheGoalNeverGrows) {
  // Distance by the box's mass: of its centre and of its turn.
  CornerRoom room;
  const MassMetric metric = mass_metric(mass_moments(Hexahedron::from_size({0.6, 0.5, 0.4})));
  int slid = 0;
  double worst = 0;
  // Commands into the corner.
  for (int i = 0; i < 600; ++i) {
    const double a = 0.05 * i;
    const MotionCommand command =
        room.world->move_by(room.box, {0.03 * std::cos(a), 0.03 * std::sin(1.3 * a), -0.02},
                            {0.02 * std::sin(0.3 * a), 0.03 * std::cos(0.2 * a), 0.05 * std::sin(0.1 * a)});
    slid += room.world->frame(std::array{command}).slide_steps > 0;
    // Along all that a frame executes it gets no larger.
    double before = kInfinity;
    for (std::size_t part = 0; part < room.world->executed_parts(); ++part) {
      for (int k = 0; k <= 8; ++k) {
        const Pose X = room.world->executed_pose(room.box, part, k / 8.0);
        const Twist left{command.path.to().p - X.p,
                         RigidPath::between(X, command.path.to()).at(0, 0).angular_velocity_W};
        const double distance = std::sqrt(inner_product(turned(X.R, metric.J), left, left));
        worst = std::max(worst, distance - before);
        ASSERT_LE(distance, before + 1e-15) << "frame " << i << " part " << part << " sample " << k;
        before = distance;
      }
    }
  }
  EXPECT_GT(slid, 300);
  std::cout << slid << " frames slid; largest growth " << worst << " m\n";
}

// Movers that slide past each other, whichever is registered first.
TEST(Slide, RegistrationOrderDoesNotShow) {
  std::array<std::vector<Pose>, 2> poses;
  // Five objects, added in order or in reverse.
  for (const bool reversed : {false, true}) {
    const auto world = make_world();
    world->set_default_rule(slide_rule());
    const std::array<std::string, 5> names{"a", "b", "c", "floor", "wall"};
    std::array<ObjectHandle, 5> h;
    for (int k = 0; k < 5; ++k) {
      const int i = reversed ? 4 - k : k;
      if (i == 3)
        h[i] = world->add({box_tree(names[i], {9, 9, 1}), at(0, 0, -0.5), true});
      else if (i == 4)
        h[i] = world->add({box_tree(names[i], {1, 9, 3}), at(3, 0, 0.5), true});
      else
        h[i] = world->add({box_tree(names[i], {1, 0.9, 0.8}), at(-2 + 1.3 * i, 0.1 * i, 0.45)});
    }
    // Commands in the same order.
    for (int frame = 0; frame < 40; ++frame) {
      const std::array commands{world->move_by(h[0], {0.09, 0.02, -0.03}, {0.01, 0, 0.02}),
                                world->move_by(h[2], {-0.03, 0, -0.02}, {0.01, 0.02, 0}),
                                world->move_by(h[1], {0.05, 0.01, -0.03}, {0, 0.01, -0.03})};
      world->frame(commands);
      for (int i = 0; i < 3; ++i) poses[reversed].push_back(world->actual_pose(h[i]));
    }
  }
  // The same bits.
  for (std::size_t i = 0; i < poses[0].size(); ++i) {
    ASSERT_TRUE(poses[0][i].p == poses[1][i].p && poses[0][i].R == poses[1][i].R)
        << "frame " << i / 3 << " box " << i % 3 << ": off by " << norm(poses[0][i].p - poses[1][i].p);
  }
}

}  // namespace
}  // namespace touchstone
