#include <algorithm>

#include "touchstone/contact_core/output/output_feed.hpp"
#include "touchstone/contact_core/world/scene_world.hpp"
#include "touchstone/examples/training_run/way.hpp"

namespace touchstone::training {
namespace {

class ContactWorldWay final : public Way {
 public:
  ContactWorldWay(const Setting& setting, std::unique_ptr<Narrowphase> narrowphase,
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

  std::string_view name() const noexcept override { return "contact world"; }
  std::string_view backend() const noexcept override { return backend_; }
  MotionCheck check() const noexcept override { return world_.capabilities().check; }

  void act(const Action& action) override {
    using Kind = OperatorAction::Kind;
    if (action.kind == Kind::latch)
      world_.latch(objects_[action.carrier], objects_[action.object], exemptions(action.allowed));
    if (action.kind == Kind::release) world_.unlatch(objects_[action.object]);
    if (action.kind == Kind::switch_on || action.kind == Kind::switch_off)
      world_.select(SelectionChange::of(objects_[action.object], action.kind == Kind::switch_on));
    formation_.apply(action, X_WO_);
    world_.prepare();
  }

  void frame(std::span<const Command> commands, std::span<const ArmCommand> arm_commands,
             FlightLog& log) noexcept override {
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

  void attach(FrameOutput& output) override { feed_.add_output(output); }
  void send(double time) noexcept override {
    report_.frame = frame_;  // poses at the end of that many frames
    feed_.send(report_, time);
  }

  std::span<const Pose> poses() const noexcept override { return X_WO_; }
  std::span<const double> joints() const noexcept override { return joints_; }
  const Formation& formation() const noexcept override { return formation_; }

 private:
  std::size_t index_of(const Arm& arm) const noexcept {
    return static_cast<std::size_t>(&arm - setting_->arms().data());
  }

  void take_joints(const Arm& arm) noexcept {
    const std::span<const double> values = world_.joint_values(mechanisms_[index_of(arm)]);
    std::copy(values.begin(), values.end(), joints_.begin() + static_cast<std::ptrdiff_t>(arm.first_value));
  }

  ObjectHandle add_link(const Arm& arm, std::uint32_t object) {
    if (object == arm.first_object)
      mechanisms_.push_back(world_.add_mechanism({arm.mechanism, arm.X_WB, arm.joints, {}, {}}));
    const std::uint32_t link = arm.link_of_object[object - arm.first_object];
    return world_.link(mechanisms_.back(), arm.mechanism->links()[link].name);
  }

  void add_objects() {
    for (std::uint32_t i = 0; i < setting_->object_count(); ++i) {
      const SceneObject& object = setting_->scene().objects[i];
      // The setting outlives this, so the world's share of the tree owns nothing.
      const std::shared_ptr<const HexahedronTree> tree(std::shared_ptr<void>(), &object.tree);
      const Arm* arm = setting_->arm_of(i);
      objects_.push_back(arm ? add_link(*arm, i)
                             : world_.add({tree, object.X_WO, !setting_->may_move(i), object.groups}));
      if (index_of_slot_.size() <= objects_[i].slot) index_of_slot_.resize(objects_[i].slot + 1);
      index_of_slot_[objects_[i].slot] = i;
      X_WO_.push_back(object.X_WO);
    }
  }

  std::vector<Exemption> exemptions(std::span<const SolidPair> pairs) const {
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

  SolidIndex solid_in_scene(ObjectHandle object, SolidIndex within) const noexcept {
    return setting_->instance().first_solid(index_of_slot_[object.slot]) + within;
  }

  void log_event(const ContactEvent& event, FlightLog& log) const noexcept {
    // Sub-steps of a slide have no time of their own: they fill the frame up to its end.
    const double s = event.part == 0 ? event.s : 1.0;
    LoggedEvent logged{frame_, event.kind, {0, 0}, s, event.geometry.separation};
    if (event.kind != EventKind::refused && event.kind != EventKind::at_limit) {
      logged.solids = {solid_in_scene(event.a, event.solids.a), solid_in_scene(event.b, event.solids.b)};
      if (logged.solids.b < logged.solids.a) std::swap(logged.solids.a, logged.solids.b);
    }
    log.add(logged);
  }

  const Setting* setting_;
  std::string backend_;
  ContactWorld world_;
  OutputFeed feed_{world_};
  FrameReport report_;
  Formation formation_;
  std::vector<ObjectHandle> objects_;
  std::vector<std::uint32_t> index_of_slot_;
  std::vector<Pose> X_WO_;
  std::vector<MotionCommand> commands_;
  std::vector<MechanismHandle> mechanisms_;  // by arm
  std::vector<JointCommand> joint_commands_;
  std::vector<double> joints_;  // of all arms
  std::uint32_t frame_ = 0;
};

}  // namespace

std::unique_ptr<Way> make_contact_world_way(const Setting& setting, std::unique_ptr<Narrowphase> narrowphase,
                                            std::unique_ptr<Broadphase> broadphase) {
  return std::make_unique<ContactWorldWay>(setting, std::move(narrowphase), std::move(broadphase));
}

}  // namespace touchstone::training
