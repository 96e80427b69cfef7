#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "touchstone/contact_core/broadphase/broadphase.hpp"
#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/geometry/hexahedron_tree.hpp"
#include "touchstone/contact_core/mechanism/mechanism.hpp"
#include "touchstone/contact_core/motion/impact.hpp"
#include "touchstone/contact_core/scene/scene.hpp"
#include "touchstone/contact_core/world/handles.hpp"
#include "touchstone/contact_core/world/selection.hpp"

/// @file
/// The contact world (the paper's Contact_object, Object_manager and Contact_manager): objects come and go at
/// run time, are commanded frame by frame, and move only as far as nothing merges.
///
/// Threads: one thread owns a world. Only select() may be called from others, while frames run.
/// Set-up (add, remove, rules, latches, backends) may allocate and throws InputError, the world unchanged.
/// frame() neither throws nor, once warm, allocates; set-up is taken up by the next prepare() or, where it
/// was left out, frame().
/// Where memory ends (std::bad_alloc), add(), add_mechanism(), remove(), remove_mechanism(), exempt(),
/// unexempt(), latch() and unlatch() did nothing; reset() needs no memory. Calls that set a rule, and
/// prepare(), may have done a part: repeat them. A frame() that throws as it takes up set-up has not begun.

namespace touchstone {

inline constexpr std::size_t kSearchedFrom = 16;  ///< hexahedra: see ObjectDescription::levels

/// The argument of ContactWorld::add(): a rigid object and its initial pose.
struct ObjectDescription {
  std::shared_ptr<const HexahedronTree> tree;  ///< its name is the object's, unique in the world
  Pose X_WO;
  bool is_static = false;  ///< never moves; pairs of static objects are not checked
  /// At most 64 names in a world, each of at most GroupName::kMostBytes bytes.
  std::vector<std::string> groups = {};
  /// Coarser and coarser trees of the same object, for speed alone: every frame has the same poses and events
  /// with them as without, but where an arm slides and plans further than its pairs were looked for, it may
  /// go otherwise, as safely. Each hexahedron of `tree` lies in one of levels[0], each of levels[0] in one of
  /// levels[1], and so on; of a rounded one the core, and the radius is no larger. While a coarser hexahedron
  /// is known to be out of reach of all others, nothing below it is looked at. Beside these, every object of
  /// kSearchedFrom hexahedra or more, and every one with levels, has spheres about halves of it, quarters and
  /// so on: far from all others it costs a frame what one hexahedron costs. Neither is used of a static
  /// object, or of one that is not searched. coarser_levels() in fit/levels.hpp makes some.
  std::vector<std::shared_ptr<const HexahedronTree>> levels = {};
  /// False: each hexahedron has a reserve of its own, and is looked at where it used that up, without levels
  /// or spheres; to compare.
  bool is_searched = true;
};

/// @throws InputError naming the object, the level and the hexahedron that keep these from being levels of
/// the tree (ObjectDescription::levels).
void validate_levels(const HexahedronTree& tree,
                     std::span<const std::shared_ptr<const HexahedronTree>> levels);

/// A pair's rule. Policies are ContactPolicy's. A mover that a `slide` pair stopped goes on along it towards
/// its commanded pose, in sub-steps of at most kMostSlideSteps, never further from that pose in its mass
/// metric (motion/mass_metric.hpp) than it was; where more than half a turn is left of its path it stays, as
/// with `advance`. Of two movers neither pushes the other away from its own goal. A slide ends at a pair that
/// only advances; the sub-step that would meet one that holds is not executed.
///
/// A rigid body that an `advance` pair stopped while it turns goes on in one sub-step, as far as that is
/// clear: on the path to its commanded pose on which the point that touches goes straight. A tool turned
/// about the edge that it rests on keeps to that edge so, whose origin's straight path would dip below it.
///
/// Unset fields are inherited, field by field: by a pair's rule from the rules of groups that fit, the one
/// given last first, then from the world's own, at last from EffectiveRule's values. A rule that is set
/// again, for the same pair, the same two groups or the world, replaces the one before as a whole; an empty
/// one takes it back.
struct PairRule {
  std::optional<ContactPolicy> policy = {};
  std::optional<double> warn_distance = {};   ///< `near` is reported within this; finite, >= 0 [m]
  std::optional<bool> translation_only = {};  ///< slide: whom this pair stops goes on without turning
  /// Not with the policies hold and cue. A passive object moves as if rigidly attached to its mover (contact
  /// without slip): it turns with the mover, and what it meets stops both. An object that is shoved against
  /// another shoves that too, up to kMostSlideSteps one after another. An object that two movers would move,
  /// or two links that may turn, stays where it is. Objects that move along are checked as movers are.
  std::optional<Passive> passive = {};
};

/// The rule that a pair follows, nothing left to inherit; the values are those that no rule sets.
struct EffectiveRule {
  ContactPolicy policy = ContactPolicy::hold;
  double warn_distance = 0.0;  ///< [m]
  bool translation_only = false;
  Passive passive = Passive::stays;
};

/// Two objects, or a hexahedron of them, that are not checked against each other.
struct Exemption {
  ObjectHandle a, b;
  std::string solid_a = {}, solid_b = {};  ///< names in the objects' trees; empty: all of the object
};

/// A mechanism (mechanism/mechanism.hpp) in the world. Its description's `base` names the end that is held.
struct MechanismPlacement {
  std::shared_ptr<const Mechanism> mechanism;  ///< its name is unique in the world
  Pose X_WB = {};                              ///< of the base, which stands still
  std::vector<double> initial = {};            ///< joint values; empty: the reference
  std::vector<std::string> groups = {};        ///< of every link
  /// Slides keep sum w dq^2 to the goal least: one a joint value, > 0; empty: all 1, radians and metres
  /// alike.
  std::vector<double> weights = {};
};

/// The commanded motion of one object over a frame.
struct MotionCommand {
  ObjectHandle object;
  RigidPath path;  ///< path.from() is replaced by the actual pose when it differs: see go_to(), move_by()
};

/// The commanded joint values of a mechanism at a frame's end, all reached evenly. Values beyond a joint's
/// limits are taken as the limit and reported as `at_limit`; a wrong number of values, or one that is not
/// finite, is refused: the mechanism stays, and the command before stays the last good one.
struct JointCommand {
  MechanismHandle mechanism;
  std::span<const double> values;  ///< read by frame() only; in the order of Mechanism::joints()
};

/// How stiffly a hand holds a rigid body: by a spring from the body's tool frame T to where the commanded
/// pose has T (virtual coupling). A slide never increases the spring's energy: with d the shift and t the
/// turn (axis times angle) that are left, sum of k d^2 + sum of c t^2 along T's axes as commanded does not
/// grow. Slides depend on the ratios of k and c only; their size scales the wrench that is reported. By
/// default 1 rad weighs as 1 m, as with joints: the body keeps its attitude unless it must yield. A hand as
/// soft in turning as a light body of its size tips over what it meets.
struct HandStiffness {
  /// The tool's frame in the object. Without one its origin is the centre of mass, at uniform density, of all
  /// that moves with the object, and its axes are the object's.
  std::optional<Pose> X_OT = {};
  Vector3 translation = {500.0, 500.0,
                         500.0};            ///< k along T's axes [N/m]; > 0, no two further apart than 1e6
  Vector3 turning = {500.0, 500.0, 500.0};  ///< c about T's axes [N m/rad]; as k, and 1e-6 to 1e6 m2 of it
};

/// How stiffly a hand holds a mechanism: each joint by a spring at its commanded value, and a tool frame T on
/// one of its links by springs at where the commanded values have it. A slide goes where these are slackest:
/// with d and t the shift and the turn of T that are left, to first order about where the slide begins and
/// along T's axes there, sum of w dq^2 + sum of k d^2 + sum of c t^2 never grows. So an arm that is held back
/// keeps its tool on its path by all of its joints, where weights of the joints alone keep each of these near
/// its value and let the tool go aside.
struct ArmHandStiffness {
  std::string link;                             ///< with or without hexahedra; some joint moves it
  Pose X_LT = {};                               ///< T in the link
  Vector3 translation = {500.0, 500.0, 500.0};  ///< k along T's axes [N/m]; as HandStiffness's
  Vector3 turning = {500.0, 500.0, 500.0};      ///< c about T's axes [N m/rad]; as HandStiffness's
  /// w of each joint value [N m/rad] or [N/m], within a factor of 1e6 of the least k; they decide where the
  /// tool leaves the joints free. Empty: all a hundredth of the least k, instead of MechanismPlacement's.
  std::vector<double> joints = {};
};

/// Forces on the hand of a mover that slid, at a frame's end (Ortega, Redon, Coquillart 2007, section 5: the
/// forces that keep the god-object back, here those of the contacts that hold the last sub-step's plan).
struct HandFeel {
  ObjectHandle object;  ///< of a mechanism its first link
  Vector3 p_W;          ///< of the tool frame's origin
  Vector3 lag_W;        ///< from there to where the command has it [m]
  Vector3 turn_lag_W;   ///< the turn from the actual to the commanded pose, axis times angle [rad]
  Vector3
      force_W;  ///< of the contacts on the object, or on a mechanism's links but between two that move [N]
  Vector3 moment_W;  ///< the same, about p_W [N m]
};

/// An event of a pair, or of a command, in a frame. ContactEvent::part, s and geometry tell when in the frame
/// it took place.
///
/// Contact, as events count it, begins within the gap g and ends beyond 2 g: a pair is in contact from
/// `began` to `ended`, each frame in between has one `persists`, and what comes within the gap in a frame has
/// begun, even if it is gone again at its end (then `ended` follows at once). With a narrowphase that only
/// judges poses, a pair that it does not call separated is in contact, until it is apart by the gap.
enum class EventKind : std::uint8_t {
  near,   ///< within the warn distance, not in contact: at the frame's end
  began,  ///< came within the gap: at the first s at which it was found there, its movers' stop, the frame's
          ///< or a part's start or end; a part whose motion was not executed does not count
  persists,  ///< still within twice the gap: at the frame's end
  ended,     ///< further apart than twice the gap again: at the frame's end. Or no longer checked (removed,
             ///< switched off, exempt, latched to one another): at s = 0, as the frame before left it
  penetrating_at_start,  ///< overlaps at the frame's start, s = 0: a bad initial pose, or switched on or
                         ///< unlatched there. `began` follows
  /// The pair stopped its movers, and nothing cancelled the stop: at the s of the stop, within the gap unless
  /// the check gave up or found no answer there. In a slide: held back the plan of a sub-step, where it was
  /// first within twice the gap at an end of that. By a pair that holds: at the s at which the motion that
  /// was not executed would have met it; stops that went with that motion are not reported.
  blocked,
  refused,   ///< a command that is no pose, or for an object that is static, carried or gone;
             ///< joint values that are not finite or too few or many (a: the first link)
  at_limit,  ///< a joint was commanded to go beyond its limits (a: the link that it moves)
};
/// The enumerator's name.
std::string_view to_string(EventKind kind);

/// One event of a frame, about a pair of solids or about a command.
struct ContactEvent {
  EventKind kind;
  ObjectHandle a, b;  ///< b: none for `refused` and `at_limit`
  SolidPair solids;   ///< indices within their objects' trees: solids.a in a, solids.b in b
  double s;           ///< within `part`, 0 to 1
  /// n from a to b; NaN for `refused` and `at_limit`, and where the narrowphase had no answer. With the
  /// objects at executed_pose(object, part, s), to rounding; of a `blocked` that holds: where the commanded
  /// paths, or the sub-step's plan, would have them at s.
  PairGeometry geometry;
  std::uint32_t part = 0;  ///< see ContactWorld::executed_parts(): 0: the commanded paths, s is the frame's
  /// The geometry at the poses that the frame ended with; NaN where `geometry` is, and where one of the two
  /// was removed.
  PairGeometry geometry_at_end = {};
};

/// The result of a frame. Counts are of this frame only.
struct FrameReport {
  std::uint64_t frame = 0;
  std::span<const ContactEvent> events;  ///< valid until the next frame; by pair
  /// Changes that came into force at its start, in order; valid until the next frame. A run that keeps these
  /// with their frames replays, however long it is.
  std::span<const SelectionChange> selections;
  /// Changes that were due at its start but named a removed object, an object twice, or an unknown group:
  /// they had no effect and are not recorded. In order; valid until the next frame.
  std::span<const SelectionChange> refused_selections;
  std::uint32_t blocked_movers = 0;    ///< stopped on their commanded paths; loads that go along, too
  std::uint32_t candidate_pairs = 0;   ///< looked at; all others are known to stay out of reach
  std::uint64_t queries = 0;           ///< narrowphase calls
  std::uint32_t iteration_limits = 0;  ///< pairs stopped early for want of iterations
  std::uint32_t slide_steps = 0;       ///< sub-steps of slides; at most kMostSlideSteps
  std::uint64_t slide_pairs = 0;       ///< what SlideBudget::pairs counts
  std::uint64_t most_slide_work = 0;   ///< what SlideBudget::mover_work counts, of the mover that took most
  /// Movers whose slides the budget ended before they came to rest, by ObjectHandle::slot: a rigid body by
  /// the object that was commanded, a mechanism by its first link. Valid until the next frame.
  std::span<const ObjectHandle> cut_off;
  /// Forces on the hand of every rigid body that slid or was commanded to, and of every mechanism that did
  /// and has an ArmHandStiffness, by ObjectHandle::slot; valid until the next frame.
  std::span<const HandFeel> felt;
  MotionCheck check = MotionCheck::proven;  ///< how this frame's poses were checked
};

/// The default of SlideBudget::mover_work.
inline constexpr std::uint64_t kMoverWork = 16384;

/// The budget of a frame's slides; commanded paths do not count. A mover that is cut off stops where its last
/// sub-step ended, which is as safe as any other pose.
///
/// `pairs` and `seconds` are of all slides together. They are checked between pairs; a pair that is begun is
/// finished. A sub-step that cannot be checked completely is executed for none of its movers. Plans get equal
/// shares of what is left at a sub-step's begin, so that results do not depend on the movers' order. With
/// either, slides are planned one after the other, on one thread.
///
/// `mover_work` is of each mover by itself, whoever slides beside it and on however many threads. It is
/// checked between sub-steps, and within a plan each time that this would be made once more: what is begun is
/// finished, so that a mover always goes on by one sub-step, and by a plan and its check beyond the budget.
struct SlideBudget {
  /// Near pairs that are planned with, and those whose paths are checked, each once a sub-step: mostly one to
  /// three narrowphase calls, kImpactIterations at most. The same on every machine.
  std::uint64_t pairs = std::numeric_limits<std::uint64_t>::max();
  /// A time by the clock, counted from the first slide [s]; >= 0. Where it cuts off differs from run to run.
  double seconds = kInfinity;
  /// Rows that plans are projected on, each as often, and steps of the projections of an arm, both twice
  /// where it has more than eight joint values and four times beyond sixteen; near pairs, and looks at these
  /// along paths: mostly 0.2 to 1 us each. The same on every machine.
  std::uint64_t mover_work = kMoverWork;
};

/// The guarantees of a world's answers: those of its narrowphase.
struct WorldCapabilities {
  std::string_view narrowphase;
  std::string_view broadphase;
  /// `sampled` with a narrowphase that has no signed distance: it judges the poses that native's separations
  /// lead to (motion/sampled_impact.hpp). An overlap that it does not see is let through.
  MotionCheck check = MotionCheck::proven;
};

/// The gap that worlds keep unless set otherwise [m]; how far motion gets at it: motion/README.md, Progress.
inline constexpr double kDefaultGap = 1e-7;
/// Most sub-steps of slides in one frame.
inline constexpr std::uint32_t kMostSlideSteps = 16;
/// Changes that ContactWorld::selection_record() has room for unless set otherwise.
inline constexpr std::size_t kSelectionRoom = 4096;

/// Objects and mechanisms at run time, moved frame by frame as far as no pair gets closer than the gap
/// allows. Threads and errors: see contact_world.hpp.
class ContactWorld {
 public:
  /// @param gap g [m], finite and > 0. @throws InputError: another gap, no narrowphase or no broadphase.
  ContactWorld(std::unique_ptr<Narrowphase> narrowphase, std::unique_ptr<Broadphase> broadphase,
               double gap = kDefaultGap);
  ~ContactWorld();
  ContactWorld(const ContactWorld&) = delete;
  ContactWorld& operator=(const ContactWorld&) = delete;

  // ---- set-up, at any time between frames

  /// @throws InputError: no tree, a name that is taken, an invalid pose, a 65th group, a rounded solid that
  /// the narrowphase does not take, levels that validate_levels() refuses.
  ObjectHandle add(ObjectDescription description);
  /// @throws InputError: an unknown handle, or an object that carries or is carried.
  void remove(ObjectHandle object);
  /// @throws InputError when the name is unknown.
  ObjectHandle find(std::string_view name) const;
  bool is_alive(ObjectHandle object) const;
  std::string_view name_of(ObjectHandle object) const;

  /// One object for every link that has hexahedra, named `mechanism.link`; rules, selection, latches,
  /// exemptions and events name those. All links are one mover: if one is stopped the whole step goes to the
  /// same fraction. Links of one mechanism are checked against each other but for the pairs that it exempts;
  /// links that no joint moves are static. Links carry objects, and are not carried.
  /// @throws InputError: no mechanism, a name that is taken, an invalid pose, initial values that are not
  /// finite, beyond limits or of another number, weights that are not above 0, a rounded solid as in add().
  MechanismHandle add_mechanism(MechanismPlacement placement);
  /// @throws InputError: an unknown handle, or a link that carries an object.
  void remove_mechanism(MechanismHandle mechanism);
  bool is_alive(MechanismHandle mechanism) const;
  /// @throws InputError: an unknown handle or name, or a link without hexahedra.
  ObjectHandle link(MechanismHandle mechanism, std::string_view name) const;

  /// Sets the rule of pairs whose own rule and groups' rules leave a field unset; EffectiveRule has the
  /// values of fields that it leaves unset, too.
  /// @throws InputError: a warn distance that is no length; so do the next two.
  void set_default_rule(const PairRule& rule);
  /// Sets the rule of every pair with one object in `first` and the other in `second` (the same group: within
  /// it).
  /// @throws InputError: a 65th group, a name that is too long.
  void set_group_rule(std::string_view first, std::string_view second, const PairRule& rule);
  /// Sets a pair's own rule, which comes before all others and ends with either object. @throws InputError:
  /// an unknown handle, one object twice.
  void set_pair_rule(ObjectHandle a, ObjectHandle b, const PairRule& rule);
  /// Returns what the two follow. @throws InputError: an unknown handle.
  EffectiveRule rule_of(ObjectHandle a, ObjectHandle b) const;
  /// The two are not checked until unexempt() takes it back or either object is removed; reset() leaves it. A
  /// second call for the same two changes nothing.
  /// @throws InputError: an unknown handle or hexahedron, one object twice.
  void exempt(const Exemption& pair);
  /// Takes back an exempt() of the same two, in either order, by the same names. Two that overlap then are
  /// reported as `penetrating_at_start` and may move as long as its depth does not grow.
  /// @throws InputError as exempt(), or if they are not exempt; what a latch allows ends with unlatch().
  void unexempt(const Exemption& pair);

  /// `carried` moves with `carrier` from now on, as they stand; what moves as one is not checked against
  /// itself.
  /// @param allowed not checked for as long as the latch holds (both jaws of a gripper against their
  /// payload): until unlatch(), reset() or the removal of either object; then as after unexempt().
  /// @throws InputError: unknown handles, already carried, a cycle, a static object, an allowed pair as
  /// exempt() refuses it.
  void latch(ObjectHandle carrier, ObjectHandle carried, const std::vector<Exemption>& allowed = {});
  /// @throws InputError when it is not carried.
  void unlatch(ObjectHandle carried);

  /// Swaps the narrowphase, which is used from the next frame on. @throws InputError: none given.
  void set_narrowphase(std::unique_ptr<Narrowphase> narrowphase);
  /// @copydoc set_narrowphase
  void set_broadphase(std::unique_ptr<Broadphase> broadphase);

  /// How stiffly the object's hand holds it where it is commanded; used unless the object is carried. None:
  /// the metric of its mass at uniform density instead of a spring, and 1 N/m to scale the reported wrench.
  /// @throws InputError: an unknown handle, a link, a frame that is no pose or further from the object's
  /// origin than a pose that turns about it can keep the gap, stiffnesses out of bounds.
  void set_hand(ObjectHandle object, const std::optional<HandStiffness>& hand);
  /// The same of a mechanism. None, as before the first call: MechanismPlacement's weights of the joints
  /// alone, and no wrench is reported. Slides plan in joint values either way, so a mechanism of more than 32
  /// does not slide.
  /// @throws InputError: an unknown handle or link, a link that no joint moves, a frame that is no pose,
  /// stiffnesses out of bounds or of another number.
  void set_hand(MechanismHandle mechanism, const std::optional<ArmHandStiffness>& hand);
  /// Sets the hand of objects that have none of their own; it is HandStiffness{} unless this is called.
  /// @throws InputError: as before; a tool frame.
  void set_default_hand(const std::optional<HandStiffness>& hand);

  /// Sets the budget of all later frames; it is SlideBudget{} unless this is called. @throws InputError:
  /// seconds < 0 or NaN.
  void set_slide_budget(const SlideBudget& budget);
  const SlideBudget& slide_budget() const;

  /// Frames run on `count` threads from the next one on, the caller's among them; the others are this world's
  /// and sleep in between. Reports, events and poses are the same with any number, bit by bit; a frame that
  /// has little to do wakes none. One, unless this is called: most worlds are small, their frames take less
  /// than waking a thread, and who steps several worlds has better use for the processors.
  /// @throws InputError: 0, or more than 64; std::system_error: the system has no more. Nothing changed then.
  void set_threads(std::size_t count);
  /// The same, on the caller's threads, TaskRunner::threads() at once (64 at most); not while the caller's
  /// runner is in use otherwise. Borrowed until the world ends, or the next call of this or set_threads(). A
  /// narrowphase that is not thread safe (Capabilities) is asked on one thread all the same. Null: none.
  void set_task_runner(TaskRunner* runner);

  WorldCapabilities capabilities() const;

  /// Takes up all set-up so far: what may allocate is done here.
  /// @throws InputError: what build() of the backends refuses, a broadphase without paths
  /// (Broadphase::update_paths()).
  void prepare();
  /// Restores the initial poses, ends all latches, selects everything and drops queued changes; objects,
  /// rules and exemptions stay. Contacts are forgotten: no `ended` is reported for them.
  void reset();

  // ---- selection, from any thread

  /// Queues a change, which comes into force at the start of the next frame unless reset() comes first.
  /// Handles and names are looked up then: a change whose object has been removed is refused, even where
  /// another has its slot. Allocates, on the caller's thread, where more than 1 024 wait for one frame; a
  /// frame does where more than 1 024 of them are refused or more than 65 536 pairs are off by themselves.
  void select(const SelectionChange& change);
  /// The changes that came into force, with their frames, for a replay: the first ones since the world was
  /// made or the record was cleared, as many as there is room for. Later ones are left out and counted, so
  /// that no frame allocates; FrameReport::selections has all changes of a frame.
  std::span<const SelectionRecord> selection_record() const;
  /// The number of changes that were left out; 0: the record is complete.
  std::uint64_t selections_left_out() const;
  /// Set-up, between frames: clears the record. @param room for changes from now on.
  void begin_selection_record(std::size_t room = kSelectionRoom);

  // ---- frames

  /// A command to a pose; the object turns from the actual one by the smaller angle. @throws InputError: an
  /// unknown handle.
  MotionCommand go_to(ObjectHandle object, const Pose& X_WO) const;
  /// @param displacement_W [m]. @param turn_W axis times angle [rad], of any size.
  /// @throws InputError: an unknown handle.
  MotionCommand move_by(ObjectHandle object, const Vector3& displacement_W, const Vector3& turn_W) const;
  /// Moves what is commanded as far as the rules allow. A bad command is reported and its object stays.
  /// Where a mover has several commands, the last valid one counts.
  FrameReport frame(std::span<const MotionCommand> commands,
                    std::span<const JointCommand> joint_commands = {});

  /// X_WO at the end of the last frame. @throws InputError: an unknown handle.
  const Pose& actual_pose(ObjectHandle object) const;
  /// X_WO of the object's last valid command; its initial pose before the first. @throws InputError: an
  /// unknown handle.
  const Pose& commanded_pose(ObjectHandle object) const;
  /// X_WS of the object's solids; empty between set-up and the prepare() or frame() that takes it up.
  /// Valid until the next prepare() or frame().
  std::span<const Pose> solid_poses(ObjectHandle object) const;
  double gap() const;

  // ---- mechanisms; all throw InputError for an unknown handle

  /// The actual joint values; valid until the mechanism is removed.
  std::span<const double> joint_values(MechanismHandle mechanism) const;
  /// The joint values of the last valid command, clamped to the limits.
  std::span<const double> commanded_joints(MechanismHandle mechanism) const;
  /// X_WL of every link, those without hexahedra too, in the order of Mechanism::links().
  std::span<const Pose> link_poses(MechanismHandle mechanism) const;

  /// The last frame's executed motion: part 0 is the commanded paths up to where they were stopped, then come
  /// the sub-steps of slides, each with an s of its own from 0 to 1. A mover that is taken back by a pair
  /// that holds stays at its start for the whole part.
  std::size_t executed_parts() const;
  /// X_WO at s of a part; the actual one of what did not move. @throws InputError: an unknown handle.
  Pose executed_pose(ObjectHandle object, std::size_t part, double s) const;
  /// @param out one a joint value. @throws InputError: an unknown handle, or of another size.
  void executed_joints(MechanismHandle mechanism, std::size_t part, double s, std::span<double> out) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace touchstone
