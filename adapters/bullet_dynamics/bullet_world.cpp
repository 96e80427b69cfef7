#include "touchstone/adapters/bullet_dynamics/bullet_world.hpp"

#include <btBulletDynamicsCommon.h>

#include <chrono>
#include <cmath>
#include <optional>

#include "touchstone/adapters/bullet_dynamics/bullet_shapes.hpp"
#include "touchstone/adapters/bullet_plugin/bullet_plugin.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/physics/engine/scene_engine.hpp"

namespace touchstone::bullet_dynamics {
namespace {

using namespace TOUCHSTONE_BULLET_NAMESPACE;
using physics::ContactSide;
using physics::DynamicScene;
using physics::EngineContact;
using physics::EngineScene;
using physics::EngineStep;
using physics::SceneEngine;
using Clock = std::chrono::steady_clock;

/// Beyond it btManifoldResult cuts a pair's friction.
constexpr double kMostFriction = 10.0;

Pose from_engine_pose(const btTransform& X) {
  Pose out;
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) out.R(i, k) = X.getBasis()[i][k];
  out.p = from_engine(X.getOrigin());
  return out;
}

/// Which solid of its body a point of a manifold is on: a compound's child.
SolidIndex solid_at(const EngineScene& scene, const btCollisionObject& object, int index) {
  const EngineScene::Body& body = scene.bodies()[static_cast<std::size_t>(object.getUserIndex())];
  return body.solids[object.getCollisionShape()->isCompound() ? static_cast<std::size_t>(index) : 0];
}

/// Gives every point the scene's friction and restitution, where bodies' own figures do not say it, and times
/// the check.
class World final : public btDiscreteDynamicsWorld {
 public:
  World(btDispatcher* dispatcher, btBroadphaseInterface* broadphase, btConstraintSolver* solver,
        btCollisionConfiguration* configuration, const EngineScene& scene)
      : btDiscreteDynamicsWorld(dispatcher, broadphase, solver, configuration), scene_(scene) {}

  void performDiscreteCollisionDetection() override {
    const Clock::time_point start = Clock::now();
    btDiscreteDynamicsWorld::performDiscreteCollisionDetection();
    if (sets_materials) set_materials();
    check_us = std::chrono::duration<double, std::micro>(Clock::now() - start).count();
  }

  bool sets_materials = false;
  double check_us = 0.0;

 private:
  void set_materials() {
    for (int m = 0; m < getDispatcher()->getNumManifolds(); ++m) {
      btPersistentManifold& manifold = *getDispatcher()->getManifoldByIndexInternal(m);
      for (int k = 0; k < manifold.getNumContacts(); ++k) {
        btManifoldPoint& point = manifold.getContactPoint(k);
        const SolidIndex a = solid_at(scene_, *manifold.getBody0(), point.m_index0),
                         b = solid_at(scene_, *manifold.getBody1(), point.m_index1);
        point.m_combinedFriction = scene_.friction(a, b);
        point.m_combinedRestitution = scene_.restitution(a, b);
      }
    }
  }

  const EngineScene& scene_;
};

class BulletEngine final : public SceneEngine {
 public:
  BulletEngine(const DynamicScene& scene, bool by_native) : SceneEngine(scene) {
    if (by_native) plugin_.emplace(dispatcher_, BulletPlugin::Options{EngineCheck::native, nullptr, true});
    world_.setGravity(to_engine(scene.gravity_W));
    world_.getSolverInfo().m_restitutionVelocityThreshold = scene.bounce_speed;
    for (std::size_t b = 0; b < bodies().bodies().size(); ++b) add(b);
    for (const auto& [a, b] : bodies().exempt_bodies()) {
      bodies_[a]->setIgnoreCollisionCheck(bodies_[b].get(), true);
      bodies_[b]->setIgnoreCollisionCheck(bodies_[a].get(), true);
    }
    world_.sets_materials = needs_materials();
    start();
  }

  ~BulletEngine() override {
    for (const auto& body : bodies_) world_.removeRigidBody(body.get());
  }

  void list_contacts(std::vector<EngineContact>& contacts) const override {
    contacts.clear();
    for (int m = 0; m < dispatcher_.getNumManifolds(); ++m) {
      const btPersistentManifold& manifold = *dispatcher().getManifoldByIndexInternal(m);
      for (int k = 0; k < manifold.getNumContacts(); ++k)
        contacts.push_back(contact(manifold, manifold.getContactPoint(k)));
    }
  }

 protected:
  void advance(EngineStep& step) override {
    for (std::size_t b = 0; b < bodies_.size(); ++b)
      if (bodies().bodies()[b].kind == ContactSide::told)
        bodies_[b]->setWorldTransform(to_engine(target(b).X_WB));
    world_.stepSimulation(to_engine(step_size()), 0, to_engine(step_size()));
    step.detection_us = world_.check_us;
    for (int m = 0; m < dispatcher_.getNumManifolds(); ++m)
      step.contacts += static_cast<std::size_t>(dispatcher_.getManifoldByIndexInternal(m)->getNumContacts());
    if (plugin_) step.failed = static_cast<std::uint32_t>(plugin_->statistics().refused - refused_);
    if (plugin_) refused_ = plugin_->statistics().refused;
  }

  State read_state(std::size_t body) const override {
    const btRigidBody& from = *bodies_[body];
    return {from_engine_pose(from.getWorldTransform()), from_engine(from.getLinearVelocity()),
            from_engine(from.getAngularVelocity())};
  }

 private:
  /// Bullet's accessor is not const.
  btCollisionDispatcher& dispatcher() const { return const_cast<btCollisionDispatcher&>(dispatcher_); }

  /// Bodies' own figures give a pair its friction: the product of two roots. They give no larger restitution.
  bool needs_materials() const {
    for (const EngineScene::Body& body : bodies().bodies())
      for (const std::size_t object : body.objects) {
        const physics::Surface& surface = scene().bodies[object].surface;
        if (surface.restitution != 0.0) return true;
        if (surface.friction != scene().bodies[body.objects[0]].surface.friction) return true;
      }
    return false;
  }

  void add(std::size_t index) {
    const EngineScene::Body& body = bodies().bodies()[index];
    const physics::Surface& surface = scene().bodies[body.objects[0]].surface;
    if (surface.friction > kMostFriction)
      throw InputError("engine 'bullet': unsupported: friction above 10 (" + body.name + ")");
    const bool is_free = body.kind == ContactSide::body;
    btRigidBody::btRigidBodyConstructionInfo info(is_free ? body.mass : 0.0, nullptr,
                                                  shapes_.make(bodies(), index),
                                                  is_free ? to_engine(body.moments) : btVector3(0, 0, 0));
    info.m_startWorldTransform = to_engine(body.X_WB);
    info.m_friction = std::sqrt(surface.friction);  // Bullet multiplies the two
    bodies_.push_back(std::make_unique<btRigidBody>(info));
    btRigidBody& added = *bodies_.back();
    added.setUserIndex(static_cast<int>(index));
    if (is_free) {
      added.setLinearVelocity(to_engine(body.v_W));
      added.setAngularVelocity(to_engine(body.w_W));
    }
    if (body.kind == ContactSide::told)
      added.setCollisionFlags(added.getCollisionFlags() | btCollisionObject::CF_KINEMATIC_OBJECT);
    if (body.kind != ContactSide::ground) added.setActivationState(DISABLE_DEACTIVATION);
    world_.addRigidBody(&added);
  }

  EngineContact contact(const btPersistentManifold& manifold, const btManifoldPoint& point) const {
    EngineContact out;
    out.solids = {solid_at(bodies(), *manifold.getBody0(), point.m_index0),
                  solid_at(bodies(), *manifold.getBody1(), point.m_index1)};
    out.separation = point.getDistance();
    out.status = out.separation > 0.0 ? PairStatus::separated : PairStatus::overlapping;
    out.p_W = from_engine((point.getPositionWorldOnA() + point.getPositionWorldOnB()) * btScalar(0.5));
    out.n_AB_W = from_engine(btVector3(-point.m_normalWorldOnB));
    // Impulses on body 0.
    const btVector3 impulse = point.m_normalWorldOnB * point.m_appliedImpulse +
                              point.m_lateralFrictionDir1 * point.m_appliedImpulseLateral1 +
                              point.m_lateralFrictionDir2 * point.m_appliedImpulseLateral2;
    out.force_W = from_engine(btVector3(-impulse)) / step_size();
    finish_contact(out);
    return out;
  }

  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_{&configuration_};
  std::optional<BulletPlugin> plugin_;
  std::uint64_t refused_ = 0;
  btDbvtBroadphase broadphase_;
  btSequentialImpulseConstraintSolver solver_;
  World world_{&dispatcher_, &broadphase_, &solver_, &configuration_, bodies()};
  Shapes shapes_;
  std::vector<std::unique_ptr<btRigidBody>> bodies_;
};

}  // namespace

std::unique_ptr<physics::DynamicsEngine> make_world(const DynamicScene& scene, bool by_native) {
  return std::make_unique<BulletEngine>(scene, by_native);
}

}  // namespace touchstone::bullet_dynamics
