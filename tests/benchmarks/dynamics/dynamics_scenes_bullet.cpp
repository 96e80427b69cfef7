#include "touchstone/tests/benchmarks/dynamics/dynamics_scenes.hpp"

#ifdef TOUCHSTONE_BENCHMARK_BULLET_DYNAMICS
#include <btBulletDynamicsCommon.h>
#endif

namespace touchstone::benchmarks {

#ifdef TOUCHSTONE_BENCHMARK_BULLET_DYNAMICS
namespace {

btVector3 vector_of(const Vector3& v) { return {v.x(), v.y(), v.z()}; }
Vector3 vector_of(const btVector3& v) { return {v.x(), v.y(), v.z()}; }

/// In double precision, with its own check and default solver.
class Bullet final : public BoxEngine {
 public:
  explicit Bullet(const BoxScene& scene) : step_(scene.step) {
    world_.setGravity({0, 0, -9.81});
    for (const SceneBox& box : scene.boxes) add(box, scene);
  }
  Bullet(const Bullet&) = delete;
  Bullet& operator=(const Bullet&) = delete;
  ~Bullet() override {
    for (const auto& body : bodies_) world_.removeRigidBody(body.get());
  }
  const char* name() const override { return "Bullet"; }
  void step() override {
    // Kinematic bodies are where they are put; Bullet takes their velocity from there.
    for (const std::size_t i : driven_) {
      btTransform X = bodies_[i]->getWorldTransform();
      X.setOrigin(X.getOrigin() + step_ * bodies_[i]->getLinearVelocity());
      const btScalar rate = driven_w_[i].length();
      if (rate > 0) X.setRotation(btQuaternion(driven_w_[i] / rate, rate * step_) * X.getRotation());
      states_[i]->setWorldTransform(X);
    }
    for (const std::size_t i : pushed_) bodies_[i]->applyCentralForce(forces_[i]);
    world_.stepSimulation(step_, 1, step_);
    for (const std::size_t i : driven_) bodies_[i]->setLinearVelocity(driven_v_[i]);
  }
  BoxMotion motion(std::size_t box) const override {
    const btRigidBody& body = *bodies_[box];
    return {vector_of(body.getWorldTransform().getOrigin()), vector_of(body.getLinearVelocity()),
            vector_of(body.getAngularVelocity())};
  }
  std::size_t points() const override {
    std::size_t count = 0;
    for (int i = 0; i < dispatcher_.getNumManifolds(); ++i)
      count += static_cast<std::size_t>(dispatcher_.getManifoldByIndexInternal(i)->getNumContacts());
    return count;
  }

 private:
  void add(const SceneBox& box, const BoxScene& scene) {
    // Only free boxes have an inertia; to Bullet a mass of 0 means fixed or moved.
    const bool is_free = box.kind == SceneBox::Kind::free;
    btVector3 inertia(0, 0, 0);
    shapes_.push_back(std::make_unique<btBoxShape>(0.5 * vector_of(box.size)));
    if (is_free) shapes_.back()->calculateLocalInertia(box.mass, inertia);
    // Bullet takes the turn vector as an angle about an axis.
    btTransform X;
    X.setIdentity();
    X.setOrigin(vector_of(box.p_W));
    const double angle = norm(box.turn_W);
    if (angle > 0.0) X.setRotation(btQuaternion(vector_of(Vector3(box.turn_W / angle)), angle));
    states_.push_back(std::make_unique<btDefaultMotionState>(X));
    // The body, and how it is moved.
    btRigidBody::btRigidBodyConstructionInfo info(is_free ? box.mass : 0.0, states_.back().get(),
                                                  shapes_.back().get(), inertia);
    bodies_.push_back(std::make_unique<btRigidBody>(info));
    btRigidBody& body = *bodies_.back();
    body.setFriction(std::sqrt(scene.friction));  // Bullet multiplies the two
    body.setLinearVelocity(vector_of(box.v_W));
    driven_v_.push_back(vector_of(box.v_W));
    driven_w_.push_back(vector_of(box.w_W));
    forces_.push_back(vector_of(box.force_W));
    if (is_free && box.force_W != Vector3::Zero()) pushed_.push_back(bodies_.size() - 1);
    if (box.kind == SceneBox::Kind::driven) {
      body.setCollisionFlags(body.getCollisionFlags() | btCollisionObject::CF_KINEMATIC_OBJECT);
      driven_.push_back(bodies_.size() - 1);
    }
    // Only free bodies of scenes in which bodies sleep may do so.
    if (!scene.sleeps || box.kind == SceneBox::Kind::driven) body.setActivationState(DISABLE_DEACTIVATION);
    world_.addRigidBody(&body);
  }

  double step_;
  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_{&configuration_};
  btDbvtBroadphase broadphase_;
  btSequentialImpulseConstraintSolver solver_;
  btDiscreteDynamicsWorld world_{&dispatcher_, &broadphase_, &solver_, &configuration_};
  std::vector<std::unique_ptr<btBoxShape>> shapes_;
  std::vector<std::unique_ptr<btDefaultMotionState>> states_;
  std::vector<std::unique_ptr<btRigidBody>> bodies_;
  std::vector<btVector3> driven_v_, driven_w_, forces_;
  std::vector<std::size_t> driven_, pushed_;
};

}  // namespace

std::unique_ptr<BoxEngine> make_bullet(const BoxScene& scene) { return std::make_unique<Bullet>(scene); }
#else
std::unique_ptr<BoxEngine> make_bullet(const BoxScene&) { return nullptr; }
#endif

}  // namespace touchstone::benchmarks
