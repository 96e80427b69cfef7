#include "touchstone/adapters/bullet_dynamics/bullet_tree.hpp"

#include <algorithm>
#include <cmath>

#include "touchstone/adapters/bullet_dynamics/bullet_shapes.hpp"

namespace touchstone::physics::bullet_dynamics {

using namespace TOUCHSTONE_BULLET_NAMESPACE;

namespace {

/// Articulated bodies divide by a link's inertia about its joint: a slender rod has none about itself.
constexpr double kThinnest = 1e-6;
/// Bullet takes no infinity for a limit.
constexpr double kNoLimit = 1e30;

btVector3 moments_of(const EngineScene::Body& body) {
  const double least = kThinnest * std::max({body.moments.x(), body.moments.y(), body.moments.z()});
  return to_engine(Vector3(body.moments.cwiseMax(least)));
}

/// Turns vectors of the parent's axes into the link's.
btQuaternion from_parent(const Pose& X_PB) {
  btQuaternion turn;
  to_engine(Pose{X_PB.R.transpose(), Vector3::Zero()}).getBasis().getRotation(turn);
  return turn;
}

}  // namespace

Tree::Tree(const EngineScene& scene, btMultiBodyDynamicsWorld& world, std::size_t root,
           std::vector<TreeLink> links, std::span<btCollisionShape* const> shapes)
    : scene_(scene), world_(world), root_(root), links_(std::move(links)) {
  const bool is_free = root_ != EngineScene::kNone;
  const int count = static_cast<int>(links_.size());
  tree_ = std::make_unique<btMultiBody>(count, is_free ? scene_.bodies()[root_].mass : 0.0,
                                        is_free ? moments_of(scene_.bodies()[root_]) : btVector3(0, 0, 0),
                                        !is_free, false);
  for (int i = 0; i < count; ++i) set_up(i, links_[static_cast<std::size_t>(i)]);
  tree_->finalizeMultiDof();
  // Bullet's defaults take 4 % of the speed a second, cut rates at 100 and pass over links that meet.
  tree_->setLinearDamping(0);
  tree_->setAngularDamping(0);
  tree_->setMaxCoordinateVelocity(kNoLimit);
  tree_->setMaxAppliedImpulse(kNoLimit);
  tree_->setHasSelfCollision(true);
  world_.addMultiBody(tree_.get());
  w_.resize(links_.size() + 1), v_.resize(links_.size() + 1);
  if (is_free) add_collider(-1, root_, shapes[root_]);
  for (int i = 0; i < count; ++i) {
    const TreeLink& link = links_[static_cast<std::size_t>(i)];
    add_collider(i, link.body, shapes[link.body]);
    if (link.joint != nullptr) add_drive(i, link);
  }
}

Tree::~Tree() {
  for (const Drive& drive : drives_) {
    world_.removeMultiBodyConstraint(drive.motor.get());
    if (drive.stops) world_.removeMultiBodyConstraint(drive.stops.get());
  }
  for (const auto& collider : colliders_) world_.removeCollisionObject(collider.get());
  world_.removeMultiBody(tree_.get());
}

void Tree::set_up(int index, const TreeLink& link) {
  const EngineScene::Body& body = scene_.bodies()[link.body];
  const int parent = link.parent == EngineScene::kNone ? -1 : index_of(link.parent);
  if (link.joint == nullptr) {
    tree_->setupFixed(index, body.mass, moments_of(body), parent, from_parent(link.X_PB),
                      to_engine(link.X_PB.p), btVector3(0, 0, 0));
    return;
  }
  const Pose X_WP = link.parent == EngineScene::kNone ? Pose{} : scene_.bodies()[link.parent].X_WB;
  const SceneJoint& joint = *link.joint->source;
  const Matrix3 R_PW = X_WP.R.transpose(), R_BW = body.X_WB.R.transpose();
  const btQuaternion turn = from_parent(compose(inverse(X_WP), body.X_WB));
  const btVector3 axis = to_engine(rotate(R_BW, joint.axis_W)),
                  parent_to_pivot = to_engine(rotate(R_PW, joint.p_W - X_WP.p)),
                  pivot_to_body = to_engine(rotate(R_BW, body.X_WB.p - joint.p_W));
  if (joint.kind == JointKind::revolute)
    tree_->setupRevolute(index, body.mass, moments_of(body), parent, turn, axis, parent_to_pivot,
                         pivot_to_body, false);
  else
    tree_->setupPrismatic(index, body.mass, moments_of(body), parent, turn, axis, parent_to_pivot,
                          pivot_to_body, false);
}

void Tree::add_collider(int index, std::size_t body, btCollisionShape* shape) {
  colliders_.push_back(std::make_unique<btMultiBodyLinkCollider>(tree_.get(), index));
  btMultiBodyLinkCollider& collider = *colliders_.back();
  collider.setCollisionShape(shape);
  collider.setUserIndex(static_cast<int>(body));
  const std::size_t first = scene_.bodies()[body].objects[0];
  collider.setFriction(std::sqrt(scene_.scene().bodies[first].surface.friction));
  collider.setActivationState(DISABLE_DEACTIVATION);
  if (index < 0)
    tree_->setBaseCollider(&collider);
  else
    tree_->getLink(index).m_collider = &collider;
  // A dynamics world takes what is no rigid body for static unless it is set otherwise.
  world_.addCollisionObject(&collider, btBroadphaseProxy::DefaultFilter, btBroadphaseProxy::AllFilter);
}

void Tree::add_drive(int index, const TreeLink& link) {
  const SceneJoint& joint = *link.joint->source;
  Drive drive{link.joint_index,
              index,
              std::make_unique<btMultiBodyJointMotor>(tree_.get(), index, 0.0, 0.0),
              nullptr,
              {}};
  world_.addMultiBodyConstraint(drive.motor.get());
  if (std::isfinite(joint.lower) || std::isfinite(joint.upper)) {
    drive.stops = std::make_unique<btMultiBodyJointLimitConstraint>(
        tree_.get(), index, std::max(joint.lower - joint.value, -kNoLimit),
        std::min(joint.upper - joint.value, kNoLimit));
    drive.stops->setMaxAppliedImpulse(kNoLimit);
    world_.addMultiBodyConstraint(drive.stops.get());
  }
  drives_.push_back(std::move(drive));
}

void Tree::set_motion(std::span<const BodyMotion> bodies, std::span<const JointMotion> joints) {
  if (root_ != EngineScene::kNone) {
    const BodyMotion& base = bodies[root_];
    tree_->setBaseWorldTransform(to_engine(base.X_WB));
    tree_->setBaseVel(to_engine(base.v_W));
    tree_->setBaseOmega(to_engine(base.w_W));
  }
  for (const Drive& drive : drives_) {
    const JointMotion& to = joints[drive.joint];
    const double start = scene_.joints()[drive.joint].source->value;
    tree_->setJointPos(drive.link, to.value - start);
    tree_->setJointVel(drive.link, to.rate);
  }
  read();
  tree_->updateCollisionObjectWorldTransforms(rotations_, origins_);
  if (tree_->getNumDofs() > 0 || root_ != EngineScene::kNone) catch_up(bodies);
}

/// Adds M^-1 J^T of the momenta that the bodies had beyond what the tree's rates give them.
void Tree::catch_up(std::span<const BodyMotion> bodies) {
  btAlignedObjectArray<btScalar> scratch_r;
  btAlignedObjectArray<btVector3> scratch_v;
  btAlignedObjectArray<btMatrix3x3> scratch_m;
  // Makes what calcAccelerationDeltasMultiDof() takes the masses from; a step of 0 changes no rate.
  tree_->computeAccelerationsArticulatedBodyAlgorithmMultiDof(0, scratch_r, scratch_v, scratch_m, false,
                                                              false, false);
  const auto size = 6 + static_cast<std::size_t>(tree_->getNumDofs());
  std::vector<btScalar> impulse(size, 0.0), part(size), change(size);
  const auto add = [&](std::size_t b) {
    const EngineScene::Body& body = scene_.bodies()[b];
    const BodyMotion now = motion(b);
    const Vector3 w_B = rotate(Matrix3(now.X_WB.R.transpose()), bodies[b].w_W - now.w_W);
    const Vector3 linear = body.mass * (bodies[b].v_W - now.v_W),
                  angular = rotate(now.X_WB.R, Vector3(body.moments.cwiseProduct(w_B)));
    tree_->fillConstraintJacobianMultiDof(index_of(b), to_engine(now.X_WB.p), to_engine(angular),
                                          to_engine(linear), part.data(), scratch_r, scratch_v, scratch_m);
    for (std::size_t i = 0; i < size; ++i) impulse[i] += part[i];
  };
  if (root_ != EngineScene::kNone) add(root_);
  for (const TreeLink& link : links_) add(link.body);
  tree_->calcAccelerationDeltasMultiDof(impulse.data(), change.data(), scratch_r, scratch_v);
  tree_->applyDeltaVeeMultiDof(change.data(), 1);
  read();
}

void Tree::set_joint(std::size_t joint, double value, double rate) {
  const int link = drive_of(joint).link;
  tree_->setJointPos(link, value - scene_.joints()[joint].source->value);
  tree_->setJointVel(link, rate);
  read();
  tree_->updateCollisionObjectWorldTransforms(rotations_, origins_);
}

void Tree::set_drive(std::size_t joint, const JointDrive& drive) {
  for (Drive& each : drives_) {
    if (each.joint != joint) continue;
    each.command = drive;
    const bool has_motor = drive.mode != JointDrive::Mode::torque;
    each.motor->setVelocityTarget(drive.mode == JointDrive::Mode::rate ? drive.rate : 0.0);
    each.motor->setMaxAppliedImpulse(has_motor ? std::min(drive.limit * scene_.scene().step, kNoLimit) : 0.0);
  }
}

void Tree::apply_torques() {
  for (const Drive& drive : drives_)
    if (drive.command.mode == JointDrive::Mode::torque)
      tree_->addJointTorque(drive.link, drive.command.torque);
}

void Tree::push(std::size_t body, const Vector3& force_W, const Vector3& moment_W) {
  const int index = index_of(body);
  if (index < 0) {
    tree_->addBaseForce(to_engine(force_W));
    tree_->addBaseTorque(to_engine(moment_W));
    return;
  }
  tree_->addLinkForce(index, to_engine(force_W));
  tree_->addLinkTorque(index, to_engine(moment_W));
}

void Tree::read() {
  tree_->forwardKinematics(rotations_, origins_);
  tree_->compTreeLinkVelocities(w_.data(), v_.data());
}

BodyMotion Tree::motion(std::size_t body) const {
  const int index = index_of(body);
  const btTransform X =
      index < 0 ? tree_->getBaseWorldTransform() : tree_->getLink(index).m_cachedWorldTransform;
  const std::size_t at = index < 0 ? 0 : static_cast<std::size_t>(index) + 1;
  BodyMotion out;
  out.X_WB = from_engine(X);
  out.v_W = rotate(out.X_WB.R, from_engine(v_[at]));
  out.w_W = rotate(out.X_WB.R, from_engine(w_[at]));
  return out;
}

JointMotion Tree::joint(std::size_t joint) const {
  const int link = drive_of(joint).link;
  return {scene_.joints()[joint].source->value + tree_->getJointPos(link), tree_->getJointVel(link)};
}

double Tree::torque(std::size_t joint, double step) const {
  const Drive& drive = drive_of(joint);
  if (drive.command.mode == JointDrive::Mode::torque) return drive.command.torque;
  return drive.motor->getAppliedImpulse(0) / step;
}

int Tree::index_of(std::size_t body) const {
  for (std::size_t i = 0; i < links_.size(); ++i)
    if (links_[i].body == body) return static_cast<int>(i);
  return -1;
}

const Tree::Drive& Tree::drive_of(std::size_t joint) const {
  return *std::find_if(drives_.begin(), drives_.end(),
                       [&](const Drive& each) { return each.joint == joint; });
}

}  // namespace touchstone::physics::bullet_dynamics
