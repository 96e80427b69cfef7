#pragma once

#include <algorithm>
#include <vector>

#include "touchstone/examples/training_run/flight/method.hpp"

namespace touchstone::training {

/// Objects that go wherever they are commanded, with what they carry.
struct Fleet {
  std::vector<Pose> X_WO;
  Formation formation;
  std::vector<double> joints;  // of all arms
  std::vector<Pose> X_WL;      // scratch
  std::vector<FrameOutput*> outputs;
  std::vector<ShownPose> shown;
  std::uint64_t frames_sent = 0;

  explicit Fleet(const Setting& setting) : formation(setting.object_count()) {
    for (const SceneObject& object : setting.scene().objects) X_WO.push_back(object.X_WO);
    shown.reserve(X_WO.size());
    for (const Arm& arm : setting.arms()) {
      joints.insert(joints.end(), arm.joints.begin(), arm.joints.end());
      X_WL.resize(std::max(X_WL.size(), arm.mechanism->links().size()));
    }
  }

  void attach(const Setting& setting, FrameOutput& output) {
    for (std::uint32_t i = 0; i < X_WO.size(); ++i) output.add_object({{i, 0}, setting.object_name(i)});
    outputs.push_back(&output);
  }
  void send(double time) noexcept {
    shown.clear();
    for (std::uint32_t i = 0; i < X_WO.size(); ++i) shown.push_back({{i, 0}, X_WO[i]});
    for (FrameOutput* output : outputs) output->write({frames_sent, time, shown, {}});
    ++frames_sent;
  }

  void execute(const ArmCommand& command) noexcept {
    const Arm& arm = *command.arm;
    std::copy(command.values.begin(), command.values.end(),
              joints.begin() + static_cast<std::ptrdiff_t>(arm.first_value));
    const std::span<Pose> links = std::span(X_WL).first(arm.mechanism->links().size());
    arm.mechanism->link_poses(arm.X_WB, command.values, links);
    for (std::uint32_t i = 0; i < arm.object_count; ++i)
      X_WO[arm.first_object + i] = links[arm.link_of_object[i]];
    for (std::uint32_t i = 0; i < X_WO.size(); ++i) {
      const std::uint32_t root = formation.root_of(i);
      if (root != i && root - arm.first_object < arm.object_count)
        X_WO[i] = compose(X_WO[root], formation.X_RO[i]);
    }
  }
  void execute(const Command& command) noexcept {
    const CarriedPath path(command.path, formation.X_RO);
    for (std::uint32_t i = 0; i < X_WO.size(); ++i)
      if (formation.root_of(i) == command.object) X_WO[i] = path.at(i, 1.0).X_WO;
  }
};

/// A method that shows its fleet.
class FleetMethod : public Method {
 public:
  explicit FleetMethod(const Setting& setting) : setting_(&setting), fleet_(setting) {}

  void act(const Action& action) final { fleet_.formation.apply(action, fleet_.X_WO); }
  void attach(FrameOutput& output) final { fleet_.attach(*setting_, output); }
  void send(double time) noexcept final { fleet_.send(time); }
  std::span<const Pose> poses() const noexcept final { return fleet_.X_WO; }
  std::span<const double> joints() const noexcept final { return fleet_.joints; }
  const Formation& formation() const noexcept final { return fleet_.formation; }

 protected:
  const Setting* setting_;
  Fleet fleet_;
};

}  // namespace touchstone::training
