#pragma once

#include "touchstone/tests/station/pilot.hpp"

// Walks end over end, as a pilot flies them; which end an arm stands on changes between frames.

namespace touchstone::station {

inline constexpr double kHeld =
    0.04;  // of a mouth's plane over its fixture's frame: 10 mm above the plate [m]

/// As the tip is turned now.
inline bool move_to(Pilot& pilot, const Vector3& p_W) { return pilot.fly_to(p_W, 0.1, 30.0, pilot.tip().R); }

/// The free end on pdgf_b, and latched: both ends are held.
inline void take_hold(Pilot& pilot) {
  ASSERT_TRUE(pilot.fly_to({0.0, 0.0, 0.5}));
  ASSERT_TRUE(pilot.fly_to({0.0, 0.0, kHeld}, 0.1));
  const ControlAnswer answer = pilot.set({Kind::latch, true, Control::kAny});
  ASSERT_TRUE(answer.done) << answer.text;
}

inline void let_go(Pilot& pilot, std::uint32_t tip) {
  ASSERT_TRUE(pilot.set({Kind::tip, true, tip}).done);
  const ControlAnswer answer = pilot.set({Kind::release});
  ASSERT_TRUE(answer.done) << answer.text;
}

/// About the middle fixture. The way over -y is free, over +y the mast stands.
inline bool swing(Pilot& pilot, double degrees, double seconds = 60.0) {
  return pilot.drive("wrist_roll", pilot.joint("wrist_roll") + degrees * kDegree, seconds);
}

inline double largest_step(std::span<const Pose> before, std::span<const Pose> after) {
  double most = 0.0;
  for (std::size_t i = 0; i < before.size(); ++i)
    most = std::max({most, norm(after[i].p - before[i].p),
                     std::sqrt((after[i].R - before[i].R).col(0).squaredNorm()),
                     std::sqrt((after[i].R - before[i].R).col(1).squaredNorm())});
  return most;
}

inline std::vector<Pose> poses_of(const Pilot& pilot) {
  const std::span<const Pose> poses = pilot.flight().ours().poses();
  return {poses.begin(), poses.end()};
}

/// The hash of the same flight, flown anew by these inputs.
inline std::uint64_t replayed(const Pilot& pilot, std::vector<RecordedInput> inputs) {
  Session session(pilot.scenes, 0, pilot.flight().state().methods, pilot.flight().state().dynamics);
  Recording recording;
  recording.scene = pilot.scenes[0]->name;
  recording.rate = kRate;
  recording.inputs = std::move(inputs);
  recording.frames = pilot.session.frame();
  replay(recording, session);
  return session.hash();
}

inline std::vector<RecordedInput> without_releases(const Pilot& pilot) {
  std::vector<RecordedInput> inputs = pilot.inputs;
  std::erase_if(inputs, [](const RecordedInput& input) {
    const auto* control = std::get_if<Control>(&input.input);
    return control != nullptr && control->kind == Kind::release;
  });
  return inputs;
}

}  // namespace touchstone::station
