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

// Stacks of cubes stepped by Bullet in double precision, with its own check and with ours (the corners of a
// patch, or their middle first): the largest way
// that one of them came sideways in ten seconds. What should be: 0.
//   usage: bullet_creep_benchmark [STARTS [CUBES [SIZE_M ...]]]       default: 5 starts, 10 cubes, 0.1 to 2 m

namespace {

using namespace touchstone;

constexpr double kSeconds = 10.0;
constexpr double kDensity = 1000.0;  // [kg/m3]
constexpr double kFriction = 0.5;
constexpr unsigned kFirstSeed = 101;   // the order of points was chosen with others
constexpr double kStartsAside = 1e-4;  // of the size

/// A box; a hull clipped as a polyhedron, its margin within the size; a hull as btConvexHullShape makes it:
/// the points at the size, the margin around them, no polyhedral features (Bullet finds a point a step by GJK
/// and gathers them).
enum class Shape { box, hull, plain_hull };

struct Setting {
  double size;  // of a cube [m]
  Shape shape;
  double margin;  // of a hull [m]
  int cubes, iterations;
  double rate;  // steps a second

  /// Half the cube's height as it stands.
  double half() const { return size / 2 + (shape == Shape::plain_hull ? margin : 0.0); }
};

/// Whose check, and which points of ours.
enum class Check { own, corners, middle };

class Stack {
 public:
  Stack(const Setting& setting, Check check, unsigned seed) : setting_(setting) {
    if (check != Check::own)
      plugin_.emplace(dispatcher_,
                      BulletPlugin::Options{EngineCheck::native, nullptr, check == Check::middle});
    world_.getSolverInfo().m_numIterations = setting.iterations;
    world_.setGravity({0, 0, -9.81});
    add({20, 20, 0.5}, {0, 0, -0.5}, 0);
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> aside(-kStartsAside * setting.size, kStartsAside * setting.size);
    const double half = setting.size / 2;
    for (int i = 0; i < setting.cubes; ++i) {
      const double x = aside(random), y = aside(random);
      add({half, half, half}, {x, y, setting.half() * (2 * i + 1)}, kDensity * std::pow(setting.size, 3));
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
  std::unique_ptr<btCollisionShape> make_shape(const btVector3& half, bool is_ground) const {
    const bool is_plain = setting_.shape == Shape::plain_hull;
    if (setting_.shape == Shape::box || (is_plain && is_ground)) return std::make_unique<btBoxShape>(half);
    auto hull = std::make_unique<btConvexHullShape>();
    const double within = is_plain ? 0.0 : setting_.margin;
    for (int corner = 0; corner < 8; ++corner) {
      btVector3 p;
      for (int k = 0; k < 3; ++k) p[k] = ((corner >> k & 1) != 0 ? 1 : -1) * (half[k] - within);
      hull->addPoint(p, false);
    }
    hull->setMargin(setting_.margin);
    hull->recalcLocalAabb();
    if (!is_plain) hull->initializePolyhedralFeatures();
    return hull;
  }

  void add(const btVector3& half, const btVector3& place, double mass) {
    shapes_.push_back(make_shape(half, mass == 0));
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

/// Median and most [mm].
struct Creep {
  double median, most;

  Creep(const Setting& setting, Check check, int starts) {
    std::vector<double> all;
    for (int k = 0; k < starts; ++k) all.push_back(1e3 * Stack(setting, check, kFirstSeed + k).run());
    std::sort(all.begin(), all.end());
    median = all[all.size() / 2], most = all.back();
  }
};

/// The sums in the table's last line: settings in which the stack stands with either check.
struct Sum {
  int stand = 0, corners_more = 0, middle_more = 0;
};

void print_row(const Setting& setting, int starts, Sum& sum) {
  const Creep own(setting, Check::own, starts), corners(setting, Check::corners, starts),
      middle(setting, Check::middle, starts);
  const double half = 1e3 * setting.size / 2;
  char shape[40] = "box";
  if (setting.shape != Shape::box)
    std::snprintf(shape, sizeof shape, "%s, margin %.0f mm",
                  setting.shape == Shape::hull ? "hull" : "plain hull", 1e3 * setting.margin);
  const bool stands = own.median <= half || std::min(corners.median, middle.median) <= half;
  sum.stand += stands ? 1 : 0;
  sum.corners_more += stands && corners.median > own.median ? 1 : 0;
  sum.middle_more += stands && middle.median > own.median ? 1 : 0;
  std::printf("| %s | %g | %d | %g | %.3g | %.3g | %.3g | %.3g | %.3g | %.3g | %s |\n", shape, setting.size,
              setting.iterations, setting.rate, own.median, own.most, corners.median, corners.most,
              middle.median, middle.most,
              !stands                                                ? "all fell"
              : std::min(corners.median, middle.median) > own.median ? "more than its own"
              : middle.median > own.median                           ? "middle first: more"
              : corners.median > own.median                          ? "corners: more"
                                                                     : "");
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  // Starts, cubes a stack and sizes come from the command line.
  const int starts = argc > 1 ? std::atoi(argv[1]) : 5, cubes = argc > 2 ? std::atoi(argv[2]) : 10;
  if (starts < 1 || cubes < 1) {
    std::fprintf(stderr, "usage: bullet_creep_benchmark [STARTS [CUBES [SIZE_M ...]]]\n");
    return 2;
  }
  std::vector<double> sizes;
  for (int i = 3; i < argc; ++i) sizes.push_back(std::atof(argv[i]));
  if (sizes.empty()) sizes = {0.1, 0.2, 0.5, 1, 2};
  // The table begins: a column each for the largest way with each check.
  std::printf("Stacks of %d cubes, 10 s, largest way sideways [mm]: median and most of %d starts.\n\n", cubes,
              starts);
  std::puts(
      "| shape | size [m] | iterations | steps a second | own | most | corners | most | middle first | most "
      "| |");
  std::puts("|---|---|---|---|---|---|---|---|---|---|---|");
  // A row for each setting, but for hulls that are hardly larger than their margin.
  Sum sum;
  constexpr double kDefaultMargin = 0.04;  // Bullet's CONVEX_DISTANCE_MARGIN
  constexpr std::pair<Shape, double> kShapes[] = {{Shape::box, 0.0},
                                                  {Shape::hull, 0.0},
                                                  {Shape::hull, kDefaultMargin},
                                                  {Shape::plain_hull, kDefaultMargin}};
  for (const double size : sizes)
    for (const auto& [shape, margin] : kShapes)
      for (const int iterations : {4, 10, 50})
        for (const double rate : {60.0, 240.0, 1000.0})
          if (shape != Shape::hull || size > 2 * margin)
            print_row({size, shape, margin, cubes, iterations, rate}, starts, sum);
  std::printf(
      "\nOf %d settings in which a stack stands, corners creep more than its own in %d, middle first in "
      "%d.\n",
      sum.stand, sum.corners_more, sum.middle_more);
}
