#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/mechanism/mechanism.hpp"
#include "touchstone/contact_core/scene/scene.hpp"
#include "touchstone/physics/bodies/inertia.hpp"
#include "touchstone/physics/contacts/narrowphase_contacts.hpp"
#include "touchstone/physics/world/dynamics_world.hpp"

/// @file
/// A scene with dynamics as plain data; SceneSimulation (scene_simulation.hpp) runs it.

namespace touchstone::physics {

/// How an object's motion is decided.
enum class BodyKind : std::uint8_t {
  fixed,      ///< at rest
  kinematic,  ///< follows the object's motion in the scene, as if of infinite mass
  dynamic,    ///< free: forces move it
  link,       ///< moved by a joint of a mechanism
};
/// As scene files have it: `fixed` is "static".
std::string_view to_string(BodyKind kind);

/// An object of the scene as dynamics sees it.
struct SceneBody {
  BodyKind kind = BodyKind::fixed;
  BodyInertia inertia = {};       ///< dynamic and link: in the object's frame
  Vector3 v_W = Vector3::Zero();  ///< dynamic: of the centre of mass at the start [m/s]
  Vector3 w_W = Vector3::Zero();  ///< dynamic: angular velocity at the start [rad/s]
  Surface surface = {};
  std::string where = {};  ///< for messages: "file:line: "; may be empty
};

/// Friction and restitution of two objects, whatever their own are; what is left out follows the scene's
/// rule.
struct ScenePair {
  std::size_t a = 0, b = 0;  ///< objects
  std::optional<double> friction = {}, restitution = {};
  std::string where = {};
};

/// A drive whose torque may grow evenly.
struct SceneDrive {
  JointDrive drive = {};
  double ramp = 0.0;  ///< of the torque, from when the drive was set on [N m/s] or [N/s]
};

/// A joint of a mechanism, given by its place while the objects are in their initial poses.
struct SceneJoint {
  std::string name;
  JointKind kind = JointKind::revolute;
  std::size_t parent = kNoObject;     ///< object; kNoObject: the ground. A fixed object is ground, too
  std::size_t child = kNoObject;      ///< object
  Vector3 p_W = Vector3::Zero();      ///< a point of the axis [m]
  Vector3 axis_W = Vector3::UnitZ();  ///< unit; the child turns or shifts about or along it, the parent held
  double value = 0.0;                 ///< of the joint in the initial poses [rad] or [m]
  double rate = 0.0;                  ///< at the start [rad/s] or [m/s]
  double lower = -kInfinity;
  double upper = kInfinity;
  double most_rate = kInfinity;  ///< of commanded rates
  double effort = kInfinity;     ///< most that a drive gives [N m] or [N]
  SceneDrive drive = {};
  JointLosses losses = {};
  double rotor = 0.0;  ///< inertia of what turns with the joint alone, as it sees it [kg m2] or [kg]
  std::string where = {};
};

/// A joint between two objects, each of which is free, a link, kinematic or the ground, given by its place
/// while they are in their initial poses. It may close loops, hold both ends of an arm, or be switched off.
struct SceneBodyJoint {
  std::string name;
  BodyJointKind kind = BodyJointKind::fixed;
  std::size_t parent = kNoObject;     ///< object; kNoObject: the ground
  std::size_t child = kNoObject;      ///< object
  Vector3 p_W = Vector3::Zero();      ///< its origin, a point of the axis [m]
  Vector3 axis_W = Vector3::UnitZ();  ///< unit; of hinges and sliders. Their value is 0 there
  double lower = -kInfinity;          ///< [rad] or [m]
  double upper = kInfinity;
  double effort = kInfinity;  ///< most that a drive gives [N m] or [N]
  SceneDrive drive = {};
  JointLosses losses = {};
  bool is_on = true;  ///< it holds from the start; an action may join them later, as they then stand
  std::string where = {};
};

/// Joints between objects, held by the ground.
struct SceneMechanism {
  std::string name;
  std::vector<SceneJoint> joints;
  std::string where = {};
};

/// A joint of a dynamic scene: of a mechanism, or (kBodyJoint) of DynamicScene::joints.
struct JointAddress {
  static constexpr std::size_t kBodyJoint = static_cast<std::size_t>(-1);
  std::size_t mechanism = 0, joint = 0;

  bool is_of_bodies() const { return mechanism == kBodyJoint; }
};

/// In force from the first step on that starts at `time` or later.
struct SceneAction {
  /// Sets a drive, makes two objects one or parts them, puts a joint at a value, has a joint between
  /// bodies hold, as they stand then, or let go, or brings an object in, or takes it out. What is brought in
  /// comes to its initial pose with its initial velocities, whatever is there; an object whose first such
  /// action is `add` is out from the start.
  enum class Kind : std::uint8_t {
    drive,
    latch,
    release,
    set_joint,
    join,
    part,
    add,
    remove
  } kind = Kind::drive;
  double time = 0.0;                     ///< [s]
  JointAddress joint = {};               ///< drive, set_joint, join, part
  double value = 0.0, rate = 0.0;        ///< set_joint: from then on [rad, rad/s] or [m, m/s]
  SceneDrive drive = {};                 ///< drive
  std::size_t carrier = 0;               ///< latch: an object
  std::size_t carried = 0;               ///< latch, release, add, remove: an object
  std::vector<ExemptPair> allowed = {};  ///< latch: not checked as well, while it holds
  std::string where = {};
};

/// A latch that closes when somebody asks for it: SceneSimulation::latch_now().
struct SceneLatchOption {
  std::size_t carrier = 0;               ///< object
  std::size_t carried = 0;               ///< object, dynamic
  std::vector<ExemptPair> allowed = {};  ///< not checked as well, while it holds
};

/// A known result of the scene, from a closed form.
struct SceneAnswer {
  /// Which figure of the run is held against `value`.
  enum class Figure : std::uint8_t {
    position,          ///< of the object's origin [m]
    velocity,          ///< of a dynamic object's centre of mass [m/s]
    angular_velocity,  ///< of a dynamic object [rad/s]
    force,             ///< of all contacts on the object, mean over the step that ends then [N]
    impact,            ///< sum of the impulses of impacts on the object up to then [N s]
    value,             ///< of a joint [rad] or [m]
    rate,              ///< of a joint
    torque,            ///< of a joint's drive, mean over the step that ends then [N m] or [N]
    moved,             ///< when a joint first had another rate than 0 at a step's end [s]
    stopped,           ///< when a sliding or a braked joint last stopped [s]
  };
  Figure figure = Figure::position;
  std::size_t object = kNoObject;   ///< of the first five
  JointAddress joint = {};          ///< of value to moved
  double time = 0.0;                ///< [s], that of a step's end; moved and stopped: the scene's duration
  Vector3 value = Vector3::Zero();  ///< scalars: the first entry
  double tolerance = 0.0;           ///< of the distance to it
  std::string where = {};

  bool is_vector() const { return figure <= Figure::impact; }
  bool is_of_joint() const { return figure >= Figure::value && figure <= Figure::moved; }
};
/// The enumerator's name.
std::string_view to_string(SceneAnswer::Figure figure);
/// In SI: "m", "rad", ...; values and rates of joints: as their kind has it.
std::string unit_of(const SceneAnswer& answer, JointKind kind);

/// Sums that do not change in a scene if the dynamics are right. About the world's origin, of all bodies and
/// mechanisms.
struct SceneConserved {
  bool linear = false;                                  ///< momentum
  std::array<bool, 3> angular = {false, false, false};  ///< angular momentum about x, y, z
  bool energy = false;
};

/// The largest errors with which a backend is still recommended.
struct SceneAccept {
  double depth = 1e-4;        ///< worst penetration [m]
  double position = 1e-4;     ///< of final poses, from the reference run's [m]
  double angle = 1e-3;        ///< the same [rad]
  double energy_made = 1e-3;  ///< as a share of the largest energy seen
  /// Of what SceneConserved says stays: as a share of the largest energy seen, and of the largest sum of all
  /// bodies' momenta, each without its sign.
  double drift = 1e-3;
  /// The largest speed of a point at the end [m/s]; infinite: nothing has to be at rest.
  double rest = kInfinity;
};

/// A scene and all that its dynamics need, nothing checked: see validate().
struct DynamicScene {
  Scene scene;
  std::vector<SceneBody> bodies;  ///< one an object, in the scene's order
  std::vector<ScenePair> pairs;   ///< the one given last counts
  /// How objects' own figures become a pair's.
  Combination friction_rule = Combination::geometric_mean, restitution_rule = Combination::maximum;
  std::vector<SceneMechanism> mechanisms;
  std::vector<SceneBodyJoint> joints;
  std::vector<SceneAction> actions;  ///< by time
  std::vector<SceneAnswer> answers;
  bool answers_hold = true;  ///< false: the caller has replaced parameters that they were derived for
  SceneConserved conserved;
  SceneAccept accept;
  Vector3 gravity_W = Vector3::Zero();  ///< [m/s2]
  double step = 1e-3;                   ///< [s]; divides the scene's duration
  double contact_margin = 1e-3;         ///< points up to this far apart are found [m]
  double bounce_speed = 1e-3;           ///< approaches slower than this do not bounce [m/s]
  double push_out = 0.0;                ///< see DynamicsWorld::Settings [1/s]
  double part_speed = 0.05;             ///< the same [m/s]
  /// The same [m/s], [s]: what has been slower for so long sleeps. Infinite: nothing does.
  double sleep_speed = 1e-3, sleep_time = kInfinity;
  std::vector<SceneLatchOption> latch_options = {};

  std::uint64_t step_count() const;
};

/// By object: whether it is out of the world at the start.
std::vector<std::uint8_t> absent_at_start(const DynamicScene& scene);
/// The name of a joint between bodies that holds the object, or would, so that it may not come or go; empty:
/// none does.
std::string joint_that_holds(const DynamicScene& scene, std::size_t object);

/// @throws InputError `where` object 'x': reason: a mass or inertia that no such body has (see
/// validate(BodyInertia)), velocities that are not finite, a bad surface, a motion of what is not kinematic.
void validate_body(const DynamicScene& scene, std::size_t object);
/// @throws InputError starting with `where`: crossed or negative limits, an axis that is not unit, a value
/// out of limits, figures that are not finite, unknown objects, a drive of a fixed joint.
void validate_joint(const DynamicScene& scene, const SceneMechanism& mechanism, const SceneJoint& joint);
/// Which objects carry which, and which are out, by object: what an action of a run meets.
struct ScenePlaces {
  std::vector<std::size_t> carriers;  ///< kNoObject: carried by none
  std::vector<std::uint8_t> is_out;
};
/// An action at a run's present, whatever its time. @throws InputError as validate(DynamicScene) of actions
void validate_action(const DynamicScene& scene, const SceneAction& action, const ScenePlaces& now);
/// Its kind as a mechanism's would be, for units; ball: fixed. @pre there is one
JointKind kind_of(const DynamicScene& scene, const JointAddress& joint);
/// "object 'box'". @pre there is one
std::string object_name(const DynamicScene& scene, std::size_t object);
/// "arm.elbow", or its own name. @pre there is one
std::string name_of(const DynamicScene& scene, const JointAddress& joint);
/// How the scene's surfaces meet; numbers are objects. @pre the scene is valid.
SurfacePairs surface_pairs(const DynamicScene& scene);
/// All of it. @throws InputError as those two and as Scene's, and for a mechanism without joints, parents
/// that are no link of it nor ground, objects moved by two joints, links without a joint, actions out of
/// order or that cannot be carried out (drives of joints that are not there or fixed), pairs of one
/// object or with figures out of range, a step that does not divide the duration, answers of what is not
/// there or has no such figure, or at times that no step ends at.
void validate(const DynamicScene& scene);

}  // namespace touchstone::physics
