#pragma once

#include <chrono>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "touchstone/contact_core/geometry/hexahedron.hpp"
#include "touchstone/contact_core/geometry/pose.hpp"
#include "touchstone/contact_core/narrowphase/pair_observer.hpp"
#include "touchstone/examples/measures/pairs/written_block.hpp"

// Small dynamic scenes with closed-form answers, as plain data that any engine can be given. SI units;
// gravity along -z.

namespace touchstone::engine_check {

inline constexpr double kGravity = 9.81;  ///< [m/s2]

struct Body {
  Hexahedron solid;  ///< its centre of mass is its frame's origin
  Pose X_WS;
  double mass = 0.0;                   ///< [kg]; 0: fixed
  Vector3 inertia = Vector3::Zero();   ///< principal moments about the frame's axes [kg m2]
  Vector3 velocity = Vector3::Zero();  ///< of the centre of mass, at the start [m/s]
};

struct World {
  std::string name;
  std::vector<Body> bodies;
  double friction = 0.5;
  double step = 1.0 / 60.0;  ///< [s]
  int steps = 600;
  /// Where the last body's centre of mass is at the end. Empty: no closed form that is exact.
  std::optional<Vector3> end = std::nullopt;
  unsigned seed = 0;        ///< of what an engine's solver draws (ODE the order of its constraints)
  bool by_hulls = false;    ///< boxes are given to the engine as hulls of 8 points
  bool ode_aborts = false;  ///< ODE ends the process (an assertion) with its own check, 0.16.2
};

/// A stack of `count` unit boxes on a slab. Nothing moves.
World stack(int count, bool by_hulls);
/// A stack of unit cubes given as hulls, each turned in a frame of its own, in which its corners are written.
/// Each stands 1 mm deep in the one below, as its exact faces have it.
World written_stack(int count, Written how);
/// A stack of frusta, every second one upside down. Nothing moves.
World frustum_stack(int count);
/// A brick wall of `rows` rows. Nothing moves.
World wall(int rows, bool by_hulls);
/// A box slides over a row of fixed boxes whose tops are flush. Where it stops is that of steps which take mu
/// g dt off the speed and then move by it, as all three engines integrate: v dt / 2 short of v^2 / (2 mu g).
World seams(bool by_hulls);
/// A tall box leans over its edge by `share` of the angle at which it tips. Below 1 it comes back to where
/// it stands upright (rocking, so no closed form in y), above 1 it falls.
World toppling(double share);
/// The same world with each body that moves put up to 0.1 mm aside along x and y: of a sway that grows from
/// rounding one start shows nothing. The solver draws by `start`, too. Start 0 is the world itself.
World shifted(World world, unsigned start);

/// The steps of a run that had this many contacts.
struct StepsWith {
  std::size_t steps = 0;
  double step_us = 0.0;  ///< median [us]
};

/// The upper one of an even number. @pre not empty.
double median(std::vector<double> values);

/// The outcome of a world.
struct Outcome {
  Vector3 end = Vector3::Zero();  ///< of the last body's centre of mass [m]
  double lean = 0.0;              ///< of the last body's z axis against the world's [rad]
  double drift = 0.0;             ///< largest displacement of a body along x and y [m]
  double rise = 0.0;              ///< largest |z - z at the start| of the last body over the run [m]
  double speed = 0.0;             ///< largest of any body's at the end [m/s]
  double turn = 0.0;              ///< largest angular speed of any body at the end [rad/s]
  double check_us = 0.0;          ///< the engine's collision detection, median of the steps [us]
  double step_us = 0.0;           ///< the whole step, likewise [us]
  std::size_t contacts = 0;       ///< contact points in the last step
  std::map<std::size_t, StepsWith> steps_with;  ///< by the number of contact points
};

inline constexpr int kIterations = 50;  ///< of each engine's solver

enum class Check { engine, native };

/// @param observer gets every pair and the check's answer to it; null: nobody. ODE's own check on
/// hexahedra (its dConvex) is not observed.
Outcome run_bullet(const World& world, Check check, PairObserver* observer = nullptr);
Outcome run_ode(const World& world, Check check, PairObserver* observer = nullptr);
Outcome run_mujoco(const World& world, Check check, PairObserver* observer = nullptr);

/// Times of each step. Medians: a busy machine interrupts some of them.
class StepTimes {
 public:
  explicit StepTimes(int steps) {
    check_.reserve(static_cast<std::size_t>(steps));
    step_.reserve(static_cast<std::size_t>(steps));
  }
  void add(std::chrono::steady_clock::duration check, std::chrono::steady_clock::duration step,
           std::size_t contacts);
  void finish(Outcome& out);

 private:
  std::vector<double> check_, step_;  ///< [us]
  std::map<std::size_t, std::vector<double>> step_with_;
};

/// Shared by the runs: fills what is measured of positions.
class Tracker {
 public:
  explicit Tracker(const World& world) : world_(world) {}
  void see_last(const Vector3& p);
  void finish(std::size_t body, const Pose& X, const Vector3& v, const Vector3& w, Outcome& out) const;
  double rise() const { return rise_; }

 private:
  const World& world_;
  double rise_ = 0.0;
};

}  // namespace touchstone::engine_check
