#include "touchstone/tests/benchmarks/dynamics/dynamics_scenes.hpp"

#ifdef TOUCHSTONE_BENCHMARK_ODE_DYNAMICS
#include <ode/ode.h>
#endif

namespace touchstone::benchmarks {

#ifdef TOUCHSTONE_BENCHMARK_ODE_DYNAMICS
namespace {

constexpr int kMostPoints = 8;

/// With its own check and dWorldQuickStep(), default error reduction and softness.
class Ode final : public BoxEngine {
 public:
  explicit Ode(const BoxScene& scene) : step_(scene.step), friction_(scene.friction) {
    dInitODE2(0);
    world_ = dWorldCreate();
    space_ = dHashSpaceCreate(nullptr);
    contacts_ = dJointGroupCreate(0);
    dWorldSetGravity(world_, 0, 0, -9.81);
    dWorldSetAutoDisableFlag(world_, scene.sleeps ? 1 : 0);
    for (const SceneBox& box : scene.boxes) add(box);
  }
  Ode(const Ode&) = delete;
  Ode& operator=(const Ode&) = delete;
  ~Ode() override {
    dJointGroupDestroy(contacts_);
    dSpaceDestroy(space_);
    dWorldDestroy(world_);
    dCloseODE();
  }
  const char* name() const override { return "ODE"; }
  void step() override {
    for (std::size_t i = 0; i < forces_.size(); ++i)
      if (bodies_[i] != nullptr) dBodyAddForce(bodies_[i], forces_[i].x(), forces_[i].y(), forces_[i].z());
    points_ = 0;
    dSpaceCollide(space_, this, &Ode::meet);
    dWorldQuickStep(world_, step_);
    dJointGroupEmpty(contacts_);
  }
  BoxMotion motion(std::size_t box) const override {
    const dBodyID body = bodies_[box];
    if (body == nullptr) return {Vector3::Zero(), Vector3::Zero(), Vector3::Zero()};
    const auto vector = [](const dReal* v) { return Vector3(v[0], v[1], v[2]); };
    return {vector(dBodyGetPosition(body)), vector(dBodyGetLinearVel(body)),
            vector(dBodyGetAngularVel(body))};
  }
  std::size_t points() const override { return points_; }

 private:
  void add(const SceneBox& box) {
    const dGeomID geom = dCreateBox(space_, box.size.x(), box.size.y(), box.size.z());
    dBodyID body = nullptr;
    if (box.kind != SceneBox::Kind::fixed) {
      body = dBodyCreate(world_);
      dMass mass;
      dMassSetBoxTotal(&mass, box.mass, box.size.x(), box.size.y(), box.size.z());
      dBodySetMass(body, &mass);
      dGeomSetBody(geom, body);
      dBodySetLinearVel(body, box.v_W.x(), box.v_W.y(), box.v_W.z());
      dBodySetAngularVel(body, box.w_W.x(), box.w_W.y(), box.w_W.z());
      if (box.kind == SceneBox::Kind::driven) dBodySetKinematic(body);
    }
    bodies_.push_back(body);
    forces_.push_back(box.force_W);
    dGeomSetPosition(geom, box.p_W.x(), box.p_W.y(), box.p_W.z());
    const double angle = norm(box.turn_W);
    if (!(angle > 0.0)) return;
    dMatrix3 R;
    dRFromAxisAndAngle(R, box.turn_W.x(), box.turn_W.y(), box.turn_W.z(), angle);
    dGeomSetRotation(geom, R);
  }
  static void meet(void* self, dGeomID a, dGeomID b) { static_cast<Ode*>(self)->meet(a, b); }
  void meet(dGeomID a, dGeomID b) {
    const dBodyID body_a = dGeomGetBody(a), body_b = dGeomGetBody(b);
    const auto is_commanded = [](dBodyID body) { return body == nullptr || dBodyIsKinematic(body) != 0; };
    if (is_commanded(body_a) && is_commanded(body_b)) return;
    dContact points[kMostPoints];
    const int count = dCollide(a, b, kMostPoints, &points[0].geom, sizeof(dContact));
    points_ += static_cast<std::size_t>(count);
    for (int i = 0; i < count; ++i) {
      points[i].surface.mode = dContactApprox1;
      points[i].surface.mu = friction_;
      dJointAttach(dJointCreateContact(world_, contacts_, &points[i]), body_a, body_b);
    }
  }

  double step_, friction_;
  std::size_t points_ = 0;
  dWorldID world_;
  dSpaceID space_;
  dJointGroupID contacts_;
  std::vector<dBodyID> bodies_;
  std::vector<Vector3> forces_;
};

}  // namespace

std::unique_ptr<BoxEngine> make_ode(const BoxScene& scene) { return std::make_unique<Ode>(scene); }
#else
std::unique_ptr<BoxEngine> make_ode(const BoxScene&) { return nullptr; }
#endif

}  // namespace touchstone::benchmarks
