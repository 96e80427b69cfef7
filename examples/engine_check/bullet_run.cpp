#include <BulletCollision/CollisionDispatch/btDefaultCollisionConfiguration.h>
#include <btBulletDynamicsCommon.h>

#include <chrono>
#include <cmath>
#include <memory>
#include <optional>
#include <vector>

#include "touchstone/adapters/bullet/engine.hpp"
#include "touchstone/adapters/bullet_plugin/bullet_plugin.hpp"
#include "touchstone/examples/engine_check/world.hpp"

namespace touchstone::engine_check {
namespace {

using namespace TOUCHSTONE_BULLET_NAMESPACE;
using Clock = std::chrono::steady_clock;
/// Times the collision detection inside a step.
class TimedWorld final : public btDiscreteDynamicsWorld {
 public:
  using btDiscreteDynamicsWorld::btDiscreteDynamicsWorld;
  void performDiscreteCollisionDetection() override {
    const auto start = Clock::now();
    btDiscreteDynamicsWorld::performDiscreteCollisionDetection();
    check_time = Clock::now() - start;
  }
  Clock::duration check_time{};
};

std::unique_ptr<btConvexInternalShape> make_shape(const World& world, const Body& body) {
  if (body.solid.is_box() && !world.by_hulls)
    return std::make_unique<btBoxShape>(to_engine(body.solid.half_extents()));
  auto hull = std::make_unique<btConvexHullShape>();
  for (const Vector3& v : body.solid.vertices()) hull->addPoint(to_engine(v), false);
  hull->setMargin(0);
  hull->recalcLocalAabb();
  hull->initializePolyhedralFeatures();
  return hull;
}

class BulletWorld {
 public:
  BulletWorld(const World& world, Check check, PairObserver* observer) : world_(world) {
    if (check == Check::native || observer != nullptr) {
      const EngineCheck whose = check == Check::native ? EngineCheck::native : EngineCheck::own;
      plugin_.emplace(dispatcher_, BulletPlugin::Options{whose, observer});
    }
    dynamics_.getSolverInfo().m_numIterations = kIterations;
    dynamics_.setGravity({0, 0, btScalar(-kGravity)});
    for (const Body& body : world.bodies) add(body);
  }

  ~BulletWorld() {
    for (const auto& body : bodies_) dynamics_.removeRigidBody(body.get());
  }
  BulletWorld(const BulletWorld&) = delete;
  BulletWorld& operator=(const BulletWorld&) = delete;

  Outcome run() {
    Tracker tracker(world_);
    const btScalar step = to_engine(world_.step);
    StepTimes times(world_.steps);
    for (int i = 0; i < world_.steps; ++i) {
      const auto start = Clock::now();
      dynamics_.stepSimulation(step, 0, step);
      times.add(dynamics_.check_time, Clock::now() - start, contacts());
      tracker.see_last(from_engine(bodies_.back()->getWorldTransform().getOrigin()));
    }
    Outcome out;
    times.finish(out);
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      const btTransform& X = bodies_[i]->getWorldTransform();
      Pose pose;
      for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c) pose.R(r, c) = X.getBasis()[r][c];
      pose.p = from_engine(X.getOrigin());
      tracker.finish(i, pose, from_engine(bodies_[i]->getLinearVelocity()),
                     from_engine(bodies_[i]->getAngularVelocity()), out);
    }
    out.contacts = contacts();
    return out;
  }

 private:
  std::size_t contacts() {
    int count = 0;
    for (int i = 0; i < dispatcher_.getNumManifolds(); ++i)
      count += dispatcher_.getManifoldByIndexInternal(i)->getNumContacts();
    return static_cast<std::size_t>(count);
  }

  void add(const Body& body) {
    shapes_.push_back(make_shape(world_, body));
    btRigidBody::btRigidBodyConstructionInfo info(to_engine(body.mass), nullptr, shapes_.back().get(),
                                                  to_engine(body.inertia));
    info.m_startWorldTransform = to_engine(body.X_WS);
    info.m_friction = to_engine(std::sqrt(world_.friction));  // the engine multiplies the two
    bodies_.push_back(std::make_unique<btRigidBody>(info));
    bodies_.back()->setLinearVelocity(to_engine(body.velocity));
    bodies_.back()->setActivationState(DISABLE_DEACTIVATION);
    dynamics_.addRigidBody(bodies_.back().get());
  }

  const World& world_;
  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_{&configuration_};
  std::optional<BulletPlugin> plugin_;
  btDbvtBroadphase broadphase_;
  btSequentialImpulseConstraintSolver solver_;
  TimedWorld dynamics_{&dispatcher_, &broadphase_, &solver_, &configuration_};
  std::vector<std::unique_ptr<btConvexInternalShape>> shapes_;
  std::vector<std::unique_ptr<btRigidBody>> bodies_;
};

}  // namespace

Outcome run_bullet(const World& world, Check check, PairObserver* observer) {
  return BulletWorld(world, check, observer).run();
}

}  // namespace touchstone::engine_check
