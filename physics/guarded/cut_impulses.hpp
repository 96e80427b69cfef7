#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "touchstone/contact_core/geometry/no_index.hpp"
#include "touchstone/physics/scene/scene_simulation.hpp"

namespace touchstone::physics {

/// The result of a cut.
struct CutReport {
  std::uint32_t contacts = 0;           ///< that pushed
  Vector3 impulse_W = Vector3::Zero();  ///< on free bodies, from mechanisms and what stands [N s]
  double approach = 0.0;                ///< the fastest along a normal before [m/s]
  double left = 0.0;                    ///< the fastest after: what the sweeps did not get to [m/s]
};

/// The impulses of points that were stopped while they still approached: along the normals, no friction, with
/// Newton's restitution, all of an instant in one problem, 0 <= impulse, speed >= wanted, by projected
/// Gauss-Seidel sweeps (sequential impulses: Moreau 1999; Catto 2005), at most kMostSweeps. Each acts on both
/// sides at one point: momentum stays to rounding, wherever the sweeps end. Without restitution every sweep
/// lowers the kinetic energy of what is free.
///
/// Memory is taken once; solve() does not allocate.
class CutImpulses {
 public:
  static constexpr std::size_t kMostContacts = 128;  ///< of one cut; the first ones of more
  static constexpr int kMostSweeps = 64;

  explicit CutImpulses(const SceneSimulation& simulation);

  /// By body and, behind them, by mechanism, as world() counts them: what is held where it is, as if of
  /// infinite mass, all 0 after solve().
  std::span<std::uint8_t> held() { return held_; }
  /// Changes velocities of `simulation`'s world at once. @param bounce_speed approaches slower than this do
  /// not bounce [m/s].
  CutReport solve(SceneSimulation& simulation, std::span<const Contact> contacts,
                  double bounce_speed) noexcept;

 private:
  /// A free body or a mechanism as impulses see it.
  struct Unit {
    bool is_used = false;
    double per_mass = 0.0;
    Matrix3 per_inertia_W = Matrix3::Zero();
    Vector3 v_W = Vector3::Zero(), w_W = Vector3::Zero(), centre_W = Vector3::Zero();
    std::size_t first = 0;  // of a mechanism's rates in qd_
    std::size_t size = 0;
    MechanismDynamics::Workspace placed;
    std::vector<double> L;  // its mass matrix' factor
  };
  struct Side {
    std::uint32_t unit = kNoIndex;
    double sign = 0.0;
    Vector3 n_W = Vector3::Zero(), turn_W = Vector3::Zero();  // a body's Jacobian
    std::size_t first = 0;                                    // a mechanism's row in J_ and Y_
  };
  struct Row {
    Side sides[2];
    Vector3 n_W, p_W;
    double commanded = 0.0;  // speed that what is not a unit contributes [m/s]
    double mass = 0.0;       // effective [kg]
    double wanted = 0.0;     // [m/s]
    double impulse = 0.0;
  };

  std::uint32_t unit_of(const SceneSimulation& simulation, const Mover& mover) const;
  void take_up(const SceneSimulation& simulation, std::uint32_t unit);
  void add(const SceneSimulation& simulation, const Contact& contact);
  double per_mass_of(Side& side, const Row& row) const;
  double speed(const Row& row) const;
  void push(const Row& row, double impulse);
  void give(SceneSimulation& simulation, CutReport& report);

  std::size_t bodies_;
  std::vector<std::uint8_t> held_;  // by unit
  std::vector<Unit> units_;
  std::vector<Row> rows_;
  std::vector<double> qd_, J_, Y_;
};

}  // namespace touchstone::physics
