#include <time.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "touchstone/contact_core/mechanism/arms/ssrms.hpp"
#include "touchstone/contact_core/registry.hpp"
#include "touchstone/contact_core/threads/processor_time.hpp"
#include "touchstone/contact_core/threads/thread_team.hpp"
#include "touchstone/contact_core/world/contact_world.hpp"

// The cost of a contact world's changes at run time, each with the frame after it, where nothing else
// happens: boxes of 1 m on a jittered grid, 1.4 m apart. Median, 99.9th percentile and worst of this thread's
// time [us] over as many changes as take a second or two, 5 000 at most.
//
//   world_changes_benchmark [objects ...]        100, 1 000, 10 000 and 100 000 without arguments
//   world_changes_benchmark --grow [objects [adds]]  the same of so many objects that come one by one, and
//   then
//                                                go: 10 000, until there are five times as many; and the
//                                                slowest, by which it was
//   world_changes_benchmark --movers [threads]   10 000 objects, 1 000 of them commanded to go 5 cm a frame,
//   on
//                                                one thread and on two (or so many): median, 99.9th
//                                                percentile and worst, of processor time shared evenly and by
//                                                the wall's clock [us]; and the share that is not in lanes

namespace touchstone {
namespace {

double wall_us() {
  timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return 1e6 * static_cast<double>(t.tv_sec) + 1e-3 * static_cast<double>(t.tv_nsec);
}

class Sample {
 public:
  void add(double value) { values_.push_back(value), total_ += value; }
  bool is_enough() const { return values_.size() >= 5000 || (total_ > 1.5e6 && values_.size() >= 20); }
  void print(const std::string& name) {
    std::sort(values_.begin(), values_.end());
    std::printf("  %-34s %10.1f %10.1f %10.1f  (%zu)\n", name.c_str(), at(0.5), at(0.999), values_.back(),
                values_.size());
    std::fflush(stdout);
  }

 private:
  double at(double share) const {
    return values_[static_cast<std::size_t>(share * static_cast<double>(values_.size() - 1))];
  }
  std::vector<double> values_;
  double total_ = 0.0;
};

std::unique_ptr<ContactWorld> make_world() {
  BackendRegistry registry;
  register_core(registry);
  return std::make_unique<ContactWorld>(registry.make_narrowphase("native"),
                                        registry.make_broadphase("native"), 1e-9);
}

PairRule world_rule() {
  PairRule rule;
  rule.policy = ContactPolicy::advance, rule.warn_distance = 0.05;
  return rule;
}

/// Above all boxes.
Pose far_above() {
  Pose X;
  X.p.z() = 200.0;
  return X;
}

struct Scene {
  std::unique_ptr<ContactWorld> world = make_world();
  std::vector<ObjectHandle> objects;
  std::mt19937 engine{20};
  int named = 0;

  double uniform(double low, double high) { return std::uniform_real_distribution<>(low, high)(engine); }
  std::size_t any() { return std::uniform_int_distribution<std::size_t>(0, objects.size() - 1)(engine); }

  ObjectDescription description(int place, int side, double spacing) {
    ObjectDescription out;
    out.tree = std::make_shared<HexahedronTree>(
        std::vector<PlacedHexahedron>{{"box", Hexahedron::from_size({1, 1, 1}), Pose{}}},
        "object " + std::to_string(named++));
    out.X_WO.p = {spacing * (place % side) + uniform(-0.15, 0.15),
                  spacing * (place / side % side) + uniform(-0.15, 0.15),
                  spacing * (place / side / side) + uniform(-0.15, 0.15)};
    if (place % 10 == 9) out.is_static = true;
    if (place < 20) out.groups = {place % 2 == 0 ? "tools" : "targets"};
    return out;
  }

  explicit Scene(int count) {
    world->set_default_rule(world_rule());
    const int side = static_cast<int>(std::ceil(std::cbrt(count)));
    for (int i = 0; i < count; ++i) objects.push_back(world->add(description(i, side, 1.4)));
    world->prepare();
  }
};

void measure(const std::string& name, const std::function<void(int)>& change, ContactWorld& world) {
  Sample sample;
  for (int i = 0; !sample.is_enough(); ++i) {
    const double start = processor_us();
    change(i);
    world.frame({});
    sample.add(processor_us() - start);
  }
  sample.print(name);
}

void measure_rules(Scene& scene) {
  ContactWorld& world = *scene.world;
  for (int i = 0; i < 10; ++i) world.frame({});  // the first ones set up; no change is left out
  measure(
      "none", [](int) {}, world);
  // Rules of pairs.
  PairRule slide, advance;
  slide.policy = ContactPolicy::slide, advance.policy = ContactPolicy::advance;
  const auto other = [&](std::size_t i) { return (i + 1) % scene.objects.size(); };
  measure(
      "policy of a pair",
      [&](int i) {
        const std::size_t a = scene.any();
        world.set_pair_rule(scene.objects[a], scene.objects[other(a)], i % 2 != 0 ? slide : advance);
      },
      world);
  PairRule warn = slide;
  measure(
      "warn distance of a pair",
      [&](int i) {
        const std::size_t a = scene.any();
        warn.warn_distance = 0.01 * (i % 5);
        world.set_pair_rule(scene.objects[a], scene.objects[other(a)], warn);
      },
      world);
  // Rules of groups.
  measure(
      "rule of two groups",
      [&](int i) { world.set_group_rule("tools", "targets", i % 2 != 0 ? slide : advance); }, world);
}

void measure_objects(Scene& scene) {
  ContactWorld& world = *scene.world;
  const int count = static_cast<int>(scene.objects.size());
  // Exemptions, selection and latches are switched on and off in turn.
  measure(
      "exempt, unexempt",
      [&](int i) {
        const Exemption pair{scene.objects[i / 2 % 50], scene.objects[i / 2 % 50 + 1]};
        i % 2 == 0 ? world.exempt(pair) : world.unexempt(pair);
      },
      world);
  measure(
      "select (object, off and on)",
      [&](int i) { world.select(SelectionChange::of(scene.objects[i / 2 % 90], i % 2 != 0)); }, world);
  measure(
      "latch, unlatch",
      [&](int i) {
        const std::size_t carried = i / 2 % 8;
        i % 2 == 0 ? world.latch(scene.objects[carried + 1], scene.objects[carried])
                   : world.unlatch(scene.objects[carried]);
      },
      world);
  // None stays latched.
  for (std::size_t carried = 0; carried < 8; ++carried) {
    try {
      world.unlatch(scene.objects[carried]);
    } catch (const std::exception&) {  // an even number of changes left none
    }
  }
  // Objects come and go.
  const int side = static_cast<int>(std::ceil(std::cbrt(count)));
  measure(
      "remove, add in its place",
      [&](int i) {
        const int place = static_cast<int>((i / 2 * 7919LL) % count);
        if (i % 2 == 0)
          world.remove(scene.objects[place]);
        else
          scene.objects[place] = world.add(scene.description(place, side, 1.4));
      },
      world);
  int added = count;
  measure(
      "add", [&](int) { scene.objects.push_back(world.add(scene.description(added++, side, 1.4))); }, world);
}

/// Changes of one arm, above all others, and changes of every object.
void measure_arms(Scene& scene) {
  ContactWorld& world = *scene.world;
  const auto mechanism = std::make_shared<const Mechanism>(make_ssrms());
  MechanismHandle arm;
  measure(
      "add, remove an arm of 47",
      [&](int i) {
        if (i % 2 == 0)
          arm = world.add_mechanism({mechanism, far_above()});
        else
          world.remove_mechanism(arm);
      },
      world);
  PairRule rule = world_rule();
  measure(
      "larger warn distance of all",
      [&](int i) {
        rule.warn_distance = 0.05 + 1e-5 * (i + 1);
        world.set_default_rule(rule);
      },
      world);
  measure(
      "reset", [&](int) { world.reset(); }, world);
}

void measure_changes(int count) {
  const double start = processor_us();
  Scene scene(count);
  std::printf("%d objects: added and prepared in %.1f ms\n", count, 1e-3 * (processor_us() - start));
  std::printf("  %-34s %10s %10s %10s\n", "change and next frame [us]", "median", "99.9 %", "worst");
  measure_rules(scene);
  measure_arms(scene);
  measure_objects(scene);
}

/// Time of each change of a series, by its number: the least of several runs of the same world.
class Series {
 public:
  Series(std::string name, int count) : name_(std::move(name)), least_(count, 1e9) {}

  void measure(ContactWorld& world, const std::function<void(int)>& change) {
    for (std::size_t i = 0; i < least_.size(); ++i) {
      const double start = processor_us();
      change(static_cast<int>(i));
      world.frame({});
      least_[i] = std::min(least_[i], processor_us() - start);
    }
  }
  void print() const {
    std::vector<std::pair<double, std::size_t>> times;
    for (std::size_t i = 0; i < least_.size(); ++i) times.emplace_back(least_[i], i);
    std::sort(times.begin(), times.end());
    const auto at = [&](double share) {
      return times[static_cast<std::size_t>(share * static_cast<double>(times.size() - 1))].first;
    };
    const auto slow =
        std::count_if(times.begin(), times.end(), [](const auto& time) { return time.first > 50.0; });
    std::printf("  %-20s %8.1f %8.1f %8.1f   %td of %zu above 50; slowest:", name_.c_str(), at(0.5),
                at(0.999), at(1.0), slow, times.size());
    for (std::size_t i = 1; i <= std::min<std::size_t>(5, times.size()); ++i)
      std::printf(" %.0f (%zu)", times[times.size() - i].first, times[times.size() - i].second);
    std::printf("\n");
  }

 private:
  std::string name_;
  std::vector<double> least_;
};

void measure_growth(int objects, int adds) {
  constexpr int kRuns = 3;
  Series add("add", adds), remove("remove", adds), again("add in their places", adds);
  for (int run = 0; run < kRuns; ++run) {
    Scene scene(objects);
    ContactWorld& world = *scene.world;
    scene.objects.reserve(static_cast<std::size_t>(objects + adds));  // this program's own list
    for (int i = 0; i < 10; ++i) world.frame({});
    const int side = static_cast<int>(std::ceil(std::cbrt(objects)));
    const auto description = [&](int i) { return scene.description(objects + i, side, 1.4); };
    add.measure(world, [&](int i) { scene.objects.push_back(world.add(description(i))); });
    remove.measure(world, [&](int i) {
      world.remove(scene.objects[static_cast<std::size_t>(objects + (i * 7919LL) % adds)]);
    });
    again.measure(world, [&](int i) {
      scene.objects[static_cast<std::size_t>(objects + i)] = world.add(description(i));
    });
  }
  std::printf("%d objects: a change and the next frame, each one's least of %d runs [us]\n", objects, kRuns);
  std::printf("  %-20s %8s %8s %8s\n", "", "median", "99.9 %", "worst");
  for (const Series* series : {&add, &remove, &again}) series->print();
}

/// A team that counts what its tasks take in all, on whichever thread: shared evenly between processors that
/// do nothing else, that is the time they take.
class TimedTeam final : public TaskRunner {
 public:
  explicit TimedTeam(std::size_t threads) : team_(threads) {}
  std::size_t threads() const noexcept override { return team_.threads(); }

  void run(std::size_t count, Task task) noexcept override {
    const double start = processor_us();
    Round round{task, 0.0};
    team_.run(count, {[](void* context, std::size_t i) noexcept {
                        Round& r = *static_cast<Round*>(context);
                        const double begin = processor_us();
                        r.task(i);
                        r.took.fetch_add(processor_us() - begin);
                      },
                      &round});
    in_rounds_ += processor_us() - start;
    shares_ += round.took / static_cast<double>(threads());
  }

  /// Since the last call [us].
  struct Rounds {
    double callers = 0.0;  ///< the caller's own time in them
    double shares = 0.0;   ///< of all threads, shared evenly
  };
  Rounds take() {
    const Rounds out{in_rounds_, shares_};
    shares_ = in_rounds_ = 0.0;
    return out;
  }

 private:
  struct Round {
    Task task;
    std::atomic<double> took;
  };
  ThreadTeam team_;
  double in_rounds_ = 0.0, shares_ = 0.0;
};

struct MoversResult {
  Sample processor, wall;
  double blocked = 0, queries = 0, steps = 0, candidates = 0;
  double serial = 0, shared = 0;  // processor time on the caller's thread alone, and in lanes [us]
  int frames = 0;
};

MoversResult fly_movers(ContactPolicy policy, std::size_t threads) {
  // The world, its rule and its threads.
  constexpr int kObjects = 10000, kMovers = 1000;
  Scene scene(kObjects);
  ContactWorld& world = *scene.world;
  TimedTeam team(threads);
  if (threads > 1) world.set_task_runner(&team);
  PairRule rule;
  rule.policy = policy;
  world.set_default_rule(rule);
  std::vector<Vector3> ways(kMovers);
  std::vector<MotionCommand> commands;
  MoversResult out;
  for (; out.frames < 60; ++out.frames) {
    // New directions every 20 frames.
    if (out.frames % 20 == 0)
      for (Vector3& way : ways) {
        way = {scene.uniform(-1, 1), scene.uniform(-1, 1), scene.uniform(-1, 1)};
        way *= 0.05 / way.norm();
      }
    commands.clear();
    for (int i = 0; i < kMovers; ++i)
      commands.push_back(world.move_by(scene.objects[10 * i], ways[i], {0, 0, 0.02}));
    // Time of the frame, with the shares of all threads in place of the caller's wait.
    team.take();
    const double start = processor_us(), wall_start = wall_us();
    const FrameReport report = world.frame(commands);
    const double own = processor_us() - start;
    const TimedTeam::Rounds rounds = team.take();
    const double took = own - rounds.callers + rounds.shares;
    if (out.frames > 0) {  // the first one sets up
      out.processor.add(took), out.wall.add(wall_us() - wall_start);
      out.serial += own - rounds.callers, out.shared += rounds.shares * static_cast<double>(threads);
    }
    out.blocked += report.blocked_movers, out.queries += static_cast<double>(report.queries);
    out.steps += report.slide_steps, out.candidates += report.candidate_pairs;
  }
  return out;
}

void measure_movers(std::size_t most_threads) {
  for (const ContactPolicy policy : {ContactPolicy::advance, ContactPolicy::slide}) {
    std::printf("10000 objects, 1000 movers at 5 cm a frame, policy %s:\n",
                policy == ContactPolicy::slide ? "slide" : "advance");
    for (const std::size_t threads : {std::size_t{1}, most_threads}) {
      MoversResult result = fly_movers(policy, threads);
      if (threads == 1)
        std::printf("  per frame %.0f blocked, %.0f pairs, %.0f queries, %.1f sub-steps\n",
                    result.blocked / result.frames, result.candidates / result.frames,
                    result.queries / result.frames, result.steps / result.frames);
      const std::string on = std::to_string(threads) + (threads == 1 ? " thread" : " threads");
      result.processor.print(on + ", shared evenly [us]");
      result.wall.print(on + ", wall clock [us]");
      if (threads > 1)
        std::printf("  of all work %.0f %% is on one thread alone\n",
                    100.0 * result.serial / (result.serial + result.shared));
    }
  }
}

}  // namespace
}  // namespace touchstone

int main(int argc, char** argv) {
  if (argc > 1 && std::string(argv[1]) == "--movers") {
    touchstone::measure_movers(argc > 2 ? std::strtoul(argv[2], nullptr, 10) : 2);
    return 0;
  }
  if (argc > 1 && std::string(argv[1]) == "--grow") {
    const int objects = argc > 2 ? std::atoi(argv[2]) : 10000;
    touchstone::measure_growth(objects, argc > 3 ? std::atoi(argv[3]) : 4 * objects);
    return 0;
  }
  std::vector<int> counts;
  for (int i = 1; i < argc; ++i) counts.push_back(std::atoi(argv[i]));
  if (counts.empty()) counts = {100, 1000, 10000, 100000};
  for (const int count : counts) touchstone::measure_changes(count);
  return 0;
}
