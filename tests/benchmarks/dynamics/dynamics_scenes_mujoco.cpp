#include "touchstone/tests/benchmarks/dynamics/dynamics_scenes.hpp"

#ifdef TOUCHSTONE_BENCHMARK_MUJOCO
#include <mujoco/mujoco.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <stdexcept>
#endif

namespace touchstone::benchmarks {

#ifdef TOUCHSTONE_BENCHMARK_MUJOCO
namespace {

/// Tables of constraints, which MuJoCo 2.2 allocates whole and whose bytes it counts in an int.
std::string size_of(const BoxScene& scene) {
  constexpr double kMostBytes = 1.9e9;
  double moving = 0.0;
  for (const SceneBox& box : scene.boxes) moving += box.kind == SceneBox::Kind::free ? 1.0 : 0.0;
  for (double a_body = 24.0; a_body >= 5.0; a_body -= 1.0) {
    const double contacts = a_body * moving + 200.0, rows = 3.0 * contacts;
    if (24.0 * rows * 6.0 * moving + 12.0 * rows * rows > kMostBytes) continue;
    return "<size njmax='" + std::to_string(static_cast<int>(rows)) + "' nconmax='" +
           std::to_string(static_cast<int>(contacts)) + "'/>";
  }
  throw std::runtime_error("its constraint tables take no more than 2 GB");
}

std::string text_of(const BoxScene& scene) {
  std::ostringstream xml;
  xml.precision(17);
  xml << "<mujoco><option gravity='0 0 -9.81' timestep='" << scene.step << "' cone='elliptic'/>"
      << size_of(scene) << "<worldbody>";
  for (const SceneBox& box : scene.boxes) {
    const double angle = norm(box.turn_W);
    const Vector3 axis = angle > 0.0 ? Vector3(box.turn_W / angle) : Vector3(Vector3::UnitX());
    xml << "<body pos='" << box.p_W.x() << ' ' << box.p_W.y() << ' ' << box.p_W.z() << "' axisangle='"
        << axis.x() << ' ' << axis.y() << ' ' << axis.z() << ' ' << angle * 57.29577951308232 << "'"
        << (box.kind == SceneBox::Kind::driven ? " mocap='true'>" : ">")
        << (box.kind == SceneBox::Kind::free ? "<freejoint/>" : "") << "<geom type='box' size='"
        << 0.5 * box.size.x() << ' ' << 0.5 * box.size.y() << ' ' << 0.5 * box.size.z() << "' mass='"
        << box.mass << "' friction='" << scene.friction << " 0 0'/></body>";
  }
  xml << "</worldbody></mujoco>";
  return xml.str();
}

/// With its own check and Newton's method on its convex, soft contacts.
class MuJoCo final : public BoxEngine {
 public:
  explicit MuJoCo(const BoxScene& scene) : scene_(&scene) {
    std::string path = "/tmp/dynamics_scene_XXXXXX";
    const int file = mkstemp(path.data());
    if (file < 0) throw std::runtime_error("no temporary file");
    close(file);
    std::ofstream(path) << text_of(scene);
    char error[500] = "";
    model_ = mj_loadXML(path.c_str(), nullptr, error, sizeof(error));
    std::remove(path.c_str());
    if (model_ == nullptr) throw std::runtime_error(error);
    data_ = mj_makeData(model_);
    if (data_ == nullptr) throw std::runtime_error("could not create mjData");
    int v = 0, mocap = 0;
    for (const SceneBox& box : scene.boxes) {
      first_v_.push_back(box.kind == SceneBox::Kind::free ? v : -1);
      mocap_.push_back(box.kind == SceneBox::Kind::driven ? mocap++ : -1);
      if (box.kind != SceneBox::Kind::free) continue;
      for (int i = 0; i < 3; ++i) data_->qvel[v + i] = box.v_W[i];
      v += 6;
    }
  }
  MuJoCo(const MuJoCo&) = delete;
  MuJoCo& operator=(const MuJoCo&) = delete;
  ~MuJoCo() override {
    mj_deleteData(data_);
    mj_deleteModel(model_);
  }
  const char* name() const override { return "MuJoCo"; }
  std::size_t points() const override { return static_cast<std::size_t>(data_->ncon); }
  void step() override {
    for (std::size_t i = 0; i < mocap_.size(); ++i) {
      const SceneBox& box = scene_->boxes[i];
      const auto body = static_cast<std::ptrdiff_t>(i) + 1;  // the world is the first
      for (int k = 0; k < 3 && mocap_[i] < 0; ++k) data_->xfrc_applied[6 * body + k] = box.force_W[k];
      for (int k = 0; k < 3 && mocap_[i] >= 0; ++k)
        data_->mocap_pos[3 * mocap_[i] + k] += scene_->step * box.v_W[k];
      if (mocap_[i] >= 0) turn(box.w_W, data_->mocap_quat + static_cast<std::ptrdiff_t>(4) * mocap_[i]);
    }
    mj_step(model_, data_);
  }
  BoxMotion motion(std::size_t box) const override {
    BoxMotion out{Vector3::Zero(), Vector3::Zero(), Vector3::Zero()};
    if (first_v_[box] < 0) return out;
    const mjtNum* const q = data_->qpos + first_v_[box] / 6 * 7;
    const mjtNum* const v = data_->qvel + first_v_[box];
    for (int i = 0; i < 3; ++i) out.p_W[i] = q[i], out.v_W[i] = v[i], out.w_W[i] = v[3 + i];
    return out;  // w in the body's axes: for cubes only its length counts
  }

 private:
  void turn(const Vector3& w_W, mjtNum* quaternion) const {
    const double rate = norm(w_W);
    if (!(rate > 0.0)) return;
    const mjtNum axis[3] = {w_W.x() / rate, w_W.y() / rate, w_W.z() / rate};
    const mjtNum before[4] = {quaternion[0], quaternion[1], quaternion[2], quaternion[3]};
    mjtNum by[4];
    mju_axisAngle2Quat(by, axis, rate * scene_->step);
    mju_mulQuat(quaternion, by, before);
  }

  const BoxScene* scene_;
  mjModel* model_;
  mjData* data_;
  std::vector<int> first_v_, mocap_;
};

}  // namespace

std::unique_ptr<BoxEngine> make_mujoco(const BoxScene& scene) { return std::make_unique<MuJoCo>(scene); }
#else
std::unique_ptr<BoxEngine> make_mujoco(const BoxScene&) { return nullptr; }
#endif

}  // namespace touchstone::benchmarks
