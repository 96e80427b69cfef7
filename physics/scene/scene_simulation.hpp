#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "touchstone/physics/bodies/latch.hpp"
#include "touchstone/physics/contacts/touch_events.hpp"
#include "touchstone/physics/scene/dynamic_scene.hpp"
#include "touchstone/physics/scene/scene_latches.hpp"

namespace touchstone::physics {

/// Runs a dynamic scene step by step over the contacts of one narrowphase:
///
///     SceneSimulation run(scene, [&] { return std::make_unique<NarrowphaseContacts>(...); });
///     while (!run.is_over()) { run.begin_step(); run.find_contacts(); run.advance(); }
///
/// Set-up throws InputError. The three parts of a step do not throw, and do not allocate unless more contacts
/// come up than there is memory for (kReservedContacts, or what reserve() was given) or a backend does:
/// latches and releases change the world in place. One thread.
class SceneSimulation {
 public:
  static constexpr std::size_t kReservedContacts = 128;

  /// Empty contacts with the scene's margin, made once.
  using MakeContacts = std::function<std::unique_ptr<NarrowphaseContacts>()>;

  /// Keeps a reference to `scene`. @throws InputError as validate(DynamicScene), and what `make` and the
  /// backends refuse.
  SceneSimulation(const DynamicScene& scene, MakeContacts make);
  SceneSimulation(DynamicScene&&, MakeContacts) = delete;
  ~SceneSimulation();

  /// Memory for this many contacts at a time: bodies that rest on a floor have up to four each, in a pile
  /// more. Between steps; allocates. @throws std::bad_alloc, std::length_error where there is not so much
  void reserve(std::size_t contacts);

  /// All that the run has come to: states, latches, drives, what the next step starts from. Good for this
  /// simulation alone. @see restore()
  class Snapshot;
  Snapshot snapshot() const;
  /// Back to then: from there the run takes the same steps to the bit. Events start anew. Does not allocate.
  /// @throws InputError: of another simulation.
  void restore(const Snapshot& snapshot);
  /// Back to the start, as just made.
  void reset();

  /// From now on touches() reports what touches; off it costs nothing. Off at the start.
  void watch_touches(bool is_watched);
  /// Pairs of solids that began to touch in the last step, went on touching, or parted; numbers as
  /// solid_name() counts.
  const TouchEvents& touches() const { return touches_; }
  /// Whether contacts of the pair are not looked for because something sleeps and neither of the two is moved
  /// by forces or commands. Numbers as solid_name() counts.
  bool are_asleep(const SolidPair& solids) const;

  /// Closes DynamicScene::latch_options[option], or opens the latch that carries the object. Between steps;
  /// the next step has the change. @return false, and nothing has changed: the object is carried already, or
  /// not carried, or the latches would close a cycle or make an inertia that begin_step() refuses.
  bool latch_now(std::size_t option);
  bool release_now(std::size_t carried);

  /// Carries out an action now, whatever its time, as begin_step() does those of the scene; ramps begin now.
  /// What a latch allows are the pairs of the scene's latch option, latch or action of the same two, if there
  /// is one. Between steps; the next step has the change.
  /// @throws InputError, and nothing has changed: validate_action(); pairs that the action itself allows;
  /// an inertia that begin_step() refuses.
  void act(const SceneAction& action);

  /// A joint's value and rate from now on, as if it had always been there; its drive stays. What it carries
  /// goes along, through whatever is in its way. Between steps; does not allocate.
  /// @throws InputError: no such joint, a fixed one, a value out of its limits, figures that are not finite.
  void set_joint(const JointAddress& joint, double value, double rate);

  /// Takes a free object out of the world: it stays where it is, without velocity, and touches nothing. What
  /// slept on it wakes. Between steps; does not allocate.
  /// @throws InputError: no such object, not a free one of its own (a carrier, one that is carried, one with
  /// a joint between bodies), one that is out.
  void remove(std::size_t object);
  /// Brings it in again, or for the first time. What is there then is parted as other overlaps are. Does not
  /// allocate. @param v_W of its centre of mass [m/s] @param w_W [rad/s]
  /// @throws InputError: as remove(), one that is in, a bad pose, velocities that are not finite.
  void add(std::size_t object, const Pose& X_WO, const Vector3& v_W, const Vector3& w_W);
  bool has(std::size_t object) const { return !pieces_[object].is_out; }
  /// What the contacts' narrowphase answers has changed otherwise than by poses: all are found anew, and what
  /// sleeps wakes. Between steps; does not allocate.
  void look_anew();

  bool is_over() const { return steps_ >= scene_->step_count(); }
  std::uint64_t steps() const { return steps_; }  ///< taken
  double time() const { return static_cast<double>(steps_) * scene_->step; }

  /// Takes the commands for this step: actions that are due, drives, velocities of kinematic bodies. An
  /// action is not carried out where a body would have an invalid inertia to rounding (some 1e7 of its sizes
  /// from end to end), nor where what a program did meanwhile leaves no place for it (a latch of what is
  /// carried, a release of what is not, objects that come or go while they are latched): advance() then
  /// fails with StepFailure::latch, and so does every step until the action has its place.
  void begin_step();
  std::span<const Contact> find_contacts();
  /// Over the contacts found. On failure nothing has moved and the time is as before; what begin_step()
  /// commanded stays.
  StepReport advance();

  const DynamicScene& scene() const { return *scene_; }
  const DynamicsWorld& world() const { return *world_; }
  const NarrowphaseContacts& detection() const { return *contacts_; }
  /// Counts what moves with what: 1 at the start, one more after every step that latched or released
  /// something.
  std::uint64_t worlds() const { return worlds_; }
  /// `contacts`, empty, gets what this simulation's own has: for a second opinion on where the world stands.
  /// Good until worlds() counts on. @throws InputError: what the backends refuse.
  void fill(NarrowphaseContacts& contacts) const;
  /// The last step's contacts, and a force for each.
  std::span<const Contact> contacts() const { return found_; }
  std::span<const ContactForce> forces() const { return std::span(forces_).first(found_.size()); }
  /// `object/hexahedron` of a solid as NarrowphaseContacts counts it, and its object.
  const std::string& solid_name(SolidIndex solid) const { return solid_names_[solid]; }
  std::size_t object_of(SolidIndex solid) const { return object_of_[solid]; }

  Pose object_pose(std::size_t object) const;
  /// The velocity of the centre of mass of the body that the object is, or is part of; nothing for links and
  /// fixed objects.
  std::optional<Vector3> velocity(std::size_t object) const;
  std::optional<Vector3> angular_velocity(std::size_t object) const;
  /// The index in world() of the body that the object moves with; nothing where that is not dynamic, or out.
  std::optional<std::uint32_t> dynamic_body(std::size_t object) const;
  /// The object that it moves with: itself unless it is carried.
  std::size_t root_of(std::size_t object) const { return pieces_[object].root; }
  /// The object that carries it, or kNoObject, and what their latch allows.
  std::size_t carrier_of(std::size_t object) const { return pieces_[object].carrier; }
  std::span<const ExemptPair> allowed_with(std::size_t object) const;
  /// Its body or link in world().
  const Mover& mover_of(std::size_t object) const { return pieces_[object].mover; }
  /// Pose of the object in the frame F of its body or link; of a fixed object, in the root object's frame.
  const Pose& pose_within(std::size_t object) const { return pieces_[object].X_FO; }
  /// Links that fixed joints make one.
  bool are_one(std::size_t a, std::size_t b) const { return cluster_[a] == cluster_[b]; }
  /// With the objects' hexahedra in its links, which are named as the objects; the base stands in the world's
  /// frame.
  const MechanismDynamics& dynamics_of(std::size_t mechanism) const { return *arms_[mechanism]->dynamics; }
  /// Between steps: states, drives and forces that come from outside (a hand, a guard).
  DynamicsWorld& world_to_set() { return *world_; }

  /// The joint of world() that a joint between bodies is: their numbers are the same.
  WorldJointState body_joint(std::size_t joint) const {
    return world_->joint_state(static_cast<std::uint32_t>(joint));
  }
  double joint_value(const JointAddress& joint) const;
  double joint_rate(const JointAddress& joint) const;
  double joint_torque(const JointAddress& joint) const;
  /// The name of whose state made the step fail: "object 'x'", "mechanism 'm'", "'x/solid' and 'y/solid'";
  /// empty for other failures.
  std::string failed_name(const StepReport& report) const;

 private:
  /// Latches are counted through the scene's own, then its actions, then its options.

  /// Where an object is: in the frame F of what it moves with (of a body or of a mechanism's link).
  struct Piece {
    std::size_t root;
    std::size_t carrier = kNoObject;
    std::size_t latch = kNoLatch;  // that carries it
    bool is_out = false;           // of the world
    Pose X_FO;
    Mover mover;                    // of the root
    Mover root_mover;               // where it is a root
    std::string name;               // for messages
    std::optional<RigidBody> body;  // roots that are dynamic: with all that they carry
    Pose X_WF;                      // roots that are fixed
  };
  struct Arm {
    Mechanism mechanism;
    std::vector<BodyInertia> links;  // with what they carry
    std::unique_ptr<MechanismDynamics> dynamics;
    std::vector<std::uint32_t> value_of;  // by joint; kNone: fixed
    std::vector<SceneDrive> drives;       // by joint
    std::vector<double> drives_since;     // [s]
    std::vector<double> qd;               // at the start; of a capture
    std::optional<CaptureScratch> scratch;
  };
  /// Two solids that are not checked, because they are listed: where a latch allows them, while that very one
  /// holds `carried`.
  struct ListedPair {
    SolidPair solids;
    std::size_t carried = kNoObject;
    std::size_t latch = kNoLatch;
  };

  // scene_simulation_setup.cpp
  void place_objects();
  void make_links(std::size_t mechanism, std::span<const Pose> X_WL);
  void make_arm(std::size_t mechanism);
  void build_world();
  void make_body_joints();
  void name_solids();
  void list_exempt();
  void list_exempt(std::span<const ExemptPair> pairs, std::size_t carried, std::size_t latch);
  void exempt_pairs(NarrowphaseContacts& contacts) const;
  std::vector<std::size_t> find_clusters() const;

  // scene_simulation_latches.cpp
  bool may_latch(std::size_t carrier, std::size_t carried) const;
  bool carry_out(const SceneAction& action, std::size_t latch);
  void latch(std::size_t carrier, std::size_t carried, std::size_t latch);
  void capture_by_link(const Mover& link, const RigidBody& body, const RigidBodyState& state);
  void release(std::size_t carried);
  RigidBodyState released_state(std::size_t root, const RigidBody& part, const Pose& X_FG) const;
  bool is_carried_by(std::size_t object, std::size_t carrier) const;
  BodyInertia inertia_of_part(std::size_t carried) const;
  BodyInertia inertia_without(std::size_t root, std::size_t carried) const;
  Pose root_pose(std::size_t root) const;
  Pose pose_in_mover(const Piece& piece) const;
  bool is_commanded(std::size_t object) const;
  void change_contacts();
  void require_free(std::size_t object, bool is_out, const char* call) const;
  void come(std::size_t object, const Pose& X_WO, const Vector3& v_W, const Vector3& w_W);
  void go(std::size_t object);
  static std::uint32_t index_of(std::size_t object) { return static_cast<std::uint32_t>(object); }

  // scene_simulation_state.cpp
  void take_touches();
  bool rests(std::size_t object) const;

  // scene_simulation.cpp
  void set_drive(const JointAddress& joint, const SceneDrive& drive);
  void apply_drive(const JointAddress& joint);
  void apply_body_drive(std::size_t joint);
  void move_kinematic(std::size_t object);
  bool is_due(const SceneAction& action) const;

  BodyKind kind_of(std::size_t object) const { return scene_->bodies[object].kind; }
  const std::string& name_of(std::size_t object) const { return scene_->scene.objects[object].tree.name(); }

  const DynamicScene* scene_;
  MakeContacts make_;
  std::vector<Piece> pieces_;  // by object
  std::vector<std::unique_ptr<Arm>> arms_;
  std::unique_ptr<DynamicsWorld> world_;
  std::unique_ptr<NarrowphaseContacts> contacts_;
  std::vector<SceneDrive> body_drives_;    // by joint between bodies
  std::vector<double> body_drives_since_;  // [s]
  std::vector<ListedPair> listed_;
  std::vector<std::size_t> cluster_;  // by object: fixed joints make links one
  std::vector<std::string> solid_names_;
  std::vector<std::size_t> object_of_;
  std::span<const Contact> found_;
  std::vector<ContactForce> forces_;
  std::size_t next_action_ = 0;
  bool is_refused_ = false;  // the next action
  std::uint64_t steps_ = 0, worlds_ = 0;
  std::unique_ptr<Snapshot> initial_;
  TouchEvents touches_;
  bool is_watched_ = false;
  std::size_t reserved_ = kReservedContacts;
  std::vector<double> joint_q_, joint_qd_;                          // of set_joint()
  std::shared_ptr<const int> id_ = std::make_shared<const int>(0);  // snapshots know it: addresses come again
};

/// @see SceneSimulation::snapshot()
class SceneSimulation::Snapshot {
 public:
  /// When it was taken, in steps.
  std::uint64_t steps() const { return steps_; }

 private:
  friend class SceneSimulation;
  explicit Snapshot(const DynamicsWorld& world) : world_(world) {}

  std::shared_ptr<const int> of_;
  DynamicsWorld world_;
  std::vector<Piece> pieces_;
  std::vector<std::vector<BodyInertia>> links_;  // by mechanism
  std::vector<std::vector<SceneDrive>> drives_;
  std::vector<std::vector<double>> drives_since_;
  std::vector<SceneDrive> body_drives_;
  std::vector<double> body_drives_since_;
  std::size_t next_action_ = 0;
  bool is_refused_ = false;
  std::uint64_t steps_ = 0;
};

}  // namespace touchstone::physics
