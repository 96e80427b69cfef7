#include "touchstone/adapters/bullet_dynamics/bullet_world.hpp"

#include <BulletDynamics/Featherstone/btMultiBodyConstraintSolver.h>
#include <btBulletDynamicsCommon.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <optional>

#include "touchstone/adapters/bullet_dynamics/bullet_joints.hpp"
#include "touchstone/adapters/bullet_dynamics/bullet_shapes.hpp"
#include "touchstone/adapters/bullet_dynamics/bullet_tree.hpp"
#include "touchstone/adapters/bullet_plugin/bullet_plugin.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/contact_core/scene/scene_instance.hpp"
#include "touchstone/physics/engine/scene_engine.hpp"

namespace touchstone::physics::bullet_dynamics {
namespace {

using namespace TOUCHSTONE_BULLET_NAMESPACE;
using Clock = std::chrono::steady_clock;

/// Beyond it btManifoldResult cuts a pair's friction.
constexpr double kMostFriction = 10.0;
/// Over motors and stops of joints, in each of the solver's iterations.
constexpr int kJointSweeps = 10;

/// Which solid of its body a point of a manifold is on: a compound's child.
SolidIndex solid_at(const EngineScene& scene, const btCollisionObject& object, int index) {
  const EngineScene::Body& body = scene.bodies()[static_cast<std::size_t>(object.getUserIndex())];
  return body.solids[object.getCollisionShape()->isCompound() ? static_cast<std::size_t>(index) : 0];
}

/// Rules for a world's contacts beyond Bullet's own. Of solids, numbered as the scene's.
struct ContactRules {
  const EngineScene& scene;
  std::function<bool(std::size_t, std::size_t)> meets;     ///< bodies; empty: all do
  std::function<bool(SolidIndex, SolidIndex)> is_checked;  ///< empty: all are
  bool sets_materials = false;    ///< where bodies' own figures do not say friction and restitution
  double part_speed = kInfinity;  ///< at most which depth is taken back [m/s]
  double check_us = 0.0;          ///< of the last step

  /// Gives every point the scene's figures, and takes out those of solids that are not checked.
  void apply(btDispatcher& dispatcher) const {
    if (!sets_materials && !is_checked) return;
    for (int m = 0; m < dispatcher.getNumManifolds(); ++m) {
      btPersistentManifold& manifold = *dispatcher.getManifoldByIndexInternal(m);
      for (int k = manifold.getNumContacts() - 1; k >= 0; --k) {
        btManifoldPoint& point = manifold.getContactPoint(k);
        const SolidIndex a = solid_at(scene, *manifold.getBody0(), point.m_index0),
                         b = solid_at(scene, *manifold.getBody1(), point.m_index1);
        if (sets_materials) {
          point.m_combinedFriction = scene.friction(a, b);
          point.m_combinedRestitution = scene.restitution(a, b);
        }
        if (is_checked && !is_checked(a, b)) manifold.removeContactPoint(k);
      }
    }
  }
};

/// Asks the rules which bodies meet. (Links of an articulated body do not ask the lists that
/// setIgnoreCollisionCheck() makes.)
class Dispatcher final : public btCollisionDispatcher {
 public:
  Dispatcher(btCollisionConfiguration* configuration, const ContactRules& rules)
      : btCollisionDispatcher(configuration), rules_(rules) {}
  bool needsCollision(const btCollisionObject* a, const btCollisionObject* b) override {
    if (rules_.meets && !rules_.meets(static_cast<std::size_t>(a->getUserIndex()),
                                      static_cast<std::size_t>(b->getUserIndex())))
      return false;
    return btCollisionDispatcher::needsCollision(a, b);
  }

 private:
  const ContactRules& rules_;
};

/// Depths as the solver gets them: none deeper than the cap, so that what it takes back of them a step has a
/// speed. What is read later are the true ones.
class CappedDepths {
 public:
  /// @param cap [m]; infinite: leaves all as they are
  void cut(btDispatcher& dispatcher, btScalar cap) {
    cut_.clear();
    if (!(cap < BT_INFINITY)) return;
    for (int m = 0; m < dispatcher.getNumManifolds(); ++m) {
      btPersistentManifold& manifold = *dispatcher.getManifoldByIndexInternal(m);
      for (int k = 0; k < manifold.getNumContacts(); ++k) {
        btManifoldPoint& point = manifold.getContactPoint(k);
        if (point.m_distance1 >= -cap) continue;
        cut_.push_back({&point, point.m_distance1});
        point.m_distance1 = -cap;
      }
    }
  }
  void put_back() {
    for (const auto& [point, distance] : cut_) point->m_distance1 = distance;
  }

 private:
  std::vector<std::pair<btManifoldPoint*, btScalar>> cut_;
};

/// A world of Bullet's that keeps the rules and times its check.
template <class Base, class Solver>
class World final : public Base {
 public:
  World(btDispatcher* dispatcher, btBroadphaseInterface* broadphase, Solver* solver,
        btCollisionConfiguration* configuration, ContactRules& rules)
      : Base(dispatcher, broadphase, solver, configuration), rules_(rules) {}

  void performDiscreteCollisionDetection() override {
    const Clock::time_point start = Clock::now();
    Base::performDiscreteCollisionDetection();
    rules_.apply(*Base::getDispatcher());
    rules_.check_us = std::chrono::duration<double, std::micro>(Clock::now() - start).count();
  }

  void solveConstraints(btContactSolverInfo& info) override {
    depths_.cut(*Base::getDispatcher(), rules_.part_speed * info.m_timeStep / info.m_erp2);
    Base::solveConstraints(info);
    depths_.put_back();
  }

 private:
  ContactRules& rules_;
  CappedDepths depths_;
};

/// That hold, or ever may.
bool any_latch(const DynamicScene& scene) {
  if (!scene.scene.latches.empty() || !scene.latch_options.empty()) return true;
  return std::any_of(scene.actions.begin(), scene.actions.end(),
                     [](const SceneAction& each) { return each.kind == SceneAction::Kind::latch; });
}

class BulletEngine final : public SceneEngine {
 public:
  BulletEngine(const DynamicScene& scene, const WorldCheck& check) : SceneEngine(scene) {
    if (check.is_ours)
      plugin_.emplace(dispatcher_, BulletPlugin::Options{EngineCheck::native, nullptr, true, check.inside});
    make_world();
    world_->setGravity(to_engine(scene.gravity_W));
    world_->getSolverInfo().m_restitutionVelocityThreshold = scene.bounce_speed;
    for (std::size_t b = 0; b < bodies().bodies().size(); ++b) add(b);
    set_rules();
    refuse_kinematic_carriers();
    add_body_joints();
    start();
    if (articulated_ != nullptr) regroup();
    is_started_ = true;
    keep_start();
  }

  EngineReturn after_restore() const override { return EngineReturn::repeatable; }

  ~BulletEngine() override {
    trees_.clear();
    body_joints_.clear();
    for (const auto& body : bodies_)
      if (body) world_->removeRigidBody(body.get());
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
  void apply(std::size_t body, const Vector3& force_W, const Vector3& moment_W) override {
    if (tree_of_[body] != nullptr) return tree_of_[body]->push(body, force_W, moment_W);
    bodies_[body]->applyCentralForce(to_engine(force_W));
    bodies_[body]->applyTorque(to_engine(moment_W));
  }

  void advance(EngineStep& step) override {
    for (std::size_t b = 0; b < bodies_.size(); ++b)
      if (bodies().bodies()[b].kind == ContactSide::kinematic)
        bodies_[b]->setWorldTransform(to_engine(target(b).X_WB));
    for (const auto& tree : trees_) tree->apply_torques();
    for (const auto& joint : body_joints_) joint->apply();
    world_->stepSimulation(to_engine(step_size()), 0, to_engine(step_size()));
    for (const auto& tree : trees_) tree->read();
    for (const auto& joint : body_joints_) joint->read();
    step.detection_us = rules_.check_us;
    for (int m = 0; m < dispatcher_.getNumManifolds(); ++m)
      step.contacts += static_cast<std::size_t>(dispatcher_.getManifoldByIndexInternal(m)->getNumContacts());
    if (plugin_) step.failed = static_cast<std::uint32_t>(plugin_->statistics().refused - refused_);
    if (plugin_) refused_ = plugin_->statistics().refused;
  }

  State read_state(std::size_t body) const override {
    const BodyMotion now = motion(body);
    return {now.X_WB, now.v_W, now.w_W};
  }

  JointState read_joint(std::size_t joint) const override {
    if (joint >= bodies().joints().size()) {
      const BodyJoint& of_bodies = *body_joints_[joint - bodies().joints().size()];
      return {of_bodies.value(), of_bodies.rate(), of_bodies.torque()};
    }
    const Tree& tree = *tree_of_joint_[joint];
    const JointMotion now = tree.joint(joint);
    return {now.value, now.rate, tree.torque(joint, step_size())};
  }

  void set_drive(std::size_t joint, const JointDrive& drive) override {
    if (joint >= bodies().joints().size())
      return body_joints_[joint - bodies().joints().size()]->set_drive(drive);
    drives_[joint] = drive;
    if (tree_of_joint_[joint] != nullptr) tree_of_joint_[joint]->set_drive(joint, drive);
  }

  void set_joint(std::size_t joint, double value, double rate) override {
    tree_of_joint_[joint]->set_joint(joint, value, rate);
  }

  void switch_joint(std::size_t body_joint, bool is_on) override {
    body_joints_[body_joint]->switch_to(is_on);
  }

  void latch(std::size_t carrier, std::size_t carried) override {
    const Pose X_WC = motion(carrier).X_WB;
    latches_.push_back({carrier, carried, compose(inverse(X_WC), motion(carried).X_WB)});
    if (is_started_) regroup();
  }

  void release(std::size_t carried) override {
    std::erase_if(latches_, [&](const Latch& each) { return each.carried == carried; });
    regroup();
  }

  void take_body(std::size_t body) override { world_->removeRigidBody(bodies_[body].get()); }
  void put_body(std::size_t body, const State& at) override { put_back(body, {at.X_WB, at.v_W, at.w_W}); }

  std::unique_ptr<EngineSnapshot> save() const override {
    auto out = std::make_unique<Saved>();
    for (std::size_t b = 0; b < bodies_.size(); ++b) out->bodies.push_back(motion(b));
    for (std::size_t j = 0; j < tree_of_joint_.size(); ++j) out->joints.push_back(joint_motion(j));
    for (const auto& joint : body_joints_) out->holds.push_back(joint->hold());
    out->latches = latches_;
    return out;
  }

  /// All of the world is put in anew, in the order of the start: what Bullet remembers of pairs and contacts
  /// has gone with it.
  void load(const EngineSnapshot& saved) override {
    const auto& from = static_cast<const Saved&>(saved);
    clear();
    for (std::size_t b = 0; b < bodies_.size(); ++b) {
      if (!bodies_[b]) continue;
      place(*bodies_[b], from.bodies[b]);
      world_->addRigidBody(bodies_[b].get());
    }
    for (std::size_t j = 0; j < body_joints_.size(); ++j) body_joints_[j]->set_hold(from.holds[j]);
    for (std::size_t b = 0; b < bodies_.size(); ++b)
      if (is_out(b)) take_body(b);
    latches_ = from.latches;
    if (articulated_ != nullptr) regroup(from.bodies, from.joints);
  }

 private:
  struct Latch {
    std::size_t carrier, carried;  // bodies
    Pose X_CB;                     // of the carried one in the carrier
  };
  struct Saved final : EngineSnapshot {
    std::vector<BodyMotion> bodies;
    std::vector<JointMotion> joints;
    std::vector<BodyJoint::Hold> holds;
    std::vector<Latch> latches;
  };

  /// Takes everything out of the world.
  void clear() {
    trees_.clear();
    std::fill(tree_of_.begin(), tree_of_.end(), nullptr);
    std::fill(tree_of_joint_.begin(), tree_of_joint_.end(), nullptr);
    for (const auto& joint : body_joints_) joint->switch_to(false);
    for (const auto& body : bodies_)
      if (body && body->isInWorld()) world_->removeRigidBody(body.get());
    broadphase_.resetPool(&dispatcher_);
    solver_->reset();
  }

  /// Bullet's accessor is not const.
  btCollisionDispatcher& dispatcher() const { return const_cast<Dispatcher&>(dispatcher_); }

  void make_world() {
    if (scene().mechanisms.empty() && !any_latch(scene())) {
      solver_ = std::make_unique<btSequentialImpulseConstraintSolver>();
      world_ = std::make_unique<World<btDiscreteDynamicsWorld, btConstraintSolver>>(
          &dispatcher_, &broadphase_, solver_.get(), &configuration_, rules_);
      return;
    }
    auto solver = std::make_unique<btMultiBodyConstraintSolver>();
    auto world = std::make_unique<World<btMultiBodyDynamicsWorld, btMultiBodyConstraintSolver>>(
        &dispatcher_, &broadphase_, solver.get(), &configuration_, rules_);
    articulated_ = world.get();
    world_ = std::move(world), solver_ = std::move(solver);
    world_->getSolverInfo().m_numNonContactInnerIterations = kJointSweeps;
    drives_.resize(bodies().joints().size());
    tree_of_joint_.resize(bodies().joints().size(), nullptr);
  }

  void set_rules() {
    if (scene().push_out > 0.0) rules_.part_speed = scene().part_speed;
    rules_.sets_materials = needs_materials();
    if (!bodies().exempt_bodies().empty() || articulated_ != nullptr)
      rules_.meets = [this](std::size_t a, std::size_t b) {
        return !std::binary_search(bodies().exempt_bodies().begin(), bodies().exempt_bodies().end(),
                                   std::pair<std::size_t, std::size_t>(std::minmax(a, b)));
      };
    if (!bodies().partly_exempt().empty() || articulated_ != nullptr)
      rules_.is_checked = [this](SolidIndex a, SolidIndex b) { return is_checked(a, b); };
  }

  /// Bodies' own figures give a pair its friction: the product of two roots. They give no larger restitution.
  bool needs_materials() const {
    if (!bodies().has_usual_surfaces()) return true;
    for (const EngineScene::Body& body : bodies().bodies())
      for (const std::size_t object : body.objects) {
        const Surface& surface = scene().bodies[object].surface;
        if (surface.restitution != 0.0) return true;
        if (surface.friction != scene().bodies[body.objects[0]].surface.friction) return true;
      }
    return false;
  }

  /// A body that a kinematic one carries would have to be kinematic, and dynamic again once let go.
  void refuse_kinematic_carriers() const {
    const auto refuse = [&](std::size_t carrier, std::size_t carried) {
      if (bodies().bodies()[carrier].kind == ContactSide::kinematic)
        throw InputError("engine 'bullet': unsupported: a latch on a kinematic body (" +
                         bodies().bodies()[carrier].name + ")");
      if (bodies().bodies()[carried].kind != ContactSide::body)
        throw InputError("engine 'bullet': unsupported: a latch that closes a loop (" +
                         bodies().bodies()[carried].name + ")");
    };
    for (const SceneLatch& each : scene().scene.latches)
      refuse(bodies().body_of(find_object(scene().scene, each.carrier)),
             bodies().body_of(find_object(scene().scene, each.carried)));
    for (const SceneAction& each : scene().actions)
      if (each.kind == SceneAction::Kind::latch)
        refuse(bodies().body_of(each.carrier), bodies().body_of(each.carried));
    for (const SceneLatchOption& each : scene().latch_options)
      refuse(bodies().body_of(each.carrier), bodies().body_of(each.carried));
  }

  /// Of rigid bodies. Those of an articulated body are none, nor is what a latch makes part of one.
  void add_body_joints() {
    const auto body = [&](std::size_t b, const SceneBodyJoint& joint) -> btRigidBody* {
      if (b == EngineScene::kNone) return nullptr;
      if (bodies().bodies()[b].kind == ContactSide::link)
        throw InputError("engine 'bullet': unsupported: a joint between bodies on a link (joint '" +
                         joint.name + "')");
      return bodies_[b].get();
    };
    for (const EngineScene::BodyJoint& joint : bodies().body_joints())
      body_joints_.push_back(std::make_unique<BodyJoint>(*world_, *joint.source,
                                                         body(joint.child, *joint.source),
                                                         body(joint.parent, *joint.source), step_size()));
    if (any_latch(scene()) && !body_joints_.empty())
      throw InputError("engine 'bullet': unsupported: joints between bodies beside latches (joint '" +
                       scene().joints[0].name + "')");
  }

  void add(std::size_t index) {
    const EngineScene::Body& body = bodies().bodies()[index];
    // Bullet clamps friction, so that a scene with more is refused.
    const Surface& surface = scene().bodies[body.objects[0]].surface;
    if (surface.friction > kMostFriction)
      throw InputError("engine 'bullet': unsupported: friction above 10 (" + body.name + ")");
    // Links belong to a multibody, which is made later from their shapes.
    made_shapes_.push_back(shapes_.make(bodies(), index));
    bodies_.push_back(nullptr);
    tree_of_.push_back(nullptr);
    if (body.kind == ContactSide::link) return;
    // Bodies that forces do not move have no mass.
    const bool is_free = body.kind == ContactSide::body;
    btRigidBody::btRigidBodyConstructionInfo info(is_free ? body.mass : 0.0, nullptr, made_shapes_.back(),
                                                  is_free ? to_engine(body.moments) : btVector3(0, 0, 0));
    info.m_startWorldTransform = to_engine(body.X_WB);
    info.m_friction = std::sqrt(surface.friction);  // Bullet multiplies the two
    bodies_.back() = std::make_unique<btRigidBody>(info);
    btRigidBody& added = *bodies_.back();
    added.setUserIndex(static_cast<int>(index));
    // Free bodies start at the scene's velocities, and whatever moves stays awake.
    if (is_free) {
      added.setLinearVelocity(to_engine(body.v_W));
      added.setAngularVelocity(to_engine(body.w_W));
    }
    if (body.kind == ContactSide::kinematic)
      added.setCollisionFlags(added.getCollisionFlags() | btCollisionObject::CF_KINEMATIC_OBJECT);
    if (body.kind != ContactSide::ground) added.setActivationState(DISABLE_DEACTIVATION);
    world_->addRigidBody(&added);
  }

  // ---- what joints and latches hold together

  BodyMotion motion(std::size_t body) const {
    if (tree_of_[body] != nullptr) return tree_of_[body]->motion(body);
    if (!bodies_[body]) {  // a link before the first tree
      const EngineScene::Body& from = bodies().bodies()[body];
      return {from.X_WB, from.v_W, from.w_W};
    }
    const btRigidBody& from = *bodies_[body];
    return {from_engine(from.getWorldTransform()), from_engine(from.getLinearVelocity()),
            from_engine(from.getAngularVelocity())};
  }

  JointMotion joint_motion(std::size_t joint) const {
    if (tree_of_joint_[joint] != nullptr) return tree_of_joint_[joint]->joint(joint);
    const SceneJoint& source = *bodies().joints()[joint].source;
    return {source.value, source.rate};
  }

  /// Makes the trees anew, by what holds now. Bodies that nothing holds any more are rigid bodies again.
  void regroup() {
    std::vector<BodyMotion> now;
    std::vector<JointMotion> joints;
    for (std::size_t b = 0; b < bodies_.size(); ++b) now.push_back(motion(b));
    for (std::size_t j = 0; j < tree_of_joint_.size(); ++j) joints.push_back(joint_motion(j));
    regroup(now, joints);
  }

  void regroup(const std::vector<BodyMotion>& now, const std::vector<JointMotion>& joints) {
    const std::vector<Tree*> before = tree_of_;
    trees_.clear();
    std::fill(tree_of_.begin(), tree_of_.end(), nullptr);
    for (auto& [root, links] : groups()) {
      for (const TreeLink& link : links) take_from_world(link.body, before);
      if (root != EngineScene::kNone) take_from_world(root, before);
      trees_.push_back(std::make_unique<Tree>(bodies(), *articulated_, root, std::move(links), made_shapes_));
      Tree& tree = *trees_.back();
      tree.set_motion(now, joints);
      if (root != EngineScene::kNone) tree_of_[root] = &tree;
      for (const TreeLink& link : tree.links()) {
        tree_of_[link.body] = &tree;
        if (link.joint == nullptr) continue;
        tree_of_joint_[link.joint_index] = &tree;
        tree.set_drive(link.joint_index, drives_[link.joint_index]);
      }
    }
    for (std::size_t b = 0; b < bodies_.size(); ++b)
      if (before[b] != nullptr && tree_of_[b] == nullptr) put_back(b, now[b]);
  }

  void take_from_world(std::size_t body, const std::vector<Tree*>& before) {
    if (bodies_[body] && before[body] == nullptr) world_->removeRigidBody(bodies_[body].get());
  }

  void put_back(std::size_t index, const BodyMotion& motion) {
    place(*bodies_[index], motion);
    world_->addRigidBody(bodies_[index].get());
  }

  static void place(btRigidBody& body, const BodyMotion& motion) {
    body.setWorldTransform(to_engine(motion.X_WB));
    body.setInterpolationWorldTransform(to_engine(motion.X_WB));
    body.setLinearVelocity(to_engine(motion.v_W));
    body.setAngularVelocity(to_engine(motion.w_W));
    body.clearForces();
    body.updateInertiaTensor();
  }

  struct Group {
    std::size_t root;
    std::vector<TreeLink> links;
  };
  /// One a free body that carries others, and one a link or carried body that the ground holds. Parents
  /// first.
  std::vector<Group> groups() const {
    // Joints and latches are links of trees, each with the body that it hangs on.
    std::vector<TreeLink> open;
    for (std::size_t j = 0; j < bodies().joints().size(); ++j) {
      const EngineScene::Joint& joint = bodies().joints()[j];
      open.push_back({joint.child, joint.parent, &joint, j, {}});
    }
    for (const Latch& latch : latches_) {
      const bool on_ground = bodies().bodies()[latch.carrier].kind == ContactSide::ground;
      const Pose X = on_ground ? compose(bodies().bodies()[latch.carrier].X_WB, latch.X_CB) : latch.X_CB;
      open.push_back({latch.carried, on_ground ? EngineScene::kNone : latch.carrier, nullptr, 0, X});
    }
    // A group is one tree: its base is the ground, or a body that nothing holds.
    std::vector<Group> out;
    std::vector<std::size_t> group_of(bodies_.size(), EngineScene::kNone);
    const auto is_held = [&](std::size_t body) {
      return std::any_of(open.begin(), open.end(), [&](const TreeLink& each) { return each.body == body; });
    };
    std::vector<std::uint8_t> is_placed(open.size(), 0);
    // Links come after their parents, in whatever order the scene lists them.
    for (std::size_t pass = 0; pass < open.size(); ++pass)
      for (std::size_t i = 0; i < open.size(); ++i) {
        const TreeLink& link = open[i];
        if (is_placed[i] != 0) continue;
        std::size_t group = EngineScene::kNone;
        if (link.parent == EngineScene::kNone) {
          group = out.size(), out.push_back({EngineScene::kNone, {}});
        } else if (group_of[link.parent] != EngineScene::kNone) {
          group = group_of[link.parent];
        } else if (!is_held(link.parent)) {
          group = group_of[link.parent] = out.size(), out.push_back({link.parent, {}});
        } else {
          continue;  // its parent comes first
        }
        out[group].links.push_back(link);
        group_of[link.body] = group;
        is_placed[i] = 1;
      }
    return out;
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
  ContactRules rules_{bodies(), {}, {}};
  Dispatcher dispatcher_{&configuration_, rules_};
  std::optional<BulletPlugin> plugin_;
  std::uint64_t refused_ = 0;
  btDbvtBroadphase broadphase_;
  std::unique_ptr<btConstraintSolver> solver_;
  std::unique_ptr<btDiscreteDynamicsWorld> world_;
  btMultiBodyDynamicsWorld* articulated_ = nullptr;  // world_, where there are joints or latches
  Shapes shapes_;
  std::vector<btCollisionShape*> made_shapes_;        // by body
  std::vector<std::unique_ptr<btRigidBody>> bodies_;  // null: a link
  std::vector<std::unique_ptr<BodyJoint>> body_joints_;
  std::vector<std::unique_ptr<Tree>> trees_;
  std::vector<Tree*> tree_of_, tree_of_joint_;  // by body, by joint; null: in none
  std::vector<JointDrive> drives_;              // by joint
  std::vector<Latch> latches_;
  bool is_started_ = false;
};

}  // namespace

std::unique_ptr<DynamicsEngine> make_world(const DynamicScene& scene, const WorldCheck& check) {
  return std::make_unique<BulletEngine>(scene, check);
}

}  // namespace touchstone::physics::bullet_dynamics
