#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <utility>
#include <vector>

#include "touchstone/contact_core/geometry/no_index.hpp"
#include "touchstone/contact_core/native/native.hpp"
#include "touchstone/contact_core/world/frame/executed_parts.hpp"
#include "touchstone/contact_core/world/frame/followers.hpp"
#include "touchstone/contact_core/world/slide/arm_plan.hpp"
#include "touchstone/contact_core/world/slide/hands.hpp"
#include "touchstone/contact_core/world/slide/leading_paths.hpp"
#include "touchstone/contact_core/world/slide/rigid_plan.hpp"
#include "touchstone/contact_core/world/slide/slide_pairs.hpp"
#include "touchstone/tests/world/arms/arm_fixture.hpp"

// The parts that slides are made of, each alone: no world flies here.

namespace touchstone {
namespace {

constexpr double kNoWay = 1e-12;

/// A cube of 1 m that is to go from X_WR to its goal, by a hand as stiff against turns as against shifts.
Slider cube_slider(const Pose& X_WR, const Pose& goal) {
  Slider slider{};
  slider.goal = goal;
  slider.moments = mass_moments(Hexahedron::from_size({1, 1, 1}));
  weigh_by_hand(slider, HandStiffness{});
  slider.start_distance = slider.distance = distance_to_goal(slider, X_WR);
  return slider;
}

/// A mover's solid above an obstacle, as the narrowphase sees the two.
NearPair near_pair(const Hexahedron& mover, const Pose& X_WM, const Hexahedron& obstacle, const Pose& X_WB) {
  const std::vector<Hexahedron> solids{obstacle, mover};
  const std::unique_ptr<Narrowphase> native = make_native();
  native->build(solids);
  NarrowphaseQuery query(*native, solids.size());
  query.set_pair({0, 1});
  NearPair near;
  PairGeometry geometry{};
  query.manifold(X_WB, X_WM, 1.0, geometry, near.points);
  near.mover = &mover, near.obstacle = &obstacle;
  near.X_WM = X_WM, near.X_WB = X_WB;
  near.centre_W = X_WM.p;
  near.gap = kGap, near.reach = 10.0, near.source = 0;
  near.separation = geometry.separation;
  near.n = geometry.n_AB_W;
  near.point_count = geometry.point_count;
  classify(near);
  return near;
}

std::vector<SlideRow> room_for_rows() {
  std::vector<SlideRow> rows;
  rows.reserve(1024);
  return rows;
}

TEST(RigidPlan, GoesToTheGoalWhereNothingIsNear) {
  Pose goal = at(0.3, -0.2, 0.1);
  goal.R = rotation_about(Vector3::UnitY(), 0.2);
  const Slider slider = cube_slider({}, goal);
  std::vector<SlideRow> rows = room_for_rows();
  const RigidPlan plan = plan_rigid_slide(slider, {}, false, {}, rows);
  EXPECT_EQ(plan.active.count, 0);
  EXPECT_EQ(plan.force_W, Vector3::Zero());
  EXPECT_LT(distance_to_goal(slider, plan.path.to()), 1e-3 * slider.distance);
  const RigidPlan straight = plan_rigid_slide(slider, {}, true, {}, rows);
  EXPECT_EQ(straight.path.to().R, Pose{}.R);
  EXPECT_LT(norm(straight.path.to().p - goal.p), 1e-12);
}

// Pressed into a floor a body goes along it as far as it was to, no deeper than half the gap, and the hand
// feels k times the lag straight up.
TEST(RigidPlan, GoesAlongAFloorAndFeelsIt) {
  const Hexahedron cube = Hexahedron::from_size({1, 1, 1}), floor = Hexahedron::from_size({8, 8, 1});
  const Pose X_WR = at(0, 0, 0.5 + kGap), X_WF = at(0, 0, -0.5);
  const Slider slider = cube_slider(X_WR, at(0.2, 0.1, 0.5 + kGap - 0.05));
  std::vector<NearPair> near{near_pair(cube, X_WR, floor, X_WF)};
  ASSERT_TRUE(near[0].is_sure);
  near[0].source = 7;
  std::vector<SlideRow> rows = room_for_rows();
  const RigidPlan plan = plan_rigid_slide(slider, X_WR, false, near, rows);
  ASSERT_GT(plan.active.count, 0);
  EXPECT_EQ(rows[plan.active.row[0]].source, 7u);
  const Pose& end = plan.path.to();
  EXPECT_NEAR(end.p.x(), 0.2, 1e-6);
  EXPECT_NEAR(end.p.y(), 0.1, 1e-6);
  EXPECT_GE(end.p.z() - 0.5, 0.5 * kGap);
  EXPECT_NEAR(plan.force_W.z(), 500.0 * 0.05, 1e-3);
  EXPECT_NEAR(plan.force_W.x(), 0.0, 1e-3);
  EXPECT_TRUE(plan.is_near_end);
}

TEST(RigidPlan, StaysWhereNothingIsToBeGained) {
  const Hexahedron cube = Hexahedron::from_size({1, 1, 1}), floor = Hexahedron::from_size({8, 8, 1});
  const Pose X_WR = at(0, 0, 0.5 + 0.75 * kGap);
  const Slider slider = cube_slider(X_WR, at(0, 0, 0.3));
  std::vector<NearPair> near{near_pair(cube, X_WR, floor, at(0, 0, -0.5))};
  std::vector<SlideRow> rows = room_for_rows();
  EXPECT_TRUE(plan_rigid_slide(slider, X_WR, false, near, rows).path.at_rest());
}

/// Nothing but what is given, all of it where the plan's path is looked at first, or where it stands.
class GivenObstacles final : public ArmObstacles {
 public:
  explicit GivenObstacles(std::vector<NearPair> pairs) : pairs_(std::move(pairs)) {}

  std::span<NearPair> near() override { return std::span(pairs_).first(known_); }
  void take_up_standing() override { known_ = stands ? pairs_.size() : 0; }
  bool take_up_held() override { return false; }
  bool take_up_on_path() override {
    ++looks;
    return std::exchange(known_, pairs_.size()) < pairs_.size();
  }
  bool is_over() const override { return over; }

  int looks = 0;
  bool over = false, stands = false;

 private:
  std::vector<NearPair> pairs_;
  std::size_t known_ = 0;
};

struct TwoBars {
  MechanismMover arm{MechanismPlacement{make_arm("arm", 2), {}, {0.0, 0.0}}};
  Slider slider{};
  std::vector<SlideRow> rows = room_for_rows();
  std::vector<JointRow> joint_rows;

  explicit TwoBars(std::vector<double> goal) {
    joint_rows.reserve(kMostSlideRows);
    arm.commanded = std::move(goal);
    slider.arm = &arm;
    begin_arm_slide(slider);
    slider.start_distance = slider.distance = distance_left(slider, {});
  }
};

TEST(ArmPlan, GoesToTheCommandedValuesWhereNothingIsMet) {
  TwoBars bars({0.1, -0.2});
  GivenObstacles none({});
  const ArmPlan plan = plan_arm_slide(bars.slider, none, bars.rows, bars.joint_rows);
  EXPECT_TRUE(plan.moves);
  EXPECT_EQ(plan.held_by, 0);
  EXPECT_EQ(none.looks, 1);
  EXPECT_NEAR(bars.arm.path.to()[0], 0.1, 1e-12);
  EXPECT_NEAR(bars.arm.path.to()[1], -0.2, 1e-12);
}

/// A wall beside the second bar's end.
NearPair wall_beside_end(const TwoBars& bars) {
  static const Hexahedron wall = Hexahedron::from_size({1, 1, 1});
  const Hexahedron& bar = bars.arm.mechanism->solids()[1];
  const Pose X_WM = compose(bars.arm.X_WL[2], bars.arm.mechanism->placed(1).X_OS);
  NearPair near = near_pair(bar, X_WM, wall, at(3.5, 0.1 + 0.5 + 0.75 * kGap, 0));
  near.centre_W = bars.arm.X_WL[2].p;
  near.link = 2;
  return near;
}

// Found on the path only, and then held to.
TEST(ArmPlan, GoesAlongWhatItsPathMeets) {
  TwoBars bars({0.1, 0.0});
  GivenObstacles obstacles({wall_beside_end(bars)});
  const ArmPlan plan = plan_arm_slide(bars.slider, obstacles, bars.rows, bars.joint_rows);
  EXPECT_GE(obstacles.looks, 2);
  EXPECT_TRUE(plan.moves);
  EXPECT_GT(plan.held_by, 0);
  // The first joint goes on, the second gives way: no point of its bar goes up by more than a gap.
  EXPECT_GT(bars.arm.path.to()[0], 1e-4);
  EXPECT_LT(bars.arm.path.to()[1], -1e-4);
}

// As if edges touched, whose plane follows the motion. The path into the wall is never looked along.
TEST(ArmPlan, TakesWhatTouchesBeforeItLooksAlongAPath) {
  TwoBars bars({0.1, 0.0});
  NearPair near = wall_beside_end(bars);
  near.is_sure = false;
  GivenObstacles obstacles({near});
  obstacles.stands = true;
  const ArmPlan plan = plan_arm_slide(bars.slider, obstacles, bars.rows, bars.joint_rows);
  EXPECT_EQ(obstacles.looks, 1);
  EXPECT_TRUE(plan.moves);
  EXPECT_GT(plan.held_by, 0);
  EXPECT_LT(bars.arm.path.to()[1], -1e-4);
}

TEST(ArmPlan, StaysWhereTheBudgetEnds) {
  TwoBars bars({0.1, 0.0});
  GivenObstacles none({});
  none.over = true;
  EXPECT_FALSE(plan_arm_slide(bars.slider, none, bars.rows, bars.joint_rows).moves);
  EXPECT_EQ(bars.arm.path.to()[0], 0.0);
}

TEST(Sliders, ShareTheRoomByHowFastTheyCome) {
  const Hexahedron cube = Hexahedron::from_size({1, 1, 1});
  const Pose low, high = at(0, 0, 1.001);
  const NearPair near = near_pair(cube, high, cube, low);
  const auto share = [&](double down, double up) {
    return share_between(cube_slider(high, at(0, 0, 1.001 - down)), high, cube_slider(low, at(0, 0, up)), low,
                         near);
  };
  EXPECT_NEAR(share(0.1, 0.1), 0.5, kNoWay);
  EXPECT_NEAR(share(0.3, 0.1), 0.75, kNoWay);
  EXPECT_EQ(share(-0.1, 0.1), 0.125);
  EXPECT_EQ(share(0.1, -0.1), 0.875);
}

TEST(Hands, EndWithTheirObject) {
  Hands hands;
  HandStiffness soft;
  soft.translation = {1, 1, 1};
  hands.set({3, 1}, soft);
  hands.set({4, 1}, std::nullopt);
  EXPECT_EQ(hands.of({3, 1})->translation.x(), 1.0);
  EXPECT_EQ(hands.of({3, 2})->translation.x(), 500.0);  // its slot's next owner
  EXPECT_FALSE(hands.of({4, 1}).has_value());
  EXPECT_TRUE(hands.of({9, 1}).has_value());
  hands.set_default(std::nullopt);
  EXPECT_FALSE(hands.of({9, 1}).has_value());
}

using Claims = std::vector<std::pair<std::uint32_t, std::uint32_t>>;

/// The leader of each root that was taken along.
Claims settled(Followers& followers, const Claims& claims) {
  Claims out;
  for (const auto& [leader, root] : claims) followers.claim({leader, 0}, root);
  followers.settle(
      [&](const Followers::Lead& lead, std::uint32_t root) { out.emplace_back(lead.root, root); });
  return out;
}

TEST(Followers, StayWhereTwoLinksOfOneLeaderWantThem) {
  Followers followers;
  followers.take_room(8, true);
  followers.begin({}, std::vector<std::uint32_t>{0});
  followers.claim({0, 2}, 5), followers.claim({0, 3}, 5), followers.claim({0, 3}, 6);
  std::vector<std::uint32_t> links;
  followers.settle([&](const Followers::Lead& lead, std::uint32_t) { links.push_back(lead.link); });
  EXPECT_EQ(links, std::vector<std::uint32_t>{3});
  EXPECT_TRUE(followers.is_disputed(5));
}

// In whichever order leaders come: whom two want stays, once and for all of the frame.
TEST(Followers, GoWithTheOneThatWantsThem) {
  Claims claims{{0, 5}, {1, 6}, {0, 6}, {1, 4}, {0, 5}};
  std::sort(claims.begin(), claims.end());
  do {
    Followers followers;
    followers.take_room(8, true);
    followers.begin({}, std::vector<std::uint32_t>{0, 1});
    EXPECT_EQ(settled(followers, claims), (Claims{{1, 4}, {0, 5}}));
    EXPECT_EQ(followers.leader_of(4), 1u);
    EXPECT_EQ(followers.leader_of(6), 6u);
    EXPECT_TRUE(followers.is_commanded(5));
    EXPECT_TRUE(followers.is_followed(0));
    EXPECT_TRUE(followers.is_disputed(6));
    EXPECT_TRUE(settled(followers, {{0, 6}}).empty());
    followers.begin(std::vector<std::uint32_t>{0, 1, 4, 5}, {});
    EXPECT_FALSE(followers.is_commanded(5));
    EXPECT_FALSE(followers.is_followed(0));
  } while (std::next_permutation(claims.begin(), claims.end()));
}

TEST(ExecutedParts, EndWhereTheMoverWasStopped) {
  const std::vector<Pose> X_CO(4);
  const auto path_to = [&](double x) { return CarriedPath(RigidPath::between({}, at(x, 0, 0)), X_CO); };
  ExecutedParts parts;
  parts.add({2, 1}, 0, path_to(1.0), 0.25);
  parts.add({3, 1}, 0, path_to(1.0), 1.0, std::vector{0.0, 1.0}, std::vector{0.5, 3.0});
  parts.add({2, 1}, 2, path_to(2.0), 1.0);
  parts.set_count(3);
  EXPECT_EQ(parts.count(), 3u);
  EXPECT_EQ(parts.find({2, 1}, 0, 0.2).s, 0.2);
  EXPECT_EQ(parts.find({2, 1}, 0, 0.5).s, 0.25);
  EXPECT_EQ(parts.find({2, 1}, 1, 0.1).s, 0.25);  // it had no such part: at the end of the one before
  EXPECT_EQ(parts.find({2, 1}, 2, 0.1).part->part, 2u);
  EXPECT_EQ(parts.find({2, 2}, 0, 0.5).part, nullptr);  // its slot's next owner
  const ExecutedParts::At half = parts.find({3, 1}, 0, 0.5);
  EXPECT_EQ(parts.joint_value(half, 0, 2), 0.25);
  EXPECT_EQ(parts.joint_value(half, 1, 2), 2.0);
  parts.clear();
  EXPECT_EQ(parts.find({2, 1}, 0, 0.5).part, nullptr);
}

TEST(LeadingPaths, PivotKeepsTheTouchingPointOnALine) {
  Pose goal;
  goal.R = rotation_about(Vector3::UnitY(), 0.4);
  const Vector3 touching{0.5, 0.0, -0.5}, end = transform(goal, touching);
  const RigidPath path = pivot_path({}, goal, touching);
  EXPECT_EQ(path.to().p, goal.p);
  EXPECT_EQ(path.to().R, goal.R);
  for (const double s : {0.25, 0.5, 0.75}) {
    const Vector3 p = transform(path.pose_at(s), touching);
    EXPECT_LT(norm(p - (touching + s * (end - touching))), 1e-15);
  }
}

// It rests flat, and the witness point may be any of its face: it turns about the edge all the same.
TEST(LeadingPaths, ABodyThatRestsOnAFaceTurnsAboutItsEdgeAtOnce) {
  for (const double side : {1.0, -1.0}) {
    const auto world = make_world();
    world->set_default_rule(rule(ContactPolicy::advance));
    world->add({box_tree("floor", {4, 4, 1}), at(0, 0, -0.5), true});
    const ObjectHandle tool = world->add({box_tree("tool", {0.4, 0.3, 0.2}), at(0, 0, 0.1 + 0.75 * kGap)});
    const Pose& before = world->actual_pose(tool);
    const Vector3 edge_O(side * 0.2, 0, -0.1), turn(0, side * 0.05, 0);
    const Pose goal = RigidPath::by(before, Vector3::Zero(), turn, edge_O).to();
    const std::array commands{world->go_to(tool, goal)};
    world->frame(commands);
    EXPECT_LT(norm(world->actual_pose(tool).p - goal.p), 1e-15) << side;
  }
}

TEST(LeadingPaths, FollowersKeepTheirPlaceBesideTheLeader) {
  Pose goal = at(0.3, 0.1, 0.0);
  goal.R = rotation_about(Vector3::UnitZ(), 0.7);
  const RigidPath leader = RigidPath::between({}, goal);
  const Pose beside = at(1.0, 2.0, 0.0);
  const RigidPath path = path_along(leader, beside);
  for (const double s : {0.0, 0.4, 1.0}) {
    const Pose X = compose(leader.pose_at(s), beside);
    EXPECT_LT(norm(path.pose_at(s).p - X.p), 1e-14);
    EXPECT_LT((path.pose_at(s).R - X.R).cwiseAbs().maxCoeff(), 1e-14);
  }
  EXPECT_TRUE(path_along(RigidPath(Pose{}), beside).at_rest());
}

TEST(LeadingPaths, ShovingGoesOnUntilItsPathIsGone) {
  Slider slider{};
  slider.goal = at(1, 0, 0);
  const RigidPath path = RigidPath::between({}, slider.goal);
  begin_shove(slider, path, 0.25);
  EXPECT_TRUE(slider.shoves);
  EXPECT_LT(norm(shoving_path(slider, at(0.25, 0, 0)).to().p - slider.goal.p), 1e-15);
  EXPECT_TRUE(go_on_shoving(slider, 0.5, false, false));
  EXPECT_NEAR(norm(slider.remaining.v), 0.375, 1e-15);
  EXPECT_FALSE(go_on_shoving(slider, 0.5, true, false));
  EXPECT_TRUE(slider.done);
}

/// Boxes along x, the first one sliding: what SlidePairs is given by a world.
struct Row {
  WorldModel model;
  PairWatch watched;
  FrameLanes lanes;
  Sliders sliders;
  SlideMeter meter;
  SlidePairs pairs;

  explicit Row(const std::vector<double>& places) {
    PairRule slides;
    slides.policy = ContactPolicy::slide;
    model.rules.set_default(slides);
    model.gap = kGap;
    for (std::size_t i = 0; i < places.size(); ++i)
      model.objects.add({box_tree("box " + std::to_string(i), {1, 1, 1}), at(places[i], 0, 0), i > 0});
    model.layout = make_layout(model.objects);
    model.narrowphase = make_native(), model.planner = make_native();
    model.narrowphase->build(model.layout.solids), model.planner->build(model.layout.solids);
    lanes.build(*model.narrowphase, *model.planner, places.size());
    stand();
    pairs.reserve(places.size(), places.size(), 0), pairs.reserve_watched(16);
    meter.begin({}), meter.begin_step(1), meter.begin_plan();
  }

  void stand() {
    const std::size_t count = model.layout.solids.size();
    for (std::uint32_t i = 0; i < count; ++i) {
      model.from.push_back(model.objects[i].X_WO), model.X_BS.emplace_back(),
          model.root_of_solid.push_back(i);
      model.paths.emplace_back(RigidPath(model.objects[i].X_WO), model.objects.poses_in_body());
      model.members.emplace_back(i, i);
    }
    model.stops.assign(count, 1.0), model.in_motion.assign(count, 0), model.rides.take_room(count, true);
    Travels& travels = model.travels;
    for (GrowingList<double>* values : {&travels.of_solid, &travels.solid_limit, &travels.last_solid,
                                        &travels.planned_solid, &travels.needed})
      values->assign(count, 0.0);
    travels.vertices.resize(count), travels.has_vertices.assign(count, 0);
    sliders.index_of.assign(count, kNoIndex);
    watched.reserve(16), watched.set_solids(count);
    for (std::uint32_t other = 1; other < count; ++other) watched.add({0, other, kNoLinkPair, kNotKnown});
  }

  /// The first box is to go so far along x.
  std::span<const std::uint32_t> slide_by(double way) {
    Pose goal = model.from[0];
    goal.p.x() += way;
    sliders.list = {cube_slider(model.from[0], goal)};
    sliders.index_of[0] = 0;
    return pairs.begin(model, sliders);
  }
  SlidePairs::Scope scope() { return {model, watched, lanes.first(), sliders, meter, lanes}; }
};

// Neighbours within reach are planned with, those beyond it are not; what was learnt about a pair keeps it
// away without another query.
TEST(SlidePairs, FindWhatASliderCouldReach) {
  Row row({0.0, 1.5, -40.0});
  const auto wanting = row.slide_by(1.0);
  EXPECT_EQ(std::vector(wanting.begin(), wanting.end()), std::vector<std::uint32_t>{0});
  EXPECT_GT(row.model.travels.needed[0], 2.0);
  row.pairs.renumber(row.watched);
  row.pairs.gather(row.model, row.watched, row.sliders, row.lanes);
  row.pairs.find_near(row.scope(), row.sliders.list[0]);
  ASSERT_EQ(row.pairs.near().size(), 1u);
  const NearPair& near = row.pairs.near()[0];
  EXPECT_EQ(row.pairs[near.source].solids, (SolidPair{0, 1}));
  EXPECT_NEAR(near.separation, 0.5, 1e-12);
  EXPECT_LT(norm(near.n + Vector3::UnitX()), 1e-12);  // from the obstacle to the mover
  EXPECT_EQ(row.meter.seen(), 1u);

  row.watched[row.watched.find({0, 1})].clear_until = 100.0;
  row.pairs.find_near(row.scope(), row.sliders.list[0]);
  EXPECT_TRUE(row.pairs.near().empty());
}

TEST(SlidePairs, StopWhatIsLaidAndKeepWhatTheyLearn) {
  Row row({0.0, 1.5, -40.0});
  row.slide_by(1.0);
  row.pairs.renumber(row.watched);
  row.pairs.gather(row.model, row.watched, row.sliders, row.lanes);
  row.model.paths[0] =
      CarriedPath(RigidPath::between(row.model.from[0], at(1, 0, 0)), row.model.objects.poses_in_body());
  row.model.in_motion[0] = 1;
  row.model.travels.last_solid[0] = row.model.travels.of_solid[0] = 1.0;
  EXPECT_EQ(row.pairs.find_impacts(row.scope()), 0u);
  int stopped = 0;
  for (const FramePair& pair : row.pairs.pairs()) {
    if (!pair.stops_movers()) continue;
    ++stopped;
    EXPECT_EQ(pair.solids, (SolidPair{0, 1}));
    EXPECT_NEAR(pair.impact.lo, 0.5, 1e-8);
  }
  EXPECT_EQ(stopped, 1);
  EXPECT_GT(row.watched[row.watched.find({0, 2})].clear_until, 30.0);
}

// The first one stops the mover: the second one's contact lies on a part of the path that is not executed.
TEST(SlidePairs, LookOnlyAsFarAsTheNearestLetsThem) {
  Row row({0.0, 3.0, 1.5});
  row.slide_by(4.0);
  row.pairs.renumber(row.watched);
  row.pairs.gather(row.model, row.watched, row.sliders, row.lanes);
  row.model.paths[0] =
      CarriedPath(RigidPath::between(row.model.from[0], at(4, 0, 0)), row.model.objects.poses_in_body());
  row.model.in_motion[0] = 1;
  row.model.travels.last_solid[0] = row.model.travels.of_solid[0] = 4.0;
  row.pairs.find_impacts(row.scope());
  row.pairs.add_looks(row.model, row.sliders);
  std::uint64_t looks = 0;
  for (const FramePair& pair : row.pairs.pairs()) {
    EXPECT_EQ(pair.stops_movers(), pair.solids.b == 2);
    EXPECT_TRUE(pair.solids.b == 2 || pair.impact.queries == 1);
    looks += static_cast<std::uint64_t>(pair.impact.queries);
  }
  EXPECT_EQ(row.sliders.list[0].work, looks);
}

// The watch may be built anew within a frame, and pairs get other indices there.
TEST(SlidePairs, FindTheirPairsAgainUnderOtherIndices) {
  Row row({0.0, 1.5, -1.5});
  row.slide_by(1.0);
  row.pairs.renumber(row.watched);
  row.pairs.gather(row.model, row.watched, row.sliders, row.lanes);
  row.pairs.find_near(row.scope(), row.sliders.list[0]);
  ASSERT_EQ(row.pairs.pairs().size(), 2u);
  row.watched.clear(), row.watched.set_solids(3);
  row.watched.add({0, 2, kNoLinkPair, kNotKnown});
  row.pairs.renumber(row.watched);
  for (const FramePair& pair : row.pairs.pairs())
    EXPECT_EQ(pair.watch, pair.solids.b == 2 ? row.watched.find({0, 2}) : kNoIndex);
}

}  // namespace
}  // namespace touchstone
