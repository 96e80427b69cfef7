// Random scenes of few bodies that are held between others, ours alone:
//
//     dynamics_squeezes_benchmark [SEED [COUNT [FAMILIES]]]
//
// COUNT scenes of each family whose name has FAMILIES in it. A table: scenes in which something was faster
// than 0.1 and than 0.5 m/s beyond its fall, against what is commanded; of those above 0.1 m/s the ones that
// gained 0.1 m/s beyond what the laws give (each step again from the same state, by Accuracy::exact: a
// frictionless cube that leans between jaws leaves as fast as the wedge that it makes closes, v / tan a; in
// a contradiction they give nothing), and the most of it; the fastest; the farthest that any was from its
// place at the end, and how many scenes moved something by more than 0.1 mm (of those that are to stand); the
// step that took most, of this thread's processor time, the least of two runs; steps whose work ended. On
// stderr each scene that was faster than 0.1 m/s, with when.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <list>
#include <memory>
#include <random>
#include <string_view>
#include <utility>
#include <vector>

#include "touchstone/contact_core/registry.hpp"
#include "touchstone/contact_core/threads/processor_time.hpp"
#include "touchstone/physics/contacts/narrowphase_contacts.hpp"

using namespace touchstone;
using namespace touchstone::physics;

namespace {

constexpr double kSide = 0.2, kGravity = 9.81;
constexpr int kRepeats = 2;

/// Evenly between two limits, the same from every standard library.
class Draw {
 public:
  explicit Draw(unsigned seed) : random_(seed) {}
  double operator()(double low, double high) {
    return low + (high - low) * static_cast<double>(random_()) / 4294967296.0;
  }

 private:
  std::mt19937 random_;
};

/// One scene as it runs.
struct Scene {
  BackendRegistry registry;
  std::list<HexahedronTree> trees;
  NarrowphaseContacts contacts;
  DynamicsWorld world;
  std::vector<std::uint32_t> bodies;
  std::vector<Vector3> places;
  double friction = 0.5, h = 1e-3, seconds = 1.0;
  double commanded = 0.0;  ///< the fastest that anything is driven [m/s]
  bool stands = false;     ///< what is in it is to stay where it is

  static BackendRegistry core() {
    BackendRegistry registry;
    register_core(registry);
    return registry;
  }
  static DynamicsWorld::Settings settings(DynamicsWorld::Accuracy accuracy) {
    DynamicsWorld::Settings out;
    out.gravity_W = {0, 0, -kGravity};
    out.accuracy = accuracy;
    return out;
  }
  Scene()
      : registry(core()),
        contacts(registry.make_broadphase("native"), registry.make_narrowphase("native"), 1e-3),
        world(settings(DynamicsWorld::Accuracy::bounded)) {}

  const HexahedronTree& tree(const Vector3& size) {
    return trees.emplace_back(std::vector<PlacedHexahedron>{{"box", Hexahedron::from_size(size), {}}}, "box");
  }
  static Pose at(const Vector3& p) {
    Pose pose;
    pose.p = p;
    return pose;
  }
  void add_driven(const Vector3& p, const Vector3& v, const Vector3& size = {kSide, kSide, kSide}) {
    contacts.add(Mover::of_body(world.add_kinematic(at(p), v, Vector3::Zero())), tree(size), {friction, 0.0});
    commanded = std::max(commanded, norm(v));
  }
  void add_ground() { add_driven({0, 0, -0.5}, Vector3::Zero(), {20, 20, 1}); }
  void add_box(const Vector3& p, double mass, const Vector3& size = {kSide, kSide, kSide}) {
    const RigidBody box(box_inertia(mass, size), "box");
    bodies.push_back(world.add_body(box, box.state(at(p), Vector3::Zero(), Vector3::Zero())));
    contacts.add(Mover::of_body(bodies.back()), tree(size), {friction, 0.0});
    places.push_back(p);
  }
};

double any_mass(Draw& draw, double most = 6.0) { return std::pow(10.0, draw(0.0, most)); }

/// A lintel on two posts, or a cube on two, spawned 0.1 mm apart, at 60 Hz.
void make_standing(Draw& draw, int run, Scene& scene) {
  scene.add_ground();
  scene.h = 1.0 / 60.0, scene.seconds = 2.0, scene.stands = true;
  const double gap = 1e-4, most = 3.0 + run % 4;
  const auto add = [&](double x, double z, const Vector3& size, double drop) {
    scene.add_box({x, 0, z + drop}, any_mass(draw, most), size);
    scene.places.back().z() = z;
  };
  const Vector3 cube(kSide, kSide, kSide);
  if (run % 2 == 0) {
    const Vector3 post(draw(0.2, 0.3), 0.2, draw(0.2, 0.6));
    const double span = draw(0.5, 0.9);
    for (const double side : {-0.5, 0.5}) add(side * span, 0.5 * post.z(), post, gap);
    add(draw(-0.03, 0.03), post.z() + 0.1, {span + 0.3, 0.2, 0.2}, 2.0 * gap);
  } else {
    for (const double side : {-0.11, 0.11}) add(side, 0.1, cube, gap);
    add(draw(-0.03, 0.03), 0.3, cube, 2.0 * gap);
  }
}

/// From above on two stacked cubes, by 19 mm.
void make_press(Draw& draw, int run, bool is_alike, double friction, Scene& scene) {
  scene.friction = friction;
  scene.add_ground();
  const double speed = draw(0.02, 0.1), gap = draw(1e-5, 1e-3);
  scene.h = run % 2 == 0 ? 1e-3 : 1.0 / 240.0;
  scene.seconds = (0.019 + gap) / speed;
  scene.add_driven({0, 0, 0.5 + gap}, {0, 0, -speed}, {0.4, 0.4, kSide});
  for (int i = 0; i < 2; ++i)
    scene.add_box({draw(-0.02, 0.02), draw(-0.02, 0.02), 0.1 + 0.2 * i}, is_alike ? 1.0 : any_mass(draw));
}

/// By 2 cm on two to four cubes in a row.
void make_row(Draw& draw, int run, Scene& scene) {
  const double speed = draw(0.02, 0.05), gap = draw(1e-5, 1e-3);
  scene.h = run % 2 == 0 ? 1e-3 : 1.0 / 240.0;
  scene.seconds = (0.02 + gap) / speed;
  const int count = 2 + run % 3;
  const double half = 0.1 * count;
  scene.add_driven({-half - 0.1 - gap, 0, 1}, {run % 2 == 0 ? 0.0 : speed, 0, 0});
  scene.add_driven({half + 0.1, 0, 1}, {-speed, 0, 0});
  for (int i = 0; i < count; ++i) scene.add_box({0.1 + 0.2 * i - half, draw(-0.02, 0.02), 1}, any_mass(draw));
}

/// Jaws or a vice on one cube, until they are a third of it into it.
void make_jaws(Draw& draw, int run, Scene& scene) {
  scene.friction = run % 3 == 0 ? 0.0 : draw(0.05, 1.0);
  const double speed = draw(0.02, 0.3), gap = draw(1e-5, 1e-3), aside = 0.05;
  scene.h = run % 2 == 0 ? 1e-3 : 1.0 / 240.0;
  scene.seconds = (0.3 * kSide + gap) / speed;
  const auto place = [&](double x) { return Vector3(x, draw(-aside, aside), 1 + draw(-aside, aside)); };
  scene.add_driven(place(-kSide - gap), {run % 4 < 2 ? 0.0 : speed, 0, 0});
  scene.add_driven(place(kSide + gap), {-speed, 0, 0});
  scene.add_box({0, 0, 1}, draw(0.5, 20.0));
}

/// Of a body, beyond what is commanded and its own fall until `time`, at least 0 [m/s].
double speed_of(const Scene& scene, const DynamicsWorld& world, std::uint32_t body, double time) {
  Vector3 v = world.velocity(body);
  if (v.z() < 0.0) v.z() = std::min(0.0, v.z() + kGravity * time);
  return std::max(0.0, norm(v) - scene.commanded);
}

/// Of the fastest body.
double fastest_of(const Scene& scene, const DynamicsWorld& world, double time) {
  double fastest = 0.0;
  for (const std::uint32_t body : scene.bodies)
    fastest = std::max(fastest, speed_of(scene, world, body, time));
  return fastest;
}

/// The same step by the laws alone; null where they have no answer.
std::unique_ptr<DynamicsWorld> step_by_laws(const Scene& scene, const DynamicsWorld& start,
                                            std::span<const Contact> contacts) {
  auto laws = std::make_unique<DynamicsWorld>(Scene::settings(DynamicsWorld::Accuracy::exact));
  for (std::uint32_t i = 0; i < start.body_count(); ++i) {
    if (std::find(scene.bodies.begin(), scene.bodies.end(), i) != scene.bodies.end())
      laws->add_body(start.body(i), start.state(i));
    else
      laws->add_kinematic(start.pose(i), start.velocity(i), Vector3::Zero());
  }
  const StepReport report = laws->step(scene.h, contacts);
  const bool is_solved = report.failure == StepFailure::none && report.unconverged == 0;
  return is_solved ? std::move(laws) : nullptr;
}

/// Of the body of which it is the most: the sum of what the scene's steps make it faster by than the laws do
/// [m/s].
double gain_beyond_laws(Scene& scene) {
  scene.contacts.build();
  std::vector<double> sums(scene.bodies.size(), 0.0), before = sums, after = sums;
  for (int i = 0; i < static_cast<int>(scene.seconds / scene.h); ++i) {
    const DynamicsWorld start = scene.world;
    const std::span<const Contact> contacts = scene.contacts.find(scene.world, scene.h);
    scene.world.step(scene.h, contacts);
    const double time = scene.h * (i + 1);
    bool is_faster = false;
    for (std::size_t k = 0; k < sums.size(); ++k) {
      after[k] = speed_of(scene, scene.world, scene.bodies[k], time);
      is_faster = is_faster || after[k] > before[k];
    }
    const auto laws = is_faster ? step_by_laws(scene, start, contacts) : nullptr;
    for (std::size_t k = 0; is_faster && k < sums.size(); ++k) {
      const double lawful = laws ? speed_of(scene, *laws, scene.bodies[k], time) : 0.0;
      sums[k] += std::max(0.0, after[k] - std::max(before[k], lawful));
    }
    before = after;
  }
  return *std::max_element(sums.begin(), sums.end());
}

/// Result of a scene's run.
struct Outcome {
  double fastest = 0.0, off = 0.0, most_us = 0.0;
  double friction = 0.0, h = 0.0, commanded = 0.0;
  int fastest_at = 0, spent = 0, failed = 0, steps = 0;
};

/// @param times in: the least so far, or empty; out
Outcome run(Scene& scene, std::vector<double>& times) {
  // Room for all contacts, so that no step allocates.
  Outcome out;
  scene.contacts.build();
  const std::size_t room = 32 * (scene.bodies.size() + 1);
  scene.contacts.reserve(room, room);
  scene.world.reserve(room);
  out.steps = static_cast<int>(scene.seconds / scene.h);
  out.friction = scene.friction, out.h = scene.h, out.commanded = scene.commanded;
  times.resize(static_cast<std::size_t>(out.steps), 1e9);
  // The least time of each step over repeats, and the fastest body beyond what is commanded.
  for (int i = 0; i < out.steps; ++i) {
    const double start = processor_us();
    const StepReport report = scene.world.step(scene.h, scene.contacts.find(scene.world, scene.h));
    double& time = times[static_cast<std::size_t>(i)];
    time = std::min(time, processor_us() - start);
    out.spent += report.is_work_spent ? 1 : 0;
    out.failed += report.failure != StepFailure::none ? 1 : 0;
    const double speed = fastest_of(scene, scene.world, scene.h * (i + 1));
    if (speed > out.fastest) out.fastest = speed, out.fastest_at = i;
  }
  // How far what was to stand has moved.
  for (std::size_t i = 0; scene.stands && i < scene.bodies.size(); ++i)
    out.off = std::max(out.off, norm(scene.world.pose(scene.bodies[i]).p - scene.places[i]));
  return out;
}

struct Family {
  const char* name;
  void (*make)(Draw& draw, int run, Scene& scene);
};

constexpr Family kFamilies[] = {
    {"lintels and pyramids of three, masses to 1e6 to 1", make_standing},
    {"press on two cubes, masses to 1e6 to 1",
     [](Draw& draw, int run, Scene& scene) { make_press(draw, run, false, 0.5, scene); }},
    {"press on two equal cubes",
     [](Draw& draw, int run, Scene& scene) { make_press(draw, run, true, draw(0.1, 1.0), scene); }},
    {"press on two equal cubes, no friction",
     [](Draw& draw, int run, Scene& scene) { make_press(draw, run, true, 0.0, scene); }},
    {"jaws on two to four cubes, masses to 1e6 to 1", make_row},
    {"jaws on one cube, a third of them without friction", make_jaws},
};

void measure(const Family& family, unsigned seed, int count) {
  // Each scene, repeated for its times.
  int above_tenth = 0, above_half = 0, beyond = 0, moved = 0, spent = 0, failed = 0, steps = 0;
  double most_beyond = 0.0;
  Outcome worst;
  for (int i = 0; i < count; ++i) {
    std::vector<double> times;
    Outcome out;
    for (int repeat = 0; repeat < kRepeats; ++repeat) {
      Draw draw(seed + static_cast<unsigned>(i));
      Scene scene;
      family.make(draw, i, scene);
      out = run(scene, times);
    }
    // Scenes in which something was shot out or moved.
    above_tenth += out.fastest > 0.1 ? 1 : 0;
    above_half += out.fastest > 0.5 ? 1 : 0;
    moved += out.off > 1e-4 ? 1 : 0;
    spent += out.spent, failed += out.failed, steps += out.steps;
    if (out.fastest > 0.1) {
      Draw draw(seed + static_cast<unsigned>(i));
      Scene scene;
      family.make(draw, i, scene);
      const double gain = gain_beyond_laws(scene);
      beyond += gain > 0.1 ? 1 : 0;
      most_beyond = std::max(most_beyond, gain);
      std::fprintf(stderr,
                   "%s, %u + %d: %.2f m/s in step %d of %d, %.2f beyond the laws; friction %.2f, %.1f ms, "
                   "at %.2f m/s\n",
                   family.name, seed, i, out.fastest, out.fastest_at, out.steps, gain, out.friction,
                   1e3 * out.h, out.commanded);
    }
    // The worst of all, and the row.
    worst.fastest = std::max(worst.fastest, out.fastest);
    worst.off = std::max(worst.off, out.off);
    for (const double time : times) worst.most_us = std::max(worst.most_us, time);
  }
  std::printf("| %s | %d | %d | %d | %d | %.2f | %.2f | %d | %.1e | %.0f | %d of %d%s |\n", family.name,
              count, above_tenth, above_half, beyond, most_beyond, worst.fastest, moved, worst.off,
              worst.most_us, spent, steps, failed > 0 ? ", steps FAILED" : "");
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  const unsigned seed = argc > 1 ? static_cast<unsigned>(std::atoi(argv[1])) : 17801;
  const int count = argc > 2 ? std::atoi(argv[2]) : 300;
  const std::string_view families = argc > 3 ? argv[3] : "";
  std::printf(
      "| scenes | of them | above 0.1 m/s | above 0.5 | 0.1 m/s beyond the laws | most beyond [m/s] | "
      "fastest [m/s] | moved 0.1 mm | farthest [m] | longest step [us] | steps whose work ended |\n"
      "|---|---|---|---|---|---|---|---|---|---|---|\n");
  for (const Family& family : kFamilies)
    if (std::string_view(family.name).find(families) != std::string_view::npos) measure(family, seed, count);
  return 0;
}
