#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <bit>
#include <cmath>
#include <latch>
#include <random>
#include <thread>
#include <tuple>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/contact_core/native/native.hpp"
#include "touchstone/contact_core/threads/thread_team.hpp"
#include "touchstone/contact_core/world/model/frame_lanes.hpp"
#include "touchstone/tests/support/counting_allocator.hpp"
#include "touchstone/tests/support/random_solid.hpp"
#include "touchstone/tests/world/arms/arm_fixture.hpp"
#include "touchstone/tests/world/world_fixture.hpp"

// Frames on several threads are those of one, bit by bit, whatever is in them: slides, shoves, stops, arms,
// latches, objects that come and go. Nor does it show in which
// order objects were registered.

namespace touchstone {
namespace {

/// The caller's own: last task first, all of them on one thread; or each on a thread of its own, all of them
/// at once, so that none has done all the work before the next one wakes.
class BackwardRunner final : public TaskRunner {
 public:
  BackwardRunner(std::size_t threads, bool starts) : threads_(threads), starts_(starts) {}
  std::size_t threads() const noexcept override { return threads_; }
  void run(std::size_t count, Task task) noexcept override {
    ++runs;
    std::vector<std::thread> started;
    std::latch all_are_there(static_cast<std::ptrdiff_t>(count));
    for (std::size_t i = count; i-- > 0;)
      if (starts_)
        started.emplace_back([&all_are_there, task, i] {
          all_are_there.arrive_and_wait();
          task(i);
        });
      else
        task(i);
    for (std::thread& thread : started) thread.join();
  }
  int runs = 0;

 private:
  std::size_t threads_;
  bool starts_;
};

/// Every bit of all reports of frames.
class Log {
 public:
  void add(std::uint64_t word) { words_.push_back(word); }
  void add(double value) { add(std::bit_cast<std::uint64_t>(value)); }
  void add(const Vector3& v) {
    for (int i = 0; i < 3; ++i) add(v[i]);
  }
  void add(const Pose& X) {
    for (int i = 0; i < 9; ++i) add(X.R(i / 3, i % 3));
    add(X.p);
  }
  void add(const ObjectHandle& object) { add(std::uint64_t{object.slot} << 32 | object.generation); }
  void add(const PairGeometry& geometry) {
    add(geometry.separation), add(geometry.n_AB_W), add(geometry.p_A_W), add(geometry.p_B_W);
  }
  void add(const ContactEvent& event) {
    add(static_cast<std::uint64_t>(event.kind)), add(event.a), add(event.b), add(event.s);
    add(std::uint64_t{event.solids.a} << 32 | event.solids.b), add(std::uint64_t{event.part});
    add(event.geometry), add(event.geometry_at_end);
  }
  void add(const FrameReport& report) {
    for (const std::uint64_t count :
         {report.frame, std::uint64_t{report.blocked_movers}, std::uint64_t{report.candidate_pairs},
          report.queries, std::uint64_t{report.iteration_limits}, std::uint64_t{report.slide_steps},
          report.slide_pairs, report.most_slide_work, std::uint64_t{report.selections.size()},
          std::uint64_t{report.refused_selections.size()}})
      add(count);
    for (const ContactEvent& event : report.events) add(event);
    for (const ObjectHandle& object : report.cut_off) add(object);
    for (const HandFeel& felt : report.felt) {
      add(felt.object);
      for (const Vector3& v : {felt.p_W, felt.lag_W, felt.turn_lag_W, felt.force_W, felt.moment_W}) add(v);
    }
  }

  std::size_t size() const { return words_.size(); }
  friend bool operator==(const Log&, const Log&) = default;

 private:
  std::vector<std::uint64_t> words_;
};

/// An event without the numbers that objects got: by names, the lower one first.
using NamedEvent = std::tuple<std::string, std::string, int, std::uint32_t, double, double>;

std::vector<NamedEvent> named_events(const ContactWorld& world, const FrameReport& report) {
  std::vector<NamedEvent> out;
  for (const ContactEvent& event : report.events) {
    if (!world.is_alive(event.a) || !world.is_alive(event.b)) continue;
    std::string a(world.name_of(event.a)), b(world.name_of(event.b));
    if (b < a) std::swap(a, b);
    out.emplace_back(a, b, static_cast<int>(event.kind), event.part, event.s, event.geometry.separation);
  }
  std::sort(out.begin(), out.end());
  return out;
}

/// Enough that every stage of a frame has work for several lanes: poses of 128 objects and more, for one.
constexpr int kCrowd = 260;

struct FlightOptions {
  std::uint64_t seed = 1;
  int objects = 200;
  bool shuffled = false;  // in which order objects are registered
  std::unique_ptr<Narrowphase> narrowphase = make_native();
};

/// A crowd with two arms in it, with random commands.
class Flight {
 public:
  explicit Flight(FlightOptions options) : random_(options.seed) {
    BackendRegistry registry;
    register_core(registry);
    world =
        std::make_unique<ContactWorld>(std::move(options.narrowphase), registry.make_broadphase("native"));
    world->set_default_rule(rule(ContactPolicy::slide, 0.02));
    add_rules();
    const int side = static_cast<int>(std::ceil(std::cbrt(options.objects)));
    std::vector<ObjectDescription> descriptions;
    for (int i = 0; i < options.objects; ++i) descriptions.push_back(description(i, side));
    std::vector<std::size_t> order(descriptions.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
    Random shuffle(options.seed + 1000);
    for (std::size_t i = order.size(); options.shuffled && i-- > 1;)
      std::swap(order[i], order[shuffle.below(static_cast<std::uint32_t>(i + 1))]);
    objects.resize(order.size());
    for (const std::size_t i : order) objects[i] = world->add(descriptions[i]);
    for (int i = 0; i < 2; ++i)
      arms.push_back(
          world->add_mechanism({make_arm("arm " + std::to_string(i), 3), at(1.0, 2.0 + 3.0 * i, 2.1), {}}));
    for (std::size_t i = 0; i + 1 < objects.size(); i += 9)
      attempt([&] { world->latch(objects[i], objects[i + 1]); });
  }

  FrameReport fly() {
    if (changes) change();
    commands_.clear(), joint_commands_.clear();
    for (const ObjectHandle object : objects) {
      const Vector3 by = random_.vector(0.15), turn = random_.vector(0.1);
      if (random_.below(4) != 0 && world->is_alive(object))
        commands_.push_back(world->move_by(object, by, turn));
    }
    for (std::size_t i = 0; i < arms.size(); ++i) {
      joints_[i].clear();
      for (const double value : world->joint_values(arms[i]))
        joints_[i].push_back(value + random_.uniform(-0.1, 0.1));
      joint_commands_.push_back({arms[i], joints_[i]});
    }
    return world->frame(commands_, joint_commands_);
  }

  void log(const FrameReport& report, Log& out) const {
    out.add(report);
    for (const ObjectHandle object : objects) {
      if (!world->is_alive(object)) continue;
      out.add(world->actual_pose(object));
      for (std::size_t part = 0; part < world->executed_parts(); ++part)
        out.add(world->executed_pose(object, part, 0.37));
    }
    for (const MechanismHandle arm : arms)
      for (const double value : world->joint_values(arm)) out.add(value);
  }

  std::unique_ptr<ContactWorld> world;
  std::vector<ObjectHandle> objects;
  std::vector<MechanismHandle> arms;
  bool changes = true;

 private:
  void add_rules() {
    const auto between = [&](const char* first, const char* second, ContactPolicy policy, Passive passive) {
      PairRule rule;
      rule.policy = policy, rule.passive = passive;
      world->set_group_rule(first, second, rule);
    };
    between("a", "a", ContactPolicy::advance, Passive::stays);
    between("a", "b", ContactPolicy::slide, Passive::shoved);
    between("b", "b", ContactPolicy::cue, Passive::stays);
    between("b", "c", ContactPolicy::hold, Passive::stays);
    between("c", "c", ContactPolicy::advance, Passive::carried);
  }

  ObjectDescription description(int place, int side) {
    const auto tree = std::make_shared<HexahedronTree>(
        std::vector<PlacedHexahedron>{{"solid", random_solid(random_, 1.0), Pose{}}},
        "object " + std::to_string(named_++));
    const Vector3 off = random_.vector(0.15);
    const Pose X = at(1.1 * (place % side) + off.x(), 1.1 * (place / side % side) + off.y(),
                      1.1 * (place / side / side) + off.z());
    std::vector<std::string> groups;
    if (random_.below(4) == 0) groups.push_back(std::string(1, static_cast<char>('a' + random_.below(3))));
    return {tree, X, random_.below(8) == 0, groups};
  }

  /// The same draws, whether or not the world takes it.
  void change() {
    const std::size_t i = random_.below(static_cast<std::uint32_t>(objects.size()));
    const std::size_t k = random_.below(static_cast<std::uint32_t>(objects.size()));
    const bool on = random_.below(2) == 0;
    const ObjectDescription fresh = description(static_cast<int>(i), 6);
    switch (random_.below(5)) {
      case 0:
        return attempt([&] { world->remove(objects[i]); });
      case 1:
        return attempt([&] {
          const ObjectHandle added = world->add(fresh);
          objects.push_back(added);
        });
      case 2:
        return attempt([&] { world->latch(objects[i], objects[k]); });
      case 3:
        return attempt([&] { world->unlatch(objects[i]); });
      default:
        return attempt([&] { world->select(SelectionChange::of(objects[i], on)); });
    }
  }

  template <class Change>
  static void attempt(Change change) {
    try {
      change();
    } catch (const InputError&) {  // removed already, or carried
    }
  }

  Random random_;
  int named_ = 0;
  std::vector<MotionCommand> commands_;
  std::vector<JointCommand> joint_commands_;
  std::array<std::vector<double>, 2> joints_;
};

struct Counted {
  std::uint64_t slides = 0, blocked = 0, pairs = 0, events = 0;
};

/// @param prepare lends the world its threads.
template <class Prepare>
std::vector<Log> fly(FlightOptions options, int frames, Prepare prepare, Counted* counted = nullptr) {
  Flight flight(std::move(options));
  prepare(*flight.world);
  std::vector<Log> out(static_cast<std::size_t>(frames));
  for (Log& log : out) {
    const FrameReport report = flight.fly();
    flight.log(report, log);
    if (counted == nullptr) continue;
    counted->slides += report.slide_steps, counted->blocked += report.blocked_movers;
    counted->pairs += report.candidate_pairs, counted->events += report.events.size();
  }
  return out;
}

void expect_same(const std::vector<Log>& one, const std::vector<Log>& other, const std::string& what) {
  ASSERT_EQ(one.size(), other.size());
  for (std::size_t i = 0; i < one.size(); ++i) ASSERT_TRUE(one[i] == other[i]) << what << ", frame " << i;
}

TEST(FrameThreads, AnyNumberGivesTheReportsAndPosesOfOne) {
  Counted counted;
  for (const std::uint64_t seed : {1, 2}) {
    const auto options = [&] { return FlightOptions{.seed = seed, .objects = kCrowd}; };
    const std::vector<Log> alone = fly(
        options(), 4, [](ContactWorld&) {}, &counted);
    for (const std::size_t threads : {1, 2, 3, 8}) {
      const auto together = fly(options(), 4, [&](ContactWorld& world) { world.set_threads(threads); });
      expect_same(alone, together, std::to_string(threads) + " threads, seed " + std::to_string(seed));
    }
  }
  // There was something to find, and enough of it for several threads.
  EXPECT_GT(counted.slides, 24u);
  EXPECT_GT(counted.blocked, 500u);
  EXPECT_GT(counted.events, 2000u);
  EXPECT_GT(counted.pairs, 12u * 256u);
}

TEST(FrameThreads, TheCallersRunnerGivesTheSame) {
  const std::vector<Log> alone = fly({.seed = 4, .objects = kCrowd}, 3, [](ContactWorld&) {});
  for (const bool starts : {false, true}) {
    BackwardRunner runner(5, starts);
    const auto lent =
        fly({.seed = 4, .objects = kCrowd}, 3, [&](ContactWorld& world) { world.set_task_runner(&runner); });
    expect_same(alone, lent, starts ? "threads of their own" : "backward");
    EXPECT_GT(runner.runs, 3 * 10);  // stages of a frame
  }
  ThreadTeam team(3);
  expect_same(
      alone,
      fly({.seed = 4, .objects = kCrowd}, 3, [&](ContactWorld& world) { world.set_task_runner(&team); }),
      "a team");
  BackwardRunner many(1000, false);
  expect_same(
      alone,
      fly({.seed = 4, .objects = kCrowd}, 3, [&](ContactWorld& world) { world.set_task_runner(&many); }),
      "1000 threads");
}

TEST(FrameThreads, MayBeChangedBetweenFrames) {
  ThreadTeam team(2);
  Flight one({.seed = 5, .objects = kCrowd}), other({.seed = 5, .objects = kCrowd});
  for (int frame = 0; frame < 5; ++frame) {
    if (frame < 3) other.world->set_threads(2 + static_cast<std::size_t>(frame) / 2);
    if (frame == 3) other.world->set_task_runner(&team);
    if (frame == 4) other.world->set_task_runner(nullptr);
    const FrameReport report = one.fly(), again = other.fly();
    for (std::size_t i = 0; i < one.objects.size(); ++i) {
      if (!one.world->is_alive(one.objects[i])) continue;
      const Pose &X = one.world->actual_pose(one.objects[i]), &Y = other.world->actual_pose(other.objects[i]);
      ASSERT_TRUE(X.p == Y.p && X.R == Y.R) << "frame " << frame << ", object " << i;
    }
    ASSERT_EQ(named_events(*one.world, report), named_events(*other.world, again)) << "frame " << frame;
  }
}

TEST(FrameThreads, NumbersThatAreNoneAreRefused) {
  const auto world = make_world();
  EXPECT_THROW(world->set_threads(0), InputError);
  EXPECT_THROW(world->set_threads(65), InputError);
  world->set_threads(64);
  world->set_threads(1);
}

/// Gives no answer for one pair in `one_in`.
class PatchyNarrowphase final : public Narrowphase {
 public:
  PatchyNarrowphase(std::uint32_t one_in, bool thread_safe) : one_in_(one_in) {
    capabilities_ = native_->capabilities();
    capabilities_.thread_safe = thread_safe;
  }
  std::string_view name() const noexcept override { return "patchy"; }
  const Capabilities& capabilities() const noexcept override { return capabilities_; }
  void build(std::span<const Hexahedron> solids) override { native_->build(solids); }
  std::unique_ptr<Workspace> make_workspace() const override { return native_->make_workspace(); }
  void evaluate(const NarrowphaseInput& input, const NarrowphaseOutput& output,
                Workspace& workspace) const noexcept override {
    const int inside = inside_.fetch_add(1);
    int most = most_inside_->load();
    while (most < inside + 1 && !most_inside_->compare_exchange_weak(most, inside + 1)) {
    }
    native_->evaluate(input, output, workspace);
    for (std::size_t i = 0; i < input.pairs.size(); ++i)
      if ((input.pairs[i].a * 31 + input.pairs[i].b) % one_in_ == 0) output.status[i] = PairStatus::failed;
    inside_.fetch_sub(1);
  }
  std::shared_ptr<std::atomic<int>> most_inside() const { return most_inside_; }

 private:
  std::unique_ptr<Narrowphase> native_ = make_native();
  Capabilities capabilities_;
  std::uint32_t one_in_;
  mutable std::atomic<int> inside_{0};
  std::shared_ptr<std::atomic<int>> most_inside_ = std::make_shared<std::atomic<int>>(0);
};

TEST(FrameThreads, AnswersThatFailStopTheSameMovers) {
  const auto options = [] {
    return FlightOptions{
        .seed = 6, .objects = 130, .narrowphase = std::make_unique<PatchyNarrowphase>(7, true)};
  };
  Counted counted;
  const std::vector<Log> alone = fly(
      options(), 5, [](ContactWorld&) {}, &counted);
  expect_same(alone, fly(options(), 5, [](ContactWorld& world) { world.set_threads(3); }), "3 threads");
  EXPECT_GT(counted.blocked, 150u);
}

TEST(FrameThreads, ANarrowphaseThatIsNotThreadSafeIsAskedOnOne) {
  auto narrowphase = std::make_unique<PatchyNarrowphase>(1000000, false);
  const auto most = narrowphase->most_inside();
  FlightOptions options{.seed = 7, .objects = 130, .narrowphase = std::move(narrowphase)};
  const auto log = fly(std::move(options), 4, [](ContactWorld& world) { world.set_threads(4); });
  EXPECT_EQ(*most, 1);
}

TEST(FrameThreads, FramesDoNotAllocate) {
  for (const std::size_t threads : {1, 2, 3}) {
    Flight flight({.seed = 8, .objects = 200});
    flight.changes = false;
    flight.world->set_threads(threads);
    std::size_t allocated = 0, slid = 0;
    std::vector<MotionCommand> commands;
    commands.reserve(flight.objects.size());
    for (int frame = 0; frame < 12; ++frame) {
      commands.clear();
      for (std::size_t i = 0; i < flight.objects.size(); ++i) {
        const double sign = (frame / 5 + i) % 2 ? 1.0 : -1.0;
        commands.push_back(
            flight.world->move_by(flight.objects[i], {sign * 0.05, 0.02, sign * 0.03}, {0, 0, 0.02}));
      }
      const std::size_t before = allocation_count();
      slid += flight.world->frame(commands).slide_steps;
      if (frame > 0) allocated += allocation_count() - before;
    }
    EXPECT_EQ(allocated, 0u) << threads << " threads";
    EXPECT_GT(slid, 10u);
  }
}

/// Boxes through each other's places: poses and forces after a few frames of slides.
std::vector<Vector3> slide_through(std::size_t threads, const SlideBudget& budget) {
  // A dense crowd in which all slide.
  std::mt19937 engine(11);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  const auto vector = [&](double most) {
    return Vector3(most * uniform(engine), most * uniform(engine), most * uniform(engine));
  };
  const auto world = make_world();
  world->set_default_rule(rule(ContactPolicy::slide));
  world->set_default_hand(HandStiffness{});
  world->set_threads(threads);
  world->set_slide_budget(budget);
  std::vector<ObjectHandle> boxes;
  for (int i = 0; i < 120; ++i) {
    const Vector3 p = vector(2.0);
    boxes.push_back(world->add(
        {box_tree("box " + std::to_string(i), {0.3, 0.4, 0.5}), at(p.x(), p.y(), p.z()), false, {}}));
  }
  // Forces at hands, and where boxes are.
  std::vector<Vector3> out;
  for (int frame = 0; frame < 4; ++frame) {
    std::vector<MotionCommand> commands;
    for (const ObjectHandle box : boxes) commands.push_back(world->move_by(box, vector(0.1), vector(0.1)));
    const FrameReport report = world->frame(commands);
    for (const HandFeel& felt : report.felt) out.push_back(felt.force_W), out.push_back(felt.moment_W);
    for (const ObjectHandle box : boxes) out.push_back(world->actual_pose(box).p);
    EXPECT_GT(report.felt.size(), 32u);
  }
  return out;
}

/// The same where beside sliders some only advance, and turn about what they touch, and others shove what
/// nobody commanded to move.
struct MixedSlides {
  std::vector<Pose> poses;
  int slid = 0, pivoted = 0, shoved = 0;
};

MixedSlides slide_and_shove(std::size_t threads, const SlideBudget& budget) {
  // A heap of boxes that slide, pivot and are shoved.
  Random random(12);
  const auto world = make_world();
  world->set_default_rule(rule(ContactPolicy::slide));
  world->set_default_hand(HandStiffness{});
  PairRule shoving = rule(ContactPolicy::slide);
  shoving.passive = Passive::shoved;
  world->set_group_rule("idle", "sliders", shoving), world->set_group_rule("idle", "idle", shoving);
  for (const char* other : {"sliders", "pivots", "idle"})
    world->set_group_rule("pivots", other, rule(ContactPolicy::advance));
  world->set_threads(threads);
  world->set_slide_budget(budget);
  const std::array<std::string, 4> groups{"sliders", "pivots", "idle", "pivots"};
  std::vector<ObjectHandle> boxes;
  for (int i = 0; i < 252; ++i)
    boxes.push_back(world->add({box_tree("box " + std::to_string(i), {0.3, 0.4, 0.5}),
                                at(0.5 * (i % 6), 0.6 * (i / 6 % 6), 0.7 * (i / 36)),
                                false,
                                {groups[i % 4]}}));
  // Each kind goes on after its stop, in the end.
  MixedSlides out;
  for (int frame = 0; frame < 4; ++frame) {
    std::vector<MotionCommand> commands;
    for (std::size_t i = 0; i < boxes.size(); ++i)
      if (i % 4 != 2) commands.push_back(world->move_by(boxes[i], random.vector(0.25), random.vector(0.4)));
    const FrameReport report = world->frame(commands);
    EXPECT_GE(report.felt.size(), 16u);  // as many as make it worth while
    const std::size_t parts = world->executed_parts();
    for (std::size_t i = 0; i < boxes.size(); ++i) {
      const Pose first = world->executed_pose(boxes[i], 0, 1.0);
      const bool goes_on = parts > 1 && first.p != world->executed_pose(boxes[i], parts - 1, 1.0).p;
      (i % 2 == 1 ? out.pivoted : i % 4 == 2 ? out.shoved : out.slid) += goes_on;
      out.poses.push_back(world->actual_pose(boxes[i]));
    }
  }
  return out;
}

bool are_same(const std::vector<Pose>& a, const std::vector<Pose>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const Pose& x, const Pose& y) { return x.p == y.p && x.R == y.R; });
}

TEST(FrameThreads, PivotsAndShovesBesideSlidesAreThoseThatArePlannedInTurn) {
  SlideBudget ample;
  ample.pairs = std::uint64_t{1} << 40;
  const MixedSlides in_turn = slide_and_shove(1, ample);
  EXPECT_GT(in_turn.slid, 40);
  EXPECT_GT(in_turn.pivoted, 10);
  EXPECT_GT(in_turn.shoved, 20);
  for (const std::size_t threads : {1, 3})
    EXPECT_TRUE(are_same(slide_and_shove(threads, {}).poses, in_turn.poses)) << threads << " threads";
}

// A budget that nothing exceeds has them planned one after the other.
TEST(FrameThreads, SlidesPlannedAtOnceAreThoseThatArePlannedInTurn) {
  SlideBudget ample;
  ample.pairs = std::uint64_t{1} << 40;
  const std::vector<Vector3> in_turn = slide_through(1, ample);
  for (const std::size_t threads : {1, 2, 4}) EXPECT_TRUE(slide_through(threads, {}) == in_turn) << threads;
}

// Nor does a budget that each mover has for itself: it cuts off the same ones.
TEST(FrameThreads, ABudgetOfMoversCutsOffTheSameOnAnyThreads) {
  SlideBudget tight;
  tight.mover_work = 60;
  const std::vector<Vector3> one = slide_through(1, tight);
  EXPECT_FALSE(slide_through(1, {}) == one);
  for (const std::size_t threads : {2, 4}) EXPECT_TRUE(slide_through(threads, tight) == one) << threads;
  tight.pairs = std::uint64_t{1} << 40;
  EXPECT_TRUE(slide_through(1, tight) == one) << "planned in turn";
}

TEST(FrameThreads, RegistrationOrderDoesNotShow) {
  for (const std::uint64_t seed : {11, 12, 13}) {
    Flight one({.seed = seed, .objects = 90}), other({.seed = seed, .objects = 90, .shuffled = true});
    other.world->set_threads(2);
    one.changes = other.changes = false;
    for (int frame = 0; frame < 6; ++frame) {
      const FrameReport report = one.fly(), again = other.fly();
      for (std::size_t i = 0; i < one.objects.size(); ++i) {
        const Pose &X = one.world->actual_pose(one.objects[i]),
                   &Y = other.world->actual_pose(other.objects[i]);
        ASSERT_TRUE(X.p == Y.p && X.R == Y.R)
            << "seed " << seed << ", frame " << frame << ", " << one.world->name_of(one.objects[i]) << " by "
            << (X.p - Y.p).norm() << " m";
      }
      ASSERT_EQ(named_events(*one.world, report), named_events(*other.world, again))
          << "seed " << seed << ", frame " << frame;
    }
  }
}

TEST(FrameThreads, SelectionFromAnotherThreadWhileFramesRun) {
  for (const std::size_t threads : {1, 2}) {
    Flight flight({.seed = 9, .objects = 100});
    flight.world->set_threads(threads);
    std::jthread other([&](const std::stop_token& stop) {
      for (bool on = false; !stop.stop_requested(); on = !on) {
        flight.world->select(SelectionChange::of_everything(on));
        std::this_thread::yield();
      }
    });
    std::size_t selections = 0;
    flight.changes = false;
    for (int frame = 0; frame < 20; ++frame) selections += flight.fly().selections.size();
    EXPECT_GT(selections, 0u);
  }
}

TEST(ThreadTeam, RunsEachTaskOnceHoweverManyThereAre) {
  for (const std::size_t threads : {0, 1, 2, 5}) {
    ThreadTeam team(threads);
    for (const std::size_t count : {0, 1, 3, 1000}) {
      std::vector<std::atomic<int>> calls(count);
      auto body = [&](std::size_t i) { ++calls[i]; };
      run_tasks(&team, count, body);
      for (const std::atomic<int>& each : calls) ASSERT_EQ(each, 1);
    }
  }
}

}  // namespace
}  // namespace touchstone
