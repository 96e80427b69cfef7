#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "touchstone/contact_core/broadphase/register_broadphases.hpp"
#include "touchstone/contact_core/native/native.hpp"
#include "touchstone/contact_core/world/frame/contact_log.hpp"
#include "touchstone/contact_core/world/frame/execution.hpp"
#include "touchstone/contact_core/world/frame/movers.hpp"
#include "touchstone/contact_core/world/frame/pair_finder.hpp"
#include "touchstone/contact_core/world/frame/selection_log.hpp"
#include "touchstone/contact_core/world/frame/stop_resolver.hpp"
#include "touchstone/contact_core/world/frame/watched_pairs.hpp"
#include "touchstone/contact_core/world/model/world_layout.hpp"
#include "touchstone/tests/world/world_fixture.hpp"

// The parts that a frame goes through, each alone over a model: no world flies here.

namespace touchstone {
namespace {

/// Cubes of 1 m along x, each an object that may move.
struct CubesInARow {
  WorldModel model;
  std::unique_ptr<Broadphase> broadphase = make_native_broadphase();
  FrameLanes lanes;
  WatchedPairs watched;
  Movers movers;
  std::vector<ObjectHandle> cubes;
  std::vector<ContactEvent> events;

  explicit CubesInARow(const std::vector<double>& places, ContactPolicy policy = ContactPolicy::advance) {
    model.gap = kGap;
    model.rules.set_default(rule(policy));
    for (std::size_t i = 0; i < places.size(); ++i)
      cubes.push_back(model.objects.add(
          {box_tree("cube " + std::to_string(i), {1, 1, 1}), at(places[i], 0, 0), false, {}}));
    model.layout = make_layout(model.objects);
    model.narrowphase = make_native();
    model.narrowphase->build(model.layout.solids);
    model.planner = make_native();
    model.planner->build(model.layout.solids);
    BroadphaseInput input;
    input.trees = model.layout.trees;
    input.margin = model.margin = 2.0 * kGap;
    input.is_static = model.layout.is_static;
    broadphase->build(input);
    lanes.build(*model.narrowphase, *model.planner, model.layout.solids.size());
    take_room(model, true);
    movers.take_room(places.size(), true);
    watched.take_room(model, true);
    place_all(model);
    EXPECT_TRUE(watched.begin(model, *broadphase, 0.0));
  }

  MotionCommand go_by(std::size_t cube, double x) const {
    const Pose& X_WO = model.objects[cubes[cube].slot].X_WO;
    return {cubes[cube], RigidPath::between(X_WO, at(X_WO.p.x() + x, 0, 0))};
  }
  void command(std::span<const MotionCommand> commands) {
    begin_frame(model, movers);
    accept(model, commands, movers, events);
    order_movers(model, movers);
    watched.begin_frame(model);
    watched.lay_paths(model, movers.roots);
    if (watched.is_due()) watched.update(model, *broadphase);
  }
  GrowingList<FramePair> find(std::span<const ContactState> contacts = {}) {
    PairFinder finder;
    finder.take_room(cubes.size(), cubes.size(), watched.room());
    GrowingList<FramePair> pairs;
    candidates = finder.find({model, lanes, watched, movers}, contacts, pairs).candidates;
    return pairs;
  }

  std::uint32_t candidates = 0;
};

TEST(Movers, AreThoseWithAPathThatMoves) {
  CubesInARow row({0, 5, 10, 15});
  MotionCommand nowhere = row.go_by(1, 0.0), broken = row.go_by(2, 1.0);
  broken.path = RigidPath::between(at(10, 0, 0), at(std::nan(""), 0, 0));
  begin_frame(row.model, row.movers);
  const std::array commands{row.go_by(3, 1.0), nowhere, row.go_by(0, 1.0), broken, row.go_by(3, 2.0)};
  accept(row.model, commands, row.movers, row.events);
  order_movers(row.model, row.movers);
  EXPECT_EQ(row.movers.roots, (std::vector<std::uint32_t>{0, 3}));
  ASSERT_EQ(row.events.size(), 1u);
  EXPECT_EQ(row.events[0].kind, EventKind::refused);
  EXPECT_EQ(row.events[0].a, row.cubes[2]);
  EXPECT_EQ(row.model.paths[3].carrier().to().p.x(), 17.0);  // the last command counts
  row.movers.add_follower(1);
  EXPECT_EQ(row.movers.roots, (std::vector<std::uint32_t>{0, 1, 3}));
  begin_frame(row.model, row.movers);
  EXPECT_TRUE(row.movers.roots.empty());
  EXPECT_TRUE(row.model.paths[3].carrier().at_rest());
}

// The same paths are not gone: what was counted for them is taken back.
TEST(WatchedPairs, CountWhatIsGoneOnly) {
  CubesInARow row({0, 2});
  row.command(std::array{row.go_by(0, 0.5)});
  Travels& travels = row.model.travels;
  EXPECT_NEAR(travels.of_solid[0], 0.5, 1e-5);
  EXPECT_EQ(travels.of_solid[1], 0.0);
  row.model.stops[0] = 0.25;
  row.watched.take_back(row.model, 0);
  EXPECT_NEAR(travels.of_solid[0], 0.125, 1e-5);
  EXPECT_GE(travels.of_solid[0], 0.125);
}

TEST(WatchedPairs, GatherWhatMayMeet) {
  CubesInARow row({0, 1.75, 9});
  GrowingList<std::uint32_t> close, deferred;
  row.command(std::array{row.go_by(0, 0.5)});
  row.watched.gather(row.model, row.movers, row.lanes, close, deferred);
  ASSERT_EQ(close.size(), 1u);
  EXPECT_EQ(row.watched.pairs().solids(close[0]), (SolidPair{0, 1}));
  EXPECT_TRUE(deferred.empty());
  row.model.selection.apply(SelectionChange::of(row.cubes[0], false), row.model.objects,
                            row.model.mechanisms);
  row.watched.gather(row.model, row.movers, row.lanes, close, deferred);
  EXPECT_TRUE(close.empty());
  row.model.selection.select_all();
  row.movers = {};
  row.movers.take_room(3, true);
  row.watched.gather(row.model, row.movers, row.lanes, close, deferred);
  EXPECT_EQ(close.size(), 1u);  // it was kept, though nobody moves now
}

// Pairs that are clear at the start wait until it is known how far the path matters; their rules are not
// looked up.
TEST(WatchedPairs, DeferWhatIsClearAtTheStart) {
  CubesInARow row({0, 1.75, 9});
  GrowingList<std::uint32_t> close, deferred;
  row.command(std::array{row.go_by(0, 0.5)});
  row.watched.pairs()[row.watched.pairs().find({0, 1})].clear_until = 0.25;
  row.watched.gather(row.model, row.movers, row.lanes, close, deferred);
  EXPECT_TRUE(close.empty());
  ASSERT_EQ(deferred.size(), 1u);
  row.watched.keep_checked(row.model, row.lanes, deferred);
  EXPECT_EQ(deferred.size(), 1u);
  row.model.selection.apply(SelectionChange::of(row.cubes[0], false), row.model.objects,
                            row.model.mechanisms);
  row.watched.keep_checked(row.model, row.lanes, deferred);
  EXPECT_TRUE(deferred.empty());
}

TEST(PairFinder, FindsWhenPairsMeet) {
  CubesInARow row({0, 1.75, 40});
  row.command(std::array{row.go_by(0, 1.0)});
  const GrowingList<FramePair> pairs = row.find();
  EXPECT_EQ(row.candidates, 1u);
  ASSERT_EQ(pairs.size(), 1u);
  EXPECT_EQ(pairs[0].solids, (SolidPair{0, 1}));
  EXPECT_EQ(pairs[0].impact.status, ImpactStatus::blocked);
  EXPECT_NEAR(pairs[0].impact.lo, 0.75, 2 * kGap);
  EXPECT_LT(pairs[0].impact.lo, 0.75);
}

// A touching object stops a mover before all others: those that lie further on are not asked about.
TEST(PairFinder, TakesWhatTouchesFirst) {
  const auto calls_to_find = [](std::span<const ContactState> contacts) {
    CubesInARow row({0, 1 + 0.75 * kGap, 2.1});
    row.command(std::array{row.go_by(0, 1.5)});
    const std::uint64_t before = row.lanes.calls();
    const GrowingList<FramePair> pairs = row.find(contacts);
    EXPECT_FALSE(pairs.empty());
    if (pairs.empty()) return std::uint64_t{0};
    EXPECT_EQ(pairs[0].solids, (SolidPair{0, 1}));
    EXPECT_EQ(pairs[0].impact.status, ImpactStatus::blocked);
    EXPECT_LT(pairs[0].impact.lo, kGap);
    return row.lanes.calls() - before;
  };
  const std::array contacts{ContactState{{0, 1}, {}}};
  EXPECT_EQ(calls_to_find({}), calls_to_find(contacts) + 1);
}

struct Resolved {
  StopResolver resolver;
  StopPermits permits;
  Followers followers;
  MomentLog moments;
  GrowingList<FramePair> pairs;

  explicit Resolved(CubesInARow& row) : pairs(row.find()) {
    const std::size_t count = row.cubes.size();
    resolver.take_room(count, count, true);
    permits.take_room(count, true);
    followers.take_room(count, true);
    followers.begin({}, row.movers.commanded);
    resolver.resolve({row.model, row.lanes.first(), row.movers.roots, followers, permits, moments}, pairs, 0);
  }
};

// The middle one leaves in time for the first one, unless something stops it.
TEST(StopResolver, StopsWhatMeetsTheStopped) {
  CubesInARow free({0, 1.5, 9});
  free.command(std::array{free.go_by(0, 1.0), free.go_by(1, 1.0)});
  EXPECT_EQ(Resolved(free).pairs.size(), 1u);
  EXPECT_EQ(free.model.stops[0], 1.0);
  EXPECT_EQ(free.model.stops[1], 1.0);

  CubesInARow stopped({0, 1.5, 2.75});
  stopped.command(std::array{stopped.go_by(0, 1.0), stopped.go_by(1, 1.0)});
  const Resolved resolved(stopped);
  EXPECT_NEAR(stopped.model.stops[1], 0.25, 4 * kGap);
  EXPECT_NEAR(stopped.model.stops[0], 0.75, 8 * kGap);
  EXPECT_NE(resolved.permits.may_pivot[0], 0);
  EXPECT_EQ(resolved.permits.may_slide[0], 0);
}

// One that holds goes nowhere, so that what would have met it on its way is not stopped there.
TEST(StopResolver, TakesBackWhatHolds) {
  CubesInARow row({0, 1.5, 2.75}, ContactPolicy::hold);
  row.command(std::array{row.go_by(0, 0.25), row.go_by(1, 1.0)});
  const Resolved resolved(row);
  EXPECT_EQ(row.model.stops[1], 0.0);
  EXPECT_EQ(row.model.stops[0], 1.0);
  ASSERT_EQ(resolved.moments.all().size(), 1u);
  EXPECT_NEAR(resolved.moments.all()[0].s, 0.25, 4 * kGap);
}

TEST(Execution, LeavesMoversAtTheirStops) {
  CubesInARow row({0, 5});
  row.command(std::array{row.go_by(0, 1.0), row.go_by(1, 1.0)});
  row.model.stops[0] = 0.5;
  EXPECT_EQ(note_short(row.model, row.movers), 1u);
  ExecutedParts parts;
  execute(row.model, row.watched, row.movers, row.lanes);
  record_part(row.model, row.movers, 0, parts);
  EXPECT_EQ(row.model.from[0].p.x(), 0.5);
  EXPECT_EQ(row.model.from[1].p.x(), 6.0);
  EXPECT_EQ(executed_pose(row.model, parts, 0, 0, 0.25).p.x(), 0.25);
  EXPECT_EQ(executed_pose(row.model, parts, 0, 0, 0.75).p.x(), 0.5);
}

std::vector<EventKind> kinds_of(const std::vector<ContactEvent>& events) {
  std::vector<EventKind> out;
  for (const ContactEvent& event : events) out.push_back(event.kind);
  return out;
}

TEST(ContactLog, TellsAContactFromItsBeginningToItsEnd) {
  // Two cubes half a gap apart.
  CubesInARow row({0, 1.0 + 0.5 * kGap});
  GrowingList<FramePair> pairs{row.model.frame_pair({0, 1})};
  const MomentLog moments;
  ContactLog log;
  log.take_room(2);
  // The events of a frame.
  const auto report = [&](std::span<const FramePair> among) {
    std::vector<ContactEvent> events;
    log.report(row.model, row.lanes, among, moments, 0, events);
    return kinds_of(events);
  };
  // Apart by more, nearer again, and no longer checked.
  EXPECT_EQ(report(pairs), std::vector{EventKind::began});
  EXPECT_EQ(report(pairs), std::vector{EventKind::persists});
  row.model.from[1].p.x() = 1.0 + 1.5 * kGap;  // no longer within the gap, but within twice of it
  EXPECT_EQ(report(pairs), std::vector{EventKind::persists});
  row.model.from[1].p.x() = 1.0 + 3.0 * kGap;
  EXPECT_EQ(report(pairs), std::vector{EventKind::ended});
  EXPECT_TRUE(log.now().empty());
  row.model.from[1].p.x() = 1.0;
  EXPECT_EQ(report(pairs), std::vector{EventKind::began});
  EXPECT_EQ(report({}), std::vector{EventKind::ended});  // no longer checked
  EXPECT_EQ(report(pairs), std::vector{EventKind::began});
  // One of them goes.
  log.end_of(row.model.layout, std::array<std::uint32_t, 1>{1});
  EXPECT_TRUE(log.now().empty());
  EXPECT_EQ(report({}), std::vector{EventKind::ended});
}

TEST(SelectionLog, CountsWhatItsRecordHasNoRoomFor) {
  CubesInARow row({0, 2});
  SelectionLog log;
  log.begin_record(1);
  log.push(SelectionChange::of(row.cubes[0], false));
  log.push(SelectionChange::of(ObjectHandle{7, 7}, false));
  log.push(SelectionChange::of(row.cubes[0], true));
  log.take(row.model, 12);
  EXPECT_EQ(log.applied().size(), 2u);
  EXPECT_EQ(log.refused().size(), 1u);
  ASSERT_EQ(log.record().size(), 1u);
  EXPECT_EQ(log.record()[0].frame, 12u);
  EXPECT_EQ(log.left_out(), 1u);
  EXPECT_TRUE(row.model.is_checked({0, 1}));
}

}  // namespace
}  // namespace touchstone
