#include <algorithm>
#include <array>
#include <cmath>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/contact_core/scene/scene_instance.hpp"
#include "touchstone/physics/guarded/guarded_simulation.hpp"

// Set-up: who follows which policy, the contact world beside the dynamics.

namespace touchstone::physics {
namespace {

constexpr std::size_t kMostPairsListed = 1024;
/// With less, bodies that touch in dynamics are too near in the world.
constexpr double kLeastGaps = 10.0;

std::vector<std::uint32_t> object_of_solids(const Scene& scene) {
  std::vector<std::uint32_t> out;
  for (std::size_t i = 0; i < scene.objects.size(); ++i)
    out.insert(out.end(), scene.objects[i].tree.solids().size(), static_cast<std::uint32_t>(i));
  return out;
}

ContactPolicy policy_in_world(GuardPolicy policy) {
  constexpr std::array<ContactPolicy, 5> kPolicies{ContactPolicy::cue, ContactPolicy::hold,
                                                   ContactPolicy::advance, ContactPolicy::slide,
                                                   ContactPolicy::slide};
  return kPolicies[static_cast<std::size_t>(policy)];
}

const DynamicScene& checked(const DynamicScene& scene, const GuardSettings& settings) {
  validate(scene);
  for (const SceneAction& action : scene.actions)
    if (action.kind == SceneAction::Kind::add || action.kind == SceneAction::Kind::remove)
      throw InputError(action.where + "guard: object '" + scene.scene.objects[action.carried].tree.name() +
                       "': nothing comes or goes in a guarded scene");
  if (!std::isfinite(settings.gap) || !(settings.gap >= kLeastGaps * scene.scene.contact_gap))
    throw InputError("guard: the gap is less than 10 times the scene's contact_gap");
  return scene;
}

}  // namespace

std::string_view to_string(GuardPolicy policy) {
  constexpr std::array<std::string_view, 5> kNames{"cue", "hold", "advance", "slide", "push"};
  return kNames[static_cast<std::size_t>(policy)];
}

GuardedSimulation::GuardedSimulation(const DynamicScene& scene, const GuardSettings& settings,
                                     MakeNarrowphase proof, MakeBroadphase broadphase,
                                     MakeNarrowphase contacts)
    : scene_(&checked(scene, settings)),
      surfaces_(surface_pairs(scene)),
      settings_(settings),
      make_proof_(std::move(proof)),
      make_broadphase_(std::move(broadphase)),
      object_of_solid_(object_of_solids(scene.scene)),
      pushed_(std::make_shared<SeenPairs>(object_of_solid_, scene.scene.objects.size())),
      sliding_(std::make_shared<SeenPairs>(object_of_solid_, scene.scene.objects.size())),
      guarded_(std::make_shared<SeenPairs>(object_of_solid_, scene.scene.objects.size())),
      simulation_(scene,
                  [&] {
                    set_policies();
                    auto found = std::make_unique<NarrowphaseContacts>(
                        make_broadphase_(),
                        std::make_unique<GapNarrowphase>(contacts ? contacts() : make_proof_(), settings_.gap,
                                                         pushed_),
                        scene_->contact_margin + settings_.gap);
                    found->keep_edges();  // the proof stops what would pass there
                    return found;
                  }),
      world_(make_proof_(), make_broadphase_(), settings_.gap),
      impulses_(simulation_),
      follower_(simulation_),
      are_joined_(scene.joints.size(), 0) {
  world_.set_slide_budget(settings_.slides);
  // The world that guards holds the scene's objects before its first frame is made.
  fill_world();
  fill_touching();
  frame_ = world_.frame({});  // so that its memory is there
}

/// An object's own name, or one of its groups'.
bool GuardedSimulation::names(const std::string& name, std::size_t object) const {
  const SceneObject& source = scene_->scene.objects[object];
  return source.tree.name() == name ||
         std::find(source.groups.begin(), source.groups.end(), name) != source.groups.end();
}

void GuardedSimulation::set_policy(std::size_t a, std::size_t b, GuardPolicy policy) {
  const std::size_t n = scene_->scene.objects.size();
  policies_[a * n + b] = policies_[b * n + a] = policy;
  see(a, b);
}

// An object that is switched off, or out, meets nothing.
void GuardedSimulation::see(std::size_t a, std::size_t b) {
  const bool are_on = is_on_[a] != 0 && is_on_[b] != 0 && is_out_[a] == 0 && is_out_[b] == 0;
  const GuardPolicy rule = policies_[a * is_on_.size() + b];  // before there are objects, too
  pushed_->set(a, b, are_on && rule == GuardPolicy::push);
  sliding_->set(a, b, are_on && (rule == GuardPolicy::push || rule == GuardPolicy::slide));
  guarded_->set(a, b, are_on && rule != GuardPolicy::cue);
}

void GuardedSimulation::set_policies() {
  const std::size_t n = scene_->scene.objects.size();
  is_on_.resize(n, 1);
  is_out_.resize(n, 0);
  policies_.assign(n * n, settings_.policy);
  for (std::size_t a = 0; a < n; ++a)
    for (std::size_t b = 0; b < n; ++b) set_policy(a, b, settings_.policy);
  for (const GuardRule& rule : settings_.rules) {
    std::array<bool, 2> is_known{false, false};
    for (std::size_t a = 0; a < n; ++a) {
      is_known[0] = is_known[0] || names(rule.first, a);
      is_known[1] = is_known[1] || names(rule.second, a);
      for (std::size_t b = 0; b < n; ++b)
        if (a != b && names(rule.first, a) && names(rule.second, b)) set_policy(a, b, rule.policy);
    }
    for (const std::size_t i : {0, 1})
      if (!is_known[i])
        throw InputError("guard: the scene has no object or group '" + (i == 0 ? rule.first : rule.second) +
                         "'");
  }
}

void GuardedSimulation::fill_world() {
  const Scene& scene = scene_->scene;
  world_.set_default_rule({.policy = policy_in_world(settings_.policy)});
  // Mechanisms come first, since links refer to them.
  for (std::size_t m = 0; m < scene_->mechanisms.size(); ++m) {
    const Mechanism& mechanism = simulation_.dynamics_of(m).mechanism();
    const std::span<const double> q = simulation_.world().joint_values(static_cast<std::uint32_t>(m));
    // The simulation outlives the world, whose share of the mechanism owns nothing.
    mechanisms_.push_back(world_.add_mechanism(
        {std::shared_ptr<const Mechanism>(std::shared_ptr<void>(), &mechanism), {}, {q.begin(), q.end()}}));
    joint_commands_.push_back({mechanisms_.back(), q});
    still_.resize(std::max(still_.size(), q.size()), 0.0);
  }
  // Each object is added, or found as a link, and is indexed by its slot.
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    const SceneObject& object = scene.objects[i];
    const SceneBody& body = scene_->bodies[i];
    if (body.kind == BodyKind::link) {
      const Mover& mover = simulation_.mover_of(i);
      objects_.push_back(world_.link(mechanisms_[mover.index], object.tree.name()));
    } else {
      objects_.push_back(
          world_.add({std::shared_ptr<const HexahedronTree>(std::shared_ptr<void>(), &object.tree),
                      simulation_.object_pose(i), body.kind == BodyKind::fixed}));
    }
    if (object_of_slot_.size() <= objects_[i].slot) object_of_slot_.resize(objects_[i].slot + 1);
    object_of_slot_[objects_[i].slot] = i;
  }
  // Pair rules, exemptions and latches follow the scene.
  set_pair_rules();
  exempt_in_world();
  carrier_.assign(objects_.size(), kNoObject);
  take_up_latches();
  // Memory for the steps is reserved.
  commands_.reserve(objects_.size());
  movers_.reserve(objects_.size());
  const std::size_t units = simulation_.world().body_count() + mechanisms_.size();
  is_cut_.assign(units, 0);
  cut_contacts_.reserve(CutImpulses::kMostContacts);
  if (follower_.any()) events_.reserve(kMostPairsListed);
  standing_.assign(units, 0);
  world_.prepare();
}

std::vector<Exemption> GuardedSimulation::exemptions(std::span<const ExemptPair> pairs) const {
  const Scene& scene = scene_->scene;
  std::vector<std::size_t> first_solid(scene.objects.size() + 1, 0);
  for (std::size_t i = 0; i < scene.objects.size(); ++i)
    first_solid[i + 1] = first_solid[i] + scene.objects[i].tree.solids().size();
  const auto name = [&](SolidIndex solid) {
    const std::size_t object = object_of_solid_[solid];
    return scene.objects[object].tree.solids()[solid - first_solid[object]].name;
  };
  std::vector<Exemption> out;
  for (const ExemptPair& pair : pairs)
    for (const SolidIndex a : find_solids(scene, pair.first))
      for (const SolidIndex b : find_solids(scene, pair.second))
        if (object_of_solid_[a] != object_of_solid_[b])
          out.push_back({objects_[object_of_solid_[a]], objects_[object_of_solid_[b]], name(a), name(b)});
  return out;
}

/// As SceneSimulation has it, but for kinematic objects against fixed ones.
void GuardedSimulation::exempt_in_world() {
  for (const Exemption& pair : exemptions(scene_->scene.exempt_pairs)) world_.exempt(pair);
  for (const SceneMechanism& mechanism : scene_->mechanisms)
    for (const SceneJoint& joint : mechanism.joints)
      if (joint.parent != kNoObject) world_.exempt({objects_[joint.parent], objects_[joint.child]});
  for (std::size_t a = 0; a < objects_.size(); ++a)
    for (std::size_t b = a + 1; b < objects_.size(); ++b)
      if (simulation_.are_one(a, b)) world_.exempt({objects_[a], objects_[b]});
  follow_joints();
}

/// By a joint of a mechanism, or as one link: exempt for good.
bool GuardedSimulation::is_joined(std::size_t a, std::size_t b) const {
  if (simulation_.are_one(a, b)) return true;
  for (const SceneMechanism& mechanism : scene_->mechanisms)
    for (const SceneJoint& joint : mechanism.joints)
      if ((joint.parent == a && joint.child == b) || (joint.parent == b && joint.child == a)) return true;
  return false;
}

/// Pairs of objects that joints between bodies join, as dynamics has it: while one of them holds.
void GuardedSimulation::follow_joints() {
  const auto holds = [&](std::size_t j) {
    return simulation_.world().world_joint(static_cast<std::uint32_t>(j)).is_on;
  };
  for (std::size_t j = 0; j < scene_->joints.size(); ++j) {
    const SceneBodyJoint& joint = scene_->joints[j];
    if (joint.parent == kNoObject || is_joined(joint.parent, joint.child)) continue;
    bool is_first = true, any_holds = false;  // several of a pair: the first speaks for all
    for (std::size_t k = 0; k < scene_->joints.size(); ++k) {
      const SceneBodyJoint& other = scene_->joints[k];
      const bool is_same = (other.parent == joint.parent && other.child == joint.child) ||
                           (other.parent == joint.child && other.child == joint.parent);
      is_first = is_first && !(is_same && k < j);
      any_holds = any_holds || (is_same && holds(k));
    }
    if (!is_first || any_holds == (are_joined_[j] != 0)) continue;
    const Exemption pair{objects_[joint.parent], objects_[joint.child]};
    any_holds ? world_.exempt(pair) : world_.unexempt(pair);
    are_joined_[j] = any_holds ? 1 : 0;
  }
}

/// Follows the latches and releases of the simulation since the last call; allocates.
void GuardedSimulation::take_up_latches() {
  for (std::size_t i = 0; i < objects_.size(); ++i)
    if (carrier_[i] != kNoObject && simulation_.carrier_of(i) != carrier_[i]) {
      world_.unlatch(objects_[i]);
      carrier_[i] = kNoObject;
    }
  for (std::size_t i = 0; i < objects_.size(); ++i) {
    const std::size_t carrier = simulation_.carrier_of(i);
    if (carrier == carrier_[i]) continue;
    world_.latch(objects_[carrier], objects_[i], exemptions(simulation_.allowed_with(i)));
    carrier_[i] = carrier;
  }
  latched_ = simulation_.worlds();
}

/// Points of pairs that slide or push, where they have come within the gap.
void GuardedSimulation::fill_touching() {
  touching_ = std::make_unique<NarrowphaseContacts>(
      make_broadphase_(), std::make_unique<GapNarrowphase>(make_proof_(), settings_.gap, sliding_),
      settings_.gap);
  touching_->keep_edges();
  simulation_.fill(*touching_);
  touching_->reserve(SceneSimulation::kReservedContacts, kMostPairsListed);
  touching_->find(simulation_.world());
}

/// Pairs that rules name keep the rule that they were given, whatever the others' is.
void GuardedSimulation::set_pair_rules() {
  for (std::size_t a = 0; a < objects_.size(); ++a)
    for (std::size_t b = a + 1; b < objects_.size(); ++b)
      if (policy_in_world(policy(a, b)) != policy_in_world(settings_.policy))
        world_.set_pair_rule(objects_[a], objects_[b], {.policy = policy_in_world(policy(a, b))});
}

void GuardedSimulation::set_policy(GuardPolicy policy) {
  settings_.policy = policy;
  set_policies();
  look_anew();
  world_.set_default_rule({.policy = policy_in_world(policy)});
  set_pair_rules();
  world_.prepare();
}

/// After see(): what rests keeps no contact that there is none of now.
void GuardedSimulation::look_anew() {
  simulation_.look_anew();
  if (touching_) touching_->look_anew();
}

/// Dynamics and the proof see the object if it is on and in, from now on.
void GuardedSimulation::show(std::size_t object) {
  for (std::size_t b = 0; b < objects_.size(); ++b)
    if (b != object) see(object, b);
  look_anew();
  world_.select(SelectionChange::of(objects_[object], is_on_[object] != 0 && is_out_[object] == 0));
  world_.prepare();
}

void GuardedSimulation::select(std::size_t object, bool is_on) {
  if (object >= objects_.size()) throw InputError("guard: no object " + std::to_string(object));
  is_on_[object] = is_on ? 1 : 0;
  show(object);
}

void GuardedSimulation::remove(std::size_t object) {
  simulation_.remove(object);
  is_out_[object] = 1;
  show(object);
}

/// What the object is within half of the gap of, where dynamics has it; kNoObject: nothing.
std::size_t GuardedSimulation::too_near(std::size_t object) const {
  NarrowphaseContacts near(make_broadphase_(),
                           std::make_unique<GapNarrowphase>(make_proof_(), 0.5 * settings_.gap, guarded_),
                           settings_.gap);
  near.keep_edges();
  simulation_.fill(near);
  near.find(simulation_.world());
  for (const ContactOrigin& origin : near.origins()) {
    const std::size_t a = simulation_.object_of(origin.solids.a), b = simulation_.object_of(origin.solids.b);
    if ((a == object || b == object) && !(origin.separation > 0.0)) return a == object ? b : a;
  }
  return kNoObject;
}

void GuardedSimulation::add(std::size_t object, const Pose& X_WO, const Vector3& v_W, const Vector3& w_W) {
  simulation_.add(object, X_WO, v_W, w_W);
  is_out_[object] = 0;
  for (std::size_t b = 0; b < objects_.size(); ++b)
    if (b != object) see(object, b);
  // Where there is no room it goes back to where it was.
  if (const std::size_t other = too_near(object); other != kNoObject) {
    simulation_.remove(object);
    simulation_.add(object, shown_pose(object), Vector3::Zero(), Vector3::Zero());
    remove(object);
    throw InputError("guard: " + object_name(*scene_, object) + " would come within the gap of " +
                     object_name(*scene_, other));
  }
  // It goes there while it meets nothing.
  const MotionCommand command{objects_[object], RigidPath::between(shown_pose(object), X_WO)};
  frame_ = world_.frame({&command, 1});
  show(object);
}

/// Takes a latch or a release over into the proof, and into the pairs whose impulses count as touching.
void GuardedSimulation::follow_latches() {
  take_up_latches();
  follow_joints();
  fill_touching();
  world_.prepare();
}

bool GuardedSimulation::latch_now(std::size_t option) {
  if (!simulation_.latch_now(option)) return false;
  follow_latches();
  return true;
}

bool GuardedSimulation::release_now(std::size_t carried) {
  if (!simulation_.release_now(carried)) return false;
  follow_latches();
  return true;
}

std::size_t GuardedSimulation::add_hand(const GuardedHand& hand) {
  if (hand.link >= objects_.size() || simulation_.mover_of(hand.link).kind != Mover::Kind::link)
    throw InputError("guard: a hand flies a link of a mechanism");
  const Mover& mover = simulation_.mover_of(hand.link);
  const Mechanism& mechanism = simulation_.dynamics_of(mover.index).mechanism();
  hands_.push_back({hand, mover.index, mover.link, ResolvedRate(mechanism, mover.link, hand.rates),
                    std::vector<Pose>(mechanism.links().size()), std::vector<double>(mechanism.value_count()),
                    Twist{Vector3::Zero(), Vector3::Zero()}});
  return hands_.size() - 1;
}

}  // namespace touchstone::physics
