#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "touchstone/contact_core/geometry/quaternion.hpp"
#include "touchstone/examples/station/exchange/recording.hpp"
#include "touchstone/examples/training_run/results/judge.hpp"
#include "touchstone/tests/station/station_scenes.hpp"

namespace touchstone::station {

inline constexpr std::uint32_t kUnchecked = 1U << static_cast<unsigned>(MethodKind::unchecked);
inline constexpr double kRate = 50.0, kDegree = std::numbers::pi / 180.0;
inline constexpr double kTop = 0.3058;        // of the ORU where it stands, 1 mm above its slot's floor [m]
inline constexpr double kOver = kTop + 0.06;  // of the tip over the ORU: jaws around the stem [m]

/// A hand that flies by what it sees, along the world's axes; `exact` judges every frame of ours.
struct Pilot {
  explicit Pilot(const std::string& scene, std::uint32_t methods = kOurs, bool dynamics = false)
      : scenes(bundled({scene}, kRate)), session(scenes, 0, methods, dynamics), judge(scenes[0]->setting) {
    set({Kind::frame_of_command, true, static_cast<std::uint32_t>(CommandFrame::camera)});
  }

  const Flight& flight() const { return session.flight(); }
  Pose tip() const { return compose(flight().ours().poses()[flight().tip().object], flight().tip().X_HT); }
  Pose pose_of(const std::string& object) const {
    return flight().ours().poses()[find_object(scenes[0]->setting.scene(), object)];
  }
  double joint(const std::string& name) const {
    const Mechanism& mechanism = *scenes[0]->arm()->mechanism;
    return flight().ours().joints()[mechanism.joints()[mechanism.find_joint(name)].value];
  }
  bool is_done(std::size_t task) const { return flight().figures().done_at[task] > 0.0; }
  bool is_within(std::size_t task) const { return flight().figures().is_within[task]; }
  ControlAnswer set(const Control& control) {
    inputs.push_back({session.frame(), control});
    return session.set(control);
  }

  void step(const HandInput& hand) {
    inputs.push_back({session.frame(), hand});
    session.step(hand);
    blocked += flight().methods().back().blocked;
    merged += merges(flight().ours());
    if (const Method* unchecked = flight().method(MethodKind::unchecked))
      unchecked_merged += merges(*unchecked->flown);
  }

  bool merges(const training::Method& method) const {
    return !judge.contacts(method.poses(), method.formation()).empty();
  }

  /// Straight to the place and the attitude. False: not there in time.
  bool fly_to(const Vector3& p_W, double speed = 0.3, double seconds = 30.0, const Matrix3& R_W = down()) {
    for (int frame = 0; frame < static_cast<int>(seconds * kRate); ++frame) {
      const Pose X = tip();
      const Vector3 way = p_W - X.p;
      const AxisAngle turn = axis_angle_of(quaternion_of(R_W * X.R.transpose()));
      if (norm(way) < there && turn.angle < there) return true;
      HandInput hand;
      hand.translation = within(speed, kRate * way) / 0.37;
      hand.rotation = within(1.0, kRate / 0.0698 * turn.angle * turn.axis);
      step(hand);
    }
    return false;
  }
  void grip(double rate, double seconds) {
    HandInput hand;
    hand.grip = rate;
    for (int frame = 0; frame < static_cast<int>(seconds * kRate); ++frame) step(hand);
  }
  /// In joint mode. False: not there in time.
  bool drive(const std::string& name, double value, double seconds) {
    const Mechanism& mechanism = *scenes[0]->arm()->mechanism;
    set({Kind::joint_mode, true, mechanism.joints()[mechanism.find_joint(name)].value});
    const double rate = std::min(0.0698, mechanism.joints()[mechanism.find_joint(name)].rate);
    int frame = 0;
    for (; frame < static_cast<int>(seconds * kRate) && std::abs(joint(name) - value) > 1e-6; ++frame) {
      HandInput hand;
      hand.joint = std::clamp((value - joint(name)) * kRate / rate, -1.0, 1.0);
      step(hand);
    }
    set({Kind::joint_mode, false});
    return std::abs(joint(name) - value) <= 1e-6;
  }

  /// The tool's x axis points down, its z axis along the world's x.
  static Matrix3 down() {
    Matrix3 R;
    R << 0, 0, 1, 0, 1, 0, -1, 0, 0;
    return R;
  }
  static Vector3 within(double most, const Vector3& v) {
    return std::min(1.0, most / (norm(v) + 1e-300)) * v;
  }

  StationScenes scenes;
  Session session;
  training::Judge judge;
  std::vector<RecordedInput> inputs;  ///< all so far, as a recording has them
  double there = 1e-5;                ///< of a place to fly to: within this of it [m, rad]
  int blocked = 0, merged = 0, unchecked_merged = 0;
};

}  // namespace touchstone::station
