// Time of dynamics, in Markdown tables.
// dynamics_benchmark sets [per friction] [seed] [last seed] | stacks|toppling [steps] [height] | arm|rolling
// [steps]
//
// sets: the random contact problems of tests/physics, processor time and residual of each solve, and which
// stage of ContactSolver solved how many.
// stacks: a hundred stacks of ten boxes, or of another height, step by step in turn with Bullet's own
// dynamics in double precision (its default solver, no box ever put to sleep). Each finds its own contacts in
// every step. toppling: the same, every second box pushed off its place by 3 cm and each stack moving at up
// to 0.5 m/s: stacks lean, slide and fall. arm: one step of the SSRMS-type arm, brakes of 2332 N m, eight
// pads around its tip against those of a free 100 t payload at 0.014 m/s. rolling: the same on the payload's
// face, anew every 500 steps: the rim rolls and slips on it, so points arrive and joints stop in most steps.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <memory>
#include <random>
#include <string>
#include <string_view>
#include <vector>

#ifdef TOUCHSTONE_BENCHMARK_BULLET_DYNAMICS
#include <btBulletDynamicsCommon.h>
#endif

#include "touchstone/contact_core/registry.hpp"
#include "touchstone/contact_core/threads/processor_time.hpp"
#include "touchstone/physics/contacts/narrowphase_contacts.hpp"
#include "touchstone/tests/physics/arm_with_payload.hpp"
#include "touchstone/tests/physics/random_contact_sets.hpp"

using namespace touchstone;
using namespace touchstone::physics;

namespace {

double timed(const std::function<void()>& work) {
  const double start = processor_us();
  work();
  return processor_us() - start;
}

void print_head(const char* what) {
  std::printf(
      "\n| %s | least | median | 90 %% | 99 %% | 99.9 %% | most | mean "
      "|\n|---|---|---|---|---|---|---|---|\n",
      what);
}

void print_quantiles(const std::string& what, std::vector<double> values, const char* format) {
  std::printf("| %s |", what.c_str());
  if (values.empty()) {
    std::printf(" | | | | | | |\n");
    return;
  }
  double sum = 0.0;
  for (const double value : values) sum += value;
  std::sort(values.begin(), values.end());
  const auto print = [&](double value) {
    std::printf(" ");
    std::printf(format, value);
    std::printf(" |");
  };
  for (const double share : {0.0, 0.5, 0.9, 0.99, 0.999, 1.0})
    print(values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))]);
  print(sum / static_cast<double>(values.size()));
  std::printf("\n");
}

/// Stages of ContactSolver, by the round that ends a solve.
constexpr std::array<const char*, 5> kStages = {"sweeps, Newton with line search", "more sweeps, Newton",
                                                "the path from no impulses", "paths from drawn impulses",
                                                "Newton from drawn impulses"};
std::size_t stage_of(int rounds) {
  if (rounds <= 3) return static_cast<std::size_t>(std::max(rounds, 1) - 1);
  return (rounds - 1) % 4 == 2 ? 3 : 4;
}

/// Of one friction, or of one stage.
struct SetFigures {
  std::vector<double> times, systems, residuals;
  int failed = 0, rounding = 0, slow = 0;

  void add(double time, const SolveReport& report, double residual) {
    times.push_back(time), systems.push_back(report.newton_steps), residuals.push_back(residual);
    failed += residual <= 1e-9 ? 0 : 1;
    rounding += residual > 1e-9 && residual < 1e-8 ? 1 : 0;
    slow += time > 2000.0 ? 1 : 0;
  }
};

void run_sets(int count, unsigned first_seed, unsigned last_seed) {
  // Every set starts from no impulses.
  ContactSolver solver;
  solver.reserve(RandomSet::kRows);
  constexpr std::array<double, 3> kFrictions = {0.3, 0.5, 0.9};
  std::array<SetFigures, kFrictions.size()> by_friction;
  std::array<SetFigures, kStages.size()> by_stage;
  std::vector<double> u(RandomSet::kRows), x(RandomSet::kRows);
  for (unsigned seed = first_seed; seed <= last_seed; ++seed)
    for (std::size_t f = 0; f < kFrictions.size(); ++f) {
      std::mt19937_64 random(seed);
      for (int i = 0; i < count; ++i) {
        const RandomSet set(random, kFrictions[f], i % 2 == 1);
        const ContactProblem problem = set.problem();
        std::fill(x.begin(), x.end(), 0.0);
        SolveReport report;
        const double time = timed([&] { report = solver.solve(problem, x); });
        const double residual = natural_residual(problem, x, u);
        by_friction[f].add(time, report, residual);
        by_stage[stage_of(report.rounds)].add(time, report, residual);
      }
    }
  // One row a figure and friction, then what is left unsolved, then the stages.
  print_head("friction");
  for (std::size_t f = 0; f < kFrictions.size(); ++f) {
    char name[64];
    std::snprintf(name, sizeof(name), "%.1f, ", kFrictions[f]);
    print_quantiles(std::string(name) + "processor time [us]", by_friction[f].times, "%.1f");
    print_quantiles(std::string(name) + "linear systems", by_friction[f].systems, "%.0f");
    print_quantiles(std::string(name) + "residual [m/s]", by_friction[f].residuals, "%.1e");
  }
  std::printf(
      "\n| friction | sets | above 1e-9 m/s | of them below 1e-8 | above 2 ms |\n|---|---|---|---|---|\n");
  for (std::size_t f = 0; f < kFrictions.size(); ++f)
    std::printf("| %.1f | %zu | %d | %d | %d |\n", kFrictions[f], by_friction[f].times.size(),
                by_friction[f].failed, by_friction[f].rounding, by_friction[f].slow);
  print_head("processor time [us], by the stage that ended the solve");
  for (std::size_t s = 0; s < kStages.size(); ++s)
    print_quantiles(kStages[s] + (": " + std::to_string(by_stage[s].times.size())), by_stage[s].times,
                    "%.1f");
}

constexpr int kStacks = 100;
constexpr double kSide = 0.2, kMass = 1.0, kStep = 1e-3, kGravity = 9.81;

Vector3 place_of(int stack, int level) {
  const int row = stack / 10;
  return {1.0 * (stack % 10), 1.0 * row, kSide * (0.5 + level)};
}

/// Boxes a stack.
int& height() {
  static int boxes = 10;
  return boxes;
}

/// How stacks start: at rest, or toppling. Of its own generator, the same for both engines.
struct Start {
  Vector3 p_W, v_W;
};
Start start_of(int box, bool topples) {
  const int stack = box / height(), level = box % height();
  Start start{place_of(stack, level), Vector3::Zero()};
  if (!topples) return start;
  start.p_W.x() += level % 2 == 1 ? 0.03 : 0.0;
  start.v_W = {0.05 * (stack % 10), 0.05 * (stack / 10 % 10), 0.0};
  return start;
}

struct OurStacks {
  RigidBody box{box_inertia(kMass, {kSide, kSide, kSide}), "box"};
  HexahedronTree box_tree{{{"box", Hexahedron::from_size({kSide, kSide, kSide}), {}}}, "box"};
  HexahedronTree ground_tree{{{"slab", Hexahedron::from_size({20, 20, 1}), {}}}, "ground"};
  BackendRegistry registry;
  std::unique_ptr<NarrowphaseContacts> contacts;
  std::unique_ptr<DynamicsWorld> world;
  std::vector<double> finding, stepping;
  StepReport last;
  std::size_t points = 0;
  double worst_residual = 0.0;
  std::uint32_t unconverged = 0;

  explicit OurStacks(bool topples) {
    register_core(registry);
    contacts = std::make_unique<NarrowphaseContacts>(registry.make_broadphase("native"),
                                                     registry.make_narrowphase("native"), 1e-3);
    DynamicsWorld::Settings settings;
    settings.gravity_W = {0, 0, -kGravity};
    world = std::make_unique<DynamicsWorld>(settings);
    Pose ground;
    ground.p = {5, 5, -0.5};
    contacts->add(Mover::of_body(world->add_kinematic(ground, Vector3::Zero(), Vector3::Zero())), ground_tree,
                  {0.5, 0.0});
    for (int i = 0; i < kStacks * height(); ++i) {
      Pose X_WB;
      const Start start = start_of(i, topples);
      X_WB.p = start.p_W;
      const auto body = world->add_body(box, box.state(X_WB, start.v_W, Vector3::Zero()));
      contacts->add(Mover::of_body(body), box_tree, {0.5, 0.0});
    }
    contacts->build();
    world->reserve(4 * kStacks * height());
  }
  void step() {
    std::span<const Contact> found;
    finding.push_back(timed([&] { found = contacts->find(*world); }));
    points = found.size();
    stepping.push_back(timed([&] { last = world->step(kStep, found); }));
    worst_residual = std::max(worst_residual, last.worst_residual);
    unconverged += last.unconverged;
  }
  double worst_sinking() const {
    double worst = 0.0;
    for (int i = 0; i < kStacks * height(); ++i)
      worst = std::max(worst, norm(world->pose(static_cast<std::uint32_t>(i) + 1).p -
                                   place_of(i / height(), i % height())));
    return worst;
  }
};

#ifdef TOUCHSTONE_BENCHMARK_BULLET_DYNAMICS
struct BulletStacks {
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher{&configuration};
  btDbvtBroadphase broadphase;
  btSequentialImpulseConstraintSolver solver;
  btDiscreteDynamicsWorld world{&dispatcher, &broadphase, &solver, &configuration};
  btBoxShape ground_shape{btVector3(10, 10, 0.5)}, box_shape{btVector3(kSide / 2, kSide / 2, kSide / 2)};
  std::vector<std::unique_ptr<btRigidBody>> bodies;
  std::vector<double> stepping;

  explicit BulletStacks(bool topples) {
    world.setGravity({0, 0, -kGravity});
    add(0.0, ground_shape, {5, 5, -0.5});
    for (int i = 0; i < kStacks * height(); ++i) {
      const Start start = start_of(i, topples);
      add(kMass, box_shape, {start.p_W.x(), start.p_W.y(), start.p_W.z()});
      bodies.back()->setLinearVelocity({start.v_W.x(), start.v_W.y(), start.v_W.z()});
    }
  }
  ~BulletStacks() {
    for (const auto& body : bodies) world.removeRigidBody(body.get());
  }
  BulletStacks(const BulletStacks&) = delete;
  BulletStacks& operator=(const BulletStacks&) = delete;

  void add(double mass, btCollisionShape& shape, const btVector3& p) {
    btVector3 inertia(0, 0, 0);
    if (mass > 0.0) shape.calculateLocalInertia(mass, inertia);
    btRigidBody::btRigidBodyConstructionInfo info(mass, nullptr, &shape, inertia);
    info.m_startWorldTransform.setIdentity();
    info.m_startWorldTransform.setOrigin(p);
    bodies.push_back(std::make_unique<btRigidBody>(info));
    bodies.back()->setActivationState(DISABLE_DEACTIVATION);
    world.addRigidBody(bodies.back().get());
  }
  void step() {
    stepping.push_back(timed([&] { world.stepSimulation(kStep, 1, kStep); }));
  }
  double worst_sinking() const {
    double worst = 0.0;
    for (int i = 0; i < kStacks * height(); ++i) {
      const btVector3 p = bodies[static_cast<std::size_t>(i) + 1]->getWorldTransform().getOrigin();
      worst = std::max(worst, norm(Vector3(p.x(), p.y(), p.z()) - place_of(i / height(), i % height())));
    }
    return worst;
  }
};
#endif

void run_stacks(int steps, bool topples) {
  // Both engines step in turn, so that a slower machine slows both.
  OurStacks ours(topples);
#ifdef TOUCHSTONE_BENCHMARK_BULLET_DYNAMICS
  BulletStacks bullet(topples);
#endif
  for (int i = 0; i < steps; ++i) {
    ours.step();
#ifdef TOUCHSTONE_BENCHMARK_BULLET_DYNAMICS
    bullet.step();
#endif
  }
  // The steps are over: what each of them took is printed as quantiles.
  std::printf("%d stacks of %d boxes, %d steps of %g s, %zu contact points:\n", kStacks, height(), steps,
              kStep, ours.points);
  print_head("processor time [ms]");
  const auto print = [](const char* what, std::vector<double> times) {
    for (double& time : times) time *= 1e-3;
    print_quantiles(what, std::move(times), "%.3f");
  };
  print("ours: contacts", ours.finding);
  print("ours: step", ours.stepping);
  std::vector<double> both;
  for (std::size_t i = 0; i < ours.finding.size(); ++i) both.push_back(ours.finding[i] + ours.stepping[i]);
  print("ours: both", both);
#ifdef TOUCHSTONE_BENCHMARK_BULLET_DYNAMICS
  print("Bullet: stepSimulation", bullet.stepping);
#endif
  // How far from right the results are.
  std::printf(
      "\nOurs: farthest box from its place %.1e m, worst residual %.1e m/s, %u islands unconverged; last "
      "step: "
      "%u solves, %u sweeps, %u Newton steps, %u pieces.\n",
      ours.worst_sinking(), ours.worst_residual, ours.unconverged, ours.last.solves, ours.last.sweeps,
      ours.last.newton_steps, ours.last.substeps);
#ifdef TOUCHSTONE_BENCHMARK_BULLET_DYNAMICS
  std::printf("Bullet: farthest box from its place %.1e m.\n", bullet.worst_sinking());
#endif
}

/// Times of a run of the arm, step by step.
struct ArmRun {
  std::vector<double> times;
  std::vector<std::uint32_t> pieces;
  std::uint32_t unconverged = 0;
  double worst = 0.0;
};

ArmRun run_arm_once(int steps, bool rolling) {
  ArmWithPayload scene;
  ArmRun run;
  for (int i = 0; i < steps; ++i) {
    if (rolling && i % 500 == 0) scene.world.set_state(scene.body, scene.approaching());
    const std::array<Contact, 8> contacts = scene.rim_contacts(rolling);
    StepReport report;
    run.times.push_back(timed([&] { report = scene.world.step(kStep, contacts); }));
    run.pieces.push_back(report.substeps);
    run.unconverged += report.unconverged;
    run.worst = std::max(run.worst, report.worst_residual);
  }
  return run;
}

/// The run has the same bits each time: the least time of each step over several is without what the machine
/// does besides.
void run_arm(int steps, bool rolling) {
  constexpr int kReplays = 7;
  const ArmRun run = run_arm_once(steps, rolling);
  std::vector<double> least = run.times;
  for (int i = 1; i < kReplays; ++i) {
    const ArmRun again = run_arm_once(steps, rolling);
    for (std::size_t k = 0; k < least.size(); ++k) least[k] = std::min(least[k], again.times[k]);
  }
  const auto whole = [&](const std::vector<double>& times) {
    std::vector<double> kept;
    for (std::size_t k = 0; k < times.size(); ++k)
      if (run.pieces[k] == 1) kept.push_back(times[k]);
    return kept;
  };
  std::printf("%s, %d steps, %zu of them cut, %u solves unconverged, worst residual %.1e m/s:\n",
              rolling ? "The arm's rim rolls on the payload" : "The arm's pads against the payload's", steps,
              run.times.size() - whole(least).size(), run.unconverged, run.worst);
  print_head("processor time [us]");
  print_quantiles("step", run.times, "%.1f");
  print_quantiles("step, least of 7 replays", least, "%.1f");
  print_quantiles("step in one piece", whole(run.times), "%.1f");
  print_quantiles("step in one piece, least of 7 replays", whole(least), "%.1f");
}

}  // namespace

int main(int argc, char** argv) {
  const std::string_view what = argc > 1 ? argv[1] : "";
  const int count = argc > 2 ? std::atoi(argv[2]) : what == "sets" ? 3500 : 200;
  if (what == "sets" && count > 0) {
    const unsigned seed = argc > 3 ? static_cast<unsigned>(std::atoi(argv[3])) : 61;
    run_sets(count, seed, argc > 4 ? static_cast<unsigned>(std::atoi(argv[4])) : seed);
  } else if ((what == "stacks" || what == "toppling") && count > 0) {
    if (argc > 3) height() = std::max(1, std::atoi(argv[3]));
    run_stacks(count, what == "toppling");
  } else if ((what == "arm" || what == "rolling") && count > 0) {
    run_arm(argc > 2 ? count : 5000, what == "rolling");
  } else {
    std::fprintf(stderr,
                 "usage: dynamics_benchmark sets [per friction] [seed] [last seed] | stacks|toppling [steps] "
                 "[height] | arm|rolling [steps]\n");
    return 1;
  }
  return 0;
}
