#include "touchstone/examples/training_run/flight/contact_world_method.hpp"

#include <algorithm>

#include "touchstone/contact_core/broadphase/register_broadphases.hpp"
#include "touchstone/contact_core/native/native.hpp"
#include "touchstone/contact_core/world/scene_world.hpp"

namespace touchstone::training {

ContactWorldMethod::ContactWorldMethod(const Setting& setting, std::unique_ptr<Narrowphase> narrowphase,
                                       std::unique_ptr<Broadphase> broadphase)
    : setting_(&setting),
      backend_(narrowphase->name()),
      world_(std::move(narrowphase), std::move(broadphase), setting.scene().contact_gap),
      formation_(setting.object_count()) {
  add_objects();
  set_rules(setting.scene(), objects_, world_);
  world_.set_default_rule(
      {setting.scene().policy, {}, setting.script().translation_only, setting.scene().passive});
  for (const Exemption& pair : exemptions(setting.instance().exempt_pairs())) world_.exempt(pair);
  commands_.reserve(setting.script().hands.size());
  joint_commands_.reserve(setting.arms().size());
  joints_.resize(setting.value_count());
  for (const Arm& arm : setting.arms()) take_joints(arm);
  for (const ObjectHandle object : objects_) feed_.show(object);
  world_.prepare();
}

void ContactWorldMethod::act(const Action& action) {
  using Kind = OperatorAction::Kind;
  if (action.kind == Kind::latch) {
    world_.latch(objects_[action.carrier], objects_[action.object], exemptions(action.allowed));
    latches_.push_back(action);
  }
  if (action.kind == Kind::release) {
    world_.unlatch(objects_[action.object]);
    std::erase_if(latches_, [&](const Action& latch) { return latch.object == action.object; });
  }
  if (action.kind == Kind::switch_on || action.kind == Kind::switch_off)
    world_.select(SelectionChange::of(objects_[action.object], action.kind == Kind::switch_on));
  formation_.apply(action, X_WO_);
  world_.prepare();
}

void ContactWorldMethod::frame(std::span<const Command> commands, std::span<const ArmCommand> arm_commands,
                               FlightLog& log) noexcept {
  commands_.clear();
  for (const Command& command : commands) commands_.push_back({objects_[command.object], command.path});
  joint_commands_.clear();
  for (const ArmCommand& command : arm_commands)
    joint_commands_.push_back({mechanisms_[index_of(*command.arm)], command.values});
  report_ = world_.frame(commands_, joint_commands_);
  for (const Arm& arm : setting_->arms()) take_joints(arm);
  for (std::size_t i = 0; i < objects_.size(); ++i) X_WO_[i] = world_.actual_pose(objects_[i]);
  for (const ContactEvent& event : report_.events) log_event(event, log);
  log.slide_steps.back() = static_cast<std::uint8_t>(report_.slide_steps);
  log.queries += report_.queries;
  log.iteration_limits += report_.iteration_limits;
  ++frame_;
}

void ContactWorldMethod::send(double time) noexcept {
  report_.frame = frame_;  // poses at the end of that many frames
  feed_.send(report_, time);
}

std::size_t ContactWorldMethod::index_of(const Arm& arm) const noexcept {
  std::size_t index = 0;
  while (setting_->arms()[index].first_object != arm.first_object) ++index;
  return index;
}

void ContactWorldMethod::take_joints(const Arm& arm) noexcept {
  const std::span<const double> values = world_.joint_values(mechanisms_[index_of(arm)]);
  std::copy(values.begin(), values.end(), joints_.begin() + static_cast<std::ptrdiff_t>(arm.first_value));
}

ObjectHandle ContactWorldMethod::add_link(const Arm& arm, std::uint32_t object) {
  if (object == arm.first_object)
    mechanisms_.push_back(world_.add_mechanism({arm.mechanism, arm.X_WB, arm.joints, {}, arm.weights}));
  const std::uint32_t link = arm.link_of_object[object - arm.first_object];
  return world_.link(mechanisms_.back(), arm.mechanism->links()[link].name);
}

void ContactWorldMethod::add_objects() {
  for (std::uint32_t i = 0; i < setting_->object_count(); ++i) {
    const SceneObject& object = setting_->scene().objects[i];
    // The setting outlives this, so the world's share of the tree owns nothing.
    const std::shared_ptr<const HexahedronTree> tree(std::shared_ptr<void>(), &object.tree);
    const Arm* arm = setting_->arm_of(i);
    objects_.emplace_back();
    set_object(
        i, arm ? add_link(*arm, i) : world_.add({tree, object.X_WO, !setting_->may_move(i), object.groups}));
    X_WO_.push_back(object.X_WO);
  }
}

void ContactWorldMethod::set_object(std::uint32_t object, ObjectHandle handle) {
  objects_[object] = handle;
  if (index_of_slot_.size() <= handle.slot) index_of_slot_.resize(handle.slot + 1);
  index_of_slot_[handle.slot] = object;
}

/// Of a mechanism that was added anew; what ended with the links of before is set again.
void ContactWorldMethod::take_links(const Arm& arm) {
  const MechanismHandle mechanism = mechanisms_[index_of(arm)];
  for (std::uint32_t i = 0; i < arm.object_count; ++i) {
    const std::uint32_t object = arm.first_object + i;
    set_object(object, world_.link(mechanism, arm.mechanism->links()[arm.link_of_object[i]].name));
    feed_.show(objects_[object]);
    if (!formation_.is_on[object]) world_.select(SelectionChange::of(objects_[object], false));
    X_WO_[object] = world_.actual_pose(objects_[object]);
  }
  const auto is_arms = [&](SolidIndex solid) {
    return setting_->instance().object_of(solid) - arm.first_object < arm.object_count;
  };
  std::vector<SolidPair> exempt;
  for (const SolidPair& pair : setting_->instance().exempt_pairs())
    if (is_arms(pair.a) || is_arms(pair.b)) exempt.push_back(pair);
  for (const Exemption& pair : exemptions(exempt)) world_.exempt(pair);
  set_rules(setting_->scene(), objects_, world_);
}

void ContactWorldMethod::set_base(const Arm& arm) {
  // A world of its own checks first whether the arm is refused, before anything changes.
  const MechanismPlacement placement{arm.mechanism, arm.X_WB, arm.joints, {}, arm.weights};
  ContactWorld(make_native(), make_native_broadphase()).add_mechanism(placement);
  const std::size_t index = index_of(arm);
  const auto is_arms = [&](const Action& latch) {
    return latch.carrier - arm.first_object < arm.object_count;
  };
  // The links let go of their loads, and take them up again where they are.
  for (const Action& latch : latches_)
    if (is_arms(latch)) world_.unlatch(objects_[latch.object]);
  world_.remove_mechanism(mechanisms_[index]);
  mechanisms_[index] = world_.add_mechanism(placement);
  take_links(arm);
  for (const Action& latch : latches_)
    if (is_arms(latch))
      world_.latch(objects_[latch.carrier], objects_[latch.object], exemptions(latch.allowed));
  world_.set_default_rule(
      {setting_->scene().policy, {}, setting_->script().translation_only, setting_->scene().passive});
  world_.prepare();
}

std::vector<Exemption> ContactWorldMethod::exemptions(std::span<const SolidPair> pairs) const {
  const SceneInstance& instance = setting_->instance();
  const auto name = [&](SolidIndex solid, std::uint32_t object) {
    return instance.trees()[object]->solids()[solid - instance.first_solid(object)].name;
  };
  std::vector<Exemption> out;
  for (const SolidPair& pair : pairs) {
    const std::uint32_t a = instance.object_of(pair.a), b = instance.object_of(pair.b);
    out.push_back({objects_[a], objects_[b], name(pair.a, a), name(pair.b, b)});
  }
  return out;
}

void ContactWorldMethod::log_event(const ContactEvent& event, FlightLog& log) const noexcept {
  // Sub-steps of a slide have no time of their own: they fill the frame up to its end.
  const double s = event.part == 0 ? event.s : 1.0;
  LoggedEvent logged{frame_, event.kind, {0, 0}, s, event.geometry.separation};
  if (event.kind != EventKind::refused && event.kind != EventKind::at_limit) {
    logged.solids = {solid_in_scene(event.a, event.solids.a), solid_in_scene(event.b, event.solids.b)};
    if (logged.solids.b < logged.solids.a) std::swap(logged.solids.a, logged.solids.b);
  }
  log.add(logged);
}

std::unique_ptr<Method> make_contact_world_method(const Setting& setting,
                                                  std::unique_ptr<Narrowphase> narrowphase,
                                                  std::unique_ptr<Broadphase> broadphase) {
  return std::make_unique<ContactWorldMethod>(setting, std::move(narrowphase), std::move(broadphase));
}

}  // namespace touchstone::training
