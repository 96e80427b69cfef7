#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "touchstone/contact_core/geometry/vector.hpp"

/// @file
/// Scenes of boxes that are hard for dynamics, as plain data, and the engines that step them.

namespace touchstone::benchmarks {

/// A box of any kind; free ones are cubes, so that their inertia has no direction.
struct SceneBox {
  enum class Kind : std::uint8_t { free, fixed, driven };
  Kind kind = Kind::free;
  Vector3 size = {0.2, 0.2, 0.2};     ///< [m]
  Vector3 p_W = Vector3::Zero();      ///< of its centre [m]
  Vector3 turn_W = Vector3::Zero();   ///< from the world's axes [rad]
  Vector3 v_W = Vector3::Zero();      ///< at the start; driven: always [m/s]
  Vector3 w_W = Vector3::Zero();      ///< driven: always [rad/s]
  Vector3 force_W = Vector3::Zero();  ///< free: always, at its centre [N]
  double mass = 1.0;                  ///< [kg]
};

struct BoxScene {
  std::string name;
  std::vector<SceneBox> boxes;
  double step = 1e-3;    ///< [s]
  double seconds = 1.0;  ///< how long it runs
  double friction = 0.5;
  bool sleeps = false;     ///< engines may put bodies to sleep
  bool is_placed = false;  ///< boxes are to stay where they start
};

/// Every scene there is, those that are drawn by this seed.
std::vector<BoxScene> box_scenes(unsigned drawn_seed);

/// How a box moves.
struct BoxMotion {
  Vector3 p_W, v_W, w_W;
};

/// One engine's copy of a scene: boxes are counted as in the scene.
class BoxEngine {
 public:
  BoxEngine() = default;
  BoxEngine(const BoxEngine&) = delete;
  BoxEngine& operator=(const BoxEngine&) = delete;
  virtual ~BoxEngine() = default;
  virtual const char* name() const = 0;
  /// Finds contacts and steps; the time of both is measured.
  virtual void step() = 0;
  virtual BoxMotion motion(std::size_t box) const = 0;
  /// Contact points of the last step, those among them that its check lists before solids touch.
  virtual std::size_t points() const = 0;
  /// Remarks on the steps so far, in the engine's words; may be empty.
  virtual std::string remarks() const { return {}; }
  /// Remarks on one step, counted from 0; may be empty.
  virtual std::string remarks_on(std::size_t) const { return {}; }
};

/// @param work DynamicsWorld::Settings::work; 0: as it is.
std::unique_ptr<BoxEngine> make_own(const BoxScene& scene, double work = 0.0);
std::unique_ptr<BoxEngine> make_bullet(const BoxScene& scene);  ///< nullptr: not built in
std::unique_ptr<BoxEngine> make_ode(const BoxScene& scene);
std::unique_ptr<BoxEngine> make_mujoco(const BoxScene& scene);

}  // namespace touchstone::benchmarks
