// Events, against the distances of all pairs at every frame's end.

#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iostream>

#include "touchstone/tests/world/frames/event_crowd.hpp"

namespace touchstone {
namespace {

using ::testing::ElementsAre;

/// Signed distances from a narrowphase that knows nothing of the world.
class FreshDistances {
 public:
  explicit FreshDistances(const EventCrowd::Known& known) : known_(known) {
    BackendRegistry registry;
    register_core(registry);
    narrowphase_ = registry.make_narrowphase("native");
    narrowphase_->build(known.solids);
    workspace_ = narrowphase_->make_workspace();
  }

  std::vector<PairGeometry> of(std::span<const SolidPair> pairs, std::span<const Pose> X_WS) {
    std::vector<PairStatus> status(pairs.size());
    std::vector<PairGeometry> geometry(pairs.size());
    Query query;
    query.kind = QueryKind::distance;
    narrowphase_->evaluate({pairs, X_WS, query}, {status, geometry, {}}, *workspace_);
    return geometry;
  }
  std::vector<PairGeometry> at_end() { return of(known_.pairs, known_.X_WS); }

  /// Poses of the event's two solids where they were at the event's own s, by the world's account.
  PairGeometry at_own_s(const EventCrowd& crowd, const ContactEvent& event) {
    std::vector<Pose> X_WS = known_.X_WS;
    const SolidPair pair = pair_of(event);
    const auto place = [&](ObjectHandle object, std::uint32_t solid, SolidIndex index) {
      const Pose& X_OS = crowd.items().at(object.slot).tree->solids()[solid].X_OS;
      X_WS[index] = compose(crowd.world().executed_pose(object, event.part, event.s), X_OS);
    };
    place(event.a, event.solids.a, pair.a);
    place(event.b, event.solids.b, pair.b);
    return of({&pair, 1}, X_WS)[0];
  }
  PairGeometry at_end(const ContactEvent& event) {
    const SolidPair pair = pair_of(event);
    return of({&pair, 1}, known_.X_WS)[0];
  }

 private:
  SolidPair pair_of(const ContactEvent& event) const {
    return {known_.index.at({event.a.slot, event.solids.a}), known_.index.at({event.b.slot, event.solids.b})};
  }

  const EventCrowd::Known& known_;
  std::unique_ptr<Narrowphase> narrowphase_;
  std::unique_ptr<Narrowphase::Workspace> workspace_;
};

bool same_bits(const PairGeometry& x, const PairGeometry& y) {
  return x.separation == y.separation && x.n_AB_W == y.n_AB_W && x.p_A_W == y.p_A_W && x.p_B_W == y.p_B_W;
}

/// Counts what is wrong with a run's events.
struct EventFigures {
  std::uint64_t frames = 0, contacts = 0, began = 0, ended = 0, blocked = 0;
  std::uint64_t ended_near = 0;            ///< `ended`, but no further apart than 2 g
  std::uint64_t ended_overlapping = 0;     ///< of these
  std::uint64_t far_in_contact = 0;        ///< further apart than 2 g, not ended
  std::uint64_t contact_not_reported = 0;  ///< within g, never began
  std::uint64_t out_of_turn = 0;           ///< began twice, or persists or ended without having begun
  std::uint64_t silent = 0;                ///< in contact without an event in this frame
  std::uint64_t not_checked = 0;           ///< in contact, of a pair that is not checked

  std::uint64_t compared = 0;     ///< events whose geometry was compared with that at their own s
  std::uint64_t other_bits = 0;   ///< of these: not the same to the last bit
  double worst_separation = 0.0;  ///< the largest difference [m]
  double worst_witness = 0.0;   ///< the largest of |p_B - p_A - separation n|, and of the points' difference
                                ///< where that is no tie [m]
  std::uint64_t ties = 0;       ///< other normals or points at the same separation
  std::uint64_t wrong_end = 0;  ///< geometry_at_end is not that of the frame's end
  std::uint64_t out_of_reach = 0;       ///< an s or a part that the frame has not
  std::uint64_t not_where_it_says = 0;  ///< began beyond g, persists beyond 2 g, ended within 2 g
  std::uint64_t blocked_in_slides = 0, held = 0;
  std::uint64_t blocked_beyond = 0, limits = 0;
};

class EventJudge {
 public:
  void judge(const EventCrowd& crowd, const FrameReport& report, EventFigures& figures) {
    ++figures.frames;
    figures.limits += report.iteration_limits;
    reported_.clear();
    ended_.clear();
    for (const ContactEvent& event : report.events) take(event, figures);
    const EventCrowd::Known known = crowd.checked_pairs();
    FreshDistances distances(known);
    const std::vector<PairGeometry> geometry = distances.at_end();
    for (const ContactEvent& event : report.events)
      if (crowd.items().count(event.a.slot) != 0 && crowd.items().count(event.b.slot) != 0)
        judge_geometry(crowd, event, distances, figures);
    for (std::size_t i = 0; i < known.keys.size(); ++i)
      judge_pair(known.keys[i], geometry[i].separation, figures);
    figures.contacts += in_contact_.size();
    for (const SolidKey& key : in_contact_) {
      figures.silent += reported_.count(key) == 0;
      figures.not_checked += !crowd.is_checked(key);
    }
  }

 private:
  static void judge_geometry(const EventCrowd& crowd, const ContactEvent& event, FreshDistances& distances,
                             EventFigures& figures) {
    figures.wrong_end += !same_bits(event.geometry_at_end, distances.at_end(event));
    figures.out_of_reach +=
        !(event.part < crowd.world().executed_parts() && event.s >= 0.0 && event.s <= 1.0);
    figures.not_where_it_says += !is_where_it_says(crowd, event, figures);
    const bool holds = event.kind == EventKind::blocked &&
                       crowd.policy_of(event.a.slot, event.b.slot) == ContactPolicy::hold;
    if (holds) return;
    const PairGeometry there = distances.at_own_s(crowd, event);
    ++figures.compared;
    if (same_bits(there, event.geometry)) return;
    ++figures.other_bits;
    const PairGeometry& reported = event.geometry;
    figures.worst_separation =
        std::max(figures.worst_separation, std::abs(there.separation - reported.separation));
    figures.worst_witness = std::max(
        figures.worst_witness, norm(reported.p_B_W - reported.p_A_W - reported.separation * reported.n_AB_W));
    if (norm(there.n_AB_W - reported.n_AB_W) > 1e-9 || norm(there.p_A_W - reported.p_A_W) > 1e-9)
      ++figures.ties;
    else
      figures.worst_witness = std::max(figures.worst_witness, norm(there.p_B_W - reported.p_B_W));
  }

  static bool is_where_it_says(const EventCrowd& crowd, const ContactEvent& event, EventFigures& figures) {
    const double separation = event.geometry.separation;
    switch (event.kind) {
      case EventKind::began:
        return separation <= kGap;
      case EventKind::persists:
        return separation <= 2.0 * kGap;
      case EventKind::penetrating_at_start:
        return separation < 0.0 && event.s == 0.0 && event.part == 0;
      case EventKind::blocked:
        figures.held += crowd.policy_of(event.a.slot, event.b.slot) == ContactPolicy::hold;
        figures.blocked_in_slides += event.part > 0;
        figures.blocked_beyond += !(separation <= 2.0 * kGap);  // the check gave up there
        return true;
      case EventKind::ended:
        return event.s == 0.0 || separation > 2.0 * kGap;
      default:
        return true;
    }
  }

  void take(const ContactEvent& event, EventFigures& figures) {
    const SolidKey key = key_of(event);
    if (event.kind == EventKind::blocked) ++figures.blocked;
    if (event.kind == EventKind::began) {
      ++figures.began;
      figures.out_of_turn += !in_contact_.insert(key).second;
      reported_.insert(key);
    } else if (event.kind == EventKind::persists) {
      figures.out_of_turn += in_contact_.count(key) == 0;
      reported_.insert(key);
    } else if (event.kind == EventKind::ended) {
      ++figures.ended;
      figures.out_of_turn += in_contact_.erase(key) == 0;
      ended_.insert(key);
    }
  }

  void judge_pair(const SolidKey& key, double separation, EventFigures& figures) const {
    const bool is_in = in_contact_.count(key) != 0;
    if (ended_.count(key) != 0) {
      figures.ended_near += !(separation > 2.0 * kGap);
      figures.ended_overlapping += separation < 0.0;
    }
    figures.far_in_contact += is_in && !(separation <= 2.0 * kGap);
    figures.contact_not_reported += !is_in && separation <= kGap;
  }

  std::set<SolidKey> in_contact_, reported_, ended_;
};

EventFigures fly_crowds(std::uint64_t first_seed, int worlds, int frames) {
  EventFigures figures;
  for (int k = 0; k < worlds; ++k) {
    EventCrowd crowd(first_seed + static_cast<std::uint64_t>(k));
    EventJudge judge;
    for (int i = 0; i < frames; ++i) judge.judge(crowd, crowd.frame(), figures);
  }
  return figures;
}

void expect_truth(const EventFigures& figures) {
  std::cout << figures.frames << " frames, " << figures.contacts << " contacts at their ends, "
            << figures.began << " began, " << figures.ended << " ended, " << figures.blocked << " blocked\n";
  EXPECT_EQ(figures.ended_near, 0u) << "of them overlapping: " << figures.ended_overlapping;
  EXPECT_EQ(figures.far_in_contact, 0u);
  EXPECT_EQ(figures.contact_not_reported, 0u);
  EXPECT_EQ(figures.out_of_turn, 0u);
  EXPECT_EQ(figures.silent, 0u);
  EXPECT_EQ(figures.not_checked, 0u);
}

TEST(EventTruth, NoContactEndsOrBeginsWhileThePairStaysInIt) { expect_truth(fly_crowds(1, 350, 60)); }

TEST(EventTruth, GeometryIsThatOfTheEventsOwnPoses) {
  const EventFigures figures = fly_crowds(1001, 100, 60);
  std::cout << figures.compared << " events compared, " << figures.other_bits
            << " with other bits; separation " << figures.worst_separation << " m, witness points "
            << figures.worst_witness << " m, ties " << figures.ties << "; blocked in slides "
            << figures.blocked_in_slides << "; held " << figures.held << "\n";
  EXPECT_GT(figures.compared, 10000u);
  EXPECT_GT(figures.blocked_in_slides, 100u);
  EXPECT_EQ(figures.wrong_end, 0u);
  EXPECT_EQ(figures.out_of_reach, 0u);
  EXPECT_EQ(figures.not_where_it_says, 0u);
  EXPECT_LE(figures.blocked_beyond, figures.limits);
  EXPECT_LE(figures.worst_separation, 1e-14);
  EXPECT_LE(figures.worst_witness, 1e-14);
}

// A cube that is commanded to go down onto a table, 0.8 m, from 0.5 m above it.
struct Dropped {
  std::unique_ptr<ContactWorld> world = make_world();
  ObjectHandle table = world->add({box_tree("table", {4, 4, 1}), at(0, 0, -0.5), true});
  ObjectHandle cube = world->add({box_tree("cube", {1, 1, 1}), at(0, 0, 1.0)});
  MotionCommand command = world->move_by(cube, {0, 0, -0.8}, {0, 0, 0});
};

TEST(EventTruth, AHoldSaysWhereTheMotionThatWasNotExecutedWouldHaveMet) {
  Dropped scene;
  const FrameReport report = scene.world->frame(std::array{scene.command});
  ASSERT_THAT(kinds(report), ElementsAre(EventKind::blocked));
  const ContactEvent& event = report.events[0];
  EXPECT_EQ(event.part, 0u);
  EXPECT_NEAR(event.s, 0.5 / 0.8, 1e-8);
  EXPECT_NEAR(event.geometry.separation, scene.command.path.pose_at(event.s).p.z() - 0.5, 1e-15);
  EXPECT_LE(event.geometry.separation, kGap);
  EXPECT_EQ(event.geometry_at_end.separation, 0.5);
}

TEST(EventTruth, ACueThatIsPassedThroughWithinOneFrameBeginsAndEnds) {
  const auto world = make_world();
  world->set_default_rule(rule(ContactPolicy::cue));
  world->add({box_tree("gate", {0.1, 1, 1}), at(0, 0, 0), true});
  const ObjectHandle ball = world->add({box_tree("ball", {0.1, 0.1, 0.1}), at(-1, 0, 0)});
  const FrameReport report = world->frame(std::array{world->move_by(ball, {2, 0, 0}, {0, 0, 0})});
  ASSERT_THAT(kinds(report), ElementsAre(EventKind::began, EventKind::ended));
  EXPECT_NEAR(report.events[0].s, 0.45, 1e-8);
  EXPECT_LE(report.events[0].geometry.separation, kGap);
  EXPECT_NEAR(report.events[0].geometry_at_end.separation, 0.9, 1e-12);
  EXPECT_NEAR(report.events[1].geometry.separation, 0.9, 1e-12);
}

// `a` is stopped by `b`, both in motion; then a third one, for which the step is not executed, runs into `a`
// where that stands. What `b` met is where `a` never was: it goes on.
TEST(EventTruth, NoStopIsLeftOfAStepThatAHoldTookBack) {
  for (const bool reversed : {false, true}) {
    const auto world = make_world();
    world->set_default_rule(rule(ContactPolicy::advance));
    std::array<ObjectHandle, 3> h;
    for (int k = 0; k < 3; ++k) {
      const int i = reversed ? 2 - k : k;
      h[i] = world->add(
          {box_tree(std::string(1, static_cast<char>('a' + i)), {1, 1, 1}), at(i == 0   ? 0
                                                                               : i == 1 ? 3
                                                                                        : -5,
                                                                               i == 1 ? 0.2 : 0, 0)});
    }
    world->set_pair_rule(h[0], h[2], rule(ContactPolicy::hold));
    // a to 1.5 and b to 2.0 would meet at s = 2 / 2.5; c would meet a, which stands at 1.2, later.
    const FrameReport report = world->frame(std::array{world->move_by(h[0], {1.5, 0, 0}, {0, 0, 0}),
                                                       world->move_by(h[1], {-1.0, 0, 0}, {0, 0, 0}),
                                                       world->move_by(h[2], {5.5, 0, 0}, {0, 0, 0})});
    EXPECT_EQ(world->actual_pose(h[0]).p.x(), 0.0);
    EXPECT_EQ(world->actual_pose(h[1]).p.x(), 2.0);
    EXPECT_EQ(world->actual_pose(h[2]).p.x(), -5.0);
    ASSERT_THAT(kinds(report), ElementsAre(EventKind::blocked));
    EXPECT_EQ(world->name_of(report.events[0].a) == "a" || world->name_of(report.events[0].b) == "a", true);
    EXPECT_EQ(world->name_of(report.events[0].a) == "c" || world->name_of(report.events[0].b) == "c", true);
    EXPECT_EQ(report.blocked_movers, 2u);
  }
}

TEST(EventTruth, AContactThatIsSwitchedOffEndsWhereItStood) {
  Dropped scene;
  scene.world->set_default_rule(rule(ContactPolicy::advance));
  scene.world->frame(std::array{scene.command});
  scene.world->exempt({scene.cube, scene.table});
  const FrameReport report =
      scene.world->frame(std::array{scene.world->move_by(scene.cube, {0, 0, -0.1}, {0, 0, 0})});
  ASSERT_THAT(kinds(report), ElementsAre(EventKind::ended));
  EXPECT_EQ(report.events[0].s, 0.0);
  EXPECT_LE(report.events[0].geometry.separation, kGap);
  EXPECT_NEAR(report.events[0].geometry_at_end.separation, -0.1, 1e-8);
}

}  // namespace
}  // namespace touchstone
