#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "touchstone/contact_core/broadphase/broadphase.hpp"
#include "touchstone/contact_core/mechanism/resolved_rate.hpp"
#include "touchstone/contact_core/narrowphase/narrowphase.hpp"
#include "touchstone/contact_core/world/contact_world.hpp"
#include "touchstone/physics/contacts/gap_narrowphase.hpp"
#include "touchstone/physics/guarded/cut_impulses.hpp"
#include "touchstone/physics/guarded/joint_follower.hpp"
#include "touchstone/physics/scene/scene_simulation.hpp"

namespace touchstone::physics {

/// The rule for two objects that meet in a simulation with forces. `push` needs dynamics; the others are
/// ContactPolicy's. They decide which part of the motion that dynamics computed is not executed in a step:
enum class GuardPolicy : std::uint8_t {
  cue,      ///< nothing: they move through each other, and it is reported
  hold,     ///< an object that would meet the other does not take the step, and stands
  advance,  ///< an object that meets the other stops there, and stands
  slide,    ///< what leads closer: they go along each other without friction, no force is known
  push,  ///< dynamics' forces keep them apart, with friction and restitution; what they miss as with `slide`
};
/// The enumerator's name, as scene files have it.
std::string_view to_string(GuardPolicy policy);

/// A rule for the pairs of one object, or of a group's, with another; the rule given last counts.
struct GuardRule {
  std::string first, second;  ///< objects or groups of the scene
  GuardPolicy policy = GuardPolicy::push;
};

/// The settings of a guarded scene.
struct GuardSettings {
  GuardPolicy policy = GuardPolicy::push;  ///< of pairs that no rule names
  std::vector<GuardRule> rules = {};
  /// Shown objects are never nearer than half of this g [m], and rest g apart. At least 10 times the scene's
  /// contact_gap, within which dynamics takes a contact to touch.
  double gap = 1e-7;
  /// The most that slides of a step do. What they leave waits for the next step and counts as held back:
  /// less work makes the longest steps shorter and what is shown lag more (GuardedStep::slides_ended).
  SlideBudget slides = {};
};

/// A hand that commands a link: the motion of a point fixed in the link, until the next command.
struct GuardedHand {
  std::size_t link = 0;           ///< object
  Vector3 p_O = Vector3::Zero();  ///< the point, in the object's frame [m]
  ResolvedRateSettings rates = {};
};

/// How a step went.
struct GuardedStep {
  StepReport dynamics;               ///< on failure nothing has moved
  std::uint32_t cut = 0;             ///< bodies and mechanisms that do not go where dynamics led
  std::uint32_t standing = 0;        ///< of them, brought to a stand: by pairs that hold or advance
  CutReport impulses = {};           ///< along the normals, of pairs that slide or push
  Vector3 held_W = Vector3::Zero();  ///< momentum that standing took from free bodies [N s]
  /// Momentum of free bodies after the cut less that before [N s], about the world's origin [N m s]. The
  /// linear one equals the impulses less `held_W`, to rounding; both are 0 where nothing was cut.
  Vector3 linear_W = Vector3::Zero(), angular_W = Vector3::Zero();
  /// Energy of bodies and mechanisms after the cut less that before [J].
  double energy = 0.0;
  double held_back = 0.0;  ///< the farthest that a body's origin or a link's was held back [m]
  /// Movers whose slides GuardSettings::slides ended before they came to rest: held back for that, too.
  std::uint32_t slides_ended = 0;
  /// The largest error of a joint between bodies, as all are shown, where something was cut [m] or [rad].
  double joint_error = 0.0;
};

/// The paper's second build with dynamics, in one loop. Hands' commands become joint rates; drives of limited
/// torque and contact forces give the poses to which everything would go (SceneSimulation); proof and motion
/// modification give those to which it goes (ContactWorld). These are shown, and the next step starts from
/// them.
///
///     GuardedSimulation run(scene, settings, make_native, make_native_broadphase);
///     const std::size_t hand = run.add_hand({.link = 4});
///     while (!run.is_over()) { run.command(hand, wanted_W); run.step(); show(run.shown_pose(object)); }
///
/// A step that the world cuts leaves: the poses that it executed, as state; velocities less what impulses
/// along the normals take (CutImpulses), equal and opposite between what is free, with Newton's restitution;
/// friction follows in the next step's forces. Who stands (hold, advance) loses its momentum to what holds
/// it.
///
/// Joints between bodies: a body that a joint holds to a cut one follows it in a further frame of the world,
/// so that the joint's frames come together as far as that is clear (JointFollower). Where something stops
/// this motion, it is cut, too. The next step takes back the errors that stay.
///
/// Shown poses are proven to be apart by g/2 at least, path and all, with the world's narrowphase, whatever
/// dynamics' contacts come from; objects that overlap at the start may part. Set-up throws InputError, and so
/// do steps in which something is latched where SceneSimulation refuses; other steps neither throw nor, once
/// warm, allocate. One thread.
class GuardedSimulation {
 public:
  using MakeNarrowphase = std::function<std::unique_ptr<Narrowphase>()>;
  using MakeBroadphase = std::function<std::unique_ptr<Broadphase>()>;

  /// Keeps a reference to `scene`. Pairs that the scene exempts, links that a joint joins and what is latched
  /// are checked by neither; kinematic objects are checked against fixed ones by the world, as any other.
  /// @param contacts of dynamics; null: `proof`. Needs manifolds. @param proof of the world: signed
  /// distances.
  /// @throws InputError: as SceneSimulation and ContactWorld; unknown names in rules; a gap that is too
  /// small.
  GuardedSimulation(const DynamicScene& scene, const GuardSettings& settings, MakeNarrowphase proof,
                    MakeBroadphase broadphase, MakeNarrowphase contacts = nullptr);
  GuardedSimulation(DynamicScene&&, const GuardSettings&, MakeNarrowphase, MakeBroadphase,
                    MakeNarrowphase) = delete;

  /// @return its number. @throws InputError: a link that no joint moves, settings out of range.
  std::size_t add_hand(const GuardedHand& hand);
  /// The motion of the hand's point from now on; joints then follow rates with at most their own torques.
  void command(std::size_t hand, const Twist& wanted_W) { hands_[hand].wanted_W = wanted_W; }
  /// The hand's point now [m].
  Vector3 hand_point(std::size_t hand) const;

  bool is_over() const { return simulation_.is_over(); }
  GuardedStep step();

  // Between steps; these allocate.

  /// As SceneSimulation's, the proof with it. @throws InputError where ContactWorld refuses.
  bool latch_now(std::size_t option);
  bool release_now(std::size_t carried);
  /// Switches an object. While it is off it meets nothing, by force or proof. What is out stays out, and is
  /// on or off when it comes; what overlaps as it comes on may part, as at the start. @throws InputError: no
  /// such object.
  void select(std::size_t object, bool is_on);
  /// SceneSimulation::remove(), from the proof, too: it stays where it is shown, and meets nothing.
  void remove(std::size_t object);
  /// SceneSimulation::add(), to the proof, too; the next step's shown poses are proven with it. proof() is
  /// then of the frame that brought it.
  /// @throws InputError as there; where it would be within half of the gap of what it does not pass through
  /// by `cue`: it stays out. What is off may be anywhere.
  void add(std::size_t object, const Pose& X_WO, const Vector3& v_W, const Vector3& w_W);
  /// Sets the policy of pairs that no rule names.
  void set_policy(GuardPolicy policy);

  /// X_WO, what an image generator gets. (Of links, to rounding: the world's objects are in the links'
  /// frames.)
  Pose shown_pose(std::size_t object) const {
    return scene_->bodies[object].kind == BodyKind::link
               ? compose(world_.actual_pose(objects_[object]), simulation_.pose_within(object))
               : world_.actual_pose(objects_[object]);
  }
  GuardPolicy policy(std::size_t a, std::size_t b) const { return policies_[a * objects_.size() + b]; }
  /// The guard's report of the last step. Its events include those of the further frames that joints between
  /// bodies need, but for `near` and `persists`.
  const FrameReport& proof() const { return frame_; }
  const ContactWorld& world() const { return world_; }
  const SceneSimulation& simulation() const { return simulation_; }
  /// SceneSimulation::reserve()
  void reserve(std::size_t contacts) { simulation_.reserve(contacts); }
  /// The dynamics world, for forces and drives from outside; between steps.
  DynamicsWorld& dynamics() { return simulation_.world_to_set(); }
  double gap() const { return settings_.gap; }
  std::size_t object_of(ObjectHandle handle) const { return object_of_slot_[handle.slot]; }

 private:
  struct Hand {
    GuardedHand setting;
    std::uint32_t mechanism, link;
    ResolvedRate control;
    std::vector<Pose> X_WL;
    std::vector<double> rates;
    Twist wanted_W;
  };

  // guarded_simulation_setup.cpp
  void set_policies();
  void set_policy(std::size_t a, std::size_t b, GuardPolicy policy);
  void see(std::size_t a, std::size_t b);
  void look_anew();
  void show(std::size_t object);
  std::size_t too_near(std::size_t object) const;
  void set_pair_rules();
  void follow_latches();
  void follow_joints();
  bool is_joined(std::size_t a, std::size_t b) const;
  bool names(const std::string& name, std::size_t object) const;
  void fill_world();
  void exempt_in_world();
  std::vector<Exemption> exemptions(std::span<const ExemptPair> pairs) const;
  void take_up_latches();
  void fill_touching();

  void drive_hands();
  void propose();
  bool find_cuts(GuardedStep& report);
  void bring_joints_together(GuardedStep& report);
  bool cut_body(std::size_t object, GuardedStep& report);
  bool cut_mechanism(std::uint32_t mechanism, GuardedStep& report);
  void mark_standing();
  void mark(ObjectHandle object);
  /// Linear and angular, of free bodies.
  std::pair<Vector3, Vector3> momentum() const;
  bool stands(std::uint32_t unit) const { return standing_[unit] != 0; }
  void take_back(GuardedStep& report);
  void stand(GuardedStep& report);
  std::span<const Contact> cut_contacts();
  std::uint32_t unit_of(std::size_t object) const;

  const DynamicScene* scene_;
  SurfacePairs surfaces_;  // numbers are objects
  GuardSettings settings_;
  MakeNarrowphase make_proof_;
  MakeBroadphase make_broadphase_;
  std::vector<GuardPolicy> policies_;         // by object and object
  std::vector<std::uint8_t> is_on_, is_out_;  // by object
  std::vector<std::uint32_t> object_of_solid_;
  std::shared_ptr<SeenPairs> pushed_, sliding_, guarded_;  // push; push and slide; all but cue
  SceneSimulation simulation_;
  ContactWorld world_;
  std::vector<ObjectHandle> objects_;
  std::vector<MechanismHandle> mechanisms_;
  std::vector<std::size_t> object_of_slot_;
  std::vector<std::size_t> carrier_;  // by object, as the world has it
  std::uint64_t latched_ = 0;         // simulation_.worlds() when the world last took latches over
  std::vector<Hand> hands_;
  CutImpulses impulses_;
  JointFollower follower_;
  std::vector<std::uint8_t> are_joined_;           // by joint between bodies: the world lets its pair through
  std::vector<ContactEvent> events_;               // of a step with several frames
  std::unique_ptr<NarrowphaseContacts> touching_;  // what a cut's impulses act at
  // Of the step.
  std::vector<Contact> cut_contacts_;
  std::vector<MotionCommand> commands_;
  std::vector<std::size_t> movers_;  // objects, one a command
  std::vector<JointCommand> joint_commands_;
  std::vector<std::uint8_t> is_cut_, standing_;  // by body, then mechanism
  std::vector<double> still_;                    // zeros, as many as the largest mechanism has rates
  FrameReport frame_;
};

}  // namespace touchstone::physics
