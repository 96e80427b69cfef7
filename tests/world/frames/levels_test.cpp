#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cmath>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/contact_core/world/frame/level_search.hpp"
#include "touchstone/tests/support/counting_allocator.hpp"
#include "touchstone/tests/world/arms/arm_fixture.hpp"
#include "touchstone/tests/world/levels_fixture.hpp"

// Objects with levels move to the same bits as without, and what does not hold its hexahedra is refused.

namespace touchstone {
namespace {

// ---- levels that are no levels

std::string refusal_of(const std::shared_ptr<const HexahedronTree>& tree, const Levels& levels,
                       bool is_static = false) {
  const auto world = make_world();
  try {
    world->add({tree, Pose{}, is_static, {}, levels});
    return "";
  } catch (const InputError& error) {
    EXPECT_THROW(world->find(tree->name()), InputError);  // nothing changed
    return error.what();
  }
}

std::shared_ptr<const HexahedronTree> one_hexahedron(const std::array<Vector3, 8>& vertices) {
  return std::make_shared<HexahedronTree>(
      std::vector<PlacedHexahedron>{
          {"only", Hexahedron::from_vertices(vertices, WarpPolicy::accept), Pose{}}},
      "part");
}

std::array<Vector3, 8> cube(double half) {
  std::array<Vector3, 8> vertices;
  for (int i = 0; i < 8; ++i)
    vertices[i] = {(i & 4) ? half : -half, (i & 2) ? half : -half, (i & 1) ? half : -half};
  return vertices;
}

TEST(Levels, AreRefusedWhereOneVertexIsMovedInwardByAPartInATrillion) {
  const auto fine = one_hexahedron(cube(1.0));
  EXPECT_EQ(refusal_of(fine, {one_hexahedron(cube(1.0))}), "");  // closed: it may touch from inside
  for (int vertex = 0; vertex < 8; ++vertex)
    for (const bool is_static : {false, true}) {
      std::array<Vector3, 8> coarse = cube(1.0);
      coarse[vertex] *= 1.0 - 1e-12;
      EXPECT_EQ(refusal_of(fine, {one_hexahedron(coarse)}, is_static),
                "object 'part': hexahedron 'only' (index 0) of level 0 lies in no hexahedron of level 1")
          << vertex;
    }
}

TEST(Levels, AreRefusedWhereAFinerLevelIsNotHeld) {
  const auto fine = one_hexahedron(cube(1.0));
  EXPECT_EQ(refusal_of(fine, {one_hexahedron(cube(2.0)), one_hexahedron(cube(1.5))}),
            "object 'part': hexahedron 'only' (index 0) of level 1 lies in no hexahedron of level 2");
  EXPECT_EQ(refusal_of(fine, {nullptr}), "object 'part': level 1 is null");
  // Two that hold it together are no level: each hexahedron has to lie in one.
  std::array<Vector3, 8> left = cube(1.0), right = left;
  for (int i = 0; i < 8; ++i) (i & 4 ? left : right)[i].x() = 0.0;
  const auto halves = std::make_shared<HexahedronTree>(
      std::vector<PlacedHexahedron>{{"left", Hexahedron::from_vertices(left), Pose{}},
                                    {"right", Hexahedron::from_vertices(right), Pose{}}},
      "part");
  EXPECT_NE(refusal_of(fine, {halves}), "");
  EXPECT_EQ(refusal_of(halves, {fine}), "");
}

TEST(Levels, OfRoundedHexahedraAreAsRounded) {
  const auto tree_of = [](const Hexahedron& solid) {
    return std::make_shared<HexahedronTree>(std::vector<PlacedHexahedron>{{"only", solid, Pose{}}}, "part");
  };
  const auto capsule = tree_of(Hexahedron::capsule(0.1, 1.0));
  EXPECT_NE(refusal_of(capsule, {tree_of(Hexahedron::from_size({1, 1, 2}))}), "");
  EXPECT_NE(refusal_of(capsule, {tree_of(Hexahedron::rounded_box({1, 1, 2}, 0.0999))}), "");
  EXPECT_EQ(refusal_of(capsule, {tree_of(Hexahedron::rounded_box({0, 0, 1}, 0.1))}), "");
}

// ---- the search below two objects

// Against each two hexahedra by themselves, of which none that is within reach may be missing.
TEST(LevelSearch, FindsAllThatAreWithinReach) {
  Random random(18001);
  std::size_t within = 0, found_in_all = 0, all = 0;
  for (int run = 0; run < 300; ++run) {
    const auto tree_a = random_bar(random, "a", 24), tree_b = random_bar(random, "b", 17);
    const ObjectLevels levels_a(*tree_a, levels_about(*tree_a, 5)), levels_b(*tree_b, Levels{});
    std::vector<Hexahedron> solids;
    std::vector<Pose> X_OS, X_WS;
    const double far_out = run % 3 == 0 ? 1e4 : 0.0;
    Pose X_WA = at(far_out, 0, 0), X_WB = at(random.vector(1.0) + Vector3(far_out, 0, 0));
    X_WA.R = rotation_about(Vector3::UnitY(), random.uniform(-3, 3));
    X_WB.R = rotation_about(Vector3::UnitZ(), random.uniform(-3, 3));
    for (const auto& [tree, X] : {std::pair{tree_a, X_WA}, {tree_b, X_WB}})
      for (const PlacedHexahedron& placed : tree->solids())
        solids.push_back(placed.solid), X_OS.push_back(placed.X_OS), X_WS.push_back(compose(X, placed.X_OS));
    const double reach = random.uniform(0.0, 0.3);
    std::vector<SolidPair> found;
    find_pairs_within(reach, {&levels_a, solids.data(), X_OS.data(), 0, X_WA},
                      {&levels_b, solids.data() + 24, X_OS.data() + 24, 24, X_WB}, found);
    std::sort(found.begin(), found.end());
    EXPECT_EQ(std::adjacent_find(found.begin(), found.end()), found.end());
    // One hexahedron against the tree has the same pairs.
    std::vector<SolidPair> one_by_one;
    for (std::uint32_t b = 24; b < solids.size(); ++b)
      find_pairs_within(reach, {&levels_a, solids.data(), X_OS.data(), 0, X_WA},
                        {nullptr, &solids[b], nullptr, b, X_WS[b]}, one_by_one);
    const auto narrowphase = [] {
      BackendRegistry registry;
      register_core(registry);
      return registry.make_narrowphase("native");
    }();
    narrowphase->build(solids);
    const auto workspace = narrowphase->make_workspace();
    for (std::uint32_t a = 0; a < 24; ++a)
      for (std::uint32_t b = 24; b < solids.size(); ++b) {
        const std::array pairs{SolidPair{a, b}};
        std::array<PairStatus, 1> status;
        std::array<PairGeometry, 1> geometry;
        narrowphase->evaluate({.pairs = pairs, .poses = X_WS, .query = {.kind = QueryKind::distance}},
                              {.status = status, .geometry = geometry}, *workspace);
        if (!(geometry[0].separation <= reach)) continue;
        ++within;
        ASSERT_TRUE(std::binary_search(found.begin(), found.end(), pairs[0])) << run;
        ASSERT_NE(std::find(one_by_one.begin(), one_by_one.end(), pairs[0]), one_by_one.end()) << run;
      }
    found_in_all += found.size(), all += 24 * 17;
  }
  EXPECT_GT(within, 1000u);
  EXPECT_LT(found_in_all, 2 * within);
  EXPECT_LT(found_in_all, all / 4);
}

// ---- frames

/// Every bit of a frame's report, but for counts.
std::vector<std::uint64_t> bits_of(const FrameReport& report) {
  std::vector<std::uint64_t> out{report.events.size(), report.blocked_movers, report.slide_steps,
                                 report.iteration_limits, report.felt.size()};
  const auto add = [&](double value) { out.push_back(std::bit_cast<std::uint64_t>(value)); };
  const auto add_vector = [&](const Vector3& v) { add(v.x()), add(v.y()), add(v.z()); };
  for (const ContactEvent& event : report.events) {
    for (const std::uint64_t word :
         {std::uint64_t{static_cast<std::uint8_t>(event.kind)}, std::uint64_t{event.a.slot},
          std::uint64_t{event.b.slot}, std::uint64_t{event.solids.a}, std::uint64_t{event.solids.b},
          std::uint64_t{event.part}})
      out.push_back(word);
    add(event.s);
    for (const PairGeometry& geometry : {event.geometry, event.geometry_at_end}) {
      if (std::isnan(geometry.separation)) continue;
      add(geometry.separation);
      add_vector(geometry.n_AB_W), add_vector(geometry.p_A_W), add_vector(geometry.p_B_W);
    }
  }
  for (const HandFeel& feel : report.felt) add_vector(feel.force_W), add_vector(feel.moment_W);
  return out;
}

enum class Kind : std::uint8_t { one_by_one, levels, spheres };
constexpr std::size_t kCrowds = 4;

ObjectDescription described(Kind kind, const std::shared_ptr<const HexahedronTree>& tree, const Pose& X,
                            bool is_static = false) {
  return {tree,
          X,
          is_static,
          {},
          kind == Kind::levels ? levels_about(*tree, 6) : Levels{},
          kind != Kind::one_by_one};
}

// ---- contacts that end because their two are checked no longer, while they move

/// 20 cubes of 0.1 m along x.
std::shared_ptr<const HexahedronTree> straight_bar(const std::string& name) {
  std::vector<PlacedHexahedron> solids;
  for (int i = 0; i < 20; ++i)
    solids.push_back(
        {"cube " + std::to_string(i), Hexahedron::from_size({0.1, 0.1, 0.1}), at(0.1 * i, 0, 0)});
  return std::make_shared<HexahedronTree>(solids, name);
}

enum class End : std::uint8_t { latch, latch_and_build_anew, exempt };

/// A bar goes against a box; then the pair's check ends, and the bar goes away: beyond its reserve, where the
/// box does not go along.
std::vector<ContactEvent> events_of_end(Kind kind, End end, std::vector<std::uint64_t>& bits) {
  const auto world = make_world();
  world->set_default_rule(rule(ContactPolicy::advance));
  const ObjectHandle bar = world->add(described(kind, straight_bar("bar"), at(0, 0, 0)));
  const ObjectHandle box = world->add({box_tree("box", {0.5, 0.5, 0.5}), at(2.3, 0, 0)});
  const std::array against{world->move_by(bar, {1, 0, 0}, {0, 0, 0})};
  EXPECT_EQ(kinds(world->frame(against)), (std::vector{EventKind::blocked, EventKind::began}));
  if (end == End::exempt)
    world->exempt({bar, box});
  else
    world->latch(bar, box);
  if (end == End::latch_and_build_anew) world->set_threads(1);
  const double far = end == End::exempt ? 20.0 : 1.0;
  const std::array away{world->move_by(bar, {-0.6 * far, 0.8 * far, 0}, {0, 0, 0})};
  const FrameReport report = world->frame(away);
  bits = bits_of(report);
  return {report.events.begin(), report.events.end()};
}

TEST(Levels, EndContactsWhereTheTwoStand) {
  for (const End end : {End::latch, End::latch_and_build_anew, End::exempt}) {
    std::vector<std::uint64_t> one_by_one;
    events_of_end(Kind::one_by_one, end, one_by_one);
    for (const Kind kind : {Kind::one_by_one, Kind::levels, Kind::spheres}) {
      SCOPED_TRACE(std::to_string(static_cast<int>(end)) + " " + std::to_string(static_cast<int>(kind)));
      std::vector<std::uint64_t> bits;
      const std::vector<ContactEvent> events = events_of_end(kind, end, bits);
      ASSERT_EQ(events.size(), 1u);
      EXPECT_EQ(events[0].kind, EventKind::ended);
      EXPECT_NEAR(events[0].geometry.separation, 0.0, 1e-8);
      // The cube that touched is 0.1 m high, the box 0.5 m.
      const double apart = end == End::exempt ? std::hypot(12.0, 16.0 - 0.3) : 0.0;
      EXPECT_NEAR(events[0].geometry_at_end.separation, apart, 1e-8);
      EXPECT_EQ(bits, one_by_one);
    }
  }
}

// A bar goes against an arm's tip and is carried off by it in the next frame: by steps so small that no other
// link is near enough to be watched with the bar.
TEST(Levels, EndContactsOfWhatAnArmTakes) {
  std::vector<std::uint64_t> one_by_one;
  for (const Kind kind : {Kind::one_by_one, Kind::levels, Kind::spheres}) {
    SCOPED_TRACE(static_cast<int>(kind));
    const auto world = make_world();
    world->set_default_rule(rule(ContactPolicy::advance));
    const MechanismHandle arm = world->add_mechanism({make_arm("arm", 3), at(-3, 0, 0), {}});
    const ObjectHandle tip = world->link(arm, "3");
    const ObjectHandle bar = world->add(described(kind, straight_bar("bar"), at(3.06, 0, 0)));
    const std::array against{world->move_by(bar, {-0.05, 0, 0}, {0, 0, 0})};
    const FrameReport touching = world->frame(against);
    ASSERT_EQ(kinds(touching), (std::vector{EventKind::blocked, EventKind::began}));
    world->latch(tip, bar);
    std::vector<double> joints = joints_of(*world, arm);
    for (double& q : joints) q += 0.002;
    const JointCommand command{arm, joints};
    const FrameReport report = world->frame({}, {&command, 1});
    ASSERT_EQ(kinds(report), std::vector{EventKind::ended});
    EXPECT_NEAR(report.events[0].geometry_at_end.separation, 0.0, 1e-8);
    if (kind == Kind::one_by_one) one_by_one = bits_of(report);
    EXPECT_EQ(bits_of(report), one_by_one);
  }
}

// ---- crowds

struct Crowd {
  std::unique_ptr<ContactWorld> world = make_world();
  std::vector<ObjectHandle> movers;
  MechanismHandle arm;
  ObjectHandle payload;
  Kind kind;

  explicit Crowd(Kind given) : kind(given) {}

  ObjectHandle add(const std::shared_ptr<const HexahedronTree>& tree, const Pose& X, bool is_static) {
    return world->add(described(kind, tree, X, is_static));
  }
};

struct Counts {
  std::uint64_t queries = 0, candidates = 0, events = 0, blocked = 0, slid = 0, joined = 0;
  void add(const FrameReport& report) {
    queries += report.queries, candidates += report.candidate_pairs, events += report.events.size();
    blocked += report.blocked_movers, slid += report.slide_steps > 0;
  }
};

/// Crooked bars that fly about a place where two stand, and an arm that carries one; the same with each
/// hexahedron looked at by itself, with levels, with these on two threads, and with spheres alone.
class Crowds {
 public:
  explicit Crowds(std::uint64_t seed) : random_(seed) { crowds_[2].world->set_threads(2); }

  void fly(int frames, std::array<Counts, kCrowds>& counts) {
    register_all();
    for (int frame = 0; frame < frames; ++frame) {
      if (frame % 5 == 4) {
        part();
        edit(frame);
      }
      if (frame % 3 == 2 && carried_ == ObjectHandle{}) counts[0].joined += join();
      ASSERT_NO_FATAL_FAILURE(fly_frame(frame, counts));
    }
  }

 private:
  void register_all() {
    constexpr std::array kPolicies{ContactPolicy::slide, ContactPolicy::advance, ContactPolicy::hold,
                                   ContactPolicy::cue};
    const PairRule common{kPolicies[random_.below(4)], random_.one_in(2) ? 0.05 : 0.0};
    const bool shoves = random_.one_in(3);
    for (Crowd& crowd : crowds_) {
      crowd.world->set_default_rule(
          {common.policy, common.warn_distance, {}, shoves ? std::optional(Passive::shoved) : std::nullopt});
      if (shoves) crowd.world->set_default_hand(HandStiffness{});
    }
    for (int i = 0; i < 2; ++i) add_bar("standing " + std::to_string(i), true);
    for (int i = 0; i < 5; ++i) add_bar("mover " + std::to_string(i), false);
    const auto payload = random_bar(random_, "payload", 30);
    for (Crowd& crowd : crowds_) {
      crowd.arm = crowd.world->add_mechanism({make_arm("arm", 3), at(-3, 0, 0.5), {}});
      crowd.payload = crowd.add(payload, at(3.0, 0, 0.5), false);
      const ObjectHandle tip = crowd.world->link(crowd.arm, "3");
      crowd.world->latch(tip, crowd.payload, {{tip, crowd.payload}});
    }
  }

  void add_bar(const std::string& name, bool is_static) {
    const auto tree = random_bar(random_, name, 6 + static_cast<int>(random_.below(40)));
    Pose X = at(random_.vector(2.0));
    X.R = rotation_about(Vector3::UnitZ(), random_.uniform(-3, 3));
    for (Crowd& crowd : crowds_) {
      const ObjectHandle bar = crowd.add(tree, X, is_static);
      if (!is_static) crowd.movers.push_back(bar);
    }
  }

  /// One goes and another comes, often into its slot; one pair gets a rule.
  void edit(int frame) {
    const std::uint32_t place = random_.below(static_cast<std::uint32_t>(crowds_[0].movers.size()));
    for (Crowd& crowd : crowds_) {
      crowd.world->remove(crowd.movers[place]);
      crowd.movers.erase(crowd.movers.begin() + place);
    }
    add_bar("late " + std::to_string(frame), false);
    const std::uint32_t one = random_.below(static_cast<std::uint32_t>(crowds_[0].movers.size()));
    const PairRule own{ContactPolicy::advance, random_.uniform(0.0, 0.3)};
    const bool is_on = random_.one_in(2);
    for (Crowd& crowd : crowds_) {
      if (crowd.movers[one] != crowd.movers.back())
        crowd.world->set_pair_rule(crowd.movers[one], crowd.movers.back(), own);
      crowd.world->select(SelectionChange::of(crowd.movers[one], is_on));
      if (frame == 9) crowd.world->unlatch(crowd.payload);
    }
  }

  /// Two that touch are exempted, or one carries the other until the next edit. @returns whether there are
  /// two.
  bool join() {
    const std::vector<ObjectHandle>& movers = crowds_[0].movers;
    const auto a = std::find(movers.begin(), movers.end(), touching_.first) - movers.begin();
    const auto b = std::find(movers.begin(), movers.end(), touching_.second) - movers.begin();
    if (std::max(a, b) == std::ssize(movers)) return false;
    const bool latches = random_.one_in(2);
    for (Crowd& crowd : crowds_)
      latches ? crowd.world->latch(crowd.movers[a], crowd.movers[b])
              : crowd.world->exempt({crowd.movers[a], crowd.movers[b]});
    if (latches) carried_ = movers[b];
    return true;
  }

  void part() {
    const std::vector<ObjectHandle>& movers = crowds_[0].movers;
    const auto carried = std::find(movers.begin(), movers.end(), carried_) - movers.begin();
    if (carried == std::ssize(movers)) return;
    for (Crowd& crowd : crowds_) crowd.world->unlatch(crowd.movers[carried]);
    carried_ = {};
  }

  /// Two movers of the first crowd that are in contact now.
  void note_touching(const FrameReport& report) {
    const auto is_mover = [&](ObjectHandle object) {
      return std::count(crowds_[0].movers.begin(), crowds_[0].movers.end(), object) > 0;
    };
    touching_ = {};
    for (const ContactEvent& event : report.events)
      if ((event.kind == EventKind::began || event.kind == EventKind::persists) && is_mover(event.a) &&
          is_mover(event.b))
        touching_ = {event.a, event.b};
  }

  void fly_frame(int frame, std::array<Counts, kCrowds>& counts) {
    // All are drawn to the middle, some by large steps, some turned by much.
    std::vector<RigidPath> paths;
    for (const ObjectHandle mover : crowds_[0].movers) {
      const Pose& X = crowds_[0].world->actual_pose(mover);
      const double size = random_.one_in(6) ? 1.5 : 0.1;
      paths.push_back(RigidPath::by(X, -0.1 * X.p + random_.vector(size), random_.vector(size)));
    }
    std::vector<double> joints = joints_of(*crowds_[0].world, crowds_[0].arm);
    for (double& q : joints) q = std::clamp(q + random_.uniform(-0.2, 0.2), -1.0, 1.0);
    std::array<std::vector<std::uint64_t>, kCrowds> bits;
    for (std::size_t i = 0; i < kCrowds; ++i) {
      Crowd& crowd = crowds_[i];
      std::vector<MotionCommand> commands;
      for (std::size_t k = 0; k < paths.size(); ++k) commands.push_back({crowd.movers[k], paths[k]});
      const JointCommand joint_command{crowd.arm, joints};
      const FrameReport report = crowd.world->frame(commands, {&joint_command, 1});
      counts[i].add(report);
      if (i == 0) note_touching(report);
      bits[i] = bits_of(report);
      ASSERT_EQ(bits[i], bits[0]) << "crowd " << i << " frame " << frame;
    }
    compare_poses(frame);
  }

  void compare_poses(int frame) {
    const ContactWorld& first = *crowds_[0].world;
    for (std::size_t i = 1; i < kCrowds; ++i) {
      const Crowd& crowd = crowds_[i];
      ASSERT_EQ(crowd.world->executed_parts(), first.executed_parts());
      for (std::size_t k = 0; k < crowd.movers.size(); ++k) {
        const ObjectHandle a = crowds_[0].movers[k], b = crowd.movers[k];
        ASSERT_TRUE(has_same_bits(first.actual_pose(a), crowd.world->actual_pose(b))) << frame;
        for (std::size_t part = 0; part < first.executed_parts(); ++part)
          ASSERT_TRUE(
              has_same_bits(first.executed_pose(a, part, 0.3), crowd.world->executed_pose(b, part, 0.3)));
        const auto solids_a = first.solid_poses(a), solids_b = crowd.world->solid_poses(b);
        ASSERT_EQ(solids_a.size(), solids_b.size());
        for (std::size_t s = 0; s < solids_a.size(); ++s)
          ASSERT_TRUE(has_same_bits(solids_a[s], solids_b[s])) << frame;
      }
      ASSERT_TRUE(
          has_same_bits(first.actual_pose(crowds_[0].payload), crowd.world->actual_pose(crowd.payload)));
      ASSERT_EQ(joints_of(first, crowds_[0].arm), joints_of(*crowd.world, crowd.arm));
    }
  }

  Random random_;
  std::pair<ObjectHandle, ObjectHandle> touching_;
  ObjectHandle carried_;
  std::array<Crowd, kCrowds> crowds_{Crowd(Kind::one_by_one), Crowd(Kind::levels), Crowd(Kind::levels),
                                     Crowd(Kind::spheres)};
};

TEST(Levels, MoveCrowdsToTheSameBits) {
  std::array<Counts, kCrowds> counts;
  for (std::uint64_t seed = 18100; seed < 18112; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    ASSERT_NO_FATAL_FAILURE(Crowds(seed).fly(16, counts));
  }
  EXPECT_GT(counts[0].blocked, 100u);
  EXPECT_GT(counts[0].slid, 20u);
  EXPECT_GT(counts[0].events, 1000u);
  EXPECT_GT(counts[0].joined, 10u);
  EXPECT_EQ(counts[1].queries, counts[2].queries);
  // A solid that was closed and opened again is no longer known to be clear.
  for (const std::size_t i : {1, 3}) {
    EXPECT_LT(counts[i].queries, counts[0].queries + counts[0].queries / 50);
    EXPECT_LT(counts[i].candidates, counts[0].candidates + counts[0].candidates / 50);
  }
}

/// An arm that carries a bar slides about among others that stand, in steps that go beyond its reserves.
struct SlidingArm {
  std::unique_ptr<ContactWorld> world = make_world();
  MechanismHandle arm;

  SlidingArm(Kind kind, Random random) {
    world->set_default_rule(rule(ContactPolicy::slide));
    arm = world->add_mechanism({make_arm("arm", 3), at(-3, 0, 0), {}});
    const auto payload = random_bar(random, "payload", 24);
    const ObjectHandle carried = world->add(described(kind, payload, at(3.9, 0, 0.2)));
    const ObjectHandle tip = world->link(arm, "3");
    world->latch(tip, carried, {{tip, carried}});
    for (int i = 0; i < 8; ++i) {
      const auto bar = random_bar(random, "bar " + std::to_string(i), 20);
      const double angle = random.uniform(-2.5, 2.5), out = random.uniform(3.0, 6.5);
      Pose X = at(-3 + out * std::cos(angle), out * std::sin(angle), 0);
      X.R = rotation_about(Vector3::UnitZ(), random.uniform(-3, 3));
      world->add(described(kind, bar, X, i % 2 == 0));
    }
  }
};

TEST(Levels, SlideArmsToTheSameBits) {
  std::size_t slid = 0;
  for (std::uint64_t seed = 18300; seed < 18304; ++seed) {
    Random random(seed);
    std::array<SlidingArm, 3> arms{SlidingArm(Kind::one_by_one, random), SlidingArm(Kind::levels, random),
                                   SlidingArm(Kind::spheres, random)};
    Random steps(seed + 1000);
    for (int frame = 0; frame < 25; ++frame) {
      const double size = steps.one_in(3) ? 1.0 : 0.1;
      std::vector<double> joints = joints_of(*arms[0].world, arms[0].arm);
      for (double& q : joints) q = std::clamp(q + steps.uniform(-size, size), -2.5, 2.5);
      std::vector<std::uint64_t> one_by_one;
      for (SlidingArm& each : arms) {
        const JointCommand command{each.arm, joints};
        const FrameReport report = each.world->frame({}, {&command, 1});
        if (&each == &arms[0]) one_by_one = bits_of(report), slid += report.slide_steps > 0;
        ASSERT_EQ(bits_of(report), one_by_one) << "seed " << seed << " frame " << frame;
        ASSERT_EQ(joints_of(*each.world, each.arm), joints_of(*arms[0].world, arms[0].arm));
      }
    }
  }
  EXPECT_GT(slid, 20u);
}

// Two bars fly by each other, near and far, for as long as frames have to be without allocations.
TEST(Levels, AllocateNothingInFrames) {
  Random random(18200);
  const auto world = make_world();
  world->set_default_rule(rule(ContactPolicy::slide, 0.01));
  std::array<ObjectHandle, 2> bars;
  for (std::size_t i = 0; i < 2; ++i) {
    const auto tree = random_bar(random, "bar " + std::to_string(i), 60);
    bars[i] = world->add({tree, at(0, i == 0 ? 0.0 : 3.0, 0), false, {}, levels_about(*tree, 8)});
  }
  std::size_t before = 0, blocked = 0;
  for (int frame = 0; frame < 300; ++frame) {
    if (frame == 60) before = allocation_count();
    const double sign = frame / 30 % 2 ? 1.0 : -1.0;
    const std::array commands{world->move_by(bars[0], {0.01, -0.1 * sign, 0}, {0, 0, 0.03}),
                              world->move_by(bars[1], {0.01 * sign, 0.1 * sign, 0}, {0.02, 0, 0})};
    blocked += world->frame(commands).blocked_movers;
  }
  EXPECT_EQ(allocation_count(), before);
  EXPECT_GT(blocked, 20u);
}

}  // namespace
}  // namespace touchstone
