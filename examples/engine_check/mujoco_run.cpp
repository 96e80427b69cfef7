#include <algorithm>
#include <chrono>
#include <cstdio>
#include <optional>
#include <sstream>
#include <vector>

#include "touchstone/adapters/mujoco/xml_model.hpp"
#include "touchstone/adapters/mujoco_plugin/mujoco_plugin.hpp"
#include "touchstone/examples/engine_check/world.hpp"

namespace touchstone::engine_check {
namespace {

using Clock = std::chrono::steady_clock;

mjtNum microseconds() {
  return std::chrono::duration<double, std::micro>(Clock::now().time_since_epoch()).count();
}

/// MuJoCo times its parts when it is given a clock, one for the process.
class EngineClock {
 public:
  EngineClock() : before_(mjcb_time) { mjcb_time = &microseconds; }
  ~EngineClock() { mjcb_time = before_; }
  EngineClock(const EngineClock&) = delete;
  EngineClock& operator=(const EngineClock&) = delete;

 private:
  mjfTime before_;
};

struct Text {
  std::ostringstream out;

  Text() { out.precision(17); }
  Text& vector(const char* name, const Vector3& v) {
    out << ' ' << name << "=\"" << v.x() << ' ' << v.y() << ' ' << v.z() << '"';
    return *this;
  }
};

void write_body(const World& world, const Body& body, std::size_t i, Text& assets, Text& bodies) {
  mjtNum rotation[9], q[4];
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) rotation[3 * r + c] = body.X_WS.R(r, c);
  mju_mat2Quat(q, rotation);
  bodies.out << "<body";
  bodies.vector("pos", body.X_WS.p).out << " quat=\"" << q[0] << ' ' << q[1] << ' ' << q[2] << ' ' << q[3]
                                        << "\">";
  if (body.mass > 0.0) {
    bodies.out << "<freejoint/><inertial pos=\"0 0 0\" mass=\"" << body.mass << '"';
    bodies.vector("diaginertia", body.inertia).out << "/>";
  }
  bodies.out << "<geom friction=\"" << world.friction << "\"";
  if (body.solid.is_box() && !world.by_hulls) {
    bodies.vector("size", body.solid.half_extents()).out << " type=\"box\"/></body>";
    return;
  }
  assets.out << "<mesh name=\"mesh" << i << "\" vertex=\"";
  for (const Vector3& v : body.solid.vertices()) assets.out << v.x() << ' ' << v.y() << ' ' << v.z() << ' ';
  assets.out << "\"/>";
  bodies.out << " type=\"mesh\" mesh=\"mesh" << i << "\"/></body>";
}

/// Elliptic cones, for the friction that the closed forms are about; several contacts from the engine's own
/// check of hulls, which has one otherwise.
mujoco::ModelHandle model_of(const World& world) {
  Text assets, bodies, model;
  for (std::size_t i = 0; i < world.bodies.size(); ++i) write_body(world, world.bodies[i], i, assets, bodies);
  model.out << "<mujoco><size nconmax=\"1500\" njmax=\"4000\"/><option timestep=\"" << world.step
            << "\" iterations=\"" << kIterations << "\" cone=\"elliptic\"";
  model.vector("gravity", {0, 0, -kGravity}).out << "><flag multiccd=\"enable\"/></option><asset>"
                                                 << assets.out.str() << "</asset><worldbody>"
                                                 << bodies.out.str() << "</worldbody></mujoco>";
  return mujoco::load_model(model.out.str());
}

class MujocoWorld {
 public:
  MujocoWorld(const World& world, Check check, PairObserver* observer)
      : world_(world), model_(model_of(world)), data_(mj_makeData(model_.get())) {
    if (check == Check::native || observer != nullptr) {
      const EngineCheck whose = check == Check::native ? EngineCheck::native : EngineCheck::own;
      override_.emplace(MujocoOverride::Options{.check = whose, .observer = observer});
    }
    for (std::size_t i = 0; i < world.bodies.size(); ++i)
      if (const int dof = first_dof(i); dof >= 0)
        for (int k = 0; k < 3; ++k) data_->qvel[dof + k] = world.bodies[i].velocity[k];
  }

  Outcome run() {
    Tracker tracker(world_);
    StepTimes times(world_.steps);
    const std::size_t last = world_.bodies.size() - 1;
    for (int i = 0; i < world_.steps; ++i) {
      // MuJoCo's own timer tells the check from the rest of the step.
      const mjtNum checked = data_->timer[mjTIMER_POS_COLLISION].duration;
      const auto start = Clock::now();
      mj_step(model_.get(), data_.get());
      const std::chrono::duration<double, std::micro> check(data_->timer[mjTIMER_POS_COLLISION].duration -
                                                            checked);
      times.add(std::chrono::duration_cast<Clock::duration>(check), Clock::now() - start,
                static_cast<std::size_t>(data_->ncon));
      tracker.see_last(position(last));
    }
    Outcome out;
    times.finish(out);
    out.contacts = static_cast<std::size_t>(data_->ncon);
    mj_kinematics(model_.get(), data_.get());  // a step leaves bodies where it began
    // Final poses and velocities are held against those expected.
    for (std::size_t i = 0; i <= last; ++i) {
      Pose X;
      for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c) X.R(r, c) = data_->xmat[9 * body(i) + 3 * r + c];
      X.p = position(i);
      Vector3 v = Vector3::Zero(), w = Vector3::Zero();
      if (const int dof = first_dof(i); dof >= 0)
        for (int k = 0; k < 3; ++k) v[k] = data_->qvel[dof + k], w[k] = data_->qvel[dof + 3 + k];
      tracker.finish(i, X, v, w, out);
    }
    return out;
  }

 private:
  static std::ptrdiff_t body(std::size_t i) { return static_cast<std::ptrdiff_t>(i) + 1; }  // 0 is the world
  int first_dof(std::size_t i) const { return model_->body_dofadr[body(i)]; }
  Vector3 position(std::size_t i) const {
    const mjtNum* p = data_->xpos + 3 * body(i);
    return {p[0], p[1], p[2]};
  }

  const World& world_;
  EngineClock clock_;
  mujoco::ModelHandle model_;
  mujoco::DataHandle data_;
  std::optional<MujocoOverride> override_;
};

}  // namespace

Outcome run_mujoco(const World& world, Check check, PairObserver* observer) {
  // Left alone it writes warnings to a file in the user's working folder.
  mju_user_warning = [](const char* text) { std::fprintf(stderr, "MuJoCo: %s\n", text); };
  return MujocoWorld(world, check, observer).run();
}

}  // namespace touchstone::engine_check
