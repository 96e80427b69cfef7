#include <BulletCollision/CollisionDispatch/btDefaultCollisionConfiguration.h>
#include <btBulletDynamicsCommon.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <optional>
#include <random>
#include <vector>

#include "touchstone/adapters/bullet_plugin/bullet_plugin.hpp"

// Stacks of cubes stepped by Bullet in double precision, with its own check and with ours: the largest way
// that one of them came sideways in ten seconds. What should be: 0.
//   usage: bullet_creep_benchmark [STARTS [CUBES [SIZE_M ...]]]       default: 5 starts, 10 cubes, 0.1 to 2 m

namespace {

using namespace touchstone;

constexpr double kSeconds = 10.0;
constexpr double kDensity = 1000.0;  // [kg/m3]
constexpr double kFriction = 0.5;
constexpr unsigned kFirstSeed = 101;   // the order of points was chosen with others
constexpr double kStartsAside = 1e-4;  // of the size

struct Setting {
  double size;    // of a cube, margin included [m]
  double margin;  // < 0: a box shape; else a hull's [m]
  int cubes, iterations;
  double rate;  // steps a second
};

class Stack {
 public:
  Stack(const Setting& setting, bool ours, unsigned seed) : setting_(setting) {
    if (ours) plugin_.emplace(dispatcher_);
    world_.getSolverInfo().m_numIterations = setting.iterations;
    world_.setGravity({0, 0, -9.81});
    add({20, 20, 0.5}, {0, 0, -0.5}, 0);
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> aside(-kStartsAside * setting.size, kStartsAside * setting.size);
    const double half = setting.size / 2;
    for (int i = 0; i < setting.cubes; ++i) {
      const double x = aside(random), y = aside(random);
      add({half, half, half}, {x, y, setting.size * (i + 0.5)}, kDensity * std::pow(setting.size, 3));
    }
  }
  ~Stack() {
    for (const auto& body : bodies_) world_.removeRigidBody(body.get());
  }
  Stack(const Stack&) = delete;
  Stack& operator=(const Stack&) = delete;

  /// The largest way sideways [m].
  double run() {
    const int steps = static_cast<int>(std::lround(kSeconds * setting_.rate));
    for (int i = 0; i < steps; ++i) world_.stepSimulation(1.0 / setting_.rate, 0, 1.0 / setting_.rate);
    double creep = 0;
    for (std::size_t i = 1; i < bodies_.size(); ++i) {
      const btVector3 way = bodies_[i]->getWorldTransform().getOrigin() - starts_[i];
      creep = std::max(creep, std::hypot(way.x(), way.y()));
    }
    return creep;
  }

 private:
  std::unique_ptr<btCollisionShape> make_shape(const btVector3& half) const {
    if (setting_.margin < 0) return std::make_unique<btBoxShape>(half);
    auto hull = std::make_unique<btConvexHullShape>();
    for (int corner = 0; corner < 8; ++corner) {
      btVector3 p;
      for (int k = 0; k < 3; ++k) p[k] = ((corner >> k & 1) != 0 ? 1 : -1) * (half[k] - setting_.margin);
      hull->addPoint(p, false);
    }
    hull->setMargin(setting_.margin);
    hull->recalcLocalAabb();
    hull->initializePolyhedralFeatures();
    return hull;
  }

  void add(const btVector3& half, const btVector3& place, double mass) {
    shapes_.push_back(make_shape(half));
    const double inertia = mass * 2.0 / 3.0 * half.x() * half.x();
    btRigidBody::btRigidBodyConstructionInfo info(mass, nullptr, shapes_.back().get(),
                                                  {inertia, inertia, inertia});
    info.m_startWorldTransform.setIdentity();
    info.m_startWorldTransform.setOrigin(place);
    info.m_friction = std::sqrt(kFriction);  // the engine multiplies the two
    bodies_.push_back(std::make_unique<btRigidBody>(info));
    bodies_.back()->setActivationState(DISABLE_DEACTIVATION);
    world_.addRigidBody(bodies_.back().get());
    starts_.push_back(place);
  }

  Setting setting_;
  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_{&configuration_};
  std::optional<BulletPlugin> plugin_;
  btDbvtBroadphase broadphase_;
  btSequentialImpulseConstraintSolver solver_;
  btDiscreteDynamicsWorld world_{&dispatcher_, &broadphase_, &solver_, &configuration_};
  std::vector<std::unique_ptr<btCollisionShape>> shapes_;
  std::vector<std::unique_ptr<btRigidBody>> bodies_;
  std::vector<btVector3> starts_;
};

/// Sorted [m].
std::vector<double> creeps(const Setting& setting, bool ours, int starts) {
  std::vector<double> out;
  for (int k = 0; k < starts; ++k) out.push_back(Stack(setting, ours, kFirstSeed + k).run());
  std::sort(out.begin(), out.end());
  return out;
}

void print_row(const Setting& setting, int starts) {
  const std::vector<double> own = creeps(setting, false, starts), ours = creeps(setting, true, starts);
  const double a = own[own.size() / 2], b = ours[ours.size() / 2];
  const bool fell = a > setting.size / 2 && b > setting.size / 2;
  char shape[32] = "box";
  if (setting.margin >= 0) std::snprintf(shape, sizeof shape, "hull, margin %.0f mm", 1e3 * setting.margin);
  std::printf("| %s | %g | %d | %g | %.3g | %.3g | %.3g | %.3g | %s |\n", shape, setting.size,
              setting.iterations, setting.rate, 1e3 * a, 1e3 * own.back(), 1e3 * b, 1e3 * ours.back(),
              fell     ? "both fell"
              : b <= a ? ""
                       : "more than its own");
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  const int starts = argc > 1 ? std::atoi(argv[1]) : 5, cubes = argc > 2 ? std::atoi(argv[2]) : 10;
  if (starts < 1 || cubes < 1) {
    std::fprintf(stderr, "usage: bullet_creep_benchmark [STARTS [CUBES [SIZE_M ...]]]\n");
    return 2;
  }
  std::vector<double> sizes;
  for (int i = 3; i < argc; ++i) sizes.push_back(std::atof(argv[i]));
  if (sizes.empty()) sizes = {0.1, 0.2, 0.5, 1, 2};
  std::printf("Stacks of %d cubes, 10 s, largest way sideways [mm]: median and most of %d starts.\n\n", cubes,
              starts);
  std::puts("| shape | size [m] | iterations | steps a second | own | most | ours | most | |");
  std::puts("|---|---|---|---|---|---|---|---|---|");
  constexpr double kBox = -1.0, kDefaultMargin = 0.04;  // Bullet's CONVEX_DISTANCE_MARGIN
  for (const double size : sizes)
    for (const double margin : {kBox, 0.0, kDefaultMargin})
      for (const int iterations : {4, 10, 50})
        for (const double rate : {60.0, 240.0, 1000.0})
          if (size > 2 * margin) print_row({size, margin, cubes, iterations, rate}, starts);
}
