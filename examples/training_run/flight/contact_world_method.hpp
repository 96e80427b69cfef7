#pragma once

#include <memory>
#include <string>
#include <vector>

#include "touchstone/contact_core/output/output_feed.hpp"
#include "touchstone/contact_core/world/contact_world.hpp"
#include "touchstone/examples/training_run/flight/method.hpp"

namespace touchstone::training {

/// (iv) of method.hpp, for those who look into its world.
class ContactWorldMethod final : public Method {
 public:
  /// @throws InputError where it cannot work with the narrowphase.
  ContactWorldMethod(const Setting& setting, std::unique_ptr<Narrowphase> narrowphase,
                     std::unique_ptr<Broadphase> broadphase);

  std::string_view name() const noexcept override { return "contact world"; }
  std::string_view backend() const noexcept override { return backend_; }
  MotionCheck check() const noexcept override { return world_.capabilities().check; }
  void act(const Action& action) override;
  void set_base(const Arm& arm) override;
  void frame(std::span<const Command> commands, std::span<const ArmCommand> arm_commands,
             FlightLog& log) noexcept override;
  void attach(FrameOutput& output) override { feed_.add_output(output); }
  void send(double time) noexcept override;
  std::span<const Pose> poses() const noexcept override { return X_WO_; }
  std::span<const double> joints() const noexcept override { return joints_; }
  const Formation& formation() const noexcept override { return formation_; }

  /// For rules and budgets, between frames.
  ContactWorld& world() noexcept { return world_; }
  /// Of the last frame; its spans hold until the next one.
  const FrameReport& report() const noexcept { return report_; }
  /// Index in the scene of one of this world's objects.
  std::uint32_t object_of(ObjectHandle object) const noexcept { return index_of_slot_[object.slot]; }
  /// Index in the scene of a solid that an event names.
  SolidIndex solid_in_scene(ObjectHandle object, SolidIndex within) const noexcept {
    return setting_->instance().first_solid(object_of(object)) + within;
  }

 private:
  std::size_t index_of(const Arm& arm) const noexcept;
  void take_joints(const Arm& arm) noexcept;
  ObjectHandle add_link(const Arm& arm, std::uint32_t object);
  void add_objects();
  void take_links(const Arm& arm);
  void set_object(std::uint32_t object, ObjectHandle handle);
  std::vector<Exemption> exemptions(std::span<const SolidPair> pairs) const;
  void log_event(const ContactEvent& event, FlightLog& log) const noexcept;

  const Setting* setting_;
  std::string backend_;
  ContactWorld world_;
  OutputFeed feed_{world_};
  FrameReport report_;
  Formation formation_;
  std::vector<Action> latches_;  // in force
  std::vector<ObjectHandle> objects_;
  std::vector<std::uint32_t> index_of_slot_;
  std::vector<Pose> X_WO_;
  std::vector<MotionCommand> commands_;
  std::vector<MechanismHandle> mechanisms_;  // by arm
  std::vector<JointCommand> joint_commands_;
  std::vector<double> joints_;  // of all arms
  std::uint32_t frame_ = 0;
};

}  // namespace touchstone::training
