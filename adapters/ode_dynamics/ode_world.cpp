#include "touchstone/adapters/ode_dynamics/ode_world.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdarg>
#include <deque>
#include <mutex>

#include "touchstone/adapters/ode_dynamics/ode_joints.hpp"
#include "touchstone/adapters/ode_plugin/ode_plugin.hpp"
#include "touchstone/physics/engine/scene_engine.hpp"

namespace touchstone::physics::ode_dynamics {
namespace {

using Clock = std::chrono::steady_clock;

/// ODE turns a body by its inverse inertia: a slender rod has none about itself.
constexpr double kThinnest = 1e-6;

/// Contacts of our check that say the same to the bit (corners of a box at rest) tie in pivots of ODE's
/// direct method (Dantzig's), which then breaks down. So ODE gets each this much deeper [m], times 1 to 3.2
/// in turn: the perturbation of Charnes (Cottle, Pang, Stone, The Linear Complementarity Problem, 4.9).
/// Between corners that share a load it shifts some mN (0.2 / h of it against a softness of 1e-10).
constexpr double kTieBreak = 1e-15;

/// So many times deeper, of either check, in a step that is taken again: what ties there ties in softer
/// contacts, too. By ODE's own check a stack of 20 breaks down in its fourth step in all of kSofter without.
constexpr double kWiderTies = 100.0;

/// Where ODE's direct method breaks down all the same, the step is taken with softer contacts: these shares
/// of the velocity that their impulses give to the lightest body stay. Shares of no more than ODE's usual
/// softness would be the failed step again.
constexpr std::array kSofter = {1e-8, 1e-6, 1e-4, 1e-2};

/// World, space and joint group, as ODE wants them made and destroyed.
struct OdeHandles {
  ode::LibraryUse library;
  dWorldID world = dWorldCreate();
  dSpaceID space = dHashSpaceCreate(nullptr);
  dJointGroupID contacts = dJointGroupCreate(0);

  OdeHandles() { dAllocateODEDataForThread(dAllocateMaskAll); }
  ~OdeHandles() {
    dJointGroupDestroy(contacts);
    dSpaceDestroy(space);
    dWorldDestroy(world);
  }
  OdeHandles(const OdeHandles&) = delete;
  OdeHandles& operator=(const OdeHandles&) = delete;
};

Vector3 vector_of(const dReal* v) { return {v[0], v[1], v[2]}; }

dMass mass_of(const EngineScene::Body& body) {
  const double least = kThinnest * std::max({body.moments.x(), body.moments.y(), body.moments.z()});
  dMass mass;
  dMassSetParameters(&mass, body.mass, 0, 0, 0, std::max(least, body.moments.x()),
                     std::max(least, body.moments.y()), std::max(least, body.moments.z()), 0, 0, 0);
  return mass;
}

thread_local int messages = 0;

/// @return whether ODE had nothing to say: its direct method goes on with forces of no meaning where it
/// fails.
bool step_directly(dWorldID world, double h) {
  messages = 0;
  dMessageFunction* const before = dGetMessageHandler();
  dSetMessageHandler([](int, const char*, va_list) { ++messages; });
  dWorldStep(world, h);
  dSetMessageHandler(before);
  return messages == 0;
}

class OdeEngine final : public SceneEngine {
 public:
  OdeEngine(const DynamicScene& scene, const WorldOptions& options) : SceneEngine(scene), options_(options) {
    dWorldSetGravity(ode_.world, scene.gravity_W.x(), scene.gravity_W.y(), scene.gravity_W.z());
    dWorldSetAutoDisableFlag(ode_.world, 0);
    if (scene.push_out > 0.0) dWorldSetContactMaxCorrectingVel(ode_.world, scene.part_speed);
    for (const EngineScene::Body& body : bodies().bodies()) add(body);
    for (SolidIndex s = 0; s < bodies().solids().size(); ++s) add_solid(s);
    for (const EngineScene::Joint& joint : bodies().joints())
      joints_.emplace_back(ode_.world, joint, bodies_[joint.child],
                           joint.parent == EngineScene::kNone ? nullptr : bodies_[joint.parent]);
    const auto body = [&](std::size_t b) { return b == EngineScene::kNone ? nullptr : bodies_[b]; };
    for (const EngineScene::BodyJoint& joint : bodies().body_joints())
      body_joints_.emplace_back(ode_.world, joint, body(joint.child), body(joint.parent));
    latches_.resize(bodies_.size());
    before_.reserve(bodies_.size());
    start();
    keep_start();
  }

  EngineReturn after_restore() const override { return EngineReturn::same_bits; }

  void list_contacts(std::vector<EngineContact>& contacts) const override {
    contacts.clear();
    for (std::size_t i = 0; i < point_count_; ++i) contacts.push_back(contact(points_[i]));
  }

 protected:
  void apply(std::size_t body, const Vector3& force_W, const Vector3& moment_W) override {
    dBodyAddForce(bodies_[body], force_W.x(), force_W.y(), force_W.z());
    dBodyAddTorque(bodies_[body], moment_W.x(), moment_W.y(), moment_W.z());
  }

  void advance(EngineStep& step) override {
    for (std::size_t b = 0; b < bodies_.size(); ++b) {
      if (bodies().bodies()[b].kind != ContactSide::kinematic) continue;
      const State& to = target(b);
      dBodySetLinearVel(bodies_[b], to.v_W.x(), to.v_W.y(), to.v_W.z());
      dBodySetAngularVel(bodies_[b], to.w_W.x(), to.w_W.y(), to.w_W.z());
    }
    for_each_axis([](OdeJoint& joint) { joint.apply(); });
    find_contacts(step);
    if (!options_.is_direct) {
      // Its order of sweeps is drawn by chance, from one row of numbers for the process: each engine has its
      // own, and engines on other threads wait.
      static std::mutex row;
      const std::scoped_lock lock(row);
      dRandSetSeed(seed_);
      dWorldQuickStep(ode_.world, step_size());
      seed_ = dRandGetSeed();
    } else if (!step_or_soften(step)) {
      step.failure = "ODE: its direct method met contacts that it cannot solve (LCP internal error)";
      point_count_ = 0;
    }
    dJointGroupEmpty(ode_.contacts);
    for (std::size_t b = 0; b < bodies_.size(); ++b)  // without what its integration rounds
      if (bodies().bodies()[b].kind == ContactSide::kinematic) place(bodies_[b], target(b).X_WB);
    for_each_axis([](OdeJoint& joint) { joint.read(); });
  }

  State read_state(std::size_t body) const override {
    const dBodyID from = bodies_[body];
    State out;
    const dReal* const R = dBodyGetRotation(from);
    for (int i = 0; i < 3; ++i)
      for (int k = 0; k < 3; ++k) out.X_WB.R(i, k) = R[4 * i + k];
    out.X_WB.p = vector_of(dBodyGetPosition(from));
    out.v_W = vector_of(dBodyGetLinearVel(from));
    out.w_W = vector_of(dBodyGetAngularVel(from));
    return out;
  }

  JointState read_joint(std::size_t joint) const override {
    const OdeJoint* const from = axis_of(joint);
    return from == nullptr ? JointState{} : JointState{from->value(), from->rate(), from->torque()};
  }
  void set_drive(std::size_t joint, const JointDrive& drive) override {
    if (joint < joints_.size())
      joints_[joint].set_drive(drive);
    else if (OdeJoint* const axis = body_joints_[joint - joints_.size()].axis())
      axis->set_drive(drive);
  }
  void switch_joint(std::size_t body_joint, bool is_on) override {
    body_joints_[body_joint].switch_to(is_on);
  }
  void latch(std::size_t carrier, std::size_t carried) override {
    Latch& latch = latches_[carried];
    latch = {dJointCreateFixed(ode_.world, nullptr), ++latchings_, carrier, bits_of(bodies_[carried]), {}};
    if (bodies_[carrier] != nullptr) latch.carrier_at = bits_of(bodies_[carrier]);
    dJointAttach(latch.joint, bodies_[carried], bodies_[carrier]);
    dJointSetFixed(latch.joint);
  }
  void release(std::size_t carried) override {
    dJointDestroy(latches_[carried].joint);
    latches_[carried] = {};
  }
  void take_body(std::size_t body) override {
    dBodySetLinearVel(bodies_[body], 0, 0, 0);
    dBodySetAngularVel(bodies_[body], 0, 0, 0);
    enable(body, false);
  }
  void put_body(std::size_t body, const State& at) override {
    place(bodies_[body], at.X_WB);
    dBodySetLinearVel(bodies_[body], at.v_W.x(), at.v_W.y(), at.v_W.z());
    dBodySetAngularVel(bodies_[body], at.w_W.x(), at.w_W.y(), at.w_W.z());
    enable(body, true);
  }

  std::unique_ptr<EngineSnapshot> save() const override {
    auto out = std::make_unique<Saved>();
    for (const dBodyID body : bodies_) out->bodies.push_back(body == nullptr ? BodyBits{} : bits_of(body));
    for (int i = 0; i < dSpaceGetNumGeoms(ode_.space); ++i)
      out->geoms.push_back(dSpaceGetGeom(ode_.space, i));
    out->latches = latches_;
    for (const OdeBodyJoint& joint : body_joints_) out->placings.push_back(joint.placing());
    for (std::size_t j = 0; j < joints_.size() + body_joints_.size(); ++j) {
      const OdeJoint* const axis = any_axis(j);
      out->counts.push_back(axis == nullptr ? OdeJoint::Count{} : axis->count());
    }
    out->seed = seed_;
    return out;
  }

  void load(const EngineSnapshot& saved) override {
    const auto& from = static_cast<const Saved&>(saved);
    for (std::size_t j = 0; j < body_joints_.size(); ++j) body_joints_[j].place_again(from.placings[j]);
    for (std::size_t b = 0; b < latches_.size(); ++b) latch_again(b, from.latches[b]);
    for (std::size_t b = 0; b < bodies_.size(); ++b) {
      if (bodies_[b] == nullptr) continue;
      set_bits(bodies_[b], from.bodies[b]);
      dBodySetForce(bodies_[b], 0, 0, 0);
      dBodySetTorque(bodies_[b], 0, 0, 0);
      if (bodies().bodies()[b].kind == ContactSide::body) enable(b, !is_out(b));
    }
    for (std::size_t j = 0; j < from.counts.size(); ++j)
      if (OdeJoint* const axis = any_axis(j)) axis->set_count(from.counts[j]);
    // Pairs come in the order of the space's list, where what moved last stands first.
    for (auto geom = from.geoms.rbegin(); geom != from.geoms.rend(); ++geom) {
      dSpaceRemove(ode_.space, *geom);
      dSpaceAdd(ode_.space, *geom);
    }
    seed_ = from.seed;
    point_count_ = 0;
  }

 private:
  /// A body that another carries: by a fixed joint, made as the two stood.
  struct Latch {
    dJointID joint = nullptr;
    std::uint64_t number = 0;  ///< counts latchings
    std::size_t carrier = 0;
    BodyBits carried_at{}, carrier_at{};
  };
  struct Saved final : EngineSnapshot {
    std::vector<BodyBits> bodies;
    std::vector<dGeomID> geoms;
    std::vector<Latch> latches;
    std::vector<OdeBodyJoint::Placing> placings;
    std::vector<OdeJoint::Count> counts;
    unsigned long seed = 0;
  };

  void latch_again(std::size_t carried, const Latch& as) {
    if (latches_[carried].number == as.number) return;
    if (latches_[carried].joint != nullptr) release(carried);
    if (as.joint == nullptr) return;
    set_bits(bodies_[carried], as.carried_at);
    if (bodies_[as.carrier] != nullptr) set_bits(bodies_[as.carrier], as.carrier_at);
    latch(as.carrier, carried);
    latches_[carried].number = as.number;
  }

  /// A body before a step, with the forces on it, which ODE forgets as it steps.
  struct Before {
    BodyBits bits;
    Vector3 force, torque;
  };

  /// By the direct method; where it breaks down, from the same state with softer contacts: kSofter.
  bool step_or_soften(EngineStep& step) {
    before_.clear();
    for (const dBodyID body : bodies_)
      if (body != nullptr)
        before_.push_back({bits_of(body), vector_of(dBodyGetForce(body)), vector_of(dBodyGetTorque(body))});
    if (step_directly(ode_.world, step_size())) return true;
    ++step.unconverged;
    // The shares of kSofter become ODE's softness by the lightest body: its row has the most.
    double least = kInfinity;
    for (const EngineScene::Body& body : bodies().bodies())
      if (body.mass > 0.0) least = std::min(least, body.mass);
    for (const double share : kSofter) {
      const double softness = share * step_size() / least;
      if (softness <= dWorldGetCFM(ode_.world)) continue;
      put_back();
      soften_contacts(softness);
      if (step_directly(ode_.world, step_size())) return true;
    }
    return false;
  }

  /// Makes the step's contacts anew, with this softness of all of their rows, and without ties. The world's
  /// own would be that of hinges and sliders, too: an arm would let go of what it holds beside a heap of
  /// light bodies.
  void soften_contacts(double softness) {
    dJointGroupEmpty(ode_.contacts);
    for (std::size_t i = 0; i < point_count_; ++i) {
      points_[i].contact.geom.depth = points_[i].depth + kWiderTies * tie_break(i);
      dSurfaceParameters& surface = points_[i].contact.surface;
      surface.mode |= dContactSoftCFM | dContactSlip1 | dContactSlip2;
      surface.soft_cfm = surface.slip1 = surface.slip2 = softness;
      join(points_[i]);
    }
  }

  static double tie_break(std::size_t point) {
    return kTieBreak * (1.0 + 0.37 * static_cast<double>(point % 7));
  }

  void put_back() {
    auto from = before_.begin();
    for (const dBodyID body : bodies_) {
      if (body == nullptr) continue;
      set_bits(body, from->bits);
      dBodySetForce(body, from->force.x(), from->force.y(), from->force.z());
      dBodySetTorque(body, from->torque.x(), from->torque.y(), from->torque.z());
      ++from;
    }
  }

  /// In the world, or out of it.
  void enable(std::size_t body, bool is_in) {
    is_in ? dBodyEnable(bodies_[body]) : dBodyDisable(bodies_[body]);
    for (dGeomID geom = dBodyGetFirstGeom(bodies_[body]); geom != nullptr; geom = dBodyGetNextGeom(geom))
      is_in ? dGeomEnable(geom) : dGeomDisable(geom);
  }

  /// A contact of the step, with what its joint did.
  struct Point {
    SolidPair solids;
    dBodyID first, second;  ///< null: of the ground. Where `first` is, ODE has `second` first
    Vector3 p_W, n_W;       ///< ODE's normal: from the second to the first
    double depth;
    dContact contact;  ///< as ODE gets it
    dJointFeedback feedback;
  };

  void join(Point& point) {
    const dJointID joint = dJointCreateContact(ode_.world, ode_.contacts, &point.contact);
    dJointAttach(joint, point.first, point.second);
    dJointSetFeedback(joint, &point.feedback);
  }

  /// Those that hold.
  template <class Action>
  void for_each_axis(const Action& action) {
    for (OdeJoint& joint : joints_) action(joint);
    for (OdeBodyJoint& joint : body_joints_)
      if (OdeJoint* const axis = joint.axis(); axis != nullptr && joint.is_on()) action(*axis);
  }
  const OdeJoint* axis_of(std::size_t joint) const {
    if (joint < joints_.size()) return &joints_[joint];
    const OdeBodyJoint& of_bodies = body_joints_[joint - joints_.size()];
    return of_bodies.is_on() ? of_bodies.axis() : nullptr;
  }

  const OdeJoint* any_axis(std::size_t joint) const {
    return joint < joints_.size() ? &joints_[joint] : body_joints_[joint - joints_.size()].axis();
  }
  OdeJoint* any_axis(std::size_t joint) {
    return joint < joints_.size() ? &joints_[joint] : body_joints_[joint - joints_.size()].axis();
  }

  static void place(dBodyID body, const Pose& X) {
    const ode::Rotation R(X.R);
    dBodySetPosition(body, X.p.x(), X.p.y(), X.p.z());
    dBodySetRotation(body, R.rows);
  }

  void add(const EngineScene::Body& body) {
    bodies_.push_back(nullptr);
    if (body.kind == ContactSide::ground) return;
    dBodyID& added = bodies_.back();
    added = dBodyCreate(ode_.world);
    if (body.kind == ContactSide::kinematic) {
      dBodySetKinematic(added);
    } else {
      const dMass mass = mass_of(body);
      dBodySetMass(added, &mass);
    }
    place(added, body.X_WB);
    dBodySetLinearVel(added, body.v_W.x(), body.v_W.y(), body.v_W.z());
    dBodySetAngularVel(added, body.w_W.x(), body.w_W.y(), body.w_W.z());
  }

  void add_solid(SolidIndex index) {
    const EngineScene::Solid& solid = bodies().solids()[index];
    dGeomID geom;
    if (options_.is_ours) {
      geom = create_ode_hexahedron(ode_.space, *solid.solid, options_.inside);
    } else {
      const Vector3 sides = 2.0 * solid.solid->half_extents();
      geom = dCreateBox(ode_.space, sides.x(), sides.y(), sides.z());
    }
    dGeomSetData(geom, const_cast<EngineScene::Solid*>(&solid));  // only read, by solid_of()
    const dBodyID body = bodies_[solid.body];
    const Pose& X_BS = solid.X_BS;
    if (body == nullptr) {
      const Pose X_WS = compose(bodies().bodies()[solid.body].X_WB, X_BS);
      const ode::Rotation R(X_WS.R);
      dGeomSetPosition(geom, X_WS.p.x(), X_WS.p.y(), X_WS.p.z());
      dGeomSetRotation(geom, R.rows);
      return;
    }
    dGeomSetBody(geom, body);
    if (X_BS.R == Matrix3::Identity() && X_BS.p == Vector3::Zero()) return;
    const ode::Rotation R(X_BS.R);
    dGeomSetOffsetPosition(geom, X_BS.p.x(), X_BS.p.y(), X_BS.p.z());
    dGeomSetOffsetRotation(geom, R.rows);
  }

  void find_contacts(EngineStep& step) {
    const Clock::time_point start = Clock::now();
    point_count_ = 0;
    const std::uint64_t refused = options_.is_ours ? ode_native_refusals() : 0;
    dSpaceCollide(ode_.space, this, &OdeEngine::meet);
    if (options_.is_ours) step.failed = static_cast<std::uint32_t>(ode_native_refusals() - refused);
    step.contacts = point_count_;
    step.detection_us = std::chrono::duration<double, std::micro>(Clock::now() - start).count();
  }

  static void meet(void* self, dGeomID a, dGeomID b) { static_cast<OdeEngine*>(self)->meet(a, b); }
  SolidIndex solid_of(dGeomID geom) const {
    const auto* const solid = static_cast<const EngineScene::Solid*>(dGeomGetData(geom));
    return static_cast<SolidIndex>(solid - bodies().solids().data());
  }

  void meet(dGeomID a, dGeomID b) {
    // Exempt pairs never get contacts.
    const SolidPair solids{solid_of(a), solid_of(b)};
    if (!is_checked(solids.a, solids.b)) return;
    dContact found[kMaxManifoldPoints];
    const int count = dCollide(a, b, kMaxManifoldPoints, &found[0].geom, sizeof(dContact));
    if (count == 0) return;
    // Friction and restitution are those of the pair of surfaces.
    const double friction = bodies().friction(solids.a, solids.b),
                 restitution = bodies().restitution(solids.a, solids.b);
    const dBodyID body_a = dGeomGetBody(a), body_b = dGeomGetBody(b);
    for (int i = 0; i < count; ++i) {
      dContact& contact = found[i];
      // The friction cone is ODE's pyramid, and slow impacts do not bounce.
      contact.surface.mode = dContactApprox1;
      contact.surface.mu = friction;
      if (restitution > 0.0) {
        contact.surface.mode |= dContactBounce;
        contact.surface.bounce = restitution;
        contact.surface.bounce_vel = scene().bounce_speed;
      }
      // Each point is kept with its forces, so that they can be read after the step.
      if (point_count_ == points_.size()) points_.emplace_back();
      Point& point = points_[point_count_++];
      point.solids = solids;
      point.first = body_a, point.second = body_b;
      point.p_W = vector_of(contact.geom.pos), point.n_W = vector_of(contact.geom.normal);
      point.depth = contact.geom.depth;
      // Depths that differ slightly keep the direct solver from ties.
      if (options_.is_direct && options_.is_ours) contact.geom.depth += tie_break(point_count_);
      point.contact = contact;
      join(point);
    }
  }

  EngineContact contact(const Point& point) const {
    EngineContact out;
    out.solids = point.solids;
    out.separation = -point.depth;
    out.status = PairStatus::overlapping;
    out.p_W = point.p_W;
    out.n_AB_W = -point.n_W;
    const Vector3 on_first = vector_of(point.feedback.f1);
    out.force_W = point.first == nullptr ? on_first : Vector3(-on_first);
    finish_contact(out);
    return out;
  }

  WorldOptions options_;
  OdeHandles ode_;
  std::vector<dBodyID> bodies_;
  std::deque<OdeJoint> joints_;
  std::deque<OdeBodyJoint> body_joints_;
  std::vector<Latch> latches_;  // by body that is carried
  std::uint64_t latchings_ = 0;
  unsigned long seed_ = 0;
  std::vector<Before> before_;  // by body that ODE has
  std::deque<Point> points_;    // stay where they are: ODE writes their feedback
  std::size_t point_count_ = 0;
};

}  // namespace

std::unique_ptr<DynamicsEngine> make_world(const DynamicScene& scene, const WorldOptions& options) {
  return std::make_unique<OdeEngine>(scene, options);
}

}  // namespace touchstone::physics::ode_dynamics
