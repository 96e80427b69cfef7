// Our check under btCollisionDispatcherMt: needs a Bullet with threads (BT_THREADSAFE=1), which Debian does
// not have. tests/bullet_plugin/run_threaded builds both from Bullet's sources.
//
//     threaded_dispatcher [bodies, default 400] [steps, default 120]
//
// A crowd of boxes and hulls with and without margins that turn and drift, and a new world for each number of
// threads: the manifolds of each step must be those of one thread under the plain dispatcher, to the bit.
// Then a pile falls in a threaded world of dynamics, by our check and by Bullet's: nothing may sink in.

#include <BulletCollision/CollisionDispatch/btCollisionDispatcherMt.h>
#include <BulletDynamics/Dynamics/btDiscreteDynamicsWorldMt.h>
#include <LinearMath/btThreads.h>
#include <btBulletDynamicsCommon.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <map>
#include <memory>
#include <optional>
#include <random>
#include <utility>
#include <vector>

#include "touchstone/adapters/bullet_plugin/bullet_plugin.hpp"

namespace {

using Clock = std::chrono::steady_clock;
using Random = std::mt19937_64;

double milliseconds_since(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

double uniform(Random& random, double from, double to) {
  return from + (to - from) * (static_cast<double>(random() >> 11) * 0x1p-53);
}

btVector3 random_vector(Random& random, double most) {
  const double x = uniform(random, -most, most), y = uniform(random, -most, most);
  return {x, y, uniform(random, -most, most)};
}

/// A third each of boxes, frusta without a margin and frusta with Bullet's.
std::unique_ptr<btCollisionShape> make_shape(Random& random, int index) {
  const double x = uniform(random, 0.3, 0.6), y = uniform(random, 0.3, 0.6), z = uniform(random, 0.3, 0.6);
  if (index % 3 == 0) return std::make_unique<btBoxShape>(btVector3(x, y, z));
  const double top = uniform(random, 0.5, 1.0);
  auto hull = std::make_unique<btConvexHullShape>();
  for (int corner = 0; corner < 8; ++corner) {
    const double side = (corner & 1) != 0 ? top : 1.0;
    hull->addPoint(btVector3((corner & 4) != 0 ? x : -x, (corner & 2) != 0 ? y : -y, 0) * side +
                       btVector3(0, 0, (corner & 1) != 0 ? z : -z),
                   false);
  }
  hull->setMargin(index % 3 == 1 ? 0.0 : 0.04);
  hull->recalcLocalAabb();
  return hull;
}

// ---- a crowd

struct Mover {
  std::unique_ptr<btCollisionShape> shape;
  std::unique_ptr<btCollisionObject> object;
  btVector3 place, drift, turn;
};

std::vector<Mover> make_crowd(int bodies) {
  Random random(20261127);
  const double half = 0.8 * std::cbrt(static_cast<double>(bodies));
  std::vector<Mover> crowd;
  for (int i = 0; i < bodies; ++i) {
    Mover& mover = crowd.emplace_back();
    mover.shape = make_shape(random, i);
    mover.object = std::make_unique<btCollisionObject>();
    mover.object->setCollisionShape(mover.shape.get());
    mover.object->setUserIndex(i);
    mover.place = random_vector(random, half);
    mover.drift = random_vector(random, 0.02), mover.turn = random_vector(random, 0.05);
  }
  return crowd;
}

void place(Mover& mover, int step) {
  const btVector3 angles = mover.turn * step;
  btTransform X;
  X.setOrigin(mover.place + mover.drift * step);
  X.setRotation(btQuaternion(angles.x(), angles.y(), angles.z()));
  mover.object->setWorldTransform(X);
}

using Manifolds = std::map<std::pair<int, int>, std::vector<double>>;

/// All that a solver reads, by pair: which manifold stands first is the threads' affair.
Manifolds manifolds_of(btCollisionDispatcher& dispatcher) {
  Manifolds all;
  for (int i = 0; i < dispatcher.getNumManifolds(); ++i) {
    const btPersistentManifold& manifold = *dispatcher.getManifoldByIndexInternal(i);
    std::vector<double>& numbers =
        all[{manifold.getBody0()->getUserIndex(), manifold.getBody1()->getUserIndex()}];
    for (int k = 0; k < manifold.getNumContacts(); ++k) {
      const btManifoldPoint& point = manifold.getContactPoint(k);
      for (const btVector3& v : {point.m_localPointA, point.m_localPointB, point.m_positionWorldOnA,
                                 point.m_positionWorldOnB, point.m_normalWorldOnB})
        numbers.insert(numbers.end(), {v.x(), v.y(), v.z()});
      numbers.insert(numbers.end(), {point.m_distance1, static_cast<double>(point.m_lifeTime)});
    }
  }
  return all;
}

struct CrowdRun {
  std::vector<Manifolds> steps;
  std::size_t points = 0;
  double milliseconds = 0;
  touchstone::BulletPlugin::Statistics statistics;
};

CrowdRun run_crowd(int bodies, int steps, bool threaded) {
  // A world of the engine's with our check.
  btDefaultCollisionConfiguration configuration;
  std::unique_ptr<btCollisionDispatcher> dispatcher;
  if (threaded)
    dispatcher = std::make_unique<btCollisionDispatcherMt>(&configuration, 16);
  else
    dispatcher = std::make_unique<btCollisionDispatcher>(&configuration);
  const touchstone::BulletPlugin plugin(*dispatcher);
  btDbvtBroadphase broadphase;
  btCollisionWorld world(dispatcher.get(), &broadphase, &configuration);
  std::vector<Mover> crowd = make_crowd(bodies);
  for (Mover& mover : crowd) place(mover, 0), world.addCollisionObject(mover.object.get());
  // Each step's time and manifolds.
  CrowdRun run;
  for (int step = 0; step < steps; ++step) {
    for (Mover& mover : crowd) place(mover, step);
    world.updateAabbs();
    world.computeOverlappingPairs();
    const Clock::time_point start = Clock::now();
    dispatcher->dispatchAllCollisionPairs(broadphase.getOverlappingPairCache(), world.getDispatchInfo(),
                                          dispatcher.get());
    run.milliseconds += milliseconds_since(start) / steps;
    run.steps.push_back(manifolds_of(*dispatcher));
    for (const auto& [pair, numbers] : run.steps.back()) run.points += numbers.size() / 17;
  }
  run.statistics = plugin.statistics();
  for (Mover& mover : crowd) world.removeCollisionObject(mover.object.get());
  return run;
}

bool same_bits(const Manifolds& a, const Manifolds& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const auto& x, const auto& y) {
    return x.first == y.first && x.second.size() == y.second.size() &&
           (x.second.empty() ||
            std::memcmp(x.second.data(), y.second.data(), x.second.size() * sizeof(double)) == 0);
  });
}

void print_crowd(const char* name, const CrowdRun& run, int others) {
  std::printf("| %s | %.2f | %zu | %llu | %llu | %d |\n", name, run.milliseconds, run.points,
              static_cast<unsigned long long>(run.statistics.checks),
              static_cast<unsigned long long>(run.statistics.refused), others);
}

bool crowds_agree(int bodies, int steps) {
  std::printf(
      "| crowd | a step [ms] | points | checks | refused | steps with other manifolds "
      "|\n|---|---|---|---|---|---|\n");
  const CrowdRun plain = run_crowd(bodies, steps, false), threaded = run_crowd(bodies, steps, true);
  int others = 0;
  for (int step = 0; step < steps; ++step)
    others += same_bits(threaded.steps[step], plain.steps[step]) ? 0 : 1;
  print_crowd("plain dispatcher", plain, 0), print_crowd("threaded dispatcher", threaded, others);
  return others == 0 && plain.points > 0 && plain.statistics.refused == 0 &&
         threaded.statistics.checks == plain.statistics.checks;
}

// ---- a pile

struct PileRun {
  double milliseconds = 0;  ///< a step
  double deepest = 0;       ///< of all contacts of the last step [m]
  double lowest = 0;        ///< of the bodies' centres [m]; the floor's top is at 0
};

/// Bodies that fall on a floor between four walls.
PileRun run_pile(int bodies, int steps, bool ours) {
  // The engine's world for threads, with our check or its own.
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcherMt dispatcher(&configuration, 16);
  std::optional<touchstone::BulletPlugin> plugin;
  if (ours) plugin.emplace(dispatcher);
  btDbvtBroadphase broadphase;
  btConstraintSolverPoolMt solvers(btGetTaskScheduler()->getNumThreads());
  btDiscreteDynamicsWorldMt world(&dispatcher, &broadphase, &solvers, nullptr, &configuration);
  world.setGravity(btVector3(0, 0, -9.81));
  std::vector<std::unique_ptr<btCollisionShape>> shapes;
  std::vector<std::unique_ptr<btRigidBody>> all;
  // A floor, four walls, and bodies in layers.
  const auto add = [&](std::unique_ptr<btCollisionShape> shape, double mass, const btVector3& p) {
    btVector3 inertia(0, 0, 0);
    if (mass > 0) shape->calculateLocalInertia(mass, inertia);
    all.push_back(std::make_unique<btRigidBody>(mass, nullptr, shape.get(), inertia));
    all.back()->setWorldTransform(btTransform(btQuaternion::getIdentity(), p));
    world.addRigidBody(all.back().get());
    shapes.push_back(std::move(shape));
  };
  add(std::make_unique<btBoxShape>(btVector3(20, 20, 1)), 0, {0, 0, -1});
  for (const double side : {-1.0, 1.0}) {
    add(std::make_unique<btBoxShape>(btVector3(1, 20, 20)), 0, {6 * side, 0, 20});
    add(std::make_unique<btBoxShape>(btVector3(20, 1, 20)), 0, {0, 6 * side, 20});
  }
  const std::size_t fixed = all.size();
  Random random(7);
  for (int i = 0; i < bodies; ++i)
    add(make_shape(random, i), 1,
        btVector3(i % 6 - 2.5, i / 6 % 6 - 2.5, 0) * 1.5 + btVector3(0, 0, 1 + i / 36 * 1.5));
  // Time of the steps.
  PileRun run;
  for (int step = 0; step < steps; ++step) {
    const Clock::time_point start = Clock::now();
    world.stepSimulation(1.0 / 120, 0, 1.0 / 120);
    run.milliseconds += milliseconds_since(start) / steps;
  }
  // How deep bodies are in each other, and whether one fell through the floor.
  for (int i = 0; i < dispatcher.getNumManifolds(); ++i)
    for (int k = 0; k < dispatcher.getManifoldByIndexInternal(i)->getNumContacts(); ++k)
      run.deepest =
          std::max(run.deepest, -dispatcher.getManifoldByIndexInternal(i)->getContactPoint(k).getDistance());
  run.lowest = 1e9;
  for (std::size_t i = fixed; i < all.size(); ++i)
    run.lowest = std::min(run.lowest, all[i]->getWorldTransform().getOrigin().z());
  for (const auto& body : all) world.removeRigidBody(body.get());
  return run;
}

bool piles_stand(int bodies, int steps) {
  std::printf(
      "\n| pile | a step [ms] | deepest contact at the end [m] | lowest centre [m] |\n|---|---|---|---|\n");
  bool stand = true;
  for (const bool ours : {true, false}) {
    const PileRun run = run_pile(bodies, steps, ours);
    std::printf("| %s | %.2f | %.2g | %.2f |\n", ours ? "ours" : "Bullet's own", run.milliseconds,
                run.deepest, run.lowest);
    stand = stand && (!ours || run.lowest > 0.2);
  }
  return stand;
}

}  // namespace

int main(int argc, char** argv) {
  const auto figure = [&](int i, int otherwise) { return argc > i ? std::atoi(argv[i]) : otherwise; };
  const int bodies = figure(1, 400), steps = figure(2, 120), threads = figure(3, 2);
  if (bodies <= 0 || steps <= 0 || threads <= 0) {
    std::fprintf(stderr, "threaded_dispatcher: bodies, steps and threads must be > 0\n");
    return 2;
  }
  btITaskScheduler* const openmp = btGetOpenMPTaskScheduler();  // null: this Bullet is built without
  btSetTaskScheduler(openmp != nullptr ? openmp : btCreateDefaultTaskScheduler());
  btGetTaskScheduler()->setNumThreads(threads);
  std::printf("\nBullet %d, %d threads of %s, %d bodies, %d steps\n\n", btGetVersion(),
              btGetTaskScheduler()->getNumThreads(), btGetTaskScheduler()->getName(), bodies, steps);
  const bool agree = crowds_agree(bodies, steps), stand = piles_stand(bodies, 4 * steps);
  std::printf("\n%s\n", agree && stand ? "passed" : "FAILED");
  return agree && stand ? 0 : 1;
}
