#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/physics/engine/engine_features.hpp"
#include "touchstone/physics/scene/dynamic_scene.hpp"

/// @file
/// Steps a dynamic scene: our own dynamics, or an engine's (adapters/bullet_dynamics, ode_dynamics,
/// mujoco_dynamics), each with its own check of contacts or with one of ours. EngineRegistry
/// (engine_registry.hpp) makes them by name.
///
/// SI units, world frame. An engine's positions are those that its own integration comes to; nothing is
/// corrected.

namespace touchstone::physics {

/// How one side of a contact is moved.
enum class ContactSide : std::uint8_t {
  ground,  ///< at rest
  kinematic,
  body,  ///< a free body
  link,  ///< of a mechanism
};

/// One contact of the last step.
struct EngineContact {
  SolidPair solids;     ///< numbered over all objects of the scene; A is `a`
  PairStatus status;    ///< of the pair
  Vector3 p_W, n_AB_W;  ///< at the step's start; the point half-way between the surfaces
  double separation;    ///< there [m]
  Vector3 force_W;      ///< on B, mean over the step [N]; impacts included
  /// The impulse of impacts alone, on B [N s]; NaN where the engine does not distinguish them from forces.
  Vector3 impact_W;
  ContactSide side_a, side_b;
  Vector3 kinematic_v_A_W,
      kinematic_v_B_W;  ///< of a kinematic side's point at p_W, constant over the step [m/s]
};

/// How a step went.
struct EngineStep {
  std::string failure;  ///< why the run ends here, with the name of what failed; empty: taken
  double total_us = 0.0;
  double detection_us = kNaN;               ///< of it; NaN: not known
  std::size_t contacts = 0;                 ///< points
  std::uint32_t undecided = 0, failed = 0;  ///< pairs, where the check reports them
  std::uint32_t unconverged = 0;            ///< solves, where the engine reports them
  double worst_residual = 0.0;              ///< the same [m/s]
  /// When within the step something last stopped [s]; NaN: nothing did, or the engine does not locate it.
  double last_stop = kNaN;
};

/// The state of an engine's run. @see DynamicsEngine::snapshot()
class EngineSnapshot {
 public:
  EngineSnapshot() = default;
  EngineSnapshot(const EngineSnapshot&) = delete;
  EngineSnapshot& operator=(const EngineSnapshot&) = delete;
  virtual ~EngineSnapshot() = default;
};

/// Steps after DynamicsEngine::restore().
enum class EngineReturn : std::uint8_t {
  none,        ///< unsupported
  repeatable,  ///< the same to the bit after every restore() of one snapshot; from the run that went on they
               ///< differ by what the engine remembers of contacts, which is found anew
  same_bits,   ///< the same to the bit as in the run that went on
};
/// In words: "same bits".
std::string_view to_string(EngineReturn after);

/// Steps one scene. Set-up throws InputError; the parts of a step do not throw. One thread; engines of
/// different scenes share nothing but what their adapters name (tables of a process).
///
///     for (engine->begin_step(); ...) const EngineStep step = engine->step();
class DynamicsEngine {
 public:
  DynamicsEngine() = default;
  DynamicsEngine(const DynamicsEngine&) = delete;
  DynamicsEngine& operator=(const DynamicsEngine&) = delete;
  virtual ~DynamicsEngine() = default;

  virtual const DynamicScene& scene() const = 0;
  virtual std::uint64_t steps() const = 0;  ///< taken
  bool is_over() const { return steps() >= scene().step_count(); }
  /// Whether impacts are distinguished from forces, and stops within a step located.
  virtual bool locates_events() const { return false; }
  double time() const { return static_cast<double>(steps()) * scene().step; }

  /// Takes the commands for this step: actions that are due, drives, kinematic bodies. An action of the scene
  /// for which a program's commands left no place (a latch of what is carried, a release of what is not) is
  /// not carried out: this step fails and names it, and so does every one until it has its place.
  virtual void begin_step() = 0;
  /// Finds contacts and moves everything by the scene's step. Timed inside, without what is only looked at.
  virtual EngineStep step() = 0;

  /// Pushes an object, with all that moves with it, over the next step: a force at p_W and a moment, in
  /// addition to gravity, drives and contacts; several pushes add up. A link transmits them through its
  /// joints. May be called before begin_step() or after it. Does not allocate.
  /// @param force_W [N] @param p_W [m] @param moment_W [N m]
  /// @throws InputError: no such object, one that is fixed or follows its motion, figures that are not
  /// finite.
  void push(std::size_t object, const Vector3& force_W, const Vector3& p_W,
            const Vector3& moment_W = Vector3::Zero());

  /// Takes a free object out of the world: it stays where it is, without velocity, and touches nothing.
  /// Between steps.
  /// @throws InputError: no such object, not a free one, one that is carried or carries, one with a joint
  /// between bodies, one that is out; "unsupported" where the engine has no such means.
  void remove(std::size_t object);
  /// Brings an object in that an action or remove() took out, or whose first action would bring it in. Bodies
  /// that come during a run are objects of the scene from the start. @param v_W of its centre of mass [m/s]
  /// @param w_W [rad/s]
  /// @throws InputError: as remove(), one that is in, a bad pose, velocities that are not finite.
  void add(std::size_t object, const Pose& X_WO, const Vector3& v_W, const Vector3& w_W);
  virtual bool has(std::size_t object) const = 0;
  /// The object that carries it by a latch, or kNoObject.
  virtual std::size_t carrier_of(std::size_t object) const = 0;

  /// Carries out a program's own command, given as an action of the scene whose time does not count: a joint
  /// driven (ramps begin now) or put at a value; a latch or release; a joint between bodies that holds, or
  /// lets go; an object at its initial pose, or gone. Between steps; the next step has it.
  /// @throws InputError, and nothing has changed: validate_action(); "unsupported" what the engine lacks of
  /// it (all but `own`: latches of two that the scene neither latches nor has an option for); a latch that
  /// says `allowed`, which the scene's option or latch of the same two does.
  void act(const SceneAction& action);

  virtual EngineReturn after_restore() const = 0;
  /// Saves the state, between steps; only this engine can restore it. @throws InputError: "unsupported".
  virtual std::unique_ptr<EngineSnapshot> snapshot() const = 0;
  /// Restores a saved state: positions, velocities, drives, latches, joints, the objects in the world, the
  /// actions still due, and the time. Pushes for the next step are forgotten. after_restore() states how
  /// later steps compare.
  /// @throws InputError: of another engine.
  virtual void restore(const EngineSnapshot& snapshot) = 0;
  /// Goes back to the start: the steps that follow are those of a new engine, to the bit. @throws InputError:
  /// "unsupported".
  virtual void reset() = 0;

  /// Lists the last step's contacts. @param contacts emptied first
  virtual void list_contacts(std::vector<EngineContact>& contacts) const = 0;
  /// Whether contacts of the two are not listed because they sleep, and so go on as they were.
  virtual bool are_asleep(const SolidPair& /*solids*/) const { return false; }

  virtual Pose object_pose(std::size_t object) const = 0;
  /// The velocity of the centre of mass of a dynamic object and all that moves with it; nothing for links and
  /// kinematic objects.
  virtual std::optional<Vector3> velocity(std::size_t object) const = 0;
  virtual std::optional<Vector3> angular_velocity(std::size_t object) const = 0;
  virtual double joint_value(const JointAddress& joint) const = 0;
  virtual double joint_rate(const JointAddress& joint) const = 0;
  /// The drive's mean torque or force over the last step [N m] or [N].
  virtual double joint_torque(const JointAddress& joint) const = 0;

  virtual Vector3 linear_momentum() const = 0;   ///< of free bodies and mechanisms [N s]
  virtual Vector3 angular_momentum() const = 0;  ///< the same, about the world's origin [N m s]
  virtual double energy() const = 0;             ///< kinetic and, in gravity, potential; the same [J]
  virtual Vector3 body_momentum() const = 0;     ///< of free bodies alone [N s]
  virtual double body_mass() const = 0;          ///< of free bodies alone [kg]

  /// The deepest overlap now of any pair that is checked, by `native` whatever check the engine has [m].
  virtual double worst_depth() = 0;

 private:
  /// As push(). @pre the object moves by forces, the figures are finite
  virtual void take_push(std::size_t object, const Vector3& force_W, const Vector3& p_W,
                         const Vector3& moment_W) = 0;
  /// As remove() and add(). @pre the object is dynamic and is in, or out; the pose is valid and all finite
  virtual void take_out(std::size_t object) = 0;
  virtual void put_in(std::size_t object, const Pose& X_WO, const Vector3& v_W, const Vector3& w_W) = 0;
  /// As act(). @pre validate_action() and the engine's features allow it @throws InputError before it changes
  /// anything: what this engine's method does not do
  virtual void take_action(const SceneAction& action) = 0;

  friend class EngineRegistry;  // which knows them
  EngineFeatures features_;
};

}  // namespace touchstone::physics
