#include <ode/ode.h>

#include <array>
#include <chrono>
#include <optional>
#include <vector>

#include "touchstone/adapters/ode/convex_data.hpp"
#include "touchstone/adapters/ode_plugin/ode_plugin.hpp"
#include "touchstone/examples/engine_check/world.hpp"

namespace touchstone::engine_check {
namespace {

using Clock = std::chrono::steady_clock;
constexpr int kMostContacts = 8;

class Library {
 public:
  Library() {
    dInitODE2(0);
    dAllocateODEDataForThread(dAllocateMaskAll);
  }
  ~Library() { dCloseODE(); }
  Library(const Library&) = delete;
  Library& operator=(const Library&) = delete;
};

class OdeWorld {
 public:
  OdeWorld(const World& world, Check check, PairObserver* observer) : world_(world), check_(check) {
    if (check == Check::native || observer != nullptr) {
      const EngineCheck whose = check == Check::native ? EngineCheck::native : EngineCheck::own;
      override_.emplace(OdeBoxOverride::Options{.check = whose, .observer = observer});
    }
    dRandSetSeed(world.seed);  // else drawn on from run to run
    dWorldSetGravity(dynamics_, 0, 0, -kGravity);
    dWorldSetQuickStepNumIterations(dynamics_, kIterations);
    convexes_.reserve(world.bodies.size());
    for (const Body& body : world.bodies) add(body);
  }
  ~OdeWorld() {
    dJointGroupDestroy(joints_);
    dSpaceDestroy(space_);
    dWorldDestroy(dynamics_);
  }
  OdeWorld(const OdeWorld&) = delete;
  OdeWorld& operator=(const OdeWorld&) = delete;

  Outcome run() {
    Tracker tracker(world_);
    StepTimes times(world_.steps);
    for (int i = 0; i < world_.steps; ++i) {
      contacts_ = 0;
      // Check and step are timed apart.
      const auto start = Clock::now();
      dSpaceCollide(space_, this, &collide);
      const auto checked = Clock::now();
      dWorldQuickStep(dynamics_, world_.step);
      times.add(checked - start, Clock::now() - start, contacts_);
      // Contact joints last one step.
      dJointGroupEmpty(joints_);
      tracker.see_last(pose(geoms_.back()).p);
    }
    Outcome out;
    times.finish(out);
    out.contacts = contacts_;
    // Geometries without a body stand still.
    for (std::size_t i = 0; i < geoms_.size(); ++i) {
      Vector3 v = Vector3::Zero(), w = Vector3::Zero();
      if (const dBodyID body = dGeomGetBody(geoms_[i])) {
        const dReal *linear = dBodyGetLinearVel(body), *angular = dBodyGetAngularVel(body);
        v = {linear[0], linear[1], linear[2]};
        w = {angular[0], angular[1], angular[2]};
      }
      tracker.finish(i, pose(geoms_[i]), v, w, out);
    }
    return out;
  }

 private:
  static Pose pose(dGeomID geom) {
    const dReal *R = dGeomGetRotation(geom), *p = dGeomGetPosition(geom);
    Pose X;
    X.R << R[0], R[1], R[2], R[4], R[5], R[6], R[8], R[9], R[10];
    X.p = {p[0], p[1], p[2]};
    return X;
  }

  dGeomID make_geom(const Body& body) {
    const Hexahedron& solid = body.solid;
    const Vector3 side = 2.0 * solid.half_extents();
    if (solid.is_box() && !world_.by_hulls) return dCreateBox(space_, side.x(), side.y(), side.z());
    if (check_ == Check::native) return create_ode_hexahedron(space_, solid);
    const ode::ConvexData& data = convexes_.emplace_back(solid);
    return dCreateConvex(space_, data.planes.data(), 6, data.points.data(), 8, ode::kConvexPolygons.data());
  }

  void add(const Body& body) {
    const dGeomID geom = make_geom(body);
    geoms_.push_back(geom);
    const Matrix3& R = body.X_WS.R;
    const dMatrix3 rows = {R(0, 0), R(0, 1), R(0, 2), 0,       R(1, 0), R(1, 1),
                           R(1, 2), 0,       R(2, 0), R(2, 1), R(2, 2), 0};
    if (body.mass > 0.0) {
      const dBodyID id = dBodyCreate(dynamics_);
      dMass mass;
      dMassSetParameters(&mass, body.mass, 0, 0, 0, body.inertia.x(), body.inertia.y(), body.inertia.z(), 0,
                         0, 0);
      dBodySetMass(id, &mass);
      dGeomSetBody(geom, id);
      dBodySetLinearVel(id, body.velocity.x(), body.velocity.y(), body.velocity.z());
    }
    dGeomSetPosition(geom, body.X_WS.p.x(), body.X_WS.p.y(), body.X_WS.p.z());
    dGeomSetRotation(geom, rows);
  }

  static void collide(void* data, dGeomID geom1, dGeomID geom2) {
    OdeWorld& world = *static_cast<OdeWorld*>(data);
    const dBodyID body1 = dGeomGetBody(geom1), body2 = dGeomGetBody(geom2);
    if (body1 == nullptr && body2 == nullptr) return;
    std::array<dContact, kMostContacts> contacts;
    const int count = dCollide(geom1, geom2, kMostContacts, &contacts[0].geom, sizeof(dContact));
    world.contacts_ += static_cast<std::size_t>(count);
    for (int i = 0; i < count; ++i) {
      contacts[i].surface.mode = dContactApprox1;
      contacts[i].surface.mu = world.world_.friction;
      dJointAttach(dJointCreateContact(world.dynamics_, world.joints_, &contacts[i]), body1, body2);
    }
  }

  const World& world_;
  Check check_;
  Library library_;
  std::optional<OdeBoxOverride> override_;
  std::vector<ode::ConvexData> convexes_;
  dWorldID dynamics_ = dWorldCreate();
  dSpaceID space_ = dSweepAndPruneSpaceCreate(nullptr, dSAP_AXES_XYZ);
  dJointGroupID joints_ = dJointGroupCreate(0);
  std::vector<dGeomID> geoms_;
  std::size_t contacts_ = 0;
};

}  // namespace

Outcome run_ode(const World& world, Check check, PairObserver* observer) {
  return OdeWorld(world, check, observer).run();
}

}  // namespace touchstone::engine_check
